//! `docs/bounds.md`.

use forms_fem::contract::Form;
use forms_fem::prelude::*;

pub fn bounded(
    space: Arc<Space<2>>,
    form: Form<2>,
    (held, damage_before): (Constraints<2>, Field<2>),
    obstacle: fn(&[f64; 2]) -> f64,
) -> Result<f64, Failure> {
    let mut bounds = Bounds::new(&space);
    bounds.at_least("all", |x| obstacle(x))?.at_most("left", |_| 1.0)?.at_least_field(&damage_before)?;
    let solved = Problem::new(&form, &space).constrained(&held).bounded(&bounds).solve()?;
    let force: f64 = solved.held().iter().map(|one| one.reaction).sum();
    Ok(force)
}

pub fn positive(space: Arc<Space<2>>, form: Form<2>) -> Result<(), Failure> {
    let volume = form!(|u: Unknown<Vector>| -> Functional { integral(cells("all"), det(I + grad(u))) });
    Problem::new(&form, &space).quadrature(Quadrature::Degree(4)).keep_positive(&volume).solve()?;
    Ok(())
}
