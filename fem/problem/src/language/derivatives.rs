//! `derivative`, `diff` and energies.
//!
//! | written | gives | meaning |
//! | --- | --- | --- |
//! | `derivative(form, field, direction)` | as `form` | d/dε of the form with field + ε direction at ε = 0; the field's gradient (and Hessian) moves along |
//! | `derivative(form, shape, T)` | as `form` | d/dε of what is assembled when every point moves from x to x + ε T(x) |
//! | `derivative(form, h, rate)` | as `form` | by the diameter of the cells, which `shape` leaves alone; `cell_volume` and `facet_area` too |
//! | `diff(expression, name)` | the axes of the expression, then those of the name | partial derivative; a field's gradient is held fixed |
//! | `-> Energy` | a form | its first variation is the residual, its second the tangent |
//!
//! `derivative` takes forms, energies, functionals and densities; the field is an argument or a data member (a parameter, too).
//! It nests: `derivative(derivative(J, u, v), u, w)` is the second variation. `diff` takes any name: an argument, a data
//! member, a `let`. With a Lagrangian density L(u, ∇u), `diff(L, u)` is ∂L/∂u and, with `let G = grad(u);`, `diff(L, G)` is ∂L/∂∇u.
//! A name that does not occur is an error: the derivative would silently be zero.
//!
//! # By the shape of the domain
//! `derivative(form, shape, T)` moves all points along a vector field T at fixed reference coordinates. It is linear in T: with
//! `T: State<Vector>` a functional gives the derivative along T as a number, with `T: Test<Vector>` a form whose residual is the
//! gradient by nodes. What moves, and what does not:
//!
//! | | rate |
//! | --- | --- |
//! | `dx`, `ds` | div T, and the divergence along the surface div T − n·∇T n |
//! | `x`, `n` | T, −(I − n ⊗ n) ∇Tᵀ n |
//! | unknowns, test functions, states, `Carried` data, history | none: they keep their values at nodes and points; ∇w changes by −∇w ∇T |
//! | `Given` data | ∇f·T: they are fixed in space, so their gradient is read (`Given::function_with_gradient`, or a field) |
//! | parameters, `h`, `cell_volume`, `facet_area` | none |
//! | `curvature` | an error |
//!
//! If T lives in the space of the mesh's geometry ([`Space::of_geometry`](crate::space::Space::of_geometry)), it is the exact derivative of the assembled
//! number, provided that both are assembled with one quadrature rule (`with_quadrature(Quadrature::Degree(..))`: the rule estimated for the
//! derivative is finer than that for the form). [`Field::move_mesh`](crate::field::Field::move_mesh) moves a mesh along T, and
//! [`Field::rate_of_diameter`](crate::field::Field::rate_of_diameter) gives the rate of h along it.
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
//! let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?;
//! let (assembler, space, omega) = (Assembler::new(&mesh), Space::vector(&mesh, 1)?, rubber::Omega::on("all"));
//! let data = rubber::data().mu(2.0).lambda(3.0);
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
//! number(assembler.functional(&rubber::slope(&data, &omega, &u, &w)), stress[0])?;
//! number(assembler.functional(&rubber::curvature_along(&data, &omega, &u, &w)), 2.0 * (1.0 + 1.0 / (f * f)) + 3.0)?;
//! number(assembler.functional(&rubber::by_mu(&data, &omega, &u)), (f * f - 1.0) / 2.0 - f.ln())?;
//!
//! // By the shape of the domain: stretched along (x₀, 0), at fixed nodal values.
//! #[forms(dimension = 2)]
//! mod moving {
//!     pub struct Data { pub load: Given<Scalar> }
//!     #[cells]
//!     pub struct Omega;
//!     pub fn work(u: State<Scalar>) -> Functional { integral(Omega, dot(grad(u), grad(u)) / 2 - load * u) }
//!     pub fn along(u: State<Scalar>, T: State<Vector>) -> Functional { derivative(work(u), shape, T) }
//!     pub fn gradient(u: State<Scalar>, T: Test<Vector>) -> Form { derivative(work(u), shape, T) }
//! }
//! let load = Given::function_with_gradient(|x: &[f64; 2]| x[0], |_| [1.0, 0.0]);
//! let (loaded, body) = (moving::data().load(load), moving::Omega::on("all"));
//! let height = Field::interpolate(&Space::scalar(&mesh, 1)?, |x| 2.0 * x[0])?;
//! let movement = Field::interpolate(&Space::of_geometry(&mesh)?, |x| [x[0], 0.0])?;
//! // On [0, s] × [0, 1] with the same nodal values ∫ |∇u|²/2 = 2/s, and u = 2x/s gives ∫ x u = 2s²/3.
//! number(assembler.functional(&moving::along(&loaded, &body, &height, &movement)), -2.0 - 4.0 / 3.0)?;
//! let gradient = assembler.linear_form(&moving::gradient(&loaded, &body, &height), movement.space())?;
//! let along: f64 = gradient.iter().zip(movement.values()).map(|(g, t)| g * t).sum();
//! assert!((along + 2.0 + 4.0 / 3.0).abs() < 1e-12);
//!
//! // Residual of the energy in the direction w is that slope.
//! let residual = assembler.residual(&rubber::energy(&data, &omega), &[&u], &[&space])?;
//! let along: f64 = residual.iter().zip(w.values()).map(|(r, w)| r * w).sum();
//! assert!((along - stress[0]).abs() < 1e-12);
//! # Ok(())
//! # }
//! ```
