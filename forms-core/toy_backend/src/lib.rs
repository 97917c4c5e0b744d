//! A backend of a thousand lines that knows nothing but the contract: linear or quadratic simplices, dense matrices. The
//! operators of the language are tested on it.

pub mod differences;
pub mod interpolate;
pub mod lanes;
pub mod mesh;
pub mod operator;
pub mod plain;
pub mod random;
pub mod rays;
mod walk;

use std::any::Any;
use std::borrow::Cow;
use std::convert::Infallible;
use std::sync::Arc;

use forms_core::contract::*;
use mesh::{Element, Mesh};
use walk::{Walk, basis, cell, geometry, unpack};

/// Nodal values of a field, node by node: the field data of this backend.
#[derive(Clone, Debug)]
pub struct Nodal {
    pub components: usize,
    pub values: Vec<f64>,
}

impl DiscreteField for Nodal {
    fn components(&self) -> usize {
        self.components
    }
    fn as_any(&self) -> &dyn Any {
        self
    }
}

impl Nodal {
    pub fn source<const D: usize>(&self) -> Source<D> {
        Source::Discrete(Arc::new(self.clone()))
    }
}

/// Places of the unknowns (or tests) in the global numbering: start and components of each.
fn layout(fields: &[FieldDescription], nodes: usize, test: bool) -> (Vec<(usize, usize)>, usize) {
    let mut next = 0;
    let mut starts = Vec::new();
    for field in fields {
        if matches!((field.role, test), (Role::Test(_), true) | (Role::Unknown(_), false)) {
            starts.push((next, field.components()));
            next += nodes * field.components();
        }
    }
    (starts, next)
}

/// R(u) by lane type `L`, dense.
pub fn residual<L: Lane, F: Form<D>, const D: usize>(
    mesh: &Mesh<D>,
    form: &F,
    unknowns: &[Nodal],
) -> Vec<f64> {
    vector::<L, F, D>(mesh, form, unknowns, None)
}

/// ∂R/∂u w by lane type `L`, without a matrix.
pub fn action<L: Lane, F: Form<D>, const D: usize>(
    mesh: &Mesh<D>,
    form: &F,
    unknowns: &[Nodal],
    directions: &[Nodal],
) -> Vec<f64> {
    vector::<L, F, D>(mesh, form, unknowns, Some(directions))
}

/// The residual, or the action on directions.
fn vector<L: Lane, F: Form<D>, const D: usize>(
    mesh: &Mesh<D>,
    form: &F,
    unknowns: &[Nodal],
    directions: Option<&[Nodal]>,
) -> Vec<f64> {
    struct Visitor<'a, const D: usize, L>(Walk<'a, D>, Vec<(usize, usize)>, Vec<f64>, L);
    impl<L: Lane, const D: usize> LinearVisitor<D> for Visitor<'_, D, L> {
        type Error = Infallible;
        fn visit<K: LinearKernel<D>>(&mut self, integral: &Integral, kernel: &K) -> Result<(), Infallible> {
            let (start, components) = self.1[integral.test];
            assert_eq!(components, K::TEST_COMPONENTS);
            let elements = self.0.elements(integral);
            let elements: Vec<&Element<D>> = elements.iter().map(|element| &**element).collect();
            for batch in elements.chunks(L::WIDTH) {
                let constants = kernel.cell::<L>(&cell(batch));
                for point in 0..batch[0].points.len() {
                    let fields = self.0.fields::<L>(&K::REQUIREMENTS, batch, point);
                    let flux = kernel.point(&constants, &geometry(batch, point), &fields);
                    for node in 0..batch[0].nodes.len() {
                        let (basis, hessian) =
                            basis(batch, integral.test_side, point, node, &K::REQUIREMENTS);
                        let block = kernel.test(&flux, &basis, &hessian);
                        for (component, value) in block.as_ref().iter().enumerate() {
                            for (lane, element) in batch.iter().enumerate() {
                                let node = element.on(integral.test_side).nodes[node];
                                let row = start + node * components + component;
                                self.2[row] += unpack(*value)[lane];
                            }
                        }
                    }
                }
            }
            Ok(())
        }
    }
    let (tests, size) = layout(form.fields(), mesh.nodes.len(), true);
    let walk = Walk {
        mesh,
        fields: form.fields(),
        inputs: form.inputs(),
        unknowns,
        directions: directions.unwrap_or_default(),
    };
    let mut visitor = Visitor(walk, tests, vec![0.0; size], L::splat(0.0));
    let walked = match directions {
        Some(_) => form.action(&mut visitor),
        None => form.residual(&mut visitor),
    };
    walked.unwrap_or_else(|never| match never {});
    visitor.2
}

/// ∂R/∂u by lane type `L`, dense, row by row. Symmetric integrals compute pairs i ≤ j only.
pub fn tangent<L: Lane, F: Form<D>, const D: usize>(
    mesh: &Mesh<D>,
    form: &F,
    unknowns: &[Nodal],
) -> Vec<Vec<f64>> {
    struct Visitor<'a, const D: usize, L>(
        Walk<'a, D>,
        [Vec<(usize, usize)>; 2],
        Vec<Vec<f64>>,
        std::marker::PhantomData<L>,
    );
    impl<L: Lane, const D: usize> BilinearVisitor<D> for Visitor<'_, D, L> {
        type Error = Infallible;
        fn visit<K: BilinearKernel<D>>(&mut self, integral: &Integral, kernel: &K) -> Result<(), Infallible> {
            let ((row, rows), (column, columns)) = (self.1[0][integral.test], self.1[1][integral.trial]);
            assert_eq!((rows, columns), (K::TEST_COMPONENTS, K::TRIAL_COMPONENTS));
            assert_eq!(integral.symmetric, K::SYMMETRIC);
            let elements = self.0.elements(integral);
            let elements: Vec<&Element<D>> = elements.iter().map(|element| &**element).collect();
            for batch in elements.chunks(L::WIDTH) {
                let constants = kernel.cell::<L>(&cell(batch));
                let nodes = batch[0].nodes.len();
                let mut sums = vec![K::zero::<L>(); nodes * nodes];
                for point in 0..batch[0].points.len() {
                    let fields = self.0.fields::<L>(&K::REQUIREMENTS, batch, point);
                    let data = kernel.point(&constants, &geometry(batch, point), &fields);
                    let functions = |side: Side| -> Vec<(Basis<L, D>, Hessian<L, D>)> {
                        (0..nodes).map(|node| basis(batch, side, point, node, &K::REQUIREMENTS)).collect()
                    };
                    let tests: Vec<_> = functions(integral.test_side)
                        .iter()
                        .map(|(basis, hessian)| kernel.test(&data, basis, hessian))
                        .collect();
                    let trials: Vec<_> = functions(integral.trial_side)
                        .iter()
                        .map(|(basis, hessian)| kernel.trial(&data, basis, hessian))
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
                                self.2[row + first * rows + a][column + second * columns + b] += value;
                                if K::SYMMETRIC && i != j {
                                    self.2[row + second * rows + b][column + first * columns + a] += value;
                                }
                            }
                        }
                    }
                }
            }
            Ok(())
        }
    }
    let (tests, rows) = layout(form.fields(), mesh.nodes.len(), true);
    let (trials, columns) = layout(form.fields(), mesh.nodes.len(), false);
    let walk = Walk { mesh, fields: form.fields(), inputs: form.inputs(), unknowns, directions: &[] };
    let matrix = vec![vec![0.0; columns]; rows];
    let mut visitor = Visitor::<D, L>(walk, [tests, trials], matrix, std::marker::PhantomData);
    form.tangent(&mut visitor).unwrap_or_else(|never| match never {});
    visitor.2
}

/// Values at all points of all elements of a region, with their weights.
struct Evaluation<'a, const D: usize> {
    walk: Walk<'a, D>,
    /// A derived field has no region: these elements are used instead.
    region: Option<(Entity, &'a str)>,
    values: Vec<(f64, Vec<f64>)>,
}

impl<const D: usize> ExpressionVisitor<D> for Evaluation<'_, D> {
    type Error = Infallible;
    fn visit<K: ExpressionKernel<D>>(&mut self, integral: &Integral, kernel: &K) -> Result<(), Infallible> {
        let elements = match self.region {
            Some((entity, name)) => {
                self.walk.mesh.elements(entity, name).into_iter().map(Cow::Borrowed).collect()
            }
            None => self.walk.elements(integral),
        };
        for element in elements {
            let (element, batch) = (&*element, [&*element]);
            let constants = kernel.cell::<f64>(&cell(&batch));
            for point in 0..element.points.len() {
                let fields = self.walk.fields::<f64>(&K::REQUIREMENTS, &batch, point);
                let value = kernel.evaluate(&constants, &geometry(&batch, point), &fields);
                assert_eq!(value.as_ref().len(), K::SHAPE.iter().product::<usize>());
                self.values.push((element.points[point].geometry.weight, value.as_ref().to_vec()));
            }
        }
        Ok(())
    }
}

/// The value of a functional (or energy).
pub fn functional<F: Functional<D>, const D: usize>(mesh: &Mesh<D>, form: &F, unknowns: &[Nodal]) -> f64 {
    let walk = Walk { mesh, fields: form.fields(), inputs: form.inputs(), unknowns, directions: &[] };
    let mut evaluation = Evaluation { walk, region: None, values: vec![] };
    form.density(&mut evaluation).unwrap_or_else(|never| match never {});
    evaluation.values.iter().map(|(weight, value)| weight * value[0]).sum()
}

/// A derived field at all points of a region.
pub fn expression<F: Expression<D>, const D: usize>(
    mesh: &Mesh<D>,
    form: &F,
    region: (Entity, &str),
) -> Vec<Vec<f64>> {
    let walk = Walk { mesh, fields: form.fields(), inputs: form.inputs(), unknowns: &[], directions: &[] };
    let mut evaluation = Evaluation { walk, region: Some(region), values: vec![] };
    form.expression(&mut evaluation).unwrap_or_else(|never| match never {});
    evaluation.values.into_iter().map(|(_, value)| value).collect()
}

/// The switches of a form at all points of its regions.
pub fn switches<F: Form<D>, const D: usize>(mesh: &Mesh<D>, form: &F, unknowns: &[Nodal]) -> Vec<Vec<f64>> {
    let walk = Walk { mesh, fields: form.fields(), inputs: form.inputs(), unknowns, directions: &[] };
    let mut evaluation = Evaluation { walk, region: None, values: vec![] };
    form.switches(&mut evaluation).unwrap_or_else(|never| match never {});
    evaluation.values.into_iter().map(|(_, value)| value).collect()
}
