//! Background of a wheel: a ring of triangles that is the same in all sectors.

use std::f64::consts::TAU;

use forms_contact::hollow_cylinder::{CONTACT, CONTACT_CELLS, INNER_RADIUS, OUTER_RADIUS};
use forms_fem::mesh::annulus;
use forms_fem::prelude::*;
use forms_fem::shape_optimisation::Failure;

use super::{HOLES, WALL};

/// Rings of `cells` pairs of triangles in the width of a sector, and as large ones along radii. There are nodes at the wall of the hub.
pub struct Grid {
    pub cells: usize,
    pub wall: usize,
    pub layers: usize,
}

impl Grid {
    pub fn new(cells: usize) -> Self {
        let size = Self::size(cells);
        let wall = (WALL / size).ceil() as usize;
        Grid { cells, wall, layers: wall + ((OUTER_RADIUS - INNER_RADIUS - WALL) / size).round() as usize }
    }

    /// The width of cells half-way between the circles \[cm\].
    pub fn size(cells: usize) -> f64 {
        0.5 * (INNER_RADIUS + OUTER_RADIUS) * TAU / (HOLES * cells) as f64
    }

    /// Whether a node stays inside: up to the first one beyond the walls.
    pub fn is_held(&self, x: &[f64; 2]) -> bool {
        let turn = TAU / (HOLES * self.cells) as f64;
        let layer = (OUTER_RADIUS - INNER_RADIUS - WALL) / (self.layers - self.wall) as f64;
        let ([angle, radius], rounding) = (in_sector(x), 1e-9);
        radius < INNER_RADIUS + WALL + rounding
            || OUTER_RADIUS - radius - layer < WALL - rounding
            || radius * (angle - turn) < 0.5 * WALL - rounding
    }

    pub fn mesh(&self) -> Result<Mesh<2>, Failure> {
        let Grid { cells, wall, layers } = *self;
        let even = annulus(INNER_RADIUS, OUTER_RADIUS, layers, HOLES * cells, CellShape::Triangle, 1)?;
        let share = |part: usize, whole: usize| part as f64 / whole as f64;
        let graded = |x: &[f64; 2]| {
            let radius = x[0].hypot(x[1]);
            let layer =
                ((radius - INNER_RADIUS) / (OUTER_RADIUS - INNER_RADIUS) * layers as f64).round() as usize;
            let here = match layer <= wall {
                true => INNER_RADIUS + WALL * share(layer, wall),
                false => {
                    let from = INNER_RADIUS + WALL;
                    from + (OUTER_RADIUS - from) * share(layer - wall, layers - wall)
                }
            };
            x.map(|x| x * here / radius)
        };
        let mut mesh = even.with_nodes(even.nodes().iter().map(graded).collect())?;
        mesh.name_facets(CONTACT, "outer", |centre| centre[1] < 0.0)?;
        mesh.name_cells_of_facets(CONTACT_CELLS, CONTACT)?;
        Ok(mesh)
    }
}

/// The place in the sector: the angle from its nearer side, and the radius.
pub fn in_sector(x: &[f64; 2]) -> [f64; 2] {
    let sector = TAU / HOLES as f64;
    let angle = x[1].atan2(x[0]).rem_euclid(sector);
    [angle.min(sector - angle), x[0].hypot(x[1])]
}
