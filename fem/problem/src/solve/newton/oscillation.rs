//! Points whose switches changed back and forth when Newton's method failed, and what may help.

use std::fmt;

use super::{LineSearch, NewtonFailure, NewtonOptions, NewtonStep};

/// Points that are printed.
const PRINTED: usize = 8;

/// A residual that fell to this part of the first one, with points that still switch, is at rounding level next to the switch.
const FALLEN: f64 = 1e-8;

/// A quadrature point whose law changed its branch back and forth.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SwitchingPoint {
    /// Place on the undeformed mesh \[length\].
    pub position: Vec<f64>,
    /// The mesh's name for the region of the integral.
    pub region: String,
    /// The switches that changed in the last iterations: `neg_part`, `max`, comparisons and others of the integral in its order, numbered from 0.
    pub switches: Vec<usize>,
    /// Those of its switches that are on at the last iterate.
    pub on: Vec<usize>,
    /// The iteration since which it switches.
    pub since: usize,
    /// Iterations since then at which it switched.
    pub changes: usize,
    /// Names and values of the observed functionals at the last iterate ([`Problem::observe`](crate::solve::Problem::observe)).
    pub values: Vec<(&'static str, f64)>,
}

/// A remedy for an oscillation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum Remedy {
    /// A line search, where there was none.
    ShorterSteps,
    /// Smaller load steps: few points switch although steps are shortened.
    SmallerLoadSteps,
    /// A start nearer to the solution: at least half of the points switch.
    NearerStart,
    /// A larger tolerance: the points are at their switch up to rounding.
    LargerTolerance,
}

impl Remedy {
    /// The first remedy to try.
    pub(in crate::solve) fn of(
        points: [usize; 2],
        why: &NewtonFailure,
        history: &[NewtonStep],
        options: &NewtonOptions,
    ) -> Self {
        let fallen = history.last().is_some_and(|last| last.relative_residual < FALLEN);
        let [switching, all] = points;
        match options.line_search {
            _ if fallen => Remedy::LargerTolerance,
            LineSearch::Off if !matches!(why, NewtonFailure::NoDescent) => Remedy::ShorterSteps,
            _ if 2 * switching >= all => Remedy::NearerStart,
            _ => Remedy::SmallerLoadSteps,
        }
    }
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Remedy::ShorterSteps => {
                "take shorter steps: NewtonOptions { line_search: LineSearch::OnResidual, .. }"
            }
            Remedy::SmallerLoadSteps => {
                "apply the load in smaller steps (`LoadSteps`): few points switch although steps are shortened"
            }
            Remedy::NearerStart => {
                "begin nearer to the solution (`Problem::start`, `LoadSteps`): at least half of the points switch"
            }
            Remedy::LargerTolerance => {
                "raise `NewtonOptions::relative_tolerance`: the points are at their switch up to rounding"
            }
        })
    }
}

/// The points that oscillated before Newton's method failed. `MeshDrawing::oscillation` draws them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Oscillation {
    /// The points, those that switched most often first.
    pub points: Vec<SwitchingPoint>,
    /// All points that have switches.
    pub point_count: usize,
    /// The first remedy to try.
    pub remedy: Remedy,
}

impl Oscillation {
    /// One line on it: numbers, and the first point.
    pub fn summary(&self) -> String {
        let (count, all) = (self.points.len(), self.point_count);
        let first = self.points.first().map(|point| {
            let SwitchingPoint { position, region, since, .. } = point;
            format!(
                ", as since iteration {since} at {position:?} of \"{region}\"{}",
                in_brackets(&point.values)
            )
        });
        format!("{count} of {all} points switch back and forth{}", first.unwrap_or_default())
    }
}

fn in_brackets(values: &[(&'static str, f64)]) -> String {
    match values {
        [] => String::new(),
        values => format!(" ({})", listed(values)),
    }
}

fn listed(values: &[(&'static str, f64)]) -> String {
    let each: Vec<String> = values.iter().map(|(name, value)| format!("{name} {value:.3e}")).collect();
    each.join(", ")
}

fn numbers(numbers: &[usize]) -> String {
    match numbers {
        [] => "-".to_owned(),
        numbers => numbers.iter().map(usize::to_string).collect::<Vec<_>>().join(", "),
    }
}

// A line for a point, and the remedy.
impl fmt::Display for Oscillation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{} of {} points switch back and forth:", self.points.len(), self.point_count)?;
        write!(f, "{:>9}  {:>7}  {:>8}  {:>8}  point", "since", "changes", "switches", "on")?;
        for point in self.points.iter().take(PRINTED) {
            let (switches, on) = (numbers(&point.switches), numbers(&point.on));
            write!(f, "\n{:>9}  {:>7}  {switches:>8}  {on:>8}", point.since, point.changes)?;
            write!(f, "  {:?} of \"{}\"{}", point.position, point.region, in_brackets(&point.values))?;
        }
        if self.points.len() > PRINTED {
            write!(f, "\n{:>9}  ({} more)", "...", self.points.len() - PRINTED)?;
        }
        write!(f, "\n{}", self.remedy)
    }
}
