//! Half a ring of rubber on its rigid flat: mesh, elements, load steps.

use std::error::Error;
use std::f64::consts::PI;

use forms_contact::laws::averaged_nitsche;
use forms_contact::laws::mixed_nitsche::{self, mixed_nitsche as law};
use forms_fem::linear_algebra::Counts;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;
use forms_fem::space::SpaceError;

use crate::forms::displacement;

/// Radii \[mm\].
pub const INSIDE: f64 = 20.0;
pub const OUTSIDE: f64 = 40.0;
/// E \[MPa\] and ν.
const YOUNG: f64 = 1.4;
const POISSON: f64 = 0.4995;
/// μ and K \[MPa\].
pub const MU: f64 = YOUNG / (2.0 * (1.0 + POISSON));
pub const BULK: f64 = YOUNG / (3.0 * (1.0 - 2.0 * POISSON));

/// Most secants on the way to the given force.
const SECANTS: usize = 12;

/// An element for nearly incompressible bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formulation {
    /// Q2/P₋₁, u and p.
    Quadratic,
    /// P2/P1, u and p.
    TaylorHood,
    /// P1 with bubbles and P1, u and p.
    Mini,
    /// Q1, F-bar, u and one p per cell.
    Averaged,
    /// Q1/P0/P0, u, p and j: the mean dilatation.
    MeanDilatation,
    /// Q1, F-bar, u only.
    AveragedAlone,
    /// P2, u only.
    Displacement,
}

impl Formulation {
    pub const ALL: [Formulation; 7] = [
        Formulation::Quadratic,
        Formulation::TaylorHood,
        Formulation::Mini,
        Formulation::Averaged,
        Formulation::MeanDilatation,
        Formulation::AveragedAlone,
        Formulation::Displacement,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Formulation::Quadratic => "Q2/P-1",
            Formulation::TaylorHood => "P2/P1",
            Formulation::Mini => "MINI",
            Formulation::Averaged => "F-bar Q1",
            Formulation::MeanDilatation => "mean dilatation Q1",
            Formulation::AveragedAlone => "F-bar Q1, u only",
            Formulation::Displacement => "P2, u only",
        }
    }

    /// In u only: slow ones that are for comparison on the first mesh.
    pub fn on_one_mesh(self) -> bool {
        matches!(self, Formulation::AveragedAlone | Formulation::Displacement)
    }

    /// In u only whole steps go too far, as K multiplies the error of J.
    fn options(self) -> NewtonOptions {
        let line_search = if self.on_one_mesh() { LineSearch::OnResidual } else { LineSearch::Off };
        NewtonOptions { line_search, ..NewtonOptions::default() }
    }

    /// Degree 1, with twice as many cells along.
    fn is_linear(self) -> bool {
        !matches!(self, Formulation::Quadratic | Formulation::TaylorHood | Formulation::Displacement)
    }

    fn shape(self) -> CellShape {
        match self {
            Formulation::TaylorHood | Formulation::Mini | Formulation::Displacement => CellShape::Triangle,
            _ => CellShape::Quadrilateral,
        }
    }

    /// The number of cells along the half ring on a level, with about as many unknowns for degree 1 as for degree 2.
    fn along(self, along: usize) -> usize {
        if self.is_linear() { 2 * along } else { along }
    }
}

/// The ring at one place of the flat.
#[derive(Clone, Debug)]
pub struct Pressed {
    /// δ \[mm\].
    pub way: f64,
    /// F \[N/mm\].
    pub force: f64,
    /// Newton steps of the increment, those of halves included.
    pub iterations: usize,
}

/// A run of one formulation.
pub struct Run {
    pub formulation: Formulation,
    pub unknowns: usize,
    pub steps: Vec<Pressed>,
    /// The reason of an early end.
    pub failure: Option<String>,
    /// δ \[mm\] at the given force, and ∫ (J − 1) \[mm²\] there.
    pub at_force: Option<(f64, f64)>,
    /// The last state, and what may be drawn of it.
    pub displacement: Field<2>,
    pub pressure: Option<Field<2>>,
    pub local_unknowns: Option<Counts>,
}

/// The right half, whose mirror is at x = 0: "bottom" is the outer arc, "top" the inner one, "left" the mirror.
fn mesh(formulation: Formulation, along: usize) -> Result<Mesh<2>, Box<dyn Error>> {
    let along = formulation.along(along);
    let across = (along / 4).max(1);
    let place = |[s, t]: [f64; 2]| {
        let (angle, radius) = (PI / 2.0 * (s - 1.0), OUTSIDE - t * (OUTSIDE - INSIDE));
        [radius * angle.cos(), radius * angle.sin()]
    };
    Ok(structured([along, across], formulation.shape(), 2, place)?)
}

/// Data with the flat moved up by δ.
pub fn data(gamma0: f64, way: f64) -> law::Data<2> {
    law::data()
        .mu(MU)
        .bulk_modulus(BULK)
        .gamma0(gamma0)
        .obstacle_normal([0.0, -1.0])
        .gap(move |x: &[f64; 2]| x[1] + OUTSIDE - way)
        .force_direction([0.0, 1.0])
}

/// A run's parameters.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Cells along the half of the half ring, for elements of degree 2.
    pub along: usize,
    /// The last δ \[mm\], reached in steps of 1.
    pub end: usize,
    /// F \[N/mm\] at which δ is looked for.
    pub force: f64,
}

impl Setting {
    /// All increments of a formulation, and the state under the given force.
    pub fn run(&self, formulation: Formulation) -> Result<Run, Box<dyn Error>> {
        let mesh = mesh(formulation, self.along)?;
        let gamma0 = mixed_nitsche::usual_gamma0(MU);
        let space = |elements, scope, shape: &[usize]| Space::of(&mesh, elements, scope, shape);
        let degree = if formulation.is_linear() { 1 } else { 2 };
        let of_displacements = match formulation {
            Formulation::Mini => Elements::Mini(1),
            _ => Elements::Lagrange(degree),
        };
        let displacements = space(of_displacements, Scope::Nodes, &[2])?;
        let of_cells = || -> Result<Arc<Space<2>>, SpaceError> {
            match formulation {
                Formulation::Quadratic => space(Elements::LinearInSpace, Scope::Cell, &[]),
                Formulation::MeanDilatation | Formulation::Averaged => {
                    space(Elements::Lagrange(0), Scope::Cell, &[])
                }
                _ => space(Elements::Lagrange(1), Scope::Nodes, &[]),
            }
        };
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(5));
        let regions = law::Regions::default().gamma_c("bottom").gamma_n("right");
        let mixed_law = |way: f64| law::Model { data: data(gamma0, way), regions: regions.clone() };
        let averaged_law = |way: f64| {
            let regions = averaged_nitsche::Regions::default().gamma_c("bottom").gamma_n("right");
            averaged_nitsche::Model { data: data(gamma0, way), regions }
        };
        let ring = Ring { setting: *self, formulation, assembler: &assembler, gamma0 };
        match formulation {
            Formulation::Averaged => {
                let cells = of_cells()?;
                let path = ring.follow([&displacements, &cells], |way| averaged_law(way).with_pressure())?;
                Ok(ring.ended(path, |[_, p]| Some(p.clone())))
            }
            Formulation::AveragedAlone => {
                let path = ring.follow([&displacements], |way| averaged_law(way).direct())?;
                Ok(ring.ended(path, |_| None))
            }
            Formulation::Displacement => {
                let path = ring.follow([&displacements], |way| {
                    let regions = displacement::Regions::default().gamma_c("bottom");
                    displacement::Model { data: data(gamma0, way), regions }.balance()
                })?;
                Ok(ring.ended(path, |_| None))
            }
            Formulation::MeanDilatation => {
                let cells = of_cells()?;
                let path =
                    ring.follow([&displacements, &cells, &cells], |way| mixed_law(way).three_fields())?;
                Ok(ring.ended(path, |[_, p, _]| Some(p.clone())))
            }
            _ => {
                let pressures = of_cells()?;
                let path = ring.follow([&displacements, &pressures], |way| mixed_law(way).direct())?;
                Ok(ring.ended(path, |[_, p]| Some(p.clone())))
            }
        }
    }
}

/// The parts of a run that all of its steps share.
struct Ring<'a> {
    setting: Setting,
    formulation: Formulation,
    assembler: &'a Assembler<2>,
    gamma0: f64,
}

/// States of a run with N unknowns.
struct Path<const N: usize> {
    steps: Vec<Pressed>,
    failure: Option<String>,
    last: [Field<2>; N],
    /// δ and ∫ (J − 1) at the force that is looked for.
    at_force: Option<(f64, f64)>,
    local_unknowns: Option<Counts>,
}

fn held(displacements: &Arc<Space<2>>) -> Result<Constraints<2>, Box<dyn Error>> {
    let mut held = Constraints::new(displacements);
    held.fix("top", |_| [0.0; 2])?;
    held.fix_component("left", 0, |_| 0.0)?;
    Ok(held)
}

impl Ring<'_> {
    /// Increments of 1 mm, halved where Newton's method fails.
    fn follow<const N: usize>(
        &self,
        spaces: [&Arc<Space<2>>; N],
        form: impl Fn(f64) -> Form<2>,
    ) -> Result<Path<N>, Box<dyn Error>> {
        let held = held(spaces[0])?;
        let (mut steps, mut iterations): (Vec<Pressed>, _) = (vec![], 0);
        // δ and F of the state whose force is nearest to the one looked for, and the state.
        let mut nearest: Option<(f64, f64, [Field<2>; N])> = None;
        let mut local_unknowns = None;
        let solve = |step: &Increment<'_, [Field<2>; N]>| -> Result<[Field<2>; N], Box<dyn Error>> {
            let count = |newton: &NewtonStep| iterations += usize::from(newton.iteration > 0);
            let solved = Problem::new(&form(step.factor), spaces)
                .assembler(self.assembler)
                .constrained(&held)
                .options(self.formulation.options())
                .increment(step)
                .each_step(count)
                .solve()?;
            // The other half of the half ring has as much.
            let force = -2.0 * solved.reaction_of(0, "top")?[1];
            local_unknowns = solved.report.as_ref().and_then(|report| report.local_unknowns);
            let off = (force - self.setting.force).abs();
            if nearest.as_ref().is_none_or(|(_, other, _)| off < (other - self.setting.force).abs()) {
                nearest = Some((step.factor, force, solved.fields.clone()));
            }
            if step.factor.fract() == 0.0 {
                steps.push(Pressed { way: step.factor, force, iterations });
                iterations = 0;
            }
            Ok(solved.fields)
        };
        let end = self.setting.end;
        let start = spaces.map(Field::zero);
        let mut load = LoadSteps::uniform(end, end as f64);
        load.smallest_increment = 1.0 / 16.0;
        let (last, mut failure) = match load.advance(start, solve) {
            Ok(path) => (path.state, None),
            Err(error) => {
                let why = format!("{} not reached from {}: {}", error.failed, error.factor, error.why);
                (error.state, Some(why))
            }
        };
        let at_force = match nearest.map(|nearest| self.under_force(spaces, &held, form, nearest)) {
            Some(Ok(found)) => Some(found),
            Some(Err(why)) => {
                failure.get_or_insert(format!("no state at {} N/mm: {why}", self.setting.force));
                None
            }
            None => None,
        };
        Ok(Path { steps, failure, last, at_force, local_unknowns })
    }

    /// δ and ∫ (J − 1) under the force, by secants from a state next to it.
    fn under_force<const N: usize>(
        &self,
        spaces: [&Arc<Space<2>>; N],
        held: &Constraints<2>,
        form: impl Fn(f64) -> Form<2>,
        (mut way, mut force, mut state): (f64, f64, [Field<2>; N]),
    ) -> Result<(f64, f64), Box<dyn Error>> {
        let mut slope = (force / way).max(1.0) * 1.8;
        for _ in 0..SECANTS {
            if (force - self.setting.force).abs() < 1e-9 * self.setting.force {
                break;
            }
            let next = way + (self.setting.force - force) / slope;
            let problem = Problem::new(&form(next), spaces).assembler(self.assembler);
            let problem = problem.constrained(held).options(self.formulation.options());
            let solved = problem.start(&state).solve()?;
            let found = -2.0 * solved.reaction_of(0, "top")?[1];
            slope = (found - force) / (next - way);
            (way, force, state) = (next, found, solved.fields);
        }
        let growth = law::growth(&data(self.gamma0, way), &law::Omega::on("all"), &state[0]);
        Ok((way, 2.0 * self.assembler.functional(&growth)?))
    }

    fn ended<const N: usize>(
        &self,
        path: Path<N>,
        pressure: impl Fn(&[Field<2>; N]) -> Option<Field<2>>,
    ) -> Run {
        let unknowns = path.last.iter().map(|field| field.values().len()).sum();
        Run {
            formulation: self.formulation,
            unknowns,
            at_force: path.at_force,
            steps: path.steps,
            failure: path.failure,
            displacement: path.last[0].clone(),
            pressure: pressure(&path.last),
            local_unknowns: path.local_unknowns,
        }
    }
}
