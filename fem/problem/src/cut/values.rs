//! The values of a level set function at the nodes of cells, away from zero, and what they say of a cell.

use super::heights::CellPolynomial;
use super::{Cut, CutError, CutSide, NEAR_ZERO};
use crate::element::{CellShape, Elements};
use crate::field::Field;
use crate::mesh::Mesh;
use crate::space::{Scope, Space};

/// The degree of a level set function, if its cells can be cut by it.
///
/// # Errors
/// [`CutError`].
pub(super) fn degree_of<const D: usize>(space: &Space<D>) -> Result<usize, CutError> {
    if space.components() != 1 {
        return Err(CutError::Components { found: space.components() });
    }
    let degree = match space.elements() {
        Elements::Lagrange(degree @ (1 | 2)) if *space.scope() == Scope::Nodes => *degree,
        elements => {
            return Err(CutError::Elements { elements: elements.clone(), scope: space.scope().clone() });
        }
    };
    let shape = space.mesh().shapes().into_iter().find(|shape| shape.is_simplex());
    match (degree, shape) {
        (2, Some(shape)) => Err(CutError::DegreeOnSimplices { shape }),
        _ => Ok(degree),
    }
}

impl<const D: usize> Cut<D> {
    /// Number of nodes of φ's space.
    pub(crate) fn node_count(&self) -> usize {
        self.values.len()
    }

    /// φ at the vertices of a cell.
    pub(crate) fn vertex_values(&self, cell: u32) -> [f64; 4] {
        let nodes = self.vertex_nodes(cell);
        std::array::from_fn(|k| nodes.get(k).map_or(f64::NAN, |node| self.values[*node as usize]))
    }

    /// All nodes of φ's space on a cell, those at its vertices first.
    pub(crate) fn level_nodes(&self, cell: u32) -> &[u32] {
        let cell = cell as usize;
        &self.nodes[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// The nodes of φ's space at the vertices of a cell.
    pub(crate) fn vertex_nodes(&self, cell: u32) -> &[u32] {
        let nodes = self.level_nodes(cell);
        match self.degree {
            1 => nodes,
            _ => &nodes[..nodes.len().min(self.mesh.cell_shape(cell as usize).vertices())],
        }
    }

    /// Whether cells of a shape are cut along heights of a polynomial, and not as simplices.
    pub(crate) fn is_by_heights(&self, shape: CellShape) -> bool {
        shape == CellShape::Hexahedron || (shape == CellShape::Quadrilateral && self.degree == 2)
    }

    /// The same of a cell, without a look at its shape where no cell is.
    pub(super) fn cuts_by_heights(&self, cell: u32) -> bool {
        !self.lattice.is_empty() && self.is_by_heights(self.mesh.cell_shape(cell as usize))
    }

    /// The degree of the level set function.
    pub(crate) fn degree(&self) -> usize {
        self.degree
    }

    /// Location of a cell by its values.
    pub(super) fn side_by_values(&self, cell: u32) -> CutSide {
        match self.cuts_by_heights(cell) {
            true => CellPolynomial::<f64>::new(self, cell).side(),
            false => side(self.level_nodes(cell).iter().map(|node| self.values[*node as usize])),
        }
    }

    /// Bounds of φ on a cell.
    pub(super) fn bounds_of(&self, cell: u32) -> [f64; 2] {
        if self.cuts_by_heights(cell) {
            return CellPolynomial::<f64>::new(self, cell).bounds();
        }
        let values = self.level_nodes(cell).iter().map(|node| self.values[*node as usize]);
        values.fold([f64::MAX, f64::MIN], |[a, b], value| [a.min(value), b.max(value)])
    }
}

/// The side of what has these values at its vertices.
pub(super) fn side(values: impl Iterator<Item = f64>) -> CutSide {
    let (mut inner, mut outer) = (false, false);
    for value in values {
        inner |= value < 0.0;
        outer |= value > 0.0;
    }
    match (inner, outer) {
        (true, false) => CutSide::Inside,
        (true, true) => CutSide::Cut,
        _ => CutSide::Outside,
    }
}

/// The nodes of all cells, those at vertices first, and the start of each cell's.
pub(super) fn nodes_of<const D: usize>(phi: &Field<D>) -> (Vec<u32>, Vec<u32>) {
    let space = phi.space();
    let mesh = space.mesh();
    let (mut list, mut starts) = (Vec::new(), Vec::with_capacity(mesh.cell_count() + 1));
    starts.push(0);
    let places: Vec<(CellShape, Vec<usize>)> =
        mesh.shapes().into_iter().map(|shape| (shape, places_of(space, shape))).collect();
    list.reserve(mesh.cell_count() * places.iter().map(|(_, places)| places.len()).max().unwrap_or(0));
    for cell in 0..mesh.cell_count() {
        let shape = mesh.cell_shape(cell);
        let nodes = space.cell_nodes(cell);
        let known = places.iter().find(|(known, _)| *known == shape);
        let places = known.map(|(_, places)| &places[..]).unwrap_or_default();
        list.extend(places.iter().filter_map(|place| nodes.get(*place)));
        starts.push(list.len() as u32);
    }
    (list, starts)
}

/// The numbers of a cell's nodes, those at vertices first.
fn places_of<const D: usize>(space: &Space<D>, shape: CellShape) -> Vec<usize> {
    let points = space.element_of(shape).node_points::<D>();
    let at = |vertex: &[f64; 3]| points.iter().position(|point| point[..] == vertex[..D]);
    let mut places: Vec<usize> = shape.vertex_points().iter().filter_map(at).collect();
    let further: Vec<usize> = (0..points.len()).filter(|place| !places.contains(place)).collect();
    places.extend(further);
    places
}

/// The places of these nodes among those of degree 2 along each axis, the first axis fastest, on the shape that is cut along heights; none without one.
pub(super) fn lattice_of<const D: usize>(space: &Space<D>, mesh: &Mesh<D>) -> Vec<u8> {
    let Some(shape) = mesh.shapes().into_iter().find(|shape| !shape.is_simplex()) else { return vec![] };
    if shape == CellShape::Quadrilateral && space.degree() == 1 {
        return vec![];
    }
    let points = space.element_of(shape).node_points::<D>();
    let place = |point: &[f64; D]| {
        point.iter().zip([1.0, 3.0, 9.0]).map(|(x, step)| (2.0 * x).round() * step).sum::<f64>() as u8
    };
    places_of(space, shape).into_iter().map(|k| place(&points[k])).collect()
}

/// Values without zeros, and the nodes whose values were moved.
pub(super) fn away_from_zero<'a>(
    values: &[f64],
    cells: impl Iterator<Item = &'a [u32]>,
) -> (Vec<f64>, Vec<u32>) {
    // The range around a node is at most that of all values: mostly nothing is near zero.
    let [least, most] = values
        .iter()
        .fold([f64::MAX, f64::MIN], |[least, most], value| [least.min(*value), most.max(*value)]);
    let near = (NEAR_ZERO * (most - least)).max(f64::MIN_POSITIVE);
    if !values.iter().any(|value| value.abs() < near) {
        return (values.to_vec(), vec![]);
    }
    let mut ranges = vec![0.0_f64; values.len()];
    for nodes in cells {
        let of_cell = || nodes.iter().map(|node| values[*node as usize]);
        let range = of_cell().fold(f64::MIN, f64::max) - of_cell().fold(f64::MAX, f64::min);
        for node in nodes {
            ranges[*node as usize] = ranges[*node as usize].max(range);
        }
    }
    let (mut values, mut moved) = (values.to_vec(), vec![]);
    for (node, value) in values.iter_mut().enumerate() {
        // A node of no cell, or one around which the function vanishes, has no range.
        let least = (NEAR_ZERO * ranges[node]).max(f64::MIN_POSITIVE);
        if value.abs() < least {
            *value = least;
            moved.push(node as u32);
        }
    }
    (values, moved)
}
