//! Sums along the axes of quadrilaterals and hexahedra against sums over nodes at each point: one more point of weight
//! zero makes the same rule no grid, and leaves nothing but the direct loops.

use forms_fem::assemble::{ElementCells, ElementKernel, ElementLayout};
use forms_fem::element::Lagrange;
use forms_fem::prelude::*;
use forms_fem::quadrature::{QuadratureRule, cell_rule, facet_reference_rule};

#[forms(matrix_free)]
mod products {
    pub struct Data {
        wind: Param<Vector>,
        load: Given<Scalar>,
        body: Given<Vector>,
    }
    #[cells]
    pub struct Omega;

    /// Scalar and unsymmetric: values and gradients on both sides, and a coefficient from fields.
    pub fn transport(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (1 + u * u + load) * dot(grad(u), grad(v)) + dot(wind, grad(u)) * v - load * v)
    }
    /// Scalar and symmetric.
    pub fn poisson(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)))
    }
    /// Values alone.
    pub fn mass(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (2 + load) * u * v)
    }
    /// Vectors.
    pub fn rubber(u: Unknown<Vector>) -> Energy {
        let F = I + grad(u);
        integral(Omega, (inner(F, F) - D - 2 * ln(det(F))) / 2 + pow(ln(det(F)), 2) - dot(body, u))
    }
    pub fn size(u: State<Vector>) -> Functional {
        integral(Omega, inner(grad(u), grad(u)) + dot(body, u))
    }
}
use products::*;

/// Cells that are no parallelograms, with curved edges in degree 2.
fn bent<const D: usize>(flat: Mesh<D>, degree: usize) -> Mesh<D> {
    let nodes = flat.nodes().iter();
    let nodes = nodes.map(|x| {
        let mut y = *x;
        y[0] += 0.07 * x[1] * x[1] + 0.03 * x[0] * x[D - 1];
        y[1] += 0.05 * x[0] * x[1];
        y[D - 1] += 0.04 * x[0] * x[0];
        y
    });
    Mesh::from_parts(flat.cell_shape(0), degree, nodes.collect(), flat.cells().to_vec()).unwrap()
}

/// Gauss points, and the same with one more that does nothing.
fn rules<const D: usize>(shape: CellShape, degree: usize) -> [Quadrature<D>; 2] {
    let cell = cell_rule::<D>(shape, degree).unwrap();
    let facet = facet_reference_rule(shape, degree).unwrap();
    let mut more: QuadratureRule<D> = cell.clone();
    more.points.push([0.371; D]);
    more.weights.push(0.0);
    [cell, more].map(|cell| Quadrature::Explicit { cell, facet: facet.clone() })
}

fn wave<const D: usize>(space: &Arc<Space<D>>, size: f64) -> Field<D> {
    let values = (0..space.unknowns()).map(|k| size * (0.37 * k as f64).sin()).collect();
    Field::from_values(space, values).unwrap()
}

fn near(what: &str, found: &[f64], expected: &[f64]) {
    let scale = expected.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    assert!(scale > 1e-6, "{what}: the test says nothing");
    assert_eq!(found.len(), expected.len(), "{what}");
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-13 * scale, "{what}: {found} instead of {expected}");
    }
}

/// Forms are written for each dimension: what is done with them is a macro.
macro_rules! check {
    ($D:literal, $mesh:expr, $degree:expr) => {{
        let (mesh, degree) = (&$mesh, $degree);
        let rules = rules::<$D>(mesh.cell_shape(0), 2 * degree + 1);
        let [along, direct] = rules.map(|rule| Assembler::new(mesh).with_quadrature(rule));
        let scalars = Space::scalar(mesh, degree).unwrap();
        let vectors = Space::vector(mesh, degree).unwrap();
        let (u, w) = (wave(&scalars, 0.3), wave(&vectors, 0.002));
        let data = data().wind([0.4; $D]).load(&u).body(&w);
        let omega = &Omega::on("all");
        let transport = transport(&data, omega);
        let poisson = poisson(&data, omega);
        let mass = mass(&data, omega);
        let rubber = rubber(&data, omega);
        let matrix = |assembler: &Assembler<$D>| {
            [
                assembler.tangent(&transport, &[&u], &[&scalars]).unwrap(),
                assembler.tangent(&poisson, &[&u], &[&scalars]).unwrap(),
                assembler.tangent(&mass, &[&u], &[&scalars]).unwrap(),
                assembler.tangent(&rubber, &[&w], &[&vectors]).unwrap(),
            ]
            .map(|matrix| matrix.values().to_vec())
        };
        for (k, (found, expected)) in matrix(&along).iter().zip(&matrix(&direct)).enumerate() {
            near(&format!("matrix {k} of degree {degree}"), found, expected);
        }
        let vector = |assembler: &Assembler<$D>| {
            [
                assembler.residual(&transport, &[&u], &[&scalars]).unwrap(),
                assembler.residual(&poisson, &[&u], &[&scalars]).unwrap(),
                assembler.residual(&mass, &[&u], &[&scalars]).unwrap(),
                assembler.residual(&rubber, &[&w], &[&vectors]).unwrap(),
                assembler.action(&transport, &[&u], &[&u], &[&scalars]).unwrap(),
                assembler.action(&rubber, &[&w], &[&w], &[&vectors]).unwrap(),
            ]
        };
        for (k, (found, expected)) in vector(&along).iter().zip(&vector(&direct)).enumerate() {
            near(&format!("vector {k} of degree {degree}"), found, expected);
        }
    }};
}

#[test]
fn sums_along_axes_are_sums_over_nodes() {
    for degree in 1..=4 {
        let flat = rectangle([0.0; 2], [1.0, 1.2], [3, 2], CellShape::Quadrilateral, 2).unwrap();
        check!(2, bent(flat, 2), degree);
        let flat = cuboid([0.0; 3], [1.0, 1.2, 0.8], [2, 1, 1], CellShape::Hexahedron, 1 + degree % 2);
        check!(3, bent(flat.unwrap(), 1 + degree % 2), degree);
    }
}

#[test]
fn element_kernels_sum_along_axes_too() {
    let element = Lagrange::new(CellShape::Hexahedron, 2).unwrap();
    let mesh = bent(cuboid([0.0; 3], [1.0; 3], [1, 1, 1], CellShape::Hexahedron, 1).unwrap(), 1);
    let size = element.nodes();
    let coordinates: Vec<f64> = mesh.cell(0).iter().flat_map(|node| mesh.nodes()[*node as usize]).collect();
    let [along, direct] = rules::<3>(CellShape::Hexahedron, 4).map(|rule| {
        let data = data().wind([0.4; 3]).load(0.0).body([0.0; 3]);
        let layout = ElementLayout {
            geometry: Lagrange::new(CellShape::Hexahedron, 1).unwrap(),
            element,
            coordinate_stride: 24,
            coordinate_offsets: (0..8).map(|node| 3 * node).collect(),
            coefficient_stride: 0,
            fields: vec![],
            rows: (0..size).collect(),
        };
        let mut kernel =
            ElementKernel::new::<poisson::Kernels>(&poisson(&data, &Omega::on("all")), layout, &rule)
                .unwrap();
        let mut matrix = vec![0.0; size * size];
        let cells = ElementCells { count: 1, coordinates: &coordinates, coefficients: &[], facet: 0 };
        kernel.matrices(&cells, &mut matrix).unwrap();
        matrix
    });
    near("element matrix", &along, &direct);
}
