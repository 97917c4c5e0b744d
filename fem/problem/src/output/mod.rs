//! Files and pictures.

pub mod matrix_market;
#[cfg(feature = "pictures")]
pub mod picture;
pub mod standard_output;
pub mod time_series;
pub mod vtu;
pub mod vtu_series;

pub use forms_mesh::files::{atomic, check_writable, write_whole};
pub use matrix_market::write_matrix_market;
pub use standard_output::{Failure, StandardOutput, one_line, program, tell};
pub use time_series::{Crossing, TimeSeries, TimeSeriesError};
pub use vtu::{VtuError, VtuFile};
pub use vtu_series::VtuSeries;

use crate::field::Field;
use crate::mesh::Mesh;

/// Whether a field lives on a mesh or on a copy of it.
fn lives_on<const D: usize>(field: &Field<D>, mesh: &Mesh<D>) -> bool {
    let own: &Mesh<D> = field.space().mesh();
    std::ptr::eq(own, mesh)
        || (own.blocks() == mesh.blocks() && own.cells() == mesh.cells() && own.nodes() == mesh.nodes())
}

/// Values of a field at the nodes of each cell of its mesh's geometry, cell after cell,
/// one component after the other.
fn values_at_cell_nodes<const D: usize>(mesh: &Mesh<D>, field: &Field<D>) -> Vec<f64> {
    let space = field.space();
    let components = space.components();
    let mut values = Vec::with_capacity(mesh.cells().len() * components);
    for block in mesh.blocks() {
        // The two elements number their nodes alike only if their degrees agree, and the space may number
        // its nodes in another way than the mesh: the field is evaluated cell by cell.
        let element = space.element_of(block.shape);
        let points = mesh.element_of(block.shape).node_points::<D>();
        let tables = element.tabulate::<D>(&points);
        for cell in block.cells.clone() {
            let unknowns = space.cell_nodes(cell);
            if element.is_in_space() {
                values.extend(points.iter().flat_map(|point| field.evaluate_in(cell, point)));
                continue;
            }
            for basis in tables.value.chunks(tables.nodes) {
                for component in 0..components {
                    let terms = basis.iter().zip(unknowns);
                    let value =
                        |(phi, &n): (&f64, &u32)| phi * field.values()[n as usize * components + component];
                    values.push(terms.map(value).sum());
                }
            }
        }
    }
    values
}
