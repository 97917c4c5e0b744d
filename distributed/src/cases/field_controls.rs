//! A load history whose controls are fields, numbers and the first state, with observations: gradient, Hessian, and minima.

use std::error::Error;

use forms_fem::inverse::{
    Bounds, ControlError, ControlValues, Controls, Inequality, LoadHistory, Minimise, MovingAsymptotes,
    Observations, ReducedProblem, SecondOrderState, second_order_taylor_test,
};
use forms_fem::prelude::*;

use super::parts::whole;
use super::report::tell;
use crate::method::Method;
use crate::petsc_solver::PetscSolver;
use crate::world::World;

/// Steps of the history.
const STEPS: usize = 2;
/// Iterations of each minimisation.
const ITERATIONS: usize = 4;

/// Diffusion with a reaction.
#[forms(dimension = 2)]
pub mod reaction {
    pub struct Data {
        /// Logarithm of the conductivity.
        pub conductivity: Param,
        /// Source \[1/time\].
        pub load: Param,
        /// Factor of the reaction.
        pub stiffness: Given<Scalar>,
    }
    /// The body.
    #[cells]
    pub struct Omega;

    /// A step of size one.
    #[controls(conductivity, load, stiffness, order = 2)]
    pub fn step(u: Unknown<Scalar>, v: Test<Scalar>, before: State<Scalar>) -> Form {
        integral(
            Omega,
            (u - before + stiffness * pow(u, 3)) * v
                + exp(conductivity) * (1 + sqr(u) + sqr(before)) * dot(grad(u), grad(v))
                - load * (1 + x[0]) * v,
        )
    }
    /// ∫ (u − x)²/2.
    pub fn misfit(u: Unknown<Scalar>) -> Energy {
        integral(Omega, sqr(u - x[0]) / 2)
    }
}

fn model(
    at: &ControlValues<2>,
    along: Option<&ControlValues<2>>,
) -> Result<reaction::Model<2>, ControlError> {
    let data = reaction::data()
        .conductivity(at.number("conductivity")?)
        .load(at.number("load")?)
        .stiffness(&at.field("stiffness")?)
        .d_conductivity(along.map_or(Ok(0.0), |along| along.number("conductivity"))?)
        .d_load(along.map_or(Ok(0.0), |along| along.number("load"))?)
        .d_stiffness(match along {
            Some(along) => Given::field(&along.field("stiffness")?),
            None => Given::constant(0.0),
        });
    Ok(reaction::Model::new(data))
}

/// Spaces, conditions and controls on the body, or a part of it.
pub struct FieldControls {
    /// Of the state.
    pub held: Constraints<2>,
    controls: Controls<2>,
    stiffnesses: Arc<Space<2>>,
}

/// Values, or why there are none.
pub type Values = Result<Vec<f64>, Box<dyn Error>>;

/// Numbers by their names.
pub type Results = Vec<(&'static str, Vec<f64>)>;

/// Operations that differ between a whole mesh and its parts.
pub struct Means<'a> {
    /// The values of a field at the vertices of the whole mesh.
    pub whole: &'a dyn Fn(&Field<2>) -> Values,
    /// The vector of a linear form on a space.
    pub linear_form: &'a dyn Fn(&Form<2>, &Arc<Space<2>>) -> Values,
    /// The product of two fields' coefficients.
    pub product: &'a dyn Fn(&Field<2>, &Field<2>) -> f64,
}

impl FieldControls {
    /// On a mesh of the body, or a part of it. The stiffness is continuous, or per cell.
    ///
    /// # Errors
    /// A mesh without a left side.
    pub fn on(mesh: &Mesh<2>, per_cell: bool) -> Result<Self, Box<dyn Error>> {
        let space = Space::scalar(mesh, 2)?;
        let mut held = Constraints::new(&space);
        held.fix("left", |x| 0.3 * x[1])?;
        let stiffnesses =
            if per_cell { Space::discontinuous_scalar(mesh, 0)? } else { Space::scalar(mesh, 1)? };
        let controls = Self::values(&space, &stiffnesses, 1.0)?;
        Ok(FieldControls { held, controls, stiffnesses })
    }

    /// Controls by a number; those at 1 are the first ones.
    fn values(
        space: &Arc<Space<2>>,
        stiffnesses: &Arc<Space<2>>,
        t: f64,
    ) -> Result<Controls<2>, Box<dyn Error>> {
        let stiffness = Field::interpolate(stiffnesses, |x| 1.0 + (t * x[0]).sin() + 0.2 * x[1])?;
        let start = Field::interpolate(space, |x| t * (0.2 * x[0] + 0.3 * x[1]))?;
        let loads: Vec<f64> = (0..STEPS).map(|step| 0.5 * t + 0.1 * step as f64).collect();
        let controls = Controls::new().number("conductivity", -t).per_step("load", &loads);
        Ok(controls.field("stiffness", &stiffness).start("start", &start))
    }

    /// The history.
    ///
    /// # Errors
    /// Observations that do not fit.
    pub fn history<'a>(&self) -> Result<LoadHistory<'a, 2>, Box<dyn Error>> {
        let space = self.held.space();
        // A point in a cell, one on the line along which two processes divide the body, and all nodes.
        let at_points = Observations::new(space).at_point(&[0.7, 0.4], &[0.1], 2.0)?.at_point(
            &[1.0, 0.5],
            &[0.2],
            1.0,
        )?;
        let measured = Field::interpolate(space, |x| 0.1 * x[0])?;
        let at_nodes = Observations::new(space).at_nodes(&measured, 0.01)?;
        Ok(LoadHistory::new(space, STEPS, self.controls.clone())
            .assembler(&Assembler::new(space.mesh()).with_threads(Threads::new(1)))
            .step(|at| Ok(model(at, None)?.step(at.before()?)))
            .sensitivities(|at, u, p| Ok(model(at, None)?.step_sensitivities(u, at.before()?, p)))
            .second_sensitivities(|at, states: &SecondOrderState<2>| {
                let &SecondOrderState { u, p, du, dbefore, dp, along } = states;
                Ok(model(at, Some(&along))?.step_second_sensitivities(u, at.before()?, p, du, dbefore, dp))
            })
            .criterion(|at| Ok(model(at, None)?.misfit()))
            .observed(1, at_points)
            .observed(STEPS - 1, at_nodes)
            .constrained(&self.held))
    }

    /// The numbers, and the values at the vertices of the fields, in a vector of controls.
    fn read(
        &self,
        names: [&'static str; 3],
        m: &[f64],
        means: &Means<'_>,
    ) -> Result<Results, Box<dyn Error>> {
        let (numbers, fields) = m.split_at(1 + STEPS);
        let (stiffness, start) = fields.split_at(self.stiffnesses.unknowns());
        let field = |space: &Arc<Space<2>>, values: &[f64]| Field::from_values(space, values.to_vec());
        let mut found =
            vec![(names[0], numbers.to_vec()), (names[2], (means.whole)(&field(self.held.space(), start)?)?)];
        if self.stiffnesses.degree() > 0 {
            found.push((names[1], (means.whole)(&field(&self.stiffnesses, stiffness)?)?));
        } else {
            let stiffness = field(&self.stiffnesses, stiffness)?;
            let weight = Field::interpolate(&self.stiffnesses, |x| (1.0 + x[0]).sqrt() + x[1])?;
            found.push((names[1], vec![(means.product)(&stiffness, &weight)]));
        }
        Ok(found)
    }

    /// Value, gradient and Hessian.
    ///
    /// # Errors
    /// Those of the history.
    pub fn derivatives(
        &self,
        history: &mut LoadHistory<'_, 2>,
        means: &Means<'_>,
    ) -> Result<Results, Box<dyn Error>> {
        let (m, d) = (self.controls.values(), Self::values(self.held.space(), &self.stiffnesses, 0.7)?);
        let found = history.hessian(m, d.values())?;
        let mut results = vec![("value", vec![found.value])];
        results.extend(self.read(["by_numbers", "by_stiffness", "by_start"], &found.gradient, means)?);
        let names = ["along_numbers", "along_stiffness", "along_start"];
        results.extend(self.read(names, &found.along, means)?);
        Ok(results)
    }

    /// The order of a Taylor test with the Hessian.
    ///
    /// # Errors
    /// Those of the history.
    pub fn order(&self, history: &mut LoadHistory<'_, 2>) -> Result<f64, Box<dyn Error>> {
        let (m, d) = (self.controls.values(), Self::values(self.held.space(), &self.stiffnesses, 0.7)?);
        let [_, third] = second_order_taylor_test(history, m, d.values(), 0.1)?;
        Ok(third.third_order().unwrap_or(f64::NAN))
    }

    /// Controls with the history of their value after some iterations: between bounds, and with a bound on the integral of the stiffness.
    ///
    /// # Errors
    /// Those of the history.
    pub fn minima(
        &self,
        history: &mut LoadHistory<'_, 2>,
        means: &Means<'_>,
    ) -> Result<Results, Box<dyn Error>> {
        let (m, mut results) = (self.controls.values(), vec![]);
        let bounds = Bounds::between(m.len(), -1.5, 1.6);
        let options = Minimise { max_iterations: ITERATIONS, ..Minimise::default() };
        let minimum = options.run(history, &bounds, |_| ())?;
        results.push(("values", minimum.history.iter().map(|step| step.value).collect()));
        results.push(("criticalities", minimum.history.iter().map(|step| step.criticality).collect()));
        let names = ["least_numbers", "least_stiffness", "least_start"];
        results.extend(self.read(names, &minimum.controls, means)?);

        // g = 1 − ∫ stiffness / 3: the stiffness stays above a mean.
        let total: Form<2> = form!(|q: Test<Scalar>| integral(cells("all"), q));
        let weights = (means.linear_form)(&total, &self.stiffnesses)?;
        let weights = Field::from_values(&self.stiffnesses, weights)?;
        let at = self.controls.places("stiffness")?;
        let least: Box<Inequality<'_, _>> = Box::new(move |m: &[f64]| {
            let mut gradient = vec![0.0; m.len()];
            gradient[at.clone()]
                .iter_mut()
                .zip(weights.values())
                .for_each(|(slope, weight)| *slope = -weight / 3.0);
            let stiffness = Field::from_values(weights.space(), m[at.clone()].to_vec());
            let integral = stiffness.map_or(f64::NAN, |stiffness| (means.product)(&weights, &stiffness));
            Ok((1.0 - integral / 3.0, gradient))
        });
        let options = MovingAsymptotes { max_iterations: ITERATIONS, ..MovingAsymptotes::default() };
        let minimum = options.run(history, &bounds, &mut [least], |_| ())?;
        results.push(("constrained_values", minimum.history.iter().map(|step| step.value).collect()));
        results.push(("constraints", minimum.history.iter().map(|step| step.constraints[0]).collect()));
        let names = ["constrained_numbers", "constrained_stiffness", "constrained_start"];
        results.extend(self.read(names, &minimum.controls, means)?);
        Ok(results)
    }
}

/// Upper corner and numbers of cells of the body.
pub const SIZE: ([f64; 2], [usize; 2]) = ([2.0, 1.0], [6, 4]);

/// Tells results on parts: "fields" derivatives, "cell fields" those by a stiffness per cell, "minima" iterates, "order" a Taylor test.
///
/// # Errors
/// Those of the history; "far" observes a point outside of the body.
pub fn run(world: &World, name: &str) -> Result<(), Box<dyn Error>> {
    let (upper, cells) = SIZE;
    let part = world.rectangle([0.0; 2], upper, cells, CellShape::Triangle, 1)?;
    let case = FieldControls::on(&part, name == "cell fields")?;
    let mut solver = PetscSolver::for_part(&part, &[&case.held], Method::Direct)?;
    let mut history = case.history()?.on(&part).solver(&mut solver);
    if name == "far" {
        let far = Observations::new(case.held.space()).at_point(&[2.5, 0.5], &[0.0], 1.0)?;
        return Ok(history.observed(0, far).value(case.controls.values()).map(drop)?);
    }
    let assembler = Assembler::new(&part).with_threads(Threads::new(1));
    let means = Means {
        whole: &|field| whole(&part, field),
        linear_form: &|form, space| Ok(part.linear_form(&assembler, form, space)?),
        product: &|a, b| part.dot(a, b).unwrap_or(f64::NAN),
    };
    let results = match name {
        "minima" => case.minima(&mut history, &means)?,
        "order" => vec![("order", vec![case.order(&mut history)?])],
        _ => case.derivatives(&mut history, &means)?,
    };
    results.iter().for_each(|(name, numbers)| tell(world, name, numbers));
    Ok(())
}
