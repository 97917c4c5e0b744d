//! A generic finite element backend for compiled weak forms.
//!
//! A weak form is written as a paper writes it, in a module under [`macro@forms`]; the compiler derives its
//! tangent and emits kernels, and this crate runs them:
//!
//! ```
//! use forms_fem::prelude::*;
//!
//! #[forms]
//! pub mod poisson {
//!     pub struct Data {
//!         /// Conductivity.
//!         k: Param,
//!         /// Source.
//!         f: Given<Scalar>,
//!     }
//!     #[cells]
//!     pub struct Omega;
//!
//!     pub fn diffusion(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
//!         integral(Omega, k * dot(grad(u), grad(v)) - f * v)
//!     }
//!
//!     /// Heat flux, a derived field.
//!     pub fn flux(u: Scalar) -> Vector {
//!         -k * grad(u)
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [16, 16], CellShape::Triangle, 1)?;
//! let space = Space::scalar(&mesh, 2)?;
//! let model = poisson::Model::new(poisson::data().k(2.0).f(|x: &[f64; 2]| 4.0 * x[0]));
//! let mut boundary = Constraints::new(&space);
//! // u = (x − x³)/3 solves −∇·(2∇u) = 4x.
//! let exact = |x: &[f64; 2]| (x[0] - x[0].powi(3)) / 3.0;
//! boundary.fix("boundary", exact)?;
//!
//! let assembler = Assembler::new(&mesh);
//! let u = Problem::new(&model.diffusion(), &space).assembler(&assembler)
//!     .constrained(&boundary).solve()?.into_field();
//! assert!((u.evaluate(&[0.5, 0.5])?[0] - exact(&[0.5, 0.5])).abs() < 1e-5);
//! let flux = assembler.at_points(&model.flux(&u), &[[0.3, 0.6]])?;
//! assert!((flux.values[0][0] + 2.0 * (1.0 - 3.0 * 0.09) / 3.0).abs() < 1e-2);
//! # Ok(())
//! # }
//! ```
//!
//! The way of a computation: [`mesh`] → [`element`] → [`quadrature`] → [`space`] → [`assemble`] →
//! [`solve`] → [`output`], with steps in [`time`] around [`solve`]. The language is described in [`language`]. Nothing here knows any physics; forms bring it through [`contract`].

extern crate self as forms_fem;

pub mod adaptivity;
mod instantiate;
pub mod inverse;
#[cfg(feature = "shape-optimisation")]
pub mod shape_optimisation;
pub mod time;
pub mod verification;

#[doc(inline)]
pub use forms_problem::{
    assemble, bounds, constraints, contract, cut, dimension, element, field, forms, history, lanes, language,
    linear_algebra, locate, mesh, movement, norms, output, pairs, prelude, quadrature, solve, space, threads,
};

/// One weak form without a module.
///
/// ```
/// use forms_fem::prelude::*;
///
/// let mesh = rectangle([0.0; 2], [1.0; 2], [8, 8], CellShape::Triangle, 1)?;
/// let space = Space::scalar(&mesh, 2)?;
/// let k = 2.0;
/// let poisson = form!(
///     |u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), k * dot(grad(u), grad(v)) - f * v),
///     k: Param,
///     f: Given<Scalar> = |x| x[0],
/// );
/// let mut constraints = Constraints::new(&space);
/// constraints.fix("boundary", |_| 0.0)?;
/// let assembler = Assembler::new(&mesh);
/// let mut problem = Problem::new(&poisson, &space).assembler(&assembler);
/// let u = problem.constrained(&constraints).solve()?.into_field();
///
/// let mean = form!(|u: State<Scalar>| -> Functional { integral(cells("all"), u) });
/// // By symmetry half of what f = 1 gives: 0.0351 / k / 2.
/// assert!((assembler.functional(&mean(&u))? - 0.5 * 0.035144 / k).abs() < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// After the closure come data (`k: Param = 2.0`; without a value the variable of that name), regions
/// (`Wall: Facets = "wall"`; or in place, `cells("all")`, `facets("wall")`), and the options of [`macro@forms`]. A closure with
/// known fields gives a Rust closure that takes them. `use path::operator;` before the closure imports.
pub use forms_core::form;
