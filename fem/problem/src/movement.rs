//! Movements of a mesh: the fields along which its points can move, moved meshes, and the rates at which cells grow.
//!
//! A movement Θ lives in the finite element space of the mesh's geometry ([`Space::of_geometry`]): then the points of a
//! cell move as its nodes do, x + t Θ(x), and `derivative(form, shape, Theta)` is the derivative of what is assembled.

use std::sync::Arc;

use thiserror::Error;

use crate::element::Elements;
use crate::field::Field;
use crate::mesh::{Mesh, MeshError};
use crate::space::{Scope, Space, SpaceError};

/// Relative difference up to which two distances between vertices of a cell count as equally long.
const EQUALLY_LONG: f64 = 1e-12;

/// Errors of moving a mesh along a field.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum MovementError {
    /// The field lives on another space than the geometry.
    #[error(
        "a mesh moves along a field on the space of its geometry, `Space::of_geometry`: continuous vectors of degree {degree}; this one has {found} {scope} and {components} components"
    )]
    Space {
        /// Degree of the geometry.
        degree: usize,
        /// Elements of the field.
        found: Elements,
        /// Components of the field.
        components: usize,
        /// Scope of the field.
        scope: Scope,
    },
    /// The other space has other nodes.
    #[error(
        "the space does not have the nodes of the field's: it must be of the same kind, on a mesh that has moved"
    )]
    OtherNodes,
    /// A wrong number of values.
    #[error("there is one number for each of the {cells} cells, but {found} were given")]
    Length {
        /// Cells of the mesh.
        cells: usize,
        found: usize,
    },
    /// There is no space of constants on cells.
    #[error(transparent)]
    Cells(#[from] SpaceError),
    /// The moved mesh is none.
    #[error("after a movement with step {step:e}: {source}")]
    Mesh {
        step: f64,
        /// Why; it names the cell.
        source: MeshError,
    },
}

impl<const D: usize> Space<D> {
    /// The vectors along which the points of a mesh can move: the continuous space of degree 1 or 2 that the geometry
    /// itself lives in.
    ///
    /// # Errors
    /// As [`Space::vector`].
    pub fn of_geometry(mesh: &Mesh<D>) -> Result<Arc<Self>, SpaceError> {
        Space::vector(mesh, mesh.degree())
    }
}

impl<const D: usize> Field<D> {
    /// The mesh after its points have moved, x + step · Θ(x), with this field as Θ: the same cells, facets, regions and
    /// numbers, also of the nodes of spaces.
    ///
    /// # Errors
    /// [`MovementError`]: a field on another space; a cell that is inverted afterwards, by its number.
    pub fn move_mesh(&self, step: f64) -> Result<Mesh<D>, MovementError> {
        let mesh = self.space().mesh();
        check(self)?;
        let mut nodes = mesh.nodes().to_vec();
        for cell in 0..mesh.cell_count() {
            for (&node, &own) in mesh.cell(cell).iter().zip(self.space().cell_nodes(cell)) {
                let (start, by) = (&mesh.nodes()[node as usize], self.at_node(own as usize));
                nodes[node as usize] = std::array::from_fn(|k| start[k] + step * by[k]);
            }
        }
        mesh.with_nodes(nodes).map_err(|source| MovementError::Mesh { step, source })
    }

    /// These coefficients on a mesh that has moved: the field keeps its nodal values.
    ///
    /// # Errors
    /// [`MovementError::OtherNodes`] when the space is of another kind, or its mesh has other cells.
    pub fn carried_to(&self, space: &Arc<Space<D>>) -> Result<Self, MovementError> {
        let same = space.elements() == self.space().elements()
            && space.mesh().blocks() == self.space().mesh().blocks()
            && space.scope() == self.space().scope()
            && space.shape() == self.space().shape()
            && space.all_cell_nodes() == self.space().all_cell_nodes()
            && space.node_count() == self.space().node_count();
        match same {
            true => Ok(Field::of_known(space, self.values().to_vec())),
            false => Err(MovementError::OtherNodes),
        }
    }

    /// The rate at which the diameter h_T of each cell grows as points move along this field, constant on each cell:
    /// for `derivative(form, h, rate)`. Where several pairs of vertices are equally far apart it is their mean, as
    /// a central difference sees it for two; the diameter has a kink there.
    ///
    /// # Errors
    /// [`MovementError`], as [`Field::move_mesh`].
    pub fn rate_of_diameter(&self) -> Result<Self, MovementError> {
        check(self)?;
        let mesh = self.space().mesh();
        let cells = cellwise(mesh)?;
        let mut values = vec![0.0; cells.unknowns()];
        for cell in 0..mesh.cell_count() {
            let rate = &mut values[cells.cell_nodes(cell)[0] as usize];
            for_each_share(mesh, cell, &mut |vertex, share: [f64; D]| {
                let node = self.space().cell_nodes(cell)[vertex] as usize;
                *rate += share.iter().zip(self.at_node(node)).map(|(share, by)| share * by).sum::<f64>();
            });
        }
        Ok(Field::of_known(&cells, values))
    }
}

/// The transpose of [`Field::rate_of_diameter`]: from numbers per cell, ordered as the residual of
/// `derivative(form, h, r)` with a test function r that is constant on cells, to a vector over the movements. Added to
/// the residual of `derivative(form, shape, Theta)` it gives the derivative where h_T moves, too.
///
/// # Errors
/// [`MovementError::Space`] unless `movements` is the space of the geometry, [`MovementError::Length`].
pub fn diameters_to_movements<const D: usize>(
    movements: &Arc<Space<D>>,
    per_cell: &[f64],
) -> Result<Vec<f64>, MovementError> {
    check_space(movements)?;
    let mesh = movements.mesh();
    let cells = cellwise(mesh)?;
    let mut result = vec![0.0; movements.unknowns()];
    if per_cell.len() != cells.unknowns() {
        return Err(MovementError::Length { cells: cells.unknowns(), found: per_cell.len() });
    }
    for cell in 0..mesh.cell_count() {
        let weight = per_cell[cells.cell_nodes(cell)[0] as usize];
        for_each_share(mesh, cell, &mut |vertex, share: [f64; D]| {
            let node = movements.cell_nodes(cell)[vertex] as usize;
            for k in 0..D {
                result[node * D + k] += weight * share[k];
            }
        });
    }
    Ok(result)
}

fn cellwise<const D: usize>(mesh: &Mesh<D>) -> Result<Arc<Space<D>>, MovementError> {
    Ok(Space::discontinuous_scalar(mesh, 0)?)
}

fn check<const D: usize>(field: &Field<D>) -> Result<(), MovementError> {
    check_space(field.space())
}

fn check_space<const D: usize>(space: &Space<D>) -> Result<(), MovementError> {
    let degree = space.mesh().degree();
    if *space.elements() == Elements::Lagrange(degree)
        && space.components() == D
        && *space.scope() == Scope::Nodes
    {
        return Ok(());
    }
    let (found, components, scope) = (space.elements().clone(), space.components(), space.scope().clone());
    Err(MovementError::Space { degree, found, components, scope })
}

/// ∂h_T/∂x of the vertices of a cell, by local number.
fn for_each_share<const D: usize>(mesh: &Mesh<D>, cell: usize, add: &mut dyn FnMut(usize, [f64; D])) {
    let vertices = mesh.cell_vertices(cell);
    let position = |vertex: usize| &mesh.nodes()[vertices[vertex] as usize];
    let between =
        |a: usize, b: usize| -> [f64; D] { std::array::from_fn(|k| position(a)[k] - position(b)[k]) };
    let diameter = mesh.diameter(cell);
    let pairs = || (0..vertices.len()).flat_map(|a| (0..a).map(move |b| (a, b)));
    let longest = |&(a, b): &(usize, usize)| {
        let length = between(a, b).iter().map(|x| x * x).sum::<f64>().sqrt();
        length >= diameter * (1.0 - EQUALLY_LONG)
    };
    let count = pairs().filter(longest).count() as f64;
    for (a, b) in pairs().filter(longest) {
        let unit = between(a, b).map(|x| x / (diameter * count));
        add(a, unit);
        add(b, unit.map(|x| -x));
    }
}
