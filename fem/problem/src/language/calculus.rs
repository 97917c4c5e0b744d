//! Derivatives in space, and means over cells and facets: `grad`, `div`, `eps`, `curl`, `hess`, `mean`, `means`.
//!
//! A trailing axis is the direction of differentiation: `grad(u)[i][j]` is ∂u_i/∂x_j, as in UFL and GetFEM. Every operator
//! of this page is linear, so its derivative is the operator of the direction.
//!
//! | written | of | gives | meaning |
//! | --- | --- | --- | --- |
//! | `grad(e)` | any rank | one rank more | ∂_j of each component |
//! | `div(a)` | vector | scalar | Σ ∂_i a_i |
//! | `div(A)` | tensor | vector | row by row, (div A)_i = Σ ∂_j A_ij |
//! | `eps(a)` | vector | tensor | (∇a + ∇aᵀ)/2 |
//! | `curl(a)` | vector in 3D | vector | ∇ × a |
//! | `curl(a)` | vector in 2D | scalar | ∂₀a₁ − ∂₁a₀ |
//! | `curl(s)` | scalar in 2D | vector | (∂₁s, −∂₀s) |
//! | `hess(e)` | any rank | two ranks more | ∂_j ∂_k of each component |
//! | `mean(e)` | any rank | as `e` | (∫ e)/\|T\| over the cell T, also on its facets |
//! | `means(Touch(u), 0, e)` | scalar | integrals | Σ D e over own facets of pairs, where `mean(a)` is (∫ a)/D over the facet's part that has opposite points |
//!
//! They apply to expressions, too: `grad(k * u)` follows the product rule, `grad(x)` is the identity. A function of position
//! given as a Rust closure has no gradient: interpolate it into a field. Third derivatives of a field and derivatives of the
//! normal are not available.
//!
//! `mean(e)` is of what is affine in fields and gradients, with coefficients that are constant on the cell: numbers, parameters, `h`,
//! `cell_volume`, other means. On two-sided regions it is of the cell on the side at hand, `this(mean(u))` or `mean(this(u))`. Second derivatives,
//! positions, histories and Rust closures have no mean, and there is no derivative of one by the shape or by `diff` of what is inside.
//!
//! ```
//! # use forms_fem::prelude::*;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! #[forms(dimension = 2)]
//! mod calculus {
//!     pub fn gradient(u: Vector) -> Tensor { grad(u) }
//!     pub fn divergence(u: Vector) -> Scalar { div(u) }
//!     pub fn strain(u: Vector) -> Tensor { eps(u) }
//!     pub fn rotation(u: Vector) -> Scalar { curl(u) }
//!     pub fn product_rule(s: Scalar, u: Vector) -> Tensor { grad(s * u) - s * grad(u) - outer(u, grad(s)) }
//!     pub fn laplacian(s: Scalar) -> Scalar { tr(hess(s)) }
//!     pub fn averaged(u: Vector) -> Tensor { mean(grad(u)) }
//! }
//! # let mesh = rectangle([0.0; 2], [2.0; 2], [1, 1], CellShape::Triangle, 1)?;
//! # let assembler = Assembler::new(&mesh);
//! let u = Field::interpolate(&Space::vector(&mesh, 2)?, |x| [3.0 * x[0] * x[1], x[0] * x[0]])?;
//! let s = Field::interpolate(&Space::scalar(&mesh, 2)?, |x: &[f64; 2]| x[0] * x[0] + 4.0 * x[1] * x[1])?;
//! let point = [1.0, 0.5];
//! # fn near(found: Vec<f64>, expected: &[f64]) {
//! #     assert!(found.len() == expected.len());
//! #     assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?} is not {expected:?}");
//! # }
//! near(assembler.at_point(&calculus::gradient(&u), point)?, &[1.5, 3.0, 2.0, 0.0]);
//! near(assembler.at_point(&calculus::divergence(&u), point)?, &[1.5]);
//! near(assembler.at_point(&calculus::strain(&u), point)?, &[1.5, 2.5, 2.5, 0.0]);
//! near(assembler.at_point(&calculus::rotation(&u), point)?, &[2.0 - 3.0]);
//! near(assembler.at_point(&calculus::product_rule(&s, &u), point)?, &[0.0; 4]);
//! near(assembler.at_point(&calculus::laplacian(&s), point)?, &[10.0]);
//! // Linear gradients: that at the centre of the lower triangle, (4/3, 2/3).
//! near(assembler.at_point(&calculus::averaged(&u), point)?, &[2.0, 4.0, 8.0 / 3.0, 0.0]);
//!
//! // On contact pairs: the own facets [0, 1] and [1, 2] have their middles at ½ and 3/2.
//! #[forms(dimension = 2)]
//! mod of_facets {
//!     #[pairs]
//!     pub struct Touch;
//!     pub fn squares() -> Functional { means(Touch, 0, sqr(mean(x[0]))) }
//! }
//! let lower = rectangle([0.0, 0.0], [2.0, 1.0], [2, 1], CellShape::Quadrilateral, 1)?;
//! let upper = rectangle([0.0, 1.0], [2.0, 2.0], [3, 1], CellShape::Quadrilateral, 1)?;
//! let bodies = Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)])?;
//! let touch = of_facets::Touch::on(Pairing::onto("lower top", "upper bottom"));
//! near(vec![Assembler::new(&bodies).functional(&of_facets::squares(&touch))?], &[0.25 + 2.25]);
//! # Ok(())
//! # }
//! ```
