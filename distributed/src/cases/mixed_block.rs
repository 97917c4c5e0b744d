//! A nearly incompressible block that is held below and pressed from above: displacements of degree 2, pressures of degree 1.

use std::error::Error;

use forms_fem::prelude::*;

/// Equilibrium with the pressure as an unknown.
#[forms(dimension = 3)]
pub mod mixed {
    /// Material and load.
    pub struct Data {
        /// μ \[stress\].
        pub mu: Param,
        /// 1/λ \[1/stress\].
        pub compressibility: Param,
        /// Pressure from above \[stress\].
        pub load: Param,
    }
    /// The body.
    #[cells]
    pub struct Omega;
    /// The loaded side.
    #[facets]
    pub struct Top;

    /// ∫ 2μ ε(u):ε(v) − p div v − q div u − p q/λ + load n·v
    pub fn balance(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * mu * inner(eps(u), eps(v)) - p * div(v) - q * div(u) - compressibility * p * q)
            + integral(Top, load * dot(n, v) * (1 + x[0]))
    }
}

/// The form, with spaces and constraints of both unknowns.
pub struct MixedBlock {
    /// The balance of forces, and the law of the volume.
    pub form: Form<3>,
    /// Of displacements and pressures.
    pub spaces: [Arc<Space<3>>; 2],
    /// u = 0 at the bottom.
    pub held: Constraints<3>,
    /// None.
    pub free: Constraints<3>,
}

impl MixedBlock {
    /// On `divisions`³ cells, with μ = 1 and λ = 1000.
    ///
    /// # Errors
    /// Too many cells, or none.
    pub fn new(divisions: usize) -> Result<Self, Box<dyn Error>> {
        Self::on(&cuboid([0.0; 3], [1.0; 3], [divisions; 3], CellShape::Hexahedron, 1)?)
    }

    /// The same on a mesh of the cube, or a part of it.
    ///
    /// # Errors
    /// A mesh without a bottom or a top.
    pub fn on(mesh: &Mesh<3>) -> Result<Self, Box<dyn Error>> {
        let spaces = [Space::vector(mesh, 2)?, Space::scalar(mesh, 1)?];
        let mut held = Constraints::new(&spaces[0]);
        held.fix("bottom", |_| [0.0; 3])?;
        let free = Constraints::new(&spaces[1]);
        let data = mixed::data().mu(1.0).compressibility(1e-3).load(0.1);
        let form = mixed::Model::new(data).balance();
        Ok(MixedBlock { form, spaces, held, free })
    }

    /// The problem of both unknowns.
    pub fn problem(&self) -> Problem<'_, 3, 2> {
        let [displacements, pressures] = &self.spaces;
        Problem::new(&self.form, [displacements, pressures])
            .threads(Threads::new(1))
            .constrained(&self.held)
            .constrained(&self.free)
    }
}
