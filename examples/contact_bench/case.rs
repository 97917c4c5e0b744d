//! One problem on one mesh: what a formulation gets.

use forms_fem::contract::PairQuadrature;
use forms_fem::prelude::*;

use crate::body;
use crate::cut_body::CutBody;
use crate::outcome::{Pressures, Refusal};

/// The degree of quadrature at which pressures and gaps are measured.
const MEASURED: usize = 8;

/// The obstacle or the surfaces that may touch.
#[derive(Clone, Debug)]
pub enum Contact {
    /// The facets of this name touch a rigid obstacle, whose place is in the data.
    Obstacle(String),
    /// The facets of two names touch each other: `[own, opposite]`.
    Bodies([String; 2]),
}

/// The surfaces that are integrated over where two bodies touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// The own one: a biased formulation.
    Own,
    /// Each, with half of the weight: an unbiased formulation.
    Both,
    /// The own one, at the points of whole facets instead of pieces that face one opposite facet.
    OwnWholeFacets,
}

impl Sides {
    /// Part of each surface's integral.
    pub fn share(self) -> f64 {
        if self == Sides::Both { 0.5 } else { 1.0 }
    }
}

/// A problem on a mesh.
#[derive(Clone, Debug)]
pub struct Case {
    /// Displacements.
    pub space: Arc<Space<2>>,
    /// Conditions on them.
    pub constraints: Constraints<2>,
    /// Materials, loads, the obstacle.
    pub data: body::Data<2>,
    /// Name of the loaded boundary.
    pub loaded: String,
    /// The body, where it is cut from the mesh; its surface is in the cells of the name in `contact`.
    pub cut: Option<CutBody>,
    /// The obstacle or the surfaces that may touch.
    pub contact: Contact,
    /// Start of Newton's method; zero without one.
    pub start: Option<Field<2>>,
    /// A typical pressure \[stress\].
    pub pressure: f64,
    /// A typical change of the gap \[length\].
    pub approach: f64,
}

impl Case {
    /// a(u,v) − ℓ(v), to which a formulation adds its terms.
    pub fn balance(&self) -> Form<2> {
        body::balance(&self.data, &self.bodies(), &self.load())
    }

    /// All bodies as a region.
    pub fn bodies(&self) -> body::Omega {
        body::Omega::on("all")
    }

    /// The loaded boundary as a region.
    pub fn load(&self) -> body::Loaded {
        body::Loaded::on(self.loaded.as_str())
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh<2> {
        self.space.mesh()
    }

    /// The rule of all integrals.
    pub fn rule(&self) -> usize {
        2 * self.space.degree() + 2
    }

    /// The assembler with that rule.
    pub fn assembler(&self) -> Assembler<2> {
        let whole = || Assembler::new(self.mesh());
        let assembler = self.cut.as_ref().map_or_else(whole, |body| body.assembler.clone());
        assembler.with_quadrature(Quadrature::Degree(self.rule()))
    }

    /// The own surface.
    pub fn own(&self) -> &str {
        match &self.contact {
            Contact::Obstacle(own) | Contact::Bodies([own, _]) => own,
        }
    }

    /// The own surface as a region of facets.
    pub fn surface(&self) -> body::Surface {
        body::Surface::on(self.own())
    }

    /// The pairs of two bodies.
    pub fn pairing(&self, sides: Sides) -> Pairing {
        let [own, opposite] = match &self.contact {
            Contact::Bodies(names) => names.each_ref().map(String::as_str),
            Contact::Obstacle(own) => [own.as_str(); 2],
        };
        match sides {
            Sides::Own => Pairing::onto(own, opposite),
            Sides::Both => Pairing::between(own, opposite),
            Sides::OwnWholeFacets => Pairing::onto(own, opposite).at(PairQuadrature::WholeFacets),
        }
    }

    /// The pairs of two bodies as a region.
    pub fn touch(&self, sides: Sides) -> body::Touch {
        body::Touch::on(self.pairing(sides))
    }

    /// The options of Newton's method that formulations take unless they need others.
    pub fn options() -> NewtonOptions {
        NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() }
    }

    /// The problem of a contact form in the displacement.
    pub fn problem<'a>(&'a self, contact: &Form<2>) -> Problem<'a, 2> {
        let gap = match self.contact {
            // Points inside of cells are not printed.
            Contact::Obstacle(_) if self.cut.is_some() => None,
            Contact::Obstacle(_) => Some(body::gap_to_obstacle(&self.data, &self.surface())),
            Contact::Bodies(_) => Some(body::gap_of_bodies(&self.data, &self.touch(Sides::Own))),
        };
        let problem = Problem::new(&(&self.balance() + contact), &self.space);
        let problem = gap.iter().fold(problem, |problem, gap| problem.observe(gap));
        let problem =
            problem.constrained(&self.constraints).assembler(self.assembler()).options(Self::options());
        self.start.iter().fold(problem, |problem, start| problem.start(start))
    }

    /// The problem of a whole form, balance and contact, in the displacement and fields on the own surface.
    pub fn mixed_problem<'a, const N: usize>(
        &'a self,
        form: &Form<2>,
        spaces: [&Arc<Space<2>>; N],
    ) -> Problem<'a, 2, N> {
        let problem = Problem::new(form, spaces);
        problem.constrained(&self.constraints).assembler(self.assembler()).options(Self::options())
    }

    /// The start, or zero.
    pub fn first(&self) -> Field<2> {
        self.start.clone().unwrap_or_else(|| Field::zero(&self.space))
    }

    /// Continuous scalars on the own surface, of the displacement's degree.
    ///
    /// # Errors
    /// No such surface.
    pub fn scalars(&self) -> Result<Arc<Space<2>>, Refusal> {
        Ok(Space::on_facets(self.mesh(), self.own(), self.space.degree())?)
    }

    /// A pressure at points of the own surface.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn pressures(&self, pressure: &Expression<2>) -> Result<Pressures, Refusal> {
        Ok(self.measured(pressure)?.into())
    }

    /// A scalar on the own surface or at its pairs.
    fn measured(&self, scalar: &Expression<2>) -> Result<forms_fem::assemble::PointValues<2>, AssemblyError> {
        if let Some(body) = &self.cut {
            return body.at_surface(scalar);
        }
        let assembler = Assembler::new(self.mesh());
        match &self.contact {
            Contact::Obstacle(own) => assembler.at_quadrature_points(scalar, Entity::Facets, own, MEASURED),
            Contact::Bodies(_) => assembler.at_pairs(scalar, &self.pairing(Sides::Own), MEASURED),
        }
    }

    /// A field of scalars on the own surface as a pressure.
    ///
    /// # Errors
    /// A field of another surface.
    pub fn known_pressures(&self, field: &Field<2>) -> Result<Pressures, Refusal> {
        let known = body::known(&self.data, field);
        let found =
            Assembler::new(self.mesh()).at_quadrature_points(&known, Entity::Facets, self.own(), MEASURED);
        Ok(found?.into())
    }

    /// The pressure that belongs to nodal forces on the own surface: f·N/|N|² with N = ∫ N_i n.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn pressures_of_forces(&self, forces: &[f64]) -> Result<Pressures, Refusal> {
        let pushed = self.assembler().linear_form(&body::pushed(&self.data, &self.surface()), &self.space)?;
        let mut found = Pressures::default();
        for node in self.space.nodes_on(self.own())? {
            let at = 2 * node as usize;
            let (push, force) = ([pushed[at], pushed[at + 1]], [forces[at], forces[at + 1]]);
            let size = push[0].hypot(push[1]);
            if size > 0.0 {
                found.positions.push(self.space.positions()[node as usize]);
                found.weights.push(size);
                found.values.push(-(push[0] * force[0] + push[1] * force[1]) / (size * size));
            }
        }
        Ok(found)
    }

    /// The largest penetration on a fine set of points, zero without one \[length\].
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn penetration(&self, u: &Field<2>) -> Result<f64, AssemblyError> {
        let distance = match &self.contact {
            Contact::Obstacle(_) => body::obstacle_distance(&self.data, u),
            Contact::Bodies(_) => body::distance(&self.data, u),
        };
        Ok(self.measured(&distance)?.values.iter().fold(0.0, |most: f64, gap| most.max(-gap[0])))
    }

    /// ½ a(u,u).
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn energy(&self, u: &Field<2>) -> Result<f64, AssemblyError> {
        self.assembler().functional(&body::energy(&self.data, &self.bodies(), u))
    }
}
