//! Meshes and fields for the tests of files and pictures.

use std::sync::Arc;

use crate::field::Field;
use crate::mesh::Mesh;
use crate::space::Space;

/// A field whose nodes are those of the mesh.
pub(crate) fn field<const D: usize>(
    mesh: &Arc<Mesh<D>>,
    shape: &[usize],
    value: impl Fn(&[f64; D]) -> Vec<f64>,
) -> Field<D> {
    let space = Space {
        mesh: mesh.clone(),
        element: mesh.element(),
        shape: shape.to_vec(),
        cell_nodes: mesh.cells().to_vec(),
        positions: mesh.nodes().to_vec(),
    };
    let values = mesh.nodes().iter().flat_map(value).collect();
    Field { space: Arc::new(space), values: Arc::new(values) }
}
