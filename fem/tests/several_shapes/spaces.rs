//! Spaces on two shapes: unknowns are shared where cells meet, and polynomials are held.

use forms_fem::prelude::*;

use super::{patchwork, rough};

#[forms(dimension = 2)]
mod skeleton {
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;
    #[interior_facets]
    pub struct Skeleton;

    pub fn jump_squared(u: State<Scalar>) -> Functional {
        integral(Skeleton, jump(u) * jump(u))
    }
    pub fn value_squared(u: State<Scalar>) -> Functional {
        integral(Skeleton, this(u) * other(u))
    }
    /// Zero for every broken field, by the divergence theorem on each cell.
    pub fn balance(w: State<Vector>) -> Functional {
        integral(Omega, div(w)) - integral(Wall, dot(w, n)) - integral(Skeleton, dot(jump(w), n))
    }
}

#[test]
fn counts_follow_from_euler() {
    let mesh = patchwork(6, 1);
    let (vertices, edges) = (7 * 7, mesh.facet_count());
    for degree in 1..=4_usize {
        let inside = [(degree - 1) * (degree - 1), (degree - 1) * degree.saturating_sub(2) / 2];
        let nodes = vertices + edges * (degree - 1) + 24 * inside[0] + 24 * inside[1];
        let space = Space::vector(&mesh, degree).unwrap();
        assert_eq!((space.node_count(), space.unknowns()), (nodes, 2 * nodes));
        assert_eq!(space.nodes_on("left").unwrap().len(), 6 * degree + 1);
        assert_eq!(space.nodes_on("all").unwrap().len(), nodes);
        let broken = Space::discontinuous_scalar(&mesh, degree).unwrap();
        let per_cell = (degree + 1) * (degree + 1) + (degree + 1) * (degree + 2) / 2;
        assert_eq!(broken.node_count(), 24 * per_cell);
        let on_facets = Space::on_facets(&mesh, "boundary", degree).unwrap();
        assert_eq!(on_facets.node_count(), 24 * degree);
        let inside = Space::on_facets(&mesh, "interior", 0).unwrap();
        assert_eq!(inside.node_count(), mesh.interior_facets().len());
    }
}

// Two cells see a node at one place, and no two nodes are at one place.
#[test]
fn nodes_are_shared_where_they_coincide() {
    for geometry in 1..=2 {
        let mesh = patchwork(5, geometry);
        for degree in 1..=4 {
            let space = Space::scalar(&mesh, degree).unwrap();
            for cell in 0..mesh.cell_count() {
                let points = space.cell_element(cell).node_points::<2>();
                assert_eq!(points.len(), space.cell_nodes(cell).len());
                for (&node, point) in space.cell_nodes(cell).iter().zip(&points) {
                    let (x, position) = (mesh.map(cell, point).0, space.positions()[node as usize]);
                    assert!((0..2).all(|k| (x[k] - position[k]).abs() < 1e-14), "{cell} {node}");
                }
            }
            let mut places: Vec<_> =
                space.positions().iter().map(|x| x.map(|x| (1e9 * x).round() as i64)).collect();
            places.sort_unstable();
            places.dedup();
            assert_eq!(places.len(), space.node_count());
        }
    }
}

#[test]
fn continuous_fields_do_not_jump_between_shapes() {
    for geometry in 1..=2 {
        let mesh = patchwork(6, geometry);
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(8));
        for degree in 1..=4 {
            let u = rough(&Space::scalar(&mesh, degree).unwrap());
            for region in ["interior", "seam"] {
                let inside = skeleton::Skeleton::on(region);
                let jumps = assembler.functional(&skeleton::jump_squared(&inside, &u)).unwrap();
                let values = assembler.functional(&skeleton::value_squared(&inside, &u)).unwrap();
                assert!(values > 0.01 && jumps < 1e-26 * values, "{region} {degree}: {jumps:e} of {values}");
            }
        }
    }
}

#[test]
fn the_divergence_theorem_holds_across_shapes() {
    for (geometry, tolerance) in [(1, 1e-13), (2, 1e-12)] {
        let mesh = patchwork(6, geometry);
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(16));
        let (omega, wall, inside) =
            (skeleton::Omega::on("all"), skeleton::Wall::on("boundary"), skeleton::Skeleton::on("interior"));
        for degree in 0..=4 {
            let w = rough(&Space::discontinuous_vector(&mesh, degree).unwrap());
            let rest = assembler.functional(&skeleton::balance(&omega, &wall, &inside, &w)).unwrap();
            assert!(rest.abs() < tolerance, "degree {degree}: {rest:e}");
        }
    }
}

// P_k is held by both elements on straight cells: Q_k with bilinear coordinates contains it.
#[test]
fn polynomials_are_held() {
    let mesh = patchwork(4, 1);
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(10));
    for degree in 1..=4 {
        let k = degree as i32;
        let value = move |x: &[f64; 2]| (x[0] - 0.3 * x[1]).powi(k) + x[1].powi(k - 1);
        let slope = move |x: &[f64; 2]| {
            let inner = f64::from(k) * (x[0] - 0.3 * x[1]).powi(k - 1);
            let outer = if k > 1 { f64::from(k - 1) * x[1].powi(k - 2) } else { 0.0 };
            [inner, -0.3 * inner + outer]
        };
        for space in [Space::scalar(&mesh, degree), Space::discontinuous_scalar(&mesh, degree)] {
            let field = Field::interpolate(&space.unwrap(), value).unwrap();
            let errors = norms::errors(
                &assembler,
                &field,
                move |x, v| v[0] = value(x),
                move |x, v| v.copy_from_slice(&slope(x)),
            );
            let errors = errors.unwrap();
            assert!(errors.h1 < 1e-12, "degree {degree}: {errors:?}");
        }
        // A space of a lower degree lies in one of a higher degree.
        if degree > 1 {
            let coarse =
                Field::interpolate(&Space::scalar(&mesh, degree - 1).unwrap(), |x| (3.0 * x[0]).sin() * x[1])
                    .unwrap();
            let fine = Space::scalar(&mesh, degree).unwrap();
            let values = fine.embedding(coarse.space()).unwrap().multiply(coarse.values()).unwrap();
            for (value, x) in values.iter().zip(fine.positions()) {
                assert!((value - coarse.evaluate(x).unwrap()[0]).abs() < 1e-11);
            }
        }
    }
}

#[test]
fn degrees_that_do_not_exist_are_refused() {
    let mesh = patchwork(3, 1);
    let message = |space: Result<Arc<Space<2>>, _>| {
        space.map(|_| ()).map_err(|error: forms_fem::space::SpaceError| error.to_string())
    };
    for (space, word) in [
        (Space::scalar(&mesh, 5), "5"),
        (Space::scalar(&mesh, 0), "0"),
        (Space::discontinuous_scalar(&mesh, 5), "5"),
    ] {
        assert!(message(space).unwrap_err().contains(word));
    }
}
