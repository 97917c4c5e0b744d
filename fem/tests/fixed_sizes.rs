//! Element kernels whose loops have fixed lengths against those that count: the same matrices and vectors.

use forms_fem::assemble::{Counted, ElementCells, ElementKernel, ElementLayout, FieldLayout, Fixed, Sizes};
use forms_fem::contract::Integrals;
use forms_fem::element::{CellShape, Lagrange};
use forms_fem::lanes::InstructionSet;
use forms_fem::prelude::*;

#[forms]
mod on_cells_and_facets {
    pub struct Data {
        mu: Param,
        lambda: Param,
        gap: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;

    fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * div(w) * I
    }
    pub fn diffusion(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (1 + gap * gap) * dot(grad(u), grad(v)) + h * u * v - dot(x, x) * v)
    }
    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)) - gap * div(v))
    }
    pub fn contact(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let gamma = mu * facet_area / cell_volume;
        let pressure = dot(n, stress(u) * n) - gamma * (dot(u, n) - gap);
        integral(Gamma, lambda * dot(u, v) + neg_part(pressure) * (dot(n, stress(v) * n) - gamma * dot(v, n)))
    }
}
use on_cells_and_facets::*;

/// Numbers in [−1, 1] that are the same each time.
fn noise(count: usize) -> Vec<f64> {
    let mut state = 7_u64;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    };
    (0..count).map(|_| next()).collect()
}

const CELLS: usize = 11;

/// Matrices and vectors of some distorted cells, one row of numbers each.
fn results<I: Integrals<D>, S: Sizes, const D: usize>(
    form: &Form<D>,
    components: usize,
    degrees: [usize; 2],
    shape: CellShape,
    facet: usize,
    set: InstructionSet,
) -> [Vec<f64>; 2] {
    ordered_results::<I, S, D>(form, components, degrees, shape, facet, set, 2, |node, component, _| {
        node * components + component
    })
}

/// Matrices and vectors by a rule of the given degree. `row` numbers the rows by node, component and number of nodes.
#[allow(clippy::too_many_arguments)]
fn ordered_results<I: Integrals<D>, S: Sizes, const D: usize>(
    form: &Form<D>,
    components: usize,
    [shape_degree, degree]: [usize; 2],
    shape: CellShape,
    facet: usize,
    set: InstructionSet,
    rule: usize,
    row: impl Fn(usize, usize, usize) -> usize,
) -> [Vec<f64>; 2] {
    let element = |degree| Lagrange::new(shape, degree).expect("it is known");
    let (geometry, own, linear) = (element(shape_degree), element(degree), element(1));
    let offsets = |element: Lagrange, start: usize, stride: usize| -> Vec<usize> {
        (0..element.nodes()).map(|node| start + node * stride).collect()
    };
    let width = own.nodes() * components;
    let layout = ElementLayout {
        geometry,
        element: own,
        coordinate_stride: geometry.nodes() * D,
        coordinate_offsets: offsets(geometry, 0, D),
        coefficient_stride: width + linear.nodes(),
        fields: vec![
            FieldLayout { name: "u".into(), element: own, offsets: offsets(own, 0, components) },
            FieldLayout { name: "gap".into(), element: linear, offsets: offsets(linear, width, 1) },
        ],
        rows: (0..width).map(|k| row(k / components, k % components, own.nodes())).collect(),
    };
    let reference = geometry.node_points::<D>();
    let mut coordinates = noise(CELLS * reference.len() * D);
    for (k, coordinate) in coordinates.iter_mut().enumerate() {
        *coordinate = reference.as_flattened()[k % (reference.len() * D)] + 0.05 * *coordinate;
    }
    let coefficients: Vec<f64> =
        noise(CELLS * (width + linear.nodes())).iter().map(|value| 0.1 * value).collect();
    let cells = ElementCells { count: CELLS, coordinates: &coordinates, coefficients: &coefficients, facet };
    let quadrature = Quadrature::Degree(rule);
    let kernel = ElementKernel::with_instructions::<I, S>(form, layout, &quadrature, set);
    let mut kernel = kernel.expect("it fits");
    let size = kernel.size();
    let mut matrices = vec![f64::NAN; CELLS * size * size];
    let mut vectors = vec![f64::NAN; CELLS * size];
    // Twice: the second time, memory is there.
    for _ in 0..2 {
        kernel.matrices(&cells, &mut matrices).expect("matrices");
        kernel.vectors(&cells, &mut vectors).expect("vectors");
    }
    [matrices, vectors]
}

fn agree(found: &[Vec<f64>; 2], expected: &[Vec<f64>; 2], what: &str) {
    for (found, expected) in found.iter().zip(expected) {
        let largest = expected.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        assert!(largest > 1e-3 && largest.is_finite(), "{what}: {largest}");
        for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
            assert!((found - expected).abs() <= 1e-13 * largest, "{what}, {k}: {found} is not {expected}");
        }
    }
}

/// Compares forms on one element, each with its number of components: `[nodes, points, geometry nodes]`, points on cells
/// and on facets.
macro_rules! compare {
    ($name:ident, $shape:ident, $dimension:literal, geometry $geometry:literal, degree $degree:literal,
     $nodes:literal, $points:literal, $facet_points:literal, $geometry_nodes:literal,
     cells [$($on_cells:ident $components:literal),*], facets [$($on_facets:ident),*]) => {
        #[test]
        fn $name() {
            let (degrees, shape) = ([$geometry, $degree], CellShape::$shape);
            let data = data::<$dimension>().mu(0.7).lambda(1.3).gap(0.0);
            for set in InstructionSet::available() {
                $({
                    type Sizes = Fixed<$nodes, $points, $geometry_nodes>;
                    let form = || $on_cells::<$dimension>(&data, &Omega::on("all"));
                    let fixed = results::<$on_cells::Kernels, Sizes, $dimension>(&form(), $components, degrees, shape, 0, set);
                    let counted = results::<$on_cells::Kernels, Counted, $dimension>(&form(), $components, degrees, shape, 0, set);
                    agree(&fixed, &counted, &format!("{set}, {}", stringify!($on_cells)));
                })*
                $(for facet in 0..2 {
                    type Sizes = Fixed<$nodes, $facet_points, $geometry_nodes>;
                    let form = || $on_facets::<$dimension>(&data, &Gamma::on("boundary"));
                    let fixed = results::<$on_facets::Kernels, Sizes, $dimension>(&form(), $dimension, degrees, shape, facet, set);
                    let counted = results::<$on_facets::Kernels, Counted, $dimension>(&form(), $dimension, degrees, shape, facet, set);
                    agree(&fixed, &counted, &format!("{set}, {}, facet {facet}", stringify!($on_facets)));
                })*
            }
        }
    };
}

// Each kernel is compiled for each instruction set: what one element shows, the next need not.
compare!(linear_triangles, Triangle, 2, geometry 1, degree 1, 3, 3, 2, 3,
    cells [diffusion 1, elasticity 2], facets [contact]);
compare!(quadratic_tetrahedra, Tetrahedron, 3, geometry 1, degree 2, 10, 4, 3, 4,
    cells [elasticity 3], facets []);
compare!(curved_quadrilaterals, Quadrilateral, 2, geometry 2, degree 2, 9, 4, 2, 9,
    cells [diffusion 1], facets [contact]);

/// The row of a node's component among the given number of nodes.
type Row = fn(node: usize, component: usize, nodes: usize) -> usize;

/// Matrices of two components are written block by block, those of linear simplices at one point as a whole, those of
/// grids from sums by moments: wherever the rows are, and for fewer cells than lanes at the end.
#[test]
fn rows_stand_in_any_order() {
    let data = data::<2>().mu(0.7).lambda(1.3).gap(0.0);
    let omega = Omega::on("all");
    let triangle = CellShape::Triangle;
    let orders: [(&str, Row); 4] = [
        ("node by node", |node, component, _| 2 * node + component),
        ("from the last node on", |node, component, nodes| 2 * (nodes - 1 - node) + component),
        ("component by component", |node, component, nodes| component * nodes + node),
        ("components exchanged", |node, component, _| 2 * node + 1 - component),
    ];
    for set in InstructionSet::available() {
        for (name, row) in orders {
            let form = || elasticity::<2>(&data, &omega);
            let linear = [
                ordered_results::<elasticity::Kernels, Fixed<3, 1, 3>, 2>(
                    &form(),
                    2,
                    [1, 1],
                    triangle,
                    0,
                    set,
                    1,
                    row,
                ),
                ordered_results::<elasticity::Kernels, Counted, 2>(
                    &form(),
                    2,
                    [1, 1],
                    triangle,
                    0,
                    set,
                    1,
                    row,
                ),
            ];
            agree(&linear[0], &linear[1], &format!("{set}, linear, {name}"));
            let quadratic = [
                ordered_results::<elasticity::Kernels, Fixed<6, 3, 3>, 2>(
                    &form(),
                    2,
                    [1, 2],
                    triangle,
                    0,
                    set,
                    2,
                    row,
                ),
                ordered_results::<elasticity::Kernels, Counted, 2>(
                    &form(),
                    2,
                    [1, 2],
                    triangle,
                    0,
                    set,
                    2,
                    row,
                ),
            ];
            agree(&quadratic[0], &quadratic[1], &format!("{set}, quadratic, {name}"));
            // By moments.
            let quadrilateral = CellShape::Quadrilateral;
            let by_moments = [
                ordered_results::<elasticity::Kernels, Fixed<9, 9, 4>, 2>(
                    &form(),
                    2,
                    [1, 2],
                    quadrilateral,
                    0,
                    set,
                    4,
                    row,
                ),
                ordered_results::<elasticity::Kernels, Counted, 2>(
                    &form(),
                    2,
                    [1, 2],
                    quadrilateral,
                    0,
                    set,
                    4,
                    row,
                ),
            ];
            agree(&by_moments[0], &by_moments[1], &format!("{set}, quadrilaterals, {name}"));
        }
        let orders: [(&str, Row); 2] =
            [("in our order", |node, _, _| node), ("backwards", |node, _, nodes| nodes - 1 - node)];
        for (name, row) in orders {
            let form = || diffusion::<2>(&data, &omega);
            let numbers = [
                ordered_results::<diffusion::Kernels, Fixed<3, 1, 3>, 2>(
                    &form(),
                    1,
                    [1, 1],
                    triangle,
                    0,
                    set,
                    1,
                    row,
                ),
                ordered_results::<diffusion::Kernels, Counted, 2>(
                    &form(),
                    1,
                    [1, 1],
                    triangle,
                    0,
                    set,
                    1,
                    row,
                ),
            ];
            agree(&numbers[0], &numbers[1], &format!("{set}, numbers, {name}"));
            let quadrilateral = CellShape::Quadrilateral;
            let by_moments = [
                ordered_results::<diffusion::Kernels, Fixed<9, 9, 9>, 2>(
                    &form(),
                    1,
                    [2, 2],
                    quadrilateral,
                    0,
                    set,
                    4,
                    row,
                ),
                ordered_results::<diffusion::Kernels, Counted, 2>(
                    &form(),
                    1,
                    [2, 2],
                    quadrilateral,
                    0,
                    set,
                    4,
                    row,
                ),
            ];
            agree(&by_moments[0], &by_moments[1], &format!("{set}, numbers on quadrilaterals, {name}"));
        }
    }
}

#[test]
fn lengths_that_do_not_fit_are_named() {
    let shape = CellShape::Triangle;
    let element = Lagrange::new(shape, 1).expect("it is known");
    let data = data::<2>().mu(0.7).lambda(1.3).gap(0.0);
    let layout = ElementLayout {
        geometry: element,
        element,
        coordinate_stride: 6,
        coordinate_offsets: vec![0, 2, 4],
        coefficient_stride: 9,
        fields: vec![
            FieldLayout { name: "u".into(), element, offsets: vec![0, 2, 4] },
            FieldLayout { name: "gap".into(), element, offsets: vec![6, 7, 8] },
        ],
        rows: (0..6).collect(),
    };
    let quadrature = Quadrature::Degree(2);
    let form = || elasticity::<2>(&data, &Omega::on("all"));
    type Wrong = Fixed<6, 3, 3>;
    let error =
        ElementKernel::with_sizes::<elasticity::Kernels, Wrong>(&form(), layout.clone(), &quadrature).err();
    let message = error.expect("a triangle has three nodes").to_string();
    assert!(message.contains("there are 3 nodes, and 6 are fixed"), "{message}");
    let unlisted = ElementLayout { fields: layout.fields[..1].to_vec(), ..layout.clone() };
    type Right = Fixed<3, 3, 3>;
    let error = ElementKernel::with_sizes::<elasticity::Kernels, Right>(&form(), unlisted, &quadrature).err();
    let message = error.expect("the gap is not listed").to_string();
    assert!(message.contains("every field"), "{message}");
    let error = ElementKernel::new::<diffusion::Kernels>(&form(), layout, &quadrature).err();
    let message = error.expect("these are other kernels").to_string();
    assert!(message.contains("those of another form"), "{message}");
}
