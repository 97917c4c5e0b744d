//! Problems on parts of a mesh give what one process gives with the solvers of `forms_fem` on the whole mesh, and what is not divided is
//! refused.

use std::collections::BTreeMap;

use forms_distributed::cases::ball_on_flat::ball_on_flat;
use forms_distributed::cases::mixed_block::MixedBlock;
use forms_distributed::cases::parts::{Case, at_vertices};
use forms_distributed::cases::report::read;
use forms_fem::prelude::*;

mod programs;

use programs::mpirun;

const SAME: f64 = 1e-9;
/// 7 and 3 do not divide the meshes; the parts of 7 meet in edges and vertices only, too.
const PROCESSES: [usize; 5] = [1, 2, 3, 4, 7];

type Numbers = BTreeMap<&'static str, Vec<f64>>;

fn told(processes: usize, arguments: &[&str]) -> String {
    let output = mpirun(processes, env!("CARGO_BIN_EXE_parts"), arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?} on {processes}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

fn check(processes: &[usize], arguments: &[&str], expected: &Numbers) {
    let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
    for processes in processes {
        let told = told(*processes, arguments);
        let found = read(&told);
        for (name, expected) in expected {
            assert_eq!(found[name].len(), expected.len(), "{arguments:?} on {processes}: {name}");
            let mut differences = found[name].iter().zip(expected).map(|(found, expected)| found - expected);
            let part = largest(&mut differences) / largest(&mut expected.iter().copied());
            println!("{arguments:?} on {processes}: {name} differs by {part:.1e}");
            assert!(part < SAME, "{arguments:?} on {processes}: {name} differs by {part:e}");
        }
    }
}

fn cube(divisions: usize, shape: CellShape) -> Mesh<3> {
    cuboid([0.0; 3], [1.0; 3], [divisions; 3], shape, 1).unwrap()
}

fn vertices(field: &Field<3>) -> Vec<f64> {
    let count = field.space().mesh().node_count();
    let numbers: Vec<u64> = (0..count as u64).collect();
    at_vertices(field, &numbers, count).0
}

fn steps<const N: usize>(solved: &Solved<3, N>) -> Vec<f64> {
    vec![solved.iterations() as f64]
}

fn solution(name: &str, mesh: &Mesh<3>, degree: usize) -> Numbers {
    let solved = Case::new(name, mesh, degree).unwrap().problem().solve().unwrap();
    let (u, reaction) = (solved.field(), |side| solved.reaction(side).unwrap());
    let size = solved.functional(&Case::size(u)).unwrap();
    let reactions = [reaction("left"), reaction("top")].concat();
    BTreeMap::from([
        ("u", vertices(u)),
        ("size", vec![size]),
        ("reactions", reactions),
        ("steps", steps(&solved)),
    ])
}

#[test]
fn diffusion_on_boxes_is_the_same() {
    let of = |shape, degree| solution("diffusion", &cube(4, shape), degree);
    check(&PROCESSES, &["diffusion", "4", "1", "cg"], &of(CellShape::Hexahedron, 1));
    check(&PROCESSES, &["diffusion", "4", "2", "direct"], &of(CellShape::Hexahedron, 2));
    // Edges with two nodes, faces with one, in the order that each side sees.
    check(&[2, 7], &["tetrahedra", "4", "3", "direct"], &of(CellShape::Tetrahedron, 3));
}

/// Cells along a curve meet others in all ways, and touch sides in edges and vertices only.
#[test]
fn diffusion_on_pieces_of_a_curve_is_the_same() {
    let of = |degree| solution("divided", &cube(4, CellShape::Tetrahedron), degree);
    check(&PROCESSES, &["divided", "4", "1", "direct"], &of(1));
    check(&[3, 7], &["divided", "4", "2", "direct"], &of(2));
}

#[test]
fn elasticity_on_boxes_is_the_same_by_both_solvers() {
    let expected = solution("hanging", &cube(4, CellShape::Hexahedron), 2);
    check(&PROCESSES, &["hanging", "4", "2", "cg"], &expected);
    check(&[3], &["hanging", "4", "2", "direct"], &expected);
    // GAMG has the rigid motions of the whole body on any number of processes.
    let iterations = |processes| read(&told(processes, &["hanging", "4", "2", "cg"]))["iterations"][0];
    let (one, four) = (iterations(1), iterations(4));
    assert!(four <= 1.5 * one, "{one} and {four} iterations");
}

#[test]
fn two_unknowns_are_the_same() {
    let block = MixedBlock::on(&cube(3, CellShape::Hexahedron)).unwrap();
    let solved = block.problem().solve().unwrap();
    let [u, p] = &solved.fields;
    let reactions = solved.reaction_of(0, "bottom").unwrap();
    let expected = BTreeMap::from([("u", vertices(u)), ("p", vertices(p)), ("reactions", reactions)]);
    check(&[1, 3, 4], &["mixed", "3", "2", "direct"], &expected);
}

/// Newton's method judges each row on all processes.
#[test]
fn a_stretched_cube_of_rubber_is_the_same_step_by_step() {
    let of = |degree| solution("rubber", &cube(3, CellShape::Hexahedron), degree);
    assert!(of(1)["steps"][0] > 3.0);
    check(&PROCESSES, &["rubber", "3", "1", "direct"], &of(1));
    check(&[4], &["rubber", "3", "2", "direct"], &of(2));
}

#[test]
fn a_ball_on_a_flat_is_the_same_with_its_adjoint_state() {
    for (theta, method, processes) in
        [(-1.0, "direct", &PROCESSES[..]), (-1.0, "gmres", &[2]), (1.0, "cg", &[4])]
    {
        let problem = ball_on_flat(4, theta).unwrap();
        let solved = problem.direct().unwrap().solver(&mut TangentSolver::default()).solve().unwrap();
        let (u, law) = (solved.field(), &problem.law);
        let value = |functional: &Functional<3>| problem.assembler.functional(functional).unwrap();
        let force = value(&law.contact_force(u));
        assert!(force > 1.0, "the ball is in contact");
        let active = solved.history.iter().filter_map(|step| step.active_points).map(|count| count as f64);
        let expected = BTreeMap::from([
            ("J", vec![value(&law.criterion(u))]),
            ("force", vec![force]),
            ("u", vertices(u)),
            ("adjoint", vertices(problem.adjoint(u).unwrap().solve().unwrap().field())),
            ("steps", steps(&solved)),
            ("active", active.collect()),
        ]);
        check(processes, &["ball", "4", "2", method], &expected);
    }
}

/// A file of each part, and one that lists them.
#[test]
fn parts_are_written() {
    let directory = std::env::temp_dir().join(format!("forms-parts-{}", std::process::id()));
    std::fs::create_dir_all(&directory).unwrap();
    let path = directory.join("block.pvd");
    told(3, &["diffusion", "4", "2", "direct", path.to_str().unwrap()]);
    let list = std::fs::read_to_string(&path).unwrap();
    let cells = |rank: usize| {
        let name = format!("block_000{rank}.vtu");
        assert!(list.contains(&format!("part=\"{rank}\" file=\"{name}\"")), "{list}");
        Mesh::<3>::read_vtk(directory.join(name)).unwrap().cell_count()
    };
    assert_eq!((0..3).map(cells).sum::<usize>(), 64);
    std::fs::remove_dir_all(&directory).unwrap();
}

/// Nothing is silently the answer of one process's piece.
#[test]
fn what_is_not_divided_is_refused() {
    let refusals = [
        ("without on", "3", "would add up over processes"),
        ("on the world", "3", "other processes than those of the part"),
        ("nearest", "3", "the nearest node: this mesh is one process's piece"),
        ("refined", "3", "refinement: this mesh is one process's piece"),
        ("cut", "3", "a cut: this mesh is one process's piece"),
        ("on facets", "3", "there are no spaces on"),
        ("sliding", "3", "there are no relations between unknowns"),
        ("interior", "3", "interior facets"),
        ("reaction", "3", "reactions, which the part of the mesh adds up"),
        ("functional", "3", "would add up over processes"),
        ("diffusion", "1", "2 processes cannot each have cells of a mesh of 1"),
    ];
    for (name, divisions, refusal) in refusals {
        let output = mpirun(2, env!("CARGO_BIN_EXE_parts"), &[name, divisions]).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && said.contains(refusal), "{name}: {said}");
    }
}
