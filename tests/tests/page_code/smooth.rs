//! `docs/smooth_formulations.md`.

use forms_fem::prelude::*;

pub fn closing(
    (space, before, held): (Arc<Space<2>>, Field<2>, Constraints<2>),
    (lambda, mu, size): (f64, f64, f64),
) -> Result<(), Failure> {
    use forms_contact::laws::third_medium::{medium, third_medium as law, third_medium_problem};

    let soft = medium(lambda, mu, 5e-6, size);
    let data = law::data().lambda(lambda).mu(mu).medium_lambda(soft.lambda).medium_mu(soft.mu);
    let data = data.curvature_stiffness(soft.curvature_stiffness);
    let regions = law::Regions::default().omega("body").medium("medium").gamma_n("top");
    let model = law::Model { data, regions };
    let solved = third_medium_problem(&model, &space)?.constrained(&held).start(&before).solve()?;
    println!("{}", solved.iterations());
    Ok(())
}

pub fn membrane(
    (displacements, latents, held): (Arc<Space<2>>, Arc<Space<2>>, Constraints<2>),
    obstacle: fn(&[f64; 2]) -> f64,
) -> Result<(), Failure> {
    use forms_contact::laws::proximal_membrane::proximal_membrane as law;
    use forms_contact::proximal::{Proximal, ProximalOptions, solve_by_proximal_points};

    let solve = |step: Proximal<'_, 2>| -> Result<_, SolveError> {
        let model = law::Model::new(law::data().obstacle(obstacle).alpha(step.alpha));
        step.problem(&model, &model.direct(step.latent()), [&displacements, &latents])?.constrained(&held).solve()
    };
    let start = [Field::zero(&displacements), Field::zero(&latents)];
    let found = solve_by_proximal_points(start, ProximalOptions::default(), solve, |_| ())?;
    println!("{}", found.history);
    Ok(())
}
