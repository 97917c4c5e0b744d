//! Files and pictures.

pub mod matrix_market;
#[cfg(feature = "pictures")]
pub mod picture;
pub mod standard_output;
pub mod time_series;
pub mod vtu;
pub mod vtu_series;

#[doc(hidden)]
pub use forms_mesh::files::checksum;
pub use forms_mesh::files::{atomic, check_writable, write_whole};
pub use matrix_market::write_matrix_market;
pub use standard_output::{Failure, StandardOutput, one_line, program, tell};
pub use time_series::{Crossing, TimeSeries, TimeSeriesError};
pub use vtu::{VtuError, VtuFile};
pub use vtu_series::VtuSeries;

use std::ops::Range;
use std::sync::Arc;

use crate::element::CellShape;
use crate::field::Field;
use crate::mesh::Mesh;
use crate::threads::Threads;

/// Whether a field lives on a mesh or on a copy of it.
fn lives_on<const D: usize>(field: &Field<D>, mesh: &Mesh<D>) -> bool {
    let own: &Mesh<D> = field.space().mesh();
    std::ptr::eq(own, mesh)
        || (own.blocks() == mesh.blocks() && own.cells() == mesh.cells() && own.nodes() == mesh.nodes())
}

/// Values of a field at the nodes of each cell of its mesh's geometry, cell after cell,
/// one component after the other.
fn values_at_cell_nodes<const D: usize>(threads: Threads, mesh: &Mesh<D>, field: &Field<D>) -> Vec<f64> {
    let components = field.space().components();
    let mut values = vec![0.0; mesh.cells().len() * components];
    let (mut rest, mut parts) = (&mut values[..], vec![]);
    for block in mesh.blocks() {
        let element = mesh.element_of(block.shape);
        // The two elements number their nodes alike only if their degrees agree, and the space may number
        // its nodes in another way than the mesh: the field is evaluated cell by cell.
        let points = Arc::new(element.node_points::<D>());
        let of_cell = points.len() * components;
        let cells = block.cells.len().div_ceil(threads.for_work(block.cells.len() * of_cell)).max(1);
        for first in block.cells.clone().step_by(cells) {
            let cells = first..(first + cells).min(block.cells.end);
            let (own, others) = rest.split_at_mut(cells.len() * of_cell);
            parts.push((block.shape, points.clone(), cells, own));
            rest = others;
        }
    }
    threads.run(parts, |(shape, points, cells, values)| {
        set_values_at(field, shape, &points, cells, values);
    });
    values
}

/// Sets the values of a field at points of the reference cell in some cells.
fn set_values_at<const D: usize>(
    field: &Field<D>,
    shape: CellShape,
    points: &[[f64; D]],
    cells: Range<usize>,
    values: &mut [f64],
) {
    let space = field.space();
    let (components, element) = (space.components(), space.element_of(shape));
    let tables = element.tabulate::<D>(points);
    for (cell, values) in cells.zip(values.chunks_mut(points.len() * components)) {
        if element.is_in_space() {
            let found = points.iter().flat_map(|point| field.evaluate_in(cell, point));
            values.iter_mut().zip(found).for_each(|(value, found)| *value = found);
            continue;
        }
        let unknowns = space.cell_nodes(cell);
        for (basis, values) in tables.value.chunks(tables.nodes).zip(values.chunks_mut(components)) {
            for (component, value) in values.iter_mut().enumerate() {
                let terms = basis.iter().zip(unknowns);
                let term =
                    |(phi, &n): (&f64, &u32)| phi * field.values()[n as usize * components + component];
                *value = terms.map(term).sum();
            }
        }
    }
}
