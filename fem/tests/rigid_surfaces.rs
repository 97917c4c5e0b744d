//! Rigid surfaces: what they refuse, STL files whole and broken, what does not see the cells that carry them, motions.

use forms_fem::assemble::BlockPattern;
use forms_fem::constraints::RigidMap;
use forms_fem::mesh::{RigidSurface, RigidSurfaceError};
use forms_fem::output::VtuFile;
use forms_fem::pairs::{Approach, PairError};
use forms_fem::prelude::*;
use forms_fem::solve::RigidLoads;

/// The corners and the triangles of a cube, counter-clockwise from outside.
fn cube() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let points = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2].map(f64::from)).collect();
    let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let facets = squares.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    (points, facets)
}

fn binary(points: &[[f64; 3]], facets: &[[u32; 3]]) -> Vec<u8> {
    let mut file = vec![b' '; 80];
    file.extend((facets.len() as u32).to_le_bytes());
    for facet in facets {
        file.extend([0.0_f32; 3].iter().flat_map(|x| x.to_le_bytes()));
        let corners = facet.iter().flat_map(|point| points[*point as usize]);
        file.extend(corners.flat_map(|x| (x as f32).to_le_bytes()));
        file.extend([0, 0]);
    }
    file
}

fn text(points: &[[f64; 3]], facets: &[[u32; 3]]) -> String {
    let mut file = "solid cube of one\n".to_owned();
    for facet in facets {
        file += "  facet normal 0 0 0\n    outer loop\n";
        for point in facet {
            let [x, y, z] = points[*point as usize];
            file += &format!("      vertex {x:e} {y:e} {z:e}\n");
        }
        file += "    endloop\n  endfacet\n";
    }
    file + "endsolid cube of one\n"
}

fn message<T>(outcome: Result<T, RigidSurfaceError>) -> String {
    outcome.err().map(|error| error.to_string()).unwrap_or_default()
}

#[test]
fn files_in_both_forms_are_one_surface() {
    let (points, facets) = cube();
    let one = RigidSurface::from_stl(&binary(&points, &facets)).unwrap();
    let other = RigidSurface::from_stl(text(&points, &facets).as_bytes()).unwrap();
    assert_eq!(one, other);
    assert_eq!((one.points().len(), one.facets().len(), one.rim()), (8, 12, 0));
    assert!((one.enclosed().unwrap() - 1.0).abs() < 1e-15);
    // A header may begin as a text does.
    let mut named = binary(&points, &facets);
    named[..5].copy_from_slice(b"solid");
    assert_eq!(RigidSurface::from_stl(&named).unwrap(), one);
    // Without its lid it is open, and encloses nothing.
    let open = RigidSurface::from_stl(&binary(&points, &facets[2..])).unwrap();
    assert_eq!((open.rim(), open.enclosed()), (4, None));
    let body = cuboid([0.0; 3], [1.0; 3], [1, 1, 1], CellShape::Hexahedron, 1).unwrap();
    let of_body = RigidSurface::of_boundary(&body, "boundary").unwrap();
    assert!((of_body.enclosed().unwrap() - 1.0).abs() < 1e-15 && of_body.facets().len() == 12);
}

#[test]
fn files_that_break_are_told_by_byte_and_line() {
    let (points, facets) = cube();
    let whole = binary(&points, &facets);
    assert_eq!(
        message(RigidSurface::from_stl(&whole[..500])),
        "the STL file says that it has 12 triangles, which take 684 bytes, but it has 500; it breaks off in triangle 8, at byte 500"
    );
    assert_eq!(
        message(RigidSurface::from_stl(&whole[..50])),
        "this is no STL file: it has 50 bytes, does not begin with \"solid\", and is too short for a binary header of 84"
    );
    let long = text(&points, &facets);
    let cut = &long[..long.find("endloop").unwrap()];
    assert_eq!(
        message(RigidSurface::from_stl(cut.as_bytes())),
        "line 7: the end of the file, where endloop should stand"
    );
    let other = long.replacen("vertex 1e0", "vertex one", 1);
    assert_eq!(
        message(RigidSurface::from_stl(other.as_bytes())),
        "line 6: \"one\", where a number should stand"
    );
    assert_eq!(message(RigidSurface::from_stl(b"solid nothing\nendsolid")), "the surface has no facets");
}

#[test]
fn triangles_that_say_nothing_are_named() {
    let (points, facets) = cube();
    let mut flat = facets.clone();
    flat[3] = [1, 1, 5];
    let told = message(RigidSurface::from_stl(&binary(&points, &flat)));
    assert!(
        told.starts_with("triangle 3 at byte 234: it is degenerate: corners at [[1.0, 0.0, 0.0],"),
        "{told}"
    );
    let mut far = points.clone();
    far[5] = [f64::NAN; 3];
    let told = message(RigidSurface::from_stl(text(&far, &facets).as_bytes()));
    assert!(told.starts_with("triangle 2 at line 16: a corner is not finite: [NaN"), "{told}");
    let told = message(RigidSurface::new(far, facets.clone()));
    assert!(told.starts_with("point 5 has a coordinate that is not finite"), "{told}");
    let against = text(&points, &facets).replacen("normal 0 0 0", "normal 0 0 1", 1);
    let told = message(RigidSurface::from_stl(against.as_bytes()));
    assert!(told.contains("triangle 0 at line 2: its normal [0.0, 0.0, 1.0] contradicts"), "{told}");
    let mut turned = facets.clone();
    turned[4].swap(0, 1);
    let told = message(RigidSurface::from_stl(&binary(&points, &turned)));
    assert!(told.contains("turn opposite sides outward"), "{told}");
    let inside_out: Vec<[u32; 3]> = facets.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let told = message(RigidSurface::from_stl(&binary(&points, &inside_out)));
    assert!(told.contains("encloses the volume -"), "{told}");
    let volume = RigidSurface::new(points.clone(), inside_out).unwrap().enclosed().unwrap();
    assert!((volume + 1.0).abs() < 1e-15, "{volume}");
    assert_eq!(
        message(RigidSurface::new(points, vec![[0, 1, 9]])),
        "facet 0 names point 9, but there are 8 points (numbered from 0)"
    );
    let told = message(RigidSurface::along(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]]));
    assert!(told.starts_with("facet 1 at [1.0, 0.0] is degenerate"), "{told}");
    assert!(matches!(RigidSurface::along(&[]), Err(RigidSurfaceError::Empty)));
    assert!(matches!(RigidSurface::along(&[[0.0, 0.0]]), Err(RigidSurfaceError::Empty)));
    let told = message(RigidSurface::from_stl_file("no such file.stl"));
    assert!(told.starts_with("no such file.stl: "), "{told}");
}

/// Whatever becomes of a file: a surface or an error, and no panic.
#[test]
fn broken_files_do_no_harm() {
    let (points, facets) = cube();
    let sources = [binary(&points, &facets), text(&points, &facets).into_bytes()];
    let count = if std::env::var("FORMS_SWEEPS").is_ok_and(|value| value == "1") { 40_000 } else { 1_000 };
    let mut state = 7_u64;
    let mut next = |bound: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % bound.max(1)
    };
    let mut refused = 0;
    for round in 0..count {
        let mut file = sources[round % 2].clone();
        for _ in 0..1 + next(4) {
            let place = next(file.len());
            match next(4) {
                0 => file[place] = next(256) as u8,
                1 => file.truncate(place),
                2 => {
                    let part: Vec<u8> = file[place..(place + next(60)).min(file.len())].to_vec();
                    let at = next(file.len());
                    file.splice(at..at, part);
                }
                _ => drop(file.drain(place..(place + next(60)).min(file.len()))),
            }
            if file.is_empty() {
                break;
            }
        }
        match RigidSurface::from_stl(&file) {
            Ok(surface) => assert!(surface.points().as_flattened().iter().all(|x| x.is_finite())),
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty());
            }
        }
    }
    assert!(refused > count / 2, "{refused}");
}

fn body() -> Mesh<2> {
    rectangle([0.0; 2], [2.0, 1.0], [8, 4], CellShape::Quadrilateral, 1).unwrap()
}

/// A punch that looks down, above a body, `apart` from it.
fn punch(apart: f64) -> RigidSurface<2> {
    let y = 1.0 + apart;
    RigidSurface::along(&[[0.5, y + 0.5], [0.6, y], [1.4, y], [1.5, y + 0.5]]).unwrap()
}

#[test]
fn bodies_do_not_see_the_cell() {
    let body = body();
    let mut mesh = body.with_rigid_surfaces(&[("punch", &punch(0.1)), ("anvil", &punch(3.0))]).unwrap();
    assert_eq!((mesh.cell_count(), mesh.body_cells()), (34, 0..32));
    assert_eq!(mesh.cell_region("all").unwrap(), body.cell_region("all").unwrap());
    assert_eq!(mesh.boundary_facets(), body.boundary_facets());
    assert_eq!(mesh.interior_facets(), body.interior_facets());
    assert_eq!(mesh.cell_region("anvil").unwrap(), [33]);
    assert_eq!(mesh.rigid_surface_names().collect::<Vec<_>>(), ["punch", "anvil"]);
    assert!(mesh.conformity().is_conforming());
    assert_eq!(mesh.quality().cells.len(), 32);
    mesh.name_cells("above", |x| x[1] > 0.5).unwrap();
    assert_eq!(mesh.cell_region("above").unwrap().len(), 16);
    let told = mesh.name_listed_cells("it", &[33]).unwrap_err().to_string();
    assert!(told.contains("there is no cell 33"), "{told}");
    for taken in ["above", "top", "all", "punch"] {
        let told = mesh.with_rigid_surfaces(&[(taken, &punch(0.1))]).unwrap_err().to_string();
        assert_eq!(told, format!("the mesh already has a region \"{taken}\""));
    }
    for refused in [mesh.refined(), mesh.simplices(), Mesh::of_bodies(&[("one", &mesh)])] {
        let told = refused.unwrap_err().to_string();
        assert!(told.contains("this mesh has the rigid surface \"punch\": add it afterwards"), "{told}");
    }
    // Bodies may move, the cells that carry surfaces not.
    let shifted: Vec<[f64; 2]> = mesh.nodes().iter().map(|[x, y]| [*x + 0.1, *y]).collect();
    assert!(mesh.with_nodes(shifted.clone()).is_err());
    let count = body.node_count();
    let nodes = shifted[..count].iter().chain(&mesh.nodes()[count..]).copied().collect();
    assert!(mesh.with_nodes(nodes).is_ok());
    // Points, areas, projections and files are those of the bodies.
    let space = Space::vector(&mesh, 1).unwrap();
    let field = Field::interpolate(&space, |x: &[f64; 2]| [x[1], 2.0 * x[0]]).unwrap();
    assert!(field.evaluate(&[1.0, 1.2]).is_err() && field.evaluate(&[1.0, 0.7]).is_ok());
    let assembler = Assembler::new(&mesh);
    let area = form!(|| -> Functional { integral(cells("all"), 1) + integral(facets("boundary"), 1) });
    assert!((assembler.functional(&area).unwrap() - 8.0).abs() < 1e-14);
    let box_of_punch = form!(|| -> Functional { integral(cells("punch"), 1) });
    let told = assembler.functional(&box_of_punch).unwrap_err().to_string();
    assert!(
        told.contains("\"punch\" is a rigid surface: the cell that carries it is no part of a body"),
        "{told}"
    );
    let twice = form!(|u: State<Vector>| -> Vector { 2 * u });
    let projected = assembler.project(&twice(&field), &space).unwrap();
    for (node, x) in space.positions().iter().enumerate() {
        let inside = x[1] <= 1.0 && x[0] <= 2.0;
        let expected = if inside && !space.nodes_on("punch").unwrap().contains(&(node as u32)) {
            [2.0 * x[1], 4.0 * x[0]]
        } else {
            [0.0; 2]
        };
        let found = projected.at_node(node);
        assert!((0..2).all(|k| (found[k] - expected[k]).abs() < 1e-12), "at {x:?}: {found:?}");
    }
    let file = std::env::temp_dir().join(format!("rigid_surfaces_{}.vtu", std::process::id()));
    VtuFile::new(&mesh).point_data("u", &field).unwrap().write(&file).unwrap();
    let written = std::fs::read_to_string(&file).unwrap();
    std::fs::remove_file(&file).unwrap();
    assert!(
        written.contains("NumberOfPoints=\"45\"") && written.contains("NumberOfCells=\"32\""),
        "{written:.400}"
    );
    assert!(BlockPattern::new(&[&space], &[&space]).is_ok());
}

#[test]
fn surfaces_that_do_not_meet_as_asked_are_named() {
    let mesh = body().with_rigid_surfaces(&[("punch", &punch(0.1))]).unwrap();
    let assembler = Assembler::new(&mesh);
    let report = assembler.pairs(&Pairing::onto("top", "punch"), 2).unwrap();
    // The flat and what is above the slanted sides.
    assert!((report.paired_measure - 1.0).abs() < 1e-14 && report.open == 0, "{report:?}");
    assert!(
        report.largest_gap > 0.1 && report.largest_gap < 0.6 && report.deepest_overlap == 0.0,
        "{report:?}"
    );
    for pairing in [Pairing::between("top", "punch"), Pairing::onto("punch", "top")] {
        let told = assembler.pairs(&pairing, 2).unwrap_err();
        assert_eq!(told, PairError::RigidSide { surface: "punch".to_owned() });
    }
    assert!(matches!(assembler.pairs(&Pairing::within("punch"), 2), Err(PairError::RigidSide { .. })));
    // A tool that begins inside the body: the report says how deep, and where.
    let inside = body().with_rigid_surfaces(&[("punch", &punch(-0.2))]).unwrap();
    let report = Assembler::new(&inside).pairs(&Pairing::onto("top", "punch"), 2).unwrap();
    assert!(
        (report.deepest_overlap - 0.2).abs() < 1e-14 && report.deepest_at.unwrap()[1] == 1.0,
        "{report:?}"
    );
    // One that looks away faces nothing.
    let away = RigidSurface::along(&[[1.4, 1.1], [0.6, 1.1]]).unwrap();
    let away = body().with_rigid_surfaces(&[("punch", &away)]).unwrap();
    let told = Assembler::new(&away).pairs(&Pairing::onto("top", "punch"), 2).unwrap_err();
    assert!(matches!(&told, PairError::NoPartners { .. }), "{told}");
    // First touch moves the tool, by its name.
    let space = Space::vector(&mesh, 2).unwrap();
    let down = Approach { moving: "punch".to_owned(), direction: [0.0, -2.0], overlap: 1e-3 };
    let touch =
        assembler.first_touch(&Pairing::onto("top", "punch"), 3, &Field::zero(&space), &down).unwrap();
    assert!((touch.distance - 0.1).abs() < 1e-14, "{}", touch.distance);
    let report = assembler.pairs_at(&Pairing::onto("top", "punch"), 3, &touch.start).unwrap();
    assert!((report.deepest_overlap - 1e-3).abs() < 1e-14, "{report:?}");
    // A carrier that is bent is no rigid surface.
    let mut values = vec![0.0; space.unknowns()];
    let node = *space.cell_nodes(mesh.cell_region("punch").unwrap()[0] as usize).last().unwrap() as usize;
    values[2 * node] = 0.01;
    let bent = Field::from_values(&space, values).unwrap();
    let told = assembler.pairs_at(&Pairing::onto("top", "punch"), 3, &bent).unwrap_err().to_string();
    assert!(
        told.starts_with(
            "the rigid surface \"punch\" is bent: a node of the cell that carries it is 1e-2 away"
        ),
        "{told}"
    );
}

#[test]
fn motions_and_loads() {
    let mesh = body().with_rigid_surfaces(&[("punch", &punch(0.1))]).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let motion = RigidMap::<2>::turn(0.7, [1.0, 2.0]).then(&RigidMap::translation([0.3, -0.1]));
    let mut constraints = Constraints::new(&space);
    constraints.move_rigidly("punch", &motion).unwrap();
    let mut values = vec![0.0; space.unknowns()];
    constraints.apply(&mut values);
    let (found, away) = RigidMap::nearest(&Field::from_values(&space, values).unwrap(), "punch").unwrap();
    assert!(away < 1e-14, "{away:e}");
    for (found, expected) in found.rotation.as_flattened().iter().zip(motion.rotation.as_flattened()) {
        assert!((found - expected).abs() < 1e-14);
    }
    let axis = [0.3, -0.4, 1.1];
    let turned = RigidMap::<3>::turn(axis, [0.0; 3]);
    let image = turned.apply(&axis);
    assert!(turned.is_motion() && (0..3).all(|k| (image[k] - axis[k]).abs() < 1e-15));
    // Along z counter-clockwise.
    let quarter =
        RigidMap::<3>::turn([0.0, 0.0, std::f64::consts::FRAC_PI_2], [0.0; 3]).apply(&[1.0, 0.0, 0.0]);
    assert!((quarter[1] - 1.0).abs() < 1e-15 && quarter[0].abs() < 1e-15);
    // From where the motion has brought it, small motions are free and the rest follows.
    let mut free = Constraints::new(&space);
    free.rigid_body_from("punch", &motion).unwrap();
    let own = space.nodes_on("punch").unwrap();
    assert_eq!(free.relations().len(), 2 * own.len() - 3);
    for stretched in [[[1.1, 0.0], [0.0, 1.0]], [[1.0, 0.0], [0.0, -1.0]], [[f64::NAN, 0.0], [0.0, 1.0]]] {
        let map = RigidMap { rotation: stretched, translation: [0.0; 2] };
        let told = constraints.move_rigidly("punch", &map).unwrap_err().to_string();
        assert!(told.starts_with("region \"punch\": a rigid body does not move by"), "{told}");
        assert!(Constraints::new(&space).rigid_body_from("punch", &map).is_err());
    }
    let mut loads = RigidLoads::new(&space);
    let told = loads.force("anvil", [0.0; 2], [0.0; 2]).unwrap_err().to_string();
    assert_eq!(told, "there is no rigid surface \"anvil\"; the mesh has \"punch\"");
    let told = loads.force("punch", [0.0; 2], [f64::NAN, 0.0]).unwrap_err().to_string();
    assert!(told.starts_with("the force on \"punch\" is not finite"), "{told}");
    let told = loads.couple("punch", &[1.0, 0.0], &motion).unwrap_err().to_string();
    assert_eq!(told, "the couple on \"punch\" has 2 components; there are 1 rotations");
    let scalar = Space::scalar(&mesh, 1).unwrap();
    assert!(RigidLoads::new(&scalar).force("punch", [0.0; 2], [1.0, 0.0]).is_err());
}
