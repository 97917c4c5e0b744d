//! Tutorial 9: contact with a Lagrange multiplier. A rigid cylinder is pressed into a block.
//!
//! From the strong to the weak form, with `w_n = w·n_y` along the normal `n_y` into the cylinder. The pressure p is an
//! unknown of its own and lives only on the facets of the contact boundary `Γ_C`.
//! 1. `−div σ(u) = 0` in Ω, and without friction `σ(u) n = −p n_y` on `Γ_C`. Times v, integrated by parts:
//!    `∫_Ω σ(u):ε(v) + ∫_ΓC p v_n = 0`.
//! 2. Contact: `u_n ≤ g`, `p ≥ 0`, one of the two with equality. For any c > 0 this is one equation with a kink,
//!    `p − max(0, p + c (u_n − g)) = 0`. Times q/c: `∫_ΓC (p − max(0, p + c (u_n − g))) q/c = 0`.
//!
//! The form below is the sum of both. Newton's method differentiates through the kink.
//!
//! Two results check the solution. Nitsche's method (tutorial 4) solves the same problem on the same mesh without a
//! multiplier. For a contact that is small compared with the block, Hertz's theory gives the largest pressure from the
//! force F and the radius R: `p₀ = √(F E' / (π R))` with `E' = E/(1−ν²)`.
//!
//! Run it with `cargo run --release --bin 09_multiplier_contact`.

use std::f64::consts::PI;

use forms_fem::mesh::structured;
use forms_fem::output::picture::{Curve, LinePlot, Picture, Scale};
use forms_fem::prelude::*;

#[forms]
mod pressed {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        /// c \[stress/length\]: any positive number gives the same solution.
        pub switch: Param,
        /// γ₀ of Nitsche's method.
        pub gamma0: Param,
        /// Unit normal into the obstacle.
        pub up: Param<Vector>,
        pub gap: Given<Scalar>,
    }

    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Top;

    fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }
    fn penetration(w: Vector) -> Scalar {
        dot(w, up) - gap
    }

    /// Equilibrium, tested with v; the law of contact, tested with q.
    pub fn contact(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
            + integral(Top, p * dot(v, up))
            + integral(Top, (p - max(0, p + switch * penetration(u))) * q / switch)
    }

    pub fn pressure(p: State<Scalar>) -> Scalar {
        p
    }
    pub fn force(p: State<Scalar>) -> Functional {
        integral(Top, p)
    }

    // Nitsche's method, its skew-symmetric variant.
    fn normal_stress(w: Vector) -> Scalar {
        dot(stress(w) * n, up)
    }
    pub fn nitsche_pressure(w: Vector) -> Scalar {
        neg_part(normal_stress(w) - gamma0 / h * penetration(w))
    }
    pub fn nitsche(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let weight = h / gamma0;
        integral(Omega, inner(stress(u), eps(v)))
            + integral(Top, weight * normal_stress(u) * normal_stress(v))
            + integral(Top, nitsche_pressure(u) * (weight * normal_stress(v) + dot(v, up)))
    }
    pub fn nitsche_force(u: State<Vector>) -> Functional {
        integral(Top, nitsche_pressure(u))
    }
}

const YOUNG: f64 = 1000.0; // MPa
const POISSON: f64 = 0.3;
const RADIUS: f64 = 20.0; // mm
const DEPTH: f64 = 0.05; // mm, how far the cylinder is pushed in

fn main() -> Result<(), Failure> {
    // A block of 16 × 8 mm with finer cells below the cylinder.
    let finer = |[s, t]: [f64; 2]| {
        let (x, y) = (2.0 * s - 1.0, t - 1.0);
        [8.0 * (0.15 * x + 0.85 * x.powi(3)), 8.0 * (0.15 * y - 0.85 * y * y)]
    };
    let mesh = structured([48, 20], CellShape::Quadrilateral, 1, finer)?;
    let displacements = Space::vector(&mesh, 2)?;
    // A space on facets: no unknown inside the block.
    let pressures = Space::on_facets(&mesh, "top", 1)?;
    let mut held = Constraints::new(&displacements);
    held.fix("bottom", |_| [0.0, 0.0])?;

    let lambda = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
    let mu = YOUNG / (2.0 * (1.0 + POISSON));
    let data = pressed::data().lambda(lambda).mu(mu).switch(YOUNG).gamma0(10.0 * YOUNG).up([0.0, 1.0]);
    let model = pressed::Model::new(data.gap(|x: &[f64; 2]| x[0] * x[0] / (2.0 * RADIUS) - DEPTH));

    let solved = Problem::new(&model.contact(), [&displacements, &pressures])
        .constrained(&held)
        .quadrature(Quadrature::Degree(6))
        .each_step(|step| println!("Newton {}: residual {:.2e}", step.iteration, step.residual))
        .solve()?;
    let [_, p] = &solved.fields;
    let force = solved.functional(&model.force(p))?;

    let problem = Problem::new(&model.nitsche(), &displacements).quadrature(Quadrature::Degree(6));
    let without = problem.constrained(&held).solve()?;
    let nitsche_force = without.functional(&model.nitsche_force(without.field()))?;

    // The pressure along the top, by x.
    let along = |samples: Vec<forms_fem::assemble::FacetSample<2>>| {
        let mut pairs: Vec<[f64; 2]> = samples.iter().map(|s| [s.position[0], s.value[0]]).collect();
        pairs.retain(|[x, _]| x.abs() < 2.0);
        pairs.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let split: (Vec<f64>, Vec<f64>) = pairs.into_iter().map(|[x, value]| (x, value)).unzip();
        split
    };
    let (x, pressure) = along(solved.assembler().along_facets_uniformly(&model.pressure(p), "top", 3)?);
    let shown = model.nitsche_pressure(without.field());
    let (nitsche_x, nitsche_pressure) = along(without.assembler().along_facets_uniformly(&shown, "top", 3)?);

    let stiffness = YOUNG / (1.0 - POISSON * POISSON);
    let peak = (force * stiffness / (PI * RADIUS)).sqrt();
    let width = 2.0 * force / (PI * peak);
    let hertz = |x: f64| peak * (1.0 - (x / width).powi(2)).max(0.0).sqrt();
    let largest = pressure.iter().copied().fold(0.0, f64::max);
    println!("force             {force:.4} N/mm, by Nitsche's method {nitsche_force:.4} N/mm");
    println!("largest pressure  {largest:.3} MPa, Hertz {peak:.3} MPa");

    let fine: Vec<f64> = (0..=400).map(|k| f64::from(k) / 100.0 - 2.0).collect();
    let closed_form: Vec<f64> = fine.iter().map(|x| hertz(*x)).collect();
    LinePlot::new()
        .x_axis("x [mm]", Scale::Linear)
        .y_axis("pressure [MPa]", Scale::Linear)
        .curve(Curve::new("Hertz", &fine, &closed_form).without_markers())
        .curve(Curve::new("multiplier", &x, &pressure))
        .curve(Curve::new("Nitsche", &nitsche_x, &nitsche_pressure).dashed().without_markers())
        .write_png("out/09_multiplier_contact.png")?;

    assert!((force - nitsche_force).abs() < 2e-3 * force, "forces {force} and {nitsche_force}");
    assert!((largest - peak).abs() < 0.03 * peak, "largest pressure {largest}, Hertz {peak}");
    Ok(())
}
