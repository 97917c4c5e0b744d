//! `docs/mean_gaps.md`.

use forms_contact::ContactProblem;
use forms_contact::laws::mean_sliding_bodies as law;
use forms_fem::prelude::*;

pub fn solve(
    space: Arc<Space<2>>,
    data: law::Data<2>,
    held: Constraints<2>,
) -> Result<Field<2>, Failure> {
    let touch = Pairing::onto("block bottom", "slab top");         // the coarser surface is the own one
    let regions = law::Regions::default().touch(touch).gamma_n("block top");
    let law = law::Model { data: data.share(1.0), regions };
    let problem = ContactProblem::new(&space, law, held).quadrature(Quadrature::Degree(7));
    let u = problem.direct()?.solve()?.into_field();
    Ok(u)
}

#[forms]
pub mod frictionless {
    use forms_contact::operators::neo_hookean::first_piola;

    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma0: Param,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;

    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let P_n = mean(dot(this(first_piola(u) * n), toward) + gamma0 / this(h) * gap);
        integral(Omega, inner(first_piola(u), grad(v)))
            + means(Touch(u), 0, neg_part(P_n) * mean(dot(toward, jump(v))))
    }
}
