//! Two neo-Hookean bodies that slide along each other without friction: what a formulation gets there.

use forms_fem::contract::PairQuadrature;
use forms_fem::forms;
use forms_fem::prelude::*;

use crate::case::Sides;
use crate::outcome::Refusal;

#[doc(inline)]
pub use self::sliding::*;

/// Two bodies at finite strains, and what contact terms are written in. Opposite points lie on rays along the deformed normal and move with u.
#[forms(dimension = 2)]
pub mod sliding {
    use forms_contact::operators::neo_hookean::first_piola;

    /// Materials.
    #[includes(forms_contact::operators::neo_hookean::Data)]
    pub struct Data {
        /// E, the scale of a formulation's parameters \[stress\].
        pub young: Param,
    }

    /// Both bodies.
    #[cells]
    pub struct Omega;
    /// The surfaces that may touch.
    #[pairs]
    pub struct Touch;

    /// The virtual work of the bodies.
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(first_piola(u), grad(v)))
    }

    /// (P n)·n_x of the own body, per reference area.
    pub fn own_stress(w: Vector) -> Scalar {
        dot(this(first_piola(w) * n), toward)
    }

    /// E/h on the boundary of the own body.
    pub fn own_stiffness() -> Scalar {
        young / this(h)
    }
}

/// Two bodies on a mesh and the ways of one of them.
#[derive(Clone, Debug)]
pub struct Sliding {
    /// Displacements.
    pub space: Arc<Space<2>>,
    /// Materials.
    pub data: Data<2>,
    /// Names of the surfaces that may touch, the own one in front.
    pub surfaces: [&'static str; 2],
    /// The name of the boundary that is held.
    pub held: &'static str,
    /// The name of the boundary that is moved.
    pub moved: &'static str,
    /// Its displacements, one after the other \[length\].
    pub ways: Vec<[f64; 2]>,
    /// A displacement with bodies in contact, from which the first step begins.
    pub start: Field<2>,
    /// A typical pressure \[stress\].
    pub pressure: f64,
    /// A typical change of the gap \[length\].
    pub approach: f64,
}

/// The bodies after a step.
#[derive(Clone, Debug)]
pub struct Slid {
    /// The force on the boundary that is moved.
    pub force: [f64; 2],
    /// Newton steps of each problem that was solved for the step.
    pub newton: Vec<usize>,
}

impl Sliding {
    /// Both bodies as a region.
    pub fn omega(&self) -> Omega {
        Omega::on("all")
    }

    /// The pairs: on segments that face one opposite facet, or at points of whole facets.
    pub fn pairing(&self, sides: Sides) -> Pairing {
        let [own, opposite] = self.surfaces;
        let pairing = match sides {
            Sides::Both => Pairing::between(own, opposite).at(PairQuadrature::Pieces),
            Sides::Own => Pairing::onto(own, opposite).at(PairQuadrature::Pieces),
            Sides::OwnWholeFacets => Pairing::onto(own, opposite).at(PairQuadrature::WholeFacets),
        };
        pairing.within_reach(10.0 * self.approach)
    }

    /// The pairs as a region.
    pub fn touch(&self, sides: Sides) -> Touch {
        Touch::on(self.pairing(sides))
    }

    /// Continuous scalars on the own surface.
    ///
    /// # Errors
    /// No such surface.
    pub fn scalars(&self, degree: usize) -> Result<Arc<Space<2>>, Refusal> {
        Ok(Space::on_facets(self.space.mesh(), self.surfaces[0], degree)?)
    }

    /// The path of a whole form in u.
    ///
    /// # Errors
    /// Newton's method fails.
    pub fn follow(&self, form: &Form<2>) -> Result<Vec<Slid>, Refusal> {
        self.follow_all(form, [self.start.clone()], crate::Case::options())
    }

    /// The path of a whole form in u and a pressure on the own surface.
    ///
    /// # Errors
    /// Newton's method fails.
    pub fn follow_pressure(&self, form: &Form<2>, scalars: &Arc<Space<2>>) -> Result<Vec<Slid>, Refusal> {
        let guess = Field::from_values(scalars, vec![self.pressure; scalars.unknowns()])?;
        self.follow_all(form, [self.start.clone(), guess], crate::Case::options())
    }

    /// The path of a whole form in u and fields on the own surface, from a start of each.
    ///
    /// # Errors
    /// Newton's method fails.
    pub fn follow_all<const N: usize>(
        &self,
        form: &Form<2>,
        fields: [Field<2>; N],
        options: NewtonOptions,
    ) -> Result<Vec<Slid>, Refusal> {
        let assembler = self.assembler();
        self.follow_by(fields, |supports, fields| {
            let problem = Problem::new(form, fields.each_ref().map(Field::space)).constrained(supports);
            let solved = problem.assembler(&assembler).options(options.clone()).start(fields).solve()?;
            let newton = vec![solved.iterations()];
            Ok((solved, newton))
        })
    }

    /// The problem of a whole form in u with these supports.
    pub fn problem<'a>(&'a self, form: &Form<2>, supports: &'a Constraints<2>) -> Problem<'a, 2> {
        let problem = Problem::new(form, &self.space).constrained(supports);
        problem.assembler(self.assembler()).options(crate::Case::options())
    }

    /// The assembler of all integrals.
    pub fn assembler(&self) -> Assembler<2> {
        let rule = Quadrature::Degree(2 * self.space.degree() + 2);
        Assembler::new(self.space.mesh()).with_quadrature(rule)
    }

    /// The path of a displacement and further fields: each step is solved from the fields after the last one, with the Newton steps of each problem.
    ///
    /// # Errors
    /// A step that is not solved.
    pub fn follow_by<const N: usize>(
        &self,
        mut fields: [Field<2>; N],
        step: impl Fn(&Constraints<2>, &[Field<2>; N]) -> Result<(Solved<2, N>, Vec<usize>), Refusal>,
    ) -> Result<Vec<Slid>, Refusal> {
        let mut path = vec![];
        for (number, way) in self.ways.iter().enumerate() {
            let mut supports = Constraints::new(&self.space);
            supports.fix(self.held, |_| [0.0; 2])?;
            supports.fix(self.moved, |_| *way)?;
            let failed = |why| match why {
                Refusal::Failed(why) => Refusal::Failed(format!("step {}: {why}", number + 1)),
                other => other,
            };
            let (solved, newton) = step(&supports, &fields).map_err(failed)?;
            let force = solved.reaction_of(0, self.moved)?;
            path.push(Slid { force: [force[0], force[1]], newton });
            fields = solved.fields;
        }
        Ok(path)
    }
}
