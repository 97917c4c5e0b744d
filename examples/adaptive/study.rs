//! The same problem on meshes that follow an estimate and on meshes refined everywhere.

use forms_fem::adaptivity::{Adaptation, AdaptiveSolution};
use forms_fem::output::picture::Curve;
use forms_fem::output::tell;
use forms_fem::prelude::*;

use crate::Outcome;

/// Figures of one mesh.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Unknowns.
    pub unknowns: usize,
    /// The true error: a norm, or J − J_h with its sign.
    pub error: f64,
    /// The estimated error.
    pub estimate: f64,
}

/// A solution with its estimate, and its true error.
pub type WithError = (AdaptiveSolution<2>, f64);

/// A study: errors over unknowns in both ways.
pub struct Study {
    /// Its name.
    pub name: String,
    /// Meshes refined everywhere.
    pub uniform: Vec<Row>,
    /// Meshes that follow the estimate.
    pub adaptive: Vec<Row>,
    /// A mesh whose cells can be seen in a picture.
    pub mesh: Mesh<2>,
}

/// Cells that can be distinguished in a picture.
const MOST_SHOWN: usize = 1_500;

impl Study {
    /// Solves on meshes of both kinds from a coarse one on, up to a number of unknowns.
    pub fn new(
        name: &str,
        coarse: &Mesh<2>,
        unknowns: usize,
        solve: impl Fn(&Mesh<2>, Option<&Field<2>>) -> Outcome<WithError>,
    ) -> Outcome<Study> {
        let row = |solution: &AdaptiveSolution<2>, error| Row {
            unknowns: solution.field.space().unknowns(),
            error,
            estimate: solution.estimate.value(),
        };
        let mut uniform: Vec<Row> = vec![];
        let (mut mesh, mut before) = (coarse.clone(), None);
        loop {
            let (solution, error) = solve(&mesh, before.as_ref())?;
            uniform.push(row(&solution, error));
            tell(format!("{name}, refined everywhere: {} unknowns", solution.field.space().unknowns()));
            // Each refinement has about four times the unknowns.
            if 2 * solution.field.space().unknowns() >= unknowns {
                break;
            }
            before = Some(solution.field);
            mesh = mesh.refined()?;
        }
        let (mut adaptive, mut shown): (Vec<Row>, _) = (vec![], coarse.clone());
        let cycle = Adaptation::to_unknowns(unknowns);
        let on_mesh = |mesh: &Mesh<2>, before: Option<&Field<2>>| -> Outcome<_> {
            let (solution, error) = solve(mesh, before)?;
            adaptive.push(row(&solution, error));
            if mesh.cell_count() <= MOST_SHOWN {
                shown = mesh.clone();
            }
            Ok(solution)
        };
        cycle.run(coarse.clone(), on_mesh, |step| tell(format!("{name}, {step}")))?;
        Ok(Study { name: name.to_owned(), uniform, adaptive, mesh: shown })
    }

    /// The unknowns with which an adaptive mesh first has the error of the last uniform one.
    pub fn unknowns_for_the_same_error(&self) -> Option<usize> {
        let wanted = self.uniform.last()?.error.abs();
        self.adaptive.iter().find(|row| row.error.abs() <= wanted).map(|row| row.unknowns)
    }
}

/// Errors over unknowns.
pub fn curve(name: &str, rows: &[Row]) -> Curve {
    let (x, y): (Vec<f64>, Vec<f64>) = rows.iter().map(|row| (row.unknowns as f64, row.error.abs())).unzip();
    Curve::new(name, &x, &y)
}

/// The number of rows to which s in error ~ Nˢ is fitted: those with at least a twentieth of the last one's unknowns.
pub fn fitted(rows: &[Row]) -> usize {
    let least = rows.last().map_or(0, |row| row.unknowns / 20);
    rows.iter().filter(|row| row.unknowns >= least).count()
}

/// s in error ~ Nˢ.
pub fn order(rows: &[Row]) -> Option<f64> {
    curve("", rows).order(fitted(rows))
}
