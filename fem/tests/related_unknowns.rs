//! Constraints that relate unknowns: sliding in rotated frames, periodic conditions, and what Newton makes of them.

use forms_fem::constraints::RigidMap;
use forms_fem::prelude::*;
use forms_fem::solve::{Elimination, NonlinearProblem};

#[forms(dimension = 2)]
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
fn turned(shape: CellShape) -> Arc<Mesh<2>> {
    let flat = rectangle([0.0; 2], [2.0, 1.0], [4, 3], shape, 1).unwrap();
    let nodes = flat.nodes().iter().map(turn).collect();
    let mut mesh = Mesh::from_parts(shape, 1, nodes, flat.cells().to_vec()).unwrap();
    for name in ["left", "right", "bottom", "top"] {
        let facets = flat.facet_region(name).unwrap();
        mesh.name_listed_facets(name, facets).unwrap();
    }
    Arc::new(mesh)
}

fn data() -> bodies::Data<2> {
    // Traction 1 along the turned first axis.
    bodies::Data { load: turn(&[1.0, 0.0]).into(), source: 0.0.into() }
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
            let mut problem = FormProblem::new(&form, &assembler, &space).unwrap();
            let u = problem.solve_affine(&rollers, &mut TangentSolver::default()).unwrap();
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
    let mut problem = FormProblem::new(&form, &assembler, &space).unwrap();
    let mut elimination = Elimination::new(space.unknowns(), rollers.prescribed())
        .and_then(|elimination| elimination.with_relations(rollers.relations().clone()))
        .unwrap();
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
    let found = problem.solve(&Field::zero(&space), &rollers, solver, &options, &mut |_| ()).unwrap();
    assert!(found.history.len() < 10);
    let mut imposed = found.field.values().to_vec();
    rollers.apply(&mut imposed);
    assert!(imposed.iter().zip(found.field.values()).all(|(a, b)| (a - b).abs() < 1e-14));
}

// u = sin(2πx) cos(2πy) on the torus; the level is fixed at a corner, where u vanishes.
#[test]
fn the_periodic_poisson_problem_has_its_closed_form() {
    let pi = std::f64::consts::PI;
    let exact = move |x: &[f64; 2]| (2.0 * pi * x[0]).sin() * (2.0 * pi * x[1]).cos();
    let error = |n: usize| {
        let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [n, n], CellShape::Triangle, 1).unwrap());
        let space = Space::scalar(&mesh, 2).unwrap();
        let mut torus = Constraints::new(&space);
        torus.periodic("left", "right", &RigidMap::translation([1.0, 0.0])).unwrap();
        torus.periodic("bottom", "top", &RigidMap::translation([0.0, 1.0])).unwrap();
        assert_eq!(torus.free().len(), 4 * n * n);
        torus.fix_nearest(&[0.0, 0.0], 0.0).unwrap();
        assert_eq!(torus.free().len(), 4 * n * n - 1);
        let source = Given::function(move |x: &[f64; 2]| 8.0 * pi * pi * exact(x));
        let data = bodies::Data { load: [0.0; 2].into(), source };
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(8));
        let form = bodies::poisson(&data, &bodies::Omega::on("all"));
        let mut problem = FormProblem::new(&form, &assembler, &space).unwrap();
        let u = problem.solve_affine(&torus, &mut TangentSolver::default()).unwrap();
        let differences = space.positions().iter().zip(u.values()).map(|(x, u)| (u - exact(x)).abs());
        differences.fold(0.0, f64::max)
    };
    let order = (error(8) / error(16)).log2();
    assert!(order > 2.7, "order {order}");
}

#[test]
fn mistakes_name_the_node_and_both_conditions() {
    let mesh = Arc::new(rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1).unwrap());
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
    let zero = constraints.slide("top", |_| [0.0; 2], |_| 0.0).unwrap_err().to_string();
    assert!(zero.starts_with("region \"top\": the normal at ["), "{zero}");
    let options = MultigridSolverOptions::default();
    assert!(MultigridSolver::new(&constraints, options).is_err());
}
