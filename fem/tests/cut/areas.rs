//! Areas, lengths and normals of cut bodies, compared with closed forms and with each other.

use std::f64::consts::PI;

use forms_fem::linear_algebra::BlockMatrix;
use forms_fem::prelude::*;

use crate::{circle, cut, level, levels, square};

#[forms]
pub mod measures {
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Outer;
    #[interface]
    pub struct Gamma;
    #[interior_facets]
    pub struct Interior;

    pub fn volume() -> Functional {
        integral(Omega, 1)
    }
    pub fn surface() -> Functional {
        integral(Gamma, 1)
    }
    pub fn rim() -> Functional {
        integral(Outer, 1)
    }
    /// Zero by Gauss's theorem.
    pub fn gauss(u: State<Vector>) -> Functional {
        integral(Omega, div(u)) - integral(Gamma, dot(u, n)) - integral(Outer, dot(u, n))
    }
    /// Zero as well.
    pub fn second(u: State<Scalar>) -> Functional {
        integral(Omega, tr(hess(u))) - integral(Gamma, dot(grad(u), n)) - integral(Outer, dot(grad(u), n))
    }
    /// Zero for fields that jump between cells, too.
    pub fn with_jumps(u: State<Scalar>) -> Functional {
        integral(Omega, grad(u)[0])
            - integral(Gamma, u * n[0])
            - integral(Outer, u * n[0])
            - integral(Interior, jump(u) * n[0])
    }
    /// Volumes of the parts of cells, with a function of degree 0.
    pub fn volumes(v: Test<Scalar>) -> Form {
        integral(Omega, v)
    }
    /// Curvature and the size of the normal.
    pub fn normals() -> Functional {
        integral(Gamma, dot(n, n) + curvature)
    }
    pub fn sizes() -> Functional {
        integral(Gamma, h / sqrt(cell_volume))
    }
    /// With kinks, values on the interface and in cells.
    pub fn springs(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) + u * u * u * v - v)
            + integral(Gamma, pos_part(u - dot(x, n)) * v)
            + integral(Outer, u * v)
    }
}

/// Errors of area and perimeter.
fn errors(cells: usize, shape: CellShape) -> [f64; 2] {
    let disc = cut(&square(cells, shape), circle);
    let area = disc.functional(&measures::volume(&measures::Omega::on("all"))).unwrap();
    let length = disc.functional(&measures::surface(&measures::Gamma::on("all"))).unwrap();
    [(area - PI * 0.49).abs(), (length - 1.4 * PI).abs()]
}

#[test]
fn circle_has_its_area_and_perimeter() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let found = [16, 32, 64].map(|cells| errors(cells, shape));
        let last = found[2];
        assert!(last[0] < 1.1e-3 && last[1] < 8.5e-4, "{shape:?}: {last:?}");
        for k in 0..2 {
            let order = (found[0][k] / last[k]).log2() / 2.0;
            assert!((order - 2.0).abs() < 0.2, "{shape:?}: order {order} of {found:?}");
        }
    }
}

#[test]
fn sphere_has_its_volume_and_surface() {
    let errors = |cells: usize| {
        let mesh = cuboid([-1.0; 3], [1.0; 3], [cells; 3], CellShape::Tetrahedron, 1).unwrap();
        let ball = cut(&mesh, |x| {
            ((x[0] - 0.013).powi(2) + (x[1] + 0.021).powi(2) + (x[2] - 0.007).powi(2)).sqrt() - 0.7
        });
        let volume = ball.functional(&measures::volume(&measures::Omega::on("all"))).unwrap();
        let surface = ball.functional(&measures::surface(&measures::Gamma::on("all"))).unwrap();
        [(volume - 1.436_755_040_3).abs(), (surface - 6.157_521_601_0).abs()]
    };
    let found = [errors(8), errors(16)];
    for k in 0..2 {
        let order = (found[0][k] / found[1][k]).log2();
        assert!((order - 2.0).abs() < 0.2, "order {order} of {found:?}");
    }
}

#[test]
fn planes_cut_exactly() {
    // The part of (−1, 1)² below a line, by its corners.
    let (a, b) = (0.3, 0.17);
    let heights = [-1.0, 1.0].map(|x: f64| a * x + b + 1.0);
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = square(7, shape);
        let body = cut(&mesh, |x| x[1] - a * x[0] - b);
        let area = body.functional(&measures::volume(&measures::Omega::on("all"))).unwrap();
        let length = body.functional(&measures::surface(&measures::Gamma::on("all"))).unwrap();
        let rim = body.functional(&measures::rim(&measures::Outer::on("boundary"))).unwrap();
        assert!((area - heights[0] - heights[1]).abs() < 1e-14, "{area}");
        assert!((length - 2.0 * (1.0_f64 + a * a).sqrt()).abs() < 1e-14, "{length}");
        assert!((rim - 2.0 - heights[0] - heights[1]).abs() < 1e-14, "{rim}");
        let normals = body.functional(&measures::normals(&measures::Gamma::on("all"))).unwrap();
        assert!((normals - length).abs() < 1e-14);
    }
    // The corner of a cube that a plane cuts off, and the rest.
    let mesh = cuboid([0.0; 3], [1.0; 3], [3; 3], CellShape::Tetrahedron, 1).unwrap();
    let corner = |x: &[f64; 3]| x[0] + x[1] + x[2] - 0.77;
    let (inside, outside) = (cut(&mesh, corner), cut(&mesh, |x| -corner(x)));
    let volume =
        |body: &Assembler<3>| body.functional(&measures::volume(&measures::Omega::on("all"))).unwrap();
    let surface =
        |body: &Assembler<3>| body.functional(&measures::surface(&measures::Gamma::on("all"))).unwrap();
    let rim =
        |body: &Assembler<3>| body.functional(&measures::rim(&measures::Outer::on("boundary"))).unwrap();
    let edge: f64 = 0.77;
    assert!((volume(&inside) - edge.powi(3) / 6.0).abs() < 1e-14);
    assert!((volume(&outside) - 1.0 + edge.powi(3) / 6.0).abs() < 1e-14);
    assert!((surface(&inside) - 0.75_f64.sqrt() * edge * edge).abs() < 1e-14);
    assert!((rim(&inside) - 1.5 * edge * edge).abs() < 1e-14);
    assert!((rim(&outside) - 6.0 + 1.5 * edge * edge).abs() < 1e-14);
}

/// The parts of each cell inside two bodies make the cell, to this part of its volume.
pub fn check_cells<const D: usize>(mesh: &Mesh<D>, bodies: [Assembler<D>; 2], part: f64)
where
    Dim: Dimension<D>,
{
    let pieces = Space::discontinuous_scalar(mesh, 0).unwrap();
    let volumes = |assembler: &Assembler<D>| {
        assembler.linear_form(&measures::volumes(&measures::Omega::on("all")), &pieces).unwrap()
    };
    let whole = volumes(&Assembler::new(mesh));
    let [inner, outer] = bodies.map(|body| volumes(&body));
    let largest = whole.iter().copied().fold(0.0, f64::max);
    for cell in 0..whole.len() {
        assert!((inner[cell] + outer[cell] - whole[cell]).abs() < part * largest, "{cell}");
        assert!(inner[cell] >= 0.0 && outer[cell] >= 0.0);
    }
    // Something of either kind.
    assert!(inner.contains(&0.0) && outer.contains(&0.0));
}

#[test]
fn inside_and_outside_make_the_cell() {
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = square(12, shape);
        check_cells(&mesh, [cut(&mesh, circle), cut(&mesh, |x| -circle(x))], 1e-14);
    }
    let mesh = cuboid([-1.0; 3], [1.0; 3], [5; 3], CellShape::Tetrahedron, 1).unwrap();
    let shape = |x: &[f64; 3]| (x[0] * x[0] + x[1] * x[1] + 2.0 * x[2] * x[2]).sqrt() - 0.71;
    check_cells(&mesh, [cut(&mesh, shape), cut(&mesh, |x| -shape(x))], 1e-14);
}

/// A vector field of degree 2.
fn vector<const D: usize>(x: &[f64; D]) -> [f64; D] {
    let last = x[D - 1];
    std::array::from_fn(|k| [x[0] * x[1] + last * last, x[0] * x[0] - 0.4 * x[1], last * x[1]][k])
}

/// Gauss's theorem for a vector field of some degrees, for a field that jumps between cells and for second derivatives; sums below bounds for continuous fields
/// and for the one that jumps.
pub fn check_gauss<const D: usize>(
    (mesh, body): (&Mesh<D>, &Assembler<D>),
    degrees: &[usize],
    [continuous, jumping]: [f64; 2],
) where
    Dim: Dimension<D>,
{
    let (omega, outer, gamma) =
        (measures::Omega::on("all"), measures::Outer::on("boundary"), measures::Gamma::on("all"));
    for degree in degrees {
        let u = Field::interpolate(&Space::vector(mesh, *degree).unwrap(), vector).unwrap();
        let sum = body.functional(&measures::gauss(&omega, &outer, &gamma, &u)).unwrap();
        assert!(sum.abs() < continuous, "degree {degree}: {sum:e}");
    }
    // Facets between cells are clipped.
    let space = Space::discontinuous_scalar(mesh, 2).unwrap();
    let values = (0..space.unknowns()).map(|k| (k as f64 * 0.37).sin()).collect();
    let u = Field::from_values(&space, values).unwrap();
    let inner = measures::Interior::on("interior");
    let sum = body.functional(&measures::with_jumps(&omega, &outer, &gamma, &inner, &u)).unwrap();
    assert!(sum.abs() < jumping, "{sum:e}");
    // A polynomial of degree 3 has the second derivatives of its interpolant everywhere.
    let cubic =
        |x: &[f64; D]| x[0].powi(3) - 2.0 * x[D - 1] * x[1].powi(2) + x[0] * x[1] * x[D - 1] + x[1].powi(2);
    let u = Field::interpolate(&Space::scalar(mesh, 3).unwrap(), cubic).unwrap();
    let sum = body.functional(&measures::second(&omega, &outer, &gamma, &u)).unwrap();
    assert!(sum.abs() < continuous, "{sum:e}");
}

#[test]
fn gauss_theorem_holds_on_pieces() {
    // A body that the square's boundary clips.
    let off = |x: &[f64; 2]| (x[0] - 0.6).hypot(x[1] + 0.55) - 0.71;
    for shape in [CellShape::Triangle, CellShape::Quadrilateral] {
        let mesh = square(9, shape);
        for body in [cut(&mesh, circle), cut(&mesh, off), cut(&mesh, |x| -off(x))] {
            check_gauss((&mesh, &body), &[1, 2, 3], [3e-13, 1e-12]);
        }
    }
    let mesh = cuboid([-1.0; 3], [1.0; 3], [3; 3], CellShape::Tetrahedron, 1).unwrap();
    let ball = cut(&mesh, |x| ((x[0] - 0.5).powi(2) + x[1].powi(2) + (x[2] + 0.6).powi(2)).sqrt() - 0.8);
    check_gauss((&mesh, &ball), &[1, 2, 3], [3e-13, 1e-12]);
}

#[test]
fn curved_cells_are_cut_in_their_own_coordinates() {
    // A half of a ring of quadratic cells, by a line through its centre: the level set function is linear in reference coordinates, so that the
    // interface is curved with the cells; Gauss's theorem knows no shape.
    for (shape, degree, rule) in [(CellShape::Triangle, 1, 12), (CellShape::Quadrilateral, 2, 14)] {
        let mesh = annulus(0.5, 1.0, 2, 12, shape, 2).unwrap();
        let phi = levels(&mesh, degree, |x| x[0] - 0.3 * x[1] + 0.07);
        let body = Assembler::new(&mesh).cut_by(&phi).unwrap().with_quadrature(Quadrature::Degree(rule));
        let u = Field::interpolate(&Space::vector(&mesh, 2).unwrap(), vector).unwrap();
        let (omega, outer, gamma) =
            (measures::Omega::on("all"), measures::Outer::on("boundary"), measures::Gamma::on("all"));
        let sum = body.functional(&measures::gauss(&omega, &outer, &gamma, &u)).unwrap();
        assert!(sum.abs() < 1e-11, "{shape:?}: {sum:e}");
    }
}

#[test]
fn whole_bodies_keep_their_bits() {
    let mesh = square(6, CellShape::Triangle);
    let space = Space::scalar(&mesh, 2).unwrap();
    let u = Field::interpolate(&space, |x| x[0] * x[1] + 0.3).unwrap();
    let form = measures::springs(
        &measures::Omega::on("all"),
        &measures::Outer::on("boundary"),
        &measures::Gamma::on("all"),
    );
    let body = cut(&mesh, |x| -1.0 - 0.01 * x[0]);
    let other = cut(&mesh, |x| -2.0 - 0.01 * x[0]).with_threads(Threads::new(3));
    assert_eq!(
        body.residual(&form, &[&u], &[&space]).unwrap(),
        other.residual(&form, &[&u], &[&space]).unwrap()
    );
    let plain = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(
        cells("all"),
        dot(grad(u), grad(v)) + u * u * u * v - v
    ) + integral(facets("boundary"), u * v));
    let whole = Assembler::new(&mesh);
    assert_eq!(
        body.residual(&plain, &[&u], &[&space]).unwrap(),
        whole.residual(&plain, &[&u], &[&space]).unwrap()
    );
    let (cut, fitted) =
        (body.tangent(&plain, &[&u], &[&space]).unwrap(), whole.tangent(&plain, &[&u], &[&space]).unwrap());
    assert_eq!(cut.values(), fitted.values());
}

/// Residuals and tangents of a body have the same bits on these numbers of threads and on one.
pub fn check_threads(mesh: &Mesh<2>, body: &Assembler<2>, threads: &[usize]) {
    let space = Space::scalar(mesh, 2).unwrap();
    let u = Field::interpolate(&space, |x| x[0] * x[1] + 0.3).unwrap();
    let form = measures::springs(
        &measures::Omega::on("all"),
        &measures::Outer::on("boundary"),
        &measures::Gamma::on("all"),
    );
    let on = |threads: usize| {
        let body = body.clone().with_threads(Threads::new(threads));
        let matrix = BlockMatrix::from(body.tangent(&form, &[&u], &[&space]).unwrap());
        (body.residual(&form, &[&u], &[&space]).unwrap(), matrix.into_csr().values().to_vec())
    };
    let one = on(1);
    assert!(one.1.iter().any(|value| *value != 0.0));
    for threads in threads {
        assert!(on(*threads) == one, "{threads} threads");
    }
}

#[test]
fn threads_do_not_show() {
    let mesh = square(40, CellShape::Triangle);
    let body = cut(&mesh, |x| (x[0] - 0.6).hypot(x[1] + 0.55) - 0.71);
    check_threads(&mesh, &body, &[2, 3, 7]);
}

#[test]
fn tangents_are_derivatives() {
    let mesh = square(6, CellShape::Quadrilateral);
    let space = Space::scalar(&mesh, 2).unwrap();
    let form = measures::springs(
        &measures::Omega::on("all"),
        &measures::Outer::on("boundary"),
        &measures::Gamma::on("all"),
    );
    let body = cut(&mesh, circle);
    let u = Field::interpolate(&space, |x| x[0] * x[1] + 1.3).unwrap();
    let step = Field::interpolate(&space, |x| (3.0 * x[0]).sin() + x[1]).unwrap();
    let report = forms_fem::verification::tangent(&body, &form, &[&u], &[&step], 1e-2).unwrap();
    report.second_order().unwrap();
}

#[test]
fn zeros_at_nodes_are_moved_and_reported() {
    let mesh = square(8, CellShape::Triangle);
    // A line through nodes.
    let phi = level(&mesh, |x| x[0]);
    let body = Assembler::new(&mesh).cut_by(&phi).unwrap();
    let moved = body.cut().unwrap().moved_nodes();
    assert_eq!(moved.len(), 9);
    assert!(moved.iter().all(|node| phi.space().positions()[*node as usize][0] == 0.0));
    let area = body.functional(&measures::volume(&measures::Omega::on("all"))).unwrap();
    let length = body.functional(&measures::surface(&measures::Gamma::on("all"))).unwrap();
    assert!((area - 2.0).abs() < 1e-11 && (length - 2.0).abs() < 1e-11, "{area} {length}");
    // The cells on the other side are outside, and the body has no slivers there.
    assert_eq!(body.cut().unwrap().inside_cells().len() + body.cut().unwrap().cut_cells().len(), 64);
    assert!(cut(&mesh, |x| x[0] - 0.1).cut().unwrap().moved_nodes().is_empty());
    let size = body.functional(&measures::sizes(&measures::Gamma::on("all"))).unwrap();
    // Triangles with a right angle: h = √2 a, the area a²/2.
    assert!((size - 4.0).abs() < 1e-11, "{size}");
}
