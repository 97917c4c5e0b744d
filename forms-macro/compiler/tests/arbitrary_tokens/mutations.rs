//! Random changes of token streams.

use proc_macro2::{Delimiter, Group, Ident, Literal, Punct, Spacing, Span, TokenStream, TokenTree};

/// Steele, Lea, Flood (2014): SplitMix64.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as usize % count.max(1)
    }
}

const WORDS: &[&str] = &[
    "u",
    "v",
    "w",
    "x",
    "n",
    "h",
    "I",
    "D",
    "PI",
    "self",
    "Self",
    "crate",
    "super",
    "fn",
    "pub",
    "mod",
    "struct",
    "let",
    "if",
    "else",
    "match",
    "loop",
    "unsafe",
    "async",
    "const",
    "mut",
    "ref",
    "as",
    "in",
    "return",
    "move",
    "true",
    "Scalar",
    "Vector",
    "Tensor",
    "Matrix",
    "Tensor4",
    "Unknown",
    "Test",
    "State",
    "Param",
    "Given",
    "Form",
    "Energy",
    "Functional",
    "Data",
    "Omega",
    "Gamma",
    "dot",
    "inner",
    "outer",
    "grad",
    "div",
    "eps",
    "hess",
    "det",
    "inv",
    "cof",
    "tr",
    "pow",
    "min",
    "max",
    "sqrt",
    "abs",
    "integral",
    "derivative",
    "diff",
    "contract",
    "f64",
    "r#fn",
    "σ",
    "a·b",
    "jump",
    "avg",
    "cells",
    "facets",
    "interior_facets",
    "_",
    "Some",
    "None",
    "Ok",
    "Box",
    "Into",
    "usize",
    "cfg",
    "derive",
    "doc",
    "allow",
    "at",
    "where",
    "extern",
    "use",
    "r#u",
    "r#type",
    "laplace",
    "dx",
    "shape",
    "tensor_exp",
    "history",
    "Table",
    "History",
    "Carried",
    "extends",
    "includes",
    "included",
    "first_included",
    "imported",
    "default",
    "Required",
    "Rest",
];

const LITERALS: &[&str] = &[
    "0",
    "1",
    "2",
    "17",
    "3.5",
    "1e400",
    "1e-300",
    "0.5f32",
    "7usize",
    "99999999999999999999999",
    "\"text\"",
    "'c'",
    "b\"bytes\"",
    "0x1F",
    "1_000",
];

const SIGNS: &str = "+-*/%^!&|=<>@.,;:#$?~";

/// A token of any kind.
fn token(random: &mut Random) -> TokenTree {
    match random.below(8) {
        0..3 => {
            let word = WORDS[random.below(WORDS.len())];
            match word.strip_prefix("r#") {
                Some(word) => TokenTree::Ident(Ident::new_raw(word, Span::call_site())),
                None => TokenTree::Ident(Ident::new(word, Span::call_site())),
            }
        }
        3..5 => {
            let literal: Literal = LITERALS[random.below(LITERALS.len())].parse().expect("a literal");
            TokenTree::Literal(literal)
        }
        5..7 => {
            let sign = SIGNS.chars().nth(random.below(SIGNS.len())).unwrap_or('+');
            let spacing = if random.below(2) == 0 { Spacing::Alone } else { Spacing::Joint };
            TokenTree::Punct(Punct::new(sign, spacing))
        }
        _ => TokenTree::Group(Group::new(delimiter(random), soup(random, 3))),
    }
}

fn delimiter(random: &mut Random) -> Delimiter {
    [Delimiter::Parenthesis, Delimiter::Brace, Delimiter::Bracket, Delimiter::None][random.below(4)]
}

/// Tokens without any order.
pub fn soup(random: &mut Random, count: usize) -> TokenStream {
    (0..random.below(count + 1)).map(|_| token(random)).collect()
}

/// The tokens with one change, somewhere.
pub fn mutate(tokens: TokenStream, random: &mut Random) -> TokenStream {
    let mut list: Vec<TokenTree> = tokens.into_iter().collect();
    let groups: Vec<usize> =
        (0..list.len()).filter(|index| matches!(list[*index], TokenTree::Group(_))).collect();
    // Most tokens are inside groups.
    if !groups.is_empty() && random.below(8) != 0 {
        let index = groups[random.below(groups.len())];
        if let TokenTree::Group(group) = &list[index] {
            let inside = mutate(group.stream(), random);
            list[index] = TokenTree::Group(Group::new(group.delimiter(), inside));
        }
        return list.into_iter().collect();
    }
    let place = random.below(list.len());
    if list.is_empty() {
        return [token(random)].into_iter().collect();
    }
    match random.below(8) {
        0 => {
            list.remove(place);
        }
        1 => list.insert(place, list[place].clone()),
        2 => {
            let other = random.below(list.len());
            list.swap(place, other);
        }
        3 => list[place] = token(random),
        4 => list.insert(place, token(random)),
        5 => {
            let one = [list[place].clone()].into_iter().collect();
            list[place] = TokenTree::Group(Group::new(delimiter(random), one));
        }
        6 => {
            let inside = soup(random, 3);
            let attribute = TokenTree::Group(Group::new(Delimiter::Bracket, inside));
            list.splice(place..place, [TokenTree::Punct(Punct::new('#', Spacing::Alone)), attribute]);
        }
        // A part of it, elsewhere.
        _ => {
            let part: Vec<_> = list[place..(place + 4).min(list.len())].to_vec();
            let at = random.below(list.len());
            list.splice(at..at, part);
        }
    }
    list.into_iter().collect()
}
