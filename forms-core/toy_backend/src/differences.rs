//! Tangents against differences of residuals, residuals against differences of energies.

use super::contract::{Energy, Form};

use super::mesh::Mesh;
use super::random::Random;
use super::{Nodal, action, energy, residual, tangent};

/// The unknowns, moved by step × direction.
fn moved(unknowns: &[Nodal], direction: &[f64], step: f64) -> Vec<Nodal> {
    let mut moved = unknowns.to_vec();
    let values = moved.iter_mut().flat_map(|field| &mut field.values);
    values.zip(direction).for_each(|(value, direction)| *value += step * direction);
    moved
}

fn unit(count: usize, index: usize) -> Vec<f64> {
    (0..count).map(|k| if k == index { 1.0 } else { 0.0 }).collect()
}

/// The tangent column by column against central differences of the residual, and by a Taylor test; the action against
/// the tangent.
pub fn check_tangent<const D: usize>(
    mesh: &Mesh<D>,
    form: &Form<D>,
    unknowns: &[Nodal],
    random: &mut Random,
) {
    let at = |unknowns: &[Nodal]| residual::<f64, D>(mesh, form, unknowns);
    let matrix = tangent::<f64, D>(mesh, form, unknowns);
    let scale = matrix.iter().flatten().fold(1.0_f64, |largest, entry| largest.max(entry.abs()));
    // Central differences, column by column: error h² f‴ / 6 + rounding / h.
    let (columns, step) = (matrix[0].len(), 1e-5);
    for column in 0..columns {
        let unit = unit(columns, column);
        let (above, below) = (at(&moved(unknowns, &unit, step)), at(&moved(unknowns, &unit, -step)));
        for row in 0..matrix.len() {
            let difference = (above[row] - below[row]) / (2.0 * step);
            let entry = matrix[row][column];
            assert!(
                (difference - entry).abs() <= 2e-8 * scale,
                "({row}, {column}): {entry}, by differences {difference}"
            );
        }
    }
    // Taylor: |R(u + t w) − R(u) − t K w| = O(t²), unless it is nothing but rounding.
    let direction: Vec<f64> = (0..columns).map(|_| random.number()).collect();
    let start = at(unknowns);
    let product = |row: &Vec<f64>| row.iter().zip(&direction).map(|(a, b)| a * b).sum::<f64>();
    let slope: Vec<f64> = matrix.iter().map(product).collect();
    // Without a matrix.
    let mut rest = &direction[..];
    let directions = unknowns.iter().map(|field| {
        let (values, others) = rest.split_at(field.values.len());
        rest = others;
        Nodal { components: field.components, values: values.to_vec() }
    });
    let directions: Vec<Nodal> = directions.collect();
    let found = action::<f64, D>(mesh, form, unknowns, &directions);
    for (row, (found, slope)) in found.iter().zip(&slope).enumerate() {
        let bound = 1e-14 * scale * columns as f64;
        assert!((found - slope).abs() <= bound, "action, row {row}: {found}, by the matrix {slope}");
    }
    let remainder = |step: f64| -> f64 {
        let moved = at(&moved(unknowns, &direction, step));
        let rows = moved.iter().zip(&start).zip(&slope);
        rows.map(|((moved, start), slope)| (moved - start - step * slope).powi(2)).sum::<f64>().sqrt()
    };
    let (first, second) = (remainder(1e-3), remainder(0.5e-3));
    let order = (first / second).log2();
    assert!(first <= 1e-14 * scale || order > 1.9, "order {order}: {first} then {second}");
}

/// The residual of an energy, entry by entry, against central differences of its value.
pub fn check_variation<const D: usize>(mesh: &Mesh<D>, form: &Energy<D>, unknowns: &[Nodal]) {
    let found = residual::<f64, D>(mesh, form, unknowns);
    let scale = found.iter().fold(1.0_f64, |largest, entry| largest.max(entry.abs()));
    for (index, found) in found.iter().enumerate() {
        let unit = unit(index + 1, index);
        let at = |step: f64| energy(mesh, form, &moved(unknowns, &unit, step));
        let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
        assert!((found - difference).abs() <= 1e-8 * scale, "{index}: {found}, by differences {difference}");
    }
}
