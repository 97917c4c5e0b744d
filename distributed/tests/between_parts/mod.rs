//! Tests across parts: controls that are fields, means of the whole body, interior facets, hanging nodes.

use std::collections::BTreeMap;

use forms_distributed::cases::ball_on_flat::{pressed, refined_quarter};
use forms_distributed::cases::facets_between::{self, Jumps, is_in_middle};
use forms_distributed::cases::field_controls::{self, FieldControls, Means};
use forms_distributed::cases::part_adaptivity;
use forms_distributed::cases::parts::{Case, even_trees, trees};
use forms_distributed::cases::report::read;
use forms_distributed::cases::whole_body::{self, MEAN, WithMean};
use forms_fem::prelude::*;

use super::{
    DIGITS, Numbers, PROCESSES, SAME, check, check_to, pressed_ball, refused, solution, steps, told, vertices,
};

fn product<const D: usize>(a: &Field<D>, b: &Field<D>) -> f64 {
    a.values().iter().zip(b.values()).map(|(a, b)| a * b).sum()
}

/// Gradient and Hessian by fields, numbers and the first state, of a criterion with observations, and the first iterates of two minimisations.
#[test]
fn controls_that_are_fields_are_the_same() {
    let (upper, cells) = field_controls::SIZE;
    let mesh = rectangle([0.0; 2], upper, cells, CellShape::Triangle, 1).unwrap();
    for (name, processes) in [("fields", &PROCESSES[..]), ("cell fields", &[3]), ("minima", &[1, 3])] {
        let case = FieldControls::on(&mesh, name == "cell fields").unwrap();
        let assembler = Assembler::new(&mesh).with_threads(Threads::new(1));
        let means = Means {
            whole: &|field| Ok(vertices(field)),
            linear_form: &|form, space| Ok(assembler.linear_form(form, space)?),
            product: &product,
        };
        let mut history = case.history().unwrap();
        if name == "minima" {
            // Rounding grows from one iterate to the next.
            let expected = case.minima(&mut history, &means).unwrap();
            check_to(SAME, processes, &[name], &Numbers::from_iter(expected));
        } else {
            let expected = case.derivatives(&mut history, &means).unwrap();
            check_to(DIGITS, processes, &[name], &Numbers::from_iter(expected));
        }
    }
    assert!(read(&told(2, &["order"]))["order"][0] > 2.9);
    refused(&["far"], "lies outside the mesh");
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
    let on = |shape| facets_between::mesh(shape).unwrap();
    let trees = facets_between::trees().unwrap();
    for (name, mut mesh) in [
        ("penalty", on(CellShape::Hexahedron)),
        ("smooth", on(CellShape::Tetrahedron)),
        ("penalty trees", trees.clone()),
        ("smooth trees", trees),
    ] {
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
        if name.starts_with("smooth") {
            expected.insert("u", vertices(u));
        }
        check_to(DIGITS, &PROCESSES, &[name], &expected);
    }
    // Of 4 × 3 × 3 hexahedra on two processes the first has the nine cells behind its side, the other none.
    assert_eq!(read(&told(2, &["penalty"]))["copies"], [9.0, 0.0]);
}

/// Meshes, estimates, solutions and what is carried from one mesh to the next.
#[test]
fn a_cycle_of_adaptivity_is_the_same() {
    let (triangles, trees) = (["adapted", "0", "2"], |degree| ["adapted trees", "0", degree]);
    for (arguments, shape, degree) in [
        (triangles, CellShape::Triangle, 2),
        (trees("1"), CellShape::Quadrilateral, 1),
        (trees("2"), CellShape::Quadrilateral, 2),
    ] {
        let found = part_adaptivity::on_one((shape, degree), vertices).unwrap();
        assert!(found.cells.len() > 3 && found.cells[1] < 2.5 * found.cells[0], "{:?}", found.cells);
        let expected = BTreeMap::from([
            ("cells", found.cells),
            ("estimates", found.estimates),
            ("u", found.values),
            ("start", found.start),
        ]);
        check_to(DIGITS, &PROCESSES, &arguments, &expected);
    }
}

/// Hanging nodes inside, on sides and on an edge where values are prescribed; the same by a solver that iterates.
#[test]
fn problems_with_hanging_nodes_are_the_same() {
    let mesh = trees(3).unwrap();
    assert!(mesh.hanging_facets().unwrap().len() > 40 && mesh.cell_count() > 100);
    check_to(DIGITS, &PROCESSES, &["trees", "3", "1", "direct"], &solution("trees", &mesh, 1));
    check_to(DIGITS, &PROCESSES, &["trees", "3", "2", "direct"], &solution("trees", &mesh, 2));
    // Where a part of a side ends at a hanging node, its value determines one that gives it.
    let held = Case::new("strip trees", &mesh, 1).unwrap().held;
    let nodes = ["strip", "left"].map(|region| held.space().nodes_on(region).unwrap()).concat();
    assert!(held.prescribed().keys().any(|unknown| !nodes.contains(&(*unknown as u32))));
    check_to(DIGITS, &PROCESSES, &["strip trees", "3", "1", "direct"], &solution("strip trees", &mesh, 1));
    for degree in [1, 2] {
        let expected = solution("rubber trees", &mesh, degree);
        assert!(expected["steps"][0] > 3.0);
        let processes = if degree == 1 { &PROCESSES[..] } else { &[3] };
        check_to(DIGITS, processes, &["rubber trees", "3", &degree.to_string(), "direct"], &expected);
    }
    let expected = solution("hanging trees", &mesh, 2);
    for (method, processes) in [("cg", &PROCESSES[..]), ("gmres", &[3])] {
        check(processes, &["hanging trees", "3", "2", method], &expected);
    }
    // Relations across surfaces whose cells all processes have.
    let expected = solution("rigid trees", &mesh, 2);
    check_to(DIGITS, &PROCESSES, &["rigid trees", "3", "2", "direct"], &expected);
    let expected = solution("periodic trees", &even_trees(3).unwrap(), 1);
    check_to(DIGITS, &PROCESSES, &["periodic trees", "3", "1", "direct"], &expected);
    let problem = pressed(&refined_quarter(4).unwrap(), -1.0).unwrap();
    check_to(DIGITS, &PROCESSES, &["ball trees", "4", "2", "direct"], &pressed_ball(&problem));
}
