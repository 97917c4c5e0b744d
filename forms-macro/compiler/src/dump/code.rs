//! After `emit`: the kernels of a function, as Rust with one statement per line.

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

use super::Dump;
use super::counts::kernels;

impl Dump {
    /// Operations and code of what is asked for, from all that a module emitted.
    pub fn emitted(&mut self, functions: &[String], dimensions: &[usize], code: &TokenStream) {
        for name in functions {
            for &dimension in dimensions {
                if !self.wants(name, dimension) {
                    continue;
                }
                let kernel_module =
                    module(code, name).and_then(|form| module(&form, &format!("kernels_{dimension}")));
                if let Some(kernel_module) = kernel_module {
                    self.counts(name, dimension, &kernels(kernel_module.clone()));
                    self.heading("emitted", name, dimension);
                    self.text += &pretty(kernel_module);
                }
            }
        }
    }
}

/// The inside of `mod name { .. }`.
fn module(code: &TokenStream, name: &str) -> Option<TokenStream> {
    let mut words = [String::new(), String::new()];
    for token in code.clone() {
        match token {
            TokenTree::Group(group) if words == ["mod", name] => return Some(group.stream()),
            token => {
                words.rotate_left(1);
                words[1] = token.to_string();
            }
        }
    }
    None
}

/// One statement per line, indented by braces. Enough for what the compiler emits, which is straight-line code.
pub fn pretty(tokens: TokenStream) -> String {
    let mut text = String::new();
    block(tokens, 0, &mut text);
    text
}

fn block(tokens: TokenStream, depth: usize, text: &mut String) {
    let mut line = Line::default();
    for token in tokens {
        match &token {
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
                line.add_text("{");
                line.end(depth, text);
                block(group.stream(), depth + 1, text);
                line.add_text("}");
                line.end(depth, text);
            }
            token => {
                line.add(token);
                if matches!(token, TokenTree::Punct(punct) if punct.as_char() == ';') {
                    line.end(depth, text);
                }
            }
        }
    }
    line.end(depth, text);
}

/// A line that grows by tokens.
#[derive(Default)]
struct Line {
    text: String,
    /// The next token follows without a space.
    tight: bool,
}

impl Line {
    fn end(&mut self, depth: usize, text: &mut String) {
        if !self.text.is_empty() {
            *text += &format!("{}{}\n", "    ".repeat(depth), self.text);
        }
        *self = Line::default();
    }

    fn add_text(&mut self, word: &str) {
        if !self.tight && !self.text.is_empty() {
            self.text.push(' ');
        }
        self.text += word;
        self.tight = false;
    }

    fn add(&mut self, token: &TokenTree) {
        match token {
            TokenTree::Group(group) => {
                let (open, close) = match group.delimiter() {
                    Delimiter::Parenthesis => ("(", ")"),
                    Delimiter::Bracket => ("[", "]"),
                    Delimiter::Brace => ("{", "}"),
                    Delimiter::None => ("", ""),
                };
                let mut inside = Line { tight: true, ..Line::default() };
                group.stream().into_iter().for_each(|token| inside.add(&token));
                // After a name or a group this is a call or an index.
                self.tight |=
                    self.text.ends_with(|last: char| last.is_alphanumeric() || "_)]>#!".contains(last));
                self.add_text(&format!("{open}{}{close}", inside.text));
            }
            TokenTree::Punct(punct) => {
                let character = punct.as_char();
                let arrow = character == '>' && self.text.ends_with('-');
                // Angle brackets are those of generics: comparisons are functions.
                self.tight |= ",;:.<>#!?".contains(character);
                self.add_text(&character.to_string());
                self.tight = !arrow && (punct.spacing() == Spacing::Joint || ".<#&'".contains(character));
                self.tight |= character == ':' && self.text.ends_with("::");
            }
            TokenTree::Literal(literal) => {
                let text = literal.to_string();
                self.add_text(text.trim_end_matches("usize").trim_end_matches("f64"));
            }
            TokenTree::Ident(name) => self.add_text(&name.to_string()),
        }
    }
}
