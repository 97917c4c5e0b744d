//! A C that closes: self contact through a third medium, after Bluhm, Sigmund and Poulios (2021).
//!
//! ```text
//! ∫_body W(u) + ∫_medium s W(u) + ½ k (H⋮H − L·L/2)  stationary in u,   H = ∇∇u, L = div ∇u
//! ```
//!
//! The medium fills the C and a strip at its open end. No contact is searched for: the medium is crushed between the arms and carries
//! the pressure. At last the derivative of the force by the body's shear modulus is computed by one adjoint problem.
//!
//! Run it with `cargo run --release --bin third_medium -- [CELLS PER TENTH] [STEPS]`. Pictures are in `out/third_medium.png` and
//! `out/third_medium_force.png`.

use std::error::Error;
use std::process::ExitCode;

use forms_contact::laws::third_medium::{medium, third_medium as law, third_medium_problem};
use forms_fem::output::picture::{Curve, FieldMap, LinePlot, Picture, Scale, Shown};
use forms_fem::output::{StandardOutput, program};
use forms_fem::prelude::*;

/// μ and λ, and the medium's part of them.
const MU: f64 = 5.0 / 14.0;
const LAMBDA: f64 = 5.0 / 3.0;
const SOFTNESS: f64 = 5e-6;
/// The way of the pressed node at the end.
const WAY: f64 = 0.62;

struct Closing {
    space: Arc<Space<2>>,
    assembler: Assembler<2>,
    model: law::Model<2>,
    pressed: usize,
}

impl Closing {
    fn new(finer: usize) -> Result<Closing, Box<dyn Error>> {
        let mut mesh = rectangle([0.0; 2], [1.1, 0.5], [11 * finer, 5 * finer], CellShape::Quadrilateral, 1)?;
        let is_medium = |x: &[f64; 2]| x[0] > 1.0 || (x[0] > 0.1 && (x[1] - 0.25).abs() < 0.15);
        mesh.name_cells("medium", is_medium)?;
        mesh.name_cells("body", |x| !is_medium(x))?;
        let space = Space::vector(&mesh, 2)?;
        let soft = medium(LAMBDA, MU, SOFTNESS, 1.0);
        let data = law::data()
            .lambda(LAMBDA)
            .mu(MU)
            .medium_lambda(soft.lambda)
            .medium_mu(soft.mu)
            .curvature_stiffness(soft.curvature_stiffness);
        let regions = law::Regions::default().omega("body").medium("medium").gamma_n("top");
        let pressed = space.nearest_node(&[1.0, 0.5]).ok_or("a mesh without nodes")?;
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(5));
        Ok(Closing { space, assembler, model: law::Model { data, regions }, pressed })
    }

    fn held(&self, height: f64) -> Result<Constraints<2>, Box<dyn Error>> {
        let mut held = Constraints::new(&self.space);
        held.fix("left", |_| [0.0; 2])?;
        held.fix_node(self.pressed, 1, height)?;
        Ok(held)
    }

    /// The displacement 1 of the pressed node along y.
    fn lift(&self) -> Result<Field<2>, Box<dyn Error>> {
        let mut values = vec![0.0; self.space.unknowns()];
        values[2 * self.pressed + 1] = 1.0;
        Ok(Field::from_values(&self.space, values)?)
    }

    /// dF/dμ by the adjoint of the force, which is 1 at the pressed node.
    fn by_shear_modulus(&self, u: &Field<2>) -> Result<f64, Box<dyn Error>> {
        let held = self.held(1.0)?;
        let adjoint = Problem::new(&self.model.force_adjoint(u), &self.space)
            .constrained(&held)
            .assembler(&self.assembler)
            .solve()?
            .into_field();
        Ok(-self.assembler.functional(&self.model.force_by_mu(u, &adjoint))?)
    }
}

fn run(out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args().skip(1).map(|count| count.parse()).collect::<Result<_, _>>()?;
    let c = Closing::new(counts.first().copied().unwrap_or(2))?;
    let count = counts.get(1).copied().unwrap_or(20);
    let lift = c.lift()?;
    out.line(format!(
        "{} unknowns\n\n| way | force | Newton steps |\n| --: | --: | --: |",
        c.space.unknowns()
    ));
    let (mut ways, mut forces, mut newton_steps) = (vec![0.0], vec![0.0], 0);
    let steps = LoadSteps::uniform(count, WAY);
    let path = steps.run(Field::zero(&c.space), |way, before: &Field<2>| -> Result<_, Box<dyn Error>> {
        let held = c.held(-way)?;
        let solved = third_medium_problem(&c.model, &c.space)?
            .constrained(&held)
            .assembler(&c.assembler)
            .start(before)
            .options(NewtonOptions {
                prescribed_values: PrescribedValues::ByTangent,
                ..NewtonOptions::default()
            })
            .solve()?;
        let iterations = solved.iterations();
        let u = solved.into_field();
        let force = -c.assembler.functional(&c.model.force_along(&u, &lift))?;
        out.line(format!("| {way:.3} | {force:.9e} | {iterations} |"));
        newton_steps += iterations;
        ways.push(way);
        forces.push(force);
        Ok(u)
    });
    let u = path.map_err(|error| error.to_string())?.state;
    out.line(format!("\n{newton_steps} Newton steps"));
    out.line(format!("derivative of the force by the body's μ: {:.9e}", c.by_shear_modulus(&u)?));
    let volumes = Space::discontinuous_scalar(c.space.mesh(), 1)?;
    let volume = c.assembler.project(&c.model.volume_ratio(&u), &volumes)?;
    FieldMap::of(&volume, Shown::Component(0), "J")
        .deformed(&u, 1.0)
        .range(0.0, 1.5)
        .size(240.0, 180.0)
        .title("A C that has closed: the crushed medium carries the contact")
        .write_png("out/third_medium.png")?;
    LinePlot::new()
        .title("Force on the upper arm")
        .x_axis("way of the arm's end", Scale::Linear)
        .y_axis("force per thickness", Scale::Linear)
        .grid()
        .curve(Curve::new("third medium", &ways, &forces))
        .write_png("out/third_medium_force.png")?;
    out.line("pictures: out/third_medium.png, out/third_medium_force.png");
    Ok(())
}

fn main() -> ExitCode {
    program(run)
}
