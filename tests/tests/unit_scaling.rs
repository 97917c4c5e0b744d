//! Units: each field measured in units of 10⁻¹², 1 and 10¹², with the data that carry its unit. Answers are the same to nine
//! digits, by every solver that fits. Conjugate gradients, MINRES and multigrid take symmetric matrices of one space; units and
//! contrasts of theirs are tested next to the solvers (`fem/problem/src/solve/contrasts.rs`).

use forms_contact::ContactProblem;
use forms_contact::hollow_cylinder::{IMPOSED_DISPLACEMENT, OBSTACLE_DEPTH, Settings, hollow_cylinder};
use forms_fem::prelude::*;
use forms_fem::solve::LuSolver;

/// Largest difference of two fields relative to the largest value.
const SAME: f64 = 1e-9;

const UNITS: [f64; 3] = [1e-12, 1.0, 1e12];

type Solvers = Vec<(&'static str, Box<dyn LinearSolver>)>;

fn solvers() -> Solvers {
    vec![
        ("TangentSolver", Box::new(TangentSolver::default())),
        ("LuSolver", Box::new(LuSolver::default())),
        ("CondensedSolver", Box::new(CondensedSolver::default())),
    ]
}

/// All pairs of units.
fn pairs() -> impl Iterator<Item = (f64, f64)> {
    UNITS.into_iter().flat_map(|one| UNITS.map(|other| (one, other)))
}

/// Solutions in several units and by several solvers compared with the first one, field by field; all that differ are reported.
#[derive(Default)]
struct Table {
    expected: Option<Vec<Vec<f64>>>,
    differences: Vec<String>,
}

impl Table {
    /// Fields and their units, or the reason why there are none.
    fn enter(&mut self, label: String, found: Result<Vec<(Vec<f64>, f64)>, String>) {
        let fields: Vec<Vec<f64>> = match found {
            Ok(found) => {
                let back =
                    |(values, unit): (Vec<f64>, f64)| values.iter().map(|value| value / unit).collect();
                found.into_iter().map(back).collect()
            }
            Err(why) => return self.differences.push(format!("{label}: {why}")),
        };
        let Some(expected) = &self.expected else {
            self.expected = Some(fields);
            return;
        };
        for (number, (field, expected)) in fields.iter().zip(expected).enumerate() {
            let largest = expected.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
            let off = field.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest;
            if off.is_nan() || off > SAME {
                self.differences.push(format!("{label}: field {number} is off by {off:.1e}"));
            }
        }
    }

    fn check(self) {
        assert!(self.differences.is_empty(), "{}", self.differences.join("\n"));
    }
}

/// The cylinder on a coarse mesh; displacements and the gap in one unit, stresses in another.
fn cylinder(theta: f64, length: f64, stress: f64) -> ContactProblem<2> {
    let settings = Settings { radial: 2, theta, ..Settings::default() };
    let mut problem = hollow_cylinder(&settings).unwrap();
    let mut constraints = Constraints::new(&problem.space);
    constraints.fix("inner", |_| IMPOSED_DISPLACEMENT.map(|value| length * value)).unwrap();
    problem.constraints = constraints;
    problem.law.data.lambda *= stress;
    problem.law.data.mu *= stress;
    problem.law.data.gamma0 *= stress;
    problem.law.data.gap = Given::function_with_gradient(
        move |x: &[f64; 2]| length * (x[1] + OBSTACLE_DEPTH),
        move |_| [0.0, length],
    );
    problem
}

#[test]
fn the_cylinder_in_contact() {
    for theta in [-1.0, 1.0] {
        let mut table = Table::default();
        for (length, stress) in [(1.0, 1.0)].into_iter().chain(pairs()) {
            for (name, mut solver) in solvers() {
                let problem = cylinder(theta, length, stress);
                let solved = problem.direct().unwrap().solver(&mut *solver).solve();
                let found = solved.map(|solved| vec![(solved.into_field().values().to_vec(), length)]);
                let label = format!("θ = {theta}, length {length:e}, stress {stress:e}, {name}");
                table.enter(label, found.map_err(|error| error.to_string()));
            }
        }
        table.check();
    }
}

#[forms(dimension = 2)]
mod pipe {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        pub expansion: Param,
        pub conductivity: Param,
        pub source: Param,
    }

    #[cells]
    pub struct Omega;

    fn stress(w: Vector, T: Scalar) -> Tensor {
        2 * mu * eps(w) + (lambda * tr(eps(w)) - (3 * lambda + 2 * mu) * expansion * T) * I
    }

    pub fn balance(u: Unknown<Vector>, T: Unknown<Scalar>, v: Test<Vector>, s: Test<Scalar>) -> Form {
        integral(Omega, inner(stress(u, T), eps(v)) + conductivity * dot(grad(T), grad(s)) - source * s)
    }
}

/// Tutorial 10's pipe, a quarter of it. Hot inside, and heated in its wall.
#[test]
fn a_hot_pipe() {
    let quarter = |[s, t]: [f64; 2]| {
        let (radius, angle) = (20.0 + 10.0 * t, std::f64::consts::FRAC_PI_2 * (1.0 - s));
        [radius * angle.cos(), radius * angle.sin()]
    };
    let mesh = forms_fem::mesh::structured([6, 3], CellShape::Quadrilateral, 2, quarter).unwrap();
    let (displacements, temperatures) = (Space::vector(&mesh, 2).unwrap(), Space::scalar(&mesh, 2).unwrap());
    let mut held = Constraints::new(&displacements);
    held.fix_component("left", 0, |_| 0.0).unwrap();
    held.fix_component("right", 1, |_| 0.0).unwrap();
    let assembler = Assembler::new(&mesh);
    let mut table = Table::default();
    // From all fields at zero, and from the temperature at zero where nothing is prescribed: the body has no load then.
    for prescribed in [100.0, 0.0] {
        table.expected = None;
        for (length, degree) in [(1.0, 1.0)].into_iter().chain(pairs()) {
            let mut heated = Constraints::new(&temperatures);
            heated.fix("bottom", |_| prescribed * degree).unwrap();
            heated.fix("top", |_| 0.0).unwrap();
            let data = pipe::data()
                .lambda(115e3)
                .mu(77e3)
                .expansion(1.2e-5 * length / degree)
                .conductivity(0.045)
                .source(0.02 * degree);
            let form = pipe::balance(&data, &pipe::Omega::on("all"));
            for (name, mut solver) in solvers() {
                let label = format!("{prescribed} K, length {length:e}, degree {degree:e}, {name}");
                let problem = Problem::new(&form, [&displacements, &temperatures]).assembler(&assembler);
                let solved = problem.constrained(&held).constrained(&heated).solver(&mut *solver).solve();
                let fields = |[u, t]: &[Field<2>; 2]| {
                    vec![(u.values().to_vec(), length), (t.values().to_vec(), degree)]
                };
                if let Ok(solved) = &solved
                    && solved.history.len() > 3
                {
                    table.differences.push(format!("{label}: {} iterates", solved.history.len()));
                }
                let found = solved.map(|solved| fields(&solved.fields)).map_err(|error| error.to_string());
                table.enter(label, found);
            }
        }
    }
    table.check();
}

#[forms(dimension = 2)]
mod fluid {
    pub struct Data {
        pub viscosity: Param,
        pub pressure: Param,
    }

    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Inlet;

    fn stress(u: Vector, p: Scalar) -> Tensor {
        2 * viscosity * eps(u) - p * I
    }

    pub fn equilibrium(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, inner(stress(u, p), eps(v)) - q * div(u)) + integral(Inlet, pressure * dot(n, v))
    }
}

/// Tutorial 6's bend.
#[test]
fn a_fluid_in_a_bend() {
    let bend = |[s, t]: [f64; 2]| {
        let (radius, angle) = (10.0 + 10.0 * t, std::f64::consts::PI * (1.0 - s));
        [radius * angle.cos(), radius * angle.sin()]
    };
    let mesh = forms_fem::mesh::structured([8, 3], CellShape::Quadrilateral, 2, bend).unwrap();
    let (velocities, pressures) = (Space::vector(&mesh, 2).unwrap(), Space::scalar(&mesh, 1).unwrap());
    let mut walls = Constraints::new(&velocities);
    for wall in ["bottom", "top"] {
        walls.fix(wall, |_| [0.0, 0.0]).unwrap();
    }
    for end in ["left", "right"] {
        walls.fix_component(end, 0, |_| 0.0).unwrap();
    }
    let level = Constraints::new(&pressures);
    let mut table = Table::default();
    for (velocity, pressure) in [(1.0, 1.0)].into_iter().chain(pairs()) {
        let data = fluid::data().viscosity(0.5 * pressure / velocity).pressure(30.0 * pressure);
        let form = fluid::equilibrium(&data, &fluid::Omega::on("all"), &fluid::Inlet::on("left"));
        for (name, mut solver) in solvers() {
            let label = format!("velocity {velocity:e}, pressure {pressure:e}, {name}");
            let problem = Problem::new(&form, [&velocities, &pressures]);
            let fields = |[u, p]: &[Field<2>; 2]| {
                vec![(u.values().to_vec(), velocity), (p.values().to_vec(), pressure)]
            };
            let solved = problem.constrained(&walls).constrained(&level).solver(&mut *solver).solve();
            let found = solved.map(|solved| fields(&solved.fields)).map_err(|error| error.to_string());
            table.enter(label, found);
        }
    }
    table.check();
}

#[forms(dimension = 2)]
mod metal {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        pub yield_stress: Param,
        pub hardening: Param,
        pub plastic: History<Tensor>,
        pub amount: History<Scalar>,
    }

    #[cells]
    pub struct Omega;

    fn trial(w: Vector) -> Tensor {
        2 * mu * (eps(w) - tr(eps(w)) / 3 * I - plastic)
    }
    fn magnitude(s: Tensor) -> Scalar {
        sqrt(inner(s, s) + tr(s) * tr(s))
    }
    fn excess(w: Vector) -> Scalar {
        magnitude(trial(w)) - sqrt(2 / 3) * (yield_stress + hardening * amount)
    }
    fn flow(w: Vector) -> Tensor {
        if excess(w) > 0 {
            excess(w) / (2 * mu + 2 / 3 * hardening) * trial(w) / magnitude(trial(w))
        } else {
            0
        }
    }
    fn stress(w: Vector) -> Tensor {
        (lambda + 2 / 3 * mu) * tr(eps(w)) * I + trial(w) - 2 * mu * flow(w)
    }
    pub fn predictor(w: Unknown<Vector>, v: Test<Vector>, u: State<Vector>) -> Form {
        let increment = eps(w - u);
        integral(Omega, inner(2 * mu * increment + lambda * tr(increment) * I, eps(v)))
    }
    pub fn equilibrium(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }
    pub fn new_plastic(w: Vector) -> Tensor {
        plastic + flow(w)
    }
    pub fn new_amount(w: Vector) -> Scalar {
        amount + sqrt(2 / 3) * magnitude(flow(w))
    }
}

/// Tutorial 5's metal: a plate whose end is pulled sideways, in four steps.
#[test]
fn a_plate_that_yields() {
    let mesh = rectangle([0.0; 2], [4.0, 1.0], [8, 2], CellShape::Triangle, 1).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let assembler = Assembler::new(&mesh);
    let pulled = |length: f64, stress: f64, solver: &mut dyn LinearSolver| -> Result<Vec<f64>, String> {
        let data = metal::data()
            .lambda(115e3 * stress / length)
            .mu(77e3 * stress / length)
            .yield_stress(250.0 * stress)
            .hardening(10e3 * stress / length)
            .plastic(assembler.history(Entity::Cells, "all", 2, [[0.0; 2]; 2]).map_err(|e| e.to_string())?)
            .amount(assembler.history(Entity::Cells, "all", 2, 0.0).map_err(|e| e.to_string())?);
        let form = metal::equilibrium(&data, &metal::Omega::on("all"));
        let mut u = Field::zero(&space);
        // Elastic, beginning to yield, and further.
        for sideways in [0.01, 0.014, 0.018, 0.022] {
            let mut constraints = Constraints::new(&space);
            constraints.fix("left", |_| [0.0, 0.0]).unwrap();
            constraints.fix_component("right", 1, |_| sideways * length).unwrap();
            let predictor = metal::predictor(&data, &metal::Omega::on("all"), &u);
            let problem = Problem::new(&predictor, &space).assembler(&assembler);
            let first = problem
                .constrained(&constraints)
                .solver(solver)
                .solve()
                .map_err(|error| error.to_string())?
                .into_field();
            let problem = Problem::new(&form, &space).assembler(&assembler);
            let solved = problem.start(&first).constrained(&constraints).solver(solver).solve();
            u = solved.map_err(|error| format!("at {sideways}: {error}"))?.into_field();
            let written = assembler.update_history(&metal::new_plastic(&data, &u), &data.plastic);
            written.map_err(|error| error.to_string())?;
            let written = assembler.update_history(&metal::new_amount(&data, &u), &data.amount);
            written.map_err(|error| error.to_string())?;
            data.plastic.commit();
            data.amount.commit();
        }
        Ok(u.values().to_vec())
    };
    let mut table = Table::default();
    for (length, stress) in [(1.0, 1.0)].into_iter().chain(pairs()) {
        for (name, mut solver) in solvers() {
            let found = pulled(length, stress, &mut *solver);
            let label = format!("length {length:e}, stress {stress:e}, {name}");
            table.enter(label, found.map(|values| vec![(values, length)]));
        }
    }
    table.check();
}
