//! Laws that are more than a formula: functions written in Rust, tables, history at quadrature points.
//!
//! | declared | used as | derivative |
//! | --- | --- | --- |
//! | `extern "Rust" { fn flux(g: Vector) -> Vector; }` | `flux(grad(u))`: the function `super::flux`, generic over [`Real`](crate::contract::Real) | by dual numbers, of any order |
//! | `law: Table` | `law(s)`: data points, see [`Table`](crate::contract::Table) | of the interpolation |
//! | `p: History<Tensor>` | `p`: what was stored at the quadrature points of a region | none: it is data |
//!
//! ```
//! # use forms_fem::prelude::*;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> { laws_of_the_page::run() }
//! # mod laws_of_the_page {
//! # use forms_fem::prelude::*;
//! /// The positive root of r + r³ = s by Newton's method: no formula for it is needed.
//! pub fn response<R: Real>(s: R) -> R {
//!     let mut root = s;
//!     for _ in 0..30 {
//!         root = root - (root + root.powi(3) - s) / (root * root * 3.0 + 1.0);
//!     }
//!     root
//! }
//!
//! #[forms(dimension = 2)]
//! mod laws {
//!     extern "Rust" {
//!         fn response(s: Scalar) -> Scalar;
//!     }
//!     pub struct Data {
//!         pub law: Table,
//!         pub largest: History<Scalar>,
//!     }
//!     pub fn value(s: Scalar) -> Scalar { response(s) }
//!     pub fn slope(s: Scalar) -> Scalar { diff(response(s), s) }
//!     pub fn tabulated(s: Scalar) -> Scalar { law(s) + diff(law(s), s) }
//!     /// What a step writes: the largest value so far.
//!     pub fn grown(u: Scalar) -> Scalar { max(largest, u) }
//! }
//! # pub fn run() -> Result<(), Box<dyn std::error::Error>> {
//! let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?;
//! let assembler = Assembler::new(&mesh);
//! let law = Table::linear(&[[0.0, 0.0], [1.0, 2.0], [2.0, 3.0]])?;
//! let data = laws::data().law(law).largest(assembler.history(Entity::Cells, "all", 2, 0.0)?);
//! let at = |form: &dyn Fn(f64) -> Result<Vec<f64>, AssemblyError>, s: f64| form(s).map(|value| value[0]);
//! // r = 2 solves r + r³ = 10; its slope is 1/(1 + 3 r²).
//! assert!((at(&|s| assembler.at_point(&laws::value(&data, s), [0.5; 2]), 10.0)? - 2.0).abs() < 1e-14);
//! assert!((at(&|s| assembler.at_point(&laws::slope(&data, s), [0.5; 2]), 10.0)? - 1.0 / 13.0).abs() < 1e-14);
//! assert_eq!(at(&|s| assembler.at_point(&laws::tabulated(&data, s), [0.5; 2]), 1.5)?, 2.5 + 1.0);
//!
//! for u in [0.3, 0.7, 0.1] {
//!     assembler.update_history(&laws::grown(&data, u), &data.largest)?;
//!     data.largest.commit();
//! }
//! let stored = assembler.history_values(&data.largest)?;
//! assert!(stored.iter().all(|value| value == &[0.7]));
//! # Ok(())
//! # }
//! # }
//! ```
