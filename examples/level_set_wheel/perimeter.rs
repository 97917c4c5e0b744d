//! A perimeter whose derivative by φ is continuous: the total variation of the part of the body around each node.
//!
//! The length of Γ itself has kinks where a node changes sides, since Γ is a polygon with corners on edges: a descent stays at them. Volumes
//! have none. With v_i = ∫_Ω t_i for the hats t_i and their integrals m_i over the background, r = v/m lies between 0 and 1, and is averaged once
//! more, (M r)/m. Its total variation is the mean length of its level lines.

use std::sync::Arc;

use forms_fem::cut::Cut;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::Failure;
use forms_fem::shape_optimisation::level_set::measure_forms;

/// The slope below which the total variation is rounded off, times the size of cells.
const ROUNDED: f64 = 1e-3;

#[forms(dimension = 2)]
pub mod variation {
    pub struct Data {
        /// δ of √(|∇r|² + δ²) − δ.
        pub rounded: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn of_density(r: State<Scalar>) -> Functional {
        integral(Omega, sqrt(dot(grad(r), grad(r)) + sqr(rounded)) - rounded)
    }
    pub fn slope(r: State<Scalar>, t: Test<Scalar>) -> Form {
        derivative(of_density(r), r, t)
    }
    pub fn moments(r: State<Scalar>, t: Test<Scalar>) -> Form {
        integral(Omega, r * t)
    }
}

/// The perimeter on one background.
pub struct SmoothPerimeter {
    background: Assembler<2>,
    space: Arc<Space<2>>,
    variation: variation::Model<2>,
    /// m.
    sizes: Vec<f64>,
    /// Nodes that stay inside.
    solid: Vec<bool>,
}

impl SmoothPerimeter {
    /// On the mesh of a space of degree 1 with cells of this size \[length\] and nodes that stay inside.
    ///
    /// # Errors
    /// Those of assembly.
    pub fn new(space: &Arc<Space<2>>, size: f64, solid: Vec<bool>) -> Result<Self, Failure> {
        let background = Assembler::new(space.mesh());
        let sizes = background.linear_form(&measure_forms::Model::default().volume(), space)?;
        let variation = variation::Model::new(variation::data().rounded(ROUNDED / size));
        Ok(SmoothPerimeter { background, space: space.clone(), variation, sizes, solid })
    }

    /// Means around nodes of what has nodal values; its transpose is `spread`.
    fn averaged(&self, values: Vec<f64>) -> Result<Vec<f64>, Failure> {
        let field = Field::from_values(&self.space, values)?;
        let moments = self.background.linear_form(&self.variation.moments(&field), &self.space)?;
        Ok(divided(moments, &self.sizes))
    }

    fn spread(&self, slopes: Vec<f64>) -> Result<Vec<f64>, Failure> {
        let field = Field::from_values(&self.space, divided(slopes, &self.sizes))?;
        Ok(self.background.linear_form(&self.variation.moments(&field), &self.space)?)
    }

    /// The perimeter \[length\] and its derivative by the nodal values of φ.
    ///
    /// # Errors
    /// Those of assembly.
    pub fn value(&self, body: &Arc<Cut<2>>) -> Result<(f64, Vec<f64>), Failure> {
        let cut = Assembler::new(body.mesh()).with_cut(body)?;
        let volume = measure_forms::Model::default().volume();
        let parts = divided(cut.linear_form(&volume, &self.space)?, &self.sizes);
        let mut density = self.averaged(parts)?;
        let own = density.iter_mut().zip(&self.solid);
        own.filter(|(_, solid)| **solid).for_each(|(value, _)| *value = 1.0);
        let density = Field::from_values(&self.space, density)?;
        let value = self.background.functional(&self.variation.of_density(&density))?;
        let mut slopes = self.background.linear_form(&self.variation.slope(&density), &self.space)?;
        slopes.iter_mut().zip(&self.solid).filter(|(_, solid)| **solid).for_each(|(slope, _)| *slope = 0.0);
        let slopes = divided(self.spread(slopes)?, &self.sizes);
        let by_parts = Field::from_values(&self.space, slopes)?;
        Ok((value, cut.derivative_by_level_set(&volume, &[], &[&by_parts])?))
    }
}

fn divided(mut values: Vec<f64>, by: &[f64]) -> Vec<f64> {
    values.iter_mut().zip(by).for_each(|(value, by)| *value /= by);
    values
}
