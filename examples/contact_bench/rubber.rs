//! A nearly incompressible body that a rigid flat deforms far: what a formulation gets there.

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
    /// Conditions on displacements.
    pub constraints: Constraints<2>,
    /// The name of the boundary that is held.
    pub held: &'static str,
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
        let assembler = Assembler::new(spaces[0].mesh()).with_quadrature(Quadrature::Degree(5));
        let mut pressed = Pressed::default();
        let mut nearest: Option<(f64, f64, [Field<2>; N])> = None;
        let mut iterations = 0;
        let load = |solved: &Solved<2, N>| -> Result<f64, Refusal> {
            Ok(-self.copies * solved.reaction_of(0, self.held)?[1])
        };
        let solve = |step: &Increment<'_, [Field<2>; N]>| -> Result<[Field<2>; N], Refusal> {
            let count = |newton: &NewtonStep| iterations += usize::from(newton.iteration > 0);
            let bounds = bounds(step.factor)?;
            let problem = Problem::new(&form(step.factor), spaces).assembler(&assembler);
            let problem = bounds.iter().fold(problem.constrained(&self.constraints), Problem::bounded);
            let solved = problem.increment(step).each_step(count).solve()?;
            let force = load(&solved)?;
            let off = (force - self.force).abs();
            if nearest.as_ref().is_none_or(|(_, other, _)| off < (other - self.force).abs()) {
                nearest = Some((step.factor, force, solved.fields.clone()));
            }
            if step.factor.fract() == 0.0 {
                pressed.newton.push(std::mem::take(&mut iterations));
                pressed.forces.push(force);
            }
            Ok(solved.fields)
        };
        let mut steps = LoadSteps::uniform(self.end, self.end as f64);
        steps.smallest_increment = 1.0 / 16.0;
        let last = match steps.advance(spaces.map(Field::zero), solve) {
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
            let next = way + (self.force - force) / slope;
            let bounds = bounds(next)?;
            let problem = Problem::new(&form(next), spaces).assembler(&assembler).start(&state);
            let solved = bounds.iter().fold(problem.constrained(&self.constraints), Problem::bounded).solve();
            let Ok(solved) = solved else { break };
            let found = load(&solved)?;
            slope = (found - force) / (next - way);
            (way, force, state) = (next, found, solved.fields);
        }
        let gap = distance(&self.data(self.end as f64), &last[0]);
        let gaps =
            Assembler::new(spaces[0].mesh()).at_quadrature_points(&gap, Entity::Facets, self.touching, 8)?;
        pressed.penetration = gaps.values.iter().fold(0.0, |most: f64, gap| most.max(-gap[0]));
        Ok(pressed)
    }
}

/// Most secants on the way to the given force.
const SECANTS: usize = 12;
