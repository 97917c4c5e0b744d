//! Rigid surfaces next to bodies: each has a straight cell of its own, which carries its motion.

use std::sync::Arc;

use super::{RigidSurface, flat_facet};
use crate::element::CellShape;
use crate::locate::Locator;
use crate::mesh::{BOUNDARY, EVERYWHERE, INTERIOR, Mesh, MeshError, TAKE_THE_WHOLE};

/// A surface on a cell: points have reference coordinates in it, which is exact where displacements are affine on the cell.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct CarriedSurface<const D: usize> {
    pub name: String,
    pub cell: u32,
    pub surface: Arc<RigidSurface<D>>,
    /// Reference coordinates of the points in the cell.
    pub references: Arc<[[f64; D]]>,
    /// The outward unit normals of the facets.
    pub normals: Arc<[[f64; D]]>,
}

/// A point and a length: the cell of one shape that has its first corner there and edges of this length along the axes holds the
/// surface.
fn around<const D: usize>(surface: &RigidSurface<D>, shape: CellShape) -> ([f64; D], f64) {
    let (mut lower, mut upper) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
    for facet in &surface.facets {
        for point in facet {
            for (k, x) in surface.points[*point as usize].into_iter().enumerate() {
                (lower[k], upper[k]) = (lower[k].min(x), upper[k].max(x));
            }
        }
    }
    let size = lower.iter().zip(&upper).map(|(lower, upper)| upper - lower).fold(0.0, f64::max);
    // A corner of the unit simplex is cut off at the middle of a box: it takes one of D times its size.
    (lower, if shape.is_simplex() { D as f64 * size } else { size })
}

impl<const D: usize> CarriedSurface<D> {
    /// The reference coordinates of a point in the cell, which is straight.
    pub fn reference_of(&self, mesh: &Mesh<D>, x: &[f64; D]) -> [f64; D] {
        // Edges run along the axes, and all have one length.
        let (origin, jacobian) = mesh.map(self.cell as usize, &[0.0; D]);
        std::array::from_fn(|k| (x[k] - origin[k]) / jacobian[k][k])
    }
}

impl<const D: usize> Mesh<D> {
    /// The mesh with rigid surfaces added to its bodies. A surface's name is found by pairings, as that of the facets opposite to a body's,
    /// and names the cell that carries it, for conditions and reactions: the nodes of that cell carry the surface's motion, and all of
    /// them have to be given one (`Constraints::move_rigidly`,
    /// `Constraints::rigid_body`). It is a cell without a material: it belongs to no
    /// other region, "all" and "boundary" included, and is not drawn. Numbers of cells and nodes stay as they are.
    ///
    /// # Errors
    /// [`MeshError::RegionExists`] for a name that is taken, by a region or by another surface; [`MeshError::Inverted`] where a surface is so
    /// small relative to its distance from the origin that its cell has no volume; [`MeshError::InsideBody`] for one that is deep in a body.
    #[inline(never)]
    pub fn with_rigid_surfaces(&self, surfaces: &[(&str, &RigidSurface<D>)]) -> Result<Self, MeshError> {
        self.without_pieces("a rigid surface", TAKE_THE_WHOLE)?;
        for (name, surface) in surfaces {
            if self.has_within(surface) {
                let position = surface.points[0].to_vec();
                return Err(MeshError::InsideBody { name: (*name).to_owned(), position });
            }
        }
        let mut nodes = self.nodes.clone();
        let mut blocks: Vec<(CellShape, Vec<u32>)> = Vec::new();
        for block in self.blocks() {
            let cells = block.cells.clone().flat_map(|cell| self.cell(cell)).copied().collect();
            blocks.push((block.shape, cells));
        }
        let shape = self.cell_shape(self.cell_count() - 1);
        let places = self.element_of(shape).node_points::<D>();
        let mut rigid = self.rigid.clone();
        for (index, (name, surface)) in surfaces.iter().enumerate() {
            let (origin, size) = around(surface, shape);
            let first = nodes.len() as u32;
            nodes.extend(
                places.iter().map(|s| -> [f64; D] { std::array::from_fn(|k| origin[k] + size * s[k]) }),
            );
            blocks.push((shape, (first..nodes.len() as u32).collect()));
            let reference = |x: &[f64; D]| std::array::from_fn(|k| (x[k] - origin[k]) / size);
            let normal = |facet: &[u32; D]| {
                // It has one: the surface was made.
                flat_facet::normal(&facet.map(|point| surface.points[point as usize])).unwrap_or([0.0; D])
            };
            rigid.push(CarriedSurface {
                name: (*name).to_owned(),
                cell: (self.cell_count() + index) as u32,
                surface: Arc::new((*surface).clone()),
                references: surface.points.iter().map(reference).collect(),
                normals: surface.facets.iter().map(normal).collect(),
            });
        }
        if u32::try_from(nodes.len()).is_err() {
            return Err(MeshError::TooLarge { what: "nodes" });
        }
        // The bodies have been looked at, and what touches a cell that is not there does not matter.
        let mut mesh = Mesh::of_sound_cells(self.degree, nodes, blocks)?;
        let data = mesh.data_mut();
        for region in [EVERYWHERE, BOUNDARY, INTERIOR] {
            data.cell_regions.remove(region);
            data.facet_regions.remove(region);
            data.interior_regions.remove(region);
        }
        data.cell_regions.extend(self.cell_regions.clone());
        data.facet_regions.extend(self.facet_regions.clone());
        data.interior_regions.extend(self.interior_regions.clone());
        for carried in &rigid[self.rigid.len()..] {
            mesh.check_name(&carried.name, "cell", false)?;
            mesh.data_mut().cell_regions.insert(carried.name.clone(), vec![carried.cell]);
        }
        let data = mesh.data_mut();
        data.parts = self.parts.clone();
        data.rigid = rigid;
        Ok(mesh)
    }

    /// Whether all points of a surface lie in cells of bodies that do not reach the boundary. A shaft that is thicker than its hole
    /// has its points in the cells next to the boundary: it is none of those.
    fn has_within(&self, surface: &RigidSurface<D>) -> bool {
        let range = |points: &[[f64; D]], axis: usize| {
            let around = |(low, high): (f64, f64), x: &[f64; D]| (low.min(x[axis]), high.max(x[axis]));
            points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), around)
        };
        let of_bodies = &self.nodes[..self.body_nodes().0];
        let leaves = |axis: usize| {
            let (own, bodies) = (range(&surface.points, axis), range(of_bodies, axis));
            own.0 < bodies.0 || own.1 > bodies.1
        };
        if (0..D).any(leaves) {
            return false;
        }
        let mut at_boundary: Vec<u32> = self.boundary_facets().iter().map(|facet| facet.cell).collect();
        at_boundary.sort_unstable();
        let locator = Locator::new(self);
        let within = |x: &[f64; D]| {
            let cell = locator.find(x).map(|(cell, _)| cell as u32);
            cell.is_some_and(|cell| at_boundary.binary_search(&cell).is_err())
        };
        surface.points.iter().all(within)
    }
}
