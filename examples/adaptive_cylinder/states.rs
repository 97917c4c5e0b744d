//! The states of the paper's cylinder on one mesh of triangles, and by what it is refined.

use clap::ValueEnum;
use forms_contact::hollow_cylinder::{
    CONTACT, CONTACT_CELLS, IMPOSED_DISPLACEMENT, INNER_RADIUS, OUTER_RADIUS, Settings, hollow_cylinder_on,
};
use forms_contact::residual_estimator::{consistent_adjoint, dual_weighted, frictionless};
use forms_contact::threshold::required_gamma0;
use forms_contact::{Adjoint, ContactProblem};
use forms_fem::adaptivity::{AdaptiveSolution, ErrorEstimate};
use forms_fem::mesh::{AdaptiveMesh, onto_sphere};
use forms_fem::prelude::*;

use crate::Outcome;

/// The free part of the outer circle.
const FREE: &str = "free";
/// Cells across the thickness of the first mesh; sixteen times as many around. Where meshes stay as coarse, their boundary is 6·10⁻⁶ cm
/// off the circles.
pub const FIRST: usize = 4;

/// A mesh of the ring with the given number of cells across.
pub fn mesh(radial: usize) -> Outcome<Mesh<2>> {
    let mut mesh = annulus(INNER_RADIUS, OUTER_RADIUS, radial, 16 * radial, CellShape::Triangle, 2)?;
    mesh.name_facets(CONTACT, "outer", |centre| centre[1] < 0.0)?;
    mesh.name_facets(FREE, "outer", |centre| centre[1] >= 0.0)?;
    mesh.name_cells_of_facets(CONTACT_CELLS, CONTACT)?;
    Ok(mesh)
}

/// Refines some cells, with new nodes on the circles.
pub fn refined(mesh: &AdaptiveMesh<2>, marked: &[u32]) -> Outcome<AdaptiveMesh<2>> {
    let (inner, outer) = (onto_sphere([0.0; 2], INNER_RADIUS), onto_sphere([0.0; 2], OUTER_RADIUS));
    Ok(mesh.refined_onto(marked, &[("inner", &inner), ("outer", &outer)])?.0)
}

/// The quadrature on the facets of Γ_C.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
pub enum ContactFacets {
    /// By the rule of a facet, wherever contact ends
    Whole,
    /// In parts, where contact ends inside
    Split,
}

/// A variant of Nitsche's method.
#[derive(Clone, Copy, Debug)]
pub struct Variant {
    /// θ.
    pub theta: f64,
    /// γ₀ in units of Young's modulus.
    pub gamma0_over_young: f64,
    /// The quadrature on Γ_C.
    pub facets: ContactFacets,
}

/// The estimates by which cells are marked for J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Marking {
    /// That of J alone.
    Goal,
    /// That of J and that of p of (22), each over its sum.
    GoalAndAdjoint,
}

/// The displacement on a mesh.
pub struct Direct {
    /// The problem.
    pub problem: ContactProblem<2>,
    /// u_h of (14).
    pub u: Field<2>,
    facets: ContactFacets,
    solver: CondensedSolver,
}

/// The states whose errors are measured, in the order of the tables.
pub struct States {
    /// u_h, p_h of (22), p̃_h of (21), p_h of (41).
    pub fields: [Field<2>; 4],
}

impl Direct {
    /// Solves (14), from the displacement on the mesh before where there is one.
    pub fn solve(mesh: &Mesh<2>, variant: &Variant, before: Option<&Field<2>>) -> Outcome<Direct> {
        let Variant { theta, gamma0_over_young, facets } = *variant;
        let settings = Settings { theta, gamma0_over_young, ..Settings::default() };
        let problem = integrated(hollow_cylinder_on(mesh, &settings)?, facets);
        let mut solver = CondensedSolver::default();
        let start = match before {
            Some(before) => before.onto(&problem.space).interpolated()?,
            None => Field::zero(&problem.space),
        };
        let u = problem.direct()?.start(&start).solver(&mut solver).solve()?.into_field();
        Ok(Direct { problem, u, facets, solver })
    }

    /// Solves for an adjoint state.
    pub fn adjoint(&mut self, which: Adjoint) -> Outcome<Field<2>> {
        Ok(self.problem.solve_adjoint(which, &self.u, &mut self.solver)?.into_field())
    }

    /// All states.
    pub fn states(mut self) -> Outcome<States> {
        let [consistent, discrete, extended] =
            [Adjoint::Consistent, Adjoint::Discrete, Adjoint::Extended].map(|which| self.adjoint(which));
        Ok(States { fields: [self.u, consistent?, discrete?, extended?] })
    }

    /// The estimated error of u.
    pub fn error(&self) -> Outcome<ErrorEstimate> {
        let regions = frictionless::Regions::default().gamma_n(FREE).gamma_c(CONTACT);
        let model = frictionless::Model { data: self.problem.law.data.clone(), regions };
        Ok(ErrorEstimate::residual(&self.problem.assembler, &model.squared(&self.u))?)
    }

    /// The estimated error of p of (22).
    pub fn adjoint_error(&mut self) -> Outcome<ErrorEstimate> {
        let p = self.adjoint(Adjoint::Consistent)?;
        let regions = consistent_adjoint::Regions::default().gamma_n(FREE).gamma_c(CONTACT);
        let model = consistent_adjoint::Model { data: self.problem.law.data.clone(), regions };
        Ok(ErrorEstimate::residual(&self.problem.assembler, &model.squared(&self.u, &p))?)
    }

    /// The same problem in degree 3.
    fn richer(&self) -> Outcome<ContactProblem<2>> {
        let space = Space::vector(self.u.space().mesh(), 3)?;
        let mut held = Constraints::new(&space);
        held.fix("inner", |_| IMPOSED_DISPLACEMENT)?;
        let (assembler, law) = (self.problem.assembler.clone(), self.problem.law.clone());
        Ok(integrated(ContactProblem::new(&space, law, held).assembler(assembler), self.facets))
    }

    /// J, and its error by p of (21) in degree 3.
    pub fn goal(mut self, marking: Marking) -> Outcome<AdaptiveSolution<2>> {
        let richer = self.richer()?;
        let p = richer.state(self.problem.law.discrete_adjoint(&self.u), &self.u)?.solve()?.into_field();
        let regions = dual_weighted::Regions::default().gamma_n(FREE).gamma_c(CONTACT);
        let model = dual_weighted::Model { data: self.problem.law.data.clone(), regions };
        let localised = |z: &Field<2>| model.localised(&self.u, z);
        let assembler = self.problem.assembler_at(&self.u)?;
        let mut estimate = ErrorEstimate::dual_weighted(&assembler, &p, &self.problem.space, localised)?;
        if marking == Marking::GoalAndAdjoint {
            estimate = estimate.marking_also_by(&self.adjoint_error()?)?;
        }
        let goal = self.problem.criterion(&self.u)?;
        Ok(AdaptiveSolution::new(self.u, estimate).with_goal(goal))
    }

    /// J of u in degree 3 on the same mesh, and the γ₀ in units of Young's modulus below which (14) need not be well posed there.
    pub fn goal_of_degree_3(&self) -> Outcome<[f64; 2]> {
        let richer = self.richer()?;
        let start = self.u.onto(&richer.space).interpolated()?;
        let mut solver = CondensedSolver::default();
        let u = richer.direct()?.start(&start).solver(&mut solver).solve()?.into_field();
        let required = required_gamma0(&richer, CONTACT_CELLS)? / Settings::default().young;
        Ok([richer.criterion(&u)?, required])
    }
}

/// A problem with an integration over Γ_C.
fn integrated(problem: ContactProblem<2>, facets: ContactFacets) -> ContactProblem<2> {
    match facets {
        ContactFacets::Whole => problem,
        ContactFacets::Split => problem.with_split_facets(),
    }
}
