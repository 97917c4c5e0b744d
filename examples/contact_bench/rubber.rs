//! A nearly incompressible body that a rigid flat deforms far: what a formulation gets there.

use std::cell::Cell;

use forms_fem::forms;
use forms_fem::prelude::*;

use crate::outcome::Refusal;

#[doc(inline)]
pub use self::rubber::*;

/// Rubber with a field for the mean stress, and what contact terms are written in.
#[forms(dimension = 2)]
pub mod rubber {
    use forms_contact::operators::rubber::{mixed_density, mixed_piola};

    /// Data of the body and the flat.
    #[includes(forms_contact::operators::rubber::Data)]
    pub struct Data {
        /// n_y, unit vector into the flat.
        pub obstacle_normal: Given<Vector>,
        /// Distance of a point of the body at rest to the flat, along n_y \[length\].
        pub flat: Given<Scalar>,
    }

    /// The body.
    #[cells]
    pub struct Omega;
    /// The boundary that may touch the flat.
    #[facets]
    pub struct Surface;

    /// The virtual work of the body, with its equation for p.
    pub fn body(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        let W = mixed_density(u, p);
        integral(Omega, derivative(W, u, v) + derivative(W, p, q))
    }

    /// 3μ over the size of a cell: the scale of a stiffness per area.
    pub fn stiffness() -> Scalar {
        3 * mu / h
    }

    /// The distance to the flat.
    pub fn distance(u: Vector) -> Scalar {
        flat - dot(u, obstacle_normal)
    }

    /// (P n)·n_y, per reference area.
    pub fn nominal_stress(u: Vector, p: Scalar) -> Scalar {
        dot(mixed_piola(u, p) * n, obstacle_normal)
    }

    /// ∫ (J − 1), the change of the body's volume.
    pub fn growth(u: State<Vector>) -> Functional {
        integral(Omega, det(I + grad(u)) - 1)
    }
}

/// A body and the way of its flat.
#[derive(Clone, Debug)]
pub struct Rubber {
    /// Displacements and mean stresses.
    pub spaces: [Arc<Space<2>>; 2],
    /// The name of the boundary that is held.
    pub held: &'static str,
    /// The name of the plane of symmetry, x = 0.
    pub mirror: &'static str,
    /// The name of the boundary that may touch.
    pub touching: &'static str,
    /// The body's data, with the flat where it touches first.
    pub data: Data<2>,
    /// The distance of a point at rest to the flat where that touches first, along `up`.
    pub distance: fn(&[f64; 2]) -> f64,
    /// The last way of the flat, in steps of 1 \[length\].
    pub end: usize,
    /// A force for which the way is looked for.
    pub force: f64,
    /// A typical pressure \[stress\].
    pub pressure: f64,
    /// The part of the whole body that is computed, as the factor of forces.
    pub copies: f64,
}

/// A path of the flat.
#[derive(Clone, Debug, Default)]
pub struct Pressed {
    /// Newton steps of each increment, those of halves included.
    pub newton: Vec<usize>,
    /// The force after each increment.
    pub forces: Vec<f64>,
    /// The way of the flat under the given force, and ∫ (J − 1) there.
    pub at_force: Option<[f64; 2]>,
    /// The worst penetration after the last increment \[length\].
    pub penetration: f64,
    /// The reason of an early end.
    pub failure: Option<String>,
}

impl Rubber {
    /// The data with the flat moved by this.
    pub fn data(&self, way: f64) -> Data<2> {
        let distance = self.distance;
        self.data.clone().flat(move |x: &[f64; 2]| distance(x) - way)
    }

    /// The body as a region.
    pub fn omega(&self) -> Omega {
        Omega::on("all")
    }

    /// The boundary that may touch as a region.
    pub fn surface(&self) -> Surface {
        Surface::on(self.touching)
    }

    /// The virtual work of the body.
    pub fn body(&self) -> Form<2> {
        body(&self.data, &self.omega())
    }

    /// The scalars on the boundary that may touch, of the displacement's degree.
    ///
    /// # Errors
    /// No such boundary.
    pub fn scalars(&self) -> Result<Arc<Space<2>>, Refusal> {
        let space = &self.spaces[0];
        Ok(Space::on_facets(space.mesh(), self.touching, space.degree().min(2))?)
    }

    /// The logarithm of the gap of the body at rest, where it is at least a hundredth of the last way.
    ///
    /// # Errors
    /// None in practice.
    pub fn latent(&self, scalars: &Arc<Space<2>>, way: f64) -> Result<Field<2>, Refusal> {
        let (distance, least) = (self.distance, 0.01 * self.end as f64);
        Ok(Field::interpolate(scalars, move |x| (distance(x) - way).max(least).ln())?)
    }

    /// The path of a whole form in u and p, body and contact, which depends on the way.
    ///
    /// # Errors
    /// No first step.
    pub fn follow(&self, form: impl Fn(f64) -> Form<2>) -> Result<Pressed, Refusal> {
        let [u, p] = &self.spaces;
        self.follow_all([u, p], form, |_| Ok(None))
    }

    /// The path of a whole form, and of bounds on u, if any, which both depend on the way.
    ///
    /// # Errors
    /// No first step.
    pub fn follow_all<const N: usize>(
        &self,
        spaces: [&Arc<Space<2>>; N],
        form: impl Fn(f64) -> Form<2>,
        bounds: impl Fn(f64) -> Result<Option<Bounds<2>>, Refusal>,
    ) -> Result<Pressed, Refusal> {
        self.follow_by(spaces.map(Field::zero), |attempt| {
            let (bounds, held) = (bounds(attempt.way)?, self.held_at(0.0)?);
            let problem = attempt.problem(&form(attempt.way)).constrained(&held);
            let problem = match attempt.increment {
                Some(increment) => problem.increment(increment),
                None => problem.start(attempt.before),
            };
            Ok(attempt.solved(bounds.iter().fold(problem, Problem::bounded))?)
        })
    }

    /// The path of a displacement and further fields: each state is solved from the one before.
    ///
    /// # Errors
    /// No first step.
    pub fn follow_by<const N: usize>(
        &self,
        start: [Field<2>; N],
        solve: impl Fn(&Attempt<'_, N>) -> Result<Solved<2, N>, Refusal>,
    ) -> Result<Pressed, Refusal> {
        let (assembler, newton) = (self.assembler(), Cell::new(0));
        let mut pressed = Pressed::default();
        let mut nearest: Option<(f64, f64, [Field<2>; N])> = None;
        let load = |solved: &Solved<2, N>| -> Result<f64, Refusal> {
            Ok(-self.copies * solved.reaction_of(0, self.held)?[1])
        };
        let step = |step: &Increment<'_, [Field<2>; N]>| -> Result<[Field<2>; N], Refusal> {
            let (from, way, before) = (step.from, step.factor, step.before);
            let attempt =
                Attempt { from, way, before, increment: Some(step), newton: &newton, assembler: &assembler };
            let solved = solve(&attempt)?;
            let force = load(&solved)?;
            let off = (force - self.force).abs();
            if nearest.as_ref().is_none_or(|(_, other, _)| off < (other - self.force).abs()) {
                nearest = Some((way, force, solved.fields.clone()));
            }
            if way.fract() == 0.0 {
                pressed.newton.push(newton.take());
                pressed.forces.push(force);
            }
            Ok(solved.fields)
        };
        let mut steps = LoadSteps::uniform(self.end, self.end as f64);
        steps.smallest_increment = 1.0 / 16.0;
        let last = match steps.advance(start, step) {
            Ok(path) => path.state,
            Err(error) => {
                pressed.failure = Some(format!("{} not reached: {}", error.failed, error.why));
                error.state
            }
        };
        let Some((mut way, mut force, mut state)) = nearest else {
            return Err(Refusal::Failed(pressed.failure.unwrap_or_default()));
        };
        // Secants.
        let mut slope = 1.8 * (force / way).max(1.0);
        for _ in 0..SECANTS {
            if (force - self.force).abs() < 1e-9 * self.force {
                let growth = growth(&self.data, &self.omega(), &state[0]);
                pressed.at_force = Some([way, self.copies * assembler.functional(&growth)?]);
                break;
            }
            let (from, next, before) = (way, way + (self.force - force) / slope, &state);
            let attempt =
                Attempt { from, way: next, before, increment: None, newton: &newton, assembler: &assembler };
            let Ok(solved) = solve(&attempt) else { break };
            let found = load(&solved)?;
            slope = (found - force) / (next - way);
            (way, force, state) = (next, found, solved.fields);
        }
        let gap = distance(&self.data(self.end as f64), &last[0]);
        let measured = Assembler::new(self.spaces[0].mesh());
        let gaps = measured.at_quadrature_points(&gap, Entity::Facets, self.touching, 8)?;
        pressed.penetration = gaps.values.iter().fold(0.0, |most: f64, gap| most.max(-gap[0]));
        Ok(pressed)
    }

    /// The path of u and p of a body that is moved onto the flat, from a start and with conditions of that motion. The states are those of a body
    /// whose flat is moved.
    ///
    /// # Errors
    /// No first step.
    pub fn follow_moved(
        &self,
        solve: impl Fn(&Attempt<'_, 2>, &Constraints<2>, &[Field<2>; 2]) -> Result<Solved<2, 2>, NewtonError>,
    ) -> Result<Pressed, Refusal> {
        let up = Field::interpolate(&self.spaces[0], |_| [0.0, 1.0])?;
        let moved = |[u, p]: &[Field<2>; 2], way: f64| -> Result<[Field<2>; 2], Refusal> {
            Ok([Field::combination(&[(1.0, u), (way, &up)])?, p.clone()])
        };
        self.follow_by(self.spaces.each_ref().map(Field::zero), |attempt| {
            let (held, start) = (self.held_at(attempt.way)?, moved(attempt.before, -attempt.from)?);
            let mut solved = solve(attempt, &held, &start)?;
            solved.fields = moved(&solved.fields, attempt.way)?;
            Ok(solved)
        })
    }

    /// The assembler of all integrals.
    pub fn assembler(&self) -> Assembler<2> {
        Assembler::new(self.spaces[0].mesh()).with_quadrature(Quadrature::Degree(Self::RULE))
    }

    /// The rule of all integrals.
    pub const RULE: usize = 5;

    /// The conditions with the held boundary moved toward the flat. A body that is moved by as much as the flat would be has the same forces.
    ///
    /// # Errors
    /// A mesh without the boundary.
    pub fn held_at(&self, way: f64) -> Result<Constraints<2>, Refusal> {
        let mut constraints = Constraints::new(&self.spaces[0]);
        constraints.fix(self.held, |_| [0.0, -way])?;
        constraints.fix_component(self.mirror, 0, |_| 0.0)?;
        Ok(constraints)
    }
}

/// An attempt to find the state of a way of the flat.
pub struct Attempt<'a, const N: usize> {
    /// The way of the state before.
    pub from: f64,
    /// The way.
    pub way: f64,
    /// The state before.
    pub before: &'a [Field<2>; N],
    /// The increment of the path, unless the way of a force is looked for.
    pub increment: Option<&'a Increment<'a, [Field<2>; N]>>,
    newton: &'a Cell<usize>,
    assembler: &'a Assembler<2>,
}

impl<const N: usize> Attempt<'_, N> {
    /// The problem of a whole form, without conditions.
    pub fn problem(&self, form: &Form<2>) -> Problem<'_, 2, N> {
        Problem::new(form, self.before.each_ref().map(Field::space)).assembler(self.assembler)
    }

    /// The solution of a problem, whose Newton steps are counted.
    ///
    /// # Errors
    /// Newton's method fails.
    pub fn solved<'p>(&'p self, problem: Problem<'p, 2, N>) -> Result<Solved<2, N>, NewtonError> {
        let count = |step: &NewtonStep| self.newton.set(self.newton.get() + usize::from(step.iteration > 0));
        problem.each_step(count).solve()
    }
}

/// Most secants on the way to the given force.
const SECANTS: usize = 12;
