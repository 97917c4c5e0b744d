//! A membrane over an obstacle: contact in the volume, and what a formulation gets there.

use forms_fem::assemble::PointValues;
use forms_fem::forms;
use forms_fem::prelude::*;

use crate::cut_body::CutBody;
use crate::outcome::{Outcome, Pressures, Refusal};

/// The degree of quadrature at which forces and heights are measured.
const MEASURED: usize = 8;

/// A membrane of tension 1, and what contact terms are written in.
#[forms(dimension = 2)]
pub mod volume {
    use forms_contact::operators::ghost_penalty::scalar_ghost;

    /// Data of the obstacle, and of the ghost penalty where the membrane is cut from a mesh.
    #[includes(forms_contact::operators::ghost_penalty::Data)]
    pub struct Data {
        /// φ, the obstacle's height.
        pub obstacle: Given<Scalar>,
    }

    /// The membrane.
    #[cells]
    pub struct Omega;
    /// The rim of a membrane that is cut from a mesh.
    #[interface]
    pub struct Rim;
    /// The facets of its ghost penalty.
    #[interior_facets]
    pub struct Ghost;

    /// u − φ, the height above the obstacle.
    pub fn height(w: Scalar) -> Scalar {
        w - obstacle
    }

    /// (∇u, ∇v).
    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)))
    }

    /// u = 0 on the rim by Nitsche's method, and the ghost penalty, for degrees 1 and 2.
    pub fn rim(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Rim, 40 / h * u * v - dot(grad(u), n) * v - dot(grad(v), n) * u)
            + integral(Ghost, scalar_ghost(u, v))
    }

    /// ½ ∫ |∇u|².
    pub fn energy(u: State<Scalar>) -> Functional {
        integral(Omega, dot(grad(u), grad(u)) / 2)
    }

    /// The area of each node.
    pub fn areas(v: Test<Scalar>) -> Form {
        integral(Omega, v)
    }

    /// A force per area that is given by a field.
    pub fn known(l: State<Scalar>) -> Scalar {
        l
    }
}

/// A membrane on a mesh.
#[derive(Clone, Debug)]
pub struct Membrane {
    /// Heights.
    pub space: Arc<Space<2>>,
    /// Conditions on them.
    pub constraints: Constraints<2>,
    /// The membrane, where it is cut from the mesh.
    pub cut: Option<CutBody>,
    /// The obstacle.
    pub data: volume::Data<2>,
    /// The obstacle's height at nodes.
    pub below: Field<2>,
    /// A membrane that is above the obstacle everywhere.
    pub above: Field<2>,
    /// A typical force per area \[stress\].
    pub pressure: f64,
    /// A typical height \[length\].
    pub approach: f64,
}

impl Membrane {
    /// All cells as a region.
    pub fn omega(&self) -> volume::Omega {
        volume::Omega::on("all")
    }

    /// (∇u, ∇v), to which a formulation adds its terms.
    pub fn balance(&self) -> Form<2> {
        let inside = volume::balance(&self.data, &self.omega());
        match &self.cut {
            None => inside,
            Some(_) => {
                &inside + &volume::rim(&self.data, &volume::Rim::on("all"), &volume::Ghost::on("ghost"))
            }
        }
    }

    /// The assembler of all integrals.
    pub fn assembler(&self) -> Assembler<2> {
        let whole = || Assembler::new(self.space.mesh());
        let assembler = self.cut.as_ref().map_or_else(whole, |cut| cut.assembler.clone());
        assembler.with_quadrature(Quadrature::Degree((2 * self.space.degree() + 2).max(MEASURED)))
    }

    /// A scalar at the points of a rule on the membrane.
    fn measured(&self, scalar: &Expression<2>, rule: usize) -> Result<PointValues<2>, Refusal> {
        let assembler = Assembler::new(self.space.mesh());
        let Some(cut) = &self.cut else {
            return Ok(assembler.at_quadrature_points(scalar, Entity::Cells, "all", rule)?);
        };
        let pieces = cut.cut.body()?;
        let zero = volume::known(&self.data, Field::zero(&Space::discontinuous_scalar(pieces.mesh(), 0)?));
        let places = Assembler::new(pieces.mesh()).at_quadrature_points(&zero, Entity::Cells, "all", rule)?;
        let values = assembler.at_points(scalar, &places.positions)?.values;
        Ok(PointValues { values, ..places })
    }

    /// The problem of contact terms in u.
    pub fn problem<'a>(&'a self, contact: &Form<2>) -> Problem<'a, 2> {
        let problem = Problem::new(&(&self.balance() + contact), &self.space);
        let options = NewtonOptions { max_iterations: 100, ..crate::Case::options() };
        problem.constrained(&self.constraints).assembler(self.assembler()).options(options)
    }

    /// The problem of a whole form, balance and contact, in u and a scalar.
    pub fn mixed_problem<'a>(&'a self, form: &Form<2>, scalars: &Arc<Space<2>>) -> Problem<'a, 2, 2> {
        let problem = Problem::new(form, [&self.space, scalars]);
        let options = NewtonOptions { max_iterations: 100, ..NewtonOptions::default() };
        problem.constrained(&self.constraints).assembler(self.assembler()).options(options)
    }

    /// A force per area at points of the membrane.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn pressures(&self, force: &Expression<2>) -> Result<Pressures, Refusal> {
        Ok(self.measured(force, MEASURED)?.into())
    }

    /// A field of forces per area at points of the membrane.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn known_pressures(&self, field: &Field<2>) -> Result<Pressures, Refusal> {
        self.pressures(&volume::known(&self.data, field))
    }

    /// Forces on nodes, divided by the nodes' areas.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn pressures_of_forces(&self, forces: &[f64]) -> Result<Pressures, Refusal> {
        let weights = self.assembler().linear_form(&volume::areas(&self.data, &self.omega()), &self.space)?;
        let values = forces.iter().zip(&weights).map(|(force, area)| force / area).collect();
        Ok(Pressures { positions: self.space.positions().to_vec(), weights, values })
    }

    /// The solution of contact terms in u, with its force per area.
    ///
    /// # Errors
    /// Newton's method fails.
    pub fn newton(
        &self,
        contact: &Form<2>,
        force: impl Fn(&Field<2>) -> Expression<2>,
    ) -> Result<Outcome, Refusal> {
        let solved = self.problem(contact).start(&self.above).solve()?;
        let pressures = self.pressures(&force(solved.field()))?;
        Ok(self.outcome(&solved, pressures))
    }

    /// The outcome of one solve.
    pub fn outcome<const N: usize>(&self, solved: &Solved<2, N>, pressures: Pressures) -> Outcome {
        Outcome {
            u: solved.fields[0].clone(),
            pressures,
            forces: vec![],
            residual: solved.residual.clone(),
            form: None,
            fields: solved.fields.to_vec(),
            newton: vec![solved.iterations()],
            outer: None,
        }
    }

    /// The least height above the obstacle on a fine set of points, negative below it \[length\].
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn least_height(&self, u: &Field<2>) -> Result<f64, Refusal> {
        let heights = self.measured(&volume::height(&self.data, u), 2 * MEASURED)?;
        Ok(heights.values.iter().fold(f64::INFINITY, |least: f64, height| least.min(height[0])))
    }
}
