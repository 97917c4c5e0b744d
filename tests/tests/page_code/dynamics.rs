//! `docs/time.md`.

use forms_contact::impact::impact;
use forms_fem::prelude::*;
use forms_fem::time::{GeneralisedAlpha, State, Step, TimeLoop, redistributed_mass};

#[forms]
mod bar {
    use forms_fem::time::operators::vector::{acceleration, displacement};

    #[includes(forms_fem::time::operators::vector::Data)]
    pub struct Data { pub rho: Param, pub mu: Param }
    #[cells]
    pub struct Omega;

    pub fn motion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, rho * dot(acceleration(u), v) + 2 * mu * inner(eps(displacement(u)), eps(v)))
    }
}

pub fn swinging_bar((u, velocity): (Field<2>, Field<2>), held: Constraints<2>) -> Result<(), Failure> {
    let form = |step: &Step<2>| bar::Model::new(bar::data_from(step).rho(1.0).mu(0.5)).motion();
    let mut motion = TimeLoop::new(form, GeneralisedAlpha::with_spectral_radius(0.8)?, State::new(0.0, u, velocity)?)
        .constrained(&held);
    for _ in 0..40 {
        let taken = motion.take(0.025)?;
        println!("{} {:?}", taken.to, taken.reaction("left")?);
    }
    let value = &motion.state().value;
    println!("{:?}", value.values());
    Ok(())
}

pub fn impact(
    (mesh, assembler): (&Mesh<2>, &Assembler<2>),
    density: f64,
    (lambda, mu, gamma0): (f64, f64, f64),
    start: State<2>,
) -> Result<(), Failure> {
    let even = Field::interpolate(&Space::discontinuous_scalar(&mesh, 0)?, |_| density)?;
    let rho = redistributed_mass(&even, "left", &assembler)?;
    let form = |step: &Step<2>| impact::Model::new(impact::data_from(step).lambda(lambda).mu(mu).gamma0(gamma0).obstacle_normal([-1.0, 0.0]).gap(0.0).theta(0.0).rho(&rho)).motion();
    let scheme = GeneralisedAlpha::with_spectral_radius(0.8)?;
    TimeLoop::new(form, scheme, start).take(0.1)?;
    Ok(())
}
