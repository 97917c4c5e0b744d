//! Proximal Galerkin: the membrane over an obstacle in closed form, a pressed layer, and ways to fail.

use std::f64::consts::PI;

use forms_contact::laws::proximal_bodies::proximal_bodies as bodies;
use forms_contact::laws::proximal_membrane::proximal_membrane as membrane;
use forms_contact::laws::proximal_obstacle::proximal_obstacle as signorini;
use forms_contact::proximal::{
    Proximal, ProximalError, ProximalOptions, ProximalSolution, solve_by_proximal_points,
};
use forms_fem::mesh::disc;
use forms_fem::prelude::*;
use forms_fem::solve::SolveError;

/// The contact radius, the slope A of u = A ln r outside of it, and ½ ∫ |∇u|².
const RADIUS: f64 = 0.348_982_574_111_686;
const SLOPE: f64 = -0.340_129_705_945_858;
const ENERGY: f64 = 0.453_542_954_841;

/// A half circle up to r = 0.45, and its tangent cone beyond.
fn obstacle(x: &[f64; 2]) -> f64 {
    let r = x[0].hypot(x[1]);
    let top = |r: f64| (0.25 - r * r).sqrt();
    if r <= 0.45 { top(r) } else { top(0.45) - 0.45 / top(0.45) * (r - 0.45) }
}

fn exact(x: &[f64; 2]) -> f64 {
    let r = x[0].hypot(x[1]);
    if r <= RADIUS { obstacle(x) } else { SLOPE * r.ln() }
}

fn exact_slope(x: &[f64; 2]) -> [f64; 2] {
    let r = x[0].hypot(x[1]);
    let part = if r <= RADIUS { -1.0 / (0.25 - r * r).sqrt() } else { SLOPE / (r * r) };
    [part * x[0], part * x[1]]
}

struct Membrane {
    spaces: [Arc<Space<2>>; 2],
    assembler: Assembler<2>,
}

impl Membrane {
    /// A quarter of the unit disc, u of degree 2 and ψ of degree 0 cell by cell.
    fn new(core: usize) -> Self {
        let mesh = disc(1.0, [true; 2], core, core, CellShape::Quadrilateral, 2).unwrap();
        let latent = Space::of(&mesh, Elements::Lagrange(0), Scope::Cell, &[]).unwrap();
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(8));
        Membrane { spaces: [Space::scalar(&mesh, 2).unwrap(), latent], assembler }
    }

    fn solve(&self, options: ProximalOptions) -> Result<ProximalSolution<2>, ProximalError> {
        let [displacements, latents] = &self.spaces;
        let mut held = Constraints::new(displacements);
        held.fix("circle", |_| 0.0).unwrap();
        let solve = |step: Proximal<'_, 2>| -> Result<_, SolveError> {
            let law = membrane::Model::new(membrane::data().obstacle(obstacle).alpha(step.alpha));
            let problem = step.problem(&law, &law.direct(step.latent()), [displacements, latents])?;
            problem.constrained(&held).assembler(&self.assembler).solve()
        };
        let start = self.spaces.each_ref().map(Field::zero);
        solve_by_proximal_points(start, options, solve, |_| ())
    }
}

#[test]
fn a_membrane_converges_to_its_closed_form_in_as_many_iterations_on_all_meshes() {
    let mut errors = vec![];
    for core in [4, 8, 16] {
        let membrane = Membrane::new(core);
        let found = membrane.solve(ProximalOptions::default()).unwrap();
        let u = &found.solved.fields[0];
        let norms = norms::errors(
            &membrane.assembler,
            u,
            |x, value| value[0] = exact(x),
            |x, slope| slope.copy_from_slice(&exact_slope(x)),
        )
        .unwrap();
        let law = membrane::Model::new(membrane::data().obstacle(obstacle).alpha(1.0));
        let energy = 4.0 * membrane.assembler.functional(&law.energy(u)).unwrap();
        let force = 4.0 * norms::mean(&membrane.assembler, &found.multiplier).unwrap()[0] * PI / 4.0;
        println!("{core}: {}, energy {energy:.6}, force {force:.6}", found.history);
        let inner: Vec<usize> = found.history.steps.iter().map(|step| step.newton_steps).collect();
        assert!((6..=9).contains(&inner.len()) && found.history.newton_steps() <= 40, "{inner:?}");
        errors.push((norms.h1, (energy - ENERGY).abs(), (force + 2.0 * PI * SLOPE).abs()));
    }
    for pair in errors.windows(2) {
        let order = (pair[0].0 / pair[1].0).log2();
        assert!(order > 1.3, "{order}");
    }
    let (_, energy, force) = errors[2];
    assert!(energy < 5e-5 && force < 1e-3, "{energy:e} {force:e}");
}

#[test]
fn a_layer_has_the_pressure_of_its_modulus() {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Quadrilateral, 1).unwrap();
    for degree in [1, 2] {
        let displacements = Space::vector(&mesh, degree).unwrap();
        let latents = Space::on_facets(&mesh, "bottom", degree).unwrap();
        let mut held = Constraints::new(&displacements);
        held.fix_component("left", 0, |_| 0.0).unwrap();
        held.fix_component("right", 0, |_| 0.0).unwrap();
        held.fix("top", |_| [0.0, -0.02]).unwrap();
        let (lambda, mu, gap) = (1.5, 1.0, 0.005);
        let solve = |step: Proximal<'_, 2>| -> Result<_, SolveError> {
            let data = signorini::data()
                .lambda(lambda)
                .mu(mu)
                .obstacle_normal([0.0, -1.0])
                .gap(gap)
                .alpha(step.alpha);
            let regions = signorini::Regions::default().gamma_c("bottom").gamma_n("top");
            let law = signorini::Model { data, regions };
            let problem = step.problem(&law, &law.direct(step.latent()), [&displacements, &latents])?;
            problem.constrained(&held).solve()
        };
        let start = [Field::zero(&displacements), Field::zero(&latents)];
        let options =
            ProximalOptions { first_step: 10.0, growth: 2.0, tolerance: 1e-12, ..Default::default() };
        let found = solve_by_proximal_points(start, options, solve, |_| ()).unwrap();
        let pressure = (lambda + 2.0 * mu) * (0.02 - gap);
        for value in found.multiplier.values() {
            assert!((value / pressure - 1.0).abs() < 1e-8, "{value}, {pressure}, {}", found.history);
        }
    }
}

/// A square on a square, on unlike meshes with a small gap: a uniform pressure, and forces that balance.
#[test]
fn two_bodies_have_a_uniform_pressure() {
    let gap = 0.01;
    let lower = rectangle([0.0; 2], [1.0; 2], [7, 5], CellShape::Quadrilateral, 1).unwrap();
    let upper = rectangle([0.0, 1.0 + gap], [1.0, 2.0 + gap], [5, 4], CellShape::Quadrilateral, 1).unwrap();
    let mesh = Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)]).unwrap();
    let (lambda, mu, way) = (1.5, 1.0, 0.03);
    for degree in [1, 2] {
        let displacements = Space::vector(&mesh, degree).unwrap();
        let latents = Space::on_facets(&mesh, "lower top", degree).unwrap();
        let mut held = Constraints::new(&displacements);
        for side in ["lower left", "lower right", "upper left", "upper right"] {
            held.fix_component(side, 0, |_| 0.0).unwrap();
        }
        held.fix_component("lower bottom", 1, |_| 0.0).unwrap();
        held.fix_component("upper top", 1, |_| -way).unwrap();
        let solve = |step: Proximal<'_, 2>| -> Result<_, SolveError> {
            let data = bodies::data().lambda(lambda).mu(mu).alpha(step.alpha);
            let touch = Pairing::onto("lower top", "upper bottom");
            let law =
                bodies::Model { data, regions: bodies::Regions::default().touch(touch).gamma_n("upper top") };
            let problem = step.problem(&law, &law.direct(step.latent()), [&displacements, &latents])?;
            problem.constrained(&held).solve()
        };
        let start = [Field::zero(&displacements), Field::zero(&latents)];
        let options =
            ProximalOptions { first_step: 10.0, growth: 2.0, tolerance: 1e-12, ..Default::default() };
        let found = solve_by_proximal_points(start, options, solve, |_| ()).unwrap();
        let pressure = (lambda + 2.0 * mu) * (way - gap) / 2.0;
        for value in found.multiplier.values() {
            assert!((value / pressure - 1.0).abs() < 1e-8, "{value}, {pressure}, {}", found.history);
        }
    }
}

#[test]
fn what_cannot_be_done_is_said() {
    let membrane = Membrane::new(2);
    let error = membrane.solve(ProximalOptions { first_step: -1.0, ..Default::default() }).unwrap_err();
    assert!(error.to_string().contains("a positive first step"), "{error}");
    let error = membrane.solve(ProximalOptions { max_iterations: 2, ..Default::default() }).unwrap_err();
    assert!(
        matches!(&error, ProximalError::NotConverged { history, .. } if history.steps.len() == 2),
        "{error}"
    );
}
