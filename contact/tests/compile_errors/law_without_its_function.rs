//! `contact_law!` names a function and a region that the module does not have.

use forms_contact::contact_law;
use forms_fem::prelude::*;

#[forms]
pub mod penalty {
    use forms_contact::operators::obstacle::penalty_density;

    #[includes(forms_contact::operators::obstacle::Data)]
    pub struct Data {
        pub mu: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct GammaC;

    pub fn direct(u: Unknown<Vector>) -> Energy {
        integral(Omega, mu * inner(eps(u), eps(u))) + integral(GammaC, penalty_density(u))
    }
}

contact_law!(penalty { direct: equilibrium, region: gamma_d });

fn main() {}
