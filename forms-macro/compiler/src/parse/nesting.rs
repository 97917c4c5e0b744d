//! The depth to which tokens nest, counted without recursion: before `syn`, which recurses, sees them.

use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// Operators of one statement that may be one inside the other, and four per bracket around it. A form that people read has
/// fewer than fifty. The compiler recurses about as deep; rustc's stack of 8 MB holds several times as much, and less than twice as much where
/// `syn` is not optimised (`deep_nesting` in `tests/arbitrary_tokens`).
const LIMIT: usize = 512;
const BRACKET: usize = 4;

/// Words that precede what they belong to, or chain it.
const WORDS: &[&str] = &[
    "as", "async", "await", "break", "const", "dyn", "else", "for", "if", "impl", "in", "let", "loop",
    "match", "move", "mut", "ref", "return", "static", "unsafe", "while", "yield",
];

/// An error on the statement that nests too deep.
pub fn check(tokens: TokenStream) -> syn::Result<()> {
    let mut pending = vec![(tokens, 0)];
    while let Some((tokens, outside)) = pending.pop() {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut start = 0;
        for end in 0..tokens.len() {
            if !ends_statement(&tokens[end], tokens.get(end + 1)) && end + 1 < tokens.len() {
                continue;
            }
            let statement = &tokens[start..=end];
            let depth = outside + operators(statement);
            if depth > LIMIT {
                let message = "this expression is too long or nests too deep to be compiled\nhelp: give parts of it names with `let`, or write functions";
                return Err(syn::Error::new(statement[0].span(), message));
            }
            let groups = statement.iter().filter_map(|token| match token {
                TokenTree::Group(group) => Some((group.stream(), depth)),
                _ => None,
            });
            pending.extend(groups);
            start = end + 1;
        }
    }
    Ok(())
}

/// `;` and `,` end a statement, and so does a block that nothing continues.
fn ends_statement(token: &TokenTree, next: Option<&TokenTree>) -> bool {
    match token {
        TokenTree::Punct(sign) => matches!(sign.as_char(), ';' | ','),
        TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => match next {
            Some(TokenTree::Ident(word)) => *word != "else" && *word != "as",
            Some(TokenTree::Punct(sign)) => sign.as_char() == '#',
            Some(TokenTree::Group(_)) => false,
            _ => true,
        },
        _ => false,
    }
}

/// The depth that the operators of a statement reach. In a sum of products and calls each sign is one, and the longest term counts
/// besides: terms are next to each other. In all else every operator may be inside the one before.
fn operators(statement: &[TokenTree]) -> usize {
    let is_sign =
        |token: &TokenTree, sign: char| matches!(token, TokenTree::Punct(one) if one.as_char() == sign);
    if matches!(statement.first(), Some(TokenTree::Ident(word)) if word == "let")
        && let Some(place) = statement.iter().position(|token| is_sign(token, '='))
    {
        return 2 + operators(&statement[1..place]) + operators(&statement[place + 1..]);
    }
    let (mut signs, mut longest, mut term, mut all) = (0, 0, 0, 0);
    let mut is_sum = true;
    let mut tokens = statement.iter().peekable();
    while let Some(token) = tokens.next() {
        let count = match token {
            // An attribute, such as a line of documentation.
            TokenTree::Punct(sign)
                if sign.as_char() == '#' && matches!(tokens.peek(), Some(TokenTree::Group(_))) =>
            {
                tokens.next();
                0
            }
            TokenTree::Punct(sign) => {
                match sign.as_char() {
                    '+' | '-' => {
                        signs += 1;
                        all += 1;
                        (longest, term) = (longest.max(term), 0);
                        continue;
                    }
                    '*' | '/' | ';' | ',' => {}
                    _ => is_sum = false,
                }
                1
            }
            TokenTree::Group(_) => BRACKET,
            TokenTree::Ident(word) => {
                let chains = WORDS.iter().any(|known| word == known);
                is_sum &= !chains;
                usize::from(chains)
            }
            TokenTree::Literal(_) => 0,
        };
        term += count;
        all += count;
    }
    if is_sum { signs + longest.max(term) } else { all }
}
