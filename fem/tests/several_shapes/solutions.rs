//! Problems on two shapes with known solutions: the patch test, orders of convergence, interior penalties, solvers.

use forms_fem::prelude::*;

use super::patchwork;

#[forms(dimension = 2)]
mod problems {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        pub source: Given<Scalar>,
        pub wanted: Given<Scalar>,
        pub gamma: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;
    #[interior_facets]
    pub struct Skeleton;

    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, 2 * mu * inner(eps(u), eps(v)) + lambda * div(u) * div(v))
    }
    pub fn poisson(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - source * v)
    }
    pub fn penalty(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        poisson(u, v)
            + integral(
                Skeleton,
                gamma / avg(h) * jump(u) * jump(v)
                    - dot(avg(grad(u)), n) * jump(v)
                    - dot(avg(grad(v)), n) * jump(u),
            )
            + integral(
                Wall,
                gamma / h * (u - wanted) * v - dot(grad(u), n) * v - dot(grad(v), n) * (u - wanted),
            )
    }
}

use problems::{Omega, Skeleton, Wall};

const PI: f64 = std::f64::consts::PI;

fn data(
    source: impl Fn(&[f64; 2]) -> f64 + Send + Sync + 'static,
    wanted: impl Fn(&[f64; 2]) -> f64 + Send + Sync + 'static,
) -> problems::Data<2> {
    let (source, wanted) = (Given::function(source), Given::function(wanted));
    problems::data().lambda(1.2).mu(0.8).source(source).wanted(wanted).gamma(40.0)
}

#[test]
fn linear_displacements_are_exact() {
    let exact = |x: &[f64; 2]| [0.1 + 0.3 * x[0] - 0.2 * x[1], 0.05 * x[0] + 0.4 * x[1] - 0.3];
    for (geometry, degree) in [(1, 1), (1, 2), (1, 3), (1, 4), (2, 2)] {
        let mesh = patchwork(6, geometry);
        let (assembler, space) = (Assembler::new(&mesh), Space::vector(&mesh, degree).unwrap());
        let data = data(|_| 0.0, |_| 0.0);
        let form = problems::elasticity(&data, &Omega::on("all"));
        let mut constraints = Constraints::new(&space);
        constraints.fix("boundary", exact).unwrap();
        let problem = Problem::new(&form, &space).assembler(&assembler);
        let u = problem.constrained(&constraints).solve().unwrap().into_field();
        for (node, x) in space.positions().iter().enumerate() {
            for (found, expected) in u.at_node(node).iter().zip(exact(x)) {
                assert!((found - expected).abs() < 1e-12, "degree {degree} at {x:?}: {found} not {expected}");
            }
        }
    }
}

fn solve(mesh: &Mesh<2>, degree: usize, solver: &mut dyn LinearSolver) -> f64 {
    let exact = |x: &[f64; 2]| (PI * x[0]).sin() * (PI * x[1] + 0.3).sin();
    let data = data(move |x| 2.0 * PI * PI * exact(x), exact);
    let (assembler, space) = (
        Assembler::new(mesh).with_quadrature(Quadrature::Degree(2 * degree + 3)),
        Space::scalar(mesh, degree).unwrap(),
    );
    let form = problems::poisson(&data, &Omega::on("all"));
    let mut constraints = Constraints::new(&space);
    constraints.fix("boundary", exact).unwrap();
    let problem = Problem::new(&form, &space).assembler(&assembler);
    let u = problem.constrained(&constraints).solver(solver).solve().unwrap().into_field();
    error(mesh, &u, exact)
}

fn error(mesh: &Mesh<2>, u: &Field<2>, exact: fn(&[f64; 2]) -> f64) -> f64 {
    let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(12));
    let value = move |x: &[f64; 2], out: &mut [f64]| out[0] = exact(x);
    norms::errors(&assembler, u, value, |_, slope| slope.fill(0.0)).unwrap().l2
}

#[test]
fn errors_fall_with_the_full_order() {
    for geometry in 1..=2 {
        for degree in 1..=3 {
            let errors = [6, 12, 24].map(|n| {
                let mesh = patchwork(n, geometry);
                solve(&mesh, degree, &mut TangentSolver::default())
            });
            let orders = [(errors[0] / errors[1]).log2(), (errors[1] / errors[2]).log2()];
            println!("geometry {geometry}, degree {degree}: errors {errors:?}, orders {orders:?}");
            assert!(orders[1] > degree as f64 + 0.8, "degree {degree}: {errors:?} {orders:?}");
        }
    }
}

#[test]
fn solvers_agree() {
    let mesh = patchwork(16, 1);
    for degree in [1, 2] {
        let space = Space::scalar(&mesh, degree).unwrap();
        let mut constraints = Constraints::new(&space);
        constraints.fix("boundary", |_: &[f64; 2]| 0.0).unwrap();
        let direct = solve(&mesh, degree, &mut TangentSolver::default());
        let options = MultigridSolverOptions::default();
        let mut multigrid = MultigridSolver::new(&constraints, options).unwrap();
        let iterated = solve(&mesh, degree, &mut multigrid);
        assert!((direct - iterated).abs() < 1e-6 * direct, "{direct} {iterated}");
        let lu = solve(&mesh, degree, &mut LuSolver::default());
        assert!((direct - lu).abs() < 1e-9 * direct, "{direct} {lu}");
    }
}

#[test]
fn interior_penalties_couple_the_shapes() {
    let linear: fn(&[f64; 2]) -> f64 = |x| 1.0 + 2.0 * x[0] - 3.0 * x[1];
    let quadratic: fn(&[f64; 2]) -> f64 = |x| x[0] * x[0] - 2.0 * x[0] * x[1] + 0.5 * x[1];
    for (degree, exact, source) in [(1, linear, 0.0), (2, quadratic, -2.0), (3, quadratic, -2.0)] {
        let mesh = patchwork(5, 1);
        let (assembler, space) = (
            Assembler::new(&mesh).with_quadrature(Quadrature::Degree(8)),
            Space::discontinuous_scalar(&mesh, degree).unwrap(),
        );
        let data = data(move |_| source, exact);
        let form =
            problems::penalty(&data, &Omega::on("all"), &Wall::on("boundary"), &Skeleton::on("interior"));
        let problem = Problem::new(&form, &space).assembler(&assembler);
        let mut solver = TangentSolver::default();
        let u = problem.solver(&mut solver).solve().unwrap().into_field();
        for (value, x) in u.values().iter().zip(space.positions()) {
            assert!((value - exact(x)).abs() < 1e-10, "degree {degree}: {value} not {}", exact(x));
        }
    }
}
