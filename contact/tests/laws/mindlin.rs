//! A ball pressed onto a half-space and then drawn along it: it sticks in the middle and slips in a ring around it (Mindlin 1949).

use forms_contact::half_spaces::{StickSlip, Tractions, halved_balls};
use forms_contact::hertz::{Hertz, RADIUS};
use forms_fem::prelude::*;

use crate::setting::{POISSON, YOUNG, close};

const FORCE: f64 = 10.0;
const FRICTION: f64 = 0.3;
const SHEAR: f64 = 1.5;

#[test]
fn known_numbers() {
    let hertz = Hertz::of_point_between(FORCE, RADIUS, 0.5 * YOUNG / (1.0 - POISSON * POISSON));
    close("a", hertz.reach, 0.81733, 1e-5);
    close("p0", hertz.peak, 7.1474, 1e-5);
    let law = StickSlip::of_point(hertz, FORCE, FRICTION, SHEAR);
    close("c", law.stick, 0.64872, 1e-5);
    close("δ_x", law.way_of_balls(), 0.011256, 1e-4);
    // Q is the integral of q over the disk, by the midpoint rule.
    let rings = 100_000;
    let width = hertz.reach / f64::from(rings);
    let ring = |k: i32| (f64::from(k) + 0.5) * width;
    let sum: f64 = (0..rings).map(|k| law.traction(ring(k)) * std::f64::consts::TAU * ring(k) * width).sum();
    close("∫ q", sum, SHEAR, 1e-6);
}

#[test]
fn a_ball_sticks_in_the_middle() {
    if std::env::var_os("FORMS_SWEEPS").is_none() {
        return;
    }
    let cells = 4;
    let bodies = halved_balls([f64::INFINITY, RADIUS], FORCE, cells).unwrap();
    let law = StickSlip::of_point(bodies.hertz, FORCE, FRICTION, SHEAR);
    let pressing = bodies.pressed().unwrap();
    let mut solver = CondensedSolver::default();
    let pressed = pressing.direct().unwrap().solver(&mut solver).solve().unwrap().into_field();
    let drawing = bodies.sheared(&law, &pressed).unwrap();
    let solved = drawing.direct().unwrap().start(&pressed).solver(&mut solver).solve().unwrap();
    let tractions = Tractions::of(&drawing, solved.field()).unwrap();
    let [force, shear] = [tractions.force(), tractions.shear()].map(|half| half / bodies.part());
    close("P", force, FORCE, 3e-3);
    close("Q", shear, SHEAR, 0.03);

    // At the forces that come out, further than a cell from the ends of stick and of contact.
    let found = StickSlip::of_point(bodies.hertz, force, FRICTION, shear);
    let cell = bodies.hertz.reach / cells as f64;
    let away = |r: f64| (r - found.stick).abs() > cell && (r - bodies.hertz.reach).abs() > cell;
    let points: Vec<_> = tractions.points.iter().filter(|point| away(point.distance())).collect();
    assert!(points.len() > 20);
    let largest = points
        .iter()
        .map(|point| (point.shear - found.traction(point.distance())).abs() / found.traction(found.stick))
        .fold(0.0, f64::max);
    println!("P {force}, Q {shear}, q {largest:.2e} of q(c), {} steps", solved.iterations());
    assert!(largest < 0.03, "{largest}");
}
