//! Printing of a [`Formula`] in several notations, by one traversal that knows where parentheses are needed.

use super::formula::{Fence, Formula, Infix, Level, Measure};
use super::symbols::Symbol;

/// Notations of the parts of a formula.
pub trait Notation {
    /// Everything is on one line: a fraction is `a/b`, and parentheses say what belongs together.
    const FLAT: bool;

    fn number(&self, value: f64) -> String;
    fn symbol(&self, symbol: &Symbol) -> String;
    /// An upright name.
    fn word(&self, word: &str) -> String;
    /// A sign, given in Unicode.
    fn sign(&self, sign: &str) -> String;
    /// Signs between their operands.
    fn between(&self, sign: &str) -> String;
    /// Parts side by side.
    fn row(&self, parts: &[String]) -> String;
    /// Between two factors.
    fn space(&self) -> String;
    /// Around a formula, growing with it.
    fn fenced(&self, open: &str, inner: String, close: &str) -> String;
    fn fraction(&self, numerator: String, denominator: String) -> String;
    fn power(&self, base: String, exponent: String) -> String;
    fn subscript(&self, base: String, index: String) -> String;
    fn root(&self, inner: String) -> String;
    fn integral(&self, region: String, density: String, measure: &str) -> String;
    fn cases(&self, rows: &[(String, Option<String>)]) -> String;
    fn matrix(&self, rows: &[Vec<String>]) -> String;

    /// The whole formula.
    fn print(&self, formula: &Formula) -> String {
        match formula {
            Formula::Number(value) => self.number(*value),
            Formula::Symbol(symbol) => self.symbol(symbol),
            Formula::Word(word) => self.word(word),
            Formula::Sum(terms) => {
                let mut parts = Vec::new();
                for (index, (minus, term)) in terms.iter().enumerate() {
                    // A sum after a minus, or one that begins with a minus, is in parentheses.
                    let integral = matches!(term, Formula::Integral { .. });
                    let least = if integral { Level::Relation } else { Level::Infix };
                    parts.push(match (index, minus) {
                        (0, false) => String::new(),
                        (0, true) => self.sign("−"),
                        (_, false) => self.between("+"),
                        (_, true) => self.between("−"),
                    });
                    parts.push(self.at_least(least, term));
                }
                parts.retain(|part| !part.is_empty());
                self.row(&parts)
            }
            Formula::Product(factors) => {
                let mut parts = Vec::new();
                for (index, factor) in factors.iter().enumerate() {
                    if index > 0 {
                        let number = factor.begins_with_digit();
                        parts.push(if number { self.between("×") } else { self.space() });
                    }
                    parts.push(match factor {
                        Formula::Fraction(..) if !Self::FLAT => self.print(factor),
                        Formula::Fraction(..) => self.at_least(Level::Atom, factor),
                        _ => self.at_least(Level::Prefix, factor),
                    });
                }
                self.row(&parts)
            }
            Formula::Infix(infix, left, right) => {
                let sign = match infix {
                    Infix::Dot => "·",
                    Infix::DoubleDot => ":",
                    Infix::Outer => "⊗",
                };
                let side = |one: &Formula| match one {
                    Formula::Fraction(..) if Self::FLAT => self.at_least(Level::Atom, one),
                    _ => self.at_least(Level::Product, one),
                };
                self.row(&[side(left), self.sign(sign), side(right)])
            }
            Formula::Fraction(numerator, denominator) if Self::FLAT => {
                let above = match &**numerator {
                    Formula::Fraction(..) => self.at_least(Level::Atom, numerator),
                    _ => self.at_least(Level::Product, numerator),
                };
                self.row(&[above, "/".into(), self.at_least(Level::Prefix, denominator)])
            }
            Formula::Fraction(numerator, denominator) => {
                self.fraction(self.print(numerator), self.print(denominator))
            }
            Formula::Power(base, exponent) => {
                self.power(self.at_least(Level::Atom, base), self.print(exponent))
            }
            Formula::Root(inner) => self.root(self.print(inner)),
            Formula::Prefix(sign, inner) => self.row(&[self.sign(sign), self.at_least(Level::Atom, inner)]),
            Formula::Derivative { order, by, of } => {
                let mut sign = self.sign("D");
                if *order > 1 {
                    sign = self.power(sign, self.number(*order as f64));
                }
                if let Some(by) = by {
                    sign = self.subscript(sign, self.print(by));
                }
                // `D stress`, but `Dσ`.
                let word = matches!(&**of, Formula::Symbol(symbol) if symbol.is_long());
                let space = if word || by.is_some() { self.space() } else { String::new() };
                self.row(&[sign, space, self.at_least(Level::Atom, of)])
            }
            Formula::Fence(fence, inner) => {
                let inner = self.print(inner);
                match fence {
                    Fence::Bars => self.fenced("|", inner, "|"),
                    Fence::DoubleBars => self.fenced("‖", inner, "‖"),
                    Fence::PositivePart => self.subscript(self.fenced("[", inner, "]"), self.sign("+")),
                    Fence::NegativePart => self.subscript(self.fenced("[", inner, "]"), self.sign("−")),
                    Fence::Jump => self.fenced("⟦", inner, "⟧"),
                    Fence::Mean => self.fenced("⟨", inner, "⟩"),
                    Fence::Average => self.fenced("{", inner, "}"),
                }
            }
            Formula::Call(head, arguments) if arguments.is_empty() => self.print(head),
            Formula::Call(head, arguments) => {
                let head = self.at_least(Level::Prefix, head);
                self.row(&[head, self.fenced("(", self.list(arguments), ")")])
            }
            Formula::Directions(head, directions) => {
                let head = self.at_least(Level::Prefix, head);
                self.row(&[head, self.fenced("[", self.list(directions), "]")])
            }
            Formula::Tuple(entries) => self.fenced("(", self.list(entries), ")"),
            Formula::Subscript(base, indices) => {
                let indices: Vec<String> = indices.iter().map(|index| self.print(index)).collect();
                self.subscript(self.at_least(Level::Atom, base), self.row(&indices))
            }
            Formula::Matrix(rows) => {
                let rows: Vec<Vec<String>> =
                    rows.iter().map(|row| row.iter().map(|entry| self.print(entry)).collect()).collect();
                self.matrix(&rows)
            }
            Formula::Cases(rows) => {
                let rows: Vec<_> = rows
                    .iter()
                    .map(|(value, condition)| {
                        (self.print(value), condition.as_ref().map(|condition| self.print(condition)))
                    })
                    .collect();
                self.cases(&rows)
            }
            Formula::Relation(sign, left, right) => {
                let joins = |sign: &str| matches!(sign, "∧" | "∨");
                let side = |one: &Formula| match one {
                    Formula::Relation(inner, ..) if joins(sign) && !joins(inner) => self.print(one),
                    _ => self.at_least(Level::Sum, one),
                };
                self.row(&[side(left), self.between(sign), side(right)])
            }
            Formula::Integral { region, density, measure } => {
                let measure = match measure {
                    Measure::Dx => "dx",
                    Measure::Ds => "ds",
                    Measure::InteriorDs => "dS",
                };
                self.integral(self.symbol(region), self.at_least(Level::Infix, density), measure)
            }
        }
    }

    /// In parentheses if it is looser than `least`.
    fn at_least(&self, least: Level, formula: &Formula) -> String {
        match formula.level() < least {
            true => self.fenced("(", self.print(formula), ")"),
            false => self.print(formula),
        }
    }

    fn list(&self, entries: &[Formula]) -> String {
        let mut parts = Vec::new();
        for (index, entry) in entries.iter().enumerate() {
            if index > 0 {
                parts.push(self.between(","));
            }
            parts.push(self.at_least(Level::Sum, entry));
        }
        self.row(&parts)
    }
}

/// A number's digits, and a power of ten where there would be many zeros.
pub fn decimal(value: f64) -> (String, Option<i32>) {
    let size = value.abs();
    if size != 0.0 && !(1e-4..1e7).contains(&size) {
        let text = format!("{value:e}");
        if let Some((digits, exponent)) = text.split_once('e') {
            return (digits.replace('-', "−"), exponent.parse().ok());
        }
    }
    (format!("{value}").replace('-', "−"), None)
}
