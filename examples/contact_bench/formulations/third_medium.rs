//! A third medium: the gap has a mesh of a very soft material, whose crushed cells carry the pressure.

use contact_bench::outcome::not_defined;
use contact_bench::{Case, Filled, Formulation, Outcome, Refusal, Step};
use forms_contact::laws::third_medium::{medium, third_medium as contact};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    use forms_contact::laws::third_medium::third_medium::stored;
    pub use forms_contact::laws::third_medium::third_medium::{
        Data, GammaN, Medium, Omega, force_adjoint, force_along, force_by_mu, volume, volume_ratio,
    };
    /// du/dμ, which is zero where u is prescribed.
    pub fn slope(u: State<Vector>, d: Unknown<Vector>, v: Test<Vector>) -> Form {
        let balance = derivative(stored(u), u, v);
        derivative(balance, u, d) + derivative(balance, mu, 1)
    }
    /// d²F/dμ² with the adjoint q of the force and d = du/dμ.
    pub fn twice(u: State<Vector>, q: State<Vector>, d: State<Vector>) -> Functional {
        let force = derivative(stored(u), u, q);
        derivative(derivative(force, u, d), u, d) + 2 * derivative(derivative(force, mu, 1), u, d)
    }
}

/// The medium's part of the bodies' stiffness.
pub struct ThirdMedium {
    softness: f64,
}

/// Three softnesses, the usual one in front.
pub fn all() -> Vec<ThirdMedium> {
    [5e-6, 5e-5, 1e-6].map(|softness| ThirdMedium { softness }).into()
}

impl ThirdMedium {
    fn data(&self, filled: &Filled) -> law::Data<2> {
        let [lambda, mu] = filled.reference;
        let soft = medium(lambda, mu, self.softness, filled.size);
        let data = law::data().lambda(filled.lambda).mu(filled.mu);
        let data = data.medium_lambda(soft.lambda).medium_mu(soft.mu);
        data.curvature_stiffness(soft.curvature_stiffness)
    }
}

/// The force and its derivatives at a displacement.
fn step(filled: &Filled, data: &law::Data<2>, u: &Field<2>, newton: usize) -> Result<Step, Refusal> {
    let (omega, gap, assembler, lift) =
        (law::Omega::on("body"), law::Medium::on("medium"), filled.assembler(), filled.lift()?);
    let linear = |form: &Form<2>, way: f64| -> Result<Field<2>, Refusal> {
        let problem = Problem::new(form, &filled.space).assembler(&assembler);
        Ok(problem.constrained(&filled.constraints(way)?).solve()?.into_field())
    };
    let q = linear(&law::force_adjoint(data, &omega, &gap, u), 1.0)?;
    let d = linear(&law::slope(data, &omega, &gap, u), 0.0)?;
    let ratios = assembler.at_quadrature_points(&law::volume_ratio(data, u), Entity::Cells, "all", 5)?;
    let force = assembler.functional(&law::force_along(data, &omega, &gap, u, &lift))?;
    let by_mu = assembler.functional(&law::force_by_mu(data, &omega, &gap, u, &q))?;
    let by_mu_twice = assembler.functional(&law::twice(data, &omega, &gap, u, &q, &d))?;
    let least_volume = ratios.values.iter().map(|ratio| ratio[0]).fold(f64::INFINITY, f64::min);
    Ok(Step { newton, force, by_mu, by_mu_twice, least_volume })
}

impl Formulation for ThirdMedium {
    fn name(&self) -> String {
        let of =
            if self.softness == 5e-6 { String::new() } else { format!(", softness {:e}", self.softness) };
        format!("third medium{of}")
    }

    fn solve(&self, _case: &Case) -> Result<Outcome, Refusal> {
        Err(not_defined("the gap has no mesh; \"closing_c\" has one"))
    }

    fn close(&self, filled: &Filled) -> Result<Vec<Step>, Refusal> {
        let (data, omega, gap) = (self.data(filled), law::Omega::on("body"), law::Medium::on("medium"));
        let direct = contact::direct(&data, &omega, &gap, &law::GammaN::on("top"));
        let volume = law::volume(&data, &omega, &gap);
        let (mut u, mut steps) = (Field::zero(&filled.space), vec![]);
        for way in &filled.ways {
            let (constraints, problem) = (filled.constraints(*way)?, Problem::new(&direct, &filled.space));
            let problem = problem.constrained(&constraints).assembler(filled.assembler()).start(&u);
            let solved = problem.keep_positive(&volume).options(filled.options.clone()).solve()?;
            let newton = solved.iterations();
            u = solved.into_field();
            steps.push(step(filled, &data, &u, newton)?);
        }
        Ok(steps)
    }
}
