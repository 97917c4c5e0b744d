//! Forms, meshes and checks that the elements share.

use forms_fem::linear_algebra::CsrMatrix;
use forms_fem::prelude::*;

#[forms]
pub mod poisson {
    pub struct Data {
        pub f: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - f * v)
    }
}

#[forms]
pub mod stokes {
    pub struct Data {
        pub inertia: Param,
        pub f: Given<Vector>,
    }
    #[cells]
    pub struct Omega;

    pub fn flow(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(
            Omega,
            inner(grad(u), grad(v)) - p * div(v) - q * div(u) + inertia * dot(grad(u) * u, v) - dot(f, v),
        )
    }
    pub fn mass(p: Unknown<Scalar>, q: Test<Scalar>) -> Form {
        integral(Omega, p * q)
    }
}

pub type Outcome = Result<(), Box<dyn std::error::Error>>;

/// The unit square of n × n cells; nodes inside are moved by a part of the cells' size, alike on all refinements.
pub fn distorted(n: usize, shape: CellShape, degree: usize) -> Mesh<2> {
    let mesh = rectangle([0.0; 2], [1.0; 2], [n, n], shape, degree).unwrap();
    moved(&mesh, shape, degree, 0.1 / n as f64)
}

/// The unit cube of n × n × n cells, distorted alike.
pub fn distorted_cube(n: usize, shape: CellShape, degree: usize) -> Mesh<3> {
    let mesh = cuboid([0.0; 3], [1.0; 3], [n, n, n], shape, degree).unwrap();
    moved(&mesh, shape, degree, 0.06 / n as f64)
}

fn moved<const D: usize>(mesh: &Mesh<D>, shape: CellShape, degree: usize, by: f64) -> Mesh<D> {
    let inside = |x: &[f64; D]| x.iter().all(|x| *x > 1e-9 && *x < 1.0 - 1e-9);
    let wave = |number: usize, k: usize| (7.0 * number as f64 + 3.0 * k as f64).sin();
    let place = |(number, x): (usize, &[f64; D])| match inside(x) {
        true => std::array::from_fn(|k| x[k] + by * wave(number, k)),
        false => *x,
    };
    let nodes = mesh.nodes().iter().enumerate().map(place).collect();
    Mesh::from_parts(shape, degree, nodes, mesh.cells().to_vec()).unwrap()
}

/// Numbers between −1 and 1 that look random.
pub fn noise(count: usize) -> Vec<f64> {
    (0..count).map(|k| (12.9898 * k as f64 + 78.233).sin()).collect()
}

/// The entries of a row, with their columns.
pub fn row(matrix: &CsrMatrix, row: usize) -> impl Iterator<Item = (usize, f64)> {
    let (columns, values) = matrix.row(row);
    columns.iter().zip(values).map(|(column, value)| (*column as usize, *value))
}

/// The orders between successive errors, of meshes that halve.
pub fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect()
}

/// The largest jump of a field with noise for values, at points of the interior facets.
pub fn largest_jump<const D: usize>(space: &Arc<Space<D>>) -> f64 {
    let mesh = space.mesh();
    let rough = Field::from_values(space, noise(space.unknowns())).unwrap();
    let mut largest = 0.0_f64;
    for sides in mesh.interior_facets() {
        let shape = mesh.cell_shape(sides[0].cell as usize);
        let corners = shape.facet_vertices(sides[0].local.into());
        let corners = [corners[0], corners[1], corners[corners.len() - 1]];
        let global = corners.map(|corner| mesh.cell(sides[0].cell as usize)[corner]);
        for (s, t) in [(0.2, 0.3), (0.45, 0.1), (0.05, 0.6)] {
            let seen = sides.map(|side| {
                let own = mesh.cell(side.cell as usize);
                let [a, b, c] = global.map(|vertex| {
                    shape.vertex_points()[own.iter().position(|own| *own == vertex).expect("they share it")]
                });
                let t = if D == 2 { 0.0 } else { t };
                let point = std::array::from_fn(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]));
                rough.evaluate_in(side.cell as usize, &point)[0]
            });
            largest = largest.max((seen[0] - seen[1]).abs());
        }
    }
    largest
}

/// The largest distance between the interpolant of a function and the function, at points inside the cells.
pub fn largest_error<const D: usize>(space: &Arc<Space<D>>, exact: impl Fn(&[f64; D]) -> f64) -> f64 {
    let field = Field::interpolate(space, &exact).unwrap();
    let mut largest = 0.0_f64;
    for cell in space.mesh().body_cells() {
        for point in [[0.2, 0.3, 0.1], [0.1, 0.15, 0.6], [0.5, 0.2, 0.2]] {
            let point = std::array::from_fn(|k| point[k]);
            let x = space.mesh().map(cell, &point).0;
            largest = largest.max((field.evaluate_in(cell, &point)[0] - exact(&x)).abs());
        }
    }
    largest
}

/// Errors [L², gradients] of −Δu = f with u = Π sin(πx_k + 0.3).
pub fn errors_of_poisson<const D: usize>(mesh: &Mesh<D>, elements: &Elements) -> [f64; 2]
where
    Dim: Dimension<D>,
{
    use std::f64::consts::PI;
    let exact = |x: &[f64; D]| x.iter().map(|x| (PI * x + 0.3).sin()).product::<f64>();
    let slope = move |x: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|k| exact(x) * PI * (PI * x[k] + 0.3).cos() / (PI * x[k] + 0.3).sin())
    };
    let space = Space::of(mesh, elements.clone(), Scope::Nodes, &[]).unwrap();
    let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(6));
    let data = poisson::data().f(move |x: &[f64; D]| D as f64 * PI * PI * exact(x));
    let form = poisson::balance(&data, &poisson::Omega::on("all"));
    let mut walls = Constraints::new(&space);
    walls.fix("boundary", exact).unwrap();
    let problem = Problem::new(&form, &space).assembler(&assembler);
    let field = problem.constrained(&walls).solve().unwrap().into_field();
    let value = move |x: &[f64; D], value: &mut [f64]| value[0] = exact(x);
    let errors =
        norms::errors(&assembler, &field, value, move |x, gradient| gradient.copy_from_slice(&slope(x)));
    let errors = errors.unwrap();
    [errors.l2, errors.seminorm]
}

/// Errors of the velocity \[L², gradients\] and of the pressure of Stokes' flow u = curl(s(x) s(y)) with s = 5 x²(1 − x)², p = x³ + y − 3/4.
pub fn errors_of_stokes(mesh: &Mesh<2>, of_u: (Elements, Scope), of_p: (Elements, Scope)) -> [f64; 3] {
    let velocities = Space::of(mesh, of_u.0, of_u.1, &[2]).unwrap();
    let pressures = Space::of(mesh, of_p.0, of_p.1, &[]).unwrap();
    let s = |x: f64| 5.0 * x * x * (1.0 - x) * (1.0 - x);
    let ds = |x: f64| 10.0 * x * (1.0 - x) * (1.0 - 2.0 * x);
    let dds = |x: f64| 10.0 * (1.0 - 6.0 * x + 6.0 * x * x);
    let ddds = |x: f64| 60.0 * (2.0 * x - 1.0);
    let velocity = move |x: &[f64; 2]| [s(x[0]) * ds(x[1]), -ds(x[0]) * s(x[1])];
    let force = move |x: &[f64; 2]| {
        let [a, b] = *x;
        [-(dds(a) * ds(b) + s(a) * ddds(b)) + 3.0 * a * a, (ddds(a) * s(b) + ds(a) * dds(b)) + 1.0]
    };
    let gradient = move |x: &[f64; 2], g: &mut [f64]| {
        let [a, b] = *x;
        g.copy_from_slice(&[ds(a) * ds(b), s(a) * dds(b), -dds(a) * s(b), -ds(a) * ds(b)]);
    };
    let pressure = |x: &[f64; 2]| x[0].powi(3) + x[1] - 0.75;
    let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(8));
    let data = stokes::data().inertia(0.0).f(force);
    let form = stokes::flow(&data, &stokes::Omega::on("all"));
    let mut walls = Constraints::new(&velocities);
    walls.fix("boundary", velocity).unwrap();
    let mut level = Constraints::new(&pressures);
    level.mean_value("all", 0, 0.0).unwrap();
    let solved = Problem::new(&form, [&velocities, &pressures])
        .assembler(&assembler)
        .constrained(&walls)
        .constrained(&level)
        .solve()
        .unwrap();
    let [u, p] = &solved.fields;
    let of_u = move |x: &[f64; 2], value: &mut [f64]| value.copy_from_slice(&velocity(x));
    let errors = norms::errors(&assembler, u, of_u, gradient).unwrap();
    let of_p = move |x: &[f64; 2], value: &mut [f64]| value[0] = pressure(x);
    let no_slope = |x: &[f64; 2], slope: &mut [f64]| slope.copy_from_slice(&[3.0 * x[0] * x[0], 1.0]);
    let pressure = norms::errors(&assembler, p, of_p, no_slope).unwrap();
    [errors.l2, errors.seminorm, pressure.l2]
}

/// Checks the tangent of a nonlinear flow and the symmetry of a linear one.
pub fn check_flow(mesh: &Mesh<2>, of_u: (Elements, Scope), of_p: (Elements, Scope)) {
    let u = Space::of(mesh, of_u.0, of_u.1, &[2]).unwrap();
    let p = Space::of(mesh, of_p.0, of_p.1, &[]).unwrap();
    let assembler = Assembler::new(mesh);
    let form = |inertia: f64| {
        let f = Given::function(|x: &[f64; 2]| [x[1], -x[0]]);
        stokes::flow(&stokes::data().inertia(inertia).f(f), &stokes::Omega::on("all"))
    };
    let field = |space: &Arc<Space<2>>| Field::from_values(space, noise(space.unknowns())).unwrap();
    let (v, q) = (field(&u), field(&p));
    let matrix = assembler.tangent(&form(0.0), &[&v, &q], &[&u, &p]).unwrap();
    assert!(matrix.is_symmetric(1e-13).unwrap());
    let directions = [Field::interpolate(&u, |x| [x[0] * x[1], x[1]]).unwrap(), field(&p)];
    let directions: Vec<&Field<2>> = directions.iter().collect();
    let report =
        forms_fem::verification::tangent(&assembler, &form(3.0), &[&v, &q], &directions, 1e-2).unwrap();
    assert!(report.second_order().unwrap() > 1.9);
}
