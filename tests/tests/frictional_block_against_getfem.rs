//! A block whose parts stick or slip, against GetFEM 5.4.2 on the same meshes and quadrature rule, in three load steps
//! (`tests/getfem/frictional_block.json`, made by the script next to it).

use forms_contact::ContactProblem;
use forms_contact::forms;
use forms_contact::laws::frictional_nitsche as law;
use forms_fem::norms::norms;
use forms_fem::prelude::*;
use serde_json::Value;

const TOLERANCE: f64 = 1e-9;

fn number(value: &Value, name: &str) -> f64 {
    value[name].as_f64().unwrap_or_else(|| panic!("{name}"))
}

/// The block on `cells` cells along its height, on the flat y = −30.
fn block(file: &Value, run: &Value) -> ContactProblem<2, law::Model<2>> {
    let cells = number(run, "cells") as usize;
    let mesh = rectangle([0.0, -30.0], [2.0, -29.0], [2 * cells, cells], CellShape::Quadrilateral, 1);
    let space = Space::vector(&mesh.unwrap(), 2).unwrap();
    let (young, poisson) = (number(file, "young"), number(file, "poisson"));
    let base = forms::data()
        .lambda(young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)))
        .mu(young / (2.0 * (1.0 + poisson)))
        .gamma0(number(run, "gamma0_over_young") * young)
        .obstacle_normal([0.0, -1.0])
        .gap(|x: &[f64; 2]| x[1] + 30.0)
        .theta(number(run, "theta"))
        .criterion_force([0.0, -1.0]);
    let data = law::data_from(base)
        .slip_stress(run["tresca"].as_f64().unwrap_or(0.0))
        .friction(run["coulomb"].as_f64().unwrap_or(0.0))
        .force_direction([1.0, 0.0]);
    let regions = law::Regions::default().gamma_n("right").gamma_c("bottom");
    ContactProblem::new(&space, law::Model { data, regions }, Constraints::new(&space))
        .quadrature(Quadrature::Degree(8))
}

/// Whether both parts that stick and parts that slip were there.
fn compare(file: &Value, run: &Value) -> bool {
    let mut problem = block(file, run);
    let label = format!(
        "{} cells, theta = {}, gamma0 = {} E, {} {}",
        run["cells"], run["theta"], run["gamma0_over_young"], run["tresca"], run["coulomb"]
    );
    let check = |name: &str, value: f64, theirs: f64, scale: f64| {
        let error = (value - theirs).abs() / scale;
        println!("{label}: {name} {value} {theirs} {error:.1e}");
        assert!(error < TOLERANCE, "{label}: {name} = {value}, GetFEM has {theirs} ({error:.1e})");
    };
    let mut solver = CondensedSolver::default();
    let mut u = Field::zero(&problem.space);
    let mut both = false;
    for theirs in run["steps"].as_array().unwrap() {
        let push = [0, 1].map(|k| theirs["push"][k].as_f64().unwrap());
        problem.constraints = Constraints::new(&problem.space);
        problem.constraints.fix("top", |_| push).unwrap();
        problem.law.data.displacement_before = Given::field(&u);
        let solved = problem.from_stick().unwrap().start(&u).solver(&mut solver).solve();
        u = solved.unwrap_or_else(|error| panic!("{label}: {error}")).into_field();
        let (law, assembler) = (&problem.law, &problem.assembler);
        let norms = norms(assembler, &u).unwrap();
        let force = number(theirs, "contact_force");
        let of = |found: Result<f64, AssemblyError>| found.unwrap();
        let stick = of(assembler.functional(&law.stick_length(&u)));
        let slip = of(assembler.functional(&law.slip_length(&u)));
        let length = of(assembler.functional(&law.contact_length(&u)));
        both |= stick > 0.1 && slip > 0.1;
        check("contact_force", of(assembler.functional(&law.contact_force(&u))), force, force);
        let tangential = of(assembler.functional(&law.tangential_force(&u)));
        check("tangential_force", tangential, number(theirs, "tangential_force"), force);
        check("contact_length", length, number(theirs, "contact_length"), 2.0);
        check("stick_length", stick, number(theirs, "stick_length"), 2.0);
        check("slip_length", slip, number(theirs, "slip_length"), 2.0);
        for (name, value) in [("J", problem.criterion(&u).unwrap()), ("u_l2", norms.l2), ("u_h1", norms.h1)] {
            check(name, value, number(theirs, name), number(theirs, name).abs());
        }
    }
    let discrete = problem.adjoint(&u).unwrap().solver(&mut solver).solve().unwrap().into_field();
    let consistent = problem.state(problem.law.consistent_adjoint(&u), &u).unwrap();
    let consistent = consistent.solver(&mut solver).solve().unwrap().into_field();
    for (name, state) in [("discrete", discrete), ("consistent", consistent)] {
        let found = norms(&problem.assembler, &state).unwrap();
        for (norm, value) in [("l2", found.l2), ("h1", found.h1)] {
            let name = format!("p_{name}_{norm}");
            check(&name, value, number(run, &name), number(run, &name));
        }
    }
    both
}

#[test]
fn both_laws_agree_with_getfem_for_every_theta() {
    let file: Value = serde_json::from_str(include_str!("../getfem/frictional_block.json")).unwrap();
    let runs = file["runs"].as_array().unwrap();
    let both = runs.iter().filter(|run| compare(&file, run)).count();
    assert_eq!((runs.len(), both), (24, 24));
}
