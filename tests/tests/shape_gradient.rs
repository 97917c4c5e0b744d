//! The volume form of the shape derivative with (21) against central differences of J_h, the direct problem solved again
//! on each moved mesh: on free, loaded, clamped and contact boundary, with u_D depending on x, for both conventions of h_T.

use std::collections::BTreeMap;

use forms_contact::forms;
use forms_contact::shape_gradient::Diameters;
use forms_contact::{Adjoint, ContactProblem};
use forms_fem::movement::MovementError;
use forms_fem::prelude::*;
use forms_fem::verification::{self, Sample};

/// (14) with γ₀ as a number per cell that moves with the body: γ₀ h/h₀ for the γ₀ of a frozen h₀.
#[forms(dimension = 2)]
mod frozen {
    pub use forms_contact::forms::direct;

    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        pub theta: Param,
        pub gamma0: Carried<Scalar>,
        pub obstacle_normal: Given<Vector>,
        pub gap: Given<Scalar>,
        pub body_force: Given<Vector>,
        pub traction: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct GammaN;
    #[facets]
    pub struct GammaC;
}

/// Far above the threshold of θ = 1, near which everything bends sharply.
const GAMMA0: f64 = 8000.0;
/// Steps that are small compared with cells of size 0.5, and move no point across the edge of the contact zone.
const STEP: f64 = 4e-4;

fn imposed(x: &[f64; 2]) -> [f64; 2] {
    [0.01 * x[1], -0.15 + 0.02 * x[0] + 0.01 * x[0] * x[1]]
}

fn imposed_slope(x: &[f64; 2]) -> [[f64; 2]; 2] {
    [[0.0, 0.01], [0.02 + 0.01 * x[1], 0.01 * x[0]]]
}

fn data(theta: f64) -> forms::Data<2> {
    forms::data()
        .lambda(57.0)
        .mu(38.0)
        .gamma0(GAMMA0)
        .obstacle_normal(Given::function_with_gradient(
            |x| [(0.05 * x[0]).sin(), -(0.05 * x[0]).cos()],
            |x| [[0.05 * (0.05 * x[0]).cos(), 0.0], [0.05 * (0.05 * x[0]).sin(), 0.0]],
        ))
        .gap(Given::function_with_gradient(|x| x[1] + 3.0 + 0.02 * x[0] * x[0], |x| [0.04 * x[0], 1.0]))
        .theta(theta)
        .extension(0.0)
        .body_force(Given::function_with_gradient(
            |x| [0.1 * x[1], -0.2 * x[0] * x[0]],
            |x| [[0.0, 0.1], [-0.4 * x[0], 0.0]],
        ))
        .traction(Given::function_with_gradient(
            |x| [0.3 * x[0], 0.2 * x[0] * x[1]],
            |x| [[0.3, 0.0], [0.2 * x[1], 0.2 * x[0]]],
        ))
        .criterion_force(Given::function_with_gradient(
            |x| [x[1], -1.0 + 0.1 * x[0]],
            |_| [[0.0, 1.0], [0.1, 0.0]],
        ))
        .criterion_weight(Given::function_with_gradient(|x| 2.0 + x[0], |_| [1.0, 0.0]))
}

/// A ring twisted a little, so that the diagonals of its cells differ: where two are equally long h_T has a kink. It is held inside, loaded on a part of the upper half of its outside, in contact below.
fn ring(shape: CellShape, degree: usize) -> Mesh<2> {
    let mut mesh = annulus(2.0, 3.0, 2, 24, shape, degree).unwrap();
    mesh.name_facets("below", "outer", |centre| centre[1] < 0.0).unwrap();
    mesh.name_facets("loaded", "outer", |centre| centre[1] > 0.0 && centre[0] > 0.0).unwrap();
    let twisted = mesh.nodes().iter().map(|[x, y]| {
        let (sine, cosine) = (0.1 * (x.hypot(*y) - 2.0)).sin_cos();
        [cosine * x - sine * y, sine * x + cosine * y]
    });
    mesh.with_nodes(twisted.collect()).unwrap()
}

fn problem(mesh: &Mesh<2>, theta: f64) -> ContactProblem<2> {
    let space = Space::vector(mesh, 2).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.fix("inner", imposed).unwrap();
    let regions = forms::Regions::default().gamma_n("loaded").gamma_c("below");
    ContactProblem::new(&space, forms::Model { data: data(theta), regions }, constraints)
        .quadrature(Quadrature::Degree(6))
}

/// u, J_h and which points are in contact.
struct Solution {
    u: Field<2>,
    criterion: f64,
    active: Option<Vec<u32>>,
    /// ‖R‖₂ at which Newton's method stops: rounding, where it starts from zero.
    residual: f64,
}

/// With diameters as they are, or as they were on another mesh. Newton's method starts from zero, or near a solution.
fn solve(problem: &ContactProblem<2>, before: Option<&Mesh<2>>, near: Option<&Solution>) -> Solution {
    let ContactProblem { assembler, space, law, constraints, .. } = problem;
    let data = &law.data;
    let mut solver = TangentSolver::default();
    let start = near.map_or_else(
        || Field::zero(space),
        |near| Field::from_values(space, near.u.values().to_vec()).unwrap(),
    );
    let options = NewtonOptions {
        relative_tolerance: 1e-13,
        absolute_tolerance: near.map_or(1e-300, |near| near.residual),
        ..NewtonOptions::default()
    };
    let solved = match before {
        None => problem.direct().unwrap().start(&start).solver(&mut solver).options(options).solve().unwrap(),
        Some(before) => {
            let cells = Space::discontinuous_scalar(space.mesh(), 0).unwrap();
            let mut gamma0 = vec![0.0; cells.unknowns()];
            for cell in 0..before.cell_count() {
                gamma0[cells.cell_nodes(cell)[0] as usize] =
                    GAMMA0 * space.mesh().diameter(cell) / before.diameter(cell);
            }
            let data = frozen::data()
                .lambda(data.lambda)
                .mu(data.mu)
                .theta(data.theta)
                .gamma0(Field::from_values(&cells, gamma0).unwrap())
                .obstacle_normal(data.obstacle_normal.clone())
                .gap(data.gap.clone())
                .body_force(data.body_force.clone())
                .traction(data.traction.clone());
            let (omega, gamma_n) = (frozen::Omega::on("all"), frozen::GammaN::on("loaded"));
            let form = frozen::direct(&data, &omega, &gamma_n, &frozen::GammaC::on("below"));
            let problem = Problem::new(&form, space).assembler(assembler);
            problem
                .start(&start)
                .constrained(constraints)
                .solver(&mut solver)
                .options(options.clone())
                .solve()
                .unwrap()
        }
    };
    let residual = near.map_or(1e-13 * solved.history[0].residual, |near| near.residual);
    let u = solved.into_field();
    let criterion = law.criterion(&u);
    let active = assembler.active_set(&problem.law.direct(), &[&u]).unwrap();
    Solution { criterion: assembler.functional(&criterion).unwrap(), u, active, residual }
}

/// A movement of the points near a place of the boundary, radially and around.
fn near(mesh: &Mesh<2>, centre: [f64; 2]) -> Field<2> {
    let movement = |x: &[f64; 2]| {
        let square: f64 = x.iter().zip(centre).map(|(x, c)| (x - c) * (x - c)).sum();
        let weight = (1.0 - square / 0.8).max(0.0);
        [weight * (0.5 * x[0] - 0.2 * x[1]), weight * (0.5 * x[1] + 0.3 * x[0] * x[0])]
    };
    Field::interpolate(&Space::of_geometry(mesh).unwrap(), movement).unwrap()
}

fn sample(solution: &Solution) -> Sample {
    Sample { value: vec![solution.criterion], active_set: solution.active.clone() }
}

const PIECES: [(&str, [f64; 2]); 4] =
    [("free", [-2.1, 2.1]), ("loaded", [2.1, 2.1]), ("clamped", [-2.0, 0.0]), ("contact", [0.3, -3.0])];

#[test]
fn with_the_discrete_adjoint_it_is_the_derivative_of_the_discrete_criterion() {
    for (shape, degree) in [(CellShape::Quadrilateral, 2), (CellShape::Triangle, 1)] {
        let mesh = ring(shape, degree);
        for theta in [-1.0, 0.0, 1.0] {
            let here = problem(&mesh, theta);
            let start = solve(&here, None, None);
            let Solution { u, active, .. } = &start;
            let in_contact =
                active.as_ref().map_or(0, |points| points.iter().filter(|point| **point > 0).count());
            assert!(in_contact > 3, "{in_contact} points in contact");
            let p =
                here.solve_adjoint(Adjoint::Discrete, u, &mut TangentSolver::default()).unwrap().into_field();
            for (diameters, before) in [(Diameters::Frozen, Some(&mesh)), (Diameters::Moving, None)] {
                let gradient = here.shape_gradient(u, &p, diameters, Some(&imposed_slope)).unwrap();
                let kept = here.shape_gradient(u, &p, diameters, None).unwrap();
                for (piece, centre) in PIECES {
                    let label = format!("{shape:?}, θ = {theta}, {diameters:?}, {piece}");
                    let along = near(&mesh, centre);
                    let found = gradient.along(&along).unwrap();
                    // Differences and Taylor's test share steps.
                    let mut known = BTreeMap::from([(0.0_f64.to_bits(), sample(&start))]);
                    let mut moved = |step: f64| -> Sample {
                        let at = || {
                            let mesh = along.move_mesh(step).unwrap();
                            sample(&solve(&problem(&mesh, theta), before, Some(&start)))
                        };
                        known.entry(step.to_bits()).or_insert_with(at).clone()
                    };
                    let mut kept_active = |step: f64| {
                        let Sample { value, active_set } = moved(step);
                        assert_eq!(
                            active_set, start.active,
                            "{label}: another active set at the step {step}"
                        );
                        value[0]
                    };
                    let mut central = |step: f64| (kept_active(step) - kept_active(-step)) / (2.0 * step);
                    // Of fourth order, from two steps.
                    let difference = (4.0 * central(STEP) - central(2.0 * STEP)) / 3.0;
                    let relative = (found - difference).abs() / difference.abs();
                    println!("{label}: {found:.6e}, differences {difference:.6e}, relative {relative:.1e}");
                    assert!(relative < 1e-7, "{label}: {found} against {difference} ({relative:.1e})");
                    let report = verification::taylor(64.0 * STEP, &[found], |step| {
                        Ok::<_, MovementError>(moved(step))
                    });
                    let report = report.unwrap();
                    report.second_order().unwrap_or_else(|failure| panic!("{label}: {failure}"));
                    // Imposed values that are kept matter where the clamped boundary moves, and only there.
                    let missing = (kept.along(&along).unwrap() - found).abs() / found.abs();
                    assert_eq!(missing > 1e-6, piece == "clamped", "{label}: {missing:e}");
                }
            }
        }
    }
}

/// The derivatives with fixed and with moving h_T differ by the contribution of γ on the contact boundary.
#[test]
fn diameters_matter_on_the_contact_boundary() {
    let mesh = ring(CellShape::Quadrilateral, 2);
    let here = problem(&mesh, 0.0);
    let u = solve(&here, None, None).u;
    let p = here.solve_adjoint(Adjoint::Discrete, &u, &mut TangentSolver::default()).unwrap().into_field();
    let [frozen, moving] = [Diameters::Frozen, Diameters::Moving]
        .map(|diameters| here.shape_gradient(&u, &p, diameters, None).unwrap());
    for (piece, centre) in PIECES {
        let along = near(&mesh, centre);
        let (a, b) = (frozen.along(&along).unwrap(), moving.along(&along).unwrap());
        assert_eq!((a - b).abs() > 1e-9 * a.abs(), piece == "contact", "{piece}: {a} and {b}");
    }
    // A movement on another mesh, and data without a gradient.
    let other = near(&ring(CellShape::Quadrilateral, 2), [0.0, 3.0]);
    let message = frozen.along(&other).unwrap_err().to_string();
    assert!(message.ends_with("it lives on another space"), "{message}");
    let mut here = here;
    here.law.data.gap = Given::function(|x: &[f64; 2]| x[1] + 3.0);
    let message = here.shape_gradient(&u, &p, Diameters::Frozen, None).unwrap_err().to_string();
    assert!(message.starts_with("form `shape_gradient` reads the gradient of `gap`"), "{message}");
}

/// With contact facets split at the zeros of β_h no point comes into contact or leaves it: the derivative needs no term for
/// the moving cut, whose integrand vanishes, and steps may be long.
#[test]
fn with_split_facets_it_is_the_derivative_across_changes_of_the_contact_zone() {
    for (shape, degree, theta) in [(CellShape::Quadrilateral, 2, -1.0), (CellShape::Triangle, 1, 1.0)] {
        let mesh = ring(shape, degree);
        let split = |mesh: &Mesh<2>| problem(mesh, theta).with_split_facets();
        let here = split(&mesh);
        let start = solve(&here, None, None);
        let u = &start.u;
        let p = here.solve_adjoint(Adjoint::Discrete, u, &mut TangentSolver::default()).unwrap().into_field();
        let gradient = here.shape_gradient(u, &p, Diameters::Moving, Some(&imposed_slope)).unwrap();
        for (piece, centre) in PIECES {
            let along = near(&mesh, centre);
            let found = gradient.along(&along).unwrap();
            let moved =
                |step: f64| solve(&split(&along.move_mesh(step).unwrap()), None, Some(&start)).criterion;
            let central = |step: f64| (moved(step) - moved(-step)) / (2.0 * step);
            let difference = (4.0 * central(STEP) - central(2.0 * STEP)) / 3.0;
            let relative = (found - difference).abs() / difference.abs();
            let label = format!("{shape:?}, θ = {theta}, {piece}");
            println!("{label}: {found:.6e}, differences {difference:.6e}, relative {relative:.1e}");
            assert!(relative < 1e-7, "{label}: {found} against {difference} ({relative:.1e})");
            let report = verification::shape(&along, 64.0 * STEP, found, |mesh| {
                let value = vec![solve(&split(mesh), None, Some(&start)).criterion];
                Ok::<_, MovementError>(Sample { value, active_set: None })
            });
            report.unwrap().second_order().unwrap_or_else(|failure| panic!("{label}: {failure}"));
        }
    }
}
