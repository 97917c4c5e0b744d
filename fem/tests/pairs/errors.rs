//! Errors of surfaces that cannot be paired, by name.

use forms_fem::pairs::PairError;
use forms_fem::prelude::*;

use super::squares;

#[forms]
mod touching {
    #[pairs]
    pub struct Touch;

    pub fn area() -> Functional {
        integral(Touch, 1)
    }
    pub fn distance() -> Scalar {
        gap
    }
}

#[forms]
mod remembering {
    pub struct Data {
        worn: History<Scalar>,
    }
    #[pairs]
    pub struct Touch;

    pub fn remembered() -> Functional {
        integral(Touch, this(worn))
    }
}

fn message<T>(found: Result<T, impl ToString>) -> String {
    found.err().map(|error| error.to_string()).unwrap_or_default()
}

#[test]
fn surfaces_that_cannot_be_paired() {
    let mut mesh = Mesh::clone(&squares([CellShape::Quadrilateral; 2], 1, [&|x| x, &|[x, y]| [x, y + 0.1]]));
    mesh.name_facets("corner", "below", |x| x[0] < 0.3).unwrap();
    let assembler = Assembler::new(&mesh);
    let pairs = |pairing: Pairing| assembler.pairs(&pairing, 2);
    let of_form =
        |pairing: Pairing| message(assembler.functional(&touching::area(&touching::Touch::on(pairing))));
    assert!(matches!(pairs(Pairing::onto("below", "sky")), Err(PairError::Surface { .. })));
    assert!(of_form(Pairing::onto("below", "sky")).starts_with(
        "form `area`, pairs `Touch` (below onto sky): there is no facet region \"sky\"; the mesh has"
    ));
    assert_eq!(
        of_form(Pairing::onto("below", "corner")),
        "form `area`, pairs `Touch` (below onto corner): \"below\" and \"corner\" have 1 facets in common, one of them at \
         [0.16666666666666666, 1.0]; for self contact give one name twice (`Pairing::within`)"
    );
    for reach in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = pairs(Pairing::onto("below", "above").within_reach(reach));
        assert!(matches!(found, Err(PairError::Reach { .. })), "{found:?}");
    }
    assert_eq!(
        message(pairs(Pairing::onto("below", "above").within_reach(0.05))),
        "no point of \"below\" faces \"above\" within reach (0 points met it from behind or further away)"
    );
    // The upper sides of both bodies look the same way.
    let behind = pairs(Pairing::onto("below", "second top").within_reach(9.0));
    let met = |error: &PairError| matches!(error, PairError::NoPartners { .. });
    assert!(behind.as_ref().is_err_and(met), "{behind:?}");
    let none = Pairing { surfaces: vec![], ..Pairing::onto("below", "above") };
    assert_eq!(pairs(none), Err(PairError::NoSurfaces));
}

#[test]
fn what_pairs_do_not_have() {
    let mesh = squares([CellShape::Quadrilateral; 2], 1, [&|x| x, &|[x, y]| [x, y + 0.1]]);
    let assembler = Assembler::new(&mesh);
    let worn: History<f64, 2> = assembler.history(Entity::Facets, "below", 2, 0.0).unwrap();
    let data = remembering::data().worn(worn);
    let touch = remembering::Touch::on(Pairing::onto("below", "above"));
    assert_eq!(
        message(assembler.functional(&remembering::remembered(&data, &touch))),
        "form `remembered`, history `worn`: it was made for \"below\", and is read on the pairs below onto above; \
         `history_on_pairs` makes one for a pairing"
    );
    let distance = touching::distance();
    assert_eq!(
        message(assembler.along_facets_uniformly(&distance, "below", 2)),
        "`distance` reads the gap or an opposite point, but the region \"below\" consists of no contact pairs"
    );
    assert!(
        message(assembler.at_quadrature_points(&distance, Entity::Pairs, "below", 2)).contains("at_pairs")
    );
    assert!(message(assembler.history::<f64>(Entity::Pairs, "below", 2, 0.0)).contains("contact pairs"));
}
