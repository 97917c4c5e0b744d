//! `derivative`, `diff` and energies.
//!
//! | written | gives | meaning |
//! | --- | --- | --- |
//! | `derivative(form, field, direction)` | as `form` | d/dε of the form with field + ε direction at ε = 0; the field's gradient (and Hessian) moves along |
//! | `diff(expression, name)` | the axes of the expression, then those of the name | partial derivative; a field's gradient is held fixed |
//! | `-> Energy` | a form | its first variation is the residual, its second the tangent |
//!
//! `derivative` takes forms, energies, functionals and densities; the field is an argument or a data member (a parameter, too).
//! It nests: `derivative(derivative(J, u, v), u, w)` is the second variation. `diff` takes any name: an argument, a data
//! member, a `let`. With a Lagrangian density L(u, ∇u), `diff(L, u)` is ∂L/∂u and, with `let G = grad(u);`, `diff(L, G)` is ∂L/∂∇u.
//! A name that does not occur is an error: the derivative would silently be zero.
//!
//! The tangent of every form by its unknowns is derived without being asked for. Conventions at kinks: [`super::kinks`].
//!
//! ```
//! # use forms_fem::prelude::*;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! #[forms(dimension = 2)]
//! mod rubber {
//!     pub struct Data { pub mu: Param, pub lambda: Param }
//!     #[cells]
//!     pub struct Omega;
//!
//!     fn density(F: Tensor) -> Scalar {
//!         let J = det(F);
//!         mu / 2 * (inner(F, F) - D - 2 * ln(J)) + lambda / 2 * pow(J - 1, 2)
//!     }
//!     /// Residual and tangent follow.
//!     pub fn energy(u: Unknown<Vector>) -> Energy { integral(Omega, density(I + grad(u))) }
//!     /// First Piola–Kirchhoff stress.
//!     pub fn stress(F: Tensor) -> Tensor { diff(density(F), F) }
//!     /// The energy as a number, its slope in a direction, and its sensitivity to μ.
//!     pub fn stored(u: State<Vector>) -> Functional { integral(Omega, density(I + grad(u))) }
//!     pub fn slope(u: State<Vector>, w: State<Vector>) -> Functional { derivative(stored(u), u, w) }
//!     pub fn curvature_along(u: State<Vector>, w: State<Vector>) -> Functional {
//!         derivative(derivative(stored(u), u, w), u, w)
//!     }
//!     pub fn by_mu(u: State<Vector>) -> Functional { derivative(stored(u), mu, 1) }
//! }
//! let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?);
//! let (assembler, space, omega) = (Assembler::new(&mesh), Space::vector(&mesh, 1)?, rubber::Omega::on("all"));
//! let data = rubber::Data { mu: 2.0, lambda: 3.0 };
//!
//! // Uniaxial stretch F = diag(f, 1): P₀₀ = μ (f − 1/f) + λ (f − 1).
//! let f = 1.5;
//! let stress = assembler.at_point(&rubber::stress(&data, [[f, 0.0], [0.0, 1.0]]), [0.5, 0.5])?;
//! assert!((stress[0] - (2.0 * (f - 1.0 / f) + 3.0 * (f - 1.0))).abs() < 1e-14);
//!
//! // The body stretches along w = (x₀, 0): slope P₀₀, curvature μ (1 + 1/f²) + λ, ∂/∂μ = (f² − 1)/2 − ln f.
//! let u = Field::interpolate(&space, |x| [(f - 1.0) * x[0], 0.0])?;
//! let w = Field::interpolate(&space, |x| [x[0], 0.0])?;
//! let number = |value: Result<f64, AssemblyError>, expected: f64| value.map(|value| assert!((value - expected).abs() < 1e-12));
//! number(assembler.functional(&rubber::slope(&data, &omega, &u, &w), &[]), stress[0])?;
//! number(assembler.functional(&rubber::curvature_along(&data, &omega, &u, &w), &[]), 2.0 * (1.0 + 1.0 / (f * f)) + 3.0)?;
//! number(assembler.functional(&rubber::by_mu(&data, &omega, &u), &[]), (f * f - 1.0) / 2.0 - f.ln())?;
//!
//! // Residual of the energy in the direction w is that slope.
//! let residual = assembler.residual(&rubber::energy(&data, &omega), &[&u], &[&space])?;
//! let along: f64 = residual.iter().zip(w.values()).map(|(r, w)| r * w).sum();
//! assert!((along - stress[0]).abs() < 1e-12);
//! # Ok(())
//! # }
//! ```
