//! The augmented Lagrangian with friction: layers with known answers, the tangent, and the method of multipliers by steps.

use forms_contact::laws::augmented_lagrangian::augmented_lagrangian as law;
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
            let form = model(data(friction, 0.0, YOUNG)).direct();
            let constraints = layer.constraints(aside, 0.01);
            let assembler = Assembler::new(&layer.mesh).with_quadrature(Quadrature::Degree(4));
            let options = NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
            let solved = Problem::new(&form, [&layer.space, &multipliers])
                .assembler(&assembler)
                .constrained(&constraints)
                .options(options)
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

#[test]
fn scratch_restart() {
    let block = plane_block(4);
    for degree in [0usize, 1] {
        let multipliers = if degree == 0 {
            Space::discontinuous_vector_on_facets(&block.mesh, "bottom", 0).unwrap()
        } else {
            Space::vector_on_facets(&block.mesh, "bottom", 1).unwrap()
        };
        for friction in [Friction::Coulomb(0.0), Friction::Coulomb(0.3), Friction::Tresca(0.5)] {
            for gamma0 in [YOUNG, 20.0 * YOUNG] {
                for aside in [0.0, 0.003] {
                    let form = model(data(friction, 0.0, gamma0)).direct();
                    let mut constraints = Constraints::new(&block.space);
                    constraints.fix("top", |_| [aside, -0.01]).unwrap();
                    let assembler = Assembler::new(&block.mesh).with_quadrature(Quadrature::Degree(4));
                    let options =
                        NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
                    let mut problem = Problem::new(&form, [&block.space, &multipliers])
                        .assembler(&assembler)
                        .constrained(&constraints)
                        .options(options.clone());
                    let label = format!("degree {degree}, {friction:?}, {gamma0}, {aside}");
                    let solved = problem.solve().unwrap();
                    let zero = Field::zero(&multipliers);
                    let mut problem = Problem::new(&form, [&block.space, &multipliers])
                        .assembler(&assembler)
                        .constrained(&constraints)
                        .options(options.clone())
                        .start([&solved.fields[0], &zero]);
                    match problem.solve() {
                        Ok(again) => {
                            println!("{label}: {} then {} steps", solved.iterations(), again.iterations())
                        }
                        Err(error) => println!("{label}: {} then {error:?}", solved.iterations()),
                    }
                }
            }
        }
    }
}
