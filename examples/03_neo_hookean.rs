//! Tutorial 3: finite strain from an energy. A neo-Hookean bar is pulled to 1.76 times its length.
//!
//! From the strong to the weak form, on the undeformed body, with `F = I + ∇u`, the energy W(F) per undeformed
//! volume and the first Piola–Kirchhoff stress `P = ∂W/∂F`:
//! 1. Equilibrium without load: `−Div P = 0` in Ω, P N = 0 on the free sides, u given at the ends.
//! 2. Times v, which vanishes where u is given, and integrated by parts: `∫_Ω P(F):∇v = 0` for all v.
//! 3. That is `d/dε ∫_Ω W(F + ε∇v)` at `ε = 0`, the first variation of the energy `Π(u) = ∫_Ω W(I + ∇u)`.
//!
//! So only Π is written down; the compiler derives the residual (its first variation), the tangent
//! (its second) and the stress. For the bar everything is known: with the stretch s along the bar and t
//! across it, the free sides give `μ(t² − 1) + λ ln(s t²) = 0`, so `s = exp(μ(1 − t²)/λ)/t²`, and the force per
//! undeformed area is `μ(s − 1/s) + λ ln(s t²)/s`.
//!
//! Run it with `cargo run --release --bin 03_neo_hookean`.

use forms_fem::output::picture::{Curve, LinePlot, Picture, Scale};
use forms_fem::prelude::*;

#[forms]
mod rubber {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
    }

    #[cells]
    pub struct Omega;
    #[facets]
    pub struct End;

    /// Stored energy per undeformed volume.
    fn density(F: Tensor) -> Scalar {
        let J = det(F);
        mu / 2 * (inner(F, F) - D) - mu * ln(J) + lambda / 2 * pow(ln(J), 2)
    }

    pub fn energy(u: Unknown<Vector>) -> Energy {
        integral(Omega, density(I + grad(u)))
    }

    /// The first Piola-Kirchhoff stress is the derivative of the density by F.
    pub fn stress(u: State<Vector>) -> Tensor {
        let F = I + grad(u);
        diff(density(F), F)
    }

    /// The force on the end of the bar, along the bar.
    pub fn force(u: State<Vector>) -> Functional {
        integral(End, (stress(u) * n)[0])
    }
}

const LAMBDA: f64 = 3.0; // MPa
const MU: f64 = 1.0; // MPa

fn main() -> Result<(), Failure> {
    // A bar of 2 × 1 × 1 mm. Its faces x = 0, y = 0 and z = 0 are planes of symmetry.
    let mesh = cuboid([0.0; 3], [2.0, 1.0, 1.0], [4, 2, 2], CellShape::Hexahedron, 1)?;
    let space = Space::vector(&mesh, 1)?;
    let data = rubber::data().lambda(LAMBDA).mu(MU);
    let model = rubber::Model { data, regions: rubber::Regions::default().end("right") };
    let form = model.energy();

    let mut u = Field::zero(&space);
    let (mut stretches, mut forces, mut exact_forces) = (vec![1.0], vec![0.0], vec![0.0]);
    println!("stretch  across  force [N]  closed form  Newton steps");
    // Load steps: each starts Newton's method from the state before.
    for step in 1..=8 {
        let across = 1.0 - 0.025 * f64::from(step);
        let stretch = (MU * (1.0 - across * across) / LAMBDA).exp() / (across * across);
        let mut constraints = Constraints::new(&space);
        for (component, plane) in ["left", "front", "bottom"].into_iter().enumerate() {
            constraints.fix_component(plane, component, |_| 0.0)?;
        }
        constraints.fix_component("right", 0, |x| (stretch - 1.0) * x[0])?;

        let problem = Problem::new(&form, &space).quadrature(Quadrature::Degree(4)).constrained(&constraints);
        let solved = problem.start(&u).solve()?;
        let (steps, force) = (solved.iterations(), solved.functional(&model.force(solved.field()))?);
        u = solved.into_field();
        let exact = MU * (stretch - 1.0 / stretch) + LAMBDA * (stretch * across * across).ln() / stretch;
        let measured = 1.0 + u.evaluate(&[2.0, 1.0, 1.0])?[1];
        println!("{stretch:7.4} {measured:7.4} {force:10.6} {exact:12.6} {steps:13}");
        assert!((force - exact).abs() < 1e-8 * exact, "force {force}, closed form {exact}");
        assert!((measured - across).abs() < 1e-8, "the bar is {measured} wide, closed form {across}");
        stretches.push(stretch);
        forces.push(force);
        exact_forces.push(exact);
    }

    LinePlot::new()
        .x_axis("stretch", Scale::Linear)
        .y_axis("force [N]", Scale::Linear)
        .curve(Curve::new("closed form", &stretches, &exact_forces).without_markers())
        .curve(Curve::new("computed", &stretches, &forces).dashed())
        .write_png("out/03_neo_hookean.png")?;
    Ok(())
}
