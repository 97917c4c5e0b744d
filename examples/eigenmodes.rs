//! Eigenproblems of two forms: the tones of a square membrane, the load under which a column buckles, and the tones of a block that
//! nothing holds. It prints the table of examples/results.md with closed forms and draws modes into `out`.
//!
//! `cargo run --release --bin eigenmodes`

use std::error::Error;
use std::f64::consts::PI;
use std::process::ExitCode;

use forms_fem::output::picture::{FieldMap, Panel, Picture, Shown};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod membrane {
    #[cells]
    pub struct Omega;

    pub fn tension(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)))
    }
    pub fn mass(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, u * v)
    }
}

#[forms]
mod body {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        /// Normal force per area at the right end.
        pub pull: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Right;

    fn stress(w: Vector) -> Tensor {
        lambda * tr(eps(w)) * I + 2 * mu * eps(w)
    }
    pub fn stiffness(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }
    pub fn mass(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, dot(u, v))
    }
    pub fn pulled(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        stiffness(u, v) - integral(Right, pull * dot(n, v))
    }
    /// The work of the stress of a loaded state on what is left of Green's strain, ½ ∇uᵀ ∇u.
    pub fn geometric(u: Unknown<Vector>, v: Test<Vector>, loaded: State<Vector>) -> Form {
        integral(Omega, inner(dot(grad(u), stress(loaded)), grad(v)))
    }
}

fn square(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let mesh = rectangle([0.0; 2], [1.0; 2], [24; 2], CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 2)?;
    let mut rim = Constraints::new(&space);
    rim.fix("boundary", |_| 0.0)?;
    let model = membrane::Model::default();
    let (tension, mass) = (model.tension(), model.mass());
    let modes = Eigenproblem::vibration(&tension, &mass, &space).constrained(&rim).smallest(6)?;
    let mut panel = Panel::new(3);
    for (mode, exact) in modes.iter().zip([2.0, 5.0, 5.0, 8.0, 10.0, 10.0]) {
        let found = mode.value / PI.powi(2);
        out.line(format!("| membrane, ω²/π² | {exact} | {found:.8} | {:.0e} |", mode.residual));
        let title = format!("ω² = {found:.4} π²");
        let map = FieldMap::of(mode.field(), Shown::Component(0), "u").without_mesh_lines().without_axes();
        panel = panel.picture(&map.levels(12).title(&title).size(150.0, 150.0))?;
    }
    panel.write_png("out/membrane_modes.png")?;
    Ok(())
}

/// E = 2, ν = 0, height 1/20 of the length; clamped at the left.
fn column(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let height = 0.05;
    let mesh = rectangle([0.0; 2], [1.0, height], [40, 2], CellShape::Quadrilateral, 1)?;
    let space = Space::vector(&mesh, 2)?;
    let mut clamped = Constraints::new(&space);
    clamped.fix("left", |_| [0.0; 2])?;
    // A pressure whose resultant is one.
    let model = body::Model::new(body::data().lambda(0.0).mu(1.0).pull(-1.0 / height));
    let loaded = Problem::new(&model.pulled(), &space).constrained(&clamped).solve()?.into_field();
    let (stiffness, geometric) = (model.stiffness(), model.geometric(&loaded));
    let modes = Eigenproblem::buckling(&stiffness, &geometric, &space).constrained(&clamped).smallest(3)?;
    let mut panel = Panel::new(1);
    for (mode, odd) in modes.iter().zip([1.0, 3.0, 5.0]) {
        let euler = f64::powi(odd, 2) * PI.powi(2) * 2.0 * height.powi(3) / 12.0 / 4.0;
        // Engesser's correction for the shear, and what the geometric stiffness takes from E I: tests/eigenproblems.rs of forms-fem.
        let exact = euler / (1.0 + euler / (5.0 / 6.0 * height) + euler / (2.0 * height));
        out.line(format!(
            "| column, load | {exact:.6e} (Euler {euler:.6e}) | {:.6e} | {:.0e} |",
            mode.value, mode.residual
        ));
        let largest = mode.field().values().iter().fold(0.0_f64, |largest, u| largest.max(u.abs()));
        let map =
            FieldMap::of(mode.field(), Shown::Component(1), "u_{y}").deformed(mode.field(), 0.12 / largest);
        panel = panel.picture(&map.without_axes().size(420.0, 130.0))?;
    }
    panel.write_png("out/buckled_column.png")?;
    Ok(())
}

fn free_block(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let mesh = cuboid([0.0; 3], [3.0, 2.0, 1.0], [6, 4, 2], CellShape::Hexahedron, 1)?;
    let space = Space::vector(&mesh, 2)?;
    let model = body::Model::new(body::data().lambda(1.0).mu(1.0).pull(0.0));
    let (stiffness, mass) = (model.stiffness(), model.mass());
    // Zero is an eigenvalue, with six rigid motions: the shift is below it.
    let modes = Eigenproblem::vibration(&stiffness, &mass, &space).above(-0.5, 8)?;
    for (number, mode) in modes.iter().enumerate() {
        let exact = if number < 6 { "0" } else { "" };
        out.line(format!("| free block, ω² | {exact} | {:.3e} | {:.0e} |", mode.value, mode.residual));
    }
    Ok(())
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    out.line("| | closed form | found | residual |\n| --- | --: | --: | --: |");
    square(out)?;
    column(out)?;
    free_block(out)?;
    out.line("pictures: out/membrane_modes.png, out/buckled_column.png");
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
