//! Maps over plain arrays: readings of histories of loads and of motions, their products with vectors compared with differences, with
//! observations of the same, and with checkpointing; what does not fit is named.

use forms_fem::inverse::{
    ControlError, ControlledEvolution, Controls, CriterionMap, DifferentiableMap, LoadHistory, MapError,
    MotionHistory, Observations, Part, Readings, ReadingsMap, ReducedProblem, StepContext,
};
use forms_fem::prelude::*;
use forms_fem::time::GeneralisedAlpha;

#[forms(dimension = 2)]
mod creeping {
    pub struct Data {
        pub conductivity: Given<Scalar>,
        pub source: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn step(u: Unknown<Scalar>, v: Test<Scalar>, before: State<Scalar>) -> Form {
        integral(Omega, (u - before) * v + conductivity * (1 + sqr(u)) * dot(grad(u), grad(v)) - source * v)
    }
    pub fn sensitivities(
        u: State<Scalar>,
        before: State<Scalar>,
        p: State<Scalar>,
        by_before: Test<Scalar>,
        by_conductivity: Test<Scalar>,
        by_source: Test<Scalar>,
    ) -> Form {
        let work = step(u, p, before);
        derivative(work, before, by_before)
            + derivative(work, conductivity, by_conductivity)
            + derivative(work, source, by_source)
    }
}

#[forms(dimension = 2)]
mod swinging {
    use forms_fem::time::operators::scalar::{second_rate, value};

    #[includes(forms_fem::time::operators::scalar::Data)]
    pub struct Data {
        pub stiffness: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn motion(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let w = value(u);
        integral(Omega, second_rate(u) * v + stiffness * (dot(grad(w), grad(v)) + pow(w, 3) * v) - v)
    }
    pub fn sensitivities(u: State<Scalar>, p: State<Scalar>, by_stiffness: Test<Scalar>) -> Form {
        derivative(motion(u, p), stiffness, by_stiffness)
    }
}

const STEPS: usize = 6;
const POINTS: [[f64; 2]; 2] = [[0.31, 0.42], [0.9, 0.77]];

struct Plate {
    space: Arc<Space<2>>,
    held: Constraints<2>,
    conductivity: Field<2>,
}

impl Plate {
    fn new() -> Self {
        let mesh = rectangle([0.0; 2], [1.0; 2], [3, 3], CellShape::Quadrilateral, 1).unwrap();
        let space = Space::scalar(&mesh, 2).unwrap();
        let mut held = Constraints::new(&space);
        held.fix("left", |_| 0.1).unwrap();
        let cells = Space::discontinuous_scalar(&mesh, 0).unwrap();
        let conductivity = Field::interpolate(&cells, |x| 0.3 + 0.2 * x[1]).unwrap();
        Plate { space, held, conductivity }
    }

    fn options() -> NewtonOptions {
        NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() }
    }

    fn creep(&self) -> LoadHistory<'static, 2> {
        let controls = Controls::new()
            .field("conductivity", &self.conductivity)
            .per_step("source", &[0.5, 0.7, 0.2, 0.4, 0.9, 0.1]);
        let model = |at: &forms_fem::inverse::ControlValues<2>| -> Result<_, ControlError> {
            let conductivity = Given::field(&at.field("conductivity")?);
            Ok(creeping::Model::new(creeping::data().conductivity(conductivity).source(at.number("source")?)))
        };
        LoadHistory::new(&self.space, STEPS, controls)
            .step(move |at| Ok(model(at)?.step(at.before()?)))
            .sensitivities(move |at, u, p| Ok(model(at)?.sensitivities(u, at.before()?, p)))
            .constrained(&self.held)
            .options(Plate::options())
    }

    fn swing(&self) -> MotionHistory<'static, 2> {
        let model = |during: &StepContext<2>| -> Result<_, ControlError> {
            let stiffness = during.number("stiffness")?;
            Ok(swinging::Model::new(swinging::data_from(during).stiffness(stiffness)))
        };
        let start = Field::interpolate(&self.space, |x| 0.1 + 0.3 * x[0]).unwrap();
        let controls = Controls::new().number("stiffness", 0.8).start("start", &start);
        MotionHistory::new(&self.space, (STEPS, 0.1), GeneralisedAlpha::trapezoidal(), controls)
            .motion(move |during| Ok(model(during)?.motion()))
            .sensitivities(move |during, u, p| Ok(model(during)?.sensitivities(u, p)))
            .constrained(&self.held)
            .options(Plate::options())
    }

    fn readings(&self) -> Readings<2> {
        POINTS.iter().fold(Readings::new(&self.space), |readings, point| readings.at_point(point).unwrap())
    }

    /// Points after step 2 and after the last, and between them all nodes.
    fn map<H: ControlledEvolution<2>>(&self, history: H) -> ReadingsMap<H, 2> {
        let map = ReadingsMap::new(history).unwrap();
        let map = map.output("middle", 2, self.readings()).unwrap();
        let map = map.output("all", 3, Readings::new(&self.space).at_nodes()).unwrap();
        map.output("end", STEPS - 1, self.readings()).unwrap()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn near(label: &str, found: &[f64], expected: &[f64], accuracy: f64) {
    let size = expected.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() <= accuracy * size, "{label}: {found} is not {expected}");
    }
}

/// Products compared with central differences, with one another, with few states, and after other controls were asked for.
fn check<H: ControlledEvolution<2>>(
    label: &str,
    plate: &Plate,
    history: impl Fn() -> H,
    few: impl Fn() -> H,
) {
    let mut map = plate.map(history());
    let m = map.start();
    let direction: Vec<f64> = (0..m.len()).map(|k| (1.0 + 1.7 * k as f64).sin()).collect();
    let h = 1e-5;
    let moved = |step: f64| m.iter().zip(&direction).map(|(m, along)| m + step * along).collect::<Vec<_>>();
    let [above, below] = [h, -h].map(|step| map.value(&moved(step)).unwrap());
    let differences: Vec<f64> =
        above.iter().zip(&below).map(|(above, below)| (above - below) / (2.0 * h)).collect();
    let along = map.jvp(&m, &direction).unwrap();
    near(label, &along, &differences, 1e-7);
    let w: Vec<f64> = (0..along.len()).map(|k| (0.3 * k as f64).cos()).collect();
    let product = map.vjp(&m, &w).unwrap();
    let size: f64 = w.iter().zip(&along).map(|(w, along)| (w * along).abs()).sum();
    assert!((dot(&w, &along) - dot(&product, &direction)).abs() < 1e-11 * size, "{label}");
    // What is remembered is of these controls alone.
    map.value(&moved(0.1)).unwrap();
    near(label, &map.vjp(&m, &w).unwrap(), &product, 1e-10);
    let mut few = plate.map(few());
    near(label, &few.vjp(&m, &w).unwrap(), &product, 1e-10);
    near(label, &few.value(&m).unwrap(), &map.value(&m).unwrap(), 1e-11);
}

#[test]
fn readings_of_loads() {
    let plate = Plate::new();
    check("creep", &plate, || plate.creep(), || plate.creep().stored_states(2));
}

#[test]
fn readings_of_motions() {
    let plate = Plate::new();
    check("swing", &plate, || plate.swing(), || plate.swing().stored_states(2));
}

/// Σ f (y − d)² by observations, and by readings with the weights 2 f (y − d).
#[test]
fn readings_beside_observations() {
    let plate = Plate::new();
    let measured = [[0.2], [0.35]];
    let observations = POINTS
        .iter()
        .zip(&measured)
        .fold(Observations::new(&plate.space), |all, (x, d)| all.at_point(x, d, 1.5).unwrap());
    let mut observed = CriterionMap::new(plate.creep().observed(STEPS - 1, observations));
    let mut map =
        ReadingsMap::new(plate.creep()).unwrap().output("end", STEPS - 1, plate.readings()).unwrap();
    let m = map.start();
    let read = map.value(&m).unwrap();
    let apart: Vec<f64> = read.iter().zip(&measured).map(|(y, d)| y - d[0]).collect();
    let value = observed.value(&m).unwrap();
    near("value", &value, &[apart.iter().map(|apart| 1.5 * apart * apart).sum::<f64>()], 1e-12);
    let weights: Vec<f64> = apart.iter().map(|apart| 3.0 * apart).collect();
    near("gradient", &observed.vjp(&m, &[1.0]).unwrap(), &map.vjp(&m, &weights).unwrap(), 1e-10);
    // One output: the product with a direction is that of the gradient.
    let along = observed.jvp(&m, &m).unwrap();
    near("slope", &along, &[dot(&observed.vjp(&m, &[1.0]).unwrap(), &m)], 1e-15);
    assert_eq!(observed.outputs(), [Part::new("criterion", 1)]);
    assert_eq!(observed.inputs(), [Part::new("conductivity", 9), Part::new("source", STEPS)]);
}

#[test]
fn what_does_not_fit_is_named() {
    let plate = Plate::new();
    let own = plate.creep().observed(0, Observations::new(&plate.space));
    let said = ReadingsMap::new(own).err().unwrap().to_string();
    assert!(said.contains("a criterion of its own"), "{said}");
    let late = ReadingsMap::new(plate.creep()).unwrap().output("late", STEPS, plate.readings());
    let said = late.err().unwrap().to_string();
    assert!(said.contains("observed at step 6, and the last step is 5"), "{said}");
    let elsewhere = Readings::new(&Space::scalar(plate.space.mesh(), 1).unwrap()).at_nodes();
    let said = ReadingsMap::new(plate.creep()).unwrap().output("other", 0, elsewhere).err().unwrap();
    assert!(said.to_string().contains("another space"), "{said}");
    assert!(Readings::new(&plate.space).at_point(&[2.0, 0.0]).is_err());
    // A history without a criterion has readings, and no value.
    let said = plate.creep().value(&plate.creep().start()).unwrap_err().to_string();
    assert!(said.contains("the history has no criterion"), "{said}");

    let mut map = plate.map(plate.creep());
    let mut m = map.start();
    let said = map.value(&m[1..]).unwrap_err().to_string();
    assert_eq!(
        said,
        "the vector of controls has 14 values; the map has 15: `conductivity` (9), `source` (6)"
    );
    assert!(matches!(map.vjp(&m, &[1.0]), Err(MapError::Length { vector: "cotangent", found: 1, .. })));
    assert!(matches!(map.jvp(&m, &m[2..]), Err(MapError::Length { vector: "direction", expected: 15, .. })));
    m[10] = f64::INFINITY;
    let said = map.value(&m).unwrap_err().to_string();
    assert_eq!(said, "the value inf of `source` in the vector of controls is not finite (its number 1)");
}
