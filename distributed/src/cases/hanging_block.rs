//! A unit cube that hangs by its top under its weight: linear elasticity in space, of degree 2.

use forms_fem::prelude::*;

/// Equilibrium of the block.
#[forms]
pub mod equilibrium {
    use forms_contact::operators::linear_elastic::stress;

    /// Material and load.
    pub struct Data {
        /// λ \[stress\].
        pub lambda: Param,
        /// μ \[stress\].
        pub mu: Param,
        /// Force per volume.
        pub weight: Given<Vector>,
    }
    /// The body.
    #[cells]
    pub struct Omega;

    /// ∫ σ(u):ε(v) − weight·v
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)) - dot(weight, v))
    }
}

/// The form, its space and its constraints.
pub struct HangingBlock {
    /// The balance of forces.
    pub form: Form<3>,
    /// Of degree 2 on hexahedra.
    pub space: Arc<Space<3>>,
    /// u = 0 at the top.
    pub constraints: Constraints<3>,
}

impl HangingBlock {
    /// On `divisions`³ cells, with E = 1, ν = 0.3 and this weight.
    ///
    /// # Errors
    /// Too many cells, or none.
    pub fn new(divisions: usize, weight: Given<[f64; 3], 3>) -> Result<Self, Box<dyn std::error::Error>> {
        Self::on(&cuboid([0.0; 3], [1.0; 3], [divisions; 3], CellShape::Hexahedron, 1)?, weight)
    }

    /// The same on a mesh of the cube, or a part of it.
    ///
    /// # Errors
    /// A mesh without a top.
    pub fn on(mesh: &Mesh<3>, weight: Given<[f64; 3], 3>) -> Result<Self, Box<dyn std::error::Error>> {
        let space = Space::vector(mesh, 2)?;
        let mut constraints = Constraints::new(&space);
        constraints.fix("top", |_| [0.0; 3])?;
        let data = equilibrium::data().lambda(0.3 / (1.3 * 0.4)).mu(0.5 / 1.3).weight(weight);
        let form = equilibrium::Model::new(data).balance();
        Ok(HangingBlock { form, space, constraints })
    }
}
