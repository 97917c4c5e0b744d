//! A backend of three hundred lines that knows nothing but the contract: linear or quadratic simplices,
//! dense matrices.
//!
//! Each test file uses a part of it.
#![allow(dead_code)]

pub mod differences;
pub mod interpolate;
pub mod lanes;
pub mod mesh;
pub mod plain;
pub mod random;
pub mod rays;

use std::any::Any;
use std::borrow::Cow;
use std::convert::Infallible;
use std::sync::Arc;

use forms_core::contract::*;
use mesh::{Element, Mesh};

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

/// Inputs of a walk: the mesh, the form's description, the unknowns' values.
struct Walk<'a, const D: usize> {
    mesh: &'a Mesh<D>,
    fields: &'static [FieldDescription],
    inputs: &'a Inputs<D>,
    unknowns: &'a [Nodal],
    /// Per unknown; read by actions.
    directions: &'a [Nodal],
}

/// Gathers one number per cell of a batch.
fn pack<L: Lane, const D: usize>(batch: &[&Element<D>], read: impl Fn(&Element<D>) -> f64) -> L {
    let mut values = [0.0; 8];
    for (lane, value) in values.iter_mut().enumerate().take(L::WIDTH) {
        *value = read(batch[lane.min(batch.len() - 1)]);
    }
    L::load(&values)
}

fn unpack<L: Lane>(value: L) -> [f64; 8] {
    let mut values = [0.0; 8];
    value.store(&mut values);
    values
}

fn cell<L: Lane, const D: usize>(batch: &[&Element<D>]) -> CellGeometry<L> {
    CellGeometry {
        diameter: pack(batch, |element| element.cell.diameter),
        cell_volume: pack(batch, |element| element.cell.cell_volume),
        facet_area: pack(batch, |element| element.cell.facet_area),
        opposite_diameter: pack(batch, |element| element.cell.opposite_diameter),
        opposite_volume: pack(batch, |element| element.cell.opposite_volume),
    }
}

fn geometry<L: Lane, const D: usize>(batch: &[&Element<D>], point: usize) -> PointGeometry<L, D> {
    PointGeometry {
        weight: pack(batch, |element| element.points[point].geometry.weight),
        position: std::array::from_fn(|k| pack(batch, |element| element.points[point].geometry.position[k])),
        normal: std::array::from_fn(|k| pack(batch, |element| element.points[point].geometry.normal[k])),
        curvature: pack(batch, |element| element.points[point].geometry.curvature),
        opposite: OppositePoint {
            gap: pack(batch, |element| element.points[point].geometry.opposite.gap),
            toward: std::array::from_fn(|k| {
                pack(batch, |element| element.points[point].geometry.opposite.toward[k])
            }),
            position: std::array::from_fn(|k| {
                pack(batch, |element| element.points[point].geometry.opposite.position[k])
            }),
            normal: std::array::from_fn(|k| {
                pack(batch, |element| element.points[point].geometry.opposite.normal[k])
            }),
            shape_operator: std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    pack(batch, |element| element.points[point].geometry.opposite.shape_operator[i][j])
                })
            }),
        },
    }
}

/// A basis function and its second derivatives, NaN where the kernel does not ask for them.
fn basis<L: Lane, const D: usize>(
    batch: &[&Element<D>],
    side: Side,
    point: usize,
    node: usize,
    requirements: &Requirements,
) -> (Basis<L, D>, Hessian<L, D>) {
    let read =
        |read: &dyn Fn(&mesh::Point<D>) -> f64| pack(batch, |element| read(&element.on(side).points[point]));
    let asked = |asked: bool, number: &dyn Fn(&mesh::Point<D>) -> f64| match asked {
        true => read(number),
        false => L::splat(f64::NAN),
    };
    let basis = Basis {
        value: asked(requirements.basis_value, &|point| point.basis[node].value),
        gradient: std::array::from_fn(|k| {
            asked(requirements.basis_gradient, &|point| point.basis[node].gradient[k])
        }),
    };
    let second = |a: usize, b: usize| asked(requirements.hessian, &|point| point.hessians[node][a][b]);
    (basis, std::array::from_fn(|a| std::array::from_fn(|b| second(a, b))))
}

impl<const D: usize> Walk<'_, D> {
    /// The batches of a region, [`Lane::WIDTH`] elements each.
    fn elements(&self, integral: &Integral) -> Vec<Cow<'_, Element<D>>> {
        let region = &self.inputs.regions[integral.region];
        let elements = self.mesh.elements(region.entity, &region.name);
        let Some(displacement) = integral.displacement else {
            return elements.into_iter().map(Cow::Borrowed).collect();
        };
        let fields: Vec<&Nodal> = displacement.iter().map(|field| self.nodal(*field)).collect();
        elements.into_iter().map(|pair| Cow::Owned(rays::slid(self.mesh, pair, &fields))).collect()
    }

    fn nodal(&self, field: usize) -> &Nodal {
        match (self.fields[field].role, &self.inputs.sources[field]) {
            (Role::Unknown(number), None) => &self.unknowns[number],
            (_, Some(Source::Discrete(field))) => {
                field.as_any().downcast_ref().expect("a field of this backend")
            }
            (role, _) => panic!("{role:?} displaces nothing"),
        }
    }

    /// The slice that a kernel reads at a point.
    fn fields<L: Lane>(&self, requirements: &Requirements, batch: &[&Element<D>], point: usize) -> Vec<L> {
        let mut data = vec![L::splat(f64::NAN); requirements.field_length];
        for slot in requirements.fields {
            let count = slot.components
                * match slot.order {
                    Order::Value => 1,
                    Order::Gradient => D,
                    Order::Hessian => D * D,
                };
            for entry in 0..count {
                data[slot.offset + entry] = pack(batch, |element| self.field(slot, element, point, entry));
            }
        }
        data
    }

    fn field(&self, slot: &FieldSlot, element: &Element<D>, point: usize, entry: usize) -> f64 {
        let element = element.on(slot.side);
        let point = &element.points[point];
        let nodal = |nodal: &Nodal| -> f64 {
            assert_eq!(nodal.components, slot.components, "{}", self.fields[slot.field].name);
            let weight = |node: usize| match slot.order {
                Order::Value => point.basis[node].value,
                Order::Gradient => point.basis[node].gradient[entry % D],
                Order::Hessian => point.hessians[node][entry / D % D][entry % D],
            };
            let component = match slot.order {
                Order::Value => entry,
                Order::Gradient => entry / D,
                Order::Hessian => entry / (D * D),
            };
            let nodes = element.nodes.iter().enumerate();
            nodes.map(|(i, node)| weight(i) * nodal.values[node * nodal.components + component]).sum()
        };
        match (self.fields[slot.field].role, &self.inputs.sources[slot.field]) {
            (Role::Unknown(number), None) => nodal(&self.unknowns[number]),
            (Role::Direction(number), None) => nodal(&self.directions[number]),
            (_, Some(Source::Discrete(field))) => {
                nodal(field.as_any().downcast_ref::<Nodal>().expect("a field of this backend"))
            }
            (_, Some(Source::Constant(values))) if slot.order == Order::Value => values[entry],
            (_, Some(Source::Constant(_))) => 0.0,
            (_, Some(Source::Function { components, function, .. })) if slot.order == Order::Value => {
                let mut values = vec![0.0; *components];
                function(&point.geometry.position, &mut values);
                values[entry]
            }
            (role, _) => panic!("{role:?} has no values"),
        }
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

/// The number that a functional (or energy) stands for.
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
