//! The command line.

use std::path::PathBuf;

use clap::Parser;
use forms_fem::output::Failure;

/// Formulations of contact compared on problems with known answers: a table, JSON and plots.
#[derive(Clone, Debug, Parser)]
#[command(name = "contact_bench", version)]
pub struct Options {
    /// Problems, by name in small or capital letters; "all".
    #[arg(long, value_delimiter = ',', default_value = "all")]
    pub problems: Vec<String>,
    /// Formulations, by the beginning of their names in small or capital letters; "all".
    #[arg(long, value_delimiter = ',', default_value = "all")]
    pub formulations: Vec<String>,
    /// Degrees of the displacements, 1 and 2.
    #[arg(long, value_delimiter = ',', default_values_t = [1, 2])]
    pub degrees: Vec<usize>,
    /// Meshes, each with cells of half the size of those before. The third one takes most of the time.
    #[arg(long, default_value_t = 3)]
    pub levels: usize,
    /// The directory of the Markdown table, JSON and plots.
    #[arg(long, default_value = "out/contact_bench")]
    pub out: PathBuf,
    /// Rows of other programs, as `bench/peers/contact/run.py` writes them.
    #[arg(long)]
    pub others: Option<PathBuf>,
    /// Prints the names of problems and formulations, and ends.
    #[arg(long)]
    pub list: bool,
}

/// The places of the names that were asked for, without regard to capital letters. `fits` says whether a name is one that was asked for, both in
/// small letters.
///
/// # Errors
/// A name that fits none.
pub fn chosen(
    names: &[String],
    asked: &[String],
    kind: &str,
    fits: impl Fn(&str, &str) -> bool,
) -> Result<Vec<usize>, Failure> {
    let fits = |name: &str, wanted: &str| {
        let [name, wanted] = [name, wanted].map(str::to_lowercase);
        wanted == "all" || fits(&name, &wanted)
    };
    for wanted in asked {
        if !names.iter().any(|name| fits(name, wanted)) {
            let names = names.join(", ");
            return Err(Failure::from(format!("there is no {kind} \"{wanted}\": {names}")));
        }
    }
    let is_chosen = |name: &str| asked.iter().any(|wanted| fits(name, wanted));
    Ok((0..names.len()).filter(|place| is_chosen(&names[*place])).collect())
}
