//! Functions that are generic over the dimension alone, compiled in this crate and not in every program: its own, and for
//! space those of the crates below (see `forms_mesh::instantiate`).

#[cfg(not(test))]
use forms_problem::instantiate::Compiled as OfProblems;

pub(crate) use forms_mesh::instantiate;

/// The functions of this crate that are compiled once for the dimension D.
#[cfg(not(test))]
pub(crate) struct Compiled<const D: usize>;

#[cfg(not(test))]
impl<const D: usize> Compiled<D> {
    fn all() -> Vec<Vec<*const ()>> {
        vec![
            Self::adaptive_steps(),
            Self::checkpoint(),
            Self::estimate(),
            Self::events(),
            Self::linear_step(),
            Self::load_history(),
            Self::motion_history(),
            Self::observations(),
            Self::readings(),
            Self::redistributed_mass(),
            Self::second_order(),
            Self::step(),
            Self::step_equations(),
            Self::time_loop(),
        ]
    }
}

#[cfg(not(test))]
#[expect(dead_code, reason = "it is there for the instances that it names")]
static HERE: [fn() -> Vec<Vec<*const ()>>; 4] =
    [Compiled::<2>::all, Compiled::<3>::all, OfProblems::<3>::all, forms_mesh::Compiled::<3>::all];
