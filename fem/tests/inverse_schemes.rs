//! Adjoints of motions by schemes that read several states, and by explicit ones: compared with adjoints of one degree of freedom that are written
//! out by hand, with the loop over the same steps, with differences.

use forms_fem::inverse::{ControlError, Controls, MotionHistory, Observations, ReducedProblem, StepContext};
use forms_fem::prelude::*;
use forms_fem::time::{
    BackwardDifferences, CentralDifferences, GeneralisedAlpha, Mass, Scheme, State, Step, TimeLoop,
};

use crate::swinging_body::{Body, STEPS, swung};

/// m ü + c u̇ + k u = load, everywhere the same.
#[forms(dimension = 2)]
mod oscillator {
    use forms_fem::time::operators::scalar::{rate, second_rate, value};

    #[includes(forms_fem::time::operators::scalar::Data)]
    pub struct Data {
        pub mass: Param,
        pub damping: Param,
        pub stiffness: Param,
        pub load: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn motion(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (mass * second_rate(u) + damping * rate(u) + stiffness * value(u) - load) * v)
    }
    pub fn sensitivities(
        u: State<Scalar>,
        p: State<Scalar>,
        by_mass: Test<Scalar>,
        by_damping: Test<Scalar>,
        by_stiffness: Test<Scalar>,
        by_load: Test<Scalar>,
    ) -> Form {
        let work = motion(u, p);
        derivative(work, mass, by_mass)
            + derivative(work, damping, by_damping)
            + derivative(work, stiffness, by_stiffness)
            + derivative(work, load, by_load)
    }
}

/// Sizes of steps that do not follow from each other.
const SIZES: [f64; 9] = [0.11, 0.07, 0.13, 0.13, 0.05, 0.09, 0.12, 0.08, 0.1];
/// m, c, k, u₀, u̇₀.
const PARAMETERS: [f64; 5] = [1.3, 0.4, 5.0, 0.7, -0.3];

fn load(step: usize) -> f64 {
    0.5 + 0.3 * (step as f64).sin()
}

/// J = Σ (uⁿ − 0.1 n)²/2 of the values after the steps, and its slope by uⁿ.
fn misfit(step: usize, u: f64) -> (f64, f64) {
    let off = u - 0.1 * step as f64;
    (off * off / 2.0, off)
}

fn space() -> Arc<Space<2>> {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1).unwrap();
    Space::scalar(&mesh, 1).unwrap()
}

/// J of the oscillator by the loop over steps.
fn of_loop(scheme: impl Scheme, mass: Mass) -> f64 {
    let space = space();
    let [m, c, k, u, rate] = PARAMETERS;
    let starts = [u, rate].map(|value| Field::interpolate(&space, |_| value).unwrap());
    let form = |step: &Step<2>| {
        let mut ends = SIZES.iter().scan(0.0, |time, size| {
            *time += size;
            Some(*time)
        });
        let number = ends.position(|end| end > step.before.time + 1e-9).unwrap();
        let load = load(number);
        oscillator::Model::new(oscillator::data_from(step).mass(m).damping(c).stiffness(k).load(load))
            .motion()
    };
    let [value, rate] = starts;
    let mut motion = TimeLoop::new(form, scheme, State::new(0.0, value, rate).unwrap()).mass(mass);
    let values = SIZES.iter().enumerate().map(|(step, size)| {
        motion.take(*size).unwrap();
        misfit(step, motion.state().value.evaluate(&[0.3, 0.6]).unwrap()[0]).0
    });
    values.sum()
}

/// J and dJ/d(m, c, k, u₀, u̇₀, loads) of the oscillator by the library, with starts that are the same at all nodes.
fn of_library(scheme: impl Scheme, mass: Mass) -> (f64, Vec<f64>) {
    let space = space();
    let [m, c, k, u, rate] = PARAMETERS;
    let constant = |value: f64| Field::interpolate(&space, |_| value).unwrap();
    let loads: Vec<f64> = (0..SIZES.len()).map(load).collect();
    let controls = Controls::new()
        .number("mass", m)
        .number("damping", c)
        .number("stiffness", k)
        .per_step("load", &loads)
        .start("start", &constant(u))
        .start_rate("start_rate", &constant(rate));
    let model = |during: &StepContext<2>| -> Result<_, ControlError> {
        Ok(oscillator::Model::new(
            oscillator::data_from(during)
                .mass(during.number("mass")?)
                .damping(during.number("damping")?)
                .stiffness(during.number("stiffness")?)
                .load(during.number("load")?),
        ))
    };
    let mut history = MotionHistory::new(&space, &SIZES[..], scheme, controls)
        .mass(mass)
        .motion(|during| Ok(model(during)?.motion()))
        .sensitivities(|during, u, p| Ok(model(during)?.sensitivities(u, p)));
    for step in 0..SIZES.len() {
        let target = [0.1 * step as f64];
        history =
            history.observed(step, Observations::new(&space).at_point(&[0.3, 0.6], &target, 0.5).unwrap());
    }
    let start = history.start();
    let (value, all) = history.value_and_gradient(&start).unwrap();
    let loads = 3 + SIZES.len();
    let nodes = space.unknowns();
    let sums = [loads, loads + nodes].map(|from| all[from..from + nodes].iter().sum::<f64>());
    (value, [&all[..3], &sums, &all[3..loads]].concat())
}

/// The same by u̇ₙ = Σ aⱼ uₙ₋ⱼ, üₙ = Σ aⱼ u̇ₙ₋ⱼ with the parabola through three states (a straight line in the first step), forward and back.
fn backward_differences_by_hand() -> (f64, Vec<f64>) {
    let [m, c, k, u_0, rate_0] = PARAMETERS;
    let count = SIZES.len();
    let weights = |n: usize| match n {
        1 => [1.0 / SIZES[0], -1.0 / SIZES[0], 0.0],
        _ => {
            let (h, g) = (SIZES[n - 1], SIZES[n - 2]);
            [(2.0 * h + g) / (h * (h + g)), -(h + g) / (h * g), h / (g * (h + g))]
        }
    };
    let (mut u, mut v, mut w) = (vec![u_0], vec![rate_0], vec![0.0]);
    let mut value = 0.0;
    for n in 1..=count {
        let a = weights(n);
        let sum = |of: &[f64]| (1..=n.min(2)).map(|j| a[j] * of[n - j]).sum::<f64>();
        let (known_rate, known_of_rates) = (sum(&u), sum(&v));
        let known_second_rate = a[0] * known_rate + known_of_rates;
        let stiffness = m * a[0] * a[0] + c * a[0] + k;
        u.push((load(n - 1) - m * known_second_rate - c * known_rate) / stiffness);
        v.push(a[0] * u[n] + known_rate);
        w.push(a[0] * v[n] + known_of_rates);
        value += misfit(n - 1, u[n]).0;
    }
    // Multipliers p of m w + c v + k u = load, q of v = Σ a u, r of w = Σ a v.
    let (mut p, mut q, mut r) = (vec![0.0; count + 1], vec![0.0; count + 1], vec![0.0; count + 1]);
    let mut gradient = vec![0.0; 5 + count];
    for n in (0..=count).rev() {
        let later = |of: &[f64]| {
            (1..=2).filter(|j| n + j <= count).map(|j| weights(n + j)[j] * of[n + j]).sum::<f64>()
        };
        let (of_rates, of_values) = (later(&r), later(&q));
        if n == 0 {
            (gradient[3], gradient[4]) = (-of_values, -of_rates);
            break;
        }
        let a = weights(n);
        // r = −m p, q = −c p + a r + …, k p − a q − … + J_u = 0.
        let stiffness = m * a[0] * a[0] + c * a[0] + k;
        p[n] = (a[0] * of_rates + of_values - misfit(n - 1, u[n]).1) / stiffness;
        r[n] = -m * p[n];
        q[n] = -c * p[n] + a[0] * r[n] + of_rates;
        gradient[0] += p[n] * w[n];
        gradient[1] += p[n] * v[n];
        gradient[2] += p[n] * u[n];
        gradient[4 + n] = -p[n];
    }
    (value, gradient)
}

/// The same by u₁ = u₀ + h u̇₀ + h²/2 ü₀, m ü₁ + c (u̇₀ + h ü₀) + k u₁ = load, u̇₁ = u̇₀ + h (ü₀ + ü₁)/2.
fn central_differences_by_hand() -> (f64, Vec<f64>) {
    let [m, c, k, u_0, rate_0] = PARAMETERS;
    let count = SIZES.len();
    let (mut u, mut v) = (vec![u_0], vec![rate_0]);
    let mut w = vec![(load(0) - c * rate_0 - k * u_0) / m];
    let mut value = 0.0;
    for n in 1..=count {
        let h = SIZES[n - 1];
        u.push(u[n - 1] + h * v[n - 1] + h * h / 2.0 * w[n - 1]);
        w.push((load(n - 1) - c * (v[n - 1] + h * w[n - 1]) - k * u[n]) / m);
        v.push(v[n - 1] + h * (w[n - 1] + w[n]) / 2.0);
        value += misfit(n - 1, u[n]).0;
    }
    let mut gradient = vec![0.0; 5 + count];
    // dJ/d(u, u̇, ü) after a step, and p of its equation.
    let [mut by_u, mut by_v, mut by_w] = [0.0; 3];
    for n in (1..=count).rev() {
        let h = SIZES[n - 1];
        by_w += h / 2.0 * by_v;
        let p = -by_w / m;
        by_u += misfit(n - 1, u[n]).1 + k * p;
        gradient[0] += p * w[n];
        gradient[1] += p * (v[n - 1] + h * w[n - 1]);
        gradient[2] += p * u[n];
        gradient[4 + n] -= p;
        by_w = h / 2.0 * by_v + c * h * p + h * h / 2.0 * by_u;
        by_v += c * p + h * by_u;
    }
    let p = -by_w / m;
    gradient[0] += p * w[0];
    gradient[1] += p * v[0];
    gradient[2] += p * u[0];
    gradient[5] -= p;
    gradient[3] = by_u + k * p;
    gradient[4] = by_v + c * p;
    (value, gradient)
}

fn agree(label: &str, (value, gradient): (f64, Vec<f64>), (by_hand, known): (f64, Vec<f64>)) {
    assert!((value - by_hand).abs() < 1e-12 * by_hand, "{label}: J = {value}, by hand {by_hand}");
    let largest = known.iter().fold(0.0_f64, |largest, slope| largest.max(slope.abs()));
    for (place, (found, known)) in gradient.iter().zip(&known).enumerate() {
        assert!((found - known).abs() < 1e-11 * largest, "{label}, entry {place}: {found}, by hand {known}");
    }
}

#[test]
fn adjoints_are_those_written_by_hand() {
    let second_order = BackwardDifferences::new(2).unwrap();
    agree("BDF", of_library(second_order, Mass::Consistent), backward_differences_by_hand());
    for mass in [Mass::Consistent, Mass::Lumped] {
        agree("central differences", of_library(CentralDifferences, mass), central_differences_by_hand());
    }
}

/// Schemes with the step sizes that they take well, and the mass matrix.
fn motions(body: &Body) -> [(&'static str, MotionHistory<'_, 2>); 4] {
    let backward = |order| BackwardDifferences::new(order).unwrap();
    [
        ("BDF 2", body.history((STEPS, 0.15), backward(2))),
        ("BDF 4", body.history(&[0.15, 0.1, 0.17, 0.12, 0.15, 0.09][..], backward(4))),
        ("central differences", body.history((STEPS, 0.04), CentralDifferences)),
        ("lumped masses", body.history((STEPS, 0.04), CentralDifferences).mass(Mass::Lumped)),
    ]
}

#[test]
fn histories_take_the_steps_of_the_loop() {
    let backward = |order| Box::new(BackwardDifferences::new(order).unwrap()) as Box<dyn Scheme>;
    let schemes: [fn() -> Box<dyn Scheme>; 2] =
        [|| Box::new(GeneralisedAlpha::trapezoidal()), || Box::new(CentralDifferences)];
    for order in 1..=5 {
        let (history, known) =
            (of_library(backward(order), Mass::Consistent).0, of_loop(backward(order), Mass::Consistent));
        assert!((history - known).abs() < 1e-12 * known, "order {order}: {history} {known}");
    }
    for scheme in schemes {
        for mass in [Mass::Consistent, Mass::Lumped] {
            let (history, known) = (of_library(scheme(), mass).0, of_loop(scheme(), mass));
            assert!((history - known).abs() < 1e-12 * known, "{:?}, {mass:?}: {history} {known}", scheme());
        }
    }
}

/// By differences of fourth order along all controls, with tangents, and with rates that give the derivatives by what was known before.
#[test]
fn gradients_beside_differences() {
    let body = Body::new([4, 2]);
    let direction = body.direction(1.0);
    for (tangents, given) in motions(&body).into_iter().zip(motions(&body)) {
        let ((name, mut tangents), (_, given)) = (tangents, given);
        let mut given =
            given.sensitivities(|during, u, p| Ok(swung(during, None)?.motion_sensitivities(u, p)));
        let m = tangents.start();
        let (all, few) = (tangents.gradient(&m).unwrap(), given.gradient(&m).unwrap());
        let largest = all.gradient.iter().fold(0.0_f64, |largest, slope| largest.max(slope.abs()));
        for (one, other) in all.gradient.iter().zip(&few.gradient) {
            assert!((one - other).abs() < 1e-12 * largest, "{name}: {one} by tangents, {other} by rates");
        }
        let slope: f64 = all.gradient.iter().zip(&direction).map(|(slope, along)| slope * along).sum();
        let mut at = |step: f64| {
            let moved: Vec<f64> = m.iter().zip(&direction).map(|(m, along)| m + step * along).collect();
            tangents.value(&moved).unwrap()
        };
        let step = 2e-3;
        let difference = (8.0 * (at(step) - at(-step)) - (at(2.0 * step) - at(-2.0 * step))) / (12.0 * step);
        let error = (slope / difference - 1.0).abs();
        println!("{name}: {slope:.12e} and {difference:.12e} by differences: {error:.1e}");
        assert!(error < 1e-8, "{name}: {slope} {difference}");
    }
}
