//! Lagrange elements of degree 1 to 4: against basix, across facets of meshes numbered at random, and their orders.

use forms_fem::element::Lagrange;
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
    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, 2.0 * inner(eps(u), eps(v)) + 1.5 * div(u) * div(v))
    }
    pub fn value() -> Scalar {
        f
    }
}

const DEGREES: std::ops::RangeInclusive<usize> = 1..=4;

/// Numbers in [0, 1) that look like chance (Knuth's linear congruential generator).
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }
}

/// Orders of a cell's vertices that keep it the right way round.
fn turns(shape: CellShape) -> Vec<Vec<usize>> {
    match shape {
        CellShape::Triangle => vec![vec![1, 2, 0]],
        CellShape::Quadrilateral => vec![vec![1, 2, 3, 0]],
        CellShape::Tetrahedron => vec![vec![1, 2, 0, 3], vec![0, 2, 3, 1]],
        CellShape::Hexahedron => vec![vec![1, 2, 3, 0, 5, 6, 7, 4], vec![4, 5, 1, 0, 7, 6, 2, 3]],
    }
}

/// A straight mesh of the same cells with vertices numbered, and cells turned, at random; vertices inside are moved
/// by up to `distortion`.
fn shuffled<const D: usize>(mesh: &Mesh<D>, distortion: f64) -> Mesh<D> {
    let mut chance = Chance(7);
    let mut numbers: Vec<u32> = (0..mesh.node_count() as u32).collect();
    for last in (1..numbers.len()).rev() {
        numbers.swap(last, chance.below(last + 1));
    }
    let mut nodes = vec![[0.0; D]; numbers.len()];
    for (old, x) in mesh.nodes().iter().enumerate() {
        let inside = x.iter().all(|x| *x > 1e-9 && *x < 1.0 - 1e-9);
        nodes[numbers[old] as usize] =
            x.map(|x| if inside { x + distortion * (2.0 * chance.next() - 1.0) } else { x });
    }
    let mut cells = Vec::new();
    let turns = turns(mesh.cell_shape(0));
    for cell in 0..mesh.cell_count() {
        let mut vertices: Vec<u32> = mesh.cell(cell).iter().map(|node| numbers[*node as usize]).collect();
        for _ in 0..chance.below(9) {
            let turn = &turns[chance.below(turns.len())];
            vertices = turn.iter().map(|&place| vertices[place]).collect();
        }
        cells.extend(vertices);
    }
    Mesh::from_parts(mesh.cell_shape(0), 1, nodes, cells).unwrap()
}

fn square(shape: CellShape, n: usize, distortion: f64) -> Mesh<2> {
    shuffled(&rectangle([0.0; 2], [1.0; 2], [n, n], shape, 1).unwrap(), distortion / n as f64)
}

fn cube(shape: CellShape, n: usize, distortion: f64) -> Mesh<3> {
    shuffled(&cuboid([0.0; 3], [1.0; 3], [n, n, n], shape, 1).unwrap(), distortion / n as f64)
}

const FLAT: [CellShape; 2] = [CellShape::Triangle, CellShape::Quadrilateral];
const SOLID: [CellShape; 2] = [CellShape::Tetrahedron, CellShape::Hexahedron];

fn check_against_basix<const D: usize>(element: Lagrange, lines: &[Vec<f64>]) {
    let point: [f64; D] = std::array::from_fn(|k| [0.17, 0.23, 0.31][k]);
    let (nodes, tables) = (element.node_points::<D>(), element.tabulate(&[point]));
    assert_eq!((nodes.len(), lines.len()), (element.nodes(), element.nodes()));
    for (node, x) in nodes.iter().enumerate() {
        let mut same = lines.iter().filter(|line| (0..D).all(|k| (line[k] - x[k]).abs() < 1e-12));
        let line = same.next().expect("basix has the node");
        assert!(same.next().is_none());
        assert!((tables.value[node] - line[D]).abs() < 1e-14, "{element:?} {x:?}");
        for k in 0..D {
            assert!((tables.gradient[node][k] - line[D + 1 + k]).abs() < 1e-13, "{element:?} {x:?}");
        }
    }
}

#[test]
fn values_and_gradients_are_those_of_basix() {
    let lines = include_str!("elements/basix.txt").lines();
    let lines: Vec<Vec<&str>> = lines.map(|line| line.split(' ').collect()).collect();
    for shape in CellShape::ALL {
        for degree in DEGREES {
            let own = lines.iter().filter(|line| line[0] == shape.name() && line[1] == degree.to_string());
            let own: Vec<Vec<f64>> =
                own.map(|line| line[2..].iter().map(|number| number.parse().unwrap()).collect()).collect();
            let element = Lagrange::new(shape, degree).unwrap();
            match shape.dimension() {
                2 => check_against_basix::<2>(element, &own),
                _ => check_against_basix::<3>(element, &own),
            }
        }
    }
}

/// (1 + c·x)^k.
fn power<const D: usize>(x: &[f64; D], degree: usize) -> f64 {
    let coefficients = [0.7, -0.4, 0.5];
    (1.0 + (0..D).map(|k| coefficients[k] * x[k]).sum::<f64>()).powi(degree as i32)
}

fn check_sharing<const D: usize>(mesh: &Mesh<D>, n: usize, degree: usize) {
    let space = Space::scalar(mesh, degree).unwrap();
    assert_eq!(space.node_count(), (degree * n + 1).pow(D as u32));
    // Each cell finds its nodes where the space says that they are.
    let points = space.cell_element(0).node_points::<D>();
    for cell in 0..mesh.cell_count() {
        for (&node, point) in space.cell_nodes(cell).iter().zip(&points) {
            let (x, position) = (mesh.map(cell, point).0, space.positions()[node as usize]);
            assert!((0..D).all(|k| (x[k] - position[k]).abs() < 1e-14), "{:?} {degree}", mesh.cell_shape(0));
        }
    }
    // Polynomials are reproduced inside the cells, which are parallelepipeds here.
    let field = Field::interpolate(&space, |x| power(x, degree)).unwrap();
    let mut chance = Chance(11);
    for cell in 0..mesh.cell_count() {
        let point: [f64; D] = std::array::from_fn(|_| chance.next() / 3.0);
        let exact = power(&mesh.map(cell, &point).0, degree);
        assert!((field.evaluate_in(cell, &point)[0] - exact).abs() < 1e-13 * 2.2_f64.powi(degree as i32));
    }
    // Values at random are continuous across facets.
    let values = (0..space.unknowns()).map(|_| chance.next()).collect();
    let rough = Field::from_values(&space, values).unwrap();
    let shape = mesh.cell_shape(0);
    for sides in mesh.interior_facets() {
        let corners = shape.facet_vertices(sides[0].local.into());
        let corners = [corners[0], corners[1], corners[corners.len() - 1]];
        let global = corners.map(|corner| mesh.cell(sides[0].cell as usize)[corner]);
        let (s, t) = (0.4 * chance.next(), 0.4 * chance.next());
        let seen = sides.map(|side| {
            let own = mesh.cell(side.cell as usize);
            let [a, b, c] = global.map(|vertex| {
                shape.vertex_points()[own.iter().position(|own| *own == vertex).expect("they share it")]
            });
            let t = if D == 2 { 0.0 } else { t };
            let point = std::array::from_fn(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
            rough.evaluate_in(side.cell as usize, &point)[0]
        });
        assert!((seen[0] - seen[1]).abs() < 1e-13, "{shape:?} {degree}: {seen:?}");
    }
    // The nodes of a side of the box.
    let whole = space.nodes_on("boundary").unwrap().len();
    assert_eq!(whole, (degree * n + 1).pow(D as u32) - (degree * n - 1).pow(D as u32));
    assert_eq!(Space::on_facets(mesh, "boundary", degree).unwrap().node_count(), whole);
}

#[test]
fn cells_share_the_nodes_of_edges_and_faces_whatever_their_numbers() {
    for degree in DEGREES {
        for shape in FLAT {
            check_sharing(&square(shape, 4, 0.0), 4, degree);
        }
        for shape in SOLID {
            check_sharing(&cube(shape, 3, 0.0), 3, degree);
        }
    }
}

macro_rules! errors_of_poisson {
    ($mesh:expr, $degree:expr, $dimension:literal) => {{
        let (mesh, pi) = ($mesh, std::f64::consts::PI);
        let exact = move |x: &[f64; $dimension]| x.iter().map(|x| (pi * x + 0.3).sin()).product::<f64>();
        let slope = move |x: &[f64; $dimension]| -> [f64; $dimension] {
            std::array::from_fn(|k| exact(x) * pi * (pi * x[k] + 0.3).cos() / (pi * x[k] + 0.3).sin())
        };
        let load = move |x: &[f64; $dimension]| f64::from($dimension) * pi * pi * exact(x);
        let space = Space::scalar(&mesh, $degree).unwrap();
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(2 * $degree + 2));
        let data = models::data().f(load);
        let form = models::poisson(&data, &models::Omega::on("all"));
        let mut walls = Constraints::new(&space);
        walls.fix("boundary", exact).unwrap();
        let problem = Problem::new(&form, &space).assembler(&assembler);
        let field = problem.constrained(&walls).solve().unwrap().into_field();
        let errors = norms::errors(
            &assembler,
            &field,
            move |x, value| value[0] = exact(x),
            move |x, gradient| gradient.copy_from_slice(&slope(x)),
        )
        .unwrap();
        [errors.l2, errors.seminorm]
    }};
}

fn check_orders(name: &str, degree: usize, coarse: [f64; 2], fine: [f64; 2], ratio: f64, lost: f64) {
    for (which, expected) in [degree as f64 + 1.0, degree as f64].into_iter().enumerate() {
        let order = (coarse[which] / fine[which]).ln() / ratio.ln();
        println!("{name} degree {degree}: order {order:.2} of {expected}, error {:.2e}", fine[which]);
        assert!(order > expected - lost, "{name}, degree {degree}: order {order} instead of {expected}");
    }
}

#[test]
fn poisson_converges_with_the_order_of_the_degree() {
    for degree in DEGREES {
        for shape in FLAT {
            let errors = [8, 16].map(|n| errors_of_poisson!(square(shape, n, 0.15), degree, 2));
            check_orders(shape.name(), degree, errors[0], errors[1], 2.0, 0.25);
        }
        for shape in SOLID {
            let errors = [3, 6].map(|n| errors_of_poisson!(cube(shape, n, 0.08), degree, 3));
            check_orders(shape.name(), degree, errors[0], errors[1], 2.0, 0.5);
        }
    }
}

macro_rules! patch_of_elasticity {
    ($mesh:expr, $degree:expr, $dimension:literal) => {
        let mesh = $mesh;
        let linear = |x: &[f64; $dimension]| -> [f64; $dimension] {
            std::array::from_fn(|k| 0.1 * x[k] + 0.3 * x[(k + 1) % $dimension] - 0.2)
        };
        let space = Space::vector(&mesh, $degree).unwrap();
        let assembler = Assembler::new(&mesh);
        let data = models::data().f(0.0);
        let form = models::elasticity(&data, &models::Omega::on("all"));
        let mut walls = Constraints::new(&space);
        walls.fix("boundary", linear).unwrap();
        let problem = Problem::new(&form, &space).assembler(&assembler);
        let found = problem.constrained(&walls).solve().unwrap().into_field();
        let exact = Field::interpolate(&space, linear).unwrap();
        for (a, b) in found.values().iter().zip(exact.values()) {
            assert!((a - b).abs() < 1e-12, "{:?} {}: {a} against {b}", mesh.cell_shape(0), $degree);
        }
        // The matrix, whose blocks are placed by a map, compared with the residual, which needs none.
        let values = (0..space.unknowns()).map(|index| ((index * 37 + 5) % 23) as f64 / 23.0).collect();
        let rough = Field::from_values(&space, values).unwrap();
        let matrix = assembler.tangent(&form, &[&rough], &[&space]).unwrap();
        let product = matrix.multiply(rough.values()).unwrap();
        let residual = assembler.residual(&form, &[&rough], &[&space]).unwrap();
        let scale = residual.iter().fold(0.0_f64, |scale, value| scale.max(value.abs()));
        assert!(product.iter().zip(&residual).all(|(a, b)| (a - b).abs() < 1e-12 * scale));
    };
}

// In degree 4 a vertex of hexahedra meets 9³ nodes, more than a byte can count.
#[test]
fn linear_displacements_pass_the_patch_test_on_distorted_meshes() {
    for degree in DEGREES {
        for shape in FLAT {
            patch_of_elasticity!(square(shape, 3, 0.15), degree, 2);
        }
        for shape in SOLID {
            patch_of_elasticity!(cube(shape, 2, 0.1), degree, 3);
        }
    }
}

#[test]
fn discontinuous_spaces_hold_what_is_projected_on_them() {
    for shape in FLAT {
        let mesh = square(shape, 3, 0.0);
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(8));
        for degree in 0..=4 {
            let space = Space::discontinuous_scalar(&mesh, degree).unwrap();
            assert_eq!(space.node_count(), mesh.cell_count() * space.cell_element(0).nodes());
            let data = models::data().f(move |x: &[f64; 2]| power(x, degree));
            let found = assembler.project(&models::value(&data), &space).unwrap();
            for (value, x) in found.values().iter().zip(space.positions()) {
                assert!((value - power(x, degree)).abs() < 1e-12, "{shape:?} {degree}");
            }
        }
        // Of a linear function, the mean over a cell is the value at the centroid.
        let space = Space::discontinuous_scalar(&mesh, 0).unwrap();
        let data = models::data().f(|x: &[f64; 2]| power(x, 1));
        let found = assembler.project(&models::value(&data), &space).unwrap();
        for (cell, value) in (0..mesh.cell_count()).map(|cell| (cell, found.evaluate_in(cell, &[0.3; 2])[0]))
        {
            let centre = mesh.map(cell, &shape.centre::<2>()).0;
            assert!((value - power(&centre, 1)).abs() < 1e-13);
        }
    }
}

#[test]
fn other_degrees_are_refused() {
    let mesh = square(CellShape::Triangle, 1, 0.0);
    assert_eq!(
        Space::scalar(&mesh, 5).unwrap_err().to_string(),
        "there is no Lagrange element of degree 5 on the triangle; the degrees are 1 to 4"
    );
    assert_eq!(
        Space::discontinuous_scalar(&mesh, 5).unwrap_err().to_string(),
        "there is no Lagrange element of degree 5 with discontinuous values; the degrees are 0 to 4"
    );
    assert_eq!(
        rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Triangle, 3).unwrap_err().to_string(),
        "there is no geometry of degree 3 for the triangle; the degrees are 1 and 2"
    );
}
