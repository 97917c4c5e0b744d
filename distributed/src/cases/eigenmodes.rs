//! Vibrations and buckling of a plate, on one process or on parts.

use std::error::Error;

use forms_fem::constraints::RigidMap;
use forms_fem::mesh::{MeshError, OctreeMesh};
use forms_fem::prelude::*;
use forms_fem::solve::{Eigenmode, Eigenproblem};

/// The forms.
#[forms(dimension = 2)]
pub mod forms {
    use forms_contact::operators::linear_elastic::stress;

    /// Constants.
    pub struct Data {
        /// λ \[stress\].
        pub lambda: Param,
        /// μ \[stress\].
        pub mu: Param,
    }
    /// The plate.
    #[cells]
    pub struct Omega;

    /// ∫ σ(u):ε(v)
    pub fn stiffness(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }
    /// ∫ u·v
    pub fn mass(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, dot(u, v))
    }
    /// ∫ ∇u σ(w):∇v, by the stress of a loaded state w.
    pub fn geometric(u: Unknown<Vector>, v: Test<Vector>, w: State<Vector>) -> Form {
        integral(Omega, inner(dot(grad(u), stress(w)), grad(v)))
    }
}

/// The upper corner of the plate, and its cells.
pub const SIZE: ([f64; 2], [usize; 2]) = ([4.0, 1.0], [12, 3]);

/// The plate with cells that are divided at its left side, so that nodes hang.
///
/// # Errors
/// None.
pub fn trees() -> Result<Mesh<2>, MeshError> {
    let plate = OctreeMesh::new(rectangle([0.0; 2], SIZE.0, SIZE.1, CellShape::Quadrilateral, 1)?)?;
    let near = |cell: &u32| plate.mesh().cell_centre(*cell as usize)[0] < 0.7;
    let near: Vec<u32> = (0..plate.mesh().cell_count() as u32).filter(near).collect();
    Ok(plate.refined(&near)?.0.mesh().clone())
}

/// An eigenproblem of the plate, and what is asked of it.
pub struct Eigenmodes {
    stiffness: Form<2>,
    /// The mass, or the geometric stiffness.
    other: Form<2>,
    buckles: bool,
    /// The space of the modes.
    pub space: Arc<Space<2>>,
    /// Conditions of the modes.
    pub held: Constraints<2>,
}

impl Eigenmodes {
    /// A shift that is no eigenvalue, and the number of eigenvalues above it.
    pub const ASKED: (f64, usize) = (-1.0, 5);

    /// A plate that `vibrates`, clamped at the left; one that `floats`; a `closed` one, whose right side goes on at the left; and one that
    /// `buckles` as it is pressed from the right.
    ///
    /// # Errors
    /// A mesh without these sides.
    pub fn new(name: &str, mesh: &Mesh<2>) -> Result<Self, Box<dyn Error>> {
        let model = forms::Model::new(forms::data().lambda(1.5).mu(1.0));
        let space = Space::vector(mesh, 2)?;
        let mut held = Constraints::new(&space);
        held.join_hanging_nodes()?;
        match name {
            "floats" => {}
            "closed" => held.periodic("right", "left", &RigidMap::translation([-SIZE.0[0], 0.0]))?,
            _ => held.fix("left", |_| [0.0; 2])?,
        }
        let buckles = name == "buckles";
        let pressed = Field::interpolate(&space, |x| [-0.01 * x[0], 0.0])?;
        let other = if buckles { model.geometric(&pressed) } else { model.mass() };
        Ok(Eigenmodes { stiffness: model.stiffness(), other, buckles, space, held })
    }

    /// The eigenproblem.
    pub fn problem(&self) -> Eigenproblem<'_, 2> {
        let (stiffness, other, space) = (&self.stiffness, &self.other, &self.space);
        let problem = match self.buckles {
            true => Eigenproblem::buckling(stiffness, other, space),
            false => Eigenproblem::vibration(stiffness, other, space),
        };
        problem.constrained(&self.held)
    }
}

/// The eigenvalues.
pub fn values(modes: &[Eigenmode<2>]) -> Vec<f64> {
    modes.iter().map(|mode| mode.value).collect()
}

/// The last mode's amounts, which have no sign. Its eigenvalue is simple.
///
/// # Errors
/// Values that fit no space.
pub fn amounts(modes: &[Eigenmode<2>]) -> Result<Field<2>, Box<dyn Error>> {
    let field = modes.last().ok_or("no mode")?.field();
    let amounts = field.values().iter().map(|value| value.abs()).collect();
    Ok(Field::from_values(field.space(), amounts)?)
}
