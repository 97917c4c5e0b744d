//! F-bar and B-bar, `forms_contact::operators::strains::{f_bar, strain_bar}`: a thick ring under pressure without locking, at small and
//! large strains; tractions on facets that fit the cells.

use std::f64::consts::PI;

use forms_fem::prelude::*;
use forms_fem::verification;

#[forms(dimension = 2)]
mod ring {
    use forms_contact::operators::neo_hookean::density;
    use forms_contact::operators::strains::{f_bar, strain_bar};

    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        pub pressure: Param,
        pub gamma: Param,
        pub wanted: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Inner;
    #[facets]
    pub struct Held;

    fn linear(e: Tensor) -> Scalar {
        mu * inner(e, e) + lambda / 2 * pow(tr(e), 2)
    }
    pub fn plain(u: Unknown<Vector>) -> Energy {
        integral(Omega, linear(eps(u))) + integral(Inner, pressure * dot(u, n))
    }
    pub fn b_bar(u: Unknown<Vector>) -> Energy {
        integral(Omega, linear(strain_bar(u))) + integral(Inner, pressure * dot(u, n))
    }
    /// A pressure of degree 0 in place of the mean, next to the same energy of shape.
    pub fn mixed(u: Unknown<Vector>, p: Unknown<Scalar>) -> Energy {
        let s = dev(eps(u));
        integral(Omega, mu * inner(s, s) + p * div(u) - p * p / (2 * (lambda + 2 * mu / D)))
            + integral(Inner, pressure * dot(u, n))
    }
    pub fn rubber(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let stored = integral(Omega, density(f_bar(u)));
        derivative(stored, u, v) + integral(Inner, pressure * dot(cof(I + grad(u)) * n, v))
    }
    pub fn stored(u: Unknown<Vector>) -> Energy {
        integral(Omega, density(f_bar(u)))
    }
    fn stress(u: Vector) -> Tensor {
        let F = f_bar(u);
        diff(density(F), F)
    }
    /// The stress of F-bar, held by Nitsche's method.
    pub fn held(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), grad(v)))
            + integral(Held, dot(gamma / h * (u - wanted) - stress(u) * n, v))
    }
    pub fn force(u: State<Vector>, axis: State<Vector>) -> Functional {
        integral(Held, dot(stress(u) * n - gamma / h * (u - wanted), axis))
    }
}

const INNER: f64 = 1.0;
const OUTER: f64 = 2.0;

/// A quarter of a ring, symmetric about both axes: 4 cells along the radius, 8 around, with bent sides.
fn quarter() -> Mesh<2> {
    let flat = rectangle([INNER, 0.0], [OUTER, PI / 2.0], [4, 8], CellShape::Quadrilateral, 2).unwrap();
    let nodes = flat.nodes().iter().map(|[r, angle]| [r * angle.cos(), r * angle.sin()]).collect();
    let mut mesh = Mesh::from_parts(CellShape::Quadrilateral, 2, nodes, flat.cells().to_vec()).unwrap();
    mesh.name_facets("inner", "boundary", |x| (x[0].hypot(x[1]) - INNER).abs() < 0.05).unwrap();
    mesh.name_facets("bottom", "boundary", |x| x[1].abs() < 1e-9).unwrap();
    mesh.name_facets("left", "boundary", |x| x[0].abs() < 1e-9).unwrap();
    mesh
}

fn symmetric(space: &Arc<Space<2>>) -> Constraints<2> {
    let mut constraints = Constraints::new(space);
    constraints.fix_component("bottom", 1, |_| 0.0).unwrap();
    constraints.fix_component("left", 0, |_| 0.0).unwrap();
    constraints
}

/// μ = 1 and Poisson's ratio.
fn data(poisson: f64, pressure: f64) -> ring::Data<2> {
    let lambda = 2.0 * poisson / (1.0 - 2.0 * poisson);
    ring::data().lambda(lambda).mu(1.0).pressure(pressure).gamma(40.0).wanted([0.0; 2])
}

/// The largest error of the radial displacement at nodes, by the largest exact one.
fn error(u: &Field<2>, exact: impl Fn(f64) -> f64) -> f64 {
    let positions = u.space().positions();
    let off = positions.iter().zip(u.values().chunks(2)).map(|(x, u)| {
        let r = x[0].hypot(x[1]);
        let radial = exact(r);
        (u[0] - radial * x[0] / r).hypot(u[1] - radial * x[1] / r)
    });
    off.fold(0.0, f64::max) / exact(INNER).abs()
}

/// Lamé's ring in plane strain.
#[test]
fn nearly_incompressible_rings_do_not_lock() {
    let mesh = quarter();
    let space = Space::vector(&mesh, 1).unwrap();
    let (omega, inner) = (ring::Omega::on("all"), ring::Inner::on("inner"));
    for poisson in [0.3, 0.4999, 0.499999] {
        let (a, b) = (INNER * INNER, OUTER * OUTER);
        let exact = |r: f64| 0.01 * a / (2.0 * (b - a)) * ((1.0 - 2.0 * poisson) * r + b / r);
        let data = data(poisson, 0.01);
        let solve = |form: &Form<2>| {
            let problem = Problem::new(form, &space).constrained(&symmetric(&space)).solve();
            problem.unwrap().into_field()
        };
        let (averaged, plain) =
            (solve(&ring::b_bar(&data, &omega, &inner)), solve(&ring::plain(&data, &omega, &inner)));
        let errors = [error(&averaged, exact), error(&plain, exact)];
        println!("ν = {poisson}: B-bar off by {:.4}, without it by {:.4}", errors[0], errors[1]);
        assert!(errors[0] < 0.005, "ν = {poisson}: {errors:?}");
        assert!(poisson < 0.4 || errors[1] > 0.5, "ν = {poisson}: {errors:?}");
        // The same as a pressure of degree 0.
        let pressures = Space::discontinuous_scalar(&mesh, 0).unwrap();
        let mixed = ring::mixed(&data, &omega, &inner);
        let held = symmetric(&space);
        let solved = Problem::new(&mixed, [&space, &pressures]).constrained(&held).solve().unwrap();
        let [u, _] = &solved.fields;
        let size = u.values().iter().fold(0.0_f64, |size, value| size.max(value.abs()));
        for (a, b) in u.values().iter().zip(averaged.values()) {
            assert!((a - b).abs() < 1e-9 * size, "{a} is not {b}");
        }
    }
}

/// r² = R² + c of an incompressible neo-Hookean ring in plane strain: p = μ ∫ (λ² − λ⁻²) R/r² dR, λ = r/R.
fn pressure_of(c: f64) -> f64 {
    let steps = 4000;
    let width = (OUTER - INNER) / f64::from(steps);
    let at = |k: i32| {
        let squared = (INNER + (f64::from(k) + 0.5) * width).powi(2);
        let stretch = (squared + c) / squared;
        (stretch - 1.0 / stretch) * squared.sqrt() / (squared + c)
    };
    (0..steps).map(at).sum::<f64>() * width
}

#[test]
fn a_rubber_ring_is_blown_up_without_locking() {
    let mesh = quarter();
    let space = Space::vector(&mesh, 1).unwrap();
    let (omega, inner) = (ring::Omega::on("all"), ring::Inner::on("inner"));
    // The inner radius grows from 1 to 1.3.
    let c = 0.69;
    let mut u = Field::zero(&space);
    let mut steps = 0;
    for part in [0.25, 0.5, 0.75, 1.0] {
        let form = ring::rubber(&data(0.4999, pressure_of(part * c)), &omega, &inner);
        let solved = Problem::new(&form, &space).constrained(&symmetric(&space)).start(&u).solve().unwrap();
        steps += solved.iterations();
        u = solved.into_field();
    }
    let off = error(&u, |r| (r * r + c).sqrt() - r);
    println!("F-bar at 30 %: off by {off:.4}, {steps} steps in 4 increments");
    assert!(off < 0.005, "{off}");
    // Quadratic convergence: the tangent is exact.
    assert!(steps <= 28, "{steps}");
}

#[test]
fn the_energy_has_exact_derivatives() {
    let mesh = quarter();
    let space = Space::vector(&mesh, 1).unwrap();
    let form = ring::stored(&data(0.4999, 0.0), &ring::Omega::on("all"));
    let wave = |size: f64, k: f64| {
        let value = move |x: &[f64; 2]| [size * (k * x[1] + x[0]).sin(), size * (k * x[0] - x[1]).cos()];
        Field::interpolate(&space, value).unwrap()
    };
    let (u, w) = (wave(0.05, 1.3), wave(1.0, 2.1));
    let assembler = Assembler::new(&mesh);
    let report = verification::tangent(&assembler, &form, &[&u], &[&w], 1e-2).unwrap();
    assert!(report.second_order().unwrap() > 1.9, "{report:?}");
    assert!(assembler.tangent(&form, &[&u], &[&space]).unwrap().is_symmetric(1e-13).unwrap());
}

/// Bent cells: the mean over a cell is not its value at the middle.
fn block() -> Mesh<2> {
    let flat = rectangle([0.0; 2], [1.0, 1.0], [4, 3], CellShape::Quadrilateral, 1).unwrap();
    let moved = |x: &[f64; 2]| {
        let bubble = 16.0 * x[0] * (1.0 - x[0]) * x[1] * (1.0 - x[1]);
        [x[0] + 0.06 * bubble, x[1] - 0.05 * bubble * x[0]]
    };
    let nodes = flat.nodes().iter().map(moved).collect();
    let mut mesh = Mesh::from_parts(CellShape::Quadrilateral, 1, nodes, flat.cells().to_vec()).unwrap();
    mesh.name_facets("bottom", "boundary", |x| x[1].abs() < 1e-9).unwrap();
    mesh.name_facets("top", "boundary", |x| (x[1] - 1.0).abs() < 1e-9).unwrap();
    mesh
}

/// Stresses on facets are those of the cells: a linear deformation held by Nitsche's method on the whole boundary stays, and where only
/// a side is held so, the forces on both sides balance.
#[test]
fn tractions_on_facets_fit_the_cells() {
    let mesh = block();
    let space = Space::vector(&mesh, 1).unwrap();
    let linear = |x: &[f64; 2]| [0.1 * x[0] + 0.2 * x[1], -0.05 * x[0] - 0.08 * x[1]];
    let mut data = data(0.499, 0.0);
    data.wanted = Given::function(linear);
    data.gamma = 40.0 * (data.lambda + 2.0);
    let omega = ring::Omega::on("all");
    let form = ring::held(&data, &omega, &ring::Held::on("boundary"));
    let exact = Field::interpolate(&space, linear).unwrap();
    let residual = Assembler::new(&mesh).residual(&form, &[&exact], &[&space]).unwrap();
    let stress = 2.0 * data.lambda * 0.1;
    assert!(residual.iter().all(|entry| entry.abs() < 1e-12 * stress), "{residual:?}");

    // Softer, so that the sums are not of much larger numbers.
    let mut data = self::data(0.45, 0.0);
    data.gamma = 400.0;
    data.wanted = Given::constant([0.05, -0.03]);
    let top = ring::Held::on("top");
    let mut constraints = Constraints::new(&space);
    constraints.fix("bottom", |_| [0.0; 2]).unwrap();
    let form = ring::held(&data, &omega, &top);
    let solved = Problem::new(&form, &space).constrained(&constraints).solve().unwrap();
    let reaction = solved.reaction("bottom").unwrap();
    for axis in 0..2 {
        let mut unit = [0.0; 2];
        unit[axis] = 1.0;
        let along = Field::interpolate(&space, |_: &[f64; 2]| unit).unwrap();
        let force = solved.functional(&ring::force(&data, &top, solved.field(), &along)).unwrap();
        println!("force along {axis}: {force:e}, reaction {:e}", reaction[axis]);
        assert!((force + reaction[axis]).abs() < 1e-12 * force.abs(), "{force} {}", reaction[axis]);
    }
}
