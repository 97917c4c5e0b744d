//! An annulus with a periodic pattern of circular holes, of block-structured quadrilaterals.

use std::f64::consts::{FRAC_PI_4, PI, TAU};

use super::blocks::{BlockNode, Blocks};
use super::generators::{between, check, direction};
use super::{Mesh, MeshError};
use crate::element::CellShape;

/// An annulus around the origin with rows of circular holes. The ring is divided into `rows` × `holes_around` equal
/// sectors with a hole in the middle of each, and the cells of all sectors of a row are the same, turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerforatedAnnulus {
    /// Radius of the inner circle \[length\].
    pub inner_radius: f64,
    /// Radius of the outer circle \[length\].
    pub outer_radius: f64,
    /// Number of rows of holes, equally high.
    pub rows: usize,
    /// Number of holes in a row.
    pub holes_around: usize,
    /// Radius of a hole \[length\].
    pub hole_radius: f64,
    /// Cells along a side of a sector, a quarter of a hole's circumference.
    pub cells_per_side: usize,
    /// Cells between a hole and the sides of its sector.
    pub layers: usize,
    /// Quadrilaterals, or triangles (two per quadrilateral).
    pub shape: CellShape,
    /// Degree of the geometry, 1 or 2.
    pub degree: usize,
}

const INNER: u8 = 1;
const OUTER: u8 = 2;
const HOLES: u8 = 4;

impl PerforatedAnnulus {
    /// The mesh. All nodes of the circles, mid-side nodes too, lie on them. Facet regions: inner, outer, holes, and "hole 1"
    /// and so on each hole, row by row from the inside, counter-clockwise from the one whose sector begins at angle 0.
    ///
    /// # Errors
    /// [`MeshError::Parameter`] unless 0 < `inner_radius` < `outer_radius`, there are at least one row, three holes in it,
    /// one cell per side and one layer, and the holes fit into their sectors; a shape that is not plane, a degree that does
    /// not exist; [`MeshError::TooLarge`].
    pub fn mesh(&self) -> Result<Mesh<2>, MeshError> {
        self.check()?;
        let mut blocks = Blocks::new(CellShape::Quadrilateral, self.degree)?;
        let (side, depth) = (self.cells_per_side * self.degree, self.layers * self.degree);
        for row in 0..self.rows {
            for sector in 0..self.holes_around {
                for along in (0..4 * side).step_by(self.degree) {
                    for layer in (0..depth).step_by(self.degree) {
                        blocks.add_cell(|[outward, forward]| {
                            self.node(row, sector, (along + forward) % (4 * side), layer + outward)
                        });
                    }
                }
            }
        }
        let mut mesh = blocks.mesh(&[(INNER, "inner"), (OUTER, "outer"), (HOLES, "holes")])?;
        let all = mesh.facet_region("holes")?.to_vec();
        // A hole's facets follow each other, as its cells do.
        for (hole, facets) in all.chunks(4 * self.cells_per_side).enumerate() {
            mesh.insert_facets(&format!("hole {}", hole + 1), facets.to_vec())?;
        }
        if self.shape == CellShape::Triangle { mesh.simplices() } else { Ok(mesh) }
    }

    fn check(&self) -> Result<(), MeshError> {
        let PerforatedAnnulus { inner_radius, outer_radius, rows, holes_around, hole_radius, .. } = *self;
        let inner_is_good = inner_radius.is_finite() && inner_radius > 0.0;
        check(inner_is_good, "inner_radius", &inner_radius, "it must be finite and positive")?;
        let outer_is_good = outer_radius.is_finite() && outer_radius > inner_radius;
        check(outer_is_good, "outer_radius", &outer_radius, "it must be finite and above the inner radius")?;
        check(rows >= 1, "rows", &rows, "at least one row of holes")?;
        check(holes_around >= 3, "holes_around", &holes_around, "at least three holes around")?;
        check(self.cells_per_side >= 1, "cells_per_side", &self.cells_per_side, "at least one cell")?;
        check(self.layers >= 1, "layers", &self.layers, "at least one layer")?;
        if self.shape.dimension() != 2 {
            return Err(MeshError::Dimension { shape: self.shape, dimension: 2 });
        }
        let cells = [rows, holes_around, 4 * self.degree.clamp(1, 2), self.cells_per_side, self.layers]
            .into_iter()
            .try_fold(self.degree.clamp(1, 2), usize::checked_mul);
        if cells.is_none_or(|nodes| u32::try_from(nodes).is_err()) {
            return Err(MeshError::TooLarge { what: "nodes" });
        }
        let height = (outer_radius - inner_radius) / rows as f64;
        // The innermost row is the narrowest: the distance from a hole's centre to the radial sides of its sector.
        let width = 2.0 * (inner_radius + 0.5 * height) * (PI / holes_around as f64).sin();
        let fits = hole_radius > 0.0 && 2.0 * hole_radius < height.min(width);
        check(
            fits,
            "hole_radius",
            &hole_radius,
            "it must be positive, and the holes must fit into their sectors",
        )
    }

    // A place on the circumference of a sector, in steps from the corner of the largest radius and the smallest angle, and a
    // layer between the hole and it.
    fn node(&self, row: usize, sector: usize, along: usize, layer: usize) -> BlockNode<[usize; 3], 2> {
        let (side, depth) = (self.cells_per_side * self.degree, self.layers * self.degree);
        let (quarter, step) = (along / side, along % side);
        // Steps across the sector (radius) and around (angle).
        let [across, around] = match quarter {
            0 => [side, step],
            1 => [side - step, side],
            2 => [0, side - step],
            _ => [step, 0],
        };
        let (radial, angular) = (row * side + across, sector * side + around);
        let all_around = self.holes_around * side;
        if layer == depth {
            let radius =
                between(self.inner_radius, self.outer_radius, radial as f64 / (self.rows * side) as f64);
            let position = direction((angular % all_around) as f64 / all_around as f64).map(|x| radius * x);
            let inner = if radial == 0 { INNER } else { 0 };
            let outer = if radial == self.rows * side { OUTER } else { 0 };
            return BlockNode { key: [0, radial, angular % all_around], position, surfaces: inner | outer };
        }
        // In the frame of the sector, whose middle has the angle 0: turned, all sectors are the same.
        let place = |across: usize, around: usize| {
            let radial = row * side + across;
            let share = radial as f64 / (self.rows * side) as f64;
            let radius = between(self.inner_radius, self.outer_radius, share);
            let angle = TAU / self.holes_around as f64 * (around as f64 / side as f64 - 0.5);
            [radius * angle.cos(), radius * angle.sin()]
        };
        let middle = (row as f64 + 0.5) / self.rows as f64;
        let centre = between(self.inner_radius, self.outer_radius, middle);
        let angle = FRAC_PI_4 * (2.0 * (along as f64 / side as f64) - 1.0);
        let hole = [centre + self.hole_radius * angle.cos(), self.hole_radius * angle.sin()];
        let (wall, share) = (place(across, around), layer as f64 / depth as f64);
        let local: [f64; 2] = std::array::from_fn(|k| between(hole[k], wall[k], share));
        let [cosine, sine] = direction((sector as f64 + 0.5) / self.holes_around as f64);
        let position = [cosine * local[0] - sine * local[1], sine * local[0] + cosine * local[1]];
        let surfaces = if layer == 0 { HOLES } else { 0 };
        BlockNode { key: [1 + layer, row * 4 * side + along, sector], position, surfaces }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::measures::{close, surface, volume};
    use crate::mesh::{Surface, onto_sphere};

    const RING: PerforatedAnnulus = PerforatedAnnulus {
        inner_radius: 4.0,
        outer_radius: 6.0,
        rows: 2,
        holes_around: 24,
        hole_radius: 0.3,
        cells_per_side: 2,
        layers: 2,
        shape: CellShape::Quadrilateral,
        degree: 2,
    };

    fn exact() -> f64 {
        PI * (36.0 - 16.0 - 48.0 * 0.09)
    }

    #[test]
    fn circles_and_regions() -> Result<(), MeshError> {
        for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
            let mesh = PerforatedAnnulus { shape, ..RING }.mesh()?;
            let per_block = if shape == CellShape::Triangle { 2 } else { 1 };
            assert_eq!(mesh.cell_count(), 48 * 8 * 2 * per_block);
            assert_eq!(mesh.facet_region("inner")?.len(), 24 * 2);
            assert_eq!(mesh.facet_region("outer")?.len(), 24 * 2);
            assert_eq!(mesh.facet_region("holes")?.len(), 48 * 8);
            assert_eq!(mesh.boundary_facets().len(), 24 * 4 + 48 * 8);
            // Eight parabolas for a hole take 0.0307 % of r² each.
            close(volume(&mesh) - exact(), 48.0 * 8.0 * 0.09 * 3.07e-4, 1e-4);
            close(surface(&mesh, "holes")?.0 / (48.0 * TAU * 0.3), 1.0, 1e-3);
            close(surface(&mesh, "boundary")?.1, 2.0 * volume(&mesh), 1e-12);
            for hole in 0..48 {
                let facets = mesh.facet_region(&format!("hole {}", hole + 1))?;
                assert_eq!(facets.len(), 8);
                let radius = if hole < 24 { 4.5 } else { 5.5 };
                let angle = TAU * ((hole % 24) as f64 + 0.5) / 24.0;
                for facet in facets {
                    for node in mesh.cell_element(facet.cell as usize).facet_nodes(facet.local.into()) {
                        let x = mesh.nodes()[mesh.cell(facet.cell as usize)[node] as usize];
                        let distance = (x[0] - radius * angle.cos()).hypot(x[1] - radius * angle.sin());
                        assert!((distance - 0.3).abs() < 1e-14);
                    }
                }
            }
        }
        Ok(())
    }

    // Turned by a sector, the cells of one sector are those of the next.
    #[test]
    fn the_pattern_is_the_same_around() -> Result<(), MeshError> {
        let mesh = RING.mesh()?;
        let per_sector = 8 * 2;
        let (sine, cosine) = (TAU / 24.0).sin_cos();
        for cell in 0..48 * per_sector {
            let sector = cell / per_sector;
            let next = sector / 24 * 24 + (sector + 1) % 24;
            let other = next * per_sector + cell % per_sector;
            for (&a, &b) in mesh.cell(cell).iter().zip(mesh.cell(other)) {
                let (a, b) = (mesh.nodes()[a as usize], mesh.nodes()[b as usize]);
                assert!((cosine * a[0] - sine * a[1] - b[0]).abs() < 2e-14);
                assert!((sine * a[0] + cosine * a[1] - b[1]).abs() < 2e-14);
            }
        }
        Ok(())
    }

    #[test]
    fn areas_converge() -> Result<(), MeshError> {
        for (degree, order) in [(1, 2.0), (2, 4.0)] {
            let error = |n| -> Result<f64, MeshError> {
                let mesh = PerforatedAnnulus { cells_per_side: n, layers: n, degree, ..RING }.mesh()?;
                Ok((volume(&mesh) - exact()).abs())
            };
            let rate = (error(2)? / error(4)?).log2();
            assert!((rate - order).abs() < 0.1, "degree {degree}: order {rate}");
        }
        // Refined, with the nodes moved onto one of the holes alone.
        let mesh = RING.mesh()?;
        let centre = direction(0.5 / 24.0).map(|x| 4.5 * x);
        let onto = onto_sphere(centre, 0.3);
        let surfaces: [Surface<2>; 1] = [("hole 1", &onto)];
        let (plain, moved) = (mesh.refined()?, mesh.refined_onto(&surfaces)?);
        close(surface(&plain, "hole 1")?.0, surface(&mesh, "hole 1")?.0, 1e-6);
        let error =
            |mesh: &Mesh<2>| -> Result<f64, MeshError> { Ok((surface(mesh, "hole 1")?.0 - TAU * 0.3).abs()) };
        assert!(error(&moved)? < error(&plain)? / 10.0);
        Ok(())
    }

    #[test]
    fn parameters_are_named() {
        let message =
            |ring: PerforatedAnnulus| ring.mesh().err().map(|error| error.to_string()).unwrap_or_default();
        let starts = |ring: PerforatedAnnulus, start: &str| {
            assert!(message(ring).starts_with(start), "{}", message(ring));
        };
        starts(PerforatedAnnulus { inner_radius: 0.0, ..RING }, "inner_radius = 0.0 is not possible");
        starts(PerforatedAnnulus { outer_radius: 4.0, ..RING }, "outer_radius = 4.0 is not possible");
        starts(PerforatedAnnulus { rows: 0, ..RING }, "rows = 0 is not possible");
        starts(PerforatedAnnulus { holes_around: 2, ..RING }, "holes_around = 2 is not possible");
        starts(PerforatedAnnulus { cells_per_side: 0, ..RING }, "cells_per_side = 0 is not possible");
        starts(PerforatedAnnulus { layers: 0, ..RING }, "layers = 0 is not possible");
        starts(PerforatedAnnulus { hole_radius: 0.5, ..RING }, "hole_radius = 0.5 is not possible");
        starts(PerforatedAnnulus { hole_radius: f64::NAN, ..RING }, "hole_radius = NaN is not possible");
        starts(PerforatedAnnulus { rows: usize::MAX, ..RING }, "the mesh has more nodes");
        starts(PerforatedAnnulus { shape: CellShape::Hexahedron, ..RING }, "a mesh of hexahedron cells");
        starts(PerforatedAnnulus { degree: 3, ..RING }, "there is no geometry of degree 3");
        // Too near to its neighbours for the row of the smallest radius.
        starts(PerforatedAnnulus { holes_around: 60, ..RING }, "hole_radius = 0.3 is not possible");
    }
}
