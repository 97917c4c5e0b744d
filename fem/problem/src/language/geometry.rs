//! Geometry that a form may name. None of these names can be declared again.
//!
//! | name | short | shape | where | meaning |
//! | --- | --- | --- | --- | --- |
//! | `position` | `x` | vector | everywhere | position |
//! | `normal` | `n` | vector | facets | outward unit normal; on an interior facet that of this side |
//! | `diameter` | `h` | scalar | everywhere | h_T, largest distance between two vertices of the cell |
//! | `cell_volume` | | scalar | everywhere | \|T\| |
//! | `facet_area` | | scalar | facets | \|F\| |
//! | `curvature` | | scalar | facets | div n, the sum of the principal curvatures |
//! | `identity` | `I` | tensor | everywhere | identity |
//! | `dimension` | `D` | number | everywhere | 2 or 3 |
//! | | `PI` | number | everywhere | π |
//!
//! `curvature` is that of the facets themselves: 0 on straight ones. A polygon that approximates a circle, geometry of degree 1, has
//! none, however fine it is; take geometry of degree 2, whose curvature converges. Assembly says so once on standard error.
//!
//! `grad(x)` is `I`; `h`, `cell_volume` and `facet_area` are constant on a cell, so their gradient is zero.
//!
//! ```
//! # use forms_fem::prelude::*;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! #[forms]
//! mod geometry {
//!     #[cells]
//!     pub struct Omega;
//!     #[facets]
//!     pub struct Wall;
//!     /// By the divergence theorem both are D |Ω|.
//!     pub fn volume_by_cells() -> Functional { integral(Omega, div(x)) }
//!     pub fn volume_by_facets() -> Functional { integral(Wall, dot(position, normal)) }
//!     pub fn cells() -> Functional { integral(Omega, 1 / cell_volume) }
//!     pub fn facets() -> Functional { integral(Wall, 1 / facet_area) }
//!     pub fn total_curvature() -> Functional { integral(Wall, curvature) }
//!     pub fn longest() -> Functional { integral(Omega, diameter / cell_volume) }
//!     pub fn trace() -> Functional { integral(Omega, tr(identity) / dimension + PI - PI) }
//! }
//! let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-10 * expected.abs().max(1.0), "{found} {expected}");
//!
//! let cube = Assembler::new(&cuboid([0.0; 3], [1.0, 2.0, 3.0], [2, 2, 2], CellShape::Hexahedron, 1)?);
//! close(cube.functional(&geometry::volume_by_cells(&geometry::Omega::on("all")))?, 18.0);
//! close(cube.functional(&geometry::volume_by_facets(&geometry::Wall::on("boundary")))?, 18.0);
//! close(cube.functional(&geometry::cells(&geometry::Omega::on("all")))?, 8.0);
//! close(cube.functional(&geometry::facets(&geometry::Wall::on("boundary")))?, 24.0);
//! close(cube.functional(&geometry::longest(&geometry::Omega::on("all")))?, 8.0 * 3.5_f64.sqrt());
//! close(cube.functional(&geometry::trace(&geometry::Omega::on("all")))?, 6.0);
//!
//! // ∮ κ ds = 2π around the outer circle, −2π around the hole, whose outward normal points to its centre.
//! let ring = annulus(1.0, 2.0, 1, 256, CellShape::Quadrilateral, 2)?;
//! let rule = Quadrature::Degree(8);
//! let ring = Assembler::new(&ring).with_quadrature(rule);
//! let total = ring.functional(&geometry::total_curvature(&geometry::Wall::on("outer")))?;
//! assert!((total - std::f64::consts::TAU).abs() < 1e-3, "{total}");
//! # Ok(())
//! # }
//! ```
