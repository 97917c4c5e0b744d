//! Multipliers that are not determined are refused by name.

use forms_contact::laws::mortar_bodies as law;
use forms_contact::laws::mortar_bodies::mortar_problem;
use forms_contact::multiplier_nodes::{MultiplierError, check_multipliers, note_on_sharp_edges};
use forms_fem::constraints::RigidMap;
use forms_fem::prelude::*;

use crate::exact::{dual, multipliers};

fn mesh() -> Mesh<2> {
    let slab = rectangle([0.0, -0.4], [4.0, 0.0], [11, 1], CellShape::Quadrilateral, 1).unwrap();
    let block = rectangle([0.5, 0.0], [1.5, 1.0], [4, 3], CellShape::Quadrilateral, 1).unwrap();
    Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap()
}

#[test]
fn nodes_without_a_condition_of_their_own() {
    let mesh = mesh();
    for degree in [1, 2] {
        let space = Space::vector(&mesh, degree).unwrap();
        let on = |region: &str| Space::on_facets(&mesh, region, 1).unwrap();
        let (own, bottom) = ("block bottom", on("block bottom"));
        let pairing = Pairing::onto(own, "slab top");
        let mut held = Constraints::new(&space);
        held.fix("slab bottom", |_| [0.0; 2]).unwrap();
        held.fix_component("block left", 0, |_| 0.0).unwrap();
        assert_eq!(check_multipliers(&[(&pairing, &bottom)], &held), Ok(()));

        let side = Pairing::onto("block left", "slab top");
        let found = check_multipliers(&[(&pairing, &bottom), (&side, &on("block left"))], &held).unwrap_err();
        let expected = MultiplierError::Shared {
            first: own.to_owned(),
            second: "block left".to_owned(),
            position: vec![0.5, 0.0],
        };
        assert_eq!(found, expected);
        // The opposite surface has no conditions.
        let slab = Pairing::onto("slab right", "block bottom");
        let free = Constraints::new(&space);
        assert_eq!(check_multipliers(&[(&pairing, &bottom), (&slab, &on("slab right"))], &free), Ok(()));

        let both = Pairing::between(own, "slab top");
        let found = check_multipliers(&[(&both, &bottom)], &held).unwrap_err();
        assert!(matches!(found, MultiplierError::OwnSurfaces { count: 2, .. }), "{found}");
        let found = check_multipliers(&[(&pairing, &on("slab top"))], &held).unwrap_err();
        assert!(found.to_string().contains("the multipliers are those of \"slab top\""), "{found}");
        let found = check_multipliers(&[(&pairing, &space)], &held).unwrap_err();
        assert!(found.to_string().contains("no multipliers on facets"), "{found}");

        assert_eq!(check_multipliers(&[(&pairing, &dual(&mesh, own, &[]))], &held), Ok(()));
        let negative = Space::on_facets(&mesh, own, 2).unwrap();
        let found = check_multipliers(&[(&pairing, &negative)], &held).unwrap_err();
        assert!(found.to_string().contains("Lagrange elements of degree 2"), "{found}");

        let quadratic = check_multipliers(&[(&pairing, &multipliers(&mesh, own, 2, &[]))], &held);
        let too_many = MultiplierError::TooMany { own: own.to_owned(), multipliers: 3, nodes: 2 };
        assert_eq!(quadratic, if degree == 1 { Err(too_many) } else { Ok(()) });

        let mut periodic = Constraints::new(&space);
        periodic.periodic("slab left", "slab right", &RigidMap::translation([4.0, 0.0])).unwrap();
        let over_slab = Pairing::onto("slab top", own);
        let found = check_multipliers(&[(&over_slab, &on("slab top"))], &periodic).unwrap_err();
        assert!(matches!(found, MultiplierError::Periodic { .. }), "{found}");
        assert!(found.to_string().contains("[0.0, 0.0]"), "{found}");
        assert_eq!(check_multipliers(&[(&pairing, &bottom)], &periodic), Ok(()));

        held.fix("block right", |_| [0.0; 2]).unwrap();
        let data = law::data().lambda(1.0).mu(1.0).gamma0(1.0);
        let regions = law::Regions::default().touch(pairing).own(own).gamma_n("block top");
        let model = law::Model { data, regions };
        let Err(found) = mortar_problem(&model, [&space, &bottom], &held) else { panic!("it is refused") };
        assert_eq!(found, MultiplierError::Prescribed { own: own.to_owned(), position: vec![1.5, 0.0] });
    }
}

#[test]
fn sharp_edges_of_own_surfaces_are_noted() {
    let mut mesh = mesh();
    mesh.name_facets("lower left", "block left", |x| x[1] < 0.6).unwrap();
    let listed =
        ["block bottom", "lower left"].map(|name| mesh.facet_region(name).unwrap().to_vec()).concat();
    mesh.name_listed_facets("bottom and left", &listed).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("slab bottom", |_| [0.0; 2]).unwrap();
    held.fix("block top", |_| [0.0; 2]).unwrap();
    let notes = |own: &str| {
        let (regions, pressures) = (law::Regions::default(), Space::on_facets(&mesh, own, 1).unwrap());
        let regions = regions.touch(Pairing::onto(own, "slab top")).own(own).gamma_n("block right");
        let model = law::Model { data: law::data().lambda(1.0).mu(1.0).gamma0(10.0), regions };
        mortar_problem(&model, [&space, &pressures], &held).unwrap().solve().unwrap().notes()
    };
    let is_told = |note: &String| note.contains("turns by 90° at [0.5, 0.0]: the mean gap");
    assert!(notes("bottom and left").iter().any(is_told), "{:?}", notes("bottom and left"));
    assert!(!notes("block bottom").iter().any(|note| note.contains("turns by")));

    // Curved facets, whose chords differ by 90°, meet without an edge.
    let of_rim = |degree: usize| {
        let ring = annulus(0.5, 1.0, 1, 4, CellShape::Quadrilateral, degree).unwrap();
        note_on_sharp_edges(&Pairing::onto("outer", "inner"), &ring).unwrap()
    };
    assert!(of_rim(1).is_some_and(|note| note.contains("turns by 90°") && note.contains("3 more nodes")));
    assert_eq!(of_rim(2), None);
    for shape in [CellShape::Hexahedron, CellShape::Tetrahedron] {
        let mut cube = cuboid([0.0; 3], [1.0; 3], [2; 3], shape, 1).unwrap();
        cube.name_facets("corner", "boundary", |x| x[0] == 0.0 || x[1] == 0.0).unwrap();
        cube.name_facets("side", "boundary", |x| x[0] == 0.0).unwrap();
        let note = |own| note_on_sharp_edges(&Pairing::onto(own, "right"), &cube).unwrap();
        let parts =
            ["corner onto right turns by 90° at [0.0, 0.0, ", "], and by more than 60° at 2 more nodes"];
        let corner = note("corner").unwrap();
        assert!(parts.iter().all(|part| corner.contains(part)), "{corner}");
        assert_eq!(note("side"), None);
    }
}
