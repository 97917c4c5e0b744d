//! `docs/mortar.md`.

use forms_contact::laws::mortar_bodies as law;
use forms_fem::contract::PairQuadrature;
use forms_fem::prelude::*;

pub fn solve(
    (mesh, space): (Mesh<2>, Arc<Space<2>>),
    held: Constraints<2>,
    (before, pressure): (Field<2>, Field<2>),
) -> Result<[Field<2>; 3], Failure> {
    let traces = Space::on_facets(&mesh, "block bottom", 1)?;
    let touch = Pairing::onto("block bottom", "slab top").at(PairQuadrature::Pieces);
    let regions = law::Regions::default().touch(touch).own("block bottom").gamma_n("block top");
    let model = law::Model { data: law::data().lambda(15.0).mu(10.0).gamma0(350.0), regions };
    let start = [&before, &pressure, &Field::zero(&traces)];
    let solved = law::mortar_problem(&model, [&space, &traces], &held)?.start(start).solve()?;
    let [u, p, g] = solved.fields;
    Ok([u, p, g])
}

#[forms]
pub mod own_law {
    pub use forms_contact::laws::two_bodies::{Omega, Touch};
    pub use forms_contact::operators::multipliers::Own;
    use forms_contact::operators::multipliers::conditions;
    use forms_contact::operators::neo_hookean::first_piola;

    #[includes(forms_contact::laws::two_bodies::Data, forms_contact::operators::multipliers::Data)]
    pub struct Data {}

    pub fn direct(
        u: Unknown<Vector>,
        p: Unknown<Scalar>,
        g: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        r: Test<Scalar>,
    ) -> Form {
        integral(Omega, inner(first_piola(u), grad(v)))
            + integral(Touch(u), this(p) * dot(toward, jump(v)) + gap * this(r - q))
            + conditions(p, g, q, r, gamma0 / h)
    }
}
