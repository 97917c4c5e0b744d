//! A backend of a thousand lines that knows nothing but the contract: linear or quadratic simplices, dense matrices. The
//! operators of the language are tested on it.

pub mod contract;
pub mod differences;
pub mod interpolate;
mod kernels;
pub mod lanes;
pub mod mesh;
pub mod operator;
pub mod plain;
pub mod random;
pub mod rays;
mod walk;

use std::any::Any;
use std::borrow::Cow;
use std::sync::Arc;

use contract::*;
pub use kernels::Lanes;
use kernels::{Values, Vectors};
use mesh::{Element, Mesh};
use walk::Walk;

/// Nodal values of a field, node by node: the field data of this backend.
#[derive(Clone, Debug)]
pub struct Nodal {
    pub components: usize,
    pub values: Vec<f64>,
}

/// A mesh of quadratic simplices, and a random vector and scalar on it.
pub fn quadratic_state<const D: usize>(random: &mut random::Random) -> (Mesh<D>, [Nodal; 2]) {
    let mesh = Mesh::quadratic_cube(random);
    let nodes = mesh.nodes.len();
    let unknowns = [random.field(nodes, D, 0.1, 0.1), random.field(nodes, 1, 0.15, 0.2)];
    (mesh, unknowns)
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
pub fn residual<L: Lanes, const D: usize>(mesh: &Mesh<D>, form: &Form<D>, unknowns: &[Nodal]) -> Vec<f64> {
    vector::<L, D>(mesh, form, form.residual(), unknowns, &[])
}

/// ∂R/∂u w by lane type `L`, without a matrix.
pub fn action<L: Lanes, const D: usize>(
    mesh: &Mesh<D>,
    form: &Form<D>,
    unknowns: &[Nodal],
    directions: &[Nodal],
) -> Vec<f64> {
    vector::<L, D>(mesh, form, form.action(), unknowns, directions)
}

/// The residual, or the action on directions.
fn vector<L: Lanes, const D: usize>(
    mesh: &Mesh<D>,
    form: &Form<D>,
    terms: &[Term<Box<dyn Vectors<D>>>],
    unknowns: &[Nodal],
    directions: &[Nodal],
) -> Vec<f64> {
    let (tests, size) = layout(form.fields(), mesh.nodes.len(), true);
    let walk = Walk { mesh, fields: form.fields(), inputs: form.inputs(), unknowns, directions };
    let mut vector = vec![0.0; size];
    for Term { integral, kernel } in terms {
        let elements = walk.elements(integral);
        let elements: Vec<&Element<D>> = elements.iter().map(|element| &**element).collect();
        L::add_vectors(&**kernel, (&walk, integral), &elements, tests[integral.test], &mut vector);
    }
    vector
}

/// ∂R/∂u by lane type `L`, dense, row by row. Symmetric integrals compute pairs i ≤ j only.
pub fn tangent<L: Lanes, const D: usize>(
    mesh: &Mesh<D>,
    form: &Form<D>,
    unknowns: &[Nodal],
) -> Vec<Vec<f64>> {
    let (tests, rows) = layout(form.fields(), mesh.nodes.len(), true);
    let (trials, columns) = layout(form.fields(), mesh.nodes.len(), false);
    let walk = Walk { mesh, fields: form.fields(), inputs: form.inputs(), unknowns, directions: &[] };
    let mut matrix = vec![vec![0.0; columns]; rows];
    for Term { integral, kernel } in form.tangent() {
        let elements = walk.elements(integral);
        let elements: Vec<&Element<D>> = elements.iter().map(|element| &**element).collect();
        let places = [tests[integral.test], trials[integral.trial]];
        L::add_matrices(&**kernel, (&walk, integral), &elements, places, &mut matrix);
    }
    matrix
}

/// Values at all points of some elements, with their weights.
fn values<const D: usize>(
    walk: &Walk<D>,
    kernel: &dyn Values<D>,
    elements: Vec<Cow<Element<D>>>,
) -> Vec<(f64, Vec<f64>)> {
    elements.iter().flat_map(|element| kernel.values(walk, element)).collect()
}

/// Values of densities or switches at all points of their regions.
fn all_values<const D: usize>(
    mesh: &Mesh<D>,
    function: &Function<D, kernels::Dense>,
    terms: &[Term<Box<dyn Values<D>>>],
    unknowns: &[Nodal],
) -> Vec<(f64, Vec<f64>)> {
    let walk = Walk { mesh, fields: function.fields(), inputs: function.inputs(), unknowns, directions: &[] };
    let found = terms.iter().map(|term| values(&walk, &*term.kernel, walk.elements(term.integral)));
    found.flatten().collect()
}

/// The value of a functional.
pub fn functional<const D: usize>(mesh: &Mesh<D>, functional: &Functional<D>) -> f64 {
    sum(all_values(mesh, functional, functional.densities(), &[]))
}

/// The value of an energy.
pub fn energy<const D: usize>(mesh: &Mesh<D>, energy: &Energy<D>, unknowns: &[Nodal]) -> f64 {
    sum(all_values(mesh, energy, energy.densities(), unknowns))
}

fn sum(values: Vec<(f64, Vec<f64>)>) -> f64 {
    values.iter().map(|(weight, value)| weight * value[0]).sum()
}

/// A derived field at all points of a region.
pub fn expression<const D: usize>(
    mesh: &Mesh<D>,
    expression: &Expression<D>,
    (entity, name): (Entity, &str),
) -> Vec<Vec<f64>> {
    let (fields, inputs) = (expression.fields(), expression.inputs());
    let walk = Walk { mesh, fields, inputs, unknowns: &[], directions: &[] };
    let elements = || mesh.elements(entity, name).into_iter().map(Cow::Borrowed).collect();
    let found = expression.densities().iter().flat_map(|term| values(&walk, &*term.kernel, elements()));
    found.map(|(_, value)| value).collect()
}

/// The switches of a form at all points of its regions.
pub fn switches<const D: usize>(mesh: &Mesh<D>, form: &Form<D>, unknowns: &[Nodal]) -> Vec<Vec<f64>> {
    let found = all_values(mesh, form, form.switches(), unknowns);
    found.into_iter().map(|(_, value)| value).collect()
}
