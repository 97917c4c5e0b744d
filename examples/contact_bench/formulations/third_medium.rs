//! A third medium, which needs a mesh of the gap: the problems here have none.

use contact_bench::outcome::not_defined;
use contact_bench::{Case, Formulation, Outcome, Refusal};

pub struct ThirdMedium;

pub fn all() -> Vec<ThirdMedium> {
    vec![ThirdMedium]
}

impl Formulation for ThirdMedium {
    fn name(&self) -> String {
        "third medium".to_owned()
    }

    fn solve(&self, _case: &Case) -> Result<Outcome, Refusal> {
        Err(not_defined("the gap has no mesh; the program `third_medium` closes a C with it"))
    }
}
