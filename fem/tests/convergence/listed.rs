//! Problems that were once answered wrongly or refused.

use forms_fem::prelude::*;

use super::laws::scalar;
use super::solvers::{COUNT, solver};

fn data() -> scalar::Data<2> {
    let one = || Given::constant(1.0);
    scalar::data().k(one()).c(one()).f(one()).wall(one()).penalty(1.0).power(0.0)
}

/// Two cells that know nothing of each other, one 10¹¹ times as stiff: both are solved.
#[test]
fn a_stiff_cell_does_not_hide_a_soft_one() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 1], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let of =
        |left: f64, right: f64| Given::function(move |x: &[f64; 2]| if x[0] < 0.5 { left } else { right });
    let data = data().k(of(1e11, 0.0)).c(of(0.0, 1.0));
    let form = scalar::Model { data, regions: scalar::Regions::default() }.apart();
    for number in 0..COUNT {
        let (name, mut linear) = solver(number);
        let solved = Problem::new(&form, &space).solver(&mut *linear).solve().unwrap();
        for value in solved.field().values() {
            assert!((value - 1.0).abs() < 1e-9, "{name}: {value}");
        }
    }
}

/// A guess beyond a stiff switch does not end the iteration where the switch is left.
#[test]
fn a_far_guess_does_not_decide_when_to_stop() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let data = data().k(1e6).f(1e5).c(0.5);
    let form = scalar::Model { data, regions: scalar::Regions::default() }.kinked();
    let far = Field::interpolate(&space, |_| 1e6).unwrap();
    let solved = Problem::new(&form, &space).start(&far).solve().unwrap();
    assert!((solved.field().values()[0] - 0.457_219).abs() < 1e-6, "{:?}", solved.field().values());
}

/// Forces of 10⁻³⁰² are forces.
#[test]
fn tiny_units_do_not_converge_at_once() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::scalar(&mesh, 1).unwrap();
    let solved = [1.0, 1e-302].map(|unit| {
        let data = data().k(unit).c(unit).f(unit);
        let form = scalar::Model { data, regions: scalar::Regions::default() }.conduction();
        let mut constraints = Constraints::new(&space);
        constraints.fix("left", |_| 0.0).unwrap();
        Problem::new(&form, &space).constrained(&constraints).solve().unwrap().field().values().to_vec()
    });
    for (one, tiny) in solved[0].iter().zip(&solved[1]) {
        assert!((one - tiny).abs() < 1e-9, "{one} {tiny}");
    }
}

#[forms(dimension = 2)]
mod multiplier {
    pub struct Data {
        pub switch: Param,
        pub gap: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Top;

    /// Contact with a multiplier, as in tutorial 9.
    pub fn contact(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, inner(2 * eps(u) + div(u) * I, eps(v)))
            + integral(Top, p * v[1])
            + integral(Top, (p - max(0, p + switch * (u[1] - gap))) * q / switch)
    }

    /// A saddle point whose second block fades away.
    pub fn fading(u: Unknown<Scalar>, p: Unknown<Scalar>, v: Test<Scalar>, w: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) / 1000 + p * v + u * w - gap * p * w - v)
    }

    /// A first field drives a second one, and not the reverse.
    pub fn one_way(u: Unknown<Scalar>, p: Unknown<Scalar>, v: Test<Scalar>, w: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - v + dot(grad(p), grad(w)) - switch * u * w)
    }

    pub fn elastic(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, switch * (inner(2 * eps(u) + div(u) * I, eps(v)) - v[1] / 1e6))
    }
}

/// The pressure of a contact that is open is zero, not an equation that does not hold.
#[test]
fn an_open_contact_has_no_pressure() {
    let even = rectangle([0.0; 2], [1.0; 2], [4, 2], CellShape::Quadrilateral, 1).unwrap();
    let nodes = even.nodes().iter().map(|x| [x[0].powi(3), 1.0 - (1.0 - x[1]).powf(1.5)]).collect();
    let mesh = even.with_nodes(nodes).unwrap();
    let (bodies, pressures) = (Space::vector(&mesh, 1).unwrap(), Space::on_facets(&mesh, "top", 1).unwrap());
    for switch in [1e-3, 1.0, 200.0, 1e6] {
        for lowered in [0.0, 0.05] {
            let data = multiplier::data().switch(switch).gap(1.0);
            let regions = multiplier::Regions::default().top("top");
            let form = multiplier::Model { data, regions }.contact();
            let mut held = Constraints::new(&bodies);
            held.fix("bottom", |x| [0.0, lowered * x[0]]).unwrap();
            for number in 0..2 {
                let (name, mut linear) = solver(number);
                let problem = Problem::new(&form, [&bodies, &pressures]).constrained(&held);
                let solved = problem.solver(&mut *linear).solve();
                let solved = solved.unwrap_or_else(|error| panic!("{name}, c = {switch}: {error}"));
                let largest = solved.fields[1].values().iter().fold(0.0_f64, |most, p| most.max(p.abs()));
                assert!(largest < 1e-12, "{name}, c = {switch}: p = {largest:e}");
            }
        }
    }
}

/// A saddle point is judged by the scale of its rows, not by its diagonal.
#[test]
fn a_fading_block_does_not_make_a_saddle_point_singular() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [8, 8], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::scalar(&mesh, 1).unwrap();
    for decades in [1.0, 10.0, 30.0, 60.0] {
        let gap = Given::function(move |x: &[f64; 2]| 10_f64.powf(-decades * x[0]));
        let data = multiplier::data().switch(1.0).gap(gap);
        let form = multiplier::Model { data, regions: multiplier::Regions::default() }.fading();
        let solved = [0, 1].map(|number| {
            let (name, mut linear) = solver(number);
            let solved = Problem::new(&form, [&space, &space]).solver(&mut *linear).solve();
            solved.unwrap_or_else(|error| panic!("{name}, {decades} decades: {error}")).fields
        });
        for (a, b) in solved[0].iter().zip(&solved[1]) {
            let most = b.values().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            for (a, b) in a.values().iter().zip(b.values()) {
                assert!((a - b).abs() < 1e-8 * most, "{decades} decades: {a} {b}");
            }
        }
    }
}

/// A coupling in one direction, however strong, is no null vector.
#[test]
fn a_strong_one_way_coupling_is_regular() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::scalar(&mesh, 1).unwrap();
    let mut held = Constraints::new(&space);
    held.fix("boundary", |_| 0.0).unwrap();
    let centre = |switch: f64, number: usize| {
        let data = multiplier::data().switch(switch).gap(0.0);
        let form = multiplier::Model { data, regions: multiplier::Regions::default() }.one_way();
        let (name, mut linear) = solver(number);
        let problem = Problem::new(&form, [&space, &space]).constrained(&held).constrained(&held);
        let solved = problem.solver(&mut *linear).solve();
        let solved = solved.unwrap_or_else(|error| panic!("{name}, {switch:e}: {error}"));
        solved.fields[1].evaluate(&[0.5, 0.5]).unwrap()[0] / switch
    };
    let expected = centre(1.0, 1);
    for switch in [1e12, 1.6e15, 1e20, 1e60, 1e-60] {
        for number in 0..2 {
            let found = centre(switch, number);
            assert!((found - expected).abs() < 1e-9 * expected, "{switch:e}: {found} {expected}");
        }
    }
}

/// Units and long cells leave a cantilever what it is.
#[test]
fn units_and_long_cells_do_not_make_a_cantilever_singular() {
    // Cells of 1 : 4, and of 1 : 1000 and more.
    for (unit, layers) in [(1.0, 4), (1e60, 4), (1e-60, 4), (1.0, 200), (1.0, 800)] {
        let mesh = rectangle([0.0; 2], [10.0, 1.0], [2, layers], CellShape::Quadrilateral, 1).unwrap();
        let space = Space::vector(&mesh, 2).unwrap();
        let mut held = Constraints::new(&space);
        held.fix("left", |_| [0.0; 2]).unwrap();
        let data = multiplier::data().switch(unit).gap(0.0);
        let form = multiplier::Model { data, regions: multiplier::Regions::default() }.elastic();
        let ends = [0, 1].map(|number| {
            let (name, mut linear) = solver(number);
            let solved = Problem::new(&form, &space).constrained(&held).solver(&mut *linear).solve();
            let solved = solved.unwrap_or_else(|error| panic!("{name}, {unit:e}, {layers}: {error}"));
            solved.field().evaluate(&[10.0, 0.5]).unwrap()[1]
        });
        assert!((ends[0] - ends[1]).abs() < 1e-6 * ends[1].abs(), "{unit:e}, {layers}: {ends:?}");
    }
}
