//! Reactions of constraints: closed forms, equilibrium, related unknowns.

use forms_fem::prelude::*;
use forms_fem::solve::{Elimination, Start, newton_eliminating};

#[forms(dimension = 2)]
mod held {
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Loaded;

    pub struct Data {
        load: Given<Vector>,
        weight: Given<Vector>,
    }

    /// λ = μ = 1: E = 5/2, ν = 1/4.
    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, 2 * inner(eps(u), eps(v)) + div(u) * div(v) - dot(weight, v))
            - integral(Loaded, dot(load, v))
    }
    pub fn both(t: Unknown<Scalar>, u: Unknown<Vector>, s: Test<Scalar>, v: Test<Vector>) -> Form {
        integral(Omega, dot(grad(t), grad(s)) + 2 * inner(eps(u), eps(v)) + div(u) * div(v))
    }
}

const WIDTH: f64 = 2.0;
const HEIGHT: f64 = 0.5;

fn block(map: impl Fn([f64; 2]) -> [f64; 2]) -> Mesh<2> {
    let scaled = |[s, t]: [f64; 2]| map([WIDTH * s, HEIGHT * t]);
    forms_fem::mesh::structured([5, 3], CellShape::Quadrilateral, 1, scaled).unwrap()
}

fn data(load: [f64; 2], weight: [f64; 2]) -> held::Data<2> {
    held::data().load(load).weight(weight)
}

fn solve(
    data: &held::Data<2>,
    loaded: &str,
    space: &Arc<Space<2>>,
    constraints: &Constraints<2>,
) -> Result<forms_fem::solve::Solved<2>, Box<dyn std::error::Error>> {
    let form = held::elasticity(data, &held::Omega::on("all"), &held::Loaded::on(loaded));
    // The form is affine: Newton's method is also run on its equations.
    let solved = Problem::new(&form, space).constrained(constraints).solve()?;
    let elimination = Elimination::of(&[constraints])?;
    let (start, mut solver) = (Start::at(vec![0.0; space.unknowns()]), TangentSolver::default());
    let (options, mut equations) = (NewtonOptions::default(), Problem::new(&form, space));
    let iterated =
        newton_eliminating(&mut equations, elimination, start, &mut solver, &options, &mut |_| ())?;
    close(&iterated.residual, &solved.residual);
    Ok(solved)
}

fn close(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-10, "{found} is not {expected}");
    }
}

/// Pulled up by δ between smooth plates the block has the stress E/(1 − ν²) δ/H everywhere.
#[test]
fn a_pulled_block_gives_the_stress_times_the_area() {
    const PULL: f64 = 0.03;
    let space = Space::vector(&block(|x| x), 2).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.fix_component("left", 0, |_| 0.0).unwrap();
    constraints.fix_component("bottom", 1, |_| 0.0).unwrap();
    constraints.fix_component("top", 1, |_| PULL).unwrap();
    let solved = solve(&data([0.0; 2], [0.0; 2]), "right", &space, &constraints).unwrap();
    let force = 2.5 / (1.0 - 0.25 * 0.25) * PULL / HEIGHT * WIDTH;
    close(&solved.reaction("top").unwrap(), &[0.0, force]);
    close(&solved.reaction("bottom").unwrap(), &[0.0, -force]);
    close(&solved.reaction("all").unwrap(), &[0.0, 0.0]);
    let error = solved.reaction("lid").unwrap_err().to_string();
    assert!(error.contains("there is no region \"lid\""), "{error}");
}

/// Loads on the held region itself count too.
#[test]
fn supports_balance_loads() {
    let space = Space::vector(&block(|x| x), 2).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.fix("left", |_| [0.0; 2]).unwrap();
    for loaded in ["right", "top", "boundary"] {
        let solved = solve(&data([0.3, -0.2], [0.1, -1.0]), loaded, &space, &constraints).unwrap();
        let length = match loaded {
            "right" => HEIGHT,
            "top" => WIDTH,
            _ => 2.0 * (WIDTH + HEIGHT),
        };
        let area = WIDTH * HEIGHT;
        close(&solved.reaction("left").unwrap(), &[-0.3 * length - 0.1 * area, 0.2 * length + area]);
    }
}

/// A turned block slides along two of its sides: each unknown that slides is given by another, and the forces of the
/// plates are normal to them.
#[test]
fn what_relates_unknowns_holds_too() {
    let (sin, cos) = 0.4_f64.sin_cos();
    let turn = |x: [f64; 2]| [cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]];
    let space = Space::vector(&block(turn), 2).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.slide("left", |_| turn([-1.0, 0.0]), |_| 0.0).unwrap();
    constraints.slide("bottom", |_| turn([0.0, -1.0]), |_| 0.0).unwrap();
    let solved = solve(&data(turn([0.7, 0.0]), [0.0; 2]), "right", &space, &constraints).unwrap();
    close(&solved.reaction("left").unwrap(), &turn([-0.7 * HEIGHT, 0.0]));
    close(&solved.reaction("all").unwrap(), &turn([-0.7 * HEIGHT, 0.0]));
    // Of the quadratic facets' consistent forces a sixth of the first one's acts on the corner, which is the bottom's too.
    close(&solved.reaction("bottom").unwrap(), &turn([-0.7 * HEIGHT / 3.0 / 6.0, 0.0]));
    // A side that moves as a rigid body: what keeps it rigid has no resultant, and the support bears the load.
    let mut constraints = Constraints::new(&space);
    constraints.fix("left", |_| [0.0; 2]).unwrap();
    constraints.rigid_body("right").unwrap();
    let solved = solve(&data([0.7, -0.1], [0.0; 2]), "right", &space, &constraints).unwrap();
    close(&solved.reaction("right").unwrap(), &[0.0, 0.0]);
    close(&solved.reaction("left").unwrap(), &[-0.7 * HEIGHT, 0.1 * HEIGHT]);
}

/// Of several unknowns each has its reactions: of a temperature, the heat that flows in.
#[test]
fn each_unknown_has_its_reactions() {
    let mesh = block(|x| x);
    let (temperatures, displacements) = (Space::scalar(&mesh, 2).unwrap(), Space::vector(&mesh, 1).unwrap());
    let (mut heated, mut pulled) = (Constraints::new(&temperatures), Constraints::new(&displacements));
    heated.fix("left", |_| 0.0).unwrap();
    heated.fix("right", |_| 1.0).unwrap();
    pulled.fix_component("left", 0, |_| 0.0).unwrap();
    pulled.fix_component("bottom", 1, |_| 0.0).unwrap();
    pulled.fix_component("top", 1, |_| 0.1).unwrap();
    let data = data([0.0; 2], [0.0; 2]);
    let form = held::both(&data, &held::Omega::on("all"));
    let problem = Problem::new(&form, [&temperatures, &displacements]);
    let solved = problem.constrained(&heated).constrained(&pulled).solve().unwrap();
    close(&solved.reaction_of(0, "right").unwrap(), &[HEIGHT / WIDTH]);
    close(&solved.reaction_of(0, "left").unwrap(), &[-HEIGHT / WIDTH]);
    close(&solved.reaction_of(1, "top").unwrap(), &[0.0, 2.5 / 0.9375 * 0.1 / HEIGHT * WIDTH]);
    let error = solved.reaction_of(2, "top").unwrap_err().to_string();
    assert_eq!(error, "there is no unknown 2; the problem has 2 (numbered from 0)");
}
