//! Checks that hold for any displacement and any multipliers: forces and moments cancel, and tangents are those of the residual.

use forms_fem::prelude::*;
use forms_fem::verification;

/// The space of multipliers of a degree on the own surface, with one or several components.
pub fn multipliers<const D: usize>(
    mesh: &Mesh<D>,
    own: &str,
    degree: usize,
    shape: &[usize],
) -> Arc<Space<D>> {
    Space::of(mesh, Elements::Bernstein(degree), Scope::Facets(own.to_owned()), shape).unwrap()
}

/// A space of dual multipliers.
pub fn dual<const D: usize>(mesh: &Mesh<D>, own: &str, shape: &[usize]) -> Arc<Space<D>> {
    Space::of(mesh, Elements::Dual, Scope::Facets(own.to_owned()), shape).unwrap()
}

/// Coefficients by the positions of the nodes.
pub fn nodal<const D: usize, const N: usize>(
    space: &Arc<Space<D>>,
    value: impl Fn(&[f64; D]) -> [f64; N],
) -> Field<D> {
    Field::from_values(space, space.positions().iter().flat_map(value).collect()).unwrap()
}

/// The largest component of the sum of forces and of that of their moments, relative to the sum of the forces' sizes.
pub fn resultants<const D: usize>(form: &Form<D>, at: [&Field<D>; 3]) -> [f64; 2]
where
    Dim: Dimension<D>,
{
    let (spaces, u) = (at.map(Field::space), at[0]);
    let residual = Assembler::new(u.space().mesh()).residual(form, &at, &spaces).unwrap();
    let residual = &residual[..u.space().unknowns()];
    let scale: f64 = residual.iter().map(|entry| entry.abs()).sum();
    assert!(scale > 1.0, "{scale}");
    let (mut force, mut moment) = ([0.0; D], [[0.0; D]; D]);
    for (node, own) in residual.chunks_exact(D).enumerate() {
        let (x, u) = (u.space().positions()[node], u.at_node(node));
        for k in 0..D {
            force[k] += own[k];
            for l in 0..k {
                moment[k][l] += (x[k] + u[k]) * own[l] - (x[l] + u[l]) * own[k];
            }
        }
    }
    let largest = |values: &[f64]| values.iter().fold(0.0_f64, |most, value| most.max(value.abs())) / scale;
    [largest(&force), largest(moment.as_flattened())]
}

/// Order 2 of the residual's remainder along a direction.
pub fn check_tangent<const D: usize>(form: &Form<D>, at: [&Field<D>; 3], along: [&Field<D>; 3], name: &str)
where
    Dim: Dimension<D>,
{
    let assembler = Assembler::new(at[0].space().mesh());
    let report = verification::tangent(&assembler, form, &at, &along, 1e-4).unwrap();
    let order = report.second_order().unwrap();
    assert!((order - 2.0).abs() < 0.05, "{name}: {report}");
}
