//! Names and formulas of combinations.

use super::Addend;
use crate::adaptation::text;
use crate::form::Formula;

/// Names that are written out; others are counted.
const NAMES: usize = 4;

/// The name of a combination: those of its addends. Messages have no room for factors.
pub(super) fn name_of(addends: &[Addend]) -> &'static str {
    match addends {
        [] => "sum of no forms",
        [one] => one.name,
        [first, others @ ..] => {
            let mut name = first.name.to_owned();
            for other in &others[..others.len().min(NAMES - 1)] {
                name += if other.factor < 0.0 { " - " } else { " + " };
                name += other.name;
            }
            if addends.len() > NAMES {
                name += &format!(" + {} more", addends.len() - NAMES);
            }
            text(name)
        }
    }
}

/// A combination as mathematics: the sum of the names with their factors, then the formula of each.
pub(in crate::function) fn formula_of(addends: &[Addend]) -> Formula {
    let mut formulas: Vec<&Formula> = Vec::new();
    for Addend { formula, .. } in addends {
        if !formulas.contains(formula) {
            formulas.push(formula);
        }
    }
    let names = |minus: &str, plain: fn(&str) -> String| {
        let mut sum = String::new();
        for (number, Addend { factor, name, .. }) in addends.iter().enumerate() {
            let is_first = number == 0;
            sum += &match (is_first, *factor < 0.0) {
                (true, false) => String::new(),
                (true, true) => minus.to_owned(),
                (false, false) => " + ".to_owned(),
                (false, true) => format!(" {minus} "),
            };
            if factor.abs() != 1.0 {
                sum += &format!("{} ", factor.abs());
            }
            sum += &plain(name);
        }
        sum
    };
    let unicode = names("−", |name| name.to_owned());
    let latex = names("-", |name| format!("\\mathrm{{{}}}", name.replace('_', "\\_")));
    let texts =
        |of: fn(&Formula) -> &'static str| formulas.iter().map(|formula| of(formula)).collect::<Vec<_>>();
    Formula {
        unicode: text(format!("{unicode}\n\n{}", texts(|formula| formula.unicode).join("\n\n"))),
        latex: text(format!("\\[ {latex} \\]\n{}", texts(|formula| formula.latex).join("\n"))),
    }
}
