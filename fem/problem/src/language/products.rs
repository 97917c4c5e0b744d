//! Products of scalars, vectors and tensors.
//!
//! s is a scalar, a and b are vectors, A and B matrices (tensors of rank 2), C is of rank 4, e anything. Every product is linear in
//! each of its two factors, so its derivative is the product rule.
//!
//! | written | gives | meaning |
//! | --- | --- | --- |
//! | `s * e`, `e * s`, `e / s` | as `e` | scaling |
//! | `A * a`, `A * B` | vector, matrix | matrix products, rectangular ones too; two vectors have no `*` |
//! | `dot(e, e)` | the axes that are left | last axis of the first with the first axis of the second: a·b, A a, Aᵀ a, A B |
//! | `ddot(e, e)` | the axes that are left | last two axes of the first with the first two of the second: A : B, C_ijkl A_kl |
//! | `inner(e, e)` | scalar | all axes of two values of one shape |
//! | `outer(e, e)` | axes of both | tensor product |
//! | `cross(a, b)` | vector; in 2D a scalar | a × b; in the plane a₀ b₁ − a₁ b₀, `cross(s, a)` = s e_z × a, `cross(a, s)` = a × s e_z |
//! | `perp(a)` | vector | (−a₁, a₀), a quarter turn to the left |
//!
//! ```
//! # use forms_fem::prelude::*;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! #[forms(dimension = 2)]
//! mod plane {
//!     pub fn angle(a: Vector, b: Vector) -> Scalar { cross(a, b) }
//!     pub fn turned(a: Vector) -> Vector { perp(a) - cross(1, a) }
//! }
//! #[forms(dimension = 3)]
//! mod products {
//!     pub struct Data { pub lambda: Param, pub mu: Param }
//!     pub fn work(a: Vector, b: Vector) -> Scalar { dot(a, b) }
//!     pub fn image(A: Tensor, b: Vector) -> Vector { dot(A, b) - A * b + dot(b, A) }
//!     pub fn energy(A: Tensor, B: Tensor) -> Scalar { inner(A, B) + ddot(A, B) }
//!     pub fn dyad(a: Vector, b: Vector) -> Tensor { outer(a, b) / 2 }
//!     pub fn moment(a: Vector, b: Vector) -> Vector { cross(a, b) }
//!     /// Hooke's law, by the elasticity tensor C_ijkl.
//!     pub fn stress(E: Tensor) -> Tensor {
//!         let C: Tensor4 = lambda * outer(I, I) + 2 * mu * sym_identity4;
//!         ddot(C, E)
//!     }
//! }
//! # let square = Assembler::new(&rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Triangle, 1)?);
//! # let cube = Assembler::new(&cuboid([0.0; 3], [1.0; 3], [1, 1, 1], CellShape::Tetrahedron, 1)?);
//! # macro_rules! at { ($form:expr) => { cube.at_point(&$form, [0.3, 0.2, 0.1])? } }
//! # macro_rules! in_plane { ($form:expr) => { square.at_point(&$form, [0.3, 0.2])? } }
//! let (a, b) = ([1.0, 2.0, 3.0], [4.0, 5.0, 6.0]);
//! let (A, B) = ([[1.0, 2.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [[1.0, 3.0, 0.0], [5.0, 0.0, 0.0], [0.0, 0.0, 2.0]]);
//! let data = products::data().lambda(2.0).mu(10.0);
//! assert_eq!(in_plane!(plane::angle([1.0, 2.0], [3.0, 4.0])), [-2.0]);
//! assert_eq!(in_plane!(plane::turned([1.0, 2.0])), [0.0, 0.0]);
//! assert_eq!(at!(products::work(&data, a, b)), [32.0]);
//! assert_eq!(at!(products::image(&data, A, b)), [4.0, 13.0, 6.0]); // Aᵀ b
//! assert_eq!(at!(products::energy(&data, A, B)), [2.0 * (1.0 + 6.0 + 2.0)]);
//! assert_eq!(at!(products::dyad(&data, a, b))[..3], [2.0, 2.5, 3.0]);
//! assert_eq!(at!(products::moment(&data, a, b)), [-3.0, 6.0, -3.0]);
//! assert_eq!(at!(products::stress(&data, B)), [26.0, 80.0, 0.0, 80.0, 6.0, 0.0, 0.0, 0.0, 46.0]);
//! # Ok(())
//! # }
//! ```
