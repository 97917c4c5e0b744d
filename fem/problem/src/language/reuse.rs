//! Functions of one module in another, and a form without a module.
//!
//! `use path::name;` inside a forms module imports a function (a strain, a stress, a whole form) of another one, in the same crate
//! or in another; it finds parameters and regions by their names in the importing module. `#[includes(path::Data)]` makes the members
//! of another module's data members of this one's, `data_from(value)` takes them from a value, and `#[default(0)]` marks what is
//! rarely given. `form!` compiles one expression in its place, by the same compiler.
//!
//! ```
//! # use forms_fem::prelude::*;
//! #[forms]
//! pub mod elasticity {
//!     pub struct Data { pub lambda: Param, pub mu: Param }
//!     #[cells]
//!     pub struct Body;
//!     pub fn stress(w: Vector) -> Tensor { 2 * mu * eps(w) + lambda * tr(eps(w)) * I }
//! }
//! #[forms]
//! pub mod loaded {
//!     use super::elasticity::{Body, stress as sigma};
//!     #[includes(super::elasticity::Data)]
//!     pub struct Data { pub thickness: Param, #[default(0)] pub force: Given<Vector> }
//!     pub fn work(u: State<Vector>) -> Functional {
//!         integral(Body, thickness * (inner(sigma(u), eps(u)) / 2 - dot(force, u)))
//!     }
//! }
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?;
//! let assembler = Assembler::new(&mesh);
//! let u = Field::interpolate(&Space::vector(&mesh, 1)?, |x| [0.1 * x[0], 0.0])?;
//! let elastic = elasticity::data().lambda(2.0).mu(3.0);
//! let data: loaded::Data<2> = loaded::data_from(elastic).thickness(1.0);
//! let work = loaded::work(&data, &elasticity::Body::on("all"), &u);
//! assert!((assembler.functional(&work)? - 0.5 * (2.0 + 2.0 * 3.0) * 0.01).abs() < 1e-14);
//!
//! let area = form!(|| -> Functional { integral(cells("all"), 1) }, dimension = 2);
//! assert!((assembler.functional(&area)? - 1.0).abs() < 1e-14);
//! # Ok(())
//! # }
//! ```
