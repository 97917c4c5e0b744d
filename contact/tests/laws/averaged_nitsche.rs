//! F-bar on a flat: the patch test, tangents, adjoints, and one answer with the mixed forms.

use forms_contact::ContactProblem;
use forms_contact::laws::averaged_nitsche as law;
use forms_contact::laws::mixed_nitsche as mixed;
use forms_fem::prelude::*;

use crate::block::{Block, plane_block, solid_block};
use crate::rubber_block::{BULK, MU, data as of_mixed, layer_pressure, plane_pairs};
use crate::setting::{check_tangent, close, difference, wave};

/// Data with the scale of γ₀ that F-bar needs.
fn data<const D: usize>(bulk: f64, friction: f64, slip_stress: f64) -> mixed::Data<D> {
    let gamma0 = forms_contact::threshold::usual_gamma0(bulk - 2.0 / 3.0 * MU, MU);
    mixed::Data { gamma0, ..of_mixed(bulk, friction, slip_stress) }
}

fn model<const D: usize>(data: mixed::Data<D>) -> law::Model<D> {
    law::Model { data, regions: law::Regions::default().gamma_n("right").gamma_c("bottom") }
}

#[test]
fn tangents_and_adjoint_gradients() {
    fn check<const D: usize>(block: &Block<D>)
    where
        Dim: Dimension<D>,
    {
        for data in [data(BULK, 0.6, 0.0), data(BULK, 0.0, 20.0)] {
            let problem = block.problem(model(data), 0.0, 0.0);
            let (u, direction) = (wave(&block.space, 0.05, 0.4), wave(&block.space, 0.05, 2.3));
            let form = problem.law.direct();
            check_tangent(&format!("{D}D"), &problem.assembler, &form, &[&u], &[&direction]);
        }
        let solve = |friction: f64| {
            let problem = block.problem(model(data(BULK, friction, 0.0)), 0.03, 0.02);
            let solved = problem.from_stick().unwrap().solve().unwrap();
            (problem, solved.into_field())
        };
        let (problem, u) = solve(0.3);
        let p = problem.adjoint(&u).unwrap().solve().unwrap().into_field();
        let gradient = problem.assembler.functional(&problem.law.by_friction(&u, &p)).unwrap();
        let found = difference(6e-5, |change| {
            let (problem, u) = solve(0.3 + change);
            Ok((problem.criterion(&u)?, problem.assembler.active_set(&problem.law.direct(), &[&u])?))
        });
        close(&format!("{D}D"), gradient, found, 1e-7);
    }
    check(&plane_block(4));
    check(&solid_block());
}

/// One p per cell is the mean pressure of F-bar: the same u, and fewer steps where the body is nearly incompressible.
#[test]
fn a_pressure_per_cell_changes_nothing_but_the_steps() {
    let [pair, ..] = plane_pairs(4);
    let space = Space::vector(&pair.mesh, 1).unwrap();
    let cells = Space::of(&pair.mesh, Elements::Lagrange(0), Scope::Cell, &[]).unwrap();
    for (bulk, friction) in [(BULK, 0.0), (BULK, 0.3), (1000.0 * MU, 0.0)] {
        let law = model(of_mixed(bulk, friction, 0.0));
        let mut held = Constraints::new(&space);
        held.fix("top", |_| [0.001, -0.004]).unwrap();
        let [u, v] = [wave(&space, 0.05, 0.4), wave(&space, 0.05, 2.3)];
        let [p, q] = [0.3, 1.7].map(|phase| {
            Field::interpolate(&cells, |x: &[f64; 2]| 20.0 * (x[0] - x[1] + phase).sin()).unwrap()
        });
        let assembler = Assembler::new(&pair.mesh).with_quadrature(Quadrature::Degree(4));
        check_tangent("u, p", &assembler, &law.with_pressure(), &[&u, &p], &[&v, &q]);
        let with = law::averaged_problem(&law, [&space, &cells]).unwrap().assembler(&assembler);
        let with = with.constrained(&held).solve().unwrap();
        let problem = ContactProblem::new(&space, law, held.clone()).assembler(assembler);
        let without = problem.direct().unwrap().solve().unwrap();
        println!("K = {bulk}: {} steps and {}", with.iterations(), without.iterations());
        assert!(bulk < 10.0 * BULK || with.iterations() < without.iterations());
        let size = without.field().values().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        for (a, b) in with.fields[0].values().iter().zip(without.field().values()) {
            assert!((a - b).abs() < 1e-7 * size, "{a} and {b}");
        }
        let counts = with.report.as_ref().unwrap().local_unknowns.as_ref().unwrap();
        assert_eq!(counts.eliminated, pair.mesh.cell_count(), "{counts:?}");
    }
}

/// K multiplies the error of J after a step: whole ones turn a cell inside out.
#[test]
fn the_line_search_ends_where_whole_steps_fail() {
    let [pair, ..] = plane_pairs(8);
    let space = Space::vector(&pair.mesh, 1).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("top", |_| [0.0, -0.025]).unwrap();
    let problem = ContactProblem::new(&space, model(data(1000.0 * MU, 0.0, 0.0)), held);
    let problem = problem.quadrature(Quadrature::Degree(4));
    let searched = problem.direct().unwrap().solve().unwrap();
    let whole = problem.direct().unwrap().options(NewtonOptions::default()).solve();
    assert!(searched.iterations() < 40, "{}", searched.iterations());
    assert!(whole.is_err(), "{}", whole.unwrap().iterations());
}

/// F = diag(1, J) on bent cells.
#[test]
fn a_layer_has_one_pressure() {
    let [pair, ..] = plane_pairs(3);
    let space = Space::vector(&pair.mesh, 1).unwrap();
    for (bulk, down) in [(BULK, 0.1), (1000.0 * MU, 1e-2)] {
        let mut held = Constraints::new(&space);
        held.fix_component("top", 1, |_| -down).unwrap();
        held.fix_component("left", 0, |_| 0.0).unwrap();
        held.fix_component("right", 0, |_| 0.0).unwrap();
        let start = Field::interpolate(&space, |x| [0.0, -down * x[1]]).unwrap();
        let problem = ContactProblem::new(&space, model(data(bulk, 0.0, 0.0)), held);
        let problem = problem.quadrature(Quadrature::Degree(4));
        let solved = problem.direct().unwrap().start(&start).solve().unwrap();
        let per_length = solved.reaction("top").unwrap()[1] / 2.0;
        close("pressure", -per_length, layer_pressure(bulk, 1.0 - down), 1e-9);
    }
}

/// Forces of F-bar and Q2/P₋₁ on a block with ν = 0.4995 that is pressed by 5 %.
#[test]
fn forces_agree_with_those_of_the_mixed_form() {
    let bulk = 1000.0 * MU;
    let differences = [4, 8].map(|cells| {
        let [pair, ..] = plane_pairs(cells);
        let follow = LoadSteps::uniform(2, 0.05);
        let spaces = pair.spaces();
        let mut forces = [0.0; 2];
        let law = mixed::Model {
            data: of_mixed(bulk, 0.0, 0.0),
            regions: mixed::Regions::default().gamma_n("right").gamma_c("bottom"),
        };
        let path = follow.advance(spaces.map(Field::zero), |step| {
            let held = pair.pressed(0.0, step.factor);
            let problem = mixed::mixed_problem(&law, spaces).map_err(|error| error.to_string())?;
            let problem = problem.quadrature(Quadrature::Degree(4));
            let solved =
                problem.constrained(&held).increment(step).solve().map_err(|error| error.to_string())?;
            forces[0] = solved.reaction_of(0, "top").unwrap()[1];
            Ok::<_, String>(solved.fields)
        });
        path.unwrap();
        let space = Space::vector(&pair.mesh, 1).unwrap();
        let path = follow.advance(Field::zero(&space), |step| {
            let mut held = Constraints::new(&space);
            held.fix("top", |_| [0.0, -step.factor]).unwrap();
            let problem = ContactProblem::new(&space, model(data(bulk, 0.0, 0.0)), held);
            let problem = problem.quadrature(Quadrature::Degree(4));
            let solved =
                problem.direct().unwrap().increment(step).solve().map_err(|error| error.to_string())?;
            forces[1] = solved.reaction("top").unwrap()[1];
            Ok::<_, String>(solved.into_field())
        });
        path.unwrap();
        println!("{cells}: {forces:?}");
        (forces[1] / forces[0] - 1.0).abs()
    });
    println!("{differences:?}");
    assert!(differences[1] < 0.6 * differences[0] && differences[1] < 0.03, "{differences:?}");
}
