//! A membrane over an obstacle: contact in the volume, and what a formulation gets there.

use forms_fem::forms;
use forms_fem::prelude::*;

use crate::outcome::{Outcome, Pressures, Refusal};

/// The degree of quadrature at which forces and heights are measured.
const MEASURED: usize = 8;

/// A membrane of tension 1, and what contact terms are written in.
#[forms(dimension = 2)]
pub mod volume {
    /// Data of the obstacle.
    pub struct Data {
        /// φ, the obstacle's height.
        pub obstacle: Given<Scalar>,
    }

    /// The membrane.
    #[cells]
    pub struct Omega;

    /// u − φ, the height above the obstacle.
    pub fn height(w: Scalar) -> Scalar {
        w - obstacle
    }

    /// (∇u, ∇v).
    pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)))
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
        volume::balance(&self.data, &self.omega())
    }

    /// The assembler of all integrals.
    pub fn assembler(&self) -> Assembler<2> {
        Assembler::new(self.space.mesh())
            .with_quadrature(Quadrature::Degree((2 * self.space.degree() + 2).max(MEASURED)))
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
        let assembler = Assembler::new(self.space.mesh());
        Ok(assembler.at_quadrature_points(force, Entity::Cells, "all", MEASURED)?.into())
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
    pub fn least_height(&self, u: &Field<2>) -> Result<f64, AssemblyError> {
        let heights = Assembler::new(self.space.mesh()).at_quadrature_points(
            &volume::height(&self.data, u),
            Entity::Cells,
            "all",
            2 * MEASURED,
        )?;
        Ok(heights.values.iter().fold(f64::INFINITY, |least: f64, height| least.min(height[0])))
    }
}
