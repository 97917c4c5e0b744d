//! The gradient of a history of sliding steps with friction on moving segments: transposed tangents move the points.

use forms_fem::contract::PairQuadrature;
use forms_fem::inverse::{ControlError, ControlValues, Controls, LoadHistory, ReducedProblem};
use forms_fem::prelude::*;
use forms_fem::solve::{Elimination, TangentSolver, solve_linear};

#[forms]
mod drawn {
    use forms_contact::laws::mean_sliding_bodies::direct as of_facets;
    use forms_contact::laws::sliding_bodies::direct as at_points;
    pub use forms_contact::laws::sliding_bodies::{GammaN, Omega, Touch, first_piola, loads};

    #[includes(forms_contact::laws::two_bodies::Data)]
    pub struct Data {
        /// 1 of means over own facets, 0 at points.
        averaged: Param,
    }

    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        (1 - averaged) * at_points(u, v) + averaged * of_facets(u, v)
    }
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
            + derivative((1 - averaged) * at_points(u, p), friction, this(by_friction))
            + derivative(work + criterion(u), mu, by_shear_modulus)
    }
    /// The change of a step's balance as data change, at a fixed displacement.
    pub fn changes(
        u: State<Vector>,
        before: State<Vector>,
        of_friction: State<Scalar>,
        of_modulus: State<Scalar>,
        v: Test<Vector>,
    ) -> Form {
        let work = direct(u, v);
        derivative(work, displacement_before, before)
            + derivative((1 - averaged) * at_points(u, v), friction, this(of_friction))
            + derivative(work, mu, of_modulus)
    }
    pub fn slope(u: State<Vector>, v: Test<Vector>) -> Form {
        derivative(criterion(u), u, v)
    }
}

struct Bodies<const D: usize> {
    space: Arc<Space<D>>,
    materials: Arc<Space<D>>,
    assembler: Assembler<D>,
    steps: usize,
    /// 1 of means over own facets, 0 at points.
    averaged: f64,
}

/// Slopes of the criterion along a direction.
struct Slopes {
    /// By the gradient of adjoint states.
    adjoint: f64,
    /// By the states' derivatives, step after step.
    forward: f64,
    /// By differences of fourth order.
    difference: f64,
}

impl<const D: usize> Bodies<D>
where
    Dim: Dimension<D>,
{
    fn new(slab: &Mesh<D>, block: &Mesh<D>, degree: usize, steps: usize) -> Self {
        let mesh = Mesh::of_bodies(&[("slab", slab), ("block", block)]).unwrap();
        let space = Space::vector(&mesh, degree).unwrap();
        let materials = Space::discontinuous_scalar(&mesh, 0).unwrap();
        Bodies { assembler: Assembler::new(&mesh), space, materials, steps, averaged: 0.0 }
    }

    fn model(&self, (friction, modulus): (f64, Field<D>), before: Given<[f64; D], D>) -> drawn::Model<D> {
        let data = drawn::data()
            .lambda(15.0)
            .mu(modulus)
            .gamma0(300.0)
            .averaged(self.averaged)
            .friction(friction)
            .displacement_before(before)
            .criterion_force(|x: &[f64; D]| {
                std::array::from_fn(|k| if k == 0 { 0.3 + x[0] } else { 0.5 * x[k] })
            });
        let touch = Pairing::between("slab top", "block bottom").at(PairQuadrature::Pieces);
        let regions = drawn::Regions::default().touch(touch).gamma_n("block right");
        drawn::Model { data, regions }
    }

    fn modulus(&self) -> Field<D> {
        Field::interpolate(&self.materials, |x| 10.0 + 2.0 * x[0].sin() * x[1]).unwrap()
    }

    fn held(&self, step: usize) -> Constraints<D> {
        let mut by = [0.0; D];
        (by[0], by[D - 1]) = (0.11 * (step + 1) as f64, -0.07);
        let mut held = Constraints::new(&self.space);
        held.fix("slab bottom", |_| [0.0; D]).unwrap();
        held.fix("block top", |_| by).unwrap();
        held
    }

    fn history(&self) -> LoadHistory<'_, D> {
        let modulus = self.modulus();
        let controls = Controls::new().number("friction", 0.3).field("shear_modulus", &modulus);
        let controls_of = |at: &ControlValues<D>| -> Result<(f64, Field<D>), ControlError> {
            Ok((at.number("friction")?, at.field("shear_modulus")?))
        };
        let options = NewtonOptions {
            relative_tolerance: 1e-12,
            line_search: LineSearch::OnResidual,
            ..NewtonOptions::default()
        };
        LoadHistory::new(&self.space, self.steps, controls)
            .step(move |at| Ok(self.model(controls_of(at)?, Given::field(at.before()?)).direct()))
            .sensitivities(move |at, u, p| {
                Ok(self.model(controls_of(at)?, Given::field(at.before()?)).sensitivities(u, p))
            })
            .criterion(move |at| Ok(self.model(controls_of(at)?, Given::constant([0.0; D])).criterion()))
            .assembler(&self.assembler)
            .constrained_at(move |step| Ok(self.held(step)))
            .options(options)
    }

    fn slopes(&self, h: f64) -> Slopes {
        let mut history = self.history();
        let m = history.start();
        let mut direction: Vec<f64> =
            (0..m.len()).map(|k| 0.1 + 0.05 * (1.0 + 1.7 * k as f64).sin()).collect();
        // Means have no derivative by a coefficient of friction that is a field.
        direction[0] *= 1.0 - self.averaged;
        let states = history.states(&m).unwrap();
        let touch = Pairing::between("slab top", "block bottom").at(PairQuadrature::Pieces);
        for u in &states {
            let report = self.assembler.pairs_at(&touch, 3, u).unwrap();
            assert!(report.deepest_overlap > 1e-4 && report.paired_measure < 0.9 * report.measure);
        }
        let product = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let adjoint = product(&history.gradient(&m).unwrap().gradient, &direction);
        let of_friction = Field::interpolate(&self.materials, |_| direction[0]).unwrap();
        let of_modulus = Field::from_values(&self.materials, direction[1..].to_vec()).unwrap();
        let mut before = Field::zero(&self.space);
        let mut change = Field::zero(&self.space);
        let mut forward = 0.0;
        for (step, u) in states.iter().enumerate() {
            let model = self.model((0.3, self.modulus()), Given::field(&before));
            let changes = model.changes(u, &change, &of_friction, &of_modulus);
            let load = self.assembler.residual(&changes, &[], &[&self.space]).unwrap();
            let load: Vec<f64> = load.iter().map(|load| -load).collect();
            let tangent = self.assembler.tangent(&model.direct(), &[u], &[&self.space]).unwrap();
            let mut elimination = Elimination::of(&[&self.held(step).homogeneous()]).unwrap();
            let solver = &mut TangentSolver::default();
            let found = solve_linear(&tangent.into(), &load, &mut elimination, solver).unwrap();
            change = Field::from_values(&self.space, found.solution).unwrap();
            before = u.clone();
            let slope = self.assembler.residual(&model.slope(u), &[], &[&self.space]).unwrap();
            forward += product(&slope, change.values());
        }
        let mut at = |t: f64| {
            let moved: Vec<f64> = m.iter().zip(&direction).map(|(m, along)| m + t * along).collect();
            history.sample(&moved).unwrap().value[0]
        };
        let [a, b, c, d] = [h, -h, 2.0 * h, -2.0 * h].map(&mut at);
        Slopes { adjoint, forward, difference: (8.0 * (a - b) - (c - d)) / (12.0 * h) }
    }
}

/// 20 steps over six facets of the slab: the gradient is that of differences of fourth order.
#[test]
fn gradients_of_sliding_histories_are_those_of_differences() {
    let slab = rectangle([0.0; 2], [4.0, 0.6], [14, 2], CellShape::Quadrilateral, 1).unwrap();
    let block = rectangle([0.3, 0.62], [1.3, 1.22], [4, 2], CellShape::Quadrilateral, 1).unwrap();
    let mut bodies = Bodies::<2>::new(&slab, &block, 1, 20);
    for averaged in [0.0, 1.0] {
        bodies.averaged = averaged;
        check(&format!("2D, {averaged}"), &bodies.slopes(2e-5), 1e-7);
    }
}

/// The same in space, in fewer steps over nodes and edges. With steps below 10⁻⁴ the rounding of differences is above 10⁻⁸, above 10⁻³ points
/// change between sticking and sliding.
#[test]
fn gradients_in_space_are_those_of_differences() {
    for (shape, degree, step) in [
        (CellShape::Tetrahedron, 1, 1e-3),
        (CellShape::Hexahedron, 1, 3e-4),
        (CellShape::Tetrahedron, 2, 1e-4),
    ] {
        let slab = cuboid([0.0; 3], [2.0, 1.2, 0.6], [6, 4, 1], shape, 1).unwrap();
        let block = cuboid([0.23, 0.17, 0.62], [0.93, 0.87, 1.22], [3, 2, 1], shape, 1).unwrap();
        let bodies = Bodies::<3>::new(&slab, &block, degree, 4);
        check(&format!("{shape:?} {degree}"), &bodies.slopes(step), 1e-8);
    }
}

fn check(name: &str, slopes: &Slopes, bound: f64) {
    let [forward, difference] =
        [slopes.forward, slopes.difference].map(|slope| (slope / slopes.adjoint - 1.0).abs());
    println!("{name}: {:.12e}, forward {forward:.1e}, differences {difference:.1e}", slopes.adjoint);
    assert!(forward < 1e-11 && difference < bound, "{name}: {forward:e} {difference:e}");
}
