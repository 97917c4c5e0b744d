//! The gradient of a history of sliding steps with friction on moving segments: transposed tangents move the points.

use forms_contact::laws::two_bodies::data;
use forms_fem::contract::PairQuadrature;
use forms_fem::inverse::{ControlError, ControlValues, Controls, LoadHistory, ReducedProblem};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod drawn {
    pub use forms_contact::laws::sliding_bodies::{Data, GammaN, Omega, Touch, direct, first_piola, loads};

    pub fn criterion(u: Unknown<Vector>) -> Energy {
        integral(Omega, dot(u, u) / 2 + dot(criterion_force, u))
    }
    pub fn sensitivities(
        u: State<Vector>,
        p: State<Vector>,
        by_before: Test<Vector>,
        by_friction: Test<Scalar>,
        by_shear_modulus: Test<Scalar>,
    ) -> Form {
        let work = direct(u, p);
        derivative(work, displacement_before, by_before)
            + derivative(work, friction, this(by_friction))
            + derivative(work + criterion(u), mu, by_shear_modulus)
    }
}

struct Bodies {
    space: Arc<Space<2>>,
    materials: Arc<Space<2>>,
    assembler: Assembler<2>,
    steps: usize,
}

impl Bodies {
    fn new(steps: usize) -> Self {
        let slab = rectangle([0.0; 2], [4.0, 0.6], [14, 2], CellShape::Quadrilateral, 1).unwrap();
        let block = rectangle([0.3, 0.62], [1.3, 1.22], [4, 2], CellShape::Quadrilateral, 1).unwrap();
        let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap();
        let space = Space::vector(&mesh, 1).unwrap();
        let materials = Space::discontinuous_scalar(&mesh, 0).unwrap();
        Bodies { assembler: Assembler::new(&mesh), space, materials, steps }
    }

    fn model(
        &self,
        at: &ControlValues<2>,
        before: Given<[f64; 2], 2>,
    ) -> Result<drawn::Model<2>, ControlError> {
        let data = data()
            .lambda(15.0)
            .mu(at.field("shear_modulus")?)
            .gamma0(300.0)
            .friction(at.number("friction")?)
            .displacement_before(before)
            .criterion_force(|x: &[f64; 2]| [0.3 + x[0], 0.5 * x[1]]);
        let touch = Pairing::between("slab top", "block bottom").at(PairQuadrature::Pieces);
        Ok(drawn::Model { data, regions: drawn::Regions::default().touch(touch).gamma_n("block right") })
    }

    fn history(&self) -> LoadHistory<'_, 2> {
        let modulus = |x: &[f64; 2]| 10.0 + 2.0 * x[0].sin() * x[1];
        let modulus = Field::interpolate(&self.materials, modulus).unwrap();
        let controls = Controls::new().number("friction", 0.3).field("shear_modulus", &modulus);
        let held = |step: usize| {
            let along = 0.11 * (step + 1) as f64;
            let mut held = Constraints::new(&self.space);
            held.fix("slab bottom", |_| [0.0; 2]).unwrap();
            held.fix("block top", |_| [along, -0.07]).unwrap();
            held
        };
        let options = NewtonOptions {
            relative_tolerance: 1e-12,
            line_search: LineSearch::OnResidual,
            ..NewtonOptions::default()
        };
        LoadHistory::new(&self.space, self.steps, controls)
            .step(|at| Ok(self.model(at, Given::field(at.before()?))?.direct()))
            .sensitivities(|at, u, p| Ok(self.model(at, Given::field(at.before()?))?.sensitivities(u, p)))
            .criterion(|at| Ok(self.model(at, Given::constant([0.0; 2]))?.criterion()))
            .assembler(&self.assembler)
            .constrained_at(move |step| Ok(held(step)))
            .options(options)
    }
}

/// 20 steps over six facets of the slab: the gradient is that of differences of fourth order.
#[test]
fn gradients_of_sliding_histories_are_those_of_differences() {
    let bodies = Bodies::new(20);
    let mut history = bodies.history();
    let m = history.start();
    let states = history.states(&m).unwrap();
    let touch = Pairing::between("slab top", "block bottom").at(PairQuadrature::Pieces);
    for u in &states {
        let report = bodies.assembler.pairs_at(&touch, 3, u).unwrap();
        assert!(report.deepest_overlap > 1e-4 && report.dropped_parts >= 2, "{report:?}");
    }
    let gradient = history.gradient(&m).unwrap().gradient;
    let direction: Vec<f64> = (0..m.len()).map(|k| 0.1 * (1.0 + 1.7 * k as f64).sin()).collect();
    let slope: f64 = gradient.iter().zip(&direction).map(|(gradient, along)| gradient * along).sum();
    let step = 2e-5;
    let mut at = |t: f64| {
        let moved: Vec<f64> = m.iter().zip(&direction).map(|(m, along)| m + t * along).collect();
        history.sample(&moved).unwrap().value[0]
    };
    let [a, b, c, d] = [step, -step, 2.0 * step, -2.0 * step].map(&mut at);
    let difference = (8.0 * (a - b) - (c - d)) / (12.0 * step);
    let error = (difference - slope).abs() / slope.abs();
    println!("{slope:.12e} and {difference:.12e} by differences: {error:.1e}");
    assert!(error < 1e-7, "{error:e}");
}
