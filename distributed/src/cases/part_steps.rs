//! Load steps with a memory at quadrature points: a plate that becomes softer where it has been strained.

use std::error::Error;

use forms_fem::prelude::*;
use forms_fem::solve::Increment;

/// The forms.
#[forms(dimension = 2)]
pub mod softening {
    /// Constants.
    pub struct Data {
        /// The largest ε:ε so far.
        pub largest: History<Scalar>,
    }
    /// The body.
    #[cells]
    pub struct Omega;

    fn reached(w: Vector) -> Scalar {
        max(largest, inner(eps(w), eps(w)))
    }
    /// Balance of forces, with a stiffness that falls with the largest strain.
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, (0.3 + 1 / (1 + 4 * reached(u))) * inner(eps(u), eps(v)))
    }
    /// The largest ε:ε after a step.
    pub fn after(w: Vector) -> Scalar {
        reached(w)
    }
    /// ∫ of the largest ε:ε.
    pub fn memory(u: State<Vector>) -> Functional {
        integral(Omega, largest + 0 * u[0])
    }
}

/// Load factors, with unloading.
pub const FACTORS: [f64; 4] = [0.2, 0.5, 0.1, 0.6];
/// The number of those after which a run may stop and go on.
pub const HALF: usize = 2;

/// A state, or why there is none.
type Solution = Result<Field<2>, Box<dyn Error>>;

/// The plate, or a part of it.
pub struct Softening {
    /// The space of the displacement.
    pub space: Arc<Space<2>>,
    /// Its quadrature is that of the memory.
    pub assembler: Assembler<2>,
    /// The memory.
    pub data: softening::Data<2>,
}

impl Softening {
    /// Before the first step.
    ///
    /// # Errors
    /// Regions that do not exist.
    pub fn on(mesh: &Mesh<2>) -> Result<Self, Box<dyn Error>> {
        let assembler = Assembler::new(mesh).with_threads(Threads::new(1));
        let data = softening::data().largest(assembler.history(Entity::Cells, "all", 4, 0.0)?);
        Ok(Softening { space: Space::vector(mesh, 2)?, assembler, data })
    }

    /// The conditions where the right side is pulled and turned by a factor.
    ///
    /// # Errors
    /// Regions that do not exist.
    pub fn held(&self, factor: f64) -> Result<Constraints<2>, Box<dyn Error>> {
        let mut held = Constraints::new(&self.space);
        held.fix("left", |_| [0.0; 2])?;
        held.fix("right", move |x| [factor * (1.0 + x[1]), factor])?;
        Ok(held)
    }

    /// The state after some factors, from one at another factor, with `solve` for each step by [`Softening::assembler`]. It commits the memory.
    ///
    /// # Errors
    /// Those of `solve`.
    pub fn pulled(
        &self,
        (from, state): (f64, Field<2>),
        factors: &[f64],
        mut solve: impl FnMut(&Form<2>, &Constraints<2>, &Increment<'_, Field<2>>) -> Solution,
    ) -> Solution {
        let form = softening::Model::new(self.data.clone()).balance();
        let steps = LoadSteps::through(factors.iter().copied()).starting_at(from);
        let path = steps.advance(state, |step| {
            let held = self.held(step.factor)?;
            let u = solve(&form, &held, step)?;
            self.assembler.update_history(&softening::after(&self.data, &u), &self.data.largest)?;
            self.data.largest.commit();
            Ok::<_, Box<dyn Error>>(u)
        });
        Ok(path.map_err(|error| error.to_string())?.state)
    }
}
