//! A formulation of your own in one file, to copy: linear springs of a fixed stiffness, on rigid obstacles.
//!
//! `cargo run --release --bin own_formulation -- --problems hertz` prints its row.

use std::process::ExitCode;

use contact_bench::outcome::not_defined;
use contact_bench::{Case, Contact, Formulation, Outcome, Refusal};
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod law {
    pub use contact_bench::body::Surface;
    use contact_bench::body::{obstacle_distance, weight};
    #[includes(contact_bench::body::Data)]
    pub struct Data {
        stiffness: Param,
    }
    pub fn pressure(u: Vector) -> Scalar {
        stiffness * neg_part(obstacle_distance(u))
    }
    pub fn contact(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Surface, weight() * pressure(u) * dot(v, obstacle_normal))
    }
}

struct Springs;

impl Formulation for Springs {
    fn name(&self) -> String {
        "springs".to_owned()
    }

    fn solve(&self, case: &Case) -> Result<Outcome, Refusal> {
        let Contact::Obstacle(_) = case.contact else {
            return Err(not_defined("there is no form for two bodies"));
        };
        let data = law::data_from(case.data.clone()).stiffness(100.0 * case.pressure / case.approach);
        case.newton(&law::contact(&data, &case.surface()), |u| law::pressure(&data, u))
    }
}

fn main() -> ExitCode {
    contact_bench::program(&[&Springs])
}
