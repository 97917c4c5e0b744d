//! Progress of the program: a spinner on a terminal, plain lines elsewhere. Both go to the standard error stream; only results go to the standard
//! output.

use std::io::IsTerminal;
use std::time::Duration;

use forms_contact_problem::hollow_cylinder::{CELLS_AROUND, Progress, Settings};
use forms_fem::output::tell;
use forms_fem::prelude::NewtonStep;
use indicatif::{ProgressBar, ProgressStyle};

/// Shows the progress.
pub struct Reporter {
    spinner: Option<ProgressBar>,
}

impl Reporter {
    /// A reporter at the first stage, the mesh.
    pub fn new(settings: &Settings) -> Reporter {
        let spinner = std::io::stderr().is_terminal().then(|| {
            let spinner = ProgressBar::new_spinner();
            if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed} {msg}") {
                spinner.set_style(style);
            }
            spinner.enable_steady_tick(Duration::from_millis(100));
            spinner
        });
        let reporter = Reporter { spinner };
        let (radial, around) = (settings.radial, CELLS_AROUND * settings.radial);
        reporter.stage(&format!("mesh of {radial} x {around} cells, matrix pattern"));
        reporter
    }

    /// A Newton iterate stays on the screen; a stage is replaced by the next one.
    pub fn hear(&self, progress: &Progress) {
        match (progress, &self.spinner) {
            (Progress::Stage(name), _) => self.stage(name),
            (Progress::LoadStep(number, all), _) => self.stage(&format!("load step {number} of {all}")),
            (Progress::Newton(step), Some(spinner)) => {
                spinner.println(line(step));
                spinner.set_message("direct problem (14)");
            }
            (Progress::Newton(step), None) => tell(line(step)),
        }
    }

    /// Reports that a stage begins.
    pub fn stage(&self, name: &str) {
        match &self.spinner {
            Some(spinner) => spinner.set_message(name.to_owned()),
            None => tell(name),
        }
    }

    /// Removes the spinner.
    pub fn finish(&self) {
        if let Some(spinner) = &self.spinner {
            spinner.finish_and_clear();
        }
    }
}

fn line(step: &NewtonStep) -> String {
    let active = step.active_points.map_or(String::new(), |count| format!(", {count} active points"));
    let condensed = match (step.condensed_unknowns, step.linear_iterations) {
        (Some(count), _) => format!(", condensed to {count} unknowns"),
        (None, Some(iterations)) if iterations > 0 => format!(", {iterations} Krylov iterations"),
        _ => String::new(),
    };
    format!("Newton {}: relative residual {:.2e}{active}{condensed}", step.iteration, step.relative_residual)
}
