//! The rustdoc page of a function: its formulas as MathML, their LaTeX, and what the letters mean.

use syn::{Attribute, Expr, Lit, Meta};

use super::equations::{Equation, Shown};
use super::formula::Formula;
use super::latex::Latex;
use super::mathml::MathMl;
use super::notation::Notation;
use super::read::symbol;
use super::symbols::Symbol;
use super::unicode::Unicode;
use crate::parse::syntax::{ArgumentRole, Function, Module, Output};

impl Shown {
    /// As lines of plain text.
    pub fn unicode(&self) -> String {
        let line = |equation: &Equation| match equation.is_ellipsis() {
            true => Unicode.print(&equation.left),
            false => format!("{} = {}", Unicode.print(&equation.left), Unicode.print(&equation.right)),
        };
        let mut lines: Vec<String> = self.equations().map(line).collect();
        if !self.definitions.is_empty() {
            lines.push("where".into());
            lines.extend(self.definitions.iter().map(|equation| format!("  {}", line(equation))));
        }
        lines.join("\n")
    }

    /// As LaTeX for the package amsmath: one `align*`, with the definitions last.
    pub fn latex(&self) -> String {
        let mut lines = Vec::new();
        for equation in self.equations().chain(&self.definitions) {
            for (index, [left, sign, right]) in rows(&Latex, equation).into_iter().enumerate() {
                let left = if index == 0 { left } else { "&\\quad".into() };
                let relation = if index == 0 { format!(" &{}", sign.trim()) } else { sign };
                lines.push(format!("  {left}{relation} {right}").replace("&\\quad ", "&\\quad "));
            }
        }
        format!("\\begin{{align*}}\n{}\n\\end{{align*}}", lines.join(" \\\\\n"))
    }

    /// As MathML elements: the function and its derivatives, then the meaning of the names.
    pub fn mathml(&self) -> String {
        let own: Vec<&Equation> = self.equations().collect();
        let mut text = table(&own);
        if !self.definitions.is_empty() {
            let definitions: Vec<&Equation> = self.definitions.iter().collect();
            text.push_str("\n<p>where</p>\n");
            text.push_str(&table(&definitions));
        }
        text
    }

    /// The markdown that follows the author's own documentation.
    pub fn page(&self, module: &Module, function: &Function) -> String {
        let mut page = String::from("\n\n# Formula\n\n");
        page.push_str(&format!("<div style=\"overflow-x: auto\">\n{}\n</div>\n\n", self.mathml()));
        let meanings = meanings(self, module, function);
        if !meanings.is_empty() {
            page.push_str(&meanings.join("\n"));
            page.push_str("\n\n");
        }
        page.push_str(&format!(
            "<details><summary>LaTeX</summary>\n\n```text\n{}\n```\n\n</details>\n",
            self.latex()
        ));
        page
    }

    fn equations(&self) -> impl Iterator<Item = &Equation> {
        [&self.content].into_iter().chain(self.derivatives.iter().map(|(_, equation)| equation))
    }
}

/// One equation in lines, a sum of integrals with one of them in each: left side, sign, right side.
fn rows(notation: &impl Notation, equation: &Equation) -> Vec<[String; 3]> {
    let left = notation.print(&equation.left);
    if equation.is_ellipsis() {
        return vec![[left, String::new(), String::new()]];
    }
    let equals = notation.between("=");
    let terms = match &equation.right {
        Formula::Sum(terms) if terms.iter().any(|(_, term)| matches!(term, Formula::Integral { .. })) => {
            terms
        }
        right => return vec![[left, equals, notation.print(right)]],
    };
    let mut rows = Vec::new();
    for (index, (minus, term)) in terms.iter().enumerate() {
        rows.push(match index {
            0 => {
                let first = Formula::Sum(vec![(*minus, term.clone())]);
                [left.clone(), equals.clone(), notation.print(&first)]
            }
            _ => [String::new(), notation.between(if *minus { "−" } else { "+" }), notation.print(term)],
        });
    }
    rows
}

fn table(equations: &[&Equation]) -> String {
    let mut text = String::from("<math display=\"block\"><mtable>\n");
    let cell = |content: &str, side: &str| {
        let style = format!("text-align: {side}; padding: 0.3ex 0.2em");
        format!("<mtd style=\"{style}\"><mrow displaystyle=\"true\">{content}</mrow></mtd>")
    };
    for equation in equations {
        for [left, sign, right] in rows(&MathMl, equation) {
            let cells = [cell(&left, "right"), cell(&sign, "center"), cell(&right, "left")];
            text.push_str(&format!("<mtr>{}</mtr>\n", cells.concat()));
        }
    }
    text.push_str("</mtable></math>");
    text
}

/// One item of a list per letter.
fn meanings(shown: &Shown, module: &Module, function: &Function) -> Vec<String> {
    let mut lines = Vec::new();
    let letter = |symbol: &Symbol| Unicode.symbol(symbol).replace('*', "\\*");
    for argument in &function.arguments {
        let role = match argument.role {
            ArgumentRole::Unknown => "the unknown",
            ArgumentRole::Test => "the test function",
            ArgumentRole::State => "a known field",
            _ => "any field",
        };
        let name = letter(&Symbol::of(&argument.name.to_string()));
        lines.push(format!("- {name}: {role}, `{}`", argument.rank));
    }
    let derived = !shown.derivatives.is_empty();
    if derived && function.output == Output::Energy {
        lines.push("- δ, Δ: directions of the first and the second derivative".into());
    } else if derived {
        lines.push("- δ: direction of the derivative".into());
    }
    let named = |name: &proc_macro2::Ident, attributes: &[Attribute]| {
        let sign = letter(&symbol(name, attributes));
        match first_paragraph(attributes) {
            // Many an author begins with the sign.
            Some(text) if text.trim_end_matches('.') == sign => format!("- {sign} (`{name}`)"),
            Some(text) if text.starts_with(&sign) => format!("- {text} (`{name}`)"),
            Some(text) => format!("- {sign} (`{name}`): {text}"),
            None => format!("- {sign} (`{name}`)"),
        }
    };
    for region in &shown.regions {
        let region = &module.regions[*region];
        lines.push(named(&region.name, &region.attributes));
    }
    let members: Vec<_> = module.members().collect();
    lines.extend(
        shown.members.iter().map(|member| named(&members[*member].name, &members[*member].attributes)),
    );
    lines
}

/// The beginning of what the author says of a name.
fn first_paragraph(attributes: &[Attribute]) -> Option<String> {
    let mut words = Vec::new();
    for attribute in attributes.iter().filter(|attribute| attribute.path().is_ident("doc")) {
        let Meta::NameValue(pair) = &attribute.meta else { continue };
        let Expr::Lit(literal) = &pair.value else { continue };
        let Lit::Str(text) = &literal.lit else { continue };
        let text = text.value();
        if text.trim().is_empty() && !words.is_empty() {
            break;
        }
        words.push(text.trim().to_string());
    }
    (!words.is_empty()).then(|| words.join(" "))
}
