//! Elasticity in space against the direct solution, on meshes of three sizes.

use super::*;
use crate::constraints::RigidMap;
use crate::linear_algebra::LinearAlgebraError;
use crate::mesh::OctreeMesh;
use crate::prelude::*;
use crate::solve::{Elimination, NonlinearProblem};

#[forms(dimension = 3, matrix_free)]
mod body {
    pub struct Data {
        /// Unsymmetric part.
        pub drift: Param,
    }
    #[cells]
    pub struct Omega;
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, 1.6 * inner(eps(u), eps(v)) + 1.2 * div(u) * div(v) + drift * u[0] * v[1] - v[2])
    }
}

/// The reduced matrix and load of a cube of n × n × n × 6 tetrahedra, clamped on the left and sliding on the bottom.
fn system(n: usize, degree: usize, drift: f64) -> (Constraints<3>, CsrMatrix, Vec<f64>) {
    let mesh = cuboid([0.0; 3], [1.0; 3], [n; 3], CellShape::Tetrahedron, 1).unwrap();
    let space = Space::vector(&mesh, degree).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.fix("left", |_: &[f64; 3]| [0.0; 3]).unwrap();
    constraints.fix_component("bottom", 2, |_: &[f64; 3]| 0.0).unwrap();
    let (matrix, load) = reduced(&constraints, drift);
    (constraints, matrix, load)
}

/// The reduced matrix and load of any constraints.
fn reduced(constraints: &Constraints<3>, drift: f64) -> (CsrMatrix, Vec<f64>) {
    let space = constraints.space();
    let form = body::balance(&body::data().drift(drift), &body::Omega::on("all"));
    let assembler = Assembler::new(space.mesh());
    let mut problem = Problem::new(&form, space).assembler(&assembler);
    let zero = vec![0.0; space.unknowns()];
    let mut elimination = Elimination::of(&[constraints]).unwrap();
    let residual = problem.residual(&zero).unwrap();
    let load = elimination.reduce(&residual).unwrap().iter().map(|value| -value).collect();
    let matrix = elimination.reduce_matrix(&problem.tangent(&zero).unwrap().matrix).unwrap();
    (matrix, load)
}

/// Iterations of multigrid, whose solution is the direct one.
fn iterations(constraints: &Constraints<3>) -> usize {
    let (matrix, load) = reduced(constraints, 0.0);
    let mut solver = MultigridSolver::new(constraints, options()).unwrap();
    solver.set_matrix(matrix.clone()).unwrap();
    let found = solver.solve(&load, 0.0).unwrap();
    assert!(solver.report().levels.len() > 1, "{:?}", solver.report().levels);
    let mut direct = TangentSolver::default();
    direct.set_matrix(matrix).unwrap();
    let exact = direct.solve(&load, 0.0).unwrap().solution;
    assert!(distance(&found.solution, &exact) < 1e-8);
    found.iterations
}

fn clamped(mesh: &Mesh<3>, degree: usize) -> Constraints<3> {
    let mut constraints = Constraints::new(&Space::vector(mesh, degree).unwrap());
    constraints.fix("bottom", |_: &[f64; 3]| [0.0; 3]).unwrap();
    constraints
}

#[test]
fn hanging_nodes_cost_few_iterations() {
    for (degree, divisions, steps) in [(1, 6, 3), (2, 3, 3), (4, 2, 1)] {
        let first = cuboid([0.0; 3], [1.0; 3], [divisions; 3], CellShape::Hexahedron, 1).unwrap();
        let plain = iterations(&clamped(&first, degree));
        let mut mesh = OctreeMesh::new(first).unwrap();
        for step in 0..steps {
            // The cells at an edge, so that nodes hang on faces and edges.
            let reach = 0.55 / f64::from(1 << step);
            let near = |cell: &u32| {
                let x = mesh.mesh().map(*cell as usize, &[0.5; 3]).0;
                x[0] + x[2] < reach
            };
            let marked: Vec<u32> = (0..mesh.mesh().cell_count() as u32).filter(near).collect();
            mesh = mesh.refined(&marked).unwrap().0;
        }
        let space = Space::vector(mesh.mesh(), degree).unwrap();
        let mut constraints = Constraints::new(&space);
        constraints.join_hanging_nodes().unwrap();
        constraints.fix("bottom", |_: &[f64; 3]| [0.0; 3]).unwrap();
        let adapted = iterations(&constraints);
        println!(
            "degree {degree}: {plain} iterations, {adapted} with {} given",
            constraints.relations().len()
        );
        assert!(!constraints.relations().is_empty() && 2 * adapted <= 3 * plain + 4);
    }
}

#[test]
fn periodic_and_sliding_conditions_cost_few_iterations() {
    for (shape, degree, n) in
        [(CellShape::Tetrahedron, 1, 8), (CellShape::Tetrahedron, 2, 4), (CellShape::Hexahedron, 2, 4)]
    {
        let mesh = cuboid([0.0; 3], [1.0; 3], [n; 3], shape, 1).unwrap();
        let plain = iterations(&clamped(&mesh, degree));
        let mut periodic = clamped(&mesh, degree);
        periodic.periodic("left", "right", &RigidMap::translation([1.0, 0.0, 0.0])).unwrap();
        let mut sliding = clamped(&mesh, degree);
        sliding.slide("right", |_| [1.0, 0.5, -0.25], |_| 0.0).unwrap();
        for (name, constraints) in [("periodic", periodic), ("sliding", sliding)] {
            let found = iterations(&constraints);
            println!("{shape:?} {degree}: {plain} iterations, {name} {found}");
            assert!(!constraints.relations().is_empty() && 2 * found <= 3 * plain + 4);
        }
    }
}

fn options() -> MultigridSolverOptions {
    let multigrid = MultigridOptions { direct_size: 300, ..MultigridOptions::default() };
    MultigridSolverOptions { multigrid, ..MultigridSolverOptions::default() }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    let largest = b.iter().fold(0.0_f64, |sum, value| sum.max(value.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

#[test]
fn iterations_do_not_grow_with_the_mesh_and_the_solution_is_the_direct_one() {
    for (degree, most, divisions) in
        [(1, 22, &[3, 6, 10][..]), (2, 26, &[3, 6, 10]), (3, 36, &[2, 4]), (4, 36, &[2, 3])]
    {
        for &n in divisions {
            let (constraints, matrix, load) = system(n, degree, 0.0);
            let mut solver = MultigridSolver::new(&constraints, options()).unwrap();
            solver.set_matrix(matrix.clone()).unwrap();
            let found = solver.solve(&load, 0.0).unwrap();
            println!("degree {degree}, n {n}: {} iterations", found.iterations);
            assert!(found.iterations <= most, "degree {degree}, n {n}: {}", found.iterations);
            let mut direct = TangentSolver::default();
            direct.set_matrix(matrix.clone()).unwrap();
            let exact = direct.solve(&load, 0.0).unwrap().solution;
            assert!(distance(&found.solution, &exact) < 1e-8);
            assert_eq!(solver.report().history.len(), found.iterations + 1);
            // The same matrix again, as for an adjoint problem.
            solver.set_matrix(matrix).unwrap();
            assert_eq!(solver.report().setups, 1);
        }
    }
}

#[test]
fn unsymmetric_systems_and_their_transposes_go_to_gmres() {
    let (constraints, matrix, load) = system(4, 2, 0.3);
    let mut solver = MultigridSolver::new(&constraints, options()).unwrap();
    solver.set_matrix(matrix.clone()).unwrap();
    for transpose in [Transpose::No, Transpose::Yes] {
        let solution = solver.solve_with(&load, 0.0, transpose).unwrap().solution;
        let product = match transpose {
            Transpose::No => matrix.multiply(&solution),
            Transpose::Yes => matrix.multiply_transposed(&solution),
        };
        assert!(distance(&product.unwrap(), &load) < 1e-8);
    }
}

#[test]
fn a_body_that_floats_or_slides_is_named_by_its_motions() {
    let mesh = cuboid([0.0; 3], [1.0; 3], [3; 3], CellShape::Tetrahedron, 1).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let form = body::balance(&body::data().drift(0.0), &body::Omega::on("all"));
    let assembler = Assembler::new(&mesh);
    let mut sliding = Constraints::new(&space);
    sliding.fix_component("bottom", 2, |_: &[f64; 3]| 0.0).unwrap();
    let floating = Constraints::new(&space);
    for (constraints, motions) in [(&floating, 6), (&sliding, 3)] {
        let mut multigrid = MultigridSolver::new(constraints, options()).unwrap();
        let mut direct = TangentSolver::default();
        let solvers: [&mut dyn LinearSolver; 2] = [&mut multigrid, &mut direct];
        for (number, solver) in solvers.into_iter().enumerate() {
            let problem = Problem::new(&form, &space).assembler(&assembler);
            let found = problem.constrained(constraints).solver(solver).solve();
            let Err(error) = found else {
                // Where nothing pulls along a free motion, conjugate gradients find one of the solutions.
                assert_eq!((number, motions), (0, 3), "a floating body is solved");
                continue;
            };
            let said = error.to_string();
            assert!(
                said.contains("the body can move rigidly: translation along x, translation along y"),
                "{said}"
            );
            assert!(said.contains("rotation about z through (0.5, 0.5, 0.5)"), "{said}");
            assert_eq!(
                said.matches("translation").count() + said.matches("rotation").count(),
                motions,
                "{said}"
            );
        }
    }
}

#[test]
fn conjugate_gradients_without_a_matrix() {
    let (constraints, matrix, load) = system(2, 2, 0.0);
    let space = constraints.space();
    let form = body::balance(&body::data().drift(0.0), &body::Omega::on("all"));
    let (assembler, u) = (Assembler::new(space.mesh()), Field::zero(space));
    let tangent = TangentAction::new(&assembler, &form, &[&u]).with_constraints(&[&constraints]);
    let elimination = Elimination::of(&[&constraints]).unwrap();
    let b = elimination.extend_by_zero(&load).unwrap();
    let mut x = vec![0.0; b.len()];
    let stop = KrylovOptions { tolerance: 1e-12, ..KrylovOptions::default() };
    cg(&tangent, &mut crate::linear_algebra::Identity, &b, &mut x, &stop).unwrap();
    let mut direct = TangentSolver::default();
    direct.set_matrix(matrix).unwrap();
    let exact = direct.solve(&load, 0.0).unwrap().solution;
    assert!(distance(&elimination.reduce(&x).unwrap(), &exact) < 1e-9);
}

#[test]
fn what_is_unfit_is_an_error_with_a_reason() {
    let (constraints, mut matrix, load) = system(3, 2, 0.0);
    let mut solver = MultigridSolver::new(&constraints, options()).unwrap();
    assert_eq!(solver.solve(&load, 0.0).unwrap_err(), SolverError::NoMatrix);
    let small = CsrMatrix::from_triplets(2, 2, &[(0, 0, 1.0), (1, 1, 1.0)]).unwrap();
    assert!(matches!(
        solver.set_matrix(small),
        Err(SolverError::LinearAlgebra(LinearAlgebraError::SizeMismatch { .. }))
    ));
    let few = MultigridSolverOptions { max_iterations: 2, ..options() };
    let mut hurried = MultigridSolver::new(&constraints, few).unwrap();
    hurried.set_matrix(matrix.clone()).unwrap();
    let error = hurried.solve(&load, 0.0).unwrap_err();
    assert!(matches!(&error, SolverError::Krylov { report, .. } if report.history.len() == 3), "{error}");
    let mut bad = load.clone();
    bad[5] = f64::NAN;
    assert!(hurried.solve(&bad, 0.0).is_err());
    let mut empty_row = matrix.clone();
    let range = matrix.row_pointers()[4]..matrix.row_pointers()[5];
    empty_row.values_mut()[range].fill(0.0);
    assert!(matches!(
        solver.set_matrix(empty_row),
        Err(SolverError::LinearAlgebra(LinearAlgebraError::Singular { unknown: 4, .. }))
    ));
    matrix.values_mut()[7] = f64::INFINITY;
    assert!(matches!(
        solver.set_matrix(matrix),
        Err(SolverError::LinearAlgebra(LinearAlgebraError::EntryNotFinite { .. }))
    ));
}
