//! Schemes of time integration: their orders on an oscillator and on decay with closed forms.

use forms_fem::prelude::*;
use forms_fem::time::{
    BackwardDifferences, CentralDifferences, GeneralisedAlpha, Mass, OneStepTheta, Scheme, State, Step,
    TimeLoop,
};

pub(super) type Outcome = Result<(), Box<dyn std::error::Error>>;

#[forms(dimension = 2)]
pub(super) mod spring {
    use forms_fem::time::operators::scalar::{rate, second_rate, value};

    #[includes(forms_fem::time::operators::scalar::Data)]
    pub struct Data {
        pub mass: Param,
        pub damping: Param,
        pub stiffness: Param,
        pub cubic: Param,
        pub force: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn motion(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let linear = mass * second_rate(u) + damping * rate(u) + stiffness * value(u);
        integral(Omega, (linear - force) * v)
    }
    pub fn hardening(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let linear = mass * second_rate(u) + damping * rate(u) + stiffness * value(u);
        integral(Omega, (linear + cubic * pow(value(u), 3) - force) * v)
    }
}

/// m ü + c u̇ + k u = F cos(Ω t) on one cell, with all nodes alike.
#[derive(Clone, Copy)]
pub(super) struct Oscillator {
    pub mass: f64,
    pub damping: f64,
    pub stiffness: f64,
    pub force: f64,
}

const DRIVEN: f64 = 1.7;

impl Oscillator {
    pub fn form(self, cubic: f64) -> impl Fn(&Step<2>) -> spring::Model<2> {
        move |step| {
            let Oscillator { mass, damping, stiffness, force } = self;
            let force = force * (DRIVEN * step.time).cos();
            spring::Model::new(
                spring::data_from(step)
                    .mass(mass)
                    .damping(damping)
                    .stiffness(stiffness)
                    .cubic(cubic)
                    .force(force),
            )
        }
    }

    /// The solution that begins at 1 with the rate ½: free vibration and the driven one.
    fn exact(&self, t: f64) -> f64 {
        let Oscillator { mass, damping, stiffness, force } = *self;
        let (a, b) = (stiffness - mass * DRIVEN * DRIVEN, damping * DRIVEN);
        let (cosine, sine) = (force * a / (a * a + b * b), force * b / (a * a + b * b));
        let decay = damping / (2.0 * mass);
        let omega = (stiffness / mass - decay * decay).sqrt();
        let (start, slope) = (1.0 - cosine, 0.5 - DRIVEN * sine);
        let free = (-decay * t).exp()
            * (start * (omega * t).cos() + (slope + decay * start) / omega * (omega * t).sin());
        free + cosine * (DRIVEN * t).cos() + sine * (DRIVEN * t).sin()
    }

    fn exact_rate(&self, t: f64) -> f64 {
        (self.exact(t + 1e-5) - self.exact(t - 1e-5)) / 2e-5
    }

    /// By the equation of motion.
    fn exact_second_rate(&self, t: f64) -> f64 {
        let Oscillator { mass, damping, stiffness, force } = *self;
        (force * (DRIVEN * t).cos() - damping * self.exact_rate(t) - stiffness * self.exact(t)) / mass
    }
}

pub(super) fn cell() -> Result<Arc<Space<2>>, Box<dyn std::error::Error>> {
    let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Quadrilateral, 1)?;
    Ok(Space::scalar(&mesh, 1)?)
}

pub(super) fn same(space: &Arc<Space<2>>, value: f64) -> Field<2> {
    Field::interpolate(space, |_| value).expect("a finite value")
}

pub(super) const OSCILLATOR: Oscillator = Oscillator { mass: 2.0, damping: 0.6, stiffness: 7.0, force: 1.5 };

/// The error at t = 2 after the given number of steps of an oscillator, in value and rate.
fn error(scheme: impl Scheme, steps: usize, mass: Mass) -> Result<f64, Box<dyn std::error::Error>> {
    let (space, size) = (cell()?, 2.0 / steps as f64);
    let state = |t: f64| {
        let (value, rate) = (OSCILLATOR.exact(t), OSCILLATOR.exact_rate(t));
        State::new(t, same(&space, value), same(&space, rate))
    };
    let earlier: Vec<_> =
        (1..scheme.states()).map(|k| state(-(k as f64) * size)).collect::<Result<_, _>>()?;
    let form = |step: &Step<2>| OSCILLATOR.form(0.0)(step).motion();
    let mut motion = TimeLoop::new(form, scheme, state(0.0)?).with_earlier(earlier).mass(mass);
    for _ in 0..steps {
        motion.take(size)?;
    }
    let end = motion.state();
    assert!((end.time - 2.0).abs() < 1e-12);
    let off = (end.value.values()[0] - OSCILLATOR.exact(2.0)).abs();
    Ok(off + (end.rate.values()[3] - OSCILLATOR.exact_rate(2.0)).abs())
}

fn order(scheme: impl Scheme + Clone, mass: Mass) -> Result<f64, Box<dyn std::error::Error>> {
    let errors = [error(scheme.clone(), 40, mass)?, error(scheme, 80, mass)?];
    assert!(errors[0] < 0.5, "{errors:?}");
    Ok((errors[0] / errors[1]).log2())
}

#[test]
fn schemes_for_second_order_have_their_orders() -> Outcome {
    let of_second_order = [
        GeneralisedAlpha::trapezoidal(),
        GeneralisedAlpha::mid_point(),
        GeneralisedAlpha::hilber_hughes_taylor(0.2)?,
        GeneralisedAlpha::wood_bossak_zienkiewicz(0.6)?,
        GeneralisedAlpha::with_spectral_radius(0.5)?,
        GeneralisedAlpha::with_spectral_radius(0.0)?,
    ];
    for scheme in of_second_order {
        let order = order(scheme, Mass::Consistent)?;
        assert!((order - 2.0).abs() < 0.15, "{scheme:?} {order}");
    }
    let order_of_one = order(GeneralisedAlpha::newmark(0.36, 0.7)?, Mass::Consistent)?;
    assert!((order_of_one - 1.0).abs() < 0.15, "{order_of_one}");
    for mass in [Mass::Consistent, Mass::Lumped] {
        let order = order(CentralDifferences, mass)?;
        assert!((order - 2.0).abs() < 0.15, "{order}");
    }
    for k in 1..=4 {
        let order = order(BackwardDifferences::new(k)?, Mass::Consistent)?;
        assert!((order - k as f64).abs() < 0.3, "{k} {order}");
    }
    Ok(())
}

/// The order of the second rate at the end of a run, compared with that of the motion at a part of the last step before its end.
fn order_of_second_rate(
    scheme: impl Scheme + Clone,
    before_the_end: f64,
) -> Result<f64, Box<dyn std::error::Error>> {
    let space = cell()?;
    let error = |steps: usize| -> Result<f64, Box<dyn std::error::Error>> {
        let size = 2.0 / steps as f64;
        let state = |t: f64| {
            let (value, rate) = (OSCILLATOR.exact(t), OSCILLATOR.exact_rate(t));
            State::new(t, same(&space, value), same(&space, rate))
        };
        let earlier: Vec<_> =
            (1..scheme.states()).map(|k| state(-(k as f64) * size)).collect::<Result<_, _>>()?;
        let form = |step: &Step<2>| OSCILLATOR.form(0.0)(step).motion();
        let mut motion = TimeLoop::new(form, scheme.clone(), state(0.0)?).with_earlier(earlier);
        for _ in 0..steps {
            motion.take(size)?;
        }
        let exact = OSCILLATOR.exact_second_rate(2.0 - before_the_end * size);
        Ok((motion.state().second_rate.values()[1] - exact).abs())
    };
    let errors = [error(160)?, error(320)?];
    // Its size is about 3.
    assert!(errors[0] < 0.2, "{scheme:?}: {errors:?}");
    Ok((errors[0] / errors[1]).log2())
}

/// No scheme's second rate keeps an error that steps do not make smaller, whether it reads that of the first state or not.
#[test]
fn second_rates_come_to_those_of_the_motion() -> Outcome {
    let of_the_family = [
        (GeneralisedAlpha::trapezoidal(), 2.0),
        (GeneralisedAlpha::mid_point(), 1.0),
        (GeneralisedAlpha::with_spectral_radius(1.0)?, 1.0),
        (GeneralisedAlpha::with_spectral_radius(0.5)?, 1.0),
        (GeneralisedAlpha::hilber_hughes_taylor(0.2)?, 1.0),
        (GeneralisedAlpha::wood_bossak_zienkiewicz(0.6)?, 1.0),
    ];
    for (scheme, expected) in of_the_family {
        let order = order_of_second_rate(scheme, 0.0)?;
        assert!((order - expected).abs() < 0.15, "{scheme:?}: {order} is not {expected}");
    }
    for order in [
        order_of_second_rate(CentralDifferences, 0.0)?,
        order_of_second_rate(BackwardDifferences::new(2)?, 0.0)?,
    ] {
        assert!((order - 2.0).abs() < 0.15, "{order}");
    }
    for scheme in [GeneralisedAlpha::mid_point(), GeneralisedAlpha::with_spectral_radius(1.0)?] {
        let order = order_of_second_rate(scheme, 0.5)?;
        assert!((order - 2.0).abs() < 0.15, "in the middle of the step: {order}");
    }
    Ok(())
}

/// The order in which the errors at t = 1 of c u̇ + k u = F cos Ωt fall, from ten steps to twenty.
fn order_of_decay(scheme: impl Scheme + Copy) -> Result<f64, Box<dyn std::error::Error>> {
    let decay = Oscillator { mass: 0.0, damping: 1.3, stiffness: 2.0, force: 1.5 };
    let (a, b) = (decay.stiffness, decay.damping * DRIVEN);
    let (cosine, sine) = (decay.force * a / (a * a + b * b), decay.force * b / (a * a + b * b));
    let exact = |t: f64| {
        (1.0 - cosine) * (-decay.stiffness / decay.damping * t).exp()
            + cosine * (DRIVEN * t).cos()
            + sine * (DRIVEN * t).sin()
    };
    let space = cell()?;
    let error = |steps: usize| -> Result<f64, Box<dyn std::error::Error>> {
        let size = 1.0 / steps as f64;
        let state = |t: f64| State::at_rest(t, same(&space, exact(t)));
        let earlier: Vec<_> = (1..scheme.states()).map(|k| state(-(k as f64) * size)).collect();
        let form = |step: &Step<2>| decay.form(0.0)(step).motion();
        let mut cooling = TimeLoop::new(form, scheme, state(0.0)).with_earlier(earlier);
        for _ in 0..steps {
            cooling.take(size)?;
        }
        Ok((cooling.state().value.values()[0] - exact(1.0)).abs())
    };
    Ok((error(10)? / error(20)?).log2())
}

#[test]
fn schemes_for_first_order_have_their_orders() -> Outcome {
    let euler = order_of_decay(OneStepTheta::implicit_euler())?;
    assert!((euler - 1.0).abs() < 0.35, "{euler}");
    let crank_nicolson = order_of_decay(OneStepTheta::crank_nicolson())?;
    assert!((crank_nicolson - 2.0).abs() < 0.35, "{crank_nicolson}");
    for k in [2, 3, 5] {
        let order = order_of_decay(BackwardDifferences::new(k)?)?;
        assert!((order - k as f64).abs() < 0.35, "{k} {order}");
    }
    Ok(())
}

#[test]
fn a_hardening_spring_keeps_its_order() -> Outcome {
    // u = cn(ωt | k²)-like motion has no elementary form: Richardson's quotient of three runs shows the order.
    let space = cell()?;
    let end = |steps: usize| -> Result<f64, Box<dyn std::error::Error>> {
        let form = |step: &Step<2>| OSCILLATOR.form(4.0)(step).hardening();
        let start = State::at_rest(0.0, same(&space, 1.0));
        let mut motion = TimeLoop::new(form, GeneralisedAlpha::with_spectral_radius(0.8)?, start);
        for _ in 0..steps {
            let taken = motion.take(1.0 / steps as f64)?;
            assert!(taken.history.len() > 1, "Newton's method solves it");
        }
        Ok(motion.state().value.values()[2])
    };
    let [coarse, middle, fine] = [end(20)?, end(40)?, end(80)?];
    let order = ((coarse - middle) / (middle - fine)).log2();
    assert!((order - 2.0).abs() < 0.1, "{order}");
    Ok(())
}
