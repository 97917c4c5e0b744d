//! A formula as MathML, which browsers draw without a script.

use super::notation::{Notation, decimal};
use super::symbols::{Accent, Symbol};

pub struct MathMl;

impl Notation for MathMl {
    const FLAT: bool = false;

    fn number(&self, value: f64) -> String {
        let (digits, exponent) = decimal(value);
        let (minus, digits) = match digits.strip_prefix('−') {
            Some(digits) => ("<mo form=\"prefix\">−</mo>", digits.to_string()),
            None => ("", digits),
        };
        match exponent {
            Some(exponent) => {
                let exponent = format!("{exponent}").replace('-', "−");
                format!(
                    "<mrow>{minus}<mn>{digits}</mn><mo>⋅</mo><msup><mn>10</mn><mn>{exponent}</mn></msup></mrow>"
                )
            }
            None if minus.is_empty() => format!("<mn>{digits}</mn>"),
            None => format!("<mrow>{minus}<mn>{digits}</mn></mrow>"),
        }
    }

    fn symbol(&self, symbol: &Symbol) -> String {
        let mut text = identifier(&symbol.base);
        let mut raised = String::new();
        for accent in &symbol.accents {
            let above = match accent {
                Accent::Hat => "^",
                Accent::Bar => "¯",
                Accent::Tilde => "~",
                Accent::Dot => "˙",
                Accent::Star => {
                    raised.push_str("<mo>∗</mo>");
                    continue;
                }
                Accent::Prime => {
                    raised.push_str("<mo>′</mo>");
                    continue;
                }
            };
            text = format!("<mover accent=\"true\">{text}<mo>{above}</mo></mover>");
        }
        let parts: Vec<String> = symbol
            .subscripts
            .iter()
            .map(|part| match part.chars().all(|c| c.is_ascii_digit()) {
                true => format!("<mn>{part}</mn>"),
                false => identifier(part),
            })
            .collect();
        let index = match parts.len() {
            0 | 1 => parts.concat(),
            _ => format!("<mrow>{}</mrow>", parts.join("<mo>,</mo>")),
        };
        text = match (index.is_empty(), raised.is_empty()) {
            (true, true) => text,
            (false, true) => format!("<msub>{text}{index}</msub>"),
            (true, false) => format!("<msup>{text}<mrow>{raised}</mrow></msup>"),
            (false, false) => format!("<msubsup>{text}{index}<mrow>{raised}</mrow></msubsup>"),
        };
        match symbol.variation {
            Some(sign) => format!("<mrow><mi>{sign}</mi>{text}</mrow>"),
            None => text,
        }
    }

    fn word(&self, word: &str) -> String {
        match word {
            "−T" => "<mrow><mo>−</mo><mi mathvariant=\"normal\">T</mi></mrow>".into(),
            "+" | "−" => format!("<mo>{word}</mo>"),
            _ => format!("<mi mathvariant=\"normal\">{}</mi>", escape(word)),
        }
    }

    fn sign(&self, sign: &str) -> String {
        match sign {
            "∇²" => "<msup><mo>∇</mo><mn>2</mn></msup>".into(),
            "D" => "<mi>D</mi>".into(),
            "·" => "<mo>⋅</mo>".into(),
            "−" | "∇" | "∂" | "¬" => format!("<mo form=\"prefix\">{sign}</mo>"),
            _ => format!("<mo>{}</mo>", escape(sign)),
        }
    }

    fn between(&self, sign: &str) -> String {
        let form = if sign == "," { "" } else { " form=\"infix\"" };
        format!("<mo{form}>{}</mo>", escape(sign))
    }

    fn row(&self, parts: &[String]) -> String {
        let parts: Vec<&str> = parts.iter().map(String::as_str).filter(|part| !part.is_empty()).collect();
        match parts[..] {
            [one] => one.to_string(),
            _ => format!("<mrow>{}</mrow>", parts.concat()),
        }
    }

    fn space(&self) -> String {
        "<mspace width=\"0.17em\"></mspace>".into()
    }

    fn fenced(&self, open: &str, inner: String, close: &str) -> String {
        let mark = |sign: &str, form: &str| format!("<mo form=\"{form}\" stretchy=\"true\">{sign}</mo>");
        format!("<mrow>{}{inner}{}</mrow>", mark(open, "prefix"), mark(close, "postfix"))
    }

    fn fraction(&self, numerator: String, denominator: String) -> String {
        format!("<mfrac>{numerator}{denominator}</mfrac>")
    }

    fn power(&self, base: String, exponent: String) -> String {
        format!("<msup>{base}{exponent}</msup>")
    }

    fn subscript(&self, base: String, index: String) -> String {
        format!("<msub>{base}{index}</msub>")
    }

    fn root(&self, inner: String) -> String {
        format!("<msqrt>{inner}</msqrt>")
    }

    fn integral(&self, region: String, density: String, measure: &str) -> String {
        let mut letters = measure.chars();
        let d: String = letters.next().into_iter().collect();
        format!(
            "<mrow><msub><mo>∫</mo>{region}</msub>{density}{}<mi mathvariant=\"normal\">{d}</mi><mi>{}</mi></mrow>",
            self.space(),
            letters.as_str()
        )
    }

    fn cases(&self, rows: &[(String, Option<String>)]) -> String {
        let mut table = String::new();
        for (value, condition) in rows {
            let condition = match condition {
                Some(condition) => format!("<mrow><mtext>if\u{a0}</mtext>{condition}</mrow>"),
                None => "<mtext>otherwise</mtext>".into(),
            };
            table.push_str(&format!("<mtr><mtd>{value}</mtd><mtd>{condition}</mtd></mtr>"));
        }
        format!("<mrow><mo form=\"prefix\" stretchy=\"true\">{{</mo><mtable>{table}</mtable></mrow>")
    }

    fn matrix(&self, rows: &[Vec<String>]) -> String {
        let mut table = String::new();
        for row in rows {
            let entries: String = row.iter().map(|entry| format!("<mtd>{entry}</mtd>")).collect();
            table.push_str(&format!("<mtr>{entries}</mtr>"));
        }
        self.fenced("(", format!("<mtable>{table}</mtable>"), ")")
    }
}

/// A letter in italics, a word upright, as `mi` does by itself.
fn identifier(text: &str) -> String {
    format!("<mi>{}</mi>", escape(text))
}

/// Text inside an element.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
