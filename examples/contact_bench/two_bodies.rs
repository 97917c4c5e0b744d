//! Two elastic bodies with friction, in the plane or in space, under one load after the other: what a formulation gets there.

use forms_fem::contract::PairQuadrature;
use forms_fem::forms;
use forms_fem::prelude::*;

use crate::case::Sides;
use crate::outcome::Refusal;

#[doc(inline)]
pub use self::bodies::*;

/// Elasticity of two bodies, and what contact with friction is written in.
#[forms]
pub mod bodies {
    use forms_contact::operators::bodies::{own_gamma, present_gap};
    use forms_contact::operators::friction::{augmented_traction, contact_traction, slip_limit};
    use forms_contact::operators::linear_elastic::stress;

    /// Materials, the scale γ₀ of a formulation's stiffness, friction, and the displacement from which slip is counted.
    #[includes(forms_contact::operators::bodies::Data, forms_contact::operators::friction::Data)]
    pub struct Data {}

    /// Both bodies.
    #[cells]
    pub struct Omega;
    /// The surfaces that may touch.
    #[pairs]
    pub struct Touch;
    /// The own surface.
    #[facets]
    pub struct Own;

    /// The area of each node of the own surface.
    pub fn areas(v: Test<Scalar>) -> Form {
        integral(Own, v)
    }

    /// Σ a_i(u,v).
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }

    /// Σ ½ a_i(u,u).
    pub fn energy(u: State<Vector>) -> Functional {
        integral(Omega, inner(stress(u), eps(u)) / 2)
    }

    /// T(λ), the traction that contact and friction allow: the projection of λ, with springs of stiffness γ on the gap and the slip.
    pub fn allowed(traction: Vector, w: Vector) -> Vector {
        let P = augmented_traction(
            this(traction),
            present_gap(w),
            jump(w - displacement_before),
            own_gamma(),
            toward,
        );
        contact_traction(P, slip_limit(neg_part(dot(P, toward))), toward)
    }

    /// The gap between the displaced surfaces.
    pub fn separation(w: Vector) -> Scalar {
        present_gap(w)
    }

    /// Gaps, which are printed at points that switch back and forth.
    pub fn gap_of_bodies(u: Unknown<Vector>) -> Functional {
        integral(Touch, separation(u))
    }

    /// A traction that is a field on the own surface.
    pub fn known(l: Vector) -> Vector {
        this(l)
    }

    /// The traction of a pressure that is a field on the own surface.
    pub fn pressed(l: Scalar) -> Vector {
        -this(l) * toward
    }
}

/// A load: conditions on displacements, and the coefficient of friction while they are reached.
#[derive(Clone, Debug)]
pub struct Load<const D: usize> {
    /// Conditions on displacements.
    pub supports: Constraints<D>,
    /// κ.
    pub friction: f64,
}

/// Two bodies on a mesh.
#[derive(Clone, Debug)]
pub struct TwoBodies<const D: usize> {
    /// Displacements.
    pub space: Arc<Space<D>>,
    /// Names of the surfaces that may touch, the own one in front. The other one covers it.
    pub surfaces: [String; 2],
    /// E \[stress\].
    pub young: f64,
    /// λ and μ \[stress\].
    pub lame: [f64; 2],
    /// The loads, one after the other.
    pub loads: Vec<Load<D>>,
    /// A typical pressure \[stress\].
    pub pressure: f64,
    /// A typical change of the gap \[length\].
    pub approach: f64,
}

/// The bodies after a load.
#[derive(Clone, Debug)]
pub struct AfterLoad<const D: usize> {
    /// The displacement.
    pub u: Field<D>,
    /// Points of the own surface, with weights and the tractions of the opposite body there.
    pub tractions: forms_fem::assemble::PointValues<D>,
    /// The residual by unknown of the displacement: reactions where values are prescribed.
    pub residual: Vec<f64>,
    /// Newton steps of each problem that was solved for the load.
    pub newton: Vec<usize>,
}

/// The solution of one load.
pub struct SolvedLoad<const D: usize, const N: usize> {
    /// The displacement, and further fields.
    pub solved: Solved<D, N>,
    /// The traction of the opposite body on the own surface.
    pub traction: Expression<D>,
    /// Newton steps of each problem.
    pub newton: Vec<usize>,
}

impl<const D: usize, const N: usize> SolvedLoad<D, N> {
    /// That of one problem.
    pub fn of(solved: Solved<D, N>, traction: Expression<D>) -> Self {
        let newton = vec![solved.iterations()];
        SolvedLoad { solved, traction, newton }
    }
}

impl<const D: usize> TwoBodies<D>
where
    Dim: Dimension<D>,
{
    /// Both bodies as a region.
    pub fn omega(&self) -> Omega {
        Omega::on("all")
    }

    /// The pairs.
    pub fn pairing(&self, sides: Sides) -> Pairing {
        let [own, opposite] = self.surfaces.each_ref().map(String::as_str);
        match sides {
            Sides::Both => Pairing::between(own, opposite),
            Sides::Own => Pairing::onto(own, opposite),
            Sides::OwnWholeFacets => Pairing::onto(own, opposite).at(PairQuadrature::WholeFacets),
        }
    }

    /// The pairs as a region.
    pub fn touch(&self, sides: Sides) -> Touch {
        Touch::on(self.pairing(sides))
    }

    /// The data of a load after a displacement, with γ₀ as a multiple of E.
    fn data(&self, stiffness: f64, load: &Load<D>, before: &Field<D>) -> Data<D> {
        let data = self.materials().gamma0(stiffness * self.young);
        data.friction(load.friction).displacement_before(before)
    }

    fn materials(&self) -> Data<D> {
        let [lambda, mu] = self.lame;
        data().lambda(lambda).mu(mu).gamma0(self.young)
    }

    /// The assembler of all integrals.
    pub fn assembler(&self) -> Assembler<D> {
        let degree = 2 * self.space.degree() + 2;
        Assembler::new(self.space.mesh()).with_quadrature(Quadrature::Degree(degree))
    }

    /// The path of a form in u, with γ₀ as a multiple of E and the traction on the own surface.
    ///
    /// # Errors
    /// Newton's method fails.
    pub fn follow(
        &self,
        stiffness: f64,
        form: impl Fn(Data<D>) -> Form<D>,
        traction: impl Fn(Data<D>, &Field<D>) -> Expression<D>,
    ) -> Result<Vec<AfterLoad<D>>, Refusal> {
        self.follow_by(stiffness, [Field::zero(&self.space)], |data, load, [u]| {
            let problem = self.problem(&form(data.clone()), load).observe(&self.observed());
            let solved = problem.start(u).solve()?;
            let traction = traction(data, solved.field());
            Ok(SolvedLoad::of(solved, traction))
        })
    }

    /// The problem of a whole form in u under a load.
    pub fn problem<'a>(&'a self, form: &Form<D>, load: &'a Load<D>) -> Problem<'a, D> {
        let problem = Problem::new(form, &self.space).constrained(&load.supports);
        problem.assembler(self.assembler()).options(crate::Case::options())
    }

    /// The path of a form in u and fields on the own surface from a start of each, with γ₀ as a multiple of E, options of Newton's method and the
    /// traction on that surface.
    ///
    /// # Errors
    /// Newton's method fails.
    pub fn follow_fields<const N: usize>(
        &self,
        (stiffness, options): (f64, NewtonOptions),
        start: [Field<D>; N],
        form: impl Fn(Data<D>) -> Form<D>,
        traction: impl Fn(Data<D>, &[Field<D>; N]) -> Expression<D>,
    ) -> Result<Vec<AfterLoad<D>>, Refusal> {
        self.follow_by(stiffness, start, |data, load, fields| {
            let problem = Problem::new(&form(data.clone()), fields.each_ref().map(Field::space));
            let problem = problem.constrained(&load.supports).assembler(self.assembler());
            let solved = problem.options(options.clone()).start(fields).solve()?;
            let traction = traction(data, &solved.fields);
            Ok(SolvedLoad::of(solved, traction))
        })
    }

    /// Forces of contact on the nodes of the own surface, divided by the nodes' areas, as a traction.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn traction_of_forces(&self, solved: &Solved<D>) -> Result<Expression<D>, Refusal> {
        let (data, own) = (self.materials(), self.surfaces[0].as_str());
        let form = balance(&data, &self.omega());
        let elastic = solved.assembler().residual(&form, &[solved.field()], &[&self.space])?;
        let scalars = Space::scalar(self.space.mesh(), self.space.degree())?;
        let areas = self.assembler().linear_form(&areas(&data, &Own::on(own)), &scalars)?;
        let mut values = vec![0.0; self.space.unknowns()];
        for node in self.space.nodes_on(own)? {
            for at in D * node as usize..D * (node as usize + 1) {
                values[at] = (elastic[at] - solved.residual[at]) / areas[node as usize];
            }
        }
        Ok(known(&data, &Field::from_values(&self.space, values)?))
    }

    fn observed(&self) -> Functional<D> {
        gap_of_bodies(&self.materials(), &self.touch(Sides::Own))
    }

    /// The path of a displacement and further fields: each load is solved from the fields after the last one.
    ///
    /// # Errors
    /// A load that is not solved.
    pub fn follow_by<const N: usize>(
        &self,
        stiffness: f64,
        mut fields: [Field<D>; N],
        step: impl Fn(Data<D>, &Load<D>, &[Field<D>; N]) -> Result<SolvedLoad<D, N>, Refusal>,
    ) -> Result<Vec<AfterLoad<D>>, Refusal> {
        let mut path = vec![];
        for (number, load) in self.loads.iter().enumerate() {
            let data = self.data(stiffness, load, &fields[0]);
            let failed = |why| match why {
                Refusal::Failed(why) => Refusal::Failed(format!("load {}: {why}", number + 1)),
                other => other,
            };
            let SolvedLoad { solved, traction, newton } = step(data, load, &fields).map_err(failed)?;
            path.push(AfterLoad {
                u: solved.fields[0].clone(),
                tractions: solved.assembler().at_pairs(&traction, &self.pairing(Sides::Own), MEASURED)?,
                residual: solved.residual[..self.space.unknowns()].to_vec(),
                newton,
            });
            fields = solved.fields;
        }
        Ok(path)
    }

    /// The largest penetration at points of the own surface, zero without one \[length\].
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn penetration(&self, u: &Field<D>) -> Result<f64, Refusal> {
        let gap = separation(&self.materials(), u);
        let gaps = self.assembler().at_pairs(&gap, &self.pairing(Sides::Own), MEASURED)?;
        Ok(gaps.values.iter().fold(0.0, |most: f64, gap| most.max(-gap[0])))
    }

    /// Σ ½ a_i(u,u).
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn energy(&self, u: &Field<D>) -> Result<f64, Refusal> {
        Ok(self.assembler().functional(&energy(&self.materials(), &self.omega(), u))?)
    }
}

/// The degree of quadrature at which tractions and gaps are measured.
const MEASURED: usize = 8;
