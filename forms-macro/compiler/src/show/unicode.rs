//! A formula as one line of text: `∫_Ω σ(u):ε(v) dx`.

use super::notation::{Notation, decimal};
use super::symbols::{Accent, Symbol};

pub struct Unicode;

impl Notation for Unicode {
    const FLAT: bool = true;

    fn number(&self, value: f64) -> String {
        match decimal(value) {
            (digits, Some(exponent)) => format!("{digits}×10{}", superscript(&format!("{exponent}"))),
            (digits, None) => digits,
        }
    }

    fn symbol(&self, symbol: &Symbol) -> String {
        let mut text: String = symbol.variation.into_iter().collect();
        text.push_str(&symbol.base);
        for accent in &symbol.accents {
            text.push(match accent {
                Accent::Hat => '\u{302}',
                Accent::Bar => '\u{304}',
                Accent::Tilde => '\u{303}',
                Accent::Dot => '\u{307}',
                Accent::Star => '*',
                Accent::Prime => '′',
            });
        }
        if let [index] = &symbol.subscripts[..]
            && index.chars().all(|c| c.is_ascii_digit())
        {
            text.extend(index.chars().filter_map(|c| char::from_u32('₀' as u32 + c as u32 - '0' as u32)));
        } else if !symbol.subscripts.is_empty() {
            text.push('_');
            text.push_str(&symbol.subscripts.join(","));
        }
        text
    }

    fn word(&self, word: &str) -> String {
        word.into()
    }

    fn sign(&self, sign: &str) -> String {
        sign.into()
    }

    fn between(&self, sign: &str) -> String {
        if sign == "," { ", ".into() } else { format!(" {sign} ") }
    }

    fn row(&self, parts: &[String]) -> String {
        parts.concat()
    }

    fn space(&self) -> String {
        " ".into()
    }

    fn fenced(&self, open: &str, inner: String, close: &str) -> String {
        format!("{open}{inner}{close}")
    }

    fn fraction(&self, numerator: String, denominator: String) -> String {
        format!("({numerator})/({denominator})")
    }

    fn power(&self, base: String, exponent: String) -> String {
        match superscript(&exponent) {
            plain if !plain.is_empty() => format!("{base}{plain}"),
            _ if exponent.chars().count() == 1 => format!("{base}^{exponent}"),
            _ => format!("{base}^({exponent})"),
        }
    }

    fn subscript(&self, base: String, index: String) -> String {
        match index.as_str() {
            "+" => format!("{base}₊"),
            "−" => format!("{base}₋"),
            _ => format!("{base}_{index}"),
        }
    }

    fn root(&self, inner: String) -> String {
        match inner.chars().count() {
            1 => format!("√{inner}"),
            _ => format!("√({inner})"),
        }
    }

    fn integral(&self, region: String, density: String, measure: &str) -> String {
        format!("∫_{region} {density} {measure}")
    }

    fn cases(&self, rows: &[(String, Option<String>)]) -> String {
        let rows: Vec<String> = rows
            .iter()
            .map(|(value, condition)| match condition {
                Some(condition) => format!("{value} if {condition}"),
                None => format!("{value} otherwise"),
            })
            .collect();
        format!("{{ {}", rows.join("; "))
    }

    fn matrix(&self, rows: &[Vec<String>]) -> String {
        let rows: Vec<String> = rows.iter().map(|row| row.join(", ")).collect();
        format!("[{}]", rows.join("; "))
    }
}

/// Digits, signs and the T of a transpose raised; empty if there is something else.
fn superscript(text: &str) -> String {
    let raised = text.chars().map(|c| match c {
        '0' => Some('⁰'),
        '1' => Some('¹'),
        '2' => Some('²'),
        '3' => Some('³'),
        '4'..='9' => char::from_u32('⁴' as u32 + c as u32 - '4' as u32),
        '-' | '−' => Some('⁻'),
        '+' => Some('⁺'),
        'T' => Some('ᵀ'),
        _ => None,
    });
    raised.collect::<Option<String>>().unwrap_or_default()
}
