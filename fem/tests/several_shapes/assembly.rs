//! Matrices and vectors over two shapes: derivatives, sums of element matrices, threads, rules, histories.

use forms_fem::assemble::BlockPattern;
use forms_fem::contract::Side;
use forms_fem::prelude::*;
use forms_fem::verification;

use super::{patchwork, rough};

#[forms(dimension = 2)]
mod everything {
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;
    #[interior_facets]
    pub struct Skeleton;

    /// Nonlinear on cells, facets and between cells, with a kink.
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, (1 + dot(u, u)) * inner(grad(u), grad(v)) + exp(u[0]) * v[1] * h)
            + integral(Wall, pos_part(dot(u, n)) * dot(v, n) / h)
            + integral(Skeleton, avg(h) * pow(jump(u[0]), 3) * jump(v[0]) + dot(avg(grad(u)) * n, this(v)))
    }
    pub fn linear(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (1 + x[0]) * dot(grad(u), grad(v)) + u * v - v) + integral(Wall, u * v)
    }
    pub fn mass(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, u * v)
    }
    pub fn square(u: State<Scalar>) -> Functional {
        integral(Omega, u * u)
    }
}

#[forms(dimension = 2)]
mod kept {
    pub struct Data {
        pub a: History<Scalar>,
        pub level: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;

    pub fn total() -> Functional {
        integral(Omega, a)
    }
    pub fn on_facets() -> Functional {
        integral(Wall, a)
    }
    pub fn grown(u: Scalar) -> Scalar {
        a + u
    }
    pub fn above(u: Scalar) -> Scalar {
        u - level
    }
    pub fn length_above(u: State<Scalar>) -> Functional {
        integral(Wall, heaviside(above(u)))
    }
}

use everything::{Omega, Skeleton, Wall};

fn regions() -> (Omega, Wall, Skeleton) {
    (Omega::on("all"), Wall::on("boundary"), Skeleton::on("interior"))
}

#[test]
fn tangents_are_derivatives() {
    for (geometry, degree) in [(1, 1), (1, 3), (2, 2)] {
        let mesh = patchwork(4, geometry);
        let assembler = Assembler::new(&mesh);
        for space in
            [Space::vector(&mesh, degree).unwrap(), Space::discontinuous_vector(&mesh, degree).unwrap()]
        {
            let u = rough(&space);
            let direction = Field::interpolate(&space, |x| [(5.0 * x[0]).sin(), x[1] - x[0] * x[0]]).unwrap();
            let (omega, wall, skeleton) = regions();
            let form = everything::balance(&omega, &wall, &skeleton);
            let report = verification::tangent(&assembler, &form, &[&u], &[&direction], 1e-2).unwrap();
            assert!(report.second_order().unwrap() > 1.9, "{report}");
        }
    }
}

#[test]
fn matrices_are_sums_of_element_matrices() {
    let mesh = patchwork(4, 1);
    let assembler = Assembler::new(&mesh);
    let space = Space::vector(&mesh, 2).unwrap();
    let (u, spaces) = (rough(&space), [&space]);
    let (omega, wall, skeleton) = regions();
    let form = everything::balance(&omega, &wall, &skeleton);
    let matrix = assembler.tangent(&form, &[&u], &spaces).unwrap();
    let pattern = BlockPattern::for_form(&form, &spaces, &spaces).unwrap();
    assert_eq!(**matrix.pattern(), **pattern.pattern());
    let mut sum = vec![vec![0.0; space.unknowns()]; space.unknowns()];
    for element in assembler.element_matrices(&form, &[&u], &spaces).unwrap() {
        let cells = [element.cell, element.opposite.map_or(element.cell, |opposite| opposite.cell)];
        let of = |side: Side| -> Vec<usize> {
            let nodes = space.cell_nodes(cells[usize::from(side == Side::Other)] as usize);
            nodes.iter().flat_map(|&node| (0..2).map(move |k| node as usize * 2 + k)).collect()
        };
        let (rows, columns) = (of(element.sides[0]), of(element.sides[1]));
        assert_eq!((element.rows, element.columns), (rows.len(), columns.len()));
        for (i, row) in rows.iter().enumerate() {
            for (j, column) in columns.iter().enumerate() {
                sum[*row][*column] += element.values[i * element.columns + j];
            }
        }
    }
    let largest = sum.iter().flatten().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    for (row, sums) in sum.iter().enumerate() {
        for (column, value) in sums.iter().enumerate() {
            assert!((value - matrix.get(row, column)).abs() < 1e-13 * largest);
        }
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    let mesh = patchwork(30, 1);
    let one = Assembler::new(&mesh).with_threads(Threads::new(1));
    let (omega, wall, skeleton) = regions();
    let form = everything::balance(&omega, &wall, &skeleton);
    let space = Space::vector(&mesh, 2).unwrap();
    let (u, spaces) = (rough(&space), [&space]);
    let matrix = one.tangent(&form, &[&u], &spaces).unwrap();
    let vector = one.residual(&form, &[&u], &spaces).unwrap();
    for count in [2, 3] {
        let several = one.clone().with_threads(Threads::new(count));
        assert_eq!(several.tangent(&form, &[&u], &spaces).unwrap().values(), matrix.values());
        assert_eq!(several.residual(&form, &[&u], &spaces).unwrap(), vector);
    }
}

// What quadrilaterals alone and triangles alone give adds up, whatever ways of summation are chosen for each.
#[test]
fn regions_of_one_shape_add_up() {
    let mesh = patchwork(5, 1);
    let assembler = Assembler::new(&mesh);
    for degree in 1..=4 {
        let space = Space::scalar(&mesh, degree).unwrap();
        let (u, spaces) = (rough(&space), [&space]);
        let pattern = BlockPattern::new(&spaces, &spaces).unwrap();
        let of = |region: &str| {
            let form = everything::mass(&Omega::on(region));
            let mut matrix = forms_fem::linear_algebra::BlockMatrix::zero(pattern.sparsity());
            assembler.add_tangent(&form, &[&u], &spaces, Parts::ALL, &pattern, &mut matrix).unwrap();
            (matrix.into_csr().values().to_vec(), assembler.residual(&form, &[&u], &spaces).unwrap())
        };
        let [all, squares, triangles] = ["all", "squares", "triangles"].map(of);
        let total: f64 = all.0.iter().sum();
        assert!((total - 1.0).abs() < 1e-12, "{total}");
        for ((whole, a), b) in all.0.iter().zip(&squares.0).zip(&triangles.0) {
            assert!((whole - a - b).abs() < 1e-16);
        }
        for ((whole, a), b) in all.1.iter().zip(&squares.1).zip(&triangles.1) {
            assert!((whole - a - b).abs() < 1e-16);
        }
    }
}

#[test]
fn a_rule_on_cells_serves_one_shape() {
    let mesh = patchwork(3, 1);
    let cell = QuadratureRule { points: vec![[1.0 / 3.0; 2]], weights: vec![0.5] };
    let facet = QuadratureRule::on_segment(&[(0.5, 1.0)]);
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Explicit { cell, facet });
    let u = rough(&Space::scalar(&mesh, 1).unwrap());
    let error = assembler.functional(&everything::square(&Omega::on("all"), &u)).unwrap_err().to_string();
    let expected = "an explicit rule on cells needs a mesh of one shape; this one has quadrilaterals and triangles: \
                    choose a degree";
    assert!(error.contains(expected), "{error}");
    // Facets have one shape: there it is exact for linear functions.
    let linear = Field::interpolate(&Space::scalar(&mesh, 1).unwrap(), |x| x[0] + 1.0).unwrap();
    let wall = kept::Wall::on("boundary");
    let form = kept::length_above(&kept::data().a(assembler_history(&mesh)).level(0.0), &wall, &linear);
    assert!((assembler.functional(&form).unwrap() - 4.0).abs() < 1e-13);
}

fn assembler_history(mesh: &Mesh<2>) -> History<f64, 2> {
    Assembler::new(mesh).history(Entity::Cells, "all", 3, 2.0).unwrap()
}

#[test]
fn histories_live_on_both_shapes() {
    let mesh = patchwork(4, 1);
    let assembler = Assembler::new(&mesh);
    let u = Field::interpolate(&Space::scalar(&mesh, 2).unwrap(), |x| x[0] * x[0] + x[1]).unwrap();
    for (region, degree) in [("all", 3), ("every other", 4)] {
        let history = assembler.history(Entity::Cells, region, degree, 2.0).unwrap();
        let data = kept::data().a(history).level(0.0);
        let on = kept::Omega::on(region);
        let total = || assembler.functional(&kept::total(&data, &on)).unwrap();
        let before = total();
        assembler.update_history(&kept::grown(&data, &u), &data.a).unwrap();
        assert_eq!(total(), before);
        data.a.commit();
        let again =
            assembler.at_quadrature_points(&kept::grown(&data, &u), Entity::Cells, region, degree).unwrap();
        let area: f64 = again.weights.iter().sum();
        assert!((before - 2.0 * area).abs() < 1e-13);
        let added: f64 =
            again.positions.iter().zip(&again.weights).map(|(x, weight)| weight * (x[0] * x[0] + x[1])).sum();
        assert!((total() - before - added).abs() < 1e-13);
        // Each value is at its own point.
        let stored = assembler.history_values(&data.a).unwrap();
        for (value, x) in stored.iter().zip(&again.positions) {
            assert!((value[0] - 2.0 - x[0] * x[0] - x[1]).abs() < 1e-13);
        }
    }
    let data = kept::data().a(assembler.history(Entity::Facets, "left", 3, 5.0).unwrap()).level(0.0);
    let wall = assembler.functional(&kept::on_facets(&data, &kept::Wall::on("left"))).unwrap();
    assert!((wall - 5.0).abs() < 1e-13);
}

#[test]
fn facets_are_split_on_both_shapes() {
    let mesh = patchwork(6, 1);
    let owners =
        mesh.facet_region("bottom").unwrap().iter().map(|facet| mesh.cell_shape(facet.cell as usize));
    let owners: Vec<CellShape> = owners.collect();
    assert!(owners.contains(&CellShape::Triangle) && owners.contains(&CellShape::Quadrilateral));
    let u = Field::interpolate(&Space::scalar(&mesh, 1).unwrap(), |x| x[0] - 0.13).unwrap();
    let assembler = Assembler::new(&mesh);
    for level in [0.0, 0.1, 0.3, 0.7] {
        let data = kept::data().a(assembler_history(&mesh)).level(level);
        let split = assembler.split_at_zeros(&kept::above(&data, &u), "bottom", 1).unwrap();
        let form = kept::length_above(&data, &kept::Wall::on("bottom"), &u);
        let found = split.functional(&form).unwrap();
        assert!((found - (0.87 - level)).abs() < 1e-13, "{found}");
        let parts = assembler.positive_parts(&kept::above(&data, &u), "bottom", 1).unwrap();
        let sum: f64 = parts.iter().map(|part| (part.positions[1][0] - part.positions[0][0]).abs()).sum();
        assert!((sum - (0.87 - level)).abs() < 1e-13, "{sum}");
    }
}

#[test]
fn affine_forms_need_one_assembly() {
    let mesh = patchwork(4, 1);
    let assembler = Assembler::new(&mesh);
    let (omega, wall, _) = regions();
    let form = everything::linear(&omega, &wall);
    for degree in 1..=4 {
        let space = Space::scalar(&mesh, degree).unwrap();
        let direction = rough(&space);
        // The action runs the residual's loops; the matrix the tangent's.
        let matrix = assembler.tangent(&form, &[&Field::zero(&space)], &[&space]).unwrap();
        let product = matrix.multiply(direction.values()).unwrap();
        let residual = |u: &Field<2>| assembler.residual(&form, &[u], &[&space]).unwrap();
        let (at, zero) = (residual(&direction), residual(&Field::zero(&space)));
        for ((product, at), zero) in product.iter().zip(&at).zip(&zero) {
            assert!((product - (at - zero)).abs() < 1e-12);
        }
    }
}
