//! Tutorial 4: contact. A block hangs above a rigid table and is pressed down by more than the gap.
//!
//! From the strong to the weak form, by Nitsche's method, with `w_n = w·n_y` along the normal `n_y` into the table:
//! 1. `−div σ(u) = 0` in Ω, and without friction `σ(u) n = σ_n n_y` on `Γ_C`. Times v, integrated by parts:
//!    `∫_Ω σ(u):ε(v) − ∫_ΓC σ_n(u) v_n = 0`.
//! 2. Contact: `u_n ≤ g`, `σ_n ≤ 0`, one of the two with equality. For any `γ > 0` this is one equation with a kink:
//!    `σ_n(u) = −P(u)`, with the pressure `P(u) = [σ_n(u) − γ(u_n − g)]₋`.
//! 3. Put `−P` for `σ_n`, and subtract `(θ/γ)(σ_n + P) σ_n(v)`, which is zero, under the integral:
//!    `∫_Ω σ(u):ε(v) − ∫_ΓC (θ/γ) σ_n(u) σ_n(v) + ∫_ΓC P(u) (v_n − (θ/γ) σ_n(v)) = 0`. Here `θ = −1`.
//!
//! The block slides freely, so its stress is uniform and the contact force has a closed form: `E/(1−ν²) · (δ − g)/H · w`, with the height H, the width w, the initial gap
//! g and the imposed displacement δ.
//!
//! Run it with `cargo run --release --bin 04_signorini`.

use forms_fem::output::picture::{Colour, FieldMap, Picture, Shown};
use forms_fem::prelude::*;

#[forms]
mod block {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        /// Stabilisation, of the order of Young's modulus; divided by the cell's diameter `h` below.
        pub gamma0: Param,
        /// Unit normal that points into the table.
        pub down: Param<Vector>,
        /// Distance to the table before the deformation, a function of position.
        pub gap: Given<Scalar>,
    }

    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Bottom;

    fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }
    fn normal_stress(w: Vector) -> Scalar {
        dot(stress(w) * n, down)
    }
    fn gamma() -> Scalar {
        gamma0 / h
    }

    /// The contact law in one line: the table presses with [σ_n − γ(u_n − g)]₋, which is zero while the block
    /// is above it. Newton's method differentiates through the kink of `neg_part`.
    pub fn pressure(w: Vector) -> Scalar {
        neg_part(normal_stress(w) - gamma() * (dot(w, down) - gap))
    }

    /// With θ = −1 in the paper's (14).
    pub fn contact(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
            + integral(Bottom, normal_stress(u) * normal_stress(v) / gamma())
            + integral(Bottom, pressure(u) * (normal_stress(v) / gamma() + dot(v, down)))
    }

    pub fn force(u: State<Vector>) -> Functional {
        integral(Bottom, pressure(u))
    }
}

const YOUNG: f64 = 100.0; // MPa
const POISSON: f64 = 0.3;
const WIDTH: f64 = 2.0; // mm
const HEIGHT: f64 = 1.0; // mm
const GAP: f64 = 0.02; // mm
const PUSH: f64 = 0.1; // mm

fn main() -> Result<(), Failure> {
    let mesh = rectangle([0.0, 0.0], [WIDTH, HEIGHT], [12, 6], CellShape::Triangle, 1)?;
    let space = Space::vector(&mesh, 1)?;
    let mut constraints = Constraints::new(&space);
    constraints.fix_component("left", 0, |_| 0.0)?;
    constraints.fix_component("top", 1, |_| -PUSH)?;

    let lambda = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));
    let mu = YOUNG / (2.0 * (1.0 + POISSON));
    let data = block::data().lambda(lambda).mu(mu).gamma0(10.0 * YOUNG).down([0.0, -1.0]);
    let model = block::Model::new(data.gap(|x: &[f64; 2]| x[1] + GAP));
    let solved = Problem::new(&model.contact(), &space)
        .constrained(&constraints)
        .each_step(|step| {
            let active = step.active_points.unwrap_or(0);
            println!("Newton {}: residual {:.2e}, {active} active points", step.iteration, step.residual);
        })
        .solve()?;

    let force = solved.functional(&model.force(solved.field()))?;
    let exact = YOUNG / (1.0 - POISSON * POISSON) * (PUSH - GAP) / HEIGHT * WIDTH;
    println!("contact force {force:.9} N/mm, closed form {exact:.9} N/mm");

    FieldMap::of(solved.field(), Shown::Magnitude, "|u| [mm]")
        .length_unit("mm")
        .deformed(solved.field(), 1.0)
        .undeformed_outline("before")
        .line(&[[-0.2, -GAP], [WIDTH + 0.2, -GAP]], "table", Colour::BLACK)
        .write_png("out/04_signorini.png")?;

    assert!((force - exact).abs() < 1e-9 * exact, "contact force {force}, closed form {exact}");
    Ok(())
}
