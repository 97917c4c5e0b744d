//! Problems on parts of a mesh give what one process gives with the solvers of `forms_fem` on the whole mesh, and what is not divided is
//! refused.

use std::collections::BTreeMap;
use std::path::PathBuf;

use forms_contact::ContactProblem;
use forms_distributed::cases::ball_on_flat::ball_on_flat;
use forms_distributed::cases::eigenmodes::{self, Eigenmodes};
use forms_distributed::cases::histories;
use forms_distributed::cases::mixed_block::MixedBlock;
use forms_distributed::cases::motions::Motion;
use forms_distributed::cases::part_steps::{FACTORS, Softening, softening};
use forms_distributed::cases::parts::{Case, at_vertices};
use forms_distributed::cases::report::read;
use forms_fem::output::VtuFile;
use forms_fem::prelude::*;
use forms_fem::time::Mass;

mod between_parts;
mod divided_contact;
mod programs;

use programs::mpirun;

const SAME: f64 = 1e-9;
/// The same with MUMPS.
const DIGITS: f64 = 1e-12;
/// 7 and 3 do not divide the meshes; the parts of 7 meet in edges and vertices only, too.
const PROCESSES: [usize; 5] = [1, 2, 3, 4, 7];

/// Most collective calls per Newton step of rubber, those before the first step included.
const CALLS: f64 = 30.0;

type Numbers = BTreeMap<&'static str, Vec<f64>>;

fn told(processes: usize, arguments: &[&str]) -> String {
    let output = mpirun(processes, env!("CARGO_BIN_EXE_parts"), arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?} on {processes}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

/// The output of two processes that fail with a cause.
fn refused(arguments: &[&str], cause: &str) -> String {
    let output = mpirun(2, env!("CARGO_BIN_EXE_parts"), arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && said.contains(cause), "{arguments:?}: {said}");
    said
}

fn check(processes: &[usize], arguments: &[&str], expected: &Numbers) {
    check_to(SAME, processes, arguments, expected);
}

fn check_to(digits: f64, processes: &[usize], arguments: &[&str], expected: &Numbers) {
    let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
    for processes in processes {
        let told = told(*processes, arguments);
        let found = read(&told);
        for (name, expected) in expected {
            assert_eq!(found[name].len(), expected.len(), "{arguments:?} on {processes}: {name}");
            let mut differences = found[name].iter().zip(expected).map(|(found, expected)| found - expected);
            let part = largest(&mut differences) / largest(&mut expected.iter().copied());
            println!("{arguments:?} on {processes}: {name} differs by {part:.1e}");
            assert!(part < digits, "{arguments:?} on {processes}: {name} differs by {part:e}");
        }
    }
}

fn cube(divisions: usize, shape: CellShape) -> Mesh<3> {
    cuboid([0.0; 3], [1.0; 3], [divisions; 3], shape, 1).unwrap()
}

fn vertices<const D: usize>(field: &Field<D>) -> Vec<f64> {
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

/// With six times the weight of the others at the top, where each square has two cells, the parts have the same weight to a tenth.
#[test]
fn cells_are_divided_by_their_weights() {
    let arguments = ["weighted", "6", "1", "direct"];
    check(&[3], &arguments, &solution("divided", &cube(6, CellShape::Tetrahedron), 1));
    for processes in [2, 3, 4, 7] {
        let told = told(processes, &arguments);
        let weights = &read(&told)["weights"];
        let sum: f64 = weights.iter().sum();
        assert_eq!(sum, 6.0 * 216.0 + 5.0 * 72.0);
        let largest = weights.iter().fold(0.0, |largest: f64, weight| largest.max(*weight));
        assert!(largest < 1.1 * sum / processes as f64, "{weights:?} on {processes}");
    }
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

/// Several numbers go in one call of all processes, and nothing but blocks and rows has as many entries as the matrix.
#[test]
fn few_calls_and_little_memory_are_taken() {
    for processes in [2, 3, 7] {
        let calls = read(&told(processes, &["rubber", "3", "1", "direct"]))["sent"][2];
        assert!(calls <= CALLS, "{calls} collective calls per Newton step on {processes} processes");
    }
    let peak = |cells| read(&told(1, &["hanging", cells, "2", "cg"]))["megabytes"][0];
    // Of degree 2 a node has 64 others near it. Rows take 12 bytes for each entry, blocks 8 until PETSc has the rows.
    let entries = 192.0 * 3.0 * 21.0_f64.powi(3);
    let found = peak("10") - peak("2");
    assert!(found < 1.2 * 20e-6 * entries, "{found} MB for {entries} entries");
}

#[test]
fn a_ball_on_a_flat_is_the_same_with_its_adjoint_state() {
    for (theta, method, processes) in
        [(-1.0, "direct", &PROCESSES[..]), (-1.0, "gmres", &[2]), (1.0, "cg", &[4])]
    {
        let expected = pressed_ball(&ball_on_flat(4, theta).unwrap());
        check(processes, &["ball", "4", "2", method], &expected);
    }
}

fn pressed_ball(problem: &ContactProblem<3>) -> Numbers {
    let solved = problem.direct().unwrap().solver(&mut TangentSolver::default()).solve().unwrap();
    let (u, law) = (solved.field(), &problem.law);
    let value = |functional: &Functional<3>| problem.assembler.functional(functional).unwrap();
    let force = value(&law.contact_force(u));
    assert!(force > 1.0, "the ball is in contact");
    let active = solved.history.iter().filter_map(|step| step.active_points).map(|count| count as f64);
    BTreeMap::from([
        ("J", vec![value(&law.criterion(u))]),
        ("force", vec![force]),
        ("u", vertices(u)),
        ("adjoint", vertices(problem.adjoint(u).unwrap().solve().unwrap().field())),
        ("steps", steps(&solved)),
        ("active", active.collect()),
    ])
}

/// Relations between unknowns: of one node, of two surfaces, and of all nodes of a surface. Some nodes are on several sides, where a process may
/// know the condition of one only.
#[test]
fn related_unknowns_are_the_same() {
    let of = |name, degree| solution(name, &cube(3, CellShape::Hexahedron), degree);
    check(&PROCESSES, &["slides", "3", "1", "direct"], &of("slides", 1));
    check(&[4], &["slides", "3", "2", "direct"], &of("slides", 2));
    check(&PROCESSES, &["periodic", "3", "1", "direct"], &of("periodic", 1));
    check(&[3], &["periodic", "3", "2", "direct"], &of("periodic", 2));
    check(&PROCESSES, &["rigid", "3", "2", "direct"], &of("rigid", 2));
    check(&[2], &["rigid", "3", "2", "cg"], &of("rigid", 2));
}

/// A directory of a test, gone at its end.
struct Directory(PathBuf);

impl Directory {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("forms-parts-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Directory(path)
    }

    fn file(&self, name: &str) -> String {
        self.0.join(name).to_str().unwrap().to_owned()
    }
}

impl Drop for Directory {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A list of times, at each a list of parts, and the parts.
#[test]
fn a_series_of_parts_is_written() {
    let directory = Directory::new("series");
    told(3, &["diffusion", "4", "2", "direct", &directory.file("block.pvd")]);
    let read = |name: &str| std::fs::read_to_string(directory.file(name)).unwrap();
    assert!(read("block.pvd").contains("<DataSet timestep=\"1\" file=\"block_0001.pvtu\"/>"));
    let list = read("block_0001.pvtu");
    let array = "<PDataArray type=\"Float64\" Name=\"u\" NumberOfComponents=\"1\"/>";
    assert!(list.contains(array) && list.matches("<Piece ").count() == 3, "{list}");
    let cells = |rank: usize| {
        let name = format!("block_0001_p000{rank}.vtu");
        assert!(list.contains(&format!("<Piece Source=\"{name}\"/>")), "{list}");
        Mesh::<3>::read_vtk(directory.file(&name)).unwrap().cell_count()
    };
    assert_eq!((0..3).map(cells).sum::<usize>(), 64);
}

/// The first process reads a mesh and sends its pieces. All give the error of one that it cannot read.
#[test]
fn a_mesh_of_one_process_is_scattered() {
    let directory = Directory::new("scattered");
    let (path, mesh) = (directory.file("cube.vtu"), cube(4, CellShape::Tetrahedron));
    VtuFile::new(&mesh).write(&path).unwrap();
    check(&[3, 7], &["scattered", "4", "1", "direct", &path], &solution("divided", &mesh, 1));
    let damaged = directory.file("damaged.vtu");
    std::fs::write(&damaged, "no mesh").unwrap();
    for (arguments, cause) in
        [(&["missing"][..], "no/such.msh"), (&["scattered", "4", "1", "direct", &damaged], "damaged.vtu")]
    {
        let said = refused(arguments, cause);
        let of = |rank| {
            said.lines().any(|line| line.contains(&format!("process {rank}: ")) && line.contains(cause))
        };
        assert!(of(0) && of(1), "{said}");
    }
}

fn softened() -> Numbers {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [6, 4], CellShape::Triangle, 1).unwrap();
    let body = Softening::on(&mesh).unwrap();
    let start = (0.0, Field::zero(&body.space));
    let u = body.pulled(start, &FACTORS, |form, held, step| {
        let problem = Problem::new(form, &body.space).assembler(&body.assembler).constrained(held);
        Ok(problem.increment(step).solve()?.into_field())
    });
    let u = u.unwrap();
    let memory = softening::memory(&body.data, &softening::Omega::on("all"), &u);
    let memory = body.assembler.functional(&memory).unwrap();
    assert!(memory > 0.1, "{memory}");
    BTreeMap::from([("u", vertices(&u)), ("memory", vec![memory])])
}

/// Values at quadrature points that steps write; and the same where a run stops and goes on with other processes.
#[test]
fn load_steps_with_a_memory_are_the_same() {
    let (directory, expected) = (Directory::new("softening"), softened());
    check_to(DIGITS, &PROCESSES, &["softening"], &expected);
    let path = directory.file("run.checkpoint");
    let arguments = ["softening", "0", "0", "direct", &path];
    told(3, &arguments);
    check_to(DIGITS, &[2], &arguments, &expected);
    // Another mesh, a damaged file.
    refused(&["impact", "8", "0", "direct", &path], "run.checkpoint was written on another mesh");
    let piece = directory.file("run_w2_p0001.checkpoint");
    assert!(!std::fs::exists(directory.file("run_w1_p0002.checkpoint")).unwrap(), "it was replaced");
    let text = std::fs::read_to_string(&piece).unwrap();
    std::fs::write(&piece, text.replacen('1', "2", 1)).unwrap();
    refused(&arguments, "run_w2_p0001.checkpoint: its checksum is another one");
}

/// Newton's method in each step, affine equations for accelerations, lumped masses, and two unknowns.
#[test]
fn motions_are_the_same() {
    let directory = Directory::new("motions");
    for (name, motion) in Motion::ALL {
        let conditions = motion.conditions().unwrap();
        let (mut serial, size) = motion.begin(&conditions).unwrap();
        for _ in 0..8 {
            serial.take(size).unwrap();
        }
        let mut expected = BTreeMap::new();
        for (state, names) in serial.states().iter().zip([["value0", "rate0"], ["value1", "rate1"]]) {
            expected.extend(names.into_iter().zip([&state.value, &state.rate].map(vertices)));
        }
        let processes: &[usize] = match name {
            "impact" => &PROCESSES,
            "porous" => &[1, 3],
            _ => &[7],
        };
        check_to(DIGITS, processes, &[name, "8"], &expected);
        if ["impact", "porous"].contains(&name) {
            let arguments = [name, "8", "0", "direct", &directory.file(name)];
            told(3, &arguments);
            check_to(DIGITS, &[2], &arguments, &expected);
        }
    }
}

/// Value, gradient and Hessian of a load history and of a motion.
#[test]
fn histories_are_the_same_with_gradient_and_hessian() {
    let direction = [0.3, -0.7];
    for name in ["creep", "swing"] {
        let held = histories::held(name).unwrap();
        let found = if name == "creep" {
            let (mut history, m) = histories::creeping(&held);
            history.hessian(&m, &direction)
        } else {
            let (mut history, m) = histories::swinging_motion(&held, Mass::Consistent).unwrap();
            history.hessian(&m, &direction)
        };
        let found = found.unwrap();
        let expected = BTreeMap::from([
            ("value", vec![found.value]),
            ("gradient", found.gradient),
            ("along", found.along),
        ]);
        let processes = if name == "creep" { &PROCESSES[..] } else { &[3] };
        check_to(DIGITS, processes, &[name], &expected);
    }
}

/// Vibrations and buckling, by Lanczos' method on divided vectors, and a count by MUMPS that none is missing: prescribed values, a body that
/// moves freely, with its three zeros, unknowns that others give, and hanging nodes.
#[test]
fn eigenmodes_are_the_same() {
    let (upper, cells) = eigenmodes::SIZE;
    let mesh = rectangle([0.0; 2], upper, cells, CellShape::Quadrilateral, 1).unwrap();
    let trees = eigenmodes::trees().unwrap();
    for name in ["vibrates", "floats", "closed", "buckles", "vibrates trees"] {
        let modes = Eigenmodes::new(name, if name == "vibrates trees" { &trees } else { &mesh }).unwrap();
        let (shift, count) = Eigenmodes::ASKED;
        let found = modes.problem().above(shift, count).unwrap();
        let values = eigenmodes::values(&found);
        let processes = if name == "vibrates" { &PROCESSES[..] } else { &[1, 2, 3] };
        let mut expected = BTreeMap::from([("values", values)]);
        if name == "vibrates" {
            check_to(DIGITS, &[1, 3], &["shared"], &expected);
        }
        // Those of the closed plate are double.
        if name != "closed" {
            expected.insert("amounts", vertices(&eigenmodes::amounts(&found).unwrap()));
        }
        check_to(SAME, processes, &[name], &expected);
    }
}

/// Nothing is silently the answer of one process's piece.
#[test]
fn what_is_not_divided_is_refused() {
    let refusals = [
        ("without on", "3", "an integral of one process is not available on a mesh that is divided"),
        ("on the world", "3", "write `.on(&part)` with the part of the mesh"),
        ("nearest", "3", "the nearest node is not available on a mesh that is divided"),
        ("refined", "3", "refinement is not available on a mesh that is divided"),
        ("cut", "3", "a cut is not available on a mesh that is divided"),
        ("on facets", "3", "are not available on a mesh that is divided"),
        ("tied", "3", "the surface \"front\" is divided among processes"),
        ("mean", "3", "a mean value is not available on a mesh that is divided"),
        ("split", "3", "has some of the unknowns of a relation"),
        ("interior", "3", "interior facets"),
        ("reaction", "3", "a reaction of one process is not available on a mesh that is divided"),
        ("uncounted", "3", "does not tell how many eigenvalues of a matrix are negative"),
        ("heavy", "3", "4294967296 weights of cells, added up, are more than PETSc's indices can count"),
        ("functional", "3", "and `part.functional(..)` for a functional"),
        ("loose", "3", "continuity at hanging nodes of a mesh that is given by its cells is not available"),
        ("late", "3", "continuity after prescribed values is not available"),
        ("diffusion", "1", "2 processes cannot each have cells of a mesh of 1"),
    ];
    for (name, divisions, refusal) in refusals {
        refused(&[name, divisions], refusal);
    }
}
