//! Histories and motions with contact pairs of the drawn block: load steps that slide with friction, a block that is thrown on the slab, means
//! over own facets, and a motion with springs between the surfaces.

use std::error::Error;

use forms_contact::ContactProblem;
use forms_contact::laws::{mean_sliding_bodies as means, two_bodies};
use forms_fem::inverse::{
    ControlError, ControlValues, Controls, LoadHistory, MotionHistory, ReducedProblem, SecondOrderMotion,
    StepContext,
};
use forms_fem::prelude::*;
use forms_fem::time::{GeneralisedAlpha, State, Step, TimeLoop};

use super::divided_contact::{drawn_pairs, of_name};
use super::drawn_block::{DrawnBlock, Law, SURFACES};
use super::parts::whole;
use super::report::tell;
use crate::Method;
use crate::part::PartCheckpoint;
use crate::petsc_solver::PetscSolver;
use crate::world::World;

/// Large sliding with friction by Nitsche's method, with a criterion that reads both bodies where they touch.
#[forms(dimension = 2)]
pub mod drawn {
    pub use forms_contact::laws::sliding_bodies::{
        Data, GammaN, Omega, Touch, contact_pressure, direct, first_piola, loads,
    };

    /// ∫ |u|²/2, and of the pairs the pressure, the gap and the jump of µ u.
    pub fn criterion(u: Unknown<Vector>) -> Energy {
        let across = jump(mu * u);
        integral(Omega, dot(u, u) / 2)
            + integral(Touch(u), share * (sqr(contact_pressure(u)) / 500 + gap + dot(across, across) / 500))
    }
    /// Rates of a step.
    pub fn sensitivities(
        u: State<Vector>,
        p: State<Vector>,
        by_before: Test<Vector>,
        by_friction: Test<Scalar>,
        by_shear_modulus: Test<Scalar>,
        by_load: Test<Scalar>,
    ) -> Form {
        let work = direct(u, p);
        derivative(work, displacement_before, by_before)
            + derivative(work, friction, this(by_friction))
            + derivative(work + criterion(u), mu, by_shear_modulus)
            + derivative(work, traction, by_load * [1, -0.4])
    }
}

/// Inertia and contact with friction at large sliding.
#[forms(dimension = 2)]
pub mod thrown {
    use forms_contact::laws::sliding_bodies::direct;
    pub use forms_contact::laws::sliding_bodies::{GammaN, Omega, Touch};
    use forms_fem::time::operators::vector::acceleration;

    #[includes(forms_fem::time::operators::vector::Data, forms_contact::laws::two_bodies::Data)]
    pub struct Data {
        /// Mass per volume.
        pub density: Param,
    }

    /// Balance of forces.
    pub fn motion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, density * dot(acceleration(u), v)) + direct(u, v)
    }
}

/// Elastic bodies that fall, with springs between their surfaces where they touch.
#[forms(dimension = 2)]
pub mod sprung {
    use forms_fem::time::operators::vector::{acceleration, displacement, velocity};

    #[includes(forms_fem::time::operators::vector::Data)]
    pub struct Data {
        /// Mass per volume.
        pub density: Param,
        /// Force per volume, down.
        pub weight: Param,
    }
    /// Both bodies.
    #[cells]
    pub struct Omega;
    /// Their surfaces.
    #[pairs]
    pub struct Touch;

    /// Balance of forces.
    #[controls(density, weight, motion(value, rate, second_rate), order = 2)]
    pub fn motion(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let w = displacement(u);
        let depth = pos_part(dot(jump(w), toward) - gap);
        integral(Omega, density * dot(acceleration(u), v) + weight * v[1])
            + integral(Omega, 0.3 * dot(velocity(u), v) + 9 * inner(eps(w), eps(v)))
            + integral(Touch, (40 * depth + 2000 * sqr(depth)) * dot(jump(v), toward))
    }
    /// ∫ |u|² and of the pairs the square of how they come closer.
    pub fn misfit(u: Unknown<Vector>) -> Energy {
        integral(Omega, dot(u, u)) + integral(Touch, sqr(dot(jump(u), toward)))
    }
}

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Parts of the block's way in load steps: it is pressed, and slides over four cells of the slab.
const WAY: [f64; 4] = [0.5, 0.65, 0.8, 0.95];

/// Load steps with friction, a modulus and the load of each step as controls. The criterion reads a field of the modulus where one is given.
///
/// # Errors
/// Regions that do not exist.
pub fn slid<'a>(block: &'a DrawnBlock, stiffness: Option<Field<2>>) -> Outcome<LoadHistory<'a, 2>> {
    let held = WAY.iter().map(|part| block.held(*part)).collect::<Outcome<Vec<_>>>()?;
    let model = |at: &ControlValues<2>, before: Given<[f64; 2], 2>, mu: Option<&Field<2>>| {
        let (load, modulus) = (at.number("load")?, at.number("shear_modulus")?);
        let data = two_bodies::data()
            .lambda(15.0)
            .mu(mu.map_or(Given::constant(modulus), Given::field))
            .gamma0(300.0)
            .friction(at.number("friction")?)
            .traction([load, -0.4 * load])
            .displacement_before(before);
        let regions = drawn::Regions::default().touch(drawn_pairs("")).gamma_n("block right");
        Ok::<_, ControlError>(drawn::Model { data, regions })
    };
    let controls = Controls::new().number("friction", 0.3).number("shear_modulus", 10.0);
    let options = NewtonOptions {
        relative_tolerance: 1e-12,
        line_search: LineSearch::OnResidual,
        ..NewtonOptions::default()
    };
    Ok(LoadHistory::new(block.space(), WAY.len(), controls.per_step("load", &[0.1, 0.3, -0.2, 0.2]))
        .step(move |at| Ok(model(at, Given::field(at.before()?), None)?.direct()))
        .sensitivities(move |at, u, p| Ok(model(at, Given::field(at.before()?), None)?.sensitivities(u, p)))
        .criterion(move |at| Ok(model(at, Given::constant([0.0; 2]), stiffness.as_ref())?.criterion()))
        .assembler(block.assembler())
        .constrained_at(move |step| Ok(held[step].clone()))
        .options(options))
}

/// Whether points do the same in a second run, and other things with larger controls: 1 if so.
///
/// # Errors
/// A step that was not solved.
pub fn switches(history: &mut LoadHistory<'_, 2>) -> Outcome<[f64; 2]> {
    let m = history.start();
    let larger: Vec<f64> = m.iter().map(|m| 1.05 * m).collect();
    let [here, again, there] = [&m, &m, &larger].map(|m| history.sample(m));
    let (here, again, there) = (here?.active_set, again?.active_set, there?.active_set);
    Ok([f64::from(here == again), f64::from(here != there)])
}

/// A stiffness of each cell; copies of cells are in no region.
fn stiffness_of_cells(mesh: &Mesh<2>) -> Outcome<Field<2>> {
    let mut stiffness = vec![10.0; mesh.cell_count()];
    mesh.cell_region("block")?.iter().for_each(|cell| stiffness[*cell as usize] = 12.0);
    Ok(Field::from_cell_values(&Space::discontinuous_scalar(mesh, 0)?, &stiffness)?)
}

/// The size of a step of the thrown block.
pub const STEP: f64 = 0.01;
/// Its steps: it touches in the third, slides, and leaves the slab.
pub const STEPS: usize = 16;

/// The slab held, and the block free.
///
/// # Errors
/// Regions that do not exist.
pub fn slab_held(block: &DrawnBlock) -> Outcome<Constraints<2>> {
    let mut held = Constraints::new(block.space());
    held.join_hanging_nodes()?;
    held.fix("slab bottom", |_| [0.0; 2])?;
    Ok(held)
}

/// The block that is thrown on the slab.
///
/// # Errors
/// Regions that do not exist.
pub fn thrown_block<'a>(block: &DrawnBlock) -> Outcome<TimeLoop<'a, 2>> {
    let space = block.space();
    let velocity = Field::interpolate(space, |x| if x[1] > 0.605 { [2.0, -0.4] } else { [0.0; 2] })?;
    let start = State { rate: velocity, ..State::at_rest(0.0, Field::zero(space)) };
    let form = |step: &Step<2>| {
        let data = thrown::data_from(step).lambda(15.0).mu(10.0).gamma0(300.0).density(0.05);
        let data = data.friction(0.3).displacement_before(&step.before.value);
        let regions = thrown::Regions::default().touch(drawn_pairs("")).gamma_n("block right");
        thrown::Model { data, regions }.motion()
    };
    let motion = TimeLoop::new(form, GeneralisedAlpha::mid_point(), start);
    Ok(motion.assembler(block.assembler()).constrained(&slab_held(block)?))
}

fn sprung_model(
    during: &StepContext<2>,
    states: Option<&SecondOrderMotion<2>>,
) -> Result<sprung::Model<2>, ControlError> {
    let along = states.map(|states| states.along);
    let data = sprung::data_from(during)
        .density(during.number("density")?)
        .weight(during.number("weight")?)
        .d_density(along.map_or(Ok(0.0), |along| along.number("density"))?)
        .d_weight(along.map_or(Ok(0.0), |along| along.number("weight"))?);
    Ok(sprung::Model { data, regions: sprung::Regions::default().touch(drawn_pairs("")) })
}

/// The block that falls on springs, with its controls.
///
/// # Errors
/// Regions that do not exist.
pub fn fallen<'a>(block: &DrawnBlock) -> Outcome<(MotionHistory<'a, 2>, [f64; 2])> {
    let m = [1.3, 0.5];
    let nothing = forms_fem::time::operators::vector::Data::default();
    let data = sprung::data_from(nothing).density(0.0).weight(0.0).d_density(0.0).d_weight(0.0);
    let of_misfit = sprung::Model { data, regions: sprung::Regions::default().touch(drawn_pairs("")) };
    let controls = Controls::new().number("density", m[0]).number("weight", m[1]);
    let history = MotionHistory::new(block.space(), (5, 0.1), GeneralisedAlpha::trapezoidal(), controls)
        .assembler(block.assembler())
        .motion(|during| Ok(sprung_model(during, None)?.motion()))
        .sensitivities(|during, u, p| Ok(sprung_model(during, None)?.motion_sensitivities(u, p)))
        .second_sensitivities(|during, states| {
            let &SecondOrderMotion { u, p, changes: [dvalue, drate, dsecond], dp, .. } = states;
            let model = sprung_model(during, Some(states))?;
            Ok(model.motion_second_sensitivities(u, p, dvalue, drate, dsecond, dp))
        })
        .criterion(move |_| Ok(of_misfit.misfit()))
        .constrained(&slab_held(block)?);
    Ok((history, m))
}

/// The law with a mean for each vertex of own facets.
pub type Means = means::mean_sliding_bodies_of_degree_two::Model<2>;

/// A load step of the drawn block by means for each vertex of own facets.
pub fn by_means(problem: &ContactProblem<2, Law>, touch: Pairing) -> ContactProblem<2, Means> {
    let regions = means::mean_sliding_bodies_of_degree_two::Regions::default().touch(touch);
    let law = Means { data: problem.law.data.clone(), regions: regions.gamma_n("block right") };
    let all = ContactProblem::new(&problem.space, law, problem.constraints.clone());
    all.assembler(problem.assembler.clone())
}

/// One of these on the processes that started this; with "trees" at the end of its name on a mesh in which nodes hang.
///
/// # Errors
/// One of a process.
pub fn run(world: &World, name: &str, path: Option<&str>) -> Outcome<()> {
    let (name, mesh) = of_name(name)?;
    let part = world.divide(&mesh)?.with_surfaces(&SURFACES)?;
    let block = DrawnBlock::on(&part, drawn_pairs(name))?;
    let held = if ["thrown", "sprung"].contains(&name) { slab_held(&block)? } else { block.held(1.0)? };
    let mut solver = PetscSolver::for_part(&part, &[&held], Method::Direct)?;
    match name {
        "thrown" => {
            let mut motion = thrown_block(&block)?.on(&part).solver(&mut solver);
            let stored = path.map(|path| PartCheckpoint::read(&part, path)).transpose()?.flatten();
            if let Some(stored) = &stored {
                motion = motion.resumed(stored.motion(&[block.space()])?);
            }
            let last = if path.is_some() && stored.is_none() { STEPS / 2 } else { STEPS };
            while motion.steps() < last {
                motion.take(STEP)?;
            }
            if let (Some(path), None) = (path, &stored) {
                PartCheckpoint::new(&part).motion(&motion.checkpoint())?.write(path)?;
            }
            tell(world, "value", &whole(&part, &motion.state().value)?);
            tell(world, "rate", &whole(&part, &motion.state().rate)?);
        }
        "sprung" => {
            let (history, m) = fallen(&block)?;
            let found = history.on(&part).solver(&mut solver).hessian(&m, &[0.3, -0.7])?;
            tell(world, "value", &[found.value]);
            tell(world, "gradient", &found.gradient);
            tell(world, "along", &found.along);
        }
        "means" | "means on segments" => {
            let mut force = f64::NAN;
            let path = block.draw(|at_points, step| {
                let problem = by_means(at_points, drawn_pairs(name));
                let solved = problem.direct()?.on(&part).solver(&mut solver).increment(step).solve()?;
                let law = by_means(at_points, drawn_pairs("one sided")).law;
                force = part.functional(block.assembler(), &law.contact_force(solved.field()))?;
                Ok(solved)
            })?;
            tell(world, "u", &whole(&part, &path.state)?);
            tell(world, "force", &[force]);
        }
        _ => {
            let stiffness = if name == "slid" { None } else { Some(stiffness_of_cells(&part)?) };
            let mut history = slid(&block, stiffness)?.on(&part).solver(&mut solver);
            let m = history.start();
            let found = history.gradient(&m)?;
            tell(world, "value", &[found.value]);
            tell(world, "gradient", &found.gradient);
            tell(world, "u", &whole(&part, &history.states(&m)?[WAY.len() - 1])?);
            tell(world, "switches", &switches(&mut history)?);
        }
    }
    Ok(())
}
