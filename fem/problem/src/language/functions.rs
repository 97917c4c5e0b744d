//! Scalar functions, powers, conditions and local names. Functions with kinks: [`super::kinks`].
//!
//! | written | meaning | derivative |
//! | --- | --- | --- |
//! | `sqrt(s)` | √s, s ≥ 0 | 1/(2√s), infinite at 0 |
//! | `exp(s)`, `ln(s)`, `log10(s)` | s > 0 for the logarithms | eˢ, 1/s, 1/(s ln 10) |
//! | `sin(s)`, `cos(s)`, `tan(s)` | radians | cos s, −sin s, 1 + tan² s |
//! | `asin(s)`, `acos(s)`, `atan(s)` | | 1/√(1 − s²), −1/√(1 − s²), 1/(1 + s²) |
//! | `atan2(s, t)` | angle of the point (t, s) | (t ds − s dt)/(s² + t²) |
//! | `sinh(s)`, `cosh(s)`, `tanh(s)` | | cosh s, sinh s, 1 − tanh² s |
//! | `asinh(s)`, `acosh(s)`, `atanh(s)` | | 1/√(s² + 1), 1/√(s² − 1), 1/(1 − s²) |
//! | `erf(s)`, `erfc(s)` | 2/√π ∫₀ˢ exp(−t²) dt; 1 − erf s | ± 2/√π exp(−s²) |
//! | `pow(s, t)` | sᵗ; a whole t that is written down allows any sign of s | t sᵗ⁻¹ ds + sᵗ ln s dt |
//! | `sqr(s)`, `hypot(s, t)` | s², √(s² + t²) | 2 s, (s ds + t dt)/hypot |
//!
//! A numeric literal is a real number: `1 / 2` is 0.5. `let name = …;` names a value; `if c { a } else { b }` chooses by comparisons
//! (`< <= > >= == !=`) joined with `&& || !`. Outside its domain a function is NaN, which is reported where it arises; an `if` keeps
//! it out.
//!
//! ```
//! # use forms_fem::prelude::*;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! #[forms(dimension = 2)]
//! mod functions {
//!     pub fn logarithms(s: Scalar) -> Scalar { ln(exp(s)) + log10(pow(10, s)) - 2 * sqrt(sqr(s)) }
//!     pub fn circle(s: Scalar) -> Scalar { sqr(sin(s)) + sqr(cos(s)) - tan(s) * cos(s) / sin(s) }
//!     pub fn angles(s: Scalar) -> Scalar { asin(sin(s)) + acos(cos(s)) + atan(tan(s)) + atan2(sin(s), cos(s)) - 4 * s }
//!     pub fn hyperbola(s: Scalar) -> Scalar { sqr(cosh(s)) - sqr(sinh(s)) - tanh(s) * cosh(s) / sinh(s) }
//!     pub fn areas(s: Scalar) -> Scalar { asinh(sinh(s)) + acosh(cosh(s)) + atanh(tanh(s)) - 3 * s }
//!     pub fn error(s: Scalar) -> Scalar { erf(s) + erfc(s) - 1 }
//!     pub fn distance(s: Scalar, t: Scalar) -> Scalar { hypot(s, t) }
//!     pub fn slope(s: Scalar) -> Scalar { diff(pow(s, 2.5), s) }
//!     pub fn clipped(s: Scalar) -> Scalar {
//!         let inside = s * (1 - s);
//!         if s > 0 && !(s >= 1) { inside } else { 0 }
//!     }
//! }
//! # let square = Assembler::new(&rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Triangle, 1)?);
//! # macro_rules! at { ($form:expr) => { square.at_point(&$form, [0.3, 0.2])?[0] } }
//! for s in [0.1, 0.4, 0.9] {
//!     for zero in [
//!         at!(functions::logarithms(s)),
//!         at!(functions::circle(s)),
//!         at!(functions::angles(s)),
//!         at!(functions::hyperbola(s)),
//!         at!(functions::areas(s)),
//!         at!(functions::error(s)),
//!     ] {
//!         assert!(zero.abs() < 1e-14, "{zero} at {s}");
//!     }
//! }
//! assert_eq!(at!(functions::distance(3.0, 4.0)), 5.0);
//! assert!((at!(functions::slope(4.0)) - 20.0).abs() < 1e-13);
//! assert_eq!([at!(functions::clipped(0.5)), at!(functions::clipped(2.0))], [0.25, 0.0]);
//! # Ok(())
//! # }
//! ```
