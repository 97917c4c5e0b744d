//! Mesh smoothing: inner nodes are repositioned, the boundary is kept.

use super::error::ShapeOptimisationError;
use super::inner_product::InnerProduct;
use crate::dimension::{Dim, Dimension};
use crate::mesh::Mesh;
use crate::space::Space;

/// The mesh with its inner nodes where one smooth movement takes those of the initial mesh, which takes the initial
/// boundary to the present one. Steps of a descent add up to something less smooth.
///
/// # Errors
/// The error that names an inverted cell, if the boundary has moved too far for one movement; the system's.
pub fn smoothed<const D: usize>(
    initial: &Mesh<D>,
    present: &Mesh<D>,
    product: &InnerProduct,
) -> Result<Mesh<D>, ShapeOptimisationError>
where
    Dim: Dimension<D>,
{
    let movements = Space::of_geometry(initial)?;
    let here = Space::of_geometry(present)?;
    let by = here.positions().iter().zip(movements.positions()).flat_map(|(here, there)| {
        let by: [f64; D] = std::array::from_fn(|k| here[k] - there[k]);
        by
    });
    let moved = product.extend(&movements, &by.collect::<Vec<f64>>())?;
    let mut nodes = initial.nodes().to_vec();
    for cell in 0..initial.cell_count() {
        for (&node, &own) in initial.cell(cell).iter().zip(movements.cell_nodes(cell)) {
            let (node, own) = (node as usize, own as usize);
            nodes[node] = std::array::from_fn(|k| initial.nodes()[node][k] + moved[own * D + k]);
        }
    }
    // Nodes of the boundary stay to the last bit.
    for facet in initial.boundary_facets() {
        for local in initial.cell_element(facet.cell as usize).facet_nodes(facet.local.into()) {
            let node = initial.cell(facet.cell as usize)[local] as usize;
            nodes[node] = present.nodes()[node];
        }
    }
    Ok(initial.with_nodes(nodes)?)
}
