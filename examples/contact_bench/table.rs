//! Tables in Markdown, which is also what the terminal gets.

use std::fmt::Write;

use crate::posed::Posed;
use crate::rows::{Answer, Measured, Row};

/// Characters of a reason in a cell.
const REASON: usize = 160;

/// The reason for a cell without an error: the pressure has no closed form.
const NOT_KNOWN: &str = "no closed form";
const NOT_MEASURED: &str = "not measured";

/// A number, or why there is none.
fn number(value: Option<f64>, why: &str) -> String {
    value.map_or_else(|| why.to_owned(), |value| format!("{value:.1e}"))
}

/// log₂ of the error before over this one.
fn order(before: Option<&Row>, row: &Row) -> String {
    let error = |row: &Row| row.measured().and_then(|measured| measured.pressure_error);
    match (before.filter(|before| before.is_coarser_than(row)).and_then(error), error(row)) {
        (Some(before), Some(after)) if after > 1e-9 => format!("{:.2}", (before / after).log2()),
        (Some(_), Some(_)) => "rounding".to_owned(),
        (None, Some(_)) => "no mesh before".to_owned(),
        (_, None) => NOT_KNOWN.to_owned(),
    }
}

impl Row {
    fn is_coarser_than(&self, other: &Row) -> bool {
        self.degree == other.degree && self.formulation == other.formulation && self.level + 1 == other.level
    }
}

fn cells(measured: &Measured, order: &str) -> String {
    let outer = measured.outer.map_or_else(|| "none".to_owned(), |outer| outer.to_string());
    let no_gradient = measured.no_gradient.as_deref().map(shortened).unwrap_or_default();
    let quantities: Vec<String> =
        measured.quantities.iter().map(|quantity| format!("{:.6}", Short(quantity.value))).collect();
    format!(
        "{} | {order} | {}, {} | {outer} | {:.2} | {} | {} | {} | {} | {}",
        number(measured.pressure_error, if measured.pressures.is_empty() { NOT_MEASURED } else { NOT_KNOWN }),
        measured.newton,
        measured.worst_newton,
        measured.seconds,
        number(measured.force_balance, "one body"),
        number(measured.moment_balance, "one body"),
        number(Some(measured.penetration).filter(|depth| !depth.is_nan()), NOT_MEASURED),
        number(measured.gradient.map(|gradient| gradient.error()), &no_gradient),
        quantities.join("; "),
    )
}

/// A number with significant digits: the precision is their count.
struct Short(f64);

impl std::fmt::Display for Short {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.0.is_nan() {
            return f.write_str("–");
        }
        let digits = f.precision().unwrap_or(4) as i32;
        let exponent = if self.0 == 0.0 { 0 } else { self.0.abs().log10().floor() as i32 };
        match exponent {
            -3..6 => write!(f, "{:.*}", (digits - 1 - exponent).max(0) as usize, self.0),
            _ => write!(f, "{:.*e}", (digits - 1) as usize, self.0),
        }
    }
}

/// The table of a problem, with its statement and the known numbers.
pub fn markdown(problem: &dyn Posed, rows: &[Row]) -> String {
    let mut text = format!("## {}\n\n{}.\n", problem.name(), problem.statement());
    let known = rows.iter().find_map(Row::measured).map_or(&[][..], |measured| &measured.quantities[..]);
    let names: Vec<String> = known
        .iter()
        .map(|quantity| match quantity.exact {
            Some(exact) => format!("{} (known: {:.6})", quantity.name, Short(exact)),
            None => quantity.name.to_owned(),
        })
        .collect();
    let _ = writeln!(
        text,
        "\n| formulation | degree | unknowns | error of p | order | Newton: all, worst | outer | s | ΣF | ΣM | penetration | gradient | {} |",
        if names.is_empty() { "numbers".to_owned() } else { names.join("; ") }
    );
    text += "| --- | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --: | --- |\n";
    for (index, row) in rows.iter().enumerate() {
        let before = index.checked_sub(1).map(|before| &rows[before]);
        let cells = match &row.answer {
            Answer::Solved(measured) => cells(measured, &order(before, row)),
            Answer::NotDefined(why) => format!("– | | | | | | | | | not defined: {why}"),
            Answer::Failed(why) => format!("– | | | | | | | | | failed: {}", shortened(why)),
        };
        let _ = writeln!(text, "| {} | {} | {} | {cells} |", row.formulation, row.degree, row.unknowns);
    }
    for row in rows {
        let Answer::Failed(why) = &row.answer else { continue };
        // Points that switch back and forth.
        if let Some((_, points)) = why.split_once('\n') {
            let _ =
                writeln!(text, "\n{}, degree {}, {} unknowns:\n", row.formulation, row.degree, row.unknowns);
            let _ = writeln!(text, "```text\n{points}\n```");
        }
    }
    text + "\n"
}

fn shortened(why: &str) -> String {
    let why = why.lines().next().unwrap_or_default().replace('|', "/");
    if why.chars().count() <= REASON { why } else { why.chars().take(REASON).chain(['…']).collect() }
}
