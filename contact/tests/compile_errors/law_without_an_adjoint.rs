//! A driver asks for what `contact_law!` did not name.

use forms_contact::{ContactProblem, contact_law};
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

contact_law!(penalty { direct: direct, region: gamma_c });

fn ask(problem: ContactProblem<2, penalty::Model<2>>, u: &Field<2>) -> Result<(), AssemblyError> {
    problem.adjoint(u)?;
    problem.with_split_facets();
    Ok(())
}

fn main() {}
