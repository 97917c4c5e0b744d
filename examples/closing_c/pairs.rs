//! The same bodies with contact pairs: the arm and a body below it, by Nitsche's method.

use std::error::Error;

use forms_contact::laws::sliding_bodies as law;
use forms_fem::mesh::MeshError;
use forms_fem::prelude::*;

use crate::design::{Closing, LAMBDA, LOWER, MU, SPRING, UPPER, WAY, is_end, pad};

/// The bodies after each step of the pad.
pub struct Pressed {
    /// The force on the pad in the last step, in the unit of the criterion.
    pub force: f64,
    /// The way of the pad and the displacements after each step.
    pub states: Vec<(f64, Field<2>)>,
}

/// Steps of the pad.
const STEPS: usize = 10;

/// The arm and the whole cells that are solid.
pub fn whole_cells(c: &Closing, solid: &dyn Fn(&[f64; 2]) -> bool) -> Result<Mesh<2>, MeshError> {
    let mut mesh = c.mesh().clone();
    mesh.name_cells("bodies", |x| x[1] > UPPER || (x[1] < LOWER && solid(x)))?;
    Ok(mesh.part("bodies")?.mesh)
}

/// The bodies on a mesh of the arm and of what is below it.
pub fn with_pairs(c: &Closing, mesh: &Mesh<2>) -> Result<Pressed, Box<dyn Error>> {
    let mut mesh = mesh.clone();
    mesh.name_facets("clamped", "boundary", |x| x[0] < 1e-9)?;
    mesh.name_facets("pressed", "boundary", is_end)?;
    mesh.name_facets("upper", "boundary", |x| (x[1] - UPPER).abs() < 1e-9)?;
    mesh.name_facets("lower", "boundary", |x| (x[1] - LOWER).abs() < 1e-9)?;

    let space = Space::vector(&mesh, 2)?;
    let touch = Pairing::between("lower", "upper").within_reach(UPPER - LOWER + WAY);
    let data = law::data().lambda(LAMBDA).mu(MU).gamma0(20.0 * (LAMBDA + 2.0 * MU)).friction(0.0);
    let regions = law::Regions::default().omega("all").gamma_n("pressed").touch(touch);
    let direct = law::Model { data, regions }.direct();
    let mut held = Constraints::new(&space);
    held.fix("clamped", |_| [0.0; 2])?;
    let (mut force, mut states) = (0.0, vec![(0.0, Field::zero(&space))]);
    let path = LoadSteps::uniform(STEPS, WAY).advance(
        Field::zero(&space),
        |step: &Increment<'_, Field<2>>| -> Result<_, Box<dyn Error>> {
            let data = pad::data().spring(SPRING).way(step.factor);
            let pad = pad::Model { data, regions: pad::Regions::default().end("pressed") };
            let form = &direct + &pad.pressing();
            let solved = Problem::new(&form, &space)
                .constrained(&held)
                .quadrature(Quadrature::Degree(5))
                .options(NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() })
                .increment(step)
                .solve()?;
            force = solved.assembler().energy(&pad.force(), &[solved.field()])?;
            states.push((step.factor, solved.field().clone()));
            Ok(solved.into_field())
        },
    );
    path.map_err(|error| error.to_string())?;
    Ok(Pressed { force: force / c.unit, states })
}
