//! Choices that histories of loads and of motions share: observations, conditions, solver, storage; and the reduced problem that each
//! of them is.

/// Methods of a history with the members `controls`, `criterion`, `constraints`, `equations` and `storage`, and methods `begin` and `unknowns_on`.
/// Conditions are a function of a moment, which the text names; second rates have tests of the names given.
macro_rules! choices_of {
    ($history:ident, constrained_at $moment:ty, $text:literal, second_rates by $tests:expr) => {
        impl<'a, const D: usize> $history<'a, D> {
            /// Jⁿ, an energy of the state (of motions, the value) after the step, whose slope is the adjoint's load. A criterion of the last
            /// step alone has a factor that is zero in the others. Of motions it depends on no control.
            pub fn criterion(
                mut self,
                energy: impl Fn(&ControlValues<D>) -> Result<Energy<D>, ControlError> + 'a,
            ) -> Self {
                self.criterion.energy = Some(Box::new(energy));
                self
            }

            /// Observations of the value at the end of a step, numbered from 0, that add to the criterion: of the first unknown on their
            /// space.
            pub fn observed(mut self, step: usize, observations: Observations<D>) -> Self {
                self.criterion.observations.entry(step).or_default().push(observations);
                self
            }

            /// A function of only the controls that is added to the criterion, with its gradient, as a regularisation. On a part of a mesh
            /// it gets the part's values and gives the value of the whole, and the gradient by the part's values.
            pub fn with_cost_of_controls(mut self, cost: impl Fn(&[f64]) -> (f64, Vec<f64>) + 'a) -> Self {
                self.criterion.of_controls = Some(Box::new(cost));
                self
            }

            /// The second derivative of that function at m along a direction.
            pub fn with_curvature_of_controls(
                mut self,
                curvature: impl Fn(&[f64], &[f64]) -> Vec<f64> + 'a,
            ) -> Self {
                self.criterion.curvature_of_controls = Some(Box::new(curvature));
                self
            }

            /// Conditions that do not change, on one unknown: the first one on the constraints' space that has none yet.
            pub fn constrained(self, constraints: &Constraints<D>) -> Self {
                let constraints = constraints.clone();
                self.constrained_at(move |_| Ok(constraints.clone()))
            }

            #[doc = concat!("Conditions on one unknown as a function of ", $text, ".")]
            pub fn constrained_at(
                mut self,
                constraints: impl Fn($moment) -> Result<Constraints<D>, ConstraintsError> + 'a,
            ) -> Self {
                self.constraints.push(constraints);
                self
            }

            /// An assembler in place of the default one: for its quadrature, and its threads, which a linear solver of the history's own has
            /// then, too.
            pub fn assembler(mut self, assembler: &Assembler<D>) -> Self {
                self.equations.assemble_by(assembler);
                self
            }

            /// A linear solver in place of a [`TangentSolver`](crate::solve::TangentSolver), for the steps and their adjoints.
            pub fn solver(mut self, solver: &'a mut dyn LinearSolver) -> Self {
                self.equations.lend(solver);
                self
            }

            /// Steps and adjoints on several processes: each assembles the tangents of its part of the cells. The linear solver has to
            /// take matrices that are sums over the processes. All processes have the same states, on pieces of a mesh those of the piece, and
            /// the same gradients and Hessians. On pieces of a mesh those by a control that is a field have the entries of the piece.
            pub fn on(mut self, communicator: &'a dyn Communicator) -> Self {
                let is_piece = self.unknowns_on()[0].mesh().is_piece();
                self.equations.communicator = Some(communicator).filter(|all| is_piece || all.size() > 1);
                self
            }

            /// Account of the linear solver, where it keeps one.
            pub fn solver_report(&mut self) -> Option<SolverReport> {
                self.equations.solver_report()
            }

            /// Tolerances of Newton's method in each step.
            pub fn options(mut self, options: NewtonOptions) -> Self {
                self.equations.options = options;
                self
            }

            /// Largest number of stored states; the others are computed again on the way back. By default all are stored.
            pub fn stored_states(mut self, most: usize) -> Self {
                self.storage.most = most;
                self
            }

            /// Stored states are files in a directory, except for the last one, and memory holds a few states however many steps there
            /// are. The files are gone when a gradient has been computed.
            pub fn states_on_disk(mut self, directory: impl Into<std::path::PathBuf>) -> Self {
                self.storage.directory = Some(directory.into());
                self
            }

            /// J with its gradient, and the cost.
            ///
            /// # Errors
            /// [`HistoryError`], which names the step.
            #[inline(never)]
            pub fn gradient(&mut self, m: &[f64]) -> Result<Gradient, HistoryError> {
                self.begin(m).and_then(|()| self.criterion.exists()).map_err(|why| why.at(0))?;
                let storage = self.storage.clone();
                let mut found = gradient_stored(self, &storage)?;
                self.criterion.add_cost_of_controls(m, &mut found).map_err(|why| why.at(0))?;
                Ok(found)
            }

            /// J with its gradient and its Hessian applied to a direction, exact for the discrete equations where no switch of the form
            /// changes. States and their changes count as one for `stored_states`.
            ///
            /// # Errors
            /// [`HistoryError`], which names the step.
            #[inline(never)]
            pub fn hessian(&mut self, m: &[f64], direction: &[f64]) -> Result<Hessian, HistoryError> {
                self.begin(m).and_then(|()| self.criterion.exists()).map_err(|why| why.at(0))?;
                let along = self.controls.directed(direction, $tests);
                let along = along.map_err(|why| HistoryFailure::from(why).at(0))?;
                let storage = self.storage.clone();
                let found = gradient_stored(&mut Changing { history: &mut *self, along }, &storage)?;
                self.criterion.hessian(found, m, direction).map_err(|why| why.at(0))
            }
        }

        impl<const D: usize> CurvedCriterion<D> for $history<'_, D> {
            fn add_criterion(
                &self,
                step: usize,
                pair: [&[f64]; 2],
                [slope, change]: [&mut [f64]; 2],
            ) -> Result<(), HistoryFailure> {
                let [values, changes] = pair.map(|values| fields_on(&self.unknowns_on(), values));
                let (values, changes) = (values?, changes?);
                let at = ControlValues::new(&self.controls, step, None);
                self.criterion.add_slope(&at, &self.equations, &values, slope)?;
                self.criterion.add_curvature(&at, &self.equations, [&values, &changes], change)
            }
        }

        impl<const D: usize> TwiceDifferentiable for $history<'_, D> {
            fn second_order(&mut self, m: &[f64], direction: &[f64]) -> Result<SecondOrder, HistoryError> {
                Ok(self.hessian(m, direction)?.into())
            }
        }

        impl<const D: usize> ControlledEvolution<D> for $history<'_, D> {
            fn controls(&self) -> &Controls<D> {
                &self.controls
            }

            fn spaces(&self) -> Vec<&Arc<Space<D>>> {
                self.unknowns_on()
            }

            fn begin(&mut self, m: &[f64]) -> Result<(), HistoryError> {
                self.begin(m).map_err(|why| why.at(0))
            }

            fn has_criterion(&self) -> bool {
                self.criterion.exists().is_ok() || self.criterion.of_controls.is_some()
            }

            fn most_stored(&self) -> usize {
                self.storage.most
            }
        }

        impl<const D: usize> ReducedProblem for $history<'_, D> {
            type Error = HistoryError;

            fn start(&self) -> Vec<f64> {
                self.controls.values().to_vec()
            }

            fn parts(&self) -> Vec<Part> {
                self.controls.parts()
            }

            fn vectors(&mut self) -> Result<ControlVectors, HistoryError> {
                let m = self.controls.values().to_vec();
                self.begin(&m).map_err(|why| why.at(0))?;
                Ok(self.equations.control_vectors(&self.controls))
            }

            fn sample(&mut self, m: &[f64]) -> Result<Sample, HistoryError> {
                self.begin(m).and_then(|()| self.criterion.exists()).map_err(|why| why.at(0))?;
                let mut found = value_of(self)?;
                found.value[0] += self.criterion.cost_of_controls(m).map_err(|why| why.at(0))?;
                Ok(found)
            }

            fn value_and_gradient(&mut self, m: &[f64]) -> Result<(f64, Vec<f64>), HistoryError> {
                let found = self.gradient(m)?;
                Ok((found.value, found.gradient))
            }
        }
    };
}

pub(super) use choices_of;
