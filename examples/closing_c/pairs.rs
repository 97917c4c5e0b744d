//! The same bodies with contact pairs: the arm and the cells of the design that are the body's, by Nitsche's method.

use std::error::Error;

use forms_contact::laws::sliding_bodies as law;
use forms_fem::prelude::*;

use crate::design::{Closing, LAMBDA, LOWER, MU, SPRING, UPPER, WAY, pad};

/// The force on the pad, in the unit of the criterion, and the displacements in the last step.
pub struct Pressed {
    pub force: f64,
    pub u: Field<2>,
}

/// Steps of the pad.
const STEPS: usize = 6;

/// The arm and the whole cells that are solid.
pub fn with_pairs(c: &Closing, solid: &dyn Fn(&[f64; 2]) -> bool) -> Result<Pressed, Box<dyn Error>> {
    let mut mesh = c.mesh().clone();
    mesh.name_cells("body", |x| x[1] > UPPER || (x[1] < LOWER && solid(x)))?;
    let mut mesh = mesh.part("body")?.mesh;
    mesh.name_facets("upper", "boundary", |x| (x[1] - UPPER).abs() < 1e-9)?;
    mesh.name_facets("lower", "boundary", |x| (x[1] - LOWER).abs() < 1e-9)?;

    let space = Space::vector(&mesh, 2)?;
    let touch = Pairing::between("lower", "upper").within_reach(UPPER - LOWER + WAY);
    let data = law::data().lambda(LAMBDA).mu(MU).gamma0(20.0 * (LAMBDA + 2.0 * MU)).friction(0.0);
    let model =
        law::Model { data, regions: law::Regions::default().omega("all").gamma_n("top").touch(touch) };
    let direct = model.direct();
    let mut held = Constraints::new(&space);
    held.fix("left", |_| [0.0; 2])?;
    let mut force = 0.0;
    let path = LoadSteps::uniform(STEPS, WAY).advance(
        Field::zero(&space),
        |step: &Increment<'_, Field<2>>| -> Result<_, Box<dyn Error>> {
            let data = pad::data().spring(SPRING).way(step.factor);
            let pad = pad::Model { data, regions: pad::Regions::default().end("end") };
            let form = &direct + &pad.pressing();
            let solved = Problem::new(&form, &space)
                .constrained(&held)
                .quadrature(Quadrature::Degree(5))
                .options(NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() })
                .increment(step)
                .solve()?;
            force = solved.assembler().energy(&pad.force(), &[solved.field()])?;
            Ok(solved.into_field())
        },
    );
    let u = path.map_err(|error| error.to_string())?.state;
    Ok(Pressed { force: force / c.unit, u })
}
