//! `docs/gap_pressures.md`.

use forms_fem::prelude::*;

pub fn barrier(
    (space, before, held): (Arc<Space<2>>, Field<2>, Constraints<2>),
    (lambda, mu, pressure, reach, gap): (f64, f64, f64, f64, f64),
) -> Result<(), Failure> {
    use forms_contact::laws::barrier_obstacle::{barrier_obstacle as law, barrier_problem, stiffness};

    let data = law::data().lambda(lambda).mu(mu).barrier_stiffness(stiffness(pressure, reach)).activation_gap(reach);
    let data = data.obstacle_normal([0.0, -1.0]).gap(gap);
    let model = law::Model { data, regions: law::Regions::default().gamma_c("bottom").gamma_n("top") };
    let solved = barrier_problem(&model, &space)?.constrained(&held).start(&before).solve()?;
    println!("{}", solved.iterations());
    Ok(())
}

pub fn table((lambda, mu, gap): (f64, f64, f64)) -> Result<(), Failure> {
    use forms_contact::laws::tabulated_obstacle as law;

    let closure = Table::monotone_cubic(&[[0.0, 0.4], [0.005, 0.1], [0.02, 0.0]])?.constant_outside();
    let data = law::data().lambda(lambda).mu(mu).obstacle_normal([0.0, -1.0]).gap(gap).closure(closure);
    println!("{:?}", law::Model::<2>::new(data).regions);
    Ok(())
}
