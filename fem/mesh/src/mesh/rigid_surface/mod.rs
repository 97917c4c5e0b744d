//! Rigid surfaces: flat facets that move as one, without cells behind them.

mod carried;
mod error;
mod flat_facet;
mod signed_distance;
mod stl;

use std::collections::BTreeMap;

#[doc(hidden)]
pub use self::carried::CarriedSurface;
pub use self::error::RigidSurfaceError;
pub use self::signed_distance::SignedDistance;
use super::{Facet, Mesh, MeshError, TAKE_THE_WHOLE};
use crate::instantiate;

/// The side of a rigid tool: segments in the plane, triangles in space, whose normals point out of the tool, toward the bodies that
/// it meets. [`Mesh::with_rigid_surfaces`] adds it to bodies.
///
/// ```
/// # use forms_mesh as forms_fem;
/// use forms_fem::element::CellShape;
/// use forms_fem::mesh::{RigidSurface, rectangle};
///
/// let block = rectangle([0.0, 0.0], [2.0, 1.0], [8, 4], CellShape::Quadrilateral, 1)?;
/// // The outward side of a polygon is on the right of the way along it: this one looks down.
/// let punch = RigidSurface::along(&[[0.5, 1.5], [0.6, 1.0], [1.4, 1.0], [1.5, 1.5]])?;
/// let mesh = block.with_rigid_surfaces(&[("punch", &punch)])?;
/// // A pairing finds it by its name: `Pairing::onto("top", "punch")`. The bodies are all that a form or a picture sees.
/// assert_eq!(mesh.cell_region("all")?.len(), 32);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct RigidSurface<const D: usize> {
    points: Vec<[f64; D]>,
    facets: Vec<[u32; D]>,
    /// Edges in space, or ends in the plane, that only one facet has.
    rim: usize,
    /// The first facet with such an edge or end, and the middle of the edge.
    open: Option<(usize, [f64; D])>,
}

/// The number of open edges, and the first facet with one and its middle.
type Rim<const D: usize> = (usize, Option<(usize, [f64; D])>);

impl<const D: usize> RigidSurface<D> {
    /// A surface from its points \[length\] and the numbers of each facet's corners: from left to right as seen with the outward
    /// normal up in the plane, counter-clockwise as seen from outside in space.
    ///
    /// # Errors
    /// A [`RigidSurfaceError`] that names the facet or point: no facets, a point that does not exist, a coordinate that is not finite,
    /// a facet without an area, neighbours with opposite sides outward.
    #[inline(never)]
    pub fn new(points: Vec<[f64; D]>, facets: Vec<[u32; D]>) -> Result<Self, RigidSurfaceError> {
        if facets.is_empty() {
            return Err(RigidSurfaceError::Empty);
        }
        if let Some(point) = points.iter().position(|x| !x.iter().all(|x| x.is_finite())) {
            return Err(RigidSurfaceError::NotFinite { point, position: points[point].to_vec() });
        }
        for (index, facet) in facets.iter().enumerate() {
            if let Some(&point) = facet.iter().find(|&&point| point as usize >= points.len()) {
                return Err(RigidSurfaceError::NoPoint { facet: index, point, count: points.len() });
            }
            let corners = facet.map(|point| points[point as usize]);
            if flat_facet::normal(&corners).is_none() {
                return Err(RigidSurfaceError::Degenerate { facet: index, position: corners[0].to_vec() });
            }
        }
        let (rim, open) = rim(&points, &facets)?;
        Ok(RigidSurface { points, facets, rim, open })
    }

    /// The side of a body of straight facets, by the name of a region on its boundary. Quadrilaterals are divided into triangles; the
    /// body's outward side is the surface's.
    ///
    /// # Errors
    /// [`RigidSurfaceError::Region`], [`RigidSurfaceError::Curved`]; those of [`RigidSurface::new`].
    #[inline(never)]
    pub fn of_boundary(body: &Mesh<D>, region: &str) -> Result<Self, RigidSurfaceError> {
        let named = body.facet_region(region).map_err(|source| RigidSurfaceError::Region { source })?;
        if body.degree() > 1 {
            return Err(RigidSurfaceError::Curved { region: region.to_owned() });
        }
        let mut number: BTreeMap<u32, u32> = BTreeMap::new();
        let (mut points, mut facets) = (Vec::new(), Vec::new());
        for facet in named {
            let corners: Vec<u32> = body.facet_vertices(*facet).collect();
            let mut own = |vertex: u32| {
                *number.entry(vertex).or_insert_with(|| {
                    points.push(body.nodes()[vertex as usize]);
                    points.len() as u32 - 1
                })
            };
            let corners: Vec<u32> = corners.into_iter().map(&mut own).collect();
            for last in D - 1..corners.len() {
                facets.push(std::array::from_fn(
                    |k| if k == 0 { corners[0] } else { corners[last + k + 1 - D] },
                ));
            }
        }
        RigidSurface::new(points, facets)
    }

    /// The points \[length\].
    pub fn points(&self) -> &[[f64; D]] {
        &self.points
    }

    /// The corners of each facet.
    pub fn facets(&self) -> &[[u32; D]] {
        &self.facets
    }

    /// Number of edges in space, or of ends in the plane, at which the surface stops: zero of one that is closed.
    pub fn rim(&self) -> usize {
        self.rim
    }

    /// The area in the plane, or the volume, that a closed surface encloses \[length^D\]: negative where its outward side looks inward,
    /// as that of a hollow mould does. `None` of a surface that is open.
    pub fn enclosed(&self) -> Option<f64> {
        let start = self.points[self.facets[0][0] as usize];
        let part = |facet: &[u32; D]| {
            let corners = facet.map(|point| self.points[point as usize]);
            flat_facet::signed_cone(&corners, &start)
        };
        (self.rim == 0).then(|| self.facets.iter().map(part).sum())
    }

    /// The points after a motion x ↦ map(x) \[length\], facet by facet: polylines for a picture.
    pub fn outline(&self, motion: impl Fn(&[f64; D]) -> [f64; D]) -> Vec<Vec<[f64; D]>> {
        let moved =
            |facet: &[u32; D]| facet.iter().map(|point| motion(&self.points[*point as usize])).collect();
        self.facets.iter().map(moved).collect()
    }
}

impl RigidSurface<2> {
    /// A polygon: the outward side is on the right of the way from each point to the next. It is closed where the last point is the
    /// first.
    ///
    /// ```
    /// # use forms_mesh as forms_fem;
    /// use forms_fem::element::CellShape;
    /// use forms_fem::mesh::{RigidSurface, rectangle};
    ///
    /// // The lower side of a blunt punch looks down: on the right, so the way goes to the left.
    /// let punch = RigidSurface::along(&[[1.5, 1.5], [1.2, 1.1], [0.8, 1.1], [0.5, 1.5]])?;
    /// let block = rectangle([0.0, 0.0], [2.0, 1.0], [8, 4], CellShape::Quadrilateral, 1)?;
    /// let mesh = block.with_rigid_surfaces(&[("punch", &punch)])?;
    /// assert_eq!(mesh.rigid_surface_names().collect::<Vec<_>>(), ["punch"]);
    /// // A closed bar, counter-clockwise: its outward side is outside.
    /// let bar = RigidSurface::along(&[[0.0, 2.0], [1.0, 2.0], [1.0, 3.0], [0.0, 3.0], [0.0, 2.0]])?;
    /// assert_eq!((bar.rim(), bar.enclosed()), (0, Some(1.0)));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`RigidSurface::new`].
    pub fn along(points: &[[f64; 2]]) -> Result<Self, RigidSurfaceError> {
        let count = points.len();
        let closed = count > 2 && points[0] == points[count - 1];
        let own = if closed { count - 1 } else { count };
        let facets = (1..count).map(|k| [k as u32 - 1, (k % own.max(1)) as u32]).collect();
        RigidSurface::new(points[..own].to_vec(), facets)
    }
}

/// The number of edges (in the plane: points) with one facet, where all others have as many on each side.
fn rim<const D: usize>(points: &[[f64; D]], facets: &[[u32; D]]) -> Result<Rim<D>, RigidSurfaceError> {
    // How often facets run along an edge from the lower number to the higher one and back, and the last of them.
    let mut edges: BTreeMap<[u32; 2], ([usize; 2], usize)> = BTreeMap::new();
    for (index, facet) in facets.iter().enumerate() {
        for k in 0..D {
            // In the plane a facet begins at one point and ends at the other.
            let [a, b] = if D == 2 { [facet[k]; 2] } else { [facet[k], facet[(k + 1) % D]] };
            let backward = if D == 2 { k == 1 } else { a > b };
            let (counts, last) = edges.entry([a.min(b), a.max(b)]).or_default();
            counts[usize::from(backward)] += 1;
            *last = index;
        }
    }
    let (mut rim, mut open) = (0, None::<(usize, [f64; D])>);
    for (edge, ([forward, backward], facet)) in edges {
        let middle: [f64; D] =
            std::array::from_fn(|k| edge.iter().map(|point| 0.5 * points[*point as usize][k]).sum());
        if forward + backward == 1 {
            rim += 1;
            if open.is_none_or(|(first, _)| facet < first) {
                open = Some((facet, middle));
            }
        } else if forward != backward {
            let corners = facets[facet].to_vec();
            return Err(RigidSurfaceError::Sides { facet, corners, position: middle.to_vec() });
        }
    }
    Ok((rim, open))
}

impl<const D: usize> Mesh<D> {
    /// The name of a rigid surface among the facets that a pairing asks for.
    #[doc(hidden)]
    pub fn rigid_surface(&self, name: &str) -> Option<&CarriedSurface<D>> {
        self.rigid.iter().find(|carried| carried.name == name)
    }

    /// Names of the rigid surfaces, in the order in which they came.
    pub fn rigid_surface_names(&self) -> impl Iterator<Item = &str> {
        self.rigid.iter().map(|carried| carried.name.as_str())
    }

    /// Whether a cell carries a rigid surface, and is no part of a body.
    #[doc(hidden)]
    pub fn carries(&self, cell: u32) -> bool {
        cell as usize >= self.cells_of_bodies().end
    }

    /// The cells of bodies: all but those that carry rigid surfaces, which come after them. Of a piece of a mesh they are this process's own.
    pub fn body_cells(&self) -> std::ops::Range<usize> {
        0..self.ghost_cells().start - self.rigid.len()
    }

    /// The cells of bodies with copies of other processes' cells.
    #[doc(hidden)]
    pub fn cells_of_bodies(&self) -> std::ops::Range<usize> {
        0..self.cell_count() - self.rigid.len()
    }

    /// Number of nodes of the bodies, and of the places in [`Mesh::cells`] that are of their cells. The nodes of the cells that carry
    /// rigid surfaces come after them, and those of copies of other processes' cells.
    #[doc(hidden)]
    pub fn body_nodes(&self) -> (usize, usize) {
        let places = |cells: std::ops::Range<usize>| cells.map(|cell| self.cell(cell).len()).sum::<usize>();
        let others = places(self.body_cells().end..self.cell_count());
        let carriers = places(self.cells_of_bodies().end..self.cell_count());
        (self.node_count() - carriers - self.ghost_nodes(), self.cells.len() - others)
    }

    /// Check that the mesh has no rigid surfaces and is no piece of another, for functions that do not support them.
    pub(super) fn without_rigid_surfaces(&self, what: &'static str) -> Result<(), MeshError> {
        self.without_pieces(what, TAKE_THE_WHOLE)?;
        match self.rigid.first() {
            None => Ok(()),
            Some(first) => Err(MeshError::RigidSurface { name: first.name.clone(), what }),
        }
    }

    /// The facet that represents a whole rigid surface. Its points belong to the cell that carries the surface.
    #[doc(hidden)]
    pub fn carrier(&self, name: &str) -> Option<Facet> {
        self.rigid_surface(name).map(|carried| Facet { cell: carried.cell, local: 0 })
    }
}

instantiate!(rigid_surface: RigidSurface::<D>::new, RigidSurface::<D>::of_boundary, RigidSurface::<D>::signed_distance, SignedDistance::<D>::at, Mesh::<D>::with_rigid_surfaces);
