//! Functions with kinks and jumps, and the derivative that each takes where it has none.
//!
#![doc = include_str!("kinks.md")]
//!
//! The compiler has these rules in one place, `differentiate/rules.rs` of `forms-compiler`. The branch of an `if` that is not taken
//! never poisons value or derivative, whatever it holds there. How many points are on:
//! [`Assembler::active_set`](crate::assemble::Assembler::active_set).
//!
//! ```
//! # use forms_fem::prelude::*;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! #[forms(dimension = 2)]
//! mod kinks {
//!     pub fn step(s: Scalar) -> Scalar { heaviside(s) }
//!     pub fn signum(s: Scalar) -> Scalar { sign(s) }
//!     pub fn modulus(s: Scalar) -> Scalar { abs(s) }
//!     pub fn positive(s: Scalar) -> Scalar { pos_part(s) }
//!     pub fn negative(s: Scalar) -> Scalar { neg_part(s) }
//!     pub fn largest(s: Scalar, t: Scalar) -> Scalar { max(s, t) }
//!     pub fn smallest(s: Scalar, t: Scalar) -> Scalar { min(s, t) }
//!     pub fn slope_of_negative(s: Scalar) -> Scalar { diff(neg_part(s), s) }
//!     pub fn guarded(s: Scalar) -> Scalar { diff(if s > 0 { sqrt(s) } else { 0 * s }, s) }
//! }
//! # let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Triangle, 1)?;
//! # let assembler = Assembler::new(&mesh);
//! # macro_rules! at { ($form:expr) => { assembler.at_point(&$form, [0.3, 0.4])?[0] } }
//! assert_eq!([at!(kinks::step(-2.0)), at!(kinks::step(0.0)), at!(kinks::step(2.0))], [0.0, 0.0, 1.0]);
//! assert_eq!([at!(kinks::signum(-2.0)), at!(kinks::signum(0.0)), at!(kinks::signum(2.0))], [-1.0, 0.0, 1.0]);
//! assert_eq!([at!(kinks::modulus(-2.0)), at!(kinks::positive(-2.0)), at!(kinks::negative(-2.0))], [2.0, 0.0, 2.0]);
//! assert_eq!([at!(kinks::largest(1.0, 3.0)), at!(kinks::smallest(1.0, 3.0))], [3.0, 1.0]);
//! assert_eq!([at!(kinks::slope_of_negative(-2.0)), at!(kinks::slope_of_negative(0.0))], [-1.0, 0.0]);
//! assert_eq!([at!(kinks::guarded(4.0)), at!(kinks::guarded(-1.0))], [0.25, 0.0]);
//! # Ok(())
//! # }
//! ```
