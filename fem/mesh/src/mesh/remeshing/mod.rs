//! Remeshing: new triangles inside the outline of a plane mesh whose cells have suffered, by their sizes.

mod error;
mod outline;
mod regions;
mod sampling;
mod sectors;
mod sizes;
#[cfg(test)]
mod tests;
mod triangulation;

use std::collections::HashMap;

pub use error::RemeshingError;
use outline::{Arc, Outline};
use sampling::{NewEdge, of_loop};
use sectors::Sectors;
pub use sizes::Sizes;
use triangulation::{Polygons, Triangles};

use super::{Mesh, Surface};
use crate::element::CellShape;

/// A mesher for a body that has a mesh already: triangles inside the same outline, of other sizes.
///
/// Nodes of the boundary are placed again on its curves, parabolas where the geometry has degree 2; corners (turns beyond 30°, 10° between straight facets)
/// and ends of regions stay. Facet regions are carried by the segments of the outline, regions of cells by components: one
/// that covers only a part of a component is an error, unless it is given as the cells of some facets.
///
/// ```
/// # use forms_mesh as forms_fem;
/// use forms_fem::element::CellShape;
/// use forms_fem::mesh::{Remeshing, Sizes, rectangle};
///
/// let bar = rectangle([0.0; 2], [4.0, 1.0], [4, 1], CellShape::Quadrilateral, 1)?;
/// let fine = Remeshing::new(Sizes::between(0.1, 0.25)).remesh(&bar)?;
/// assert!(fine.cell_count() > 100 && fine.quality().scaled_jacobian()[0] > 0.5);
/// assert!(fine.facet_region("left")?.len() >= 4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct Remeshing<'a> {
    sizes: Sizes<'a>,
    surfaces: &'a [Surface<'a, 2>],
    cells_of_facets: &'a [(&'a str, &'a str)],
    sectors: Option<Sectors>,
}

/// A boundary that is cut into new facets.
struct Cut {
    polygons: Polygons,
    /// The node in the middle of each edge.
    middles: Vec<[f64; 2]>,
    /// Whether an edge is on the boundary, not on the side of a sector.
    is_facet: Vec<bool>,
}

/// The new mesh before it has names: vertices, triangles, and the places in the middle of facets.
struct Cells {
    points: Vec<[f64; 2]>,
    cells: Vec<[usize; 3]>,
    middles: HashMap<[usize; 2], [f64; 2]>,
}

impl<'a> Remeshing<'a> {
    /// By these sizes.
    pub fn new(sizes: Sizes<'a>) -> Self {
        Remeshing { sizes, surfaces: &[], cells_of_facets: &[], sectors: None }
    }

    /// Curves for the nodes of some regions of facets. Without them the nodes are on the old facets, which is not
    /// where the curve is that these approximate.
    pub fn onto(mut self, surfaces: &'a [Surface<'a, 2>]) -> Self {
        self.surfaces = surfaces;
        self
    }

    /// Regions of cells, each with the region of facets whose cells it consists of.
    pub fn with_cells_of_facets(mut self, regions: &'a [(&'a str, &'a str)]) -> Self {
        self.cells_of_facets = regions;
        self
    }

    /// One sector of a ring, filled and repeated, so that the mesh has the outline's pattern: `count` sectors
    /// around the centre, where the first begins at an angle \[rad\]. The boundary has nodes on the sides of the sectors.
    pub fn in_sectors(mut self, centre: [f64; 2], count: usize, angle: f64) -> Self {
        self.sectors = Some(Sectors { centre, count, angle });
        self
    }

    /// The new mesh, of triangles, with geometry of the same degree.
    ///
    /// # Errors
    /// [`RemeshingError`]: sizes without meaning, an outline that crosses itself or has not the pattern, a region that cannot
    /// be carried.
    pub fn remesh(&self, mesh: &Mesh<2>) -> Result<Mesh<2>, RemeshingError> {
        if let Some((name, value, why)) = self.sizes.wrong() {
            return Err(RemeshingError::Setting { name, value, why });
        }
        mesh.without_rigid_surfaces("remeshing")?;
        let outline = Outline::of(mesh)?;
        let cells = match &self.sectors {
            None => self.whole(&outline)?,
            Some(sectors) if sectors.count < 3 => {
                let (name, why) = ("sectors", "there are at least three");
                return Err(RemeshingError::Setting { name, value: sectors.count as f64, why });
            }
            Some(sectors) => self.in_copies(&outline, sectors)?,
        };
        let mut new = cells.mesh(mesh.degree())?;
        regions::carry(mesh, &outline, &mut new, self.cells_of_facets)?;
        for (region, surface) in self.surfaces {
            new = regions::put_onto(&new, region, surface)?;
        }
        Ok(new)
    }

    fn whole(&self, outline: &Outline) -> Result<Cells, RemeshingError> {
        let along: Vec<&Arc> = outline.arcs().collect();
        let sizes = self.sizes.inside(outline, &along);
        let mut cut = Cut::new();
        for arcs in &outline.loops {
            cut.add_loop(&of_loop(arcs, &sizes), |_| true);
        }
        let Triangles { points, cells } = cut.polygons.triangulate(&sizes)?;
        let edges = cut.polygons.edges.iter().zip(&cut.middles);
        let middles = edges.map(|(edge, middle)| (sorted(*edge), *middle)).collect();
        Ok(Cells { points, cells, middles })
    }

    fn in_copies(&self, outline: &Outline, sectors: &Sectors) -> Result<Cells, RemeshingError> {
        let sector = sectors.first(outline)?;
        let along: Vec<&Arc> = sector.whole.iter().chain(&sector.across).flatten().collect();
        let sizes = self.sizes.inside(outline, &along);
        let (edges, [outer, side, inner, _]) = sectors.edges_around(&sector, &sizes);
        let is_side = |k: usize| (k >= outer && k < outer + side) || k >= outer + side + inner;
        let mut cut = Cut::new();
        cut.add_loop(&edges, |k| !is_side(k));
        for arcs in &sector.whole {
            cut.add_loop(&of_loop(arcs, &sizes), |_| true);
        }
        let one = cut.polygons.triangulate(&sizes)?;
        // The side where a sector ends has the points with which the next begins: backwards, for the loop goes on.
        let around = outer + 2 * side + inner;
        let own = |vertex: usize| {
            (outer..=outer + side).contains(&vertex).then(|| (around - (vertex - outer)) % around)
        };
        let kept: Vec<usize> = (0..one.points.len()).filter(|vertex| own(*vertex).is_none()).collect();
        let mut place = vec![0; one.points.len()];
        kept.iter().enumerate().for_each(|(k, vertex)| place[*vertex] = k);
        let number = |sector: usize, vertex: usize| match own(vertex) {
            None => (sector % sectors.count) * kept.len() + place[vertex],
            Some(image) => ((sector + 1) % sectors.count) * kept.len() + place[image],
        };
        let (mut points, mut cells, mut middles) = (vec![], vec![], HashMap::new());
        for k in 0..sectors.count {
            points.extend(kept.iter().map(|vertex| sectors.turned(&one.points[*vertex], k)));
            cells.extend(one.cells.iter().map(|cell| cell.map(|vertex| number(k, vertex))));
            for ((edge, middle), is_facet) in cut.polygons.edges.iter().zip(&cut.middles).zip(&cut.is_facet) {
                if *is_facet {
                    middles.insert(sorted(edge.map(|vertex| number(k, vertex))), sectors.turned(middle, k));
                }
            }
        }
        Ok(Cells { points, cells, middles })
    }
}

impl Cut {
    fn new() -> Self {
        Cut { polygons: Polygons { points: vec![], edges: vec![] }, middles: vec![], is_facet: vec![] }
    }

    fn add_loop(&mut self, edges: &[NewEdge], is_facet: impl Fn(usize) -> bool) {
        let first = self.polygons.points.len();
        for (k, [start, middle]) in edges.iter().enumerate() {
            self.polygons.points.push(*start);
            self.polygons.edges.push([first + k, first + (k + 1) % edges.len()]);
            self.middles.push(*middle);
            self.is_facet.push(is_facet(k));
        }
    }
}

impl Cells {
    /// The mesh, with a node in the middle of each edge for geometry of degree 2.
    fn mesh(self, degree: usize) -> Result<Mesh<2>, RemeshingError> {
        let Cells { mut points, cells, middles } = self;
        let mut between: HashMap<[usize; 2], usize> = HashMap::new();
        let mut numbers = Vec::with_capacity(cells.len() * 6);
        for cell in &cells {
            numbers.extend(cell.map(|vertex| vertex as u32));
            for [a, b] in
                CellShape::Triangle.edges().iter().filter(|_| degree == 2).map(|edge| edge.map(|k| cell[k]))
            {
                let middle = *between.entry(sorted([a, b])).or_insert_with(|| {
                    let straight = std::array::from_fn(|k| 0.5 * (points[a][k] + points[b][k]));
                    points.push(middles.get(&sorted([a, b])).copied().unwrap_or(straight));
                    points.len() - 1
                });
                numbers.push(middle as u32);
            }
        }
        Ok(Mesh::from_parts(CellShape::Triangle, degree, points, numbers)?)
    }
}

fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    if a < b { [a, b] } else { [b, a] }
}
