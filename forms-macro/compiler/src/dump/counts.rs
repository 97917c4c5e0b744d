//! Floating-point operations of emitted kernels, counted in the code itself: an addition, subtraction, multiplication,
//! division, function or comparison is one, `multiply_add` two; a sign and a literal are none.

use proc_macro2::{Delimiter, TokenStream, TokenTree};

use super::Dump;

/// Operations of each function of one kernel: `("point", 4)`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KernelCounts {
    pub kernel: String,
    pub functions: Vec<(String, usize)>,
}

/// The kernels of one dimension's module.
pub fn kernels(tokens: TokenStream) -> Vec<KernelCounts> {
    let tokens: Vec<TokenTree> = tokens.into_iter().collect();
    let mut found: Vec<KernelCounts> = Vec::new();
    let mut start = 0;
    // `impl .. Name { fn .. }`: the name is the last before the braces; `new` belongs to the form's level.
    for (index, token) in tokens.iter().enumerate() {
        if is_word(token, "impl") {
            start = index;
        }
        let TokenTree::Group(group) = token else { continue };
        if group.delimiter() != Delimiter::Brace || !is_word(&tokens[start], "impl") || index == 0 {
            continue;
        }
        let kernel = tokens[index - 1].to_string();
        let functions = functions(group.stream());
        match found.iter_mut().find(|one| one.kernel == kernel) {
            Some(one) => one.functions.extend(functions),
            None => found.push(KernelCounts { kernel, functions }),
        }
        start = index;
    }
    found
}

fn is_word(token: &TokenTree, word: &str) -> bool {
    matches!(token, TokenTree::Ident(name) if name == word)
}

/// `fn name .. { body }`
fn functions(tokens: TokenStream) -> Vec<(String, usize)> {
    let mut found = Vec::new();
    let mut name: Option<String> = None;
    let mut after_fn = false;
    for token in tokens {
        match token {
            TokenTree::Ident(word) if after_fn => {
                name = Some(if word == "new" { "form".into() } else { word.to_string() });
                after_fn = false;
            }
            TokenTree::Ident(word) => after_fn = word == "fn",
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
                found.extend(name.take().map(|name| (name, operations(group.stream()))));
            }
            _ => {}
        }
    }
    found
}

/// Operations in straight-line code.
pub fn operations(tokens: TokenStream) -> usize {
    // `let (t0, t1);` declares, and is no call; what a part does is counted in the part.
    const FREE: &[&str] = &["splat", "new", "load", "let", "apart"];
    let mut count = 0;
    // Does a value end here, so that an operator that follows is binary?
    let mut after_value = false;
    let mut word = String::new();
    for token in tokens {
        match token {
            TokenTree::Punct(punct) => {
                if after_value && "+-*/".contains(punct.as_char()) {
                    count += 1;
                }
                after_value = false;
                word.clear();
            }
            TokenTree::Group(group) => {
                let call = group.delimiter() == Delimiter::Parenthesis && !word.is_empty();
                if call && !FREE.contains(&word.as_str()) {
                    count += if word == "multiply_add" { 2 } else { 1 };
                }
                count += operations(group.stream());
                after_value = true;
                word.clear();
            }
            TokenTree::Ident(name) => {
                word = name.to_string();
                after_value = word != "let";
            }
            TokenTree::Literal(_) => {
                after_value = true;
                word.clear();
            }
        }
    }
    count
}

impl Dump {
    /// One line per kernel.
    pub fn counts(&mut self, name: &str, dimension: usize, kernels: &[KernelCounts]) {
        self.heading("operations per call", name, dimension);
        for one in kernels {
            let counts: Vec<String> =
                one.functions.iter().map(|(function, count)| format!("{function} {count}")).collect();
            self.text += &format!("  {}: {}\n", one.kernel, counts.join(", "));
        }
    }
}
