//! The augmented Lagrangian with friction: layers with known answers, the tangent, and the method of multipliers by steps.

use forms_contact::laws::augmented_lagrangian::{augmented_lagrangian as law, multiplier_problem};
use forms_fem::prelude::*;

use crate::block::{Block, plane_block, solid_block};
use crate::layer::{Answer, Inside, Layer, plane_layers, quadratic_solid_layer};
use crate::setting::{Friction, LAMBDA, MU, YOUNG, check_tangent, data, wave};

fn model<const D: usize>(data: law::Data<D>) -> law::Model<D> {
    law::Model { data, regions: law::Regions::default().gamma_n("right").gamma_c("bottom") }
}

/// Multipliers that are constant on each facet have no nodes that the periodic condition would have to carry over.
fn layers<const D: usize>(layer: &Layer<D>)
where
    Dim: Dimension<D>,
{
    let pressure = (LAMBDA + 2.0 * MU) * 0.01;
    let bound = 0.3 * pressure;
    let multipliers = Space::discontinuous_vector_on_facets(&layer.mesh, "bottom", 0).unwrap();
    for friction in [Friction::Coulomb(0.3), Friction::Tresca(bound)] {
        let label = format!("{D}D, {friction:?}");
        let sticks = Answer { pressure, shear: 0.01 * MU, slip: 0.0 };
        let slips = Answer { pressure, shear: bound, slip: 0.02 - bound / MU };
        for (aside, answer) in [(0.01, sticks), (0.02, slips)] {
            let model = model(data(friction, 0.0, YOUNG));
            let constraints = layer.constraints(aside, 0.01);
            let assembler = Assembler::new(&layer.mesh).with_quadrature(Quadrature::Degree(4));
            let solved = multiplier_problem(&model, [&layer.space, &multipliers])
                .unwrap()
                .assembler(&assembler)
                .constrained(&constraints)
                .solve()
                .unwrap_or_else(|error| panic!("{label}: {error}"));
            let reaction = solved.reaction_of(0, "top").unwrap();
            let traction: Vec<f64> = reaction.iter().map(|force| force / layer.area()).collect();
            answer.check(&label, &traction, layer.slips(&solved.fields[0]), 1e-11);
            // λ is the traction on the body: p up, friction against the motion.
            for node in solved.fields[1].values().chunks(D) {
                assert!((node[D - 1] - pressure).abs() < 1e-10 * pressure, "{label}: {node:?}");
                assert!((node[0] + answer.shear).abs() < 1e-10 * pressure, "{label}: {node:?}");
            }
        }
    }
}

#[test]
fn a_layer_sticks_and_slips_as_known() {
    plane_layers(Inside::Distorted).iter().for_each(layers);
    layers(&quadratic_solid_layer());
}

#[test]
fn tangents_pass_their_taylor_test() {
    fn check<const D: usize>(block: &Block<D>)
    where
        Dim: Dimension<D>,
    {
        let multipliers = Space::vector_on_facets(&block.mesh, "bottom", 1).unwrap();
        let assembler = Assembler::new(&block.mesh).with_quadrature(Quadrature::Degree(4));
        for friction in [Friction::Coulomb(0.6), Friction::Tresca(20.0)] {
            let form = model(data(friction, 0.0, 10.0 * YOUNG)).direct();
            let unknowns = [wave(&block.space, 0.02, 0.4), wave(&multipliers, 20.0, 1.1)];
            let directions = [wave(&block.space, 0.02, 2.3), wave(&multipliers, 20.0, 0.3)];
            let label = format!("{D}D, {friction:?}");
            check_tangent(&label, &assembler, &form, &unknowns.each_ref(), &directions.each_ref());
        }
    }
    check(&plane_block(4));
    check(&solid_block());
}

/// A solution's displacements with λ = 0: the gap is closed to rounding, whose sign says which points touch, and the method comes
/// back to the same solution, stick, slip and lifted parts included.
#[test]
fn a_restart_without_the_multiplier_comes_back() {
    let block = plane_block(4);
    let spaces = [
        Space::discontinuous_vector_on_facets(&block.mesh, "bottom", 0).unwrap(),
        Space::vector_on_facets(&block.mesh, "bottom", 1).unwrap(),
    ];
    let mut constraints = Constraints::new(&block.space);
    constraints.fix("top", |x| [0.003, -0.01 + 0.012 * (x[0] - 1.0)]).unwrap();
    for multipliers in &spaces {
        for friction in [Friction::Coulomb(0.0), Friction::Coulomb(0.3), Friction::Tresca(0.5)] {
            for gamma0 in [YOUNG, 20.0 * YOUNG] {
                let form = model(data(friction, 0.0, gamma0)).direct();
                let solved = |start: [&Field<2>; 2]| {
                    let options =
                        NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
                    let mut problem = Problem::new(&form, [&block.space, multipliers])
                        .quadrature(Quadrature::Degree(4))
                        .constrained(&constraints)
                        .options(options)
                        .start(start);
                    problem.solve().unwrap_or_else(|error| panic!("{friction:?}, {gamma0}: {error}"))
                };
                let zero = Field::zero(multipliers);
                let first = solved([&Field::zero(&block.space), &zero]);
                let again = solved([&first.fields[0], &zero]);
                assert!(again.iterations() > 0);
                for (first, again) in first.fields.iter().zip(&again.fields) {
                    let size = first.values().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
                    for (a, b) in first.values().iter().zip(again.values()) {
                        assert!((a - b).abs() < 1e-8 * size, "{friction:?}, {gamma0}: {a} and {b}");
                    }
                }
            }
        }
    }
}

/// Multipliers that are nodes of their own on both ends of a periodic base are more than the displacements there determine.
#[test]
fn multipliers_that_displacements_do_not_determine_are_named() {
    let layer = &plane_layers(Inside::Alike)[0];
    let multipliers = Space::vector_on_facets(&layer.mesh, "bottom", 1).unwrap();
    let pressed = Field::interpolate(&multipliers, |_: &[f64; 2]| [0.0, 1.0]).unwrap();
    let form = model(data(Friction::Coulomb(0.3), 0.0, YOUNG)).direct();
    let constraints = layer.constraints(0.003, 0.01);
    let error = Problem::new(&form, [&layer.space, &multipliers])
        .assembler(Assembler::new(&layer.mesh).with_quadrature(Quadrature::Degree(4)))
        .constrained(&constraints)
        .start([&Field::zero(&layer.space), &pressed])
        .solve()
        .unwrap_err()
        .to_string();
    assert!(error.contains("singular: nothing determines component 0 of `multiplier` at ["), "{error}");
    assert!(error.contains("or the spaces do not"), "{error}");
}
