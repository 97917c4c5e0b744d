//! Tutorial 5: plasticity. J2 plasticity with linear isotropic hardening, small strain, plane strain.
//!
//! The plastic strain and its accumulated amount are histories: values at quadrature points that a step reads and writes. The
//! return map is a function of the module. The compiler differentiates it, which gives Newton's method the consistent tangent
//! (Simo and Hughes, Computational Inelasticity, 1998, section 3.3).
//!
//! The first problem is a block under uniaxial strain ε, loaded and unloaded into reverse yielding. Its stress is known:
//! `dσ/dε` is `K + 4μ/3` in the elastic range and `K + 4μ/3 · h/(μ + h)` with h = H/3 in the plastic one. Yielding
//! begins at `ε = σ_y/(2μ)`. The second one is a clamped plate whose end is pulled sideways, step by step.
//!
//! Run it with `cargo run --release --bin 05_plasticity`.

use forms_fem::assemble::AssemblyError;
use forms_fem::output::picture::{Curve, FieldMap, LinePlot, Picture, Scale, Shown};
use forms_fem::prelude::*;

#[forms]
mod metal {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        pub yield_stress: Param,
        pub hardening: Param,
        /// Plastic strain. It is a deviator, so that in plane strain its component out of the plane is minus
        /// its trace.
        pub plastic: History<Tensor>,
        /// √(2/3) ∫ |plastic strain rate|.
        pub amount: History<Scalar>,
    }

    #[cells]
    pub struct Omega;

    /// The deviatoric stress if nothing flows: 2μ (dev ε − plastic strain), with the component −tr out of the
    /// plane.
    fn trial(w: Vector) -> Tensor {
        2 * mu * (eps(w) - tr(eps(w)) / 3 * I - plastic)
    }
    fn magnitude(s: Tensor) -> Scalar {
        sqrt(inner(s, s) + tr(s) * tr(s))
    }
    /// Distance of the trial stress from the yield surface, positive outside.
    fn excess(w: Vector) -> Scalar {
        magnitude(trial(w)) - sqrt(2 / 3) * (yield_stress + hardening * amount)
    }
    /// The return map: the increment of plastic strain that puts the stress back on the surface.
    fn flow(w: Vector) -> Tensor {
        if excess(w) > 0 {
            excess(w) / (2 * mu + 2 / 3 * hardening) * trial(w) / magnitude(trial(w))
        } else {
            0
        }
    }
    pub fn stress(w: Vector) -> Tensor {
        (lambda + 2 / 3 * mu) * tr(eps(w)) * I + trial(w) - 2 * mu * flow(w)
    }
    /// A step begins with the increment that would leave all points elastic.
    pub fn predictor(w: Unknown<Vector>, v: Test<Vector>, u: State<Vector>) -> Form {
        let increment = eps(w - u);
        integral(Omega, inner(2 * mu * increment + lambda * tr(increment) * I, eps(v)))
    }
    pub fn equilibrium(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }

    /// The plastic strain after a step.
    pub fn new_plastic(w: Vector) -> Tensor {
        plastic + flow(w)
    }
    pub fn new_amount(w: Vector) -> Scalar {
        amount + sqrt(2 / 3) * magnitude(flow(w))
    }
    pub fn plastic_amount() -> Scalar {
        amount
    }
    pub fn stress_along_x(u: State<Vector>) -> Functional {
        integral(Omega, stress(u)[0][0])
    }
}

const LAMBDA: f64 = 115e3; // MPa
const MU: f64 = 77e3; // MPa
const YIELD_STRESS: f64 = 250.0; // MPa
const HARDENING: f64 = 10e3; // MPa

fn model(assembler: &Assembler<2>) -> Result<metal::Model<2>, AssemblyError> {
    let data = metal::data()
        .lambda(LAMBDA)
        .mu(MU)
        .yield_stress(YIELD_STRESS)
        .hardening(HARDENING)
        .plastic(assembler.history(Entity::Cells, "all", 2, [[0.0; 2]; 2])?)
        .amount(assembler.history(Entity::Cells, "all", 2, 0.0)?);
    Ok(metal::Model::new(data))
}

/// One load step: equilibrium at given constraints, and the new history written, to be committed.
fn step(
    assembler: &Assembler<2>,
    model: &metal::Model<2>,
    constraints: &Constraints<2>,
    start: &Field<2>,
) -> Result<(Field<2>, Vec<NewtonStep>), Failure> {
    let predictor = Problem::new(&model.predictor(start), start.space());
    let start = predictor.constrained(constraints).assembler(assembler).solve()?.into_field();
    let options = NewtonOptions { max_iterations: 15, ..NewtonOptions::default() };
    let problem =
        Problem::new(&model.equilibrium(), start.space()).constrained(constraints).assembler(assembler);
    let solved = problem.start(&start).options(options).solve()?;
    assembler.update_history(&model.new_plastic(solved.field()), &model.data.plastic)?;
    assembler.update_history(&model.new_amount(solved.field()), &model.data.amount)?;
    Ok((solved.field().clone(), solved.history))
}

fn commit(metal::Model { data, .. }: &metal::Model<2>) {
    data.plastic.commit();
    data.amount.commit();
}

/// Uniaxial strain up to `LARGEST` and back to zero against the closed form.
fn block() -> Result<(), Failure> {
    const LARGEST: f64 = 0.006;
    let mesh = rectangle([0.0; 2], [1.0, 1.0], [2, 2], CellShape::Triangle, 1)?;
    let space = Space::vector(&mesh, 2)?;
    let assembler = Assembler::new(&mesh);
    let model = model(&assembler)?;

    let bulk = LAMBDA + 2.0 / 3.0 * MU;
    let ratio = HARDENING / 3.0 / (MU + HARDENING / 3.0);
    let (elastic, plastic) = (bulk + 4.0 / 3.0 * MU, bulk + 4.0 / 3.0 * MU * ratio);
    let first_yield = YIELD_STRESS / (2.0 * MU);
    let curve = |strain: f64, elastic_range: f64| {
        elastic * strain.min(elastic_range) + plastic * (strain - elastic_range).max(0.0)
    };
    // After loading the yield surface has grown, and unloading crosses all of it.
    let grown = 2.0 * (first_yield + ratio * (LARGEST - first_yield));

    let mut u = Field::zero(&space);
    let (mut strains, mut stresses, mut exact_stresses) = (vec![0.0], vec![0.0], vec![0.0]);
    for number in 1..=12 {
        let loading = number <= 6;
        let strain = LARGEST * f64::from(if loading { number } else { 12 - number }) / 6.0;
        let mut constraints = Constraints::new(&space);
        constraints.fix("left", |_| [0.0, 0.0])?;
        constraints.fix("right", |_| [strain, 0.0])?;
        constraints.fix_component("top", 1, |_| 0.0)?;
        constraints.fix_component("bottom", 1, |_| 0.0)?;
        (u, _) = step(&assembler, &model, &constraints, &u)?;

        let stress = assembler.functional(&model.stress_along_x(&u))?;
        commit(&model);
        let exact = match loading {
            true => curve(strain, first_yield),
            false => curve(LARGEST, first_yield) - curve(LARGEST - strain, grown),
        };
        assert!((stress - exact).abs() < 1e-7 * YIELD_STRESS, "σ = {stress} at ε = {strain}, exact {exact}");
        strains.push(strain);
        stresses.push(stress);
        exact_stresses.push(exact);
    }
    println!(
        "uniaxial strain: σ = {:.3} MPa at ε = {LARGEST}, {:.3} MPa back at 0",
        stresses[6], stresses[12]
    );
    LinePlot::new()
        .x_axis("strain", Scale::Linear)
        .y_axis("stress [MPa]", Scale::Linear)
        .curve(Curve::new("closed form", &strains, &exact_stresses).without_markers())
        .curve(Curve::new("computed", &strains, &stresses).dashed())
        .write_png("out/05_plasticity_curve.png")?;
    Ok(())
}

/// A plate of 4 × 1 mm, clamped on the left; its right end is moved sideways.
fn plate() -> Result<(), Failure> {
    const SIDEWAYS: f64 = 0.06; // mm
    let mesh = rectangle([0.0; 2], [4.0, 1.0], [24, 6], CellShape::Triangle, 1)?;
    let space = Space::vector(&mesh, 2)?;
    let assembler = Assembler::new(&mesh);
    let model = model(&assembler)?;

    let mut histories: Vec<Vec<NewtonStep>> = Vec::new();
    let solve = |factor: f64, u: &Field<2>| -> Result<Field<2>, Failure> {
        let mut constraints = Constraints::new(&space);
        constraints.fix("left", |_| [0.0, 0.0])?;
        constraints.fix_component("right", 1, |_| factor * SIDEWAYS)?;
        let (u, history) = step(&assembler, &model, &constraints, u)?;
        histories.push(history);
        Ok(u)
    };
    // A step that does not converge is halved, and begins again from the committed history.
    let path = LoadSteps::uniform(4, 1.0)
        .committing(|_: &Field<2>| commit(&model))
        .each_attempt(|step| {
            let outcome = step.failure.as_deref().unwrap_or("equilibrium");
            println!("load factor {:.3}: {outcome}", step.factor);
        })
        .run(Field::zero(&space), solve)?;
    println!("residuals of the last step, relative to its first:");
    let last = histories.last().ok_or("no step was made")?;
    for step in last {
        println!("  {:.3e}", step.relative_residual);
    }
    // Quadratic convergence: once the zone that flows is found, each step squares the residual, until rounding.
    let residuals: Vec<f64> = last.iter().map(|step| step.relative_residual).collect();
    let near: Vec<&[f64]> = residuals.windows(2).filter(|pair| pair[0] < 1e-2).collect();
    assert!(near.len() >= 2, "Newton's method took {} steps", last.len());
    for pair in near {
        assert!(pair[1] < 10.0 * pair[0].powi(2) + 1e-11, "{} after {}", pair[1], pair[0]);
    }

    let amounts = assembler.project(&model.plastic_amount(), &Space::scalar(&mesh, 1)?)?;
    let largest = amounts.values().iter().copied().fold(0.0, f64::max);
    println!("largest plastic strain {largest:.4}");
    assert!(largest > 1e-3, "it flows at the clamp");
    // The projection goes a little below zero.
    FieldMap::of(&amounts, Shown::Component(0), "plastic strain")
        .range(0.0, largest)
        .length_unit("mm")
        .deformed(&path.state, 1.0)
        .write_png("out/05_plasticity.png")?;
    Ok(())
}

fn main() -> Result<(), Failure> {
    block()?;
    plate()
}
