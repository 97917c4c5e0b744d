//! Interior facets: the two sides of a field, jumps and averages.
//!
//! On a region declared `#[interior_facets]` a field has two values, one from each cell.
//!
//! | written | gives | meaning | UFL |
//! | --- | --- | --- | --- |
//! | `this(e)`, `other(e)` | as `e` | as the cell that owns the facet sees it; as the cell across it does | `e('+')`, `e('-')` |
//! | `jump(e)` | as `e` | this(e) − other(e) | `jump(e)` |
//! | `jump(s, n)`, `jump(a, n)` | vector, scalar | this(s n) + other(s n); of a vector a·n | `jump(e, n)` |
//! | `avg(e)` | as `e` | (this(e) + other(e))/2 | `avg(e)` |
//! | `n` | vector | from `this` to `other`; inside `other(..)` it is that cell's outward normal | `n('+')` |
//! | `h`, `cell_volume` | scalar | of one of the cells: they need a side | `h('+')` |
//!
//! A side encloses a whole expression and is linear: it commutes with every operator and derivative. Every field needs one.
//! `x`, `facet_area`, parameters and numbers are the same from both cells.
//!
//! ```
//! # use forms_fem::prelude::*;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! #[forms(dimension = 2)]
//! mod skeleton {
//!     #[interior_facets]
//!     pub struct Skeleton;
//!     pub fn jumps(u: State<Scalar>) -> Functional { integral(Skeleton, sqr(jump(u))) }
//!     pub fn kinks(u: State<Scalar>) -> Functional { integral(Skeleton, sqr(jump(grad(u), n)) - sqr(jump(dot(grad(u), n)))) }
//!     pub fn vectors(u: State<Scalar>) -> Functional {
//!         integral(Skeleton, inner(jump(u, n), jump(u, n)) - sqr(jump(u)) + norm(this(n) + other(n)))
//!     }
//!     pub fn product_rule(u: State<Scalar>, v: State<Scalar>) -> Functional {
//!         integral(Skeleton, jump(u * v) - jump(u) * avg(v) - avg(u) * jump(v))
//!     }
//!     pub fn length() -> Functional { integral(Skeleton, avg(h) / this(h) * this(cell_volume) / other(cell_volume)) }
//! }
//! // Two triangles and their common facet, of length √2.
//! let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Triangle, 1)?;
//! let (assembler, facet) = (Assembler::new(&mesh), skeleton::Skeleton::on("interior"));
//! let broken = Space::discontinuous_scalar(&mesh, 0)?;
//! let u = Field::interpolate(&broken, |x: &[f64; 2]| if x[0] > x[1] { 3.0 } else { 1.0 })?;
//! let v = Field::interpolate(&broken, |x: &[f64; 2]| if x[0] > x[1] { -2.0 } else { 5.0 })?;
//! let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found} {expected}");
//! near(assembler.functional(&skeleton::jumps(&facet, &u))?, 4.0 * 2.0_f64.sqrt());
//! near(assembler.functional(&skeleton::kinks(&facet, &u))?, 0.0);
//! near(assembler.functional(&skeleton::vectors(&facet, &u))?, 0.0);
//! near(assembler.functional(&skeleton::product_rule(&facet, &u, &v))?, 0.0);
//! near(assembler.functional(&skeleton::length(&facet))?, 2.0_f64.sqrt());
//! # Ok(())
//! # }
//! ```
