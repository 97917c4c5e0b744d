//! Continuity where coarse cells meet fine ones: its coefficients, and polynomials that solve Poisson's equation exactly.

use forms_fem::constraints::ConstraintsError;
use forms_fem::mesh::{Facet, MeshError};
use forms_fem::prelude::*;

#[forms]
mod models {
    pub struct Data {
        f: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    pub fn poisson(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - f * v)
    }
}

/// The unit box: each cell of a mesh is divided as often as `level` says, at most twice, whatever its neighbours are.
fn graded<const D: usize>(coarse: &Mesh<D>, level: impl Fn(&[f64; D]) -> usize) -> Mesh<D> {
    let middle = coarse.refined().unwrap();
    let fine = middle.refined().unwrap();
    let (shape, children) = (coarse.cell_shape(0), 1 << D);
    // The child at a vertex of a cell has it at the same place.
    let of_middle = |cell: usize, vertex: usize| fine.cell(cell * children + vertex)[vertex];
    let mut cells = Vec::new();
    for cell in 0..coarse.cell_count() {
        let parts = cell * children..(cell + 1) * children;
        match level(&coarse.cell_centre(cell)) {
            0 => cells.extend((0..shape.vertices()).map(|v| of_middle(cell * children + v, v))),
            1 => cells.extend(parts.flat_map(|part| (0..shape.vertices()).map(move |v| of_middle(part, v)))),
            _ => {
                let parts = parts.start * children..parts.end * children;
                cells.extend(parts.flat_map(|part| fine.cell(part).to_vec()));
            }
        }
    }
    let mut mesh = Mesh::from_nonconforming_blocks(1, fine.nodes().to_vec(), vec![(shape, cells)]).unwrap();
    mesh.name_facets("outer", "boundary", |x| x.iter().any(|x| *x < 1e-9 || *x > 1.0 - 1e-9)).unwrap();
    mesh
}

fn polynomial<const D: usize>(x: &[f64; D], degree: usize) -> f64 {
    let along: f64 = x.iter().zip([1.0, -0.5, 0.75]).map(|(x, a)| a * x).sum();
    (0.5 + along).powi(degree as i32)
}

fn solves_exactly<const D: usize>(mesh: &Mesh<D>)
where
    Dim: Dimension<D>,
{
    let gradient: f64 = [1.0, -0.5, 0.75][..D].iter().map(|a| a * a).sum();
    for degree in 1..=4 {
        let space = Space::scalar(mesh, degree).unwrap();
        let source = Given::function(move |x: &[f64; D]| match degree {
            1 => 0.0,
            _ => -(degree as f64) * (degree as f64 - 1.0) * gradient * polynomial(x, degree - 2),
        });
        let form = models::poisson(&models::data().f(source), &models::Omega::on("all"));
        let error = |joined: bool| {
            let mut constraints = Constraints::new(&space);
            if joined {
                constraints.join_hanging_nodes().unwrap();
                // Polynomials of the space's degree satisfy all relations.
                for (&unknown, relation) in constraints.relations() {
                    let value = |unknown: usize| polynomial(&space.positions()[unknown], degree);
                    let sum: f64 = relation.terms.iter().map(|(free, a)| a * value(*free)).sum();
                    assert!((sum + relation.value - value(unknown)).abs() < 1e-12, "degree {degree}");
                }
            }
            constraints.fix("outer", |x| polynomial(x, degree)).unwrap();
            let u = Problem::new(&form, &space).constrained(&constraints).solve().unwrap().into_field();
            let error =
                |node: usize| (u.at_node(node)[0] - polynomial(&space.positions()[node], degree)).abs();
            (0..space.node_count()).map(error).fold(0.0, f64::max)
        };
        assert!(error(true) < 1e-11, "{D} dimensions, degree {degree}: {:e}", error(true));
        // With nothing that holds the sides together it is another solution.
        assert!(error(false) > 1e-4, "{D} dimensions, degree {degree}: {:e}", error(false));
    }
}

#[test]
fn polynomials_are_solved_exactly_across_hanging_nodes() {
    for shape in [CellShape::Quadrilateral, CellShape::Triangle] {
        let coarse = rectangle([0.0; 2], [1.0; 2], [3, 3], shape, 1).unwrap();
        solves_exactly(&graded(&coarse, |x| usize::from(x[0] > 0.4) + usize::from(x[1] > 0.7)));
        // Two levels at once.
        solves_exactly(&graded(&coarse, |x| if x[0] + x[1] > 1.1 { 2 } else { 0 }));
    }
}

#[test]
fn polynomials_are_solved_exactly_in_space() {
    let all = std::env::var_os("FORMS_SWEEPS").is_some();
    for shape in [CellShape::Hexahedron, CellShape::Tetrahedron] {
        let divisions = if all { [3, 3, 3] } else { [2, 2, 1] };
        let coarse = cuboid([0.0; 3], [1.0; 3], divisions, shape, 1).unwrap();
        solves_exactly(&graded(&coarse, |x| usize::from(x[0] > 0.5 && x[1] > 0.5)));
        if all {
            solves_exactly(&graded(&coarse, |x| usize::from(x[0] > 0.4) + usize::from(x[2] > 0.4)));
        }
    }
}

/// One large square on the left, two small ones on the right.
fn one_and_two() -> Mesh<2> {
    let nodes =
        vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.0, 0.5], [1.5, 0.0], [1.5, 0.5], [1.5, 1.0]];
    let cells = vec![0, 1, 2, 3, 1, 5, 6, 4, 4, 6, 7, 2];
    Mesh::from_nonconforming_blocks(1, nodes, vec![(CellShape::Quadrilateral, cells)]).unwrap()
}

/// The coefficients of the textbooks, of all relations in ascending order of their places.
#[test]
fn coefficients_of_degree_one_and_two() {
    let mesh = one_and_two();
    for (degree, expected) in [
        (1, vec![(0.5, vec![0.5, 0.5])]),
        (2, vec![(0.25, vec![0.375, 0.75, -0.125]), (0.5, vec![1.0]), (0.75, vec![-0.125, 0.75, 0.375])]),
    ] {
        let space = Space::scalar(&mesh, degree).unwrap();
        let mut constraints = Constraints::new(&space);
        constraints.join_hanging_nodes().unwrap();
        let height = |unknown: usize| space.positions()[unknown][1];
        let mut found: Vec<(f64, Vec<f64>)> = Vec::new();
        for (&unknown, relation) in constraints.relations() {
            let mut terms = relation.terms.clone();
            terms.sort_by(|a, b| height(a.0).total_cmp(&height(b.0)));
            found.push((height(unknown), terms.iter().map(|(_, a)| *a).collect()));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert_eq!(found.len(), expected.len());
        for ((at, coefficients), (expected_at, expected)) in found.iter().zip(&expected) {
            assert!((at - expected_at).abs() < 1e-15 && coefficients.len() == expected.len());
            coefficients.iter().zip(expected).for_each(|(a, b)| assert!((a - b).abs() < 1e-14, "{a} {b}"));
        }
        assert!(constraints.join_hanging_nodes().is_ok(), "said twice");
    }
}

#[test]
fn vectors_are_joined_component_by_component() {
    let space = Space::vector(&one_and_two(), 3).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.join_hanging_nodes().unwrap();
    // Five places on the small edges that the large one does not have.
    assert_eq!(constraints.relations().len(), 2 * 5);
    for (unknown, relation) in constraints.relations() {
        assert!(relation.terms.iter().all(|(free, _)| free % 2 == unknown % 2));
    }
}

#[test]
fn what_cannot_be_joined_is_named() {
    let discontinuous = Space::discontinuous_scalar(&one_and_two(), 1).unwrap();
    let error = Constraints::new(&discontinuous).join_hanging_nodes().unwrap_err();
    assert!(matches!(error, ConstraintsError::NotContinuous { .. }), "{error}");
    // Two squares next to three.
    let mut nodes = Vec::new();
    let mut cells = Vec::new();
    for (left, count) in [(0.0, 2_u32), (1.0, 3)] {
        let first = nodes.len() as u32;
        for row in 0..=count {
            nodes.extend([0.0, 1.0].map(|x| [left + x, f64::from(row) / f64::from(count)]));
        }
        cells.extend((0..count).flat_map(|k| [0, 1, 3, 2].map(|corner| first + 2 * k + corner)));
    }
    let blocks = vec![(CellShape::Quadrilateral, cells)];
    let mesh = Mesh::from_nonconforming_blocks(1, nodes, blocks).unwrap();
    let error = Constraints::new(&Space::scalar(&mesh, 1).unwrap()).join_hanging_nodes().unwrap_err();
    let crossing = |facet: &Facet| facet.cell < 5;
    match error {
        ConstraintsError::Mesh(MeshError::NotNested { facets, .. }) => assert!(facets.iter().all(crossing)),
        other => panic!("{other}"),
    }
}

/// Bodies whose cells meet with hanging nodes, and one that has such a node of its own: what touches is not glued.
#[test]
fn bodies_that_touch_stay_apart() {
    let square = |low, high, counts| rectangle(low, high, counts, CellShape::Quadrilateral, 1).unwrap();
    let slab = square([0.0, -1.0], [1.0, 0.0], [2, 2]);
    let block = square([0.0, 0.0], [1.0, 1.0], [4, 1]);
    let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap();
    assert_eq!(mesh.hanging_facets().unwrap().len(), 4);
    let error = Constraints::new(&Space::scalar(&mesh, 1).unwrap()).join_hanging_nodes().unwrap_err();
    assert!(error.to_string().contains("bodies that touch are not joined"), "{error}");
    // Two cells below one of the small ones.
    let slab = square([1.0, -0.5], [1.5, 0.0], [2, 1]);
    let alone = one_and_two();
    let mesh = Mesh::of_bodies(&[("block", &alone), ("slab", &slab)]).unwrap();
    let relations = |mesh: &Mesh<2>| {
        let mut constraints = Constraints::new(&Space::scalar(mesh, 2).unwrap());
        constraints.join_hanging_nodes().unwrap();
        constraints.relations().len()
    };
    assert!(mesh.hanging_facets().unwrap().len() > alone.hanging_facets().unwrap().len());
    assert_eq!(relations(&mesh), relations(&alone));
    // One that is below two of them in part.
    let slab = square([0.6, -0.5], [1.4, 0.0], [1, 1]);
    let mesh = Mesh::of_bodies(&[("block", &alone), ("slab", &slab)]).unwrap();
    assert!(matches!(mesh.hanging_facets(), Err(MeshError::NotNested { .. })));
    assert_eq!(relations(&mesh), relations(&alone));
}

/// In space, small edges lie on the boundary, too: their nodes interpolate what is prescribed on the large ones, by one
/// condition or by two that meet there.
#[test]
fn prescribed_values_are_interpolated_on_small_edges() {
    let coarse = cuboid([0.0; 3], [1.0; 3], [2, 2, 2], CellShape::Hexahedron, 1).unwrap();
    let mesh = graded(&coarse, |x| usize::from(x[0] > 0.5));
    let mut halves = mesh.clone();
    halves.name_facets("low", "outer", |x| x[2] < 1e-9).unwrap();
    halves.name_facets("sides", "outer", |x| x[2] > 1e-9).unwrap();
    let value = |x: &[f64; 3]| (x[0] + 2.0 * x[1] - x[2]).exp();
    let mut results = Vec::new();
    for (mesh, regions) in [(&mesh, vec!["outer"]), (&halves, vec!["low", "sides"])] {
        let space = Space::scalar(mesh, 1).unwrap();
        let mut constraints = Constraints::new(&space);
        constraints.join_hanging_nodes().unwrap();
        for region in regions {
            constraints.fix(region, value).unwrap();
        }
        let mut values: Vec<f64> = space.positions().iter().map(value).collect();
        constraints.apply(&mut values);
        for (node, x) in space.positions().iter().enumerate() {
            // On the outer boundary, in the plane where the sizes change.
            let hangs = x[0] == 0.5 && x[1] == 0.25 && x[2] == 0.0;
            let expected =
                if hangs { 0.5 * (value(&[0.5, 0.0, 0.0]) + value(&[0.5, 0.5, 0.0])) } else { value(x) };
            let on_boundary = x.iter().any(|x| *x == 0.0 || *x == 1.0);
            let plane = x[0] == 0.5 && !hangs;
            assert!(!on_boundary || plane || (values[node] - expected).abs() < 1e-12, "{x:?}");
        }
        results.push(values);
        // Other values on the large edges are a conflict, as always.
        let error = constraints.fix("outer", |x| value(x) + 1.0).unwrap_err();
        assert!(matches!(error, ConstraintsError::Conflict { .. }), "{error}");
    }
    results[0].iter().zip(&results[1]).for_each(|(a, b)| assert!((a - b).abs() < 1e-13 * a.abs()));
}

/// A relation gives the unknown that it names; what others have given is left alone.
#[test]
fn relations_name_the_unknown_that_they_give() {
    let mesh = rectangle([0.0; 2], [3.0, 1.0], [3, 1], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::scalar(&mesh, 1).unwrap();
    let mut constraints = Constraints::new(&space);
    // The sum would have given the unknown with the larger coefficient.
    constraints.relate("a lever", 2, &[(5, 3.0), (6, -2.0)], 1.0).unwrap();
    assert_eq!(constraints.relations()[&2].terms, [(5, 3.0), (6, -2.0)]);
    // Through another one, and put into the first.
    constraints.relate("a rod", 5, &[(7, 0.5)], 0.0).unwrap();
    assert_eq!(constraints.relations()[&2].terms, [(6, -2.0), (7, 1.5)]);
    constraints.relate("the lever again", 2, &[(7, 1.5), (6, -2.0)], 1.0).unwrap();
    let before = constraints.relations().clone();
    let message = |outcome: Result<(), ConstraintsError>| outcome.unwrap_err().to_string();
    let given = message(constraints.relate("another lever", 2, &[(7, 1.0)], 0.0));
    assert!(
        given.starts_with("another lever cannot give unknown 2, at ") && given.contains("a lever"),
        "{given}"
    );
    let contradiction = message(constraints.relate("a longer rod", 5, &[(7, 0.5)], 1.0));
    assert!(contradiction.starts_with("a longer rod contradicts a rod"), "{contradiction}");
    assert!(message(constraints.relate("x", 8, &[(0, 1.0)], 0.0)).contains("no unknown 8"));
    assert!(message(constraints.relate("x", 0, &[(1, f64::NAN)], 0.0)).contains("not finite: NaN"));
    assert!(message(constraints.relate("x", 0, &[], 0.0)).starts_with("x: 0 unknowns are related"));
    assert_eq!(constraints.relations(), &before);
}
