//! Each formulation on each problem.

use std::process::ExitCode;

use forms_fem::output::{Failure, StandardOutput};
use forms_program::command_line::program_with_options;

use crate::formulation::Formulation;
use crate::options::{Options, chosen};
use crate::posed::Posed;
use crate::rows::Row;
use crate::{at_once, others, plots, problems, table};

/// The program: these formulations on the problems that the command line names.
pub fn program(formulations: &[&dyn Formulation]) -> ExitCode {
    program_with_options(|options: &Options, out| run(options, formulations, out))
}

fn run(
    options: &Options,
    formulations: &[&dyn Formulation],
    out: &mut StandardOutput,
) -> Result<(), Failure> {
    let all = problems::all();
    if options.list {
        all.iter().for_each(|problem| out.line(format!("{}: {}", problem.name(), problem.statement())));
        formulations.iter().for_each(|formulation| out.line(formulation.name()));
        return Ok(());
    }
    let names: Vec<String> = all.iter().map(|problem| problem.name()).collect();
    let problems = chosen(&names, &options.problems, "problem", |name, wanted| name == wanted)?;
    let names: Vec<String> = formulations.iter().map(|formulation| formulation.name()).collect();
    let begins = |name: &str, wanted: &str| name.starts_with(wanted);
    let places = chosen(&names, &options.formulations, "formulation", begins)?;
    let formulations: Vec<&dyn Formulation> = places.into_iter().map(|place| formulations[place]).collect();
    if options.levels == 0 || options.degrees.iter().any(|degree| !(1..=4).contains(degree)) {
        return Err(Failure::from("there is a mesh at least, and degrees are 1 to 4".to_owned()));
    }
    std::fs::create_dir_all(&options.out)?;
    let others = options.others.as_deref().map(others::read).transpose()?.unwrap_or_default();
    let problems: Vec<&dyn Posed> = problems.into_iter().map(|place| all[place].as_ref()).collect();
    let (mut rows, mut markdown) = (vec![], String::new());
    at_once::run(&problems, &formulations, options, |problem, mut rows_of| {
        let of_others: Vec<Row> = others.iter().filter_map(|other| other.row(&rows_of)).collect();
        rows_of.extend(of_others);
        let text = table::markdown(problem, &rows_of);
        text.lines().for_each(|line| out.line(line));
        markdown += &text;
        rows.extend(rows_of);
        Ok(())
    })?;
    std::fs::write(options.out.join("contact_bench.md"), markdown)?;
    std::fs::write(options.out.join("contact_bench.json"), serde_json::to_string_pretty(&rows)?)?;
    // References of other programs have degrees of their own.
    rows.retain(|row| options.degrees.contains(&row.degree));
    for path in plots::write(&rows, &options.out)? {
        out.line(path.display());
    }
    Ok(())
}
