//! Orderings by the places of cells on matrices of forms: the solution is the one of minimum degree, whatever the form couples.

use forms_fem::constraints::RigidMap;
use forms_fem::linear_algebra::Ordering;
use forms_fem::linear_algebra::vector::norm;
use forms_fem::prelude::*;
use forms_fem::solve::{Solved, SolverPath};
use forms_fem::threads::Threads;

#[forms]
mod bodies {
    pub struct Data {
        /// Keeps the diagonals of pressures and multipliers from zero.
        pub leak: Param,
        pub up: Param<Vector>,
        pub force: Given<Vector>,
    }

    #[cells]
    pub struct Omega;
    #[interior_facets]
    pub struct Inner;
    #[facets]
    pub struct Top;

    pub fn elastic(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(eps(u), eps(v)) + div(u) * div(v) - dot(force, v))
    }

    /// Degrees of freedom on both sides of each facet are coupled.
    pub fn broken(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(grad(u), grad(v)) + dot(u, v) - dot(force, v))
            + integral(Inner, 10 / avg(h) * dot(jump(u), jump(v)))
    }

    pub fn flow(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, inner(grad(u), grad(v)) - p * div(v) - q * div(u) - leak * p * q - dot(force, v))
    }

    /// A multiplier on facets alone holds the top.
    pub fn tied(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, inner(eps(u), eps(v)) - dot(force, v))
            + integral(Top, p * dot(v, up) + q * dot(u, up) - leak * p * q)
    }
}

fn model<const D: usize>() -> bodies::Model<D>
where
    Dim: Dimension<D>,
{
    let mut up = [0.0; D];
    up[D - 1] = 1.0;
    let force = Given::function(move |x: &[f64; D]| std::array::from_fn(|i| (3.0 * x[i] + i as f64).sin()));
    bodies::Model::new(bodies::data().leak(0.01).up(up).force(force))
}

fn solver(ordering: Ordering, threads: Threads) -> TangentSolver {
    TangentSolver::new(TangentSolverOptions { ordering, threads, ..TangentSolverOptions::default() })
}

/// Solves by cells on 1, 2 and 3 threads, and by minimum degree.
fn check<const D: usize, const N: usize>(
    path: SolverPath,
    solve: impl Fn(&mut TangentSolver, Threads) -> Solved<D, N>,
) {
    let values = |solved: &Solved<D, N>| -> Vec<f64> {
        solved.fields.iter().flat_map(|field| field.values()).copied().collect()
    };
    let by_cells = |threads: Threads| {
        let solved = solve(&mut solver(Ordering::CellDissection, threads), threads);
        let report = solved.report.as_ref().unwrap();
        assert_eq!(report.path, Some(path));
        assert_eq!(report.orderings[0].name, "dissection of cells");
        values(&solved)
    };
    let found = by_cells(Threads::ONE);
    for count in [2, 3] {
        let again = by_cells(Threads::new(count));
        assert!(found.iter().zip(&again).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
    let expected = values(&solve(&mut solver(Ordering::MinimumDegree, Threads::ONE), Threads::ONE));
    let difference: Vec<f64> = found.iter().zip(&expected).map(|(a, b)| a - b).collect();
    let difference = norm(&difference) / norm(&expected);
    println!("relative difference {difference:e}");
    assert!(difference < 1e-12, "{difference:e}");
}

fn check_one<const D: usize>(form: &Form<D>, constraints: &Constraints<D>) {
    check(SolverPath::Cholesky, |solver, threads| {
        let problem = Problem::new(form, constraints.space()).threads(threads).constrained(constraints);
        problem.solver(solver).solve().unwrap()
    });
}

fn fixed<const D: usize>(space: &Arc<Space<D>>, region: &str) -> Constraints<D> {
    let mut constraints = Constraints::new(space);
    constraints.fix(region, |_| [0.0; D]).unwrap();
    constraints
}

#[test]
fn bodies_in_the_plane_and_in_space() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = rectangle([0.0; 2], [2.0, 1.0], [24, 12], shape, 1).unwrap();
        check_one(&model().elastic(), &fixed(&Space::vector(&mesh, 2).unwrap(), "left"));
    }
    let mesh = annulus(1.0, 2.0, 4, 48, CellShape::Quadrilateral, 2).unwrap();
    check_one(&model().elastic(), &fixed(&Space::vector(&mesh, 2).unwrap(), "inner"));
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        let mesh = cuboid([0.0; 3], [1.0, 1.0, 2.0], [4, 4, 6], shape, 1).unwrap();
        check_one(&model().elastic(), &fixed(&Space::vector(&mesh, 2).unwrap(), "bottom"));
    }
}

/// Couplings that no cell has: across facets, of unknowns given by others far away, of a mean value with all.
#[test]
fn couplings_beyond_cells() {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [20, 10], CellShape::Triangle, 1).unwrap();
    let broken = Space::discontinuous_vector(&mesh, 1).unwrap();
    check_one(&model().broken(), &Constraints::new(&broken));
    let space = Space::vector(&mesh, 2).unwrap();
    let mut periodic = fixed(&space, "bottom");
    periodic.periodic("left", "right", &RigidMap::translation([2.0, 0.0])).unwrap();
    check_one(&model().elastic(), &periodic);
    let mut rigid = fixed(&space, "bottom");
    rigid.rigid_body("top").unwrap();
    check_one(&model().elastic(), &rigid);
    let mut mean = fixed(&space, "bottom");
    mean.mean_value("top", 0, 0.3).unwrap();
    check_one(&model().elastic(), &mean);
}

#[test]
fn two_unknowns() {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [20, 10], CellShape::Quadrilateral, 1).unwrap();
    let velocities = Space::vector(&mesh, 2).unwrap();
    let walls = fixed(&velocities, "bottom");
    let model = model();
    let (flow, tied) = (model.flow(), model.tied());
    let pressures = Space::scalar(&mesh, 1).unwrap();
    check(SolverPath::SignedCholesky, |solver, threads| {
        let problem = Problem::new(&flow, [&velocities, &pressures]).threads(threads);
        problem.constrained(&walls).solver(solver).solve().unwrap()
    });
    let multipliers = Space::on_facets(&mesh, "top", 1).unwrap();
    check(SolverPath::SignedCholesky, |solver, threads| {
        let problem = Problem::new(&tied, [&velocities, &multipliers]).threads(threads);
        problem.constrained(&walls).solver(solver).solve().unwrap()
    });
}
