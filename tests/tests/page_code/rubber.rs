//! `docs/nearly_incompressible.md`.

use forms_fem::prelude::*;

pub fn block(
    (mesh, displacements): (Mesh<2>, Arc<Space<2>>),
    (mu, k): (f64, f64),
    gap: fn(&[f64; 2]) -> f64,
    held: Constraints<2>,
) -> Result<(), Failure> {
    use forms_contact::laws::mixed_nitsche::{mixed_nitsche as law, mixed_problem, usual_gamma0};

    let pressures = Space::of(&mesh, Elements::LinearInSpace, Scope::Cell, &[])?;
    let data = law::data().mu(mu).bulk_modulus(k).gamma0(usual_gamma0(mu)).obstacle_normal([0.0, -1.0]).gap(gap).friction(0.3);
    let solved = mixed_problem(&law::Model::new(data), [&displacements, &pressures])?.constrained(&held).solve()?;
    println!("{}", solved.iterations());
    Ok(())
}
