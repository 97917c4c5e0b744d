//! Contact where free unknowns give others: hanging nodes, periodic and rigid bodies, on few unknowns and on all.

use crate::constraints::RigidMap;
use crate::linear_algebra::vector::norm;
use crate::mesh::Mesh;
use crate::prelude::*;
use crate::solve::NewtonOptions;

#[forms]
mod bed {
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Floor;

    /// An elastic body that its weight presses onto an unsymmetric bed, which starts below it and deepens along x.
    pub fn pressed(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(eps(u), eps(v)) + div(u) * div(v) + v[1] / 10)
            - integral(Floor, 20 * pos_part(-u[1] - x[0] / 50) * (v[1] + v[0] / 5))
    }
}

/// Squares, some at the floor divided once more: hanging nodes between them.
fn graded(cells: usize) -> Mesh<2> {
    let coarse = rectangle([0.0; 2], [2.0, 1.0], [2 * cells, cells], CellShape::Quadrilateral, 1).unwrap();
    let fine = coarse.refined().unwrap();
    // The child at a vertex of a cell has it at the same place.
    let mut list = Vec::new();
    for cell in 0..coarse.cell_count() {
        let [x, y] = coarse.cell_centre(cell);
        match y < 0.5 && (x - 1.0).abs() > 0.5 {
            true => list.extend((0..4).flat_map(|child| fine.cell(4 * cell + child).to_vec())),
            false => list.extend((0..4).map(|vertex| fine.cell(4 * cell + vertex)[vertex])),
        }
    }
    let blocks = vec![(CellShape::Quadrilateral, list)];
    let mut mesh = Mesh::from_nonconforming_blocks(1, fine.nodes().to_vec(), blocks).unwrap();
    mesh.name_facets("floor", "boundary", |x| x[1] < 1e-9).unwrap();
    mesh.name_facets("roof", "boundary", |x| x[1] > 1.0 - 1e-9).unwrap();
    mesh.name_facets("west", "boundary", |x| x[0] < 1e-9).unwrap();
    mesh.name_facets("east", "boundary", |x| x[0] > 2.0 - 1e-9).unwrap();
    mesh
}

/// Compares solutions by iterates on few unknowns with those on all.
fn check(mesh: &Mesh<2>, constraints: &Constraints<2>) {
    let form = bed::pressed(&bed::Omega::on("all"), &bed::Floor::on("floor"));
    let solve = |solver: &mut dyn LinearSolver| {
        let assembler = Assembler::new(mesh);
        let problem = Problem::new(&form, constraints.space()).assembler(&assembler).constrained(constraints);
        let solved = problem.options(NewtonOptions::default()).solver(solver).solve().unwrap();
        (solved.fields[0].values().to_vec(), solved.history)
    };
    let (expected, all) = solve(&mut TangentSolver::default());
    assert!(all.len() > 2, "{all:?}");
    let mut solver = CondensedSolver::default();
    let (found, few) = solve(&mut solver);
    let difference: Vec<f64> = found.iter().zip(&expected).map(|(a, b)| a - b).collect();
    assert!(norm(&difference) < 1e-11 * norm(&expected), "{:e}", norm(&difference) / norm(&expected));
    let condensed: Vec<usize> = few.iter().filter_map(|step| step.condensed_unknowns).collect();
    assert!(condensed.len() + 2 >= few.len() && condensed.iter().any(|count| *count > 0), "{few:?}");
    let report = solver.report();
    assert!(report.factorisations <= 2 && report.lu_factorisations == 0, "{report:?}");
    assert!(report.condensed_unknowns.is_some_and(|count| count > 0 && count < expected.len() / 3));
}

#[test]
fn contact_with_related_unknowns_iterates_on_few() {
    let mesh = graded(6);
    let space = Space::vector(&mesh, 1).unwrap();
    // Hanging nodes only; periodic ones, with the corner of the floor; rigid sides, also the one that is pressed onto the bed.
    let joined = |space: &Arc<Space<2>>| {
        let mut joined = Constraints::new(space);
        joined.join_hanging_nodes().unwrap();
        assert!(!joined.relations().is_empty());
        joined
    };
    let held = |space: &Arc<Space<2>>| {
        let mut held = joined(space);
        held.fix("roof", |_| [0.0; 2]).unwrap();
        held
    };
    check(&mesh, &held(&space));
    check(&mesh, &held(&Space::vector(&mesh, 2).unwrap()));
    let mut periodic = held(&space);
    periodic.periodic("west", "east", &RigidMap::translation([2.0, 0.0])).unwrap();
    check(&mesh, &periodic);
    for side in ["east", "floor"] {
        let mut rigid = joined(&space);
        rigid.rigid_body(side).unwrap();
        rigid.fix(if side == "floor" { "roof" } else { "west" }, |_| [0.0; 2]).unwrap();
        check(&mesh, &rigid);
    }
}
