//! Parts and functions of tensors, shapes, components and arrays.
//!
//! Shapes are `Scalar`, `Vector`, `Tensor` (extents D), `Tensor4` (rank 4), `Vector<3>` and `Matrix<2, 3>` (fixed extents, D among
//! them). In Rust they are `f64`, `[f64; 3]`, `[[f64; 3]; 2]` and so on.
//!
//! | written | gives | meaning | derivative in the direction dA |
//! | --- | --- | --- | --- |
//! | `transpose(A)` | matrix | Aᵀ, of any extents | `transpose(dA)` |
//! | `sym(A)`, `skew(A)`, `dev(A)` | tensor | (A + Aᵀ)/2, (A − Aᵀ)/2, A − tr A/n I | the same of dA |
//! | `tr(A)` | scalar | Σ A_ii | `tr(dA)` |
//! | `diag(A)`, `diag(a)` | vector, tensor | the diagonal; a diagonal matrix | the same of dA |
//! | `det(A)` | scalar | determinant, up to 3 × 3 | `inner(cof(A), dA)` |
//! | `inv(A)` | tensor | A⁻¹, up to 3 × 3 | −A⁻¹ dA A⁻¹ |
//! | `cof(A)` | tensor | det A · A⁻ᵀ, defined also where det A = 0 | polynomial in A and dA |
//! | `norm(e)` | scalar | √(e : e); see [`super::kinks`] at 0 | (e : de)/norm(e) |
//! | `normalize(e)` | as `e` | e/norm(e), 0 where e is | (de − (m : de) m)/norm(e) with m = normalize(e) |
//! | `tensor_exp(A)`, `tensor_ln(A)`, `tensor_sqrt(A)` | tensor | of a symmetric tensor; the last two of a positive definite one | exact, also at equal eigenvalues; by symmetric tensors: an entry and its mirror image move together |
//! | `identity(3)`, `I` | matrix | δ_ij | |
//! | `identity4`, `sym_identity4` | rank 4 | δ_ik δ_jl; its symmetric part | |
//! | `u[0]`, `F[0][1]`, `F[(0, 1)]` | component | counted from 0; `F[0]` is a row | the same of dF |
//! | `u[0..2]`, `A[(.., 1)]` | slice | a range keeps its axis | the same of dA |
//! | `[a, b]`, `[a; 3]` | one axis more | arrays of scalars, vectors, … | entry by entry |
//!
//! ```
//! # use forms_fem::prelude::*;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! #[forms(dimension = 2)]
//! mod tensors {
//!     pub fn parts(A: Tensor) -> Tensor { sym(A) + skew(A) + dev(A) - transpose(A) }
//!     pub fn invariants(A: Tensor) -> Vector { [tr(A), det(A)] }
//!     pub fn identities(A: Tensor) -> Tensor { inv(A) * A + cof(A) - det(A) * transpose(inv(A)) - identity(2) }
//!     pub fn diagonals(A: Tensor) -> Tensor { diag(diag(A)) }
//!     pub fn length(A: Tensor) -> Scalar { norm(A) }
//!     pub fn direction(a: Vector) -> Vector { normalize(a) }
//!     pub fn back(A: Tensor) -> Tensor { tensor_ln(tensor_exp(A)) - tensor_sqrt(A * A) }
//!     pub fn column(A: Tensor) -> Vector { A[(.., 1)] }
//!     pub fn built(a: Vector) -> Tensor { [[a[0], 0], a[0..2]] }
//!     pub fn flat(A: Matrix<2, 3>) -> Vector<3> { A[1] }
//!     pub fn same(A: Tensor) -> Tensor { ddot(identity4, A) - ddot(sym_identity4, A) }
//! }
//! # let square = Assembler::new(&rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Triangle, 1)?);
//! # macro_rules! at { ($form:expr) => { square.at_point(&$form, [0.3, 0.2])? } }
//! let A = [[3.0, 1.0], [2.0, 4.0]];
//! let symmetric = [[3.0, 1.0], [1.0, 4.0]];
//! assert_eq!(at!(tensors::parts(A)), [-0.5, 0.0, 3.0, 0.5]); // A + dev A − Aᵀ
//! assert_eq!(at!(tensors::invariants(A)), [7.0, 10.0]);
//! assert!(at!(tensors::identities(A)).iter().all(|entry| entry.abs() < 1e-15));
//! assert_eq!(at!(tensors::diagonals(A)), [3.0, 0.0, 0.0, 4.0]);
//! assert_eq!(at!(tensors::length([[1.0, 2.0], [2.0, 4.0]])), [5.0]);
//! assert_eq!(at!(tensors::direction([0.0, 4.0])), [0.0, 1.0]);
//! assert!(at!(tensors::back(symmetric)).iter().all(|entry| entry.abs() < 1e-13));
//! assert_eq!(at!(tensors::column(A)), [1.0, 4.0]);
//! assert_eq!(at!(tensors::built([5.0, 6.0])), [5.0, 0.0, 5.0, 6.0]);
//! assert_eq!(at!(tensors::flat([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])), [4.0, 5.0, 6.0]);
//! assert_eq!(at!(tensors::same(A)), [0.0, -0.5, 0.5, 0.0]); // the skew part
//! # Ok(())
//! # }
//! ```
