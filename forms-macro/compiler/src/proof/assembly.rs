//! A backend of one cell: calls the interpreted kernels in the contract's order.
//!
//! What a kernel does not require is NaN, so that reading it shows.

use super::emitted::Kernel;
use super::interpreter::Value;
use crate::reference::{Jet, MEAN, Point};

/// The points of a cell, each with its quadrature weight.
pub type Points = [(f64, Point)];

/// A scalar basis function at each of the points.
pub type Basis = [Jet];

fn requirement(kernel: &Kernel, name: &str, value: f64) -> f64 {
    if reads(kernel, name) { value } else { f64::NAN }
}

/// Does a kernel ask for a quantity? What its requirements do not name is as in `Requirements::NONE`.
pub fn reads(kernel: &Kernel, name: &str) -> bool {
    match &kernel.constants["REQUIREMENTS"] {
        Value::Structure(members) => members.get(name).is_some_and(Value::truth),
        other => panic!("{other:?} are no requirements"),
    }
}

fn cell_geometry(kernel: &Kernel, point: &Point) -> Value {
    let number = |name: &str, value: f64| Value::Number(requirement(kernel, name, value));
    Value::structure([
        ("diameter", number("diameter", point.diameter[0])),
        ("cell_volume", number("cell_volume", point.cell_volume[0])),
        ("facet_area", number("facet_area", point.facet_area)),
        ("opposite_diameter", number("opposite_diameter", point.diameter[1])),
        ("opposite_volume", number("opposite_volume", point.cell_volume[1])),
    ])
}

fn point_geometry(kernel: &Kernel, (weight, point): &(f64, Point)) -> Value {
    let numbers = |name: &str, values: &[f64]| {
        Value::numbers(values.iter().map(|value| requirement(kernel, name, *value)))
    };
    Value::structure([
        ("weight", Value::Number(*weight)),
        ("position", numbers("position", &point.position)),
        ("normal", numbers("normal", &point.normal)),
        ("curvature", Value::Number(requirement(kernel, "curvature", point.curvature))),
    ])
}

/// The slice of field data, as the kernel's slots lay it out.
fn fields(kernel: &Kernel, point: &Point) -> Value {
    let requirements = &kernel.constants["REQUIREMENTS"];
    let mut fields = vec![f64::NAN; requirements.member("field_length").index()];
    for slot in requirements.member("fields").list() {
        let side = match slot.member("side").word() {
            "This" => 0,
            "Other" => 1,
            other => panic!("the slot's side is {other}"),
        };
        let jet = &point.fields[side][slot.member("field").index()];
        let order = match slot.member("order").word() {
            "Value" => 0,
            "Gradient" => 1,
            "Hessian" => 2,
            "MeanValue" => MEAN,
            "MeanGradient" => MEAN + 1,
            other => panic!("the slot's order is {other}"),
        };
        assert_eq!(jet[0].len(), slot.member("components").index(), "the components of a slot");
        let start = slot.member("offset").index();
        fields[start..start + jet[order].len()].copy_from_slice(&jet[order]);
    }
    Value::numbers(fields)
}

fn basis(kernel: &Kernel, jet: &Jet) -> [Value; 2] {
    let dimension = jet[1].len();
    let hessian = jet[2].chunks(dimension);
    let hessian =
        hessian.map(|row| Value::numbers(row.iter().map(|entry| requirement(kernel, "hessian", *entry))));
    let basis = Value::structure([
        ("value", Value::Number(requirement(kernel, "basis_value", jet[0][0]))),
        (
            "gradient",
            Value::numbers(jet[1].iter().map(|entry| requirement(kernel, "basis_gradient", *entry))),
        ),
    ]);
    let mean = |numbers: &[f64]| {
        let asked = reads(kernel, "test_mean") || reads(kernel, "trial_mean");
        numbers.iter().map(|number| if asked { *number } else { f64::NAN }).collect::<Vec<_>>()
    };
    let mean = Value::structure([
        ("value", Value::Number(mean(&jet[MEAN])[0])),
        ("gradient", Value::numbers(mean(&jet[MEAN + 1]))),
    ]);
    [basis, Value::structure([("hessian", Value::List(hessian.collect())), ("mean", mean)])]
}

/// All parameters in a row.
fn parameters(points: &Points) -> Vec<f64> {
    points[0].1.parameters.concat()
}

fn result(kernel: &Kernel, method: &str, prepared: &Value, arguments: &[Value]) -> Value {
    kernel.call(method, Some(prepared), arguments).0.unwrap_or_else(|| panic!("`{method}` gives nothing"))
}

/// Σ over the points of a linear kernel, for one test node: its components.
pub fn linear(kernel: &Kernel, points: &Points, test: &Basis) -> Vec<f64> {
    let prepared = kernel.prepare(&parameters(points));
    let cell = result(kernel, "cell", &prepared, &[cell_geometry(kernel, &points[0].1)]);
    let mut block = vec![0.0; kernel.constants["TEST_COMPONENTS"].index()];
    for (point, jet) in points.iter().zip(test) {
        let data = [cell.clone(), point_geometry(kernel, point), fields(kernel, &point.1)];
        let flux = result(kernel, "point", &prepared, &data);
        let [basis, further] = basis(kernel, jet);
        let share = result(kernel, "test", &prepared, &[flux, basis, further]).to_numbers();
        assert_eq!(share.len(), block.len(), "the components of a test node");
        block.iter_mut().zip(share).for_each(|(sum, share)| *sum += share);
    }
    block
}

/// A bilinear kernel's block of a test node and a trial node, row-major.
pub fn bilinear(kernel: &Kernel, points: &Points, test: &Basis, trial: &Basis) -> Vec<f64> {
    let prepared = kernel.prepare(&parameters(points));
    let cell = result(kernel, "cell", &prepared, &[cell_geometry(kernel, &points[0].1)]);
    let mut accumulator = kernel.call("zero", None, &[]).0.expect("an accumulator");
    for (index, point) in points.iter().enumerate() {
        let data = [cell.clone(), point_geometry(kernel, point), fields(kernel, &point.1)];
        let data = result(kernel, "point", &prepared, &data);
        let side = |method: &str, jet: &Jet| {
            let [basis, further] = basis(kernel, jet);
            result(kernel, method, &prepared, &[data.clone(), basis, further])
        };
        let sides = [accumulator, side("test", &test[index]), side("trial", &trial[index])];
        let (_, mut scope) = kernel.call("pair", None, &sides);
        accumulator = scope.remove("accumulator").expect("an accumulator");
    }
    result(kernel, "finish", &prepared, &[cell, accumulator]).to_numbers()
}

/// An expression kernel's value at each point.
pub fn expression(kernel: &Kernel, points: &Points) -> Vec<Vec<f64>> {
    let prepared = kernel.prepare(&parameters(points));
    let cell = result(kernel, "cell", &prepared, &[cell_geometry(kernel, &points[0].1)]);
    let at = |point: &(f64, Point)| {
        let data = [cell.clone(), point_geometry(kernel, point), fields(kernel, &point.1)];
        result(kernel, "evaluate", &prepared, &data).to_numbers()
    };
    points.iter().map(at).collect()
}
