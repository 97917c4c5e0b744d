//! Files and pictures.

pub mod atomic;
pub mod matrix_market;
#[cfg(feature = "pictures")]
pub mod picture;
pub mod vtu;

pub use atomic::write_whole;
pub use matrix_market::write_matrix_market;
pub use vtu::{VtuError, VtuFile};

use crate::field::Field;
use crate::mesh::Mesh;

/// Whether a field lives on a mesh or on a copy of it.
fn lives_on<const D: usize>(field: &Field<D>, mesh: &Mesh<D>) -> bool {
    let own: &Mesh<D> = field.space().mesh();
    std::ptr::eq(own, mesh) || (own.cells() == mesh.cells() && own.nodes() == mesh.nodes())
}

/// Values of a field at the nodes of each cell of its mesh's geometry, cell after cell,
/// `values[(cell * nodes + node) * components + component]`.
fn values_at_cell_nodes<const D: usize>(mesh: &Mesh<D>, field: &Field<D>) -> Vec<f64> {
    let space = field.space();
    let components = space.components();
    let per_cell = space.element().nodes();
    // The two elements number their nodes alike only if their degrees agree, and the space may number
    // its nodes in another way than the mesh: the field is evaluated cell by cell.
    let tables = space.element().tabulate::<D>(&mesh.element().node_points::<D>());
    let mut values = Vec::with_capacity(mesh.cells().len() * components);
    for cell in 0..mesh.cell_count() {
        let unknowns = space.cell_nodes(cell);
        for basis in tables.value.chunks(per_cell) {
            for component in 0..components {
                let terms = basis.iter().zip(unknowns);
                let value =
                    |(phi, &n): (&f64, &u32)| phi * field.values()[n as usize * components + component];
                values.push(terms.map(value).sum());
            }
        }
    }
    values
}
