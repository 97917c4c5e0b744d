//! Inputs of kernels, gathered from the elements of a batch: geometry, basis functions, fields.

use std::borrow::Cow;

use forms_core::contract::*;

use super::mesh::{Element, Mesh, Point};
use super::{Nodal, rays};

/// Inputs of a walk: the mesh, the form's description, the unknowns' values.
pub struct Walk<'a, const D: usize> {
    pub mesh: &'a Mesh<D>,
    pub fields: &'a [FieldDescription],
    pub inputs: &'a Inputs<D>,
    pub unknowns: &'a [Nodal],
    /// Per unknown; read by actions.
    pub directions: &'a [Nodal],
}

/// Gathers one number per cell of a batch.
fn pack<L: Lane, const D: usize>(batch: &[&Element<D>], read: impl Fn(&Element<D>) -> f64) -> L {
    let mut values = [0.0; 8];
    for (lane, value) in values.iter_mut().enumerate().take(L::WIDTH) {
        *value = read(batch[lane.min(batch.len() - 1)]);
    }
    L::load(&values)
}

pub fn unpack<L: Lane>(value: L) -> [f64; 8] {
    let mut values = [0.0; 8];
    value.store(&mut values);
    values
}

pub fn cell<L: Lane, const D: usize>(batch: &[&Element<D>]) -> CellGeometry<L> {
    CellGeometry {
        diameter: pack(batch, |element| element.cell.diameter),
        cell_volume: pack(batch, |element| element.cell.cell_volume),
        facet_area: pack(batch, |element| element.cell.facet_area),
        opposite_diameter: pack(batch, |element| element.cell.opposite_diameter),
        opposite_volume: pack(batch, |element| element.cell.opposite_volume),
    }
}

pub fn geometry<L: Lane, const D: usize>(batch: &[&Element<D>], point: usize) -> PointGeometry<L, D> {
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

/// A basis function with its second derivatives and means, NaN where the kernel does not ask for them.
pub fn basis<L: Lane, const D: usize>(
    batch: &[&Element<D>],
    side: Side,
    point: usize,
    node: usize,
    requirements: &Requirements,
) -> (Basis<L, D>, Further<L, D>) {
    let read = |read: &dyn Fn(&Point<D>) -> f64| pack(batch, |element| read(&element.on(side).points[point]));
    let asked = |asked: bool, number: &dyn Fn(&Point<D>) -> f64| match asked {
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
    let hessian = std::array::from_fn(|a| std::array::from_fn(|b| second(a, b)));
    let average =
        |number: &dyn Fn(&Basis<f64, D>) -> f64| match requirements.test_mean || requirements.trial_mean {
            true => pack(batch, |element| number(&element.on(side).means[node])),
            false => L::splat(f64::NAN),
        };
    let mean = Basis {
        value: average(&|mean| mean.value),
        gradient: std::array::from_fn(|k| average(&|mean| mean.gradient[k])),
    };
    (basis, Further { hessian, mean })
}

impl<const D: usize> Walk<'_, D> {
    /// The batches of a region, [`Lane::WIDTH`] elements each.
    pub fn elements(&self, integral: &Integral) -> Vec<Cow<'_, Element<D>>> {
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
    pub fn fields<L: Lane>(
        &self,
        requirements: &Requirements,
        batch: &[&Element<D>],
        point: usize,
    ) -> Vec<L> {
        let mut data = vec![L::splat(f64::NAN); requirements.field_length];
        for slot in requirements.fields {
            let count = slot.components * D.pow(slot.order.axes() as u32);
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
                Order::MeanValue => element.means[node].value,
                Order::MeanGradient => element.means[node].gradient[entry % D],
            };
            let component = entry / D.pow(slot.order.axes() as u32);
            let nodes = element.nodes.iter().enumerate();
            nodes.map(|(i, node)| weight(i) * nodal.values[node * nodal.components + component]).sum()
        };
        match (self.fields[slot.field].role, &self.inputs.sources[slot.field]) {
            (Role::Unknown(number), None) => nodal(&self.unknowns[number]),
            (Role::Direction(number), None) => nodal(&self.directions[number]),
            (_, Some(Source::Discrete(field))) => {
                nodal(field.as_any().downcast_ref::<Nodal>().expect("a field of this backend"))
            }
            (_, Some(Source::Constant(values))) if slot.order.axes() == 0 => values[entry],
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
