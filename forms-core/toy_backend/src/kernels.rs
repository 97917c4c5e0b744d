//! Kernels behind virtual calls: their sums over the points of elements, in two types of lanes.

use forms_core::contract::*;

use crate::lanes::Four;
use crate::mesh::Element;
use crate::walk::{Walk, basis, cell, geometry, unpack};

/// This backend.
pub struct Dense;

impl<const D: usize> Backend<D> for Dense {
    type Linear = Box<dyn Vectors<D>>;
    type Bilinear = Box<dyn Matrices<D>>;
    type Expression = Box<dyn Values<D>>;

    fn linear<K: LinearKernel<D>>(kernel: K) -> Self::Linear {
        Box::new(kernel)
    }
    fn bilinear<K: BilinearKernel<D>>(kernel: K) -> Self::Bilinear {
        Box::new(kernel)
    }
    fn expression<K: ExpressionKernel<D>>(kernel: K) -> Self::Expression {
        Box::new(kernel)
    }
}

/// The start of a field's unknowns in a vector, and its components.
pub type Place = (usize, usize);

/// A walk, and the integral of the kernel that is called.
pub type At<'a, const D: usize> = (&'a Walk<'a, D>, &'a Integral);

/// A linear kernel.
pub trait Vectors<const D: usize>: Send + Sync {
    fn add_by_one(&self, at: At<D>, elements: &[&Element<D>], test: Place, vector: &mut [f64]);
    fn add_by_four(&self, at: At<D>, elements: &[&Element<D>], test: Place, vector: &mut [f64]);
}

impl<K: LinearKernel<D>, const D: usize> Vectors<D> for K {
    fn add_by_one(&self, at: At<D>, elements: &[&Element<D>], test: Place, vector: &mut [f64]) {
        add_vectors::<f64, K, D>(self, at, elements, test, vector);
    }
    fn add_by_four(&self, at: At<D>, elements: &[&Element<D>], test: Place, vector: &mut [f64]) {
        add_vectors::<Four, K, D>(self, at, elements, test, vector);
    }
}

/// A bilinear kernel.
pub trait Matrices<const D: usize>: Send + Sync {
    fn add_by_one(&self, at: At<D>, elements: &[&Element<D>], places: [Place; 2], matrix: &mut [Vec<f64>]);
    fn add_by_four(&self, at: At<D>, elements: &[&Element<D>], places: [Place; 2], matrix: &mut [Vec<f64>]);
}

impl<K: BilinearKernel<D>, const D: usize> Matrices<D> for K {
    fn add_by_one(&self, at: At<D>, elements: &[&Element<D>], places: [Place; 2], matrix: &mut [Vec<f64>]) {
        add_matrices::<f64, K, D>(self, at, elements, places, matrix);
    }
    fn add_by_four(&self, at: At<D>, elements: &[&Element<D>], places: [Place; 2], matrix: &mut [Vec<f64>]) {
        add_matrices::<Four, K, D>(self, at, elements, places, matrix);
    }
}

/// A kernel without test function.
pub trait Values<const D: usize>: Send + Sync {
    /// Weight and value at each point of an element.
    fn values(&self, walk: &Walk<D>, element: &Element<D>) -> Vec<(f64, Vec<f64>)>;
}

impl<K: ExpressionKernel<D>, const D: usize> Values<D> for K {
    fn values(&self, walk: &Walk<D>, element: &Element<D>) -> Vec<(f64, Vec<f64>)> {
        let batch = [element];
        let constants = self.cell::<f64>(&cell(&batch));
        let at = |point: usize| {
            let fields = walk.fields::<f64>(&K::REQUIREMENTS, &batch, point);
            let value = self.evaluate(&constants, &geometry(&batch, point), &fields);
            assert_eq!(value.as_ref().len(), K::SHAPE.iter().product::<usize>());
            (element.points[point].geometry.weight, value.as_ref().to_vec())
        };
        (0..element.points.len()).map(at).collect()
    }
}

/// A type of lanes that kernels are compiled for.
pub trait Lanes: Lane {
    fn add_vectors<const D: usize>(
        kernel: &dyn Vectors<D>,
        at: At<D>,
        elements: &[&Element<D>],
        test: Place,
        vector: &mut [f64],
    );
    fn add_matrices<const D: usize>(
        kernel: &dyn Matrices<D>,
        at: At<D>,
        elements: &[&Element<D>],
        places: [Place; 2],
        matrix: &mut [Vec<f64>],
    );
}

macro_rules! lanes {
    ($lanes:ty: $method:ident) => {
        impl Lanes for $lanes {
            fn add_vectors<const D: usize>(
                kernel: &dyn Vectors<D>,
                at: At<D>,
                elements: &[&Element<D>],
                test: Place,
                vector: &mut [f64],
            ) {
                kernel.$method(at, elements, test, vector);
            }
            fn add_matrices<const D: usize>(
                kernel: &dyn Matrices<D>,
                at: At<D>,
                elements: &[&Element<D>],
                places: [Place; 2],
                matrix: &mut [Vec<f64>],
            ) {
                kernel.$method(at, elements, places, matrix);
            }
        }
    };
}
lanes!(f64: add_by_one);
lanes!(Four: add_by_four);

fn add_vectors<L: Lane, K: LinearKernel<D>, const D: usize>(
    kernel: &K,
    (walk, integral): At<D>,
    elements: &[&Element<D>],
    (start, components): Place,
    vector: &mut [f64],
) {
    assert_eq!(components, K::TEST_COMPONENTS);
    for batch in elements.chunks(L::WIDTH) {
        let constants = kernel.cell::<L>(&cell(batch));
        for point in 0..batch[0].points.len() {
            let fields = walk.fields::<L>(&K::REQUIREMENTS, batch, point);
            let flux = kernel.point(&constants, &geometry(batch, point), &fields);
            for node in 0..batch[0].nodes.len() {
                let (basis, further) = basis(batch, integral.test_side, point, node, &K::REQUIREMENTS);
                let block = kernel.test(&flux, &basis, &further);
                for (component, value) in block.as_ref().iter().enumerate() {
                    for (lane, element) in batch.iter().enumerate() {
                        let node = element.on(integral.test_side).nodes[node];
                        vector[start + node * components + component] += unpack(*value)[lane];
                    }
                }
            }
        }
    }
}

fn add_matrices<L: Lane, K: BilinearKernel<D>, const D: usize>(
    kernel: &K,
    (walk, integral): At<D>,
    elements: &[&Element<D>],
    [(row, rows), (column, columns)]: [Place; 2],
    matrix: &mut [Vec<f64>],
) {
    assert_eq!((rows, columns), (K::TEST_COMPONENTS, K::TRIAL_COMPONENTS));
    assert_eq!(integral.symmetric, K::SYMMETRIC);
    for batch in elements.chunks(L::WIDTH) {
        let constants = kernel.cell::<L>(&cell(batch));
        let nodes = batch[0].nodes.len();
        let mut sums = vec![K::zero::<L>(); nodes * nodes];
        for point in 0..batch[0].points.len() {
            let fields = walk.fields::<L>(&K::REQUIREMENTS, batch, point);
            let data = kernel.point(&constants, &geometry(batch, point), &fields);
            let functions = |side: Side| -> Vec<(Basis<L, D>, Further<L, D>)> {
                (0..nodes).map(|node| basis(batch, side, point, node, &K::REQUIREMENTS)).collect()
            };
            let tests: Vec<_> = functions(integral.test_side)
                .iter()
                .map(|(basis, further)| kernel.test(&data, basis, further))
                .collect();
            let trials: Vec<_> = functions(integral.trial_side)
                .iter()
                .map(|(basis, further)| kernel.trial(&data, basis, further))
                .collect();
            for i in 0..nodes {
                for j in (if K::SYMMETRIC { i } else { 0 })..nodes {
                    K::pair(&mut sums[i * nodes + j], &tests[i], &trials[j]);
                }
            }
        }
        for i in 0..nodes {
            for j in (if K::SYMMETRIC { i } else { 0 })..nodes {
                let block = kernel.finish(&constants, &sums[i * nodes + j]);
                for (entry, value) in block.as_ref().iter().enumerate() {
                    let (a, b) = (entry / columns, entry % columns);
                    for (lane, element) in batch.iter().enumerate() {
                        let value = unpack(*value)[lane];
                        let first = element.on(integral.test_side).nodes[i];
                        let second = element.on(integral.trial_side).nodes[j];
                        matrix[row + first * rows + a][column + second * columns + b] += value;
                        if K::SYMMETRIC && i != j {
                            matrix[row + second * rows + b][column + first * columns + a] += value;
                        }
                    }
                }
            }
        }
    }
}
