//! The filter of densities as a form (Lazarov and Sigmund 2011, Int. J. Numer. Methods Eng. 86), and a history of smooth densities behind it.

use std::error::Error;

use forms_fem::inverse::{HistoryError, HistoryFailure, LoadHistory, ReducedProblem};
use forms_fem::prelude::*;
use forms_fem::verification::Sample;

#[forms(dimension = 2)]
pub mod filter {
    pub struct Data {
        /// Length over which densities are smoothed.
        pub radius: Param,
        /// ρ, of each cell.
        pub density: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    #[controls(density)]
    pub fn smoothing(s: Unknown<Scalar>, w: Test<Scalar>) -> Form {
        integral(Omega, sqr(radius) * dot(grad(s), grad(w)) + (s - density) * w)
    }
}

/// The filter of a radius on a region of cells.
#[derive(Clone, Copy)]
pub struct Filter {
    /// Length over which densities are smoothed.
    pub radius: f64,
    /// The cells' name.
    pub region: &'static str,
}

impl Filter {
    /// The filter with densities ρ.
    pub fn of(&self, density: Given<f64, 2>) -> filter::Model<2> {
        let regions = filter::Regions::default().omega(self.region);
        filter::Model { data: filter::data().radius(self.radius).density(density), regions }
    }
}

/// J(ρ) = J(ρ̃(ρ)): a reduced problem of smooth densities behind the filter.
pub struct Filtered<'a> {
    behind: LoadHistory<'a, 2>,
    filter: Filter,
    smooth: Arc<Space<2>>,
    cells: Arc<Space<2>>,
    /// ρ to begin with.
    pub start: Vec<f64>,
    assembler: Assembler<2>,
    solver: TangentSolver,
}

impl<'a> Filtered<'a> {
    /// The history with the densities on `smooth` as its only control, behind the filter of ρ.
    ///
    /// # Errors
    /// Those of the filter's matrix.
    pub fn new(
        behind: LoadHistory<'a, 2>,
        filter: Filter,
        smooth: &Arc<Space<2>>,
        density: &Field<2>,
        assembler: &Assembler<2>,
    ) -> Result<Self, Box<dyn Error>> {
        let mut solver = TangentSolver::default();
        let form = filter.of(Given::constant(0.0)).smoothing();
        solver.set_matrix(assembler.tangent(&form, &[&Field::zero(smooth)], &[smooth])?)?;
        Ok(Filtered {
            behind,
            filter,
            smooth: Arc::clone(smooth),
            cells: Arc::clone(density.space()),
            start: density.values().to_vec(),
            assembler: assembler.clone(),
            solver,
        })
    }

    /// x with A x = −load, of the filter's symmetric matrix A.
    fn solve(&mut self, load: &[f64]) -> Result<Field<2>, HistoryFailure> {
        let load: Vec<f64> = load.iter().map(|load| -load).collect();
        Ok(Field::from_values(&self.smooth, self.solver.solve(&load, 0.0)?.solution)?)
    }

    /// ρ̃.
    ///
    /// # Errors
    /// Those of the assembly and of the solution.
    pub fn smoothed(&mut self, densities: &[f64]) -> Result<Field<2>, HistoryError> {
        self.try_smoothed(densities).map_err(|why| HistoryError { step: 0, why })
    }

    fn try_smoothed(&mut self, densities: &[f64]) -> Result<Field<2>, HistoryFailure> {
        let densities = Field::from_values(&self.cells, densities.to_vec())?;
        let form = self.filter.of(Given::field(&densities)).smoothing();
        let load = self.assembler.residual(&form, &[&Field::zero(&self.smooth)], &[&self.smooth])?;
        self.solve(&load)
    }

    /// The states after the steps.
    ///
    /// # Errors
    /// Those of the history.
    pub fn states(&mut self, m: &[f64]) -> Result<Vec<Field<2>>, HistoryError> {
        let smooth = self.smoothed(m)?;
        self.behind.states(smooth.values())
    }

    fn pulled_back(&mut self, smooth: &Field<2>, slope: &[f64]) -> Result<Vec<f64>, HistoryFailure> {
        let adjoint = self.solve(slope)?;
        let rates = self.filter.of(Given::constant(0.0)).smoothing_sensitivities(smooth, &adjoint);
        Ok(self.assembler.residual(&rates, &[], &[&self.cells])?)
    }
}

impl ReducedProblem for Filtered<'_> {
    type Error = HistoryError;

    fn start(&self) -> Vec<f64> {
        self.start.clone()
    }

    fn sample(&mut self, m: &[f64]) -> Result<Sample, HistoryError> {
        let smooth = self.smoothed(m)?;
        self.behind.sample(smooth.values())
    }

    fn value_and_gradient(&mut self, m: &[f64]) -> Result<(f64, Vec<f64>), HistoryError> {
        let smooth = self.smoothed(m)?;
        let (value, slope) = self.behind.value_and_gradient(smooth.values())?;
        let gradient = self.pulled_back(&smooth, &slope);
        Ok((value, gradient.map_err(|why| HistoryError { step: 0, why })?))
    }
}
