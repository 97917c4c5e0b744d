//! Linear maps of tensors, component by component.

use super::Scalariser;
use crate::differentiate::multi_indices;
use crate::optimise::scalar::Scalar;
use crate::tensor::{LinearMap, Tensor};

impl Scalariser<'_> {
    pub(super) fn linear_map(&mut self, map: LinearMap, a: Tensor) -> Vec<Scalar> {
        let (components, shape) = (self.components(a), self.arena.shape(a).to_vec());
        let (rows, columns) = (shape[0], shape.get(1).copied().unwrap_or(1));
        let transposed: Vec<_> =
            multi_indices(&[columns, rows]).iter().map(|ij| components[ij[1] * columns + ij[0]]).collect();
        let graph = &mut *self.graph;
        match map {
            LinearMap::Transpose => transposed,
            LinearMap::Trace => {
                let diagonal: Vec<_> = (0..rows).map(|i| components[i * columns + i]).collect();
                vec![graph.sum(&diagonal)]
            }
            LinearMap::Symmetric | LinearMap::Skew => {
                let sign = if map == LinearMap::Symmetric { 0.5 } else { -0.5 };
                let pairs = components.iter().zip(&transposed);
                pairs
                    .map(|(a, b)| {
                        let (a, b) = (graph.scale(0.5, *a), graph.scale(sign, *b));
                        graph.add(a, b)
                    })
                    .collect()
            }
            LinearMap::Perpendicular => vec![graph.negate(components[1]), components[0]],
            LinearMap::Diagonal => (0..rows).map(|i| components[i * columns + i]).collect(),
            LinearMap::DiagonalTensor => {
                let zero = graph.number(0.0);
                let entries = multi_indices(&[rows, rows]);
                entries.iter().map(|ij| if ij[0] == ij[1] { components[ij[0]] } else { zero }).collect()
            }
            LinearMap::Curl => {
                let mut difference = |row: usize, column: usize| {
                    let minus = graph.negate(components[column * columns + row]);
                    graph.add(components[row * columns + column], minus)
                };
                match rows {
                    2 => vec![difference(1, 0)],
                    _ => vec![difference(2, 1), difference(0, 2), difference(1, 0)],
                }
            }
            // dev A = A − tr A / size I
            LinearMap::Deviator => {
                let diagonal: Vec<_> = (0..rows).map(|i| components[i * columns + i]).collect();
                let trace = graph.sum(&diagonal);
                let mean = graph.scale(-1.0 / rows as f64, trace);
                let on_diagonal = |entry: usize| entry / columns == entry % columns;
                let entries = components.iter().enumerate();
                entries.map(|(entry, a)| if on_diagonal(entry) { graph.add(*a, mean) } else { *a }).collect()
            }
        }
    }
}
