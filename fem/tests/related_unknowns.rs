//! Constraints that relate unknowns: sliding in rotated frames, periodic conditions, and what Newton makes of them.

use forms_fem::constraints::RigidMap;
use forms_fem::prelude::*;
use forms_fem::solve::{Elimination, NonlinearProblem};

#[forms(dimension = 2, matrix_free)]
mod bodies {
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Loaded;

    pub struct Data {
        load: Given<Vector>,
        source: Given<Scalar>,
    }

    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, 2 * inner(eps(u), eps(v)) + div(u) * div(v)) - integral(Loaded, dot(load, v))
    }
    /// Without lateral contraction.
    pub fn slender(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, 2 * inner(eps(u), eps(v))) - integral(Loaded, dot(load, v))
    }
    pub fn poisson(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - source * v)
    }
    /// Stiffer as it is stretched.
    pub fn hardening(u: Unknown<Vector>) -> Energy {
        let E = eps(u);
        integral(Omega, inner(E, E) + pow(inner(E, E), 2) + div(u) * div(u) / 2)
            - integral(Loaded, dot(load, u))
    }
}

const ANGLE: f64 = 0.4;

fn turn(x: &[f64; 2]) -> [f64; 2] {
    let (sin, cos) = ANGLE.sin_cos();
    [cos * x[0] - sin * x[1], sin * x[0] + cos * x[1]]
}

/// The rectangle [0, 2] × [0, 1], turned.
fn turned(shape: CellShape) -> Mesh<2> {
    let flat = rectangle([0.0; 2], [2.0, 1.0], [4, 3], shape, 1).unwrap();
    let nodes = flat.nodes().iter().map(turn).collect();
    let mut mesh = Mesh::from_parts(shape, 1, nodes, flat.cells().to_vec()).unwrap();
    for name in ["left", "right", "bottom", "top"] {
        let facets = flat.facet_region(name).unwrap();
        mesh.name_listed_facets(name, facets).unwrap();
    }
    mesh
}

fn data() -> bodies::Data<2> {
    // Traction 1 along the turned first axis.
    bodies::data().load(turn(&[1.0, 0.0])).source(0.0)
}

fn rollers(space: &Arc<Space<2>>) -> Constraints<2> {
    let mut rollers = Constraints::new(space);
    rollers.slide("left", |_| turn(&[-3.0, 0.0]), |_| 0.0).unwrap();
    rollers.slide_along("bottom", |_| 0.0).unwrap();
    rollers
}

// Plane strain with mu = lambda = 1: sigma_11 = 1 and sigma_22 = 0 give eps_11 = 3/8, eps_22 = -1/8.
#[test]
fn a_turned_block_on_rollers_is_stretched_uniaxially() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        for degree in 1..=3 {
            let mesh = turned(shape);
            let space = Space::vector(&mesh, degree).unwrap();
            let rollers = rollers(&space);
            let (data, assembler) = (data(), Assembler::new(&mesh));
            let form = bodies::elasticity(&data, &bodies::Omega::on("all"), &bodies::Loaded::on("right"));
            let problem = Problem::new(&form, &space).assembler(&assembler);
            let u = problem.constrained(&rollers).solve().unwrap().into_field();
            let back = |x: &[f64; 2]| {
                let (sin, cos) = ANGLE.sin_cos();
                [cos * x[0] + sin * x[1], cos * x[1] - sin * x[0]]
            };
            let exact = |x: &[f64; 2]| {
                let x = back(x);
                turn(&[0.375 * x[0], -0.125 * x[1]])
            };
            for (node, x) in space.positions().iter().enumerate() {
                let (found, exact) = (u.at_node(node), exact(x));
                assert!((0..2).all(|k| (found[k] - exact[k]).abs() < 1e-12), "{found:?} {exact:?}");
            }
        }
    }
}

// The reduced tangent is symmetric, and the derivative of the reduced residual: Taylor's remainder is of second order.
#[test]
fn reduced_residual_and_tangent_belong_together() {
    let mesh = turned(CellShape::Quadrilateral);
    let space = Space::vector(&mesh, 2).unwrap();
    let rollers = rollers(&space);
    let (data, assembler) = (data(), Assembler::new(&mesh));
    let form = bodies::hardening(&data, &bodies::Omega::on("all"), &bodies::Loaded::on("right"));
    let mut problem = Problem::new(&form, &space).assembler(&assembler);
    let mut elimination = Elimination::of(&[&rollers]).unwrap();
    let count = elimination.free().len();
    let at: Vec<f64> = (0..count).map(|k| 0.1 * (1.7 * k as f64).sin()).collect();
    let direction: Vec<f64> = (0..count).map(|k| 0.1 * (0.9 * k as f64 + 1.0).cos()).collect();
    let mut residual = |t: f64| {
        let moved: Vec<f64> = at.iter().zip(&direction).map(|(a, d)| a + t * d).collect();
        let full = elimination.extend_by_zero(&moved).unwrap();
        elimination.reduce(&problem.residual(&full).unwrap()).unwrap()
    };
    let start = residual(0.0);
    let steps = [1e-2, 5e-3].map(|t| (t, residual(t)));
    let full = elimination.extend_by_zero(&at).unwrap();
    let tangent = elimination.reduce_matrix(&problem.tangent(&full).unwrap().matrix).unwrap();
    assert!(tangent.asymmetry().unwrap() < 1e-13);
    let slope = tangent.multiply(&direction).unwrap();
    let remainders = steps.map(|(t, moved)| {
        let rest =
            moved.iter().zip(&start).zip(&slope).map(|((moved, start), slope)| moved - start - t * slope);
        rest.map(|rest| rest * rest).sum::<f64>().sqrt()
    });
    let order = (remainders[0] / remainders[1]).log2();
    assert!((1.9..2.2).contains(&order), "order {order}");
    // The operator without a matrix is the same on free unknowns.
    let field = Field::from_values(&space, full).unwrap();
    let action = TangentAction::new(&assembler, &form, &[&field]).with_constraints(&[&rollers]);
    let mut product = vec![0.0; space.unknowns()];
    action.apply(&elimination.extend_by_zero(&direction).unwrap(), &mut product).unwrap();
    let free = elimination.free().iter().map(|&unknown| product[unknown]);
    assert!(free.zip(&slope).all(|(a, b)| (a - b).abs() < 1e-12));
    // Newton converges quadratically with it.
    let options = NewtonOptions::default();
    let solver = &mut TangentSolver::default();
    let found = problem.constrained(&rollers).solver(solver).options(options.clone()).solve().unwrap();
    assert!(found.history.len() < 10);
    let mut imposed = found.field().values().to_vec();
    rollers.apply(&mut imposed);
    assert!(imposed.iter().zip(found.field().values()).all(|(a, b)| (a - b).abs() < 1e-14));
}

// u = sin(2πx) cos(2πy) on the torus; the level is fixed at a corner, where u vanishes.
#[test]
fn the_periodic_poisson_problem_has_its_closed_form() {
    let pi = std::f64::consts::PI;
    let exact = move |x: &[f64; 2]| (2.0 * pi * x[0]).sin() * (2.0 * pi * x[1]).cos();
    let error = |n: usize| {
        let mesh = rectangle([0.0; 2], [1.0; 2], [n, n], CellShape::Triangle, 1).unwrap();
        let space = Space::scalar(&mesh, 2).unwrap();
        let mut torus = Constraints::new(&space);
        torus.periodic("left", "right", &RigidMap::translation([1.0, 0.0])).unwrap();
        torus.periodic("bottom", "top", &RigidMap::translation([0.0, 1.0])).unwrap();
        assert_eq!(torus.free().len(), 4 * n * n);
        torus.fix_nearest(&[0.0, 0.0], 0.0).unwrap();
        assert_eq!(torus.free().len(), 4 * n * n - 1);
        let source = Given::function(move |x: &[f64; 2]| 8.0 * pi * pi * exact(x));
        let data = bodies::data().load([0.0; 2]).source(source);
        let form = bodies::poisson(&data, &bodies::Omega::on("all"));
        let problem = Problem::new(&form, &space).quadrature(Quadrature::Degree(8));
        let u = problem.constrained(&torus).solve().unwrap().into_field();
        let differences = space.positions().iter().zip(u.values()).map(|(x, u)| (u - exact(x)).abs());
        differences.fold(0.0, f64::max)
    };
    let order = (error(8) / error(16)).log2();
    assert!(order > 2.7, "order {order}");
}

#[test]
fn mistakes_name_the_node_and_both_conditions() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.slide("left", |_| [1.0, 0.0], |_| 0.0).unwrap();
    constraints.slide("bottom", |_| [1.0, 1.0], |_| 1.0).unwrap();
    let corner = space.nearest_node(&[0.0, 0.0]).unwrap();
    assert_eq!(constraints.prescribed().get(&(2 * corner + 1)), Some(&2_f64.sqrt()));
    let before = constraints.relations().clone();
    let slides = constraints.slide("bottom", |_| [0.0, 1.0], |_| 0.0).unwrap_err().to_string();
    assert!(slides.starts_with("region \"bottom\" contradicts region \"bottom\" at node "), "{slides}");
    assert!(slides.contains("[0.0, 0.0]"), "{slides}");
    assert_eq!(constraints.relations(), &before);
    // What follows from the others changes nothing.
    constraints.slide("bottom", |_| [-2.0, -2.0], |_| -1.0).unwrap();
    assert_eq!(constraints.relations(), &before);
    let alone =
        constraints.periodic("left", "right", &RigidMap::translation([1.0, 0.25])).unwrap_err().to_string();
    assert!(alone.contains("has no partner on \"right\"; the nearest is 2.5e-1 away"), "{alone}");
    for translation in [[0.0; 2], [1e-12, 0.0]] {
        let map = RigidMap::translation(translation);
        let itself = constraints.periodic("left", "left", &map).unwrap_err().to_string();
        let expected = "the regions \"left\" and \"left\" are not periodic under this map: it leaves all nodes where they are";
        assert!(itself.starts_with(expected), "{itself}");
    }
    assert_eq!(constraints.relations(), &before);
    let zero = constraints.slide("top", |_| [0.0; 2], |_| 0.0).unwrap_err().to_string();
    assert!(zero.starts_with("region \"top\": the normal at ["), "{zero}");
}

/// The block [0, 2] × [0, 1] has rollers at its left side; its right side is a rigid plate.
fn plate(space: &Arc<Space<2>>) -> Constraints<2> {
    let mut plate = Constraints::new(space);
    plate.fix_component("left", 0, |_| 0.0).unwrap();
    plate.fix_node(space.nearest_node(&[0.0, 0.0]).unwrap(), 1, 0.0).unwrap();
    plate.rigid_body("right").unwrap();
    plate
}

fn solve_with_plate(mesh: &Mesh<2>, degree: usize, load: Given<[f64; 2], 2>) -> Field<2> {
    let space = Space::vector(mesh, degree).unwrap();
    let (data, assembler) = (bodies::data().load(load).source(0.0), Assembler::new(mesh));
    let form = bodies::slender(&data, &bodies::Omega::on("all"), &bodies::Loaded::on("right"));
    let problem = Problem::new(&form, &space).assembler(&assembler);
    problem.constrained(&plate(&space)).solve().unwrap().into_field()
}

// Without lateral contraction (lambda = 0, E = 2 mu = 2) the plate stays plane by itself: pulled by a force F its block has
// u = (F x / E, 0), bent by a moment M it has u = M/(E I) (x (y - 1/2), -x^2/2), I = 1/12. Tractions of any shape with this
// force and moment give the same.
#[test]
fn a_rigid_plate_feels_the_force_and_the_moment_alone() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 3], shape, 1).unwrap();
        let compare = |u: &Field<2>, exact: &dyn Fn(&[f64; 2]) -> [f64; 2]| {
            for (node, x) in u.space().positions().iter().enumerate() {
                let (found, exact) = (u.at_node(node), exact(x));
                assert!((0..2).all(|k| (found[k] - exact[k]).abs() < 1e-11), "{x:?}: {found:?} {exact:?}");
            }
        };
        let pulled = |x: &[f64; 2]| [0.35 * x[0], 0.0];
        compare(&solve_with_plate(&mesh, 2, Given::constant([0.7, 0.0])), &pulled);
        // 0.7 in all, symmetric about the middle: without moment.
        let uneven = Given::function(|x: &[f64; 2]| [0.7 * 12.0 * (x[1] - 0.5).powi(2), 0.0]);
        compare(&solve_with_plate(&mesh, 2, uneven), &pulled);
        // M = 1/12: M / (E I) = 1/2.
        let bent = |x: &[f64; 2]| [0.5 * x[0] * (x[1] - 0.5), -0.25 * x[0] * x[0]];
        let linear = Given::function(|x: &[f64; 2]| [x[1] - 0.5, 0.0]);
        compare(&solve_with_plate(&mesh, 2, linear), &bent);
        // 20/3 ∫ (y - 1/2)^4 = 1/12.
        let cubic = Given::function(|x: &[f64; 2]| [20.0 / 3.0 * (x[1] - 0.5).powi(3), 0.0]);
        compare(&solve_with_plate(&mesh, 2, cubic), &bent);
    }
}

// Slip along the lower side is what rollers there alone leave open: a motion in a direction that is no axis.
#[test]
fn what_rollers_leave_open_is_told_in_words() {
    let mesh = turned(CellShape::Triangle);
    let space = Space::vector(&mesh, 2).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.slide_along("bottom", |_| 0.0).unwrap();
    assert!(!constraints.relations().is_empty());
    let (data, assembler) = (data(), Assembler::new(&mesh));
    let form = bodies::elasticity(&data, &bodies::Omega::on("all"), &bodies::Loaded::on("right"));
    let problem = Problem::new(&form, &space).assembler(&assembler);
    let error = problem.constrained(&constraints).solve().unwrap_err().to_string();
    let motion = "the body can move rigidly: translation along (0.921061, 0.389418)";
    assert!(error.ends_with(motion), "{error}");
}

#[test]
fn a_rigid_face_in_space_keeps_distances_to_first_order() {
    let mesh = forms_fem::mesh::cuboid([0.0; 3], [1.0; 3], [2; 3], CellShape::Hexahedron, 1).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.rigid_body("top").unwrap();
    let on_top = space.nodes_on("top").unwrap();
    assert_eq!(constraints.relations().len(), 3 * on_top.len() - 6);
    let mut values: Vec<f64> = (0..space.unknowns()).map(|k| (0.7 * k as f64).sin()).collect();
    constraints.apply(&mut values);
    for a in &on_top {
        for b in &on_top {
            let [x, y] = [a, b].map(|node| space.positions()[*node as usize]);
            let stretch: f64 = (0..3)
                .map(|k| (x[k] - y[k]) * (values[*a as usize * 3 + k] - values[*b as usize * 3 + k]))
                .sum();
            assert!(stretch.abs() < 1e-12, "{stretch}");
        }
    }
}

// -Δu = cos(πx) with insulated sides has u = cos(πx)/π² + c. The mean over the square, or over its left side, gives c.
#[test]
fn a_mean_value_fixes_what_an_insulated_body_leaves_open() {
    let pi = std::f64::consts::PI;
    let mesh = rectangle([0.0; 2], [1.0; 2], [8, 8], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::scalar(&mesh, 3).unwrap();
    let source = Given::function(move |x: &[f64; 2]| (pi * x[0]).cos());
    let data = bodies::data().load([0.0; 2]).source(source);
    let form = bodies::poisson(&data, &bodies::Omega::on("all"));
    for (region, constant) in [("all", 2.0), ("left", 2.0 - 1.0 / (pi * pi))] {
        let mut constraints = Constraints::new(&space);
        constraints.mean_value(region, 0, 2.0).unwrap();
        let problem = Problem::new(&form, &space).quadrature(Quadrature::Degree(8));
        let u = problem.constrained(&constraints).solve().unwrap().into_field();
        for (node, x) in space.positions().iter().enumerate() {
            let exact = (pi * x[0]).cos() / (pi * pi) + constant;
            assert!((u.at_node(node)[0] - exact).abs() < 2e-6, "{region}: {:?} {exact}", u.at_node(node));
        }
    }
    let mut constraints = Constraints::new(&space);
    let message =
        |outcome: Result<(), forms_fem::constraints::ConstraintsError>| outcome.unwrap_err().to_string();
    assert!(message(constraints.mean_value("lid", 0, 0.0)).contains("lid"));
    assert!(message(constraints.mean_value("all", 1, 0.0)).contains("there is no component 1"));
    let not_finite = message(constraints.mean_value("left", 0, f64::NAN));
    assert_eq!(
        not_finite,
        "the mean value over region \"left\": a coefficient or the value is not finite: NaN"
    );
    assert!(message(constraints.sum("the sum", &[], 0.0)).starts_with("the sum: 0 unknowns are related"));
    assert!(message(constraints.sum("the sum", &[(100_000, 1.0)], 0.0)).contains("no unknown 100000"));
    constraints.fix("left", |_| 1.0).unwrap();
    let contradiction = message(constraints.mean_value("left", 0, 2.0));
    assert!(
        contradiction.starts_with("the mean value over region \"left\" contradicts region \"left\""),
        "{contradiction}"
    );
}

/// The adjoint problem is the transposed one on the free unknowns: it gives the derivative by the load.
#[test]
fn adjoint_states_of_a_rigid_body_give_the_derivative_by_the_load() {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 3], CellShape::Triangle, 1).unwrap();
    let load = |t: f64| Given::function(move |x: &[f64; 2]| [t * x[1], 0.3]);
    let states = [0.5, 1.5].map(|t| solve_with_plate(&mesh, 2, load(t)));
    let space = states[0].space();
    // J = Σ c_k u_k.
    let criterion: Vec<f64> = (0..space.unknowns()).map(|k| (1.3 * k as f64).cos()).collect();
    let value = |u: &Field<2>| u.values().iter().zip(&criterion).map(|(u, c)| u * c).sum::<f64>();
    let assembler = Assembler::new(&mesh);
    let residual = |t: f64| {
        let data = bodies::data().load(load(t)).source(0.0);
        let form = bodies::slender(&data, &bodies::Omega::on("all"), &bodies::Loaded::on("right"));
        let zero = Field::zero(space);
        (
            assembler.residual(&form, &[&zero], &[space]).unwrap(),
            assembler.tangent(&form, &[&zero], &[space]).unwrap(),
        )
    };
    let (constraints, (start, tangent)) = (plate(space), residual(0.0));
    let mut elimination = Elimination::of(&[&constraints]).unwrap();
    let solver = &mut TangentSolver::default();
    let adjoint =
        forms_fem::solve::solve_linear_transposed(&tangent.into(), &criterion, &mut elimination, solver)
            .unwrap();
    let derivative: f64 =
        residual(1.0).0.iter().zip(&start).zip(&adjoint.solution).map(|((r, s), p)| -(r - s) * p).sum();
    let difference = value(&states[1]) - value(&states[0]);
    assert!((derivative - difference).abs() < 1e-10 * difference.abs(), "{derivative} {difference}");
}

// sin 2πx differs between both ends by its rounding, which is not small compared with its values there: they are zero.
#[test]
fn a_prescribed_wave_is_periodic() {
    for amplitude in [1.0, 1e-200, 1e200] {
        for degree in 1..=2 {
            let mesh = rectangle([0.0; 2], [1.0; 2], [4, 3], CellShape::Quadrilateral, 1).unwrap();
            let wave = |x: &[f64; 2]| amplitude * (std::f64::consts::TAU * x[0]).sin();
            let map = RigidMap::translation([1.0, 0.0]);
            for space in [Space::scalar(&mesh, degree).unwrap(), Space::vector(&mesh, degree).unwrap()] {
                let fix = |constraints: &mut Constraints<2>, height: f64, factor: f64| {
                    let region = if height == 1.0 { "top" } else { "bottom" };
                    if space.components() == 1 {
                        constraints.fix(region, |x| factor * wave(x))
                    } else {
                        constraints.fix(region, |x| [factor * wave(x), 0.3 * wave(x)])
                    }
                };
                let mut before = Constraints::new(&space);
                before.periodic("left", "right", &map).unwrap();
                fix(&mut before, 1.0, 1.0).unwrap();
                fix(&mut before, 0.0, -2.0).unwrap();
                let mut after = Constraints::new(&space);
                fix(&mut after, 1.0, 1.0).unwrap();
                fix(&mut after, 0.0, -2.0).unwrap();
                after.periodic("left", "right", &map).unwrap();
                assert_eq!(before.free(), after.free());
                // A value that is no rounding of another is a contradiction as before.
                let mut wrong = Constraints::new(&space);
                wrong.periodic("left", "right", &map).unwrap();
                fix(&mut wrong, 1.0, 1.0).unwrap();
                let tilted = |x: &[f64; 2]| wave(x) + 1e-9 * amplitude * x[0];
                let refused = if space.components() == 1 {
                    wrong.fix("bottom", tilted)
                } else {
                    wrong.fix("bottom", |x| [tilted(x), 0.0])
                };
                let message = refused.unwrap_err().to_string();
                assert!(message.starts_with("region \"bottom\" contradicts "), "{message}");
            }
        }
    }
}
