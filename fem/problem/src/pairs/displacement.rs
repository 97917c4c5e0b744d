//! Displacement of surfaces by a sum of fields, evaluated on facets.

use crate::element::lagrange::{Lagrange, MAXIMUM_NODES};
use crate::mesh::{Facet, Mesh};
use crate::space::Space;

/// A sum of vector fields on cells.
pub(crate) struct Displacement<'a, const D: usize> {
    pub fields: Vec<DisplacementField<'a, D>>,
}

/// One of the fields.
pub(crate) struct DisplacementField<'a, const D: usize> {
    pub space: &'a Space<D>,
    pub values: &'a [f64],
}

/// Coefficients of a displacement's fields on one cell.
#[derive(Clone, Debug)]
pub(super) struct CellDisplacement<const D: usize> {
    parts: Vec<(Lagrange, Vec<[f64; D]>)>,
}

impl<const D: usize> Displacement<'_, D> {
    /// The highest degree of the fields.
    pub fn degree(&self) -> usize {
        self.fields.iter().map(|field| field.space.trace_degree()).max().unwrap_or(0)
    }

    /// The displacement of the cell that owns a facet.
    pub(super) fn on_cell_of(&self, mesh: &Mesh<D>, facet: Facet) -> CellDisplacement<D> {
        let shape = mesh.cell_shape(facet.cell as usize);
        let part = |field: &DisplacementField<D>| {
            let nodes = field.space.nodes_at(facet.cell, Some(facet.local));
            let coefficients = nodes.iter().map(|node| field.value_at(*node)).collect();
            (field.space.traces_of(shape), coefficients)
        };
        CellDisplacement { parts: self.fields.iter().map(part).collect() }
    }
}

impl<const D: usize> DisplacementField<'_, D> {
    /// The value at a node; zero before there are coefficients, as when a pattern is made.
    pub(super) fn value_at(&self, node: u32) -> [f64; D] {
        let first = node as usize * D;
        match self.values.get(first..first + D) {
            Some(values) => std::array::from_fn(|k| values[k]),
            None => [0.0; D],
        }
    }
}

impl<const D: usize> CellDisplacement<D> {
    /// The highest degree of the fields.
    pub fn degree(&self) -> usize {
        self.parts.iter().map(|(element, _)| element.degree).max().unwrap_or(0)
    }

    /// The displacement and its derivatives along the reference cell's axes at a point of that cell, added.
    pub fn add_at(&self, reference: &[f64; D], position: &mut [f64; D], jacobian: &mut [[f64; D]; D]) {
        for (element, coefficients) in &self.parts {
            let (mut value, mut gradient) = ([0.0; MAXIMUM_NODES], [[0.0; D]; MAXIMUM_NODES]);
            element.evaluate(reference, &mut value, &mut gradient);
            for ((coefficient, phi), slope) in coefficients.iter().zip(value).zip(gradient) {
                for i in 0..D {
                    position[i] += phi * coefficient[i];
                    for j in 0..D {
                        jacobian[i][j] += slope[j] * coefficient[i];
                    }
                }
            }
        }
    }
}
