//! A formula as LaTeX; it needs the package amsmath (and stmaryrd for jumps).

use super::notation::{Notation, decimal};
use super::symbols::{Accent, GREEK, Symbol};

pub struct Latex;

impl Notation for Latex {
    const FLAT: bool = false;

    fn number(&self, value: f64) -> String {
        let (digits, exponent) = decimal(value);
        let digits = digits.replace('−', "-");
        match exponent {
            Some(exponent) => format!("{digits} \\cdot 10^{{{exponent}}}"),
            None => digits,
        }
    }

    fn symbol(&self, symbol: &Symbol) -> String {
        let mut text = letters(&symbol.base);
        let (mut marks, mut raised) = (String::new(), String::new());
        for accent in &symbol.accents {
            let above = match accent {
                Accent::Hat => "\\hat",
                Accent::Bar => "\\bar",
                Accent::Tilde => "\\tilde",
                Accent::Dot => "\\dot",
                Accent::Star => {
                    raised.push_str("\\ast");
                    continue;
                }
                Accent::Prime => {
                    raised.push_str("\\prime");
                    continue;
                }
            };
            text = format!("{above}{{{text}}}");
        }
        if !symbol.subscripts.is_empty() {
            let parts: Vec<String> = symbol.subscripts.iter().map(|part| letters(part)).collect();
            marks.push_str(&format!("_{{{}}}", parts.join(",")));
        }
        if !raised.is_empty() {
            marks.push_str(&format!("^{{{raised}}}"));
        }
        match symbol.variation {
            Some('Δ') => format!("\\Delta {text}{marks}"),
            Some('∂') => format!("\\partial {text}{marks}"),
            Some(_) => format!("\\delta {text}{marks}"),
            None => format!("{text}{marks}"),
        }
    }

    fn word(&self, word: &str) -> String {
        match word {
            "T" => "\\mathsf{T}".into(),
            "−T" => "-\\mathsf{T}".into(),
            "+" | "−" => word.replace('−', "-"),
            "…" => "\\dots ".into(),
            _ => format!("\\operatorname{{{word}}}"),
        }
    }

    fn sign(&self, sign: &str) -> String {
        match sign {
            "−" => "-",
            "·" => " \\cdot ",
            "⊗" => " \\otimes ",
            "×" => " \\times ",
            "∇" => "\\nabla ",
            "∇²" => "\\nabla^{2} ",
            "∂" => "\\partial ",
            "¬" => "\\lnot ",
            "∧" => "\\land ",
            "∨" => "\\lor ",
            "≤" => "\\le ",
            "≥" => "\\ge ",
            "≠" => "\\ne ",
            other => other,
        }
        .into()
    }

    fn between(&self, sign: &str) -> String {
        match sign {
            "," => ", ".into(),
            _ => format!(" {} ", self.sign(sign).trim()),
        }
    }

    fn row(&self, parts: &[String]) -> String {
        parts.concat()
    }

    fn space(&self) -> String {
        "\\, ".into()
    }

    fn fenced(&self, open: &str, inner: String, close: &str) -> String {
        let delimiter = |one: &str| match one {
            "{" => "\\{".to_string(),
            "}" => "\\}".to_string(),
            "‖" => "\\|".to_string(),
            "⟨" => "\\langle".to_string(),
            "⟩" => "\\rangle".to_string(),
            "⟦" => "\\llbracket".to_string(),
            "⟧" => "\\rrbracket".to_string(),
            other => other.to_string(),
        };
        // Tall contents need delimiters that grow.
        if ["\\frac", "\\begin"].iter().any(|tall| inner.contains(tall)) {
            return format!("\\left{} {inner} \\right{}", delimiter(open), delimiter(close));
        }
        let space = |one: &str| if one.starts_with(['⟦', '⟧', '‖', '⟨']) { " " } else { "" };
        format!("{}{}{inner}{}", delimiter(open), space(open), delimiter(close))
    }

    fn fraction(&self, numerator: String, denominator: String) -> String {
        format!("\\frac{{{numerator}}}{{{denominator}}}")
    }

    fn power(&self, base: String, exponent: String) -> String {
        format!("{{{base}}}^{{{exponent}}}")
    }

    fn subscript(&self, base: String, index: String) -> String {
        format!("{{{base}}}_{{{index}}}")
    }

    fn root(&self, inner: String) -> String {
        format!("\\sqrt{{{inner}}}")
    }

    fn integral(&self, region: String, density: String, measure: &str) -> String {
        let mut letters = measure.chars();
        letters.next();
        format!("\\int_{{{region}}} {density} \\,\\mathrm{{d}}{}", letters.as_str())
    }

    fn cases(&self, rows: &[(String, Option<String>)]) -> String {
        let rows: Vec<String> = rows
            .iter()
            .map(|(value, condition)| match condition {
                Some(condition) => format!("{value} & \\text{{if }} {condition}"),
                None => format!("{value} & \\text{{otherwise}}"),
            })
            .collect();
        format!("\\begin{{cases}} {} \\end{{cases}}", rows.join(" \\\\ "))
    }

    fn matrix(&self, rows: &[Vec<String>]) -> String {
        let rows: Vec<String> = rows.iter().map(|row| row.join(" & ")).collect();
        format!("\\begin{{pmatrix}} {} \\end{{pmatrix}}", rows.join(" \\\\ "))
    }
}

/// A letter, Greek or not, in italics; a word upright.
fn letters(text: &str) -> String {
    let mut characters = text.chars();
    if let (Some(one), None) = (characters.next(), characters.next()) {
        return match GREEK.iter().find(|(_, letter)| *letter == one) {
            Some((name, _)) => format!("\\{} ", if *name == "epsilon" { "varepsilon" } else { name }),
            None => one.to_string(),
        };
    }
    if text.chars().all(|c| c.is_ascii_digit()) {
        return text.to_string();
    }
    let mut plain = String::new();
    for character in text.chars() {
        match GREEK.iter().find(|(_, letter)| *letter == character) {
            Some((name, _)) => plain.push_str(&format!("$\\{name}$")),
            None if character == '_' => plain.push_str("\\_"),
            None => plain.push(character),
        }
    }
    format!("\\text{{{plain}}}")
}
