//! Gradients of histories with friction: 200 steps to and fro compared with differences, with all states stored and with few.

use std::f64::consts::TAU;
use std::time::Instant;

use forms_contact::forms;
use forms_contact::laws::frictional_nitsche as friction;
use forms_fem::inverse::{Controls, LoadHistory, ReducedProblem, taylor_test};
use forms_fem::prelude::*;

/// Coulomb's law by Nitsche's method, with a criterion over the steps, and the rates of a step by what is before it, by κ and by
/// the load.
#[forms(dimension = 2)]
mod rubbed {
    pub use forms_contact::laws::frictional_nitsche::{GammaC, GammaN, Omega, direct};

    #[includes(forms_contact::laws::frictional_nitsche::Data)]
    pub struct Data {
        /// The load of amplitude one on Γ_N \[stress\].
        pub pull: Param<Vector>,
    }

    pub fn criterion(u: Unknown<Vector>) -> Energy {
        integral(Omega, dot(u, u) / 2 + dot(criterion_force, u)) + integral(GammaC, sqr(u[0]))
    }

    pub fn sensitivities(
        u: State<Vector>,
        p: State<Vector>,
        by_before: Test<Vector>,
        by_friction: Test<Scalar>,
        by_load: Test<Scalar>,
    ) -> Form {
        let work = direct(u, p);
        derivative(work, displacement_before, by_before)
            + derivative(work, friction, by_friction)
            + derivative(work, traction, by_load * pull)
    }
}

const YOUNG: f64 = 200.0;
const POISSON: f64 = 0.3;
const PULL: [f64; 2] = [1.0, -0.3];

/// A block that is pressed on a flat, and pulled at its side to and fro twice.
struct Block {
    space: Arc<Space<2>>,
    assembler: Assembler<2>,
    top: Constraints<2>,
    steps: usize,
}

impl Block {
    fn new(cells: usize, steps: usize) -> Self {
        let mesh = rectangle([0.0; 2], [2.0, 1.0], [2 * cells, cells], CellShape::Quadrilateral, 1).unwrap();
        let space = Space::vector(&mesh, 1).unwrap();
        let mut top = Constraints::new(&space);
        top.fix_component("top", 1, |_| -0.01).unwrap();
        top.fix_component("left", 0, |_| 0.0).unwrap();
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
        Block { space, assembler, top, steps }
    }

    fn model(&self, coefficient: f64, load: f64, before: &Field<2>) -> rubbed::Model<2> {
        let base = forms::data()
            .lambda(YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)))
            .mu(YOUNG / (2.0 * (1.0 + POISSON)))
            .gamma0(20.0 * YOUNG)
            .obstacle_normal([0.0, -1.0])
            .gap(0.0)
            .theta(0.0)
            .criterion_force(|x: &[f64; 2]| [0.3 + x[0], 0.5 * x[1]])
            .traction(PULL.map(|pull| load * pull));
        let base = friction::data_from(base).friction(coefficient).displacement_before(before);
        let regions = rubbed::Regions::default().gamma_n("right").gamma_c("bottom");
        rubbed::Model { data: rubbed::data_from(base).pull(PULL), regions }
    }

    fn history(&self) -> LoadHistory<'_, 2> {
        let loads: Vec<f64> = (1..=self.steps)
            .map(|n| 1.5 * (2.0 * TAU * n as f64 / self.steps as f64).sin() + 0.001 * (n % 7) as f64)
            .collect();
        let controls = Controls::new().number("friction", 0.3).per_step("load", &loads);
        LoadHistory::new(&self.space, self.steps, controls)
            .step(|at| Ok(self.model(at.number("friction")?, at.number("load")?, at.before()?).direct()))
            .sensitivities(|at, u, p| {
                Ok(self.model(at.number("friction")?, at.number("load")?, at.before()?).sensitivities(u, p))
            })
            .criterion(|at| {
                Ok(self.model(at.number("friction")?, 0.0, &Field::zero(&self.space)).criterion())
            })
            .assembler(&self.assembler)
            .constrained(&self.top)
            .options(NewtonOptions {
                relative_tolerance: 1e-12,
                line_search: LineSearch::OnResidual,
                ..NewtonOptions::default()
            })
    }
}

/// 200 steps: order two away from kinks, differences to 10⁻⁷; at most 12 stored states give the same gradient for 496 steps solved
/// in place of 200. FORMS_SWEEPS=1: on a finer mesh. Prints the time forward and
/// back compared with that forward.
#[test]
fn two_hundred_steps_of_friction() {
    let sweep = std::env::var_os("FORMS_SWEEPS").is_some();
    let block = Block::new(if sweep { 12 } else { 3 }, 200);
    let mut history = block.history();
    let m = history.start();
    let (mut forward, mut both) = (f64::INFINITY, f64::INFINITY);
    let (mut value, mut whole) = (f64::NAN, None);
    // The shorter of some times: what other programs take does not count.
    for _ in 0..if sweep { 3 } else { 1 } {
        let begun = Instant::now();
        value = history.value(&m).unwrap();
        forward = forward.min(begun.elapsed().as_secs_f64());
        let begun = Instant::now();
        whole = Some(history.gradient(&m).unwrap());
        both = both.min(begun.elapsed().as_secs_f64());
    }
    let whole = whole.unwrap();
    assert_eq!(whole.work.steps_solved, 200);
    assert!((whole.value - value).abs() <= 1e-12 * value.abs());
    println!("forward {forward:.3} s, forward and adjoint {both:.3} s: {:.2}", both / forward);

    let direction: Vec<f64> =
        (0..m.len()).map(|k| if k == 0 { 0.02 } else { 0.02 * (0.1 * k as f64).cos() }).collect();
    let slope: f64 = whole.gradient.iter().zip(&direction).map(|(gradient, along)| gradient * along).sum();
    let report = taylor_test(&mut history, &m, &direction, 0.0125).unwrap();
    println!("{report}");
    let order = report.second_order().unwrap();
    assert!((order - 2.0).abs() < 0.02, "{report}");
    let mut at = |t: f64| {
        let moved: Vec<f64> = m.iter().zip(&direction).map(|(m, along)| m + t * along).collect();
        history.sample(&moved).unwrap()
    };
    // The step that the test came to, or the next one with the points in contact, in stick and in slip of the start on the other side
    // too: a point may change its state there alone.
    let switches = at(0.0).active_set;
    let steps = report.steps.iter().filter(|step| step.same_active_set).skip(2).map(|step| step.step);
    let (step, samples) = steps
        .map(|step| (step, [at(step), at(-step)]))
        .find(|(_, samples)| samples.iter().all(|sample| sample.active_set == switches))
        .expect("no point changes its state on either side");
    let difference = (samples[0].value[0] - samples[1].value[0]) / (2.0 * step);
    let error = (difference - slope).abs() / slope.abs();
    println!("{slope:.12e} and {difference:.12e} by differences: {error:.1e}");
    assert!(error < 1e-7);

    let begun = Instant::now();
    let few = block.history().stored_states(12).gradient(&m).unwrap();
    println!("with 12 states {:.3} s, {:?}", begun.elapsed().as_secs_f64(), few.work);
    assert!(few.work.most_stored <= 12 && few.work.steps_solved == 496);
    let largest = whole.gradient.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
    for (few, whole) in few.gradient.iter().zip(&whole.gradient) {
        assert!((few - whole).abs() < 1e-9 * largest, "{few} is not {whole}");
    }
}
