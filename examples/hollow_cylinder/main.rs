//! The paper's experiment: the hollow cylinder pressed onto a flat obstacle, its three adjoint states, a
//! table of results, a `.vtu` file and pictures.

mod destinations;
mod measurements;
mod memory;
mod options;
mod pictures;
mod progress;
mod table;
mod visualisation;

use std::error::Error;
use std::io::Write;
use std::process::ExitCode;
use std::time::Instant;

use forms_contact::hollow_cylinder::{CONTACT_CELLS, CylinderError, Settings, hollow_cylinder, solve};
use forms_contact::threshold::required_gamma0;
use forms_fem::output::write_whole;

use measurements::Measurements;
use options::{Options, one_line};
use progress::Reporter;

/// What can go wrong while files are written has no common type.
type Outcome<T> = Result<T, Box<dyn Error>>;

fn main() -> ExitCode {
    let options = match options::from_command_line() {
        Ok(options) => options,
        Err(code) => return code,
    };
    match run(&options) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", one_line(&error.to_string()));
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Outcome<()> {
    let start = Instant::now();
    let settings = options.settings()?;
    // A long computation must not end with nowhere to put its result.
    destinations::prepare_directory(&options.out)?;
    if let Some(json) = &options.json {
        destinations::check_file(json)?;
    }
    let reporter = Reporter::new(&settings);
    let solution = match solve(&settings, &mut |progress| reporter.hear(&progress)) {
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
        eprintln!("{warning}");
    }
    print(&table::of(&measured));
    if let Some(path) = &options.json {
        let text = serde_json::to_string_pretty(&measured)?;
        write_whole(path, |writer| writeln!(writer, "{text}"))?;
        print(&format!("Written: {}\n", path.display()));
    }
    for file in files? {
        print(&format!("Written: {}\n", file.display()));
    }
    Ok(())
}

/// Newton's history, and whether γ₀ may be to blame.
fn explain_failure(settings: &Settings, error: &CylinderError) {
    if let CylinderError::Newton(newton) = error {
        eprint!("{}", table::newton_history(&newton.history.iter().map(Into::into).collect::<Vec<_>>()));
        let required = hollow_cylinder(settings).and_then(|problem| {
            let required = required_gamma0(&problem, CONTACT_CELLS)?;
            Ok(required)
        });
        if let Some(warning) = required.ok().and_then(|required| threshold_warning(settings, required)) {
            eprintln!("{warning}");
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

/// Prints to the standard output; a reader who has gone away is no error.
fn print(text: &str) {
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
}
