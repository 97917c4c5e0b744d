//! A block of rubber that is pressed on a slab and drawn along it with Coulomb's friction, on moving segments: with multipliers on the own
//! facets, or with means over them.

use std::error::Error;

use forms_contact::laws::mean_sliding_bodies;
use forms_contact::laws::mortar_bodies::mortar_bodies_with_friction as mortar;
use forms_contact::laws::mortar_bodies::{data, frictional_mortar_problem};
use forms_fem::constraints::ConstraintsError;
use forms_fem::contract::PairQuadrature;
use forms_fem::inverse::{ControlError, ControlValues, Controls, LoadHistory};
use forms_fem::prelude::*;

use crate::{Method, PetscSolver, World};

/// Load steps: the first presses, the others draw.
const STEPS: usize = 4;
/// The way of the block's top in each step after the first.
const WAY: f64 = 0.13;
/// The way of the block's top down.
const DOWN: f64 = 0.03;
/// Friction between both bodies.
const FRICTION: f64 = 0.3;

/// The processes and the method that solve, where it is not this process with its own solver.
pub type On<'a> = Option<(&'a World, Method)>;

/// Steps with a criterion, and its derivatives by what a step reads.
#[forms(dimension = 2)]
mod drawn {
    pub use forms_contact::laws::mortar_bodies::mortar_bodies_with_friction::{
        Data, GammaN, Omega, Own, Touch, direct,
    };

    pub fn criterion(u: Unknown<Vector>) -> Energy {
        integral(Omega, dot(u, u) / 2 + dot(criterion_force, u))
    }

    pub fn sensitivities(
        u: State<Vector>,
        m: State<Vector>,
        d: State<Vector>,
        z: State<Vector>,
        y: State<Vector>,
        w: State<Vector>,
        by_before_u: Test<Vector>,
        by_friction: Test<Scalar>,
    ) -> Form {
        let work = direct(u, m, d, z, y, w);
        derivative(work, displacement_before, by_before_u) + derivative(work, friction, by_friction)
    }
}

/// The state after the last step.
pub struct Drawn {
    /// Displacement, and with multipliers the multipliers and the means.
    pub fields: Vec<Field<2>>,
    /// Newton's steps of each load step.
    pub steps: Vec<f64>,
    /// Iterations of each linear system.
    pub iterations: Vec<f64>,
    /// The force of the slab on the block along the way.
    pub force: f64,
}

/// Both bodies. The own surface is the block's bottom, or the slab's top, whose facets the block covers in part.
pub struct MortarBlock {
    space: Arc<Space<2>>,
    assembler: Assembler<2>,
    surfaces: [&'static str; 2],
    /// Nothing else determines multipliers that nothing faces.
    uncovered: f64,
}

impl MortarBlock {
    /// With a displacement of a degree on a number of cells along the block's side.
    ///
    /// # Errors
    /// Too many cells, or none.
    pub fn new(cells: usize, degree: usize, is_on_slab: bool) -> Result<Self, Box<dyn Error>> {
        let shape = CellShape::Quadrilateral;
        let slab = rectangle([0.0; 2], [3.0, 0.6], [3 * cells + 1, cells.div_ceil(2)], shape, 1)?;
        let block = rectangle([0.3, 0.6], [1.3, 1.2], [cells, cells.div_ceil(2)], shape, 1)?;
        let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)])?;
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(2 * degree + 1));
        let (surfaces, uncovered) = match is_on_slab {
            true => (["slab top", "block bottom"], 1e-15),
            false => (["block bottom", "slab top"], 1e-18),
        };
        let space = Space::vector(&mesh, degree)?;
        Ok(MortarBlock { space, assembler: assembler.with_threads(Threads::new(1)), surfaces, uncovered })
    }

    /// With the displacement's degree that goes with multipliers of a name.
    ///
    /// # Errors
    /// As [`MortarBlock::new`].
    pub fn of(name: &str, cells: usize, is_on_slab: bool) -> Result<Self, Box<dyn Error>> {
        Self::new(cells, if name.contains("bernstein") { 2 } else { 1 }, is_on_slab)
    }

    /// All steps with multipliers of a name, or with `means`.
    ///
    /// # Errors
    /// A step that was not solved; another name.
    pub fn drawn(&self, name: &str, on: On<'_>) -> Result<Drawn, Box<dyn Error>> {
        match name {
            "means" => self.by_means(on),
            _ => self.by_multipliers(&self.multipliers(name)?, on),
        }
    }

    /// The space of multipliers of a name: `hats`, `bernstein` of degree 2, `dual` and `dual_of_bernstein`.
    ///
    /// # Errors
    /// Another name.
    pub fn multipliers(&self, name: &str) -> Result<Arc<Space<2>>, Box<dyn Error>> {
        let elements = match name {
            "hats" => Elements::Bernstein(1),
            "bernstein" => Elements::Bernstein(2),
            "dual" => Elements::Dual,
            "dual_of_bernstein" => Elements::DualOfBernstein,
            _ => return Err(format!("no multipliers are called {name}").into()),
        };
        Ok(Space::of(self.space.mesh(), elements, Scope::Facets(self.surfaces[0].into()), &[2])?)
    }

    /// The slab held, the block's top where a step moves it.
    ///
    /// # Errors
    /// Regions that do not exist.
    pub fn held(&self, step: usize) -> Result<Constraints<2>, ConstraintsError> {
        let mut held = Constraints::new(&self.space);
        held.fix("slab bottom", |_| [0.0; 2])?;
        held.fix("block top", |_| [step as f64 * WAY, -DOWN])?;
        Ok(held)
    }

    fn touch(&self) -> Pairing {
        let [own, opposite] = self.surfaces;
        Pairing::onto(own, opposite).at(PairQuadrature::Pieces)
    }

    /// All steps with multipliers.
    ///
    /// # Errors
    /// A step that was not solved.
    pub fn by_multipliers(&self, traces: &Arc<Space<2>>, on: On<'_>) -> Result<Drawn, Box<dyn Error>> {
        let model = |before: &Field<2>| {
            let data =
                data().lambda(15.0).mu(10.0).gamma0(300.0).friction(FRICTION).uncovered(self.uncovered);
            let data = data.displacement_before(Given::field(before)).force_direction([1.0, 0.0]);
            let regions =
                mortar::Regions::default().touch(self.touch()).own(self.surfaces[0]).gamma_n("block right");
            mortar::Model { data, regions }
        };
        // A pressure where the block is.
        let pressed = |x: &[f64; 2]| [if (0.3..=1.3).contains(&x[0]) { 1.0 } else { 0.0 }, 0.0];
        let pressed = traces.positions().iter().flat_map(pressed).collect();
        let mut fields =
            [Field::zero(&self.space), Field::from_values(traces, pressed)?, Field::zero(traces)];
        let (mut steps, mut iterations, mut force) = (vec![], vec![], 0.0);
        for step in 0..STEPS {
            let held = self.held(step)?;
            let free = Constraints::new(traces);
            let mut solver = self.solver(on, &[&held, &free, &free])?;
            let model = model(&fields[0]);
            let problem = frictional_mortar_problem(&model, [&self.space, traces], &held)?;
            let problem = problem.assembler(&self.assembler).start(fields.each_ref());
            let solved = match (on, &mut solver) {
                (Some((world, _)), Some(solver)) => problem.on(world).solver(solver).solve()?,
                _ => { problem }.solve()?,
            };
            steps.push(solved.iterations() as f64);
            iterations
                .extend(solver.iter().flat_map(|one| &one.report().iterations).map(|count| *count as f64));
            fields = solved.fields;
            force = self.assembler.functional(&model.contact_force(&fields[0], &fields[1]))?;
        }
        Ok(Drawn { fields: fields.into(), steps, iterations, force })
    }

    /// All steps by Nitsche's method with means over the own facets.
    ///
    /// # Errors
    /// A step that was not solved.
    pub fn by_means(&self, on: On<'_>) -> Result<Drawn, Box<dyn Error>> {
        let (mut u, mut force) = (Field::zero(&self.space), 0.0);
        let (mut steps, mut iterations) = (vec![], vec![]);
        for step in 0..STEPS {
            let held = self.held(step)?;
            let mut solver = self.solver(on, &[&held])?;
            let data = mean_sliding_bodies::data().lambda(15.0).mu(10.0).gamma0(300.0).friction(FRICTION);
            let data = data.displacement_before(Given::field(&u)).force_direction([1.0, 0.0]).share(1.0);
            let regions = mean_sliding_bodies::Regions::default().touch(self.touch()).gamma_n("block right");
            let model = mean_sliding_bodies::Model { data, regions };
            let form = model.direct();
            let options = NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
            let problem = Problem::new(&form, &self.space).constrained(&held).options(options);
            let problem = problem.assembler(&self.assembler).start(&u);
            let solved = match (on, &mut solver) {
                (Some((world, _)), Some(solver)) => problem.on(world).solver(solver).solve()?,
                _ => { problem }.solve()?,
            };
            steps.push(solved.iterations() as f64);
            iterations
                .extend(solver.iter().flat_map(|one| &one.report().iterations).map(|count| *count as f64));
            u = solved.into_field();
            force = self.assembler.functional(&model.contact_force(&u))?;
        }
        Ok(Drawn { fields: vec![u], steps, iterations, force })
    }

    fn solver<'w>(
        &self,
        on: On<'w>,
        constraints: &[&Constraints<2>],
    ) -> Result<Option<PetscSolver<'w>>, Box<dyn Error>> {
        let Some((world, method)) = on else { return Ok(None) };
        Ok(Some(PetscSolver::coupled(world, constraints, method)?.with_options_prefix("block_")?))
    }

    /// The history of all steps, with the coefficient of friction as the control.
    pub fn history<'a>(&'a self, traces: &'a Arc<Space<2>>) -> LoadHistory<'a, 2> {
        let model = |at: &ControlValues<2>, before: Given<[f64; 2], 2>| {
            let data = data().lambda(15.0).mu(10.0).gamma0(300.0).uncovered(self.uncovered);
            let data = data.friction(at.number("friction")?).displacement_before(before);
            let data = data.criterion_force(|x: &[f64; 2]| [0.3 + x[0], 0.5 * x[1]]);
            let regions =
                drawn::Regions::default().touch(self.touch()).own(self.surfaces[0]).gamma_n("block right");
            Ok::<_, ControlError>(drawn::Model { data, regions })
        };
        let options = NewtonOptions {
            relative_tolerance: 1e-12,
            line_search: LineSearch::OnResidual,
            ..NewtonOptions::default()
        };
        let controls = Controls::new().number("friction", FRICTION);
        LoadHistory::new([&self.space, traces, traces], STEPS, controls)
            .step(move |at| Ok(model(at, Given::field(at.before()?))?.direct()))
            .coupled_sensitivities(move |at, states, adjoints| {
                let ([u, m, d], [z, y, w]) = (states, adjoints) else { unreachable!("three unknowns") };
                Ok(model(at, Given::field(at.before()?))?.sensitivities(u, m, d, z, y, w))
            })
            .criterion(move |at| Ok(model(at, Given::constant([0.0; 2]))?.criterion()))
            .assembler(&self.assembler)
            .constrained_at(|step| self.held(step))
            .options(options)
    }
}
