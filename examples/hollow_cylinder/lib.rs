//! The paper's experiment: the hollow cylinder pressed onto a flat obstacle, its three adjoint states, a
//! table of results, a `.vtu` file and pictures.

mod derived_fields;
mod destinations;
mod measurements;
mod options;
mod pictures;
mod progress;
mod table;
mod visualisation;

use std::error::Error;
use std::io::Write;
use std::time::Instant;

use forms_contact_problem::hollow_cylinder::{
    CONTACT_CELLS, CylinderError, Settings, hollow_cylinder, solve_with_progress,
};
use forms_contact_problem::threshold::required_gamma0;
use forms_fem::output::{StandardOutput, tell, write_whole};
use forms_program::memory;

use measurements::Measurements;
pub use options::Options;
use progress::Reporter;

/// A result with any error; errors of writing files have no common type.
pub type Outcome<T> = Result<T, Box<dyn Error>>;

/// The program with its options: solves, prints the table, writes the files.
///
/// # Errors
/// One line that says which option, file or solver failed, and why.
pub fn run(options: &Options, out: &mut StandardOutput) -> Outcome<()> {
    let start = Instant::now();
    let settings = options.settings()?;
    if !options.any_memory {
        let unknowns = settings.unknowns();
        memory::check(&format!("--radial {}", settings.radial), unknowns, memory::of_contact(unknowns))?;
    }
    // Before the long computation: its results can be written.
    destinations::prepare_directory(&options.out)?;
    if let Some(json) = &options.json {
        destinations::check_file(json)?;
    }
    let reporter = Reporter::new(&settings);
    let solution = match solve_with_progress(&settings, |progress| reporter.hear(&progress)) {
        Ok(solution) => solution,
        Err(error) => {
            reporter.finish();
            explain_failure(&settings, &error);
            return Err(error.into());
        }
    };
    reporter.stage("norms");
    let mut measured = Measurements::new(&settings, &solution)?;
    reporter.stage("stresses, .vtu file and pictures");
    let files = visualisation::write_all(&solution, &options.out, &mut measured.seconds);
    reporter.finish();
    measured.seconds.total = start.elapsed().as_secs_f64();
    measured.peak_rss_mb = memory::peak_megabytes();
    if let Some(warning) = threshold_warning(&settings, solution.required_gamma0) {
        tell(&warning);
    }
    out.line(table::of(&measured));
    if let Some(path) = &options.json {
        let text = serde_json::to_string_pretty(&measured)?;
        write_whole(path, |writer| writeln!(writer, "{text}"))?;
        out.line(format!("Written: {}", path.display()));
    }
    for file in files? {
        out.line(format!("Written: {}", file.display()));
    }
    Ok(())
}

/// Newton's history, and whether γ₀ may be to blame.
fn explain_failure(settings: &Settings, error: &CylinderError) {
    if let CylinderError::Solve(newton) = error {
        tell(table::newton_history(&newton.history).trim_end_matches('\n'));
        let required = hollow_cylinder(settings).and_then(|problem| {
            let required = required_gamma0(&problem, CONTACT_CELLS)?;
            Ok(required)
        });
        if let Some(warning) = required.ok().and_then(|required| threshold_warning(settings, required)) {
            tell(&warning);
        }
    }
}

/// The warning about a γ₀ \[MPa\] below the one that is required, in the unit of the option.
fn threshold_warning(settings: &Settings, required: f64) -> Option<String> {
    let needed = required / settings.young;
    (settings.gamma0_over_young <= needed).then(|| {
        format!(
            "warning: gamma0 = {} E is below the threshold of Nitsche's method: at theta = {} this mesh needs \
             --gamma0 above {:.4} (in units of E); the results cannot be relied on",
            settings.gamma0_over_young, settings.theta, needed
        )
    })
}
