//! In a Newton iteration the tangent is updated in place, where nonlinear integrals touch it.

use forms_fem::linear_algebra::BlockMatrix;
use forms_fem::prelude::*;
use forms_fem::solve::NonlinearProblem;

#[forms(dimension = 2)]
mod resting {
    pub struct Data {
        stiffness: Param,
        load: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Floor;

    /// Linear in the cells, nonlinear on the floor.
    pub fn body(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(sym(grad(u)), grad(v)) - dot(load, v))
            + integral(Floor, dot(u, v))
            + integral(Floor, stiffness * pos_part(dot(u, n)) * dot(v, n))
    }
    /// The same with a linear part that is not symmetric.
    pub fn drifting(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        body(u, v) + integral(Omega, dot(grad(u) * load, v))
    }
    /// Nonlinear everywhere.
    pub fn stiffening(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, (1 + inner(grad(u), grad(u))) * inner(grad(u), grad(v)) - dot(load, v))
    }
    /// Linear everywhere, nonlinear everywhere.
    pub fn both(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(grad(u), grad(v)) + dot(u, u) * dot(u, v) - dot(load, v))
    }
}

fn data() -> resting::Data<2> {
    resting::data().stiffness(30.0).load([0.3, -0.7])
}

fn mesh(cells: usize) -> Mesh<2> {
    rectangle([0.0; 2], [1.0; 2], [cells; 2], CellShape::Quadrilateral, 1).unwrap()
}

fn wave(space: &Arc<Space<2>>, shift: f64) -> Field<2> {
    Field::interpolate(space, |x| [(3.0 * x[0] + shift).sin(), (5.0 * x[0] - 2.0 * x[1] + shift).cos()])
        .unwrap()
}

/// The linear part of a problem, where tangents do not differ from it everywhere.
fn linear_part(problem: &mut dyn NonlinearProblem) -> Option<BlockMatrix> {
    problem.partly_linear().unwrap().linear_part().unwrap().map(|part| part.matrix.clone())
}

/// Tangents and residuals of successive iterates are those of an assembly from scratch, and K comes back.
fn follows(form: &Form<2>, space: &Arc<Space<2>>) {
    let assembler = Assembler::new(space.mesh());
    let mut problem = Problem::new(form, space).assembler(&assembler);
    let pattern = problem.pattern().unwrap().clone();
    let linear = linear_part(&mut problem);
    for shift in [0.0, 2.0, 0.7, 0.7] {
        let u = wave(space, shift);
        let mut whole = BlockMatrix::zero(pattern.sparsity());
        assembler.add_tangent(form, &[&u], &[space], Parts::ALL, &pattern, &mut whole).unwrap();
        let scale = whole.values().iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let tangent = problem.tangent(u.values()).unwrap();
        let close = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-13 * scale;
        assert!(tangent.matrix.values().iter().zip(whole.values()).all(close), "{}", form.name());
        let scratch = assembler.residual(form, &[&u], &[space]).unwrap();
        let residual = problem.residual(u.values()).unwrap();
        assert!(residual.iter().zip(scratch).all(|(a, b)| (a - b).abs() <= 1e-12 * scale));
        assert!(linear_part(&mut problem) == linear);
    }
}

#[test]
fn updates_are_those_of_an_assembly_from_scratch() {
    let mesh = mesh(6);
    let space = Space::vector(&mesh, 2).unwrap();
    let omega = resting::Omega::on("all");
    follows(&resting::body(&data(), &omega, &resting::Floor::on("bottom")), &space);
    follows(&resting::stiffening(&data(), &omega), &space);
    follows(&resting::both(&data(), &omega), &space);
}

/// A linear part is declared symmetric where it is.
#[test]
fn a_symmetric_linear_part_is_known_by_proof() {
    let mesh = mesh(6);
    let space = Space::vector(&mesh, 2).unwrap();
    let (omega, floor) = (resting::Omega::on("all"), resting::Floor::on("bottom"));
    let known = |problem: &mut dyn NonlinearProblem| {
        let part = problem.partly_linear().unwrap().linear_part().unwrap().unwrap();
        (part.is_symmetric, part.matrix.asymmetry().unwrap())
    };
    let (form, other) = (resting::body(&data(), &omega, &floor), resting::drifting(&data(), &omega, &floor));
    let (is_symmetric, asymmetry) = known(&mut Problem::new(&form, &space));
    assert!(is_symmetric && asymmetry < 1e-14, "{asymmetry:e}");
    let (is_symmetric, asymmetry) = known(&mut Problem::new(&other, &space));
    assert!(!is_symmetric && asymmetry > 1e-3, "{asymmetry:e}");
}

/// The changes between two iterates are those that the problem announces, and lie in rows and columns of nodes of the cells
/// at the floor; the number of places grows with the floor's facets and not with the cells.
#[test]
fn only_rows_of_cells_at_the_contact_facets_change() {
    let mut counts = vec![];
    for cells in [6, 12] {
        let mesh = mesh(cells);
        let space = Space::vector(&mesh, 2).unwrap();
        let form = resting::body(&data(), &resting::Omega::on("all"), &resting::Floor::on("bottom"));
        let mut problem = Problem::new(&form, &space);
        let places = problem.changed_places().unwrap().to_vec();
        assert!(places.windows(2).all(|pair| pair[0].end < pair[1].start));
        let at_floor: Vec<usize> =
            mesh.facet_region("bottom").unwrap().iter().map(|facet| facet.cell as usize).collect();
        let mut near = vec![false; space.node_count()];
        at_floor.iter().flat_map(|cell| space.cell_nodes(*cell)).for_each(|node| near[*node as usize] = true);
        let before = problem.tangent(wave(&space, 0.0).values()).unwrap().matrix.into_owned();
        let after = problem.tangent(wave(&space, 2.0).values()).unwrap().matrix.into_owned();
        let sparsity = after.sparsity().clone();
        let mut changes = 0;
        for row in 0..after.rows() {
            for (column, place) in sparsity.row(row) {
                let told = places.iter().any(|range| range.contains(&place));
                let changed = before.values()[place] != after.values()[place];
                assert!(told || !changed, "({row}, {column})");
                assert!(!told || near[row / 2] && near[column / 2], "({row}, {column})");
                changes += usize::from(changed);
            }
        }
        assert!(changes > 0);
        counts.push(places.iter().map(|range| range.len()).sum::<usize>());
    }
    // Pairs of nodes of each cell, less those of the edge that two cells share.
    let expected = |facets: usize| 4 * (81 * facets - 9 * (facets - 1));
    assert_eq!(counts, [expected(6), expected(12)]);
}

/// A tangent is made again after a change of any unknown that it reads, also of one that only a switch reads.
#[test]
fn a_change_of_one_unknown_is_followed() {
    let mesh = mesh(3);
    let space = Space::vector(&mesh, 2).unwrap();
    let form = resting::body(&data(), &resting::Omega::on("all"), &resting::Floor::on("bottom"));
    let mut problem = Problem::new(&form, &space);
    let mut u = wave(&space, 0.0).values().to_vec();
    let mut before = problem.tangent(&u).unwrap().matrix.into_owned();
    let mut changes = 0;
    for unknown in 0..u.len() {
        u[unknown] -= 0.3;
        let updated = problem.tangent(&u).unwrap().matrix.into_owned();
        let anew = Problem::new(&form, &space).tangent(&u).unwrap().matrix.into_owned();
        assert_eq!(updated.values(), anew.values(), "unknown {unknown}");
        changes += usize::from(updated.values() != before.values());
        before = updated;
    }
    assert!(changes > 0 && changes < u.len(), "{changes}");
}

#[test]
fn an_iterate_that_is_not_finite_is_an_error_where_it_is_read() {
    let mesh = mesh(4);
    let space = Space::vector(&mesh, 1).unwrap();
    let form = resting::body(&data(), &resting::Omega::on("all"), &resting::Floor::on("bottom"));
    let mut problem = Problem::new(&form, &space);
    let mut u = vec![0.0; space.unknowns()];
    u[2 * space.nodes_on("bottom").unwrap()[0] as usize] = f64::NAN;
    assert_eq!(problem.tangent(&u).unwrap_err().to_string(), "form `body`: `u` is not finite");
    assert_eq!(problem.residual(&u).unwrap_err().to_string(), "form `body`: `u` is not finite");
    assert!(problem.tangent(&u[1..]).unwrap_err().to_string().contains("has size"));
    // The matrix still serves.
    u.fill(0.0);
    assert!(problem.tangent(&u).unwrap().matrix.values().iter().all(|value| value.is_finite()));
}

/// Newton's method with a solver that takes changes, and with one that takes whole matrices, goes the same way.
#[test]
fn solvers_agree() {
    let mesh = mesh(8);
    let space = Space::vector(&mesh, 2).unwrap();
    let form = resting::body(&data(), &resting::Omega::on("all"), &resting::Floor::on("bottom"));
    let mut constraints = Constraints::new(&space);
    constraints.fix("top", |_| [0.0, -0.1]).unwrap();
    let solve = |solver: &mut dyn LinearSolver| {
        let problem = Problem::new(&form, &space);
        let options = NewtonOptions::default();
        problem
            .constrained(&constraints)
            .solver(solver)
            .options(options.clone())
            .solve()
            .unwrap()
            .into_field()
    };
    let mut condensed = CondensedSolver::default();
    let fields =
        [solve(&mut condensed), solve(&mut TangentSolver::default()), solve(&mut LuSolver::default())];
    assert!(condensed.report().condensed_unknowns.is_some_and(|count| count > 0));
    for field in &fields[1..] {
        let difference = field.values().iter().zip(fields[0].values()).map(|(a, b)| (a - b).abs());
        assert!(difference.fold(0.0, f64::max) < 1e-10);
    }
}
