//! What goes across parts: means of the whole body, interior facets.

use std::collections::BTreeMap;

use forms_distributed::cases::facets_between::{self, Jumps, is_in_middle};
use forms_distributed::cases::report::read;
use forms_distributed::cases::whole_body::{self, MEAN, WithMean};
use forms_fem::prelude::*;

use super::{DIGITS, PROCESSES, SAME, check_to, steps, told, vertices};

fn product<const D: usize>(a: &Field<D>, b: &Field<D>) -> f64 {
    a.values().iter().zip(b.values()).map(|(a, b)| a * b).sum()
}

/// The multiplier of a mean is one unknown of all processes. The same mean as a relation between all unknowns gives the same solution.
#[test]
fn means_of_the_whole_body_are_the_same() {
    let (upper, cells) = whole_body::SIZE;
    let mesh = rectangle([0.0; 2], upper, cells, CellShape::Triangle, 1).unwrap();
    let case = WithMean::on(&mesh).unwrap();
    let solved = case.problem().solve().unwrap();
    let [u, m] = &solved.fields;
    assert!(solved.iterations() > 2 && m.values()[0].abs() > 0.5);
    let steps = vec![solved.iterations() as f64];
    let expected = BTreeMap::from([("u", vertices(u)), ("m", m.values().to_vec()), ("steps", steps)]);
    check_to(DIGITS, &PROCESSES, &["multiplier"], &expected);

    let space = Space::scalar(&mesh, 2).unwrap();
    let mut mean = Constraints::new(&space);
    mean.mean_value("all", 0, MEAN).unwrap();
    let form = whole_body::model().flow();
    let related = Problem::new(&form, &space).constrained(&mean).solve().unwrap();
    check_to(SAME, &[3], &["multiplier"], &BTreeMap::from([("u", vertices(related.field()))]));

    let form = whole_body::model().balanced();
    let related = Problem::new(&form, &space).constrained(&mean).solve().unwrap();
    let expected = BTreeMap::from([("u", vertices(related.field())), ("mean", vec![MEAN])]);
    check_to(SAME, &PROCESSES, &["pinned"], &expected);
}

/// Each interior facet counts once: in equations of discontinuous and of continuous elements, functionals, and indicators of cells.
#[test]
fn interior_facets_are_the_same() {
    for (name, shape) in [("penalty", CellShape::Hexahedron), ("smooth", CellShape::Tetrahedron)] {
        let mut mesh = facets_between::mesh(shape).unwrap();
        mesh.name_interior_facets("middle", "interior", is_in_middle).unwrap();
        let solved = Jumps::on(&mesh, name).unwrap().problem().solve().unwrap();
        let u = solved.field();
        let rough = |inner| solved.functional(&facets_between::model(inner).roughness(u)).unwrap();
        let cells = Space::discontinuous_scalar(&mesh, 0).unwrap();
        let squares = facets_between::model("interior").squares(u);
        let squares = solved.assembler().linear_form(&squares, &cells).unwrap();
        let squares = Field::from_values(&cells, squares).unwrap();
        let weight = Field::interpolate(&cells, |x| 1.0 + x[0] + (3.0 * x[1]).sin() + x[2]).unwrap();
        let mut expected = BTreeMap::from([
            ("roughness", vec![rough("interior"), rough("middle")]),
            ("norm", vec![product(u, u)]),
            ("indicators", vec![product(&squares, &squares), product(&squares, &weight)]),
            ("steps", steps(&solved)),
        ]);
        if name == "smooth" {
            expected.insert("u", vertices(u));
        }
        check_to(DIGITS, &PROCESSES, &[name], &expected);
    }
    // Of 4 × 3 × 3 hexahedra on two processes the first has the nine cells behind its side, the other none.
    assert_eq!(read(&told(2, &["penalty"]))["copies"], [9.0, 0.0]);
}
