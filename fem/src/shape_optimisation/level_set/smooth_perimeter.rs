//! A perimeter whose derivative by φ is continuous: the total variation of the part of the body around each node.

use std::sync::Arc;

use super::measures::measure_forms;
use crate::assemble::{Assembler, AssemblyError};
use crate::cut::Cut;
use crate::dimension::{Dim, Dimension};
use crate::field::Field;
use crate::forms;
use crate::shape_optimisation::Failure;
use crate::space::Space;

/// The slope of densities below which their variation is rounded off, in units of the steepest one.
const ROUNDED: f64 = 1e-3;

/// Forms of a density r between 0 and 1.
#[forms(crate = crate)]
pub mod density_variation {
    /// The place where the variation is rounded off.
    pub struct Data {
        /// δ of √(|∇r|² + δ²) − δ \[1/length\].
        pub rounded: Param,
    }
    /// The background.
    #[cells]
    pub struct Omega;

    /// ∫ √(|∇r|² + δ²) − δ.
    pub fn variation(r: State<Scalar>) -> Functional {
        integral(Omega, sqrt(dot(grad(r), grad(r)) + sqr(rounded)) - rounded)
    }
    /// Derivative of `variation` by r.
    pub fn slope(r: State<Scalar>, t: Test<Scalar>) -> Form {
        derivative(variation(r), r, t)
    }
    /// ∫ r t.
    pub fn moments(r: State<Scalar>, t: Test<Scalar>) -> Form {
        integral(Omega, r * t)
    }
}

/// |Γ| about as [`interface_measure`](super::interface_measure) has it, with a derivative by φ that is continuous.
///
/// The measure of Γ itself has kinks where a node changes sides and φ is not linear around it, since the corners of Γ on its edges meet there: a
/// descent stops at them. Volumes have none. With v_i = ∫_Ω t_i for the hats t_i and their integrals m_i over the background, r = v/m lies
/// between 0 and 1, and is averaged once more, (M r)/m with the mass matrix M. Its total variation is the mean measure of its level lines
/// (surfaces). It does not see waves of Γ that are as short as cells: end a descent with `interface_measure`.
pub struct SmoothPerimeter<const D: usize> {
    background: Assembler<D>,
    space: Arc<Space<D>>,
    forms: density_variation::Model<D>,
    /// m.
    sizes: Vec<f64>,
    /// Nodes that stay inside.
    solid: Vec<bool>,
}

impl<const D: usize> SmoothPerimeter<D>
where
    Dim: Dimension<D>,
{
    /// The perimeter of bodies on the mesh of a space of degree 1, with a flag per node: nodes that stay inside, such as those of walls, have
    /// the density 1, so that Γ next to a boundary counts as elsewhere.
    ///
    /// # Errors
    /// Those of assembly; another number of flags.
    pub fn new(space: &Arc<Space<D>>, solid: Vec<bool>) -> Result<Self, Failure> {
        if solid.len() != space.unknowns() {
            return Err(format!("{} flags for {} nodes", solid.len(), space.unknowns()).into());
        }
        let mesh = space.mesh();
        let least = mesh.body_cells().map(|cell| mesh.diameter(cell)).fold(f64::INFINITY, f64::min);
        let forms = density_variation::Model::new(density_variation::data().rounded(ROUNDED / least));
        let background = Assembler::new(mesh);
        let sizes = background.linear_form(&measure_forms::Model::default().volume(), space)?;
        Ok(SmoothPerimeter { background, space: space.clone(), forms, sizes, solid })
    }

    /// M times nodal values.
    fn moments(&self, values: Vec<f64>) -> Result<Vec<f64>, Failure> {
        let field = Field::from_values(&self.space, values)?;
        Ok(self.background.linear_form(&self.forms.moments(&field), &self.space)?)
    }

    fn over_sizes(&self, mut values: Vec<f64>) -> Vec<f64> {
        values.iter_mut().zip(&self.sizes).for_each(|(value, size)| *value /= size);
        values
    }

    fn set_solid(&self, values: &mut [f64], to: f64) {
        values.iter_mut().zip(&self.solid).filter(|(_, solid)| **solid).for_each(|(value, _)| *value = to);
    }

    /// The perimeter \[length^(D−1)\] and its derivative by the nodal values of φ.
    ///
    /// # Errors
    /// Those of assembly; a body on another mesh.
    pub fn value(&self, body: &Arc<Cut<D>>) -> Result<(f64, Vec<f64>), Failure> {
        let cut = Assembler::new(self.space.mesh()).with_cut(body)?;
        let volume = measure_forms::Model::default().volume();
        let parts = self.over_sizes(cut.linear_form(&volume, &self.space)?);
        let mut density = self.over_sizes(self.moments(parts)?);
        self.set_solid(&mut density, 1.0);
        let density = Field::from_values(&self.space, density)?;
        let value = self.background.functional(&self.forms.variation(&density))?;
        // The same way back, by transposed steps.
        let mut slopes = self.background.linear_form(&self.forms.slope(&density), &self.space)?;
        self.set_solid(&mut slopes, 0.0);
        let by_parts = self.over_sizes(self.moments(self.over_sizes(slopes))?);
        let by_parts = Field::from_values(&self.space, by_parts)?;
        let slopes: Result<Vec<f64>, AssemblyError> = cut.derivative_by_level_set(&volume, &[], &[&by_parts]);
        Ok((value, slopes?))
    }
}
