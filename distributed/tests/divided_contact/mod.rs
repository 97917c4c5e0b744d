//! Contact between bodies on parts of a mesh.

use std::collections::BTreeMap;

use forms_contact::ContactProblem;
use forms_contact::laws::sliding_bodies;
use forms_distributed::cases::adaptive_contact;
use forms_distributed::cases::divided_contact::{
    FACTORS, RING, Remembering, blocks, blocks_mesh, blocks_trees, drawn_pairs, force_on_block, is_skin,
    place, ring,
};
use forms_distributed::cases::drawn_block::DrawnBlock;
use forms_distributed::cases::report::read;
use forms_fem::mesh::{Facet, structured};
use forms_fem::prelude::*;

use super::{DIGITS, Directory, Numbers, PROCESSES, check_to, refused, told, vertices};

mod histories;

fn paired<const D: usize>(solved: &Solved<D>) -> [Vec<f64>; 2] {
    let reports = solved.pairs.iter().map(|pairs| &pairs.report);
    [
        reports.clone().map(|report| report.paired_measure).collect(),
        reports.map(|report| report.points as f64).collect(),
    ]
}

fn steps_and_active<const D: usize>(solved: &Solved<D>) -> [Vec<f64>; 2] {
    let active = solved.history.iter().filter_map(|step| step.active_points).map(|count| count as f64);
    [vec![solved.iterations() as f64], active.collect()]
}

/// Load steps in which points slide over the opposite cells, with friction.
fn drawn(name: &str) -> Numbers {
    let block = DrawnBlock::on(&DrawnBlock::mesh(4).unwrap(), drawn_pairs(name)).unwrap();
    let (mut steps, mut before, mut last) = (vec![], None, None);
    let path = block.draw(|problem: &ContactProblem<2, sliding_bodies::Model<2>>, step| {
        let solved = problem.direct()?.increment(step).solve()?;
        steps.push(solved.iterations() as f64);
        before = Some(step.before.clone());
        last = Some(solved.clone());
        Ok(solved)
    });
    path.unwrap();
    let (last, before): (Solved<2>, Field<2>) = last.zip(before).unwrap();
    let [measure, points] = paired(&last);
    let u = last.into_field();
    let problem = block.step(1.0, &before).unwrap();
    let force = block.of_block(&before).unwrap().contact_force(&u);
    let force = block.assembler().functional(&force).unwrap();
    assert!(force < -0.05, "friction holds the block back: {force}");
    let mut expected = BTreeMap::from([
        ("steps", steps),
        ("paired", measure),
        ("points", points),
        ("u", vertices(&u)),
        ("J", vec![problem.criterion(&u).unwrap()]),
        ("force", vec![force]),
    ]);
    if name != "segments" {
        let adjoint = problem.adjoint(&u).unwrap().solve().unwrap();
        expected.insert("adjoint", vertices(adjoint.field()));
    }
    expected
}

#[test]
fn a_block_that_is_drawn_along_a_slab_is_the_same_on_parts() {
    check_to(DIGITS, &PROCESSES, &["drawn"], &drawn("drawn"));
    check_to(DIGITS, &[3], &["one sided"], &drawn("one sided"));
    // forms_fem solves for the contact unknowns first, and takes another number of steps once.
    let mut segments = drawn("segments");
    segments.insert("steps", read(&told(1, &["segments"]))["steps"].clone());
    check_to(DIGITS, &[4], &["segments"], &segments);
}

/// Fixed pairs with friction, and a stiffness of each cell that the opposite side reads.
fn pressed_blocks(space: &Arc<Space<3>>) -> Numbers {
    let (mut u, mut all_steps, mut expected) = (Field::zero(space), vec![], BTreeMap::new());
    for factor in FACTORS {
        let problem = blocks(space, factor, &u, &Ok).unwrap();
        let solved = problem.direct().unwrap().solve().unwrap();
        all_steps.push(solved.iterations() as f64);
        let force = problem.assembler.functional(&force_on_block(&problem.law, solved.field())).unwrap();
        let [steps, active] = steps_and_active(&solved);
        assert!(force < -1e-3 && active.last().is_some_and(|count| *count > 10.0), "{force} {active:?}");
        let [measure, points] = paired(&solved);
        let adjoint = problem.adjoint(solved.field()).unwrap().solve().unwrap();
        expected = BTreeMap::from([
            ("steps", steps),
            ("active", active),
            ("paired", measure),
            ("points", points),
            ("force", vec![force]),
            ("reaction", solved.reaction("slab bottom").unwrap()),
            ("adjoint", vertices(adjoint.field())),
        ]);
        u = solved.into_field();
    }
    expected.extend([("all_steps", all_steps), ("u", vertices(&u))]);
    expected
}

#[test]
fn blocks_in_space_are_the_same_on_parts() {
    let expected = pressed_blocks(&Space::vector(&blocks_mesh(1).unwrap(), 1).unwrap());
    check_to(DIGITS, &PROCESSES, &["blocks", "1"], &expected);
    // Files have each cell once, and another number of processes goes on from them with copies of its own.
    let directory = Directory::new("blocks");
    let arguments = ["blocks", "1", "0", "direct", &directory.file("run.checkpoint")];
    told(3, &arguments);
    let cells = |rank: usize| {
        let file = directory.file(&format!("run_p000{rank}.vtu"));
        Mesh::<3>::read_vtk(file).unwrap().cell_count()
    };
    assert_eq!((0..3).map(cells).sum::<usize>(), blocks_mesh(1).unwrap().cell_count());
    let stored = BTreeMap::from([("u", expected["u"].clone()), ("stiffness", vec![5.0])]);
    check_to(DIGITS, &[2], &arguments, &stored);
}

/// Nodes that hang on both surfaces, whose cells all processes have, and inside of both bodies, which touch at rest.
#[test]
fn contact_where_nodes_hang_is_the_same_on_parts() {
    let mesh = blocks_trees().unwrap();
    let hanging: Vec<u32> = {
        let small = mesh.hanging_facets_of_bodies().unwrap();
        let vertices = |facet: Facet| mesh.facet_vertices(facet).collect::<Vec<_>>();
        let ends = |[small, large]: &[Facet; 2]| [vertices(*small), vertices(*large)];
        let of = |[small, large]: [Vec<u32>; 2]| small.into_iter().filter(move |one| !large.contains(one));
        small.iter().map(ends).flat_map(of).collect()
    };
    for surface in ["slab top", "block bottom"] {
        let on_surface = |node: &u32| {
            let facets = mesh.facet_region(surface).unwrap();
            facets.iter().any(|facet| mesh.facet_vertices(*facet).any(|vertex| vertex == *node))
        };
        let count = hanging.iter().filter(|node| on_surface(node)).count();
        assert!(count > 4 && hanging.len() > 2 * count, "{count} of {} on the {surface}", hanging.len());
    }
    for (degree, processes) in [(1, &PROCESSES[..]), (2, &[3])] {
        let mut expected = pressed_blocks(&Space::vector(&mesh, degree).unwrap());
        // Rounding decides whether the first load step ends one step earlier.
        expected.remove("all_steps");
        check_to(DIGITS, processes, &["blocks trees", &degree.to_string()], &expected);
    }
}

/// Jumps across interior facets and pressures of pairs: of triangles, and of quadrilaterals with hanging nodes.
#[test]
fn a_cycle_of_adaptivity_with_contact_is_the_same_on_parts() {
    let cases =
        [("adapted contact", CellShape::Triangle), ("adapted contact of trees", CellShape::Quadrilateral)];
    for (name, shape) in cases {
        let found = adaptive_contact::on_one(shape, vertices).unwrap();
        assert!(found.cells.is_sorted() && found.cells[4] > 2.0 * found.cells[0], "{:?}", found.cells);
        let expected =
            BTreeMap::from([("cells", found.cells), ("estimates", found.estimates), ("u", found.values)]);
        check_to(DIGITS, &PROCESSES, &[name], &expected);
    }
}

/// One surface that may touch itself, on a grid whose other parts no process builds.
#[test]
fn a_ring_that_closes_on_itself_is_the_same_on_parts() {
    let mut mesh = structured(RING, CellShape::Quadrilateral, 1, place).unwrap();
    mesh.name_facets("skin", "boundary", is_skin).unwrap();
    mesh.name_facets("back", "top", |x| x[0] < -1.2).unwrap();
    mesh.name_facets("pushed down", "top", |x| x[0] > 0.9 && x[1] > 0.0).unwrap();
    mesh.name_facets("pushed up", "top", |x| x[0] > 0.9 && x[1] < 0.0).unwrap();
    assert_eq!(mesh.facet_region("skin").unwrap().len(), RING[0] + 2 * RING[1]);
    let solved = ring(&mesh).unwrap().direct().unwrap().solve().unwrap();
    let [measure, points] = paired(&solved);
    let [steps, _] = steps_and_active(&solved);
    let expected = BTreeMap::from([
        ("u", vertices(solved.field())),
        ("steps", steps),
        ("paired", measure),
        ("points", points),
    ]);
    check_to(DIGITS, &[1, 2, 3, 7], &["ring"], &expected);
}

/// Springs at the own points of sliding pairs.
#[test]
fn friction_that_remembers_is_the_same_on_parts() {
    let block = Remembering::on(&DrawnBlock::mesh(4).unwrap(), drawn_pairs("")).unwrap();
    let end = block.drawn(|problem, step| Ok(problem.direct()?.increment(step).solve()?));
    let (u, law) = end.unwrap();
    let force = block.assembler().functional(&law.contact_force(&u)).unwrap();
    assert!(force < -0.05, "springs hold the block back: {force}");
    let expected = BTreeMap::from([("u", vertices(&u)), ("force", vec![force])]);
    check_to(DIGITS, &PROCESSES, &["springs"], &expected);
    // Another number of processes reads the slip of each own point.
    let directory = Directory::new("springs");
    let arguments = ["springs", "0", "0", "direct", &directory.file("run.checkpoint")];
    told(3, &arguments);
    for processes in [1, 2] {
        let sums = read(&told(processes, &arguments))["stored"].clone();
        assert!(sums[0] > 1e-3 && sums[1] < 1e-11 * sums[0], "{sums:?}");
    }
}

#[test]
fn surfaces_and_fields_that_processes_do_not_have_whole_are_refused() {
    refused(
        &["unnamed"],
        "the surface \"slab top\" is divided among processes; name it in `part.with_surfaces",
    );
    let said =
        refused(&["material", "1"], "has other values on copies of cells than on the process that owns them");
    assert!(said.contains("part.completed(&field)"), "{said}");
}
