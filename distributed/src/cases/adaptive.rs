//! A membrane under a load near one corner, on quadrilaterals that are divided where a residual estimator asks for it: nodes hang.

use std::error::Error;

use forms_fem::adaptivity::{Adaptation, AdaptationError, Adapted, AdaptiveSolution, ErrorEstimate};
use forms_fem::prelude::*;

/// The membrane and its estimator.
#[forms(dimension = 2)]
pub mod membrane {
    /// The load.
    pub struct Data {
        /// f \[unknown/length²\].
        pub load: Given<Scalar>,
    }
    /// The square.
    #[cells]
    pub struct Omega;
    /// Between its cells.
    #[interior_facets]
    pub struct Interior;

    /// ∫ ∇u·∇v − f v
    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - load * v)
    }
    /// η_T² = h²‖f + Δu‖² + h‖½⟦∂u/∂n⟧‖²
    pub fn residual(u: State<Scalar>, q: Test<Scalar>) -> Form {
        integral(Omega, sqr(h) * sqr(load + tr(hess(u))) * q)
            + integral(Interior, avg(h) * sqr(dot(jump(grad(u)), n)) / 2 * avg(q))
    }
}

/// Errors of a solution on one of the meshes.
pub type Failure = Box<dyn Error>;

/// The cycle to 500 unknowns of degree 2, with the solutions that `solve` finds of a form on a space under constraints.
///
/// # Errors
/// Those of `solve`, with the mesh.
pub fn adapted(
    mut solve: impl FnMut(&Form<2>, &Arc<Space<2>>, &Constraints<2>) -> Result<Field<2>, Failure>,
) -> Result<Adapted<2>, AdaptationError<Failure>> {
    let coarse = rectangle([0.0; 2], [1.0; 2], [4, 3], CellShape::Quadrilateral, 1)?;
    let load = |x: &[f64; 2]| 50.0 * (-60.0 * ((x[0] - 0.3).powi(2) + (x[1] - 0.2).powi(2))).exp();
    let model = membrane::Model::new(membrane::data().load(load));
    let balance = model.balance();
    Adaptation::to_unknowns(500).run(
        coarse,
        |mesh, _| {
            let space = Space::scalar(mesh, 2)?;
            let mut constraints = Constraints::new(&space);
            constraints.fix("boundary", |_| 0.0)?;
            constraints.join_hanging_nodes()?;
            let u = solve(&balance, &space, &constraints)?;
            let assembler = Assembler::new(mesh).with_threads(Threads::new(1));
            let estimate = ErrorEstimate::residual(&assembler, &model.residual(&u))?;
            Ok(AdaptiveSolution::new(u, estimate))
        },
        |_| {},
    )
}
