//! Random starts, loads and parameters: each run converges to a state that an independent look finds in order, or says why it
//! does not. Ten runs per law; FORMS_SWEEPS=1: 200. (`contact_heat` is one linear system without a start: `heat`.)

mod bodies;
mod heat;
mod layers;
mod obstacles;

use std::fmt::Debug;

use forms_contact::laws::augmented_lagrangian;
use forms_contact::laws::finite_nitsche;
use forms_contact::laws::frictional_nitsche;
use forms_contact::laws::frictional_penalty;
use forms_contact::{ContactProblem, law::ContactLaw};
use forms_fem::contract::Expression;
use forms_fem::prelude::*;

use crate::block::{Block, plane_block};
use crate::setting::{Friction, THETAS, YOUNG, data};

/// Numbers between −1 and 1, the same in each run of the test.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        // Knuth's linear congruential generator.
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() + 1.0) / 2.0
    }

    fn start(&mut self, space: &Arc<Space<2>>, size: f64) -> Field<2> {
        let values = (0..space.unknowns()).map(|_| size * self.next()).collect();
        Field::from_values(space, values).unwrap()
    }
}

fn runs() -> usize {
    if std::env::var_os("FORMS_SWEEPS").is_some() { 200 } else { 10 }
}

/// The parameters of a run.
#[derive(Debug)]
struct Case {
    friction: Friction,
    theta: f64,
    gamma0: f64,
    aside: f64,
    down: f64,
    force: [f64; 2],
}

/// Cells along each side of the block.
const CELLS: usize = 4;

impl Case {
    /// γ = γ₀/h; cells are halves of squares or whole ones, with a diameter above their side.
    fn augmentation(&self) -> f64 {
        self.gamma0 * CELLS as f64
    }
}

fn case(random: &mut Random) -> Case {
    let friction = match random.next() > 0.0 {
        true => Friction::Coulomb(random.between(0.0, 0.8)),
        false => Friction::Tresca(random.between(0.0, 2.0)),
    };
    let theta = THETAS[(random.between(0.0, 2.999)) as usize];
    Case {
        friction,
        theta,
        gamma0: random.between(20.0, 60.0) * YOUNG,
        aside: random.between(-0.02, 0.02),
        down: random.between(-0.002, 0.02),
        force: [random.next(), random.next()],
    }
}

fn data_of(case: &Case) -> frictional_nitsche::Data<2> {
    let mut data = data::<2>(case.friction, case.theta, case.gamma0);
    data.body_force = Given::constant(case.force);
    data
}

/// The bound of friction at a pressure.
fn bound(friction: Friction, pressure: f64) -> f64 {
    match friction {
        Friction::Tresca(bound) => bound,
        Friction::Coulomb(coefficient) => coefficient * pressure,
    }
}

/// Solves from the start. `traction` is that on the body, `normal` points into the obstacle, `augmentation` is γ. The solution,
/// if it converged.
fn check<L>(
    problem: &ContactProblem<2, L>,
    start: &Field<2>,
    friction: Friction,
    augmentation: f64,
    label: &dyn Debug,
    traction: impl Fn(&L, &Field<2>) -> Expression<2>,
    normal: impl Fn(&L, &Field<2>) -> Expression<2>,
) -> Option<Field<2>>
where
    L: ContactLaw<2>,
{
    // The start is noise: its residual is a hundred times the forces of the solution, and the result is judged relative to these.
    let options = NewtonOptions {
        relative_tolerance: 1e-12,
        line_search: LineSearch::OnResidual,
        ..NewtonOptions::default()
    };
    let u = match problem.direct().unwrap().start(start).options(options).solve() {
        Ok(solved) => solved.into_field(),
        Err(error) => {
            // It says at which iteration and why.
            let text = error.to_string();
            assert!(text.contains("failed at iteration") && text.len() > 40, "{label:?}: {text}");
            println!("{label:?}: {}", text.lines().next().unwrap_or_default());
            return None;
        }
    };
    assert!(u.values().iter().all(|value| value.is_finite()), "{label:?}");
    // The residual again, relative to the forces on the support.
    let residual = problem.assembler.residual(&problem.law.direct(), &[&u], &[&problem.space]).unwrap();
    let largest = residual.iter().fold(0.0_f64, |most, r| most.max(r.abs()));
    for free in problem.constraints.free() {
        // Where nothing touches and nothing pulls there is rounding of stresses that cancel.
        let most = 1e-8 * largest + f64::EPSILON * YOUNG;
        assert!(residual[free].abs() <= most, "{label:?}: {} of {largest}", residual[free]);
    }
    let along = |sample: &[f64]| [sample[0], sample[1]];
    let forces = problem.assembler.along_facets_uniformly(&traction(&problem.law, &u), "bottom", 5).unwrap();
    let normals = problem.assembler.along_facets_uniformly(&normal(&problem.law, &u), "bottom", 5).unwrap();
    for (force, normal) in forces.iter().zip(&normals) {
        let (t, m) = (along(&force.value), along(&normal.value));
        let pressure = -(t[0] * m[0] + t[1] * m[1]);
        let tangential = ((t[0] + pressure * m[0]).powi(2) + (t[1] + pressure * m[1]).powi(2)).sqrt();
        // The normal part of γ g is taken away from the tangential one, up to its rounding: g is below 1 everywhere, and the
        // body's own stresses are of the size 1.
        let rounding = 4.0 * f64::EPSILON * (augmentation + 1.0);
        let scale = largest.max(pressure.abs());
        assert!(pressure >= -1e-12 * scale - rounding, "{label:?}: it pulls by {pressure}");
        let most = bound(friction, pressure.max(0.0));
        assert!(
            tangential <= most + 1e-10 * scale + rounding,
            "{label:?}: friction {tangential} above {most}"
        );
    }
    Some(u)
}

/// Runs all cases of a law and counts those that converge: nine of ten at least.
fn all(seed: u64, mut run: impl FnMut(&mut Random) -> bool) {
    let mut random = Random(seed);
    let converged = (0..runs()).filter(|_| run(&mut random)).count();
    println!("{converged} of {} converge", runs());
    assert!(10 * converged >= 9 * runs(), "{converged} of {} converge", runs());
}

fn block() -> Block<2> {
    plane_block(CELLS)
}

/// Tresca's problem has one solution for γ₀ above the threshold: all starts lead there.
#[test]
fn nitsches_method() {
    let block = block();
    all(1, |random| {
        let case = case(random);
        let regions = frictional_nitsche::Regions::default().gamma_n("right").gamma_c("bottom");
        let law = frictional_nitsche::Model { data: data_of(&case), regions };
        let problem = block.problem(law, case.aside, case.down);
        let starts = [random.start(&block.space, 0.02), random.start(&block.space, 0.02)];
        let found = starts.each_ref().map(|start| {
            check(
                &problem,
                start,
                case.friction,
                case.augmentation(),
                &case,
                |law, u| law.obstacle_traction(u),
                |_, u| flat(u),
            )
        });
        if let ([Some(a), Some(b)], Friction::Tresca(_)) = (&found, case.friction) {
            let apart = a.values().iter().zip(b.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-9, "{case:?}: two solutions, {apart:.1e} apart");
        }
        found.iter().all(Option::is_some)
    });
}

#[forms(dimension = 2)]
mod flat_normal {
    /// n_y of the flat below.
    pub fn downwards(u: Vector) -> Vector {
        0 * u + [0, -1]
    }
}

fn flat(u: &Field<2>) -> Expression<2> {
    flat_normal::downwards(u)
}

#[test]
fn penalty() {
    let block = block();
    all(2, |random| {
        let case = case(random);
        let regions = frictional_penalty::Regions::default().gamma_n("right").gamma_c("bottom");
        let law = frictional_penalty::Model { data: data_of(&case), regions };
        let problem = block.problem(law, case.aside, case.down);
        let start = random.start(&block.space, 0.02);
        let traction = |law: &frictional_penalty::Model<2>, u: &Field<2>| law.obstacle_traction(u);
        check(&problem, &start, case.friction, case.augmentation(), &case, traction, |_, u| flat(u)).is_some()
    });
}

#[test]
fn finite_strains() {
    let block = block();
    all(3, |random| {
        let case = case(random);
        let regions = finite_nitsche::Regions::default().gamma_n("right").gamma_c("bottom");
        let law = finite_nitsche::Model { data: data_of(&case), regions };
        // Larger loads than those of small strains.
        let problem = block.problem(law, 5.0 * case.aside, 5.0 * case.down);
        let start = random.start(&block.space, 0.02);
        let traction = |law: &finite_nitsche::Model<2>, u: &Field<2>| law.obstacle_traction(u);
        check(&problem, &start, case.friction, case.augmentation(), &case, traction, |_, u| flat(u)).is_some()
    });
}

/// The multiplier is T(λ) in the mean over each facet; and so it presses, and is within the bound of friction.
#[test]
fn augmented_lagrangian_method() {
    let block = block();
    let multipliers = Space::discontinuous_vector_on_facets(&block.mesh, "bottom", 0).unwrap();
    all(5, |random| {
        let case = case(random);
        let mut constraints = Constraints::new(&block.space);
        constraints.fix("top", |_| [case.aside, -case.down]).unwrap();
        let regions = augmented_lagrangian::Regions::default().gamma_n("right").gamma_c("bottom");
        let model = augmented_lagrangian::Model { data: data_of(&case), regions };
        let form = model.direct();
        let starts = [random.start(&block.space, 0.02), random.start(&multipliers, 5.0)];
        let options = NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
        let assembler = Assembler::new(&block.mesh).with_quadrature(Quadrature::Degree(4));
        let solved = Problem::new(&form, [&block.space, &multipliers])
            .assembler(&assembler)
            .constrained(&constraints)
            .options(options)
            .start(starts.each_ref())
            .solve();
        let [u, multiplier] = match solved {
            Ok(solved) => solved.fields,
            Err(error) => {
                let text = error.to_string();
                assert!(text.contains("failed at iteration"), "{case:?}: {text}");
                println!("{case:?}: {}", text.lines().next().unwrap_or_default());
                return false;
            }
        };
        let update = model.update(&multiplier, &u);
        let samples = assembler.along_facets_uniformly(&update, "bottom", 5).unwrap();
        let largest = multiplier.values().iter().fold(1e-3_f64, |most, value| most.max(value.abs()));
        for value in multiplier.values().chunks(2) {
            assert!(value[1] >= -1e-8 * largest, "{case:?}: it pulls by {value:?}");
            let most = bound(case.friction, value[1].max(0.0));
            assert!(value[0].abs() <= most + 1e-8 * largest, "{case:?}: friction {value:?} above {most}");
        }
        assert!(samples.iter().all(|sample| sample.value[1] >= -1e-12 * largest), "{case:?}");
        true
    });
}
