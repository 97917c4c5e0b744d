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

/// Draws the ball, and compares q with the closed form at the forces that come out: the largest error of its mean over circles further than
/// a cell from the ends of stick and of contact relative to q(c), and its error in the L² norm.
fn draw(cells: usize) -> [f64; 2] {
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
    // The curved surfaces miss some of the half-spaces where the shear stress is largest: a part a/R.
    close("Q", shear, SHEAR, 0.03);

    let found = StickSlip::of_point(bodies.hertz, force, FRICTION, shear);
    let (mut error, mut size) = (0.0, 0.0);
    for point in &tractions.points {
        let exact = found.traction(point.distance());
        error += point.weight * (point.shear - exact).powi(2);
        size += point.weight * exact * exact;
    }
    // Rings half a cell wide.
    let cell = bodies.hertz.reach / cells as f64;
    let mut largest = 0.0_f64;
    for ring in 0..3 * cells {
        let inner = 0.5 * cell * ring as f64;
        let middle = inner + 0.25 * cell;
        let inside = |r: f64| (inner..inner + 0.5 * cell).contains(&r);
        let points: Vec<_> = tractions.points.iter().filter(|point| inside(point.distance())).collect();
        let mean = |value: &dyn Fn(f64, f64) -> f64| {
            let weight: f64 = points.iter().map(|point| point.weight).sum();
            points.iter().map(|point| point.weight * value(point.shear, point.distance())).sum::<f64>()
                / weight
        };
        let q = [mean(&|shear, _| shear), mean(&|_, r| found.traction(r))];
        let spread = mean(&|shear, r| (shear - found.traction(r)).abs()) / found.traction(found.stick);
        let off = (q[0] - q[1]).abs() / found.traction(found.stick);
        println!(
            "r/a = {:.3}: {:.4} and {:.4}, {off:.1e}, {spread:.1e}",
            middle / bodies.hertz.reach,
            q[0],
            q[1]
        );
        let near = |end: f64| (middle - end).abs() < 1.25 * cell;
        if !near(found.stick) && !near(bodies.hertz.reach) {
            largest = largest.max(off);
        }
    }
    let of_norm = (error / size).sqrt();
    println!("a/h = {cells}: {largest:.2e} of q(c), {of_norm:.2e} in L²; {} steps", solved.iterations());
    [largest, of_norm]
}

#[test]
fn a_ball_sticks_in_the_middle() {
    let finest = if std::env::var_os("FORMS_SWEEPS").is_some() { 4 } else { 3 };
    for cells in 3..=finest {
        let [largest, of_norm] = draw(cells);
        // All but the kinks at the ends of stick and of contact, which the rule of 16 points a piece does not resolve: with 25 points
        // the norm is 0.336/cells at three cells, with 16 points 0.363/cells.
        assert!(largest < 0.005 && of_norm < 0.37 / cells as f64, "{largest} {of_norm}");
    }
}
