//! A wheel in several positions on flat ground: the ground that turns about the mesh compared with the mesh that turns, and one factor for
//! all positions.

use forms_contact::hollow_cylinder::{
    CONTACT, CONTACT_CELLS, CRITERION_FORCE, IMPOSED_DISPLACEMENT, INNER_RADIUS, OBSTACLE_DEPTH,
    OUTER_RADIUS, Settings, hollow_cylinder_on,
};
use forms_contact::rolling::{Ground, PositionNumbers};
use forms_contact::{ContactProblem, forms};
use forms_fem::prelude::*;

const SECTORS: usize = 12;

/// A ring whose facets of Γ_C face one of the grounds, those that may touch it "swept".
fn ring(around: usize, grounds: &[Ground]) -> Mesh<2> {
    let cells = [around / 16, around];
    let mut mesh =
        annulus(INNER_RADIUS, OUTER_RADIUS, cells[0], cells[1], CellShape::Quadrilateral, 2).unwrap();
    let nearest = |x: &[f64; 2]| grounds.iter().map(|ground| ground.gap(x)).fold(f64::MAX, f64::min);
    mesh.name_facets(CONTACT, "outer", |x| nearest(x) < OBSTACLE_DEPTH).unwrap();
    mesh.name_facets("swept", "outer", |x| nearest(x) < 1.2).unwrap();
    mesh.name_cells_of_facets(CONTACT_CELLS, CONTACT).unwrap();
    mesh
}

fn settings(theta: f64) -> Settings {
    Settings { theta, ..Settings::default() }
}

/// The problem of a position on the mesh of the first one.
fn position(mesh: &Mesh<2>, theta: f64, ground: &Ground) -> ContactProblem<2> {
    let first = hollow_cylinder_on(mesh, &settings(theta)).unwrap();
    let mut held = Constraints::new(&first.space);
    held.fix("inner", |_| ground.seen(IMPOSED_DISPLACEMENT)).unwrap();
    let law = ground.law(&first.law, CRITERION_FORCE);
    ContactProblem::new(&first.space, law, held).assembler(first.assembler)
}

fn numbers(problem: &ContactProblem<2>, u: &Field<2>) -> [f64; 3] {
    let PositionNumbers { work, reaction, square } =
        PositionNumbers::of(&problem.law, &problem.assembler, u).unwrap();
    [work, reaction, square]
}

#[test]
fn turned_ground_is_a_turned_wheel() {
    let ground = Ground { angle: 0.11, distance: OBSTACLE_DEPTH };
    let mesh = ring(64, &[ground]);
    let back = Ground { angle: -ground.angle, ..ground };
    let turned = mesh.with_nodes(mesh.nodes().iter().map(|x| back.seen(*x)).collect()).unwrap();
    for theta in [0.0, -1.0, 1.0] {
        let of_ground = position(&mesh, theta, &ground);
        // The paper's own problem, with the ground below.
        let of_wheel = hollow_cylinder_on(&turned, &settings(theta)).unwrap();
        let [u, other] =
            [&of_ground, &of_wheel].map(|problem| problem.direct().unwrap().solve().unwrap().into_field());
        for (here, there) in numbers(&of_ground, &u).iter().zip(numbers(&of_wheel, &other)) {
            assert!((here / there - 1.0).abs() < 1e-10, "θ = {theta}: {here} {there}");
        }
        for (here, there) in u.values().chunks_exact(2).zip(other.values().chunks_exact(2)) {
            let seen = ground.seen([there[0], there[1]]);
            assert!((here[0] - seen[0]).hypot(here[1] - seen[1]) < 1e-11);
        }
    }
}

/// Direct and adjoint problems of four positions, and the number of factors that a solver made for them.
fn in_turn(theta: f64, expects: bool) -> (Vec<Field<2>>, usize) {
    let grounds = Ground::in_sector(OBSTACLE_DEPTH, SECTORS, 4);
    let mesh = ring(96, &grounds);
    let mut solver = CondensedSolver::default();
    let mut states = vec![];
    let problems: Vec<_> = grounds.iter().map(|ground| position(&mesh, theta, ground)).collect();
    for problem in &problems {
        let direct = problem.direct().unwrap();
        let direct = if expects { direct.expecting_changes_at("swept") } else { direct };
        states.push(direct.solver(&mut solver).solve().unwrap().into_field());
    }
    let weights = PositionNumbers { work: 1.0, reaction: -0.2, square: 0.3 };
    for (problem, u) in problems.iter().zip(states.clone()) {
        let adjoint: Form<2> = weights.adjoint(&problem.law, &u);
        states.push(problem.state(adjoint, &u).unwrap().solver(&mut solver).solve().unwrap().into_field());
    }
    (states, solver.report().factorisations)
}

#[test]
fn positions_share_one_factor() {
    let (shared, factors) = in_turn(0.0, true);
    assert_eq!(factors, 1);
    // Without a word on it, the factor of the first position does not serve the others.
    let (by_growth, factors) = in_turn(0.0, false);
    assert!(factors > 1, "{factors}");
    for (one, other) in shared.iter().zip(&by_growth) {
        let most = one.values().iter().zip(other.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let scale = one.values().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        assert!(most < 1e-11 * scale, "{most:e} of {scale}");
    }
    // The linear part has the normal of the position in it.
    assert!(in_turn(-1.0, true).1 >= 4);
}

/// Expectations that name no facets are errors, and so large ones that a factor for them does not pay are left aside.
#[test]
fn expectations_are_names_and_guesses() {
    let ground = Ground { angle: 0.0, distance: OBSTACLE_DEPTH };
    let problem = position(&ring(64, &[ground]), 0.0, &ground);
    let solve = |facets: &'static str| {
        let mut solver = CondensedSolver::default();
        let direct = problem.direct().unwrap().expecting_changes_at(facets);
        let found = direct.solver(&mut solver).solve().map(Solved::into_field);
        found.map(|u| (u, solver.report()))
    };
    let message = solve("tread").err().map(|error| error.to_string()).unwrap_or_default();
    assert!(message.contains("tread") && message.contains("swept"), "{message}");
    let [(few, of_few), (all, of_all)] = ["swept", "boundary"].map(|facets| solve(facets).unwrap());
    assert!(of_few.condensed_unknowns.is_some() && of_all.condensed_unknowns.is_some());
    let most = few.values().iter().zip(all.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(most < 1e-12, "{most:e}");
}

/// The law of a position has the paper's numbers where the ground is below.
#[test]
fn the_first_position_is_the_papers() {
    let ground = Ground { angle: 0.0, distance: OBSTACLE_DEPTH };
    let mesh = ring(64, &[ground]);
    let paper = hollow_cylinder_on(&mesh, &settings(-1.0)).unwrap();
    let u = Field::interpolate(&paper.space, |x| [0.01 * x[1], -0.9]).unwrap();
    let law: forms::Model<2> = ground.law(&paper.law, CRITERION_FORCE);
    let same =
        ContactProblem::new(&paper.space, law, paper.constraints.clone()).assembler(paper.assembler.clone());
    assert_eq!(numbers(&same, &u), numbers(&paper, &u));
}
