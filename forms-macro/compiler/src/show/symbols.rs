//! Names as symbols: `gamma0` is γ₀, `sigma_n` is σ_n, `GammaC` is Γ_C, `u_hat` is û.

/// Greek letters: the name, the letter, and LaTeX where it is not `\name`.
pub const GREEK: &[(&str, char)] = &[
    ("alpha", 'α'),
    ("beta", 'β'),
    ("gamma", 'γ'),
    ("delta", 'δ'),
    ("epsilon", 'ε'),
    ("zeta", 'ζ'),
    ("eta", 'η'),
    ("theta", 'θ'),
    ("iota", 'ι'),
    ("kappa", 'κ'),
    ("lambda", 'λ'),
    ("mu", 'μ'),
    ("nu", 'ν'),
    ("xi", 'ξ'),
    ("pi", 'π'),
    ("rho", 'ρ'),
    ("sigma", 'σ'),
    ("tau", 'τ'),
    ("upsilon", 'υ'),
    ("phi", 'φ'),
    ("chi", 'χ'),
    ("psi", 'ψ'),
    ("omega", 'ω'),
    ("Gamma", 'Γ'),
    ("Delta", 'Δ'),
    ("Theta", 'Θ'),
    ("Lambda", 'Λ'),
    ("Xi", 'Ξ'),
    ("Pi", 'Π'),
    ("Sigma", 'Σ'),
    ("Upsilon", 'Υ'),
    ("Phi", 'Φ'),
    ("Psi", 'Ψ'),
    ("Omega", 'Ω'),
];

/// Accents, primes and indices of a letter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Accent {
    Hat,
    Bar,
    Tilde,
    Dot,
    Star,
    Prime,
}

const ACCENTS: &[(&str, Accent)] = &[
    ("hat", Accent::Hat),
    ("bar", Accent::Bar),
    ("tilde", Accent::Tilde),
    ("dot", Accent::Dot),
    ("star", Accent::Star),
    ("prime", Accent::Prime),
];

/// A letter or word with what belongs to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Symbol {
    /// δ or Δ before the letter: a direction; ∂: a boundary.
    pub variation: Option<char>,
    /// A letter, or a word, which is upright.
    pub base: String,
    pub accents: Vec<Accent>,
    pub subscripts: Vec<String>,
}

impl Symbol {
    /// From a name, or from the sign that a `doc(alias)` gives.
    pub fn of(name: &str) -> Symbol {
        let name = name.strip_prefix("r#").unwrap_or(name);
        let mut rest = name.chars();
        if let Some(variation @ ('δ' | 'Δ' | '∂')) = rest.next()
            && !rest.as_str().is_empty()
        {
            return Symbol { variation: Some(variation), ..Symbol::of(rest.as_str()) };
        }
        let mut parts = name.split('_').filter(|part| !part.is_empty());
        let Some(first) = parts.next() else { return Symbol::word(name) };
        let (base, index) = split_base(first);
        let mut symbol =
            Symbol { variation: None, base, accents: vec![], subscripts: index.into_iter().collect() };
        // The rest of a word is no index: `body_force` is one name.
        if !symbol.is_letter() {
            return Symbol::word(name);
        }
        for part in parts {
            match ACCENTS.iter().find(|(word, _)| *word == part) {
                Some((_, accent)) => symbol.accents.push(*accent),
                None => symbol.subscripts.push(letter(part).unwrap_or_else(|| part.to_string())),
            }
        }
        symbol
    }

    /// A word, or a letter with a word as its index.
    pub fn is_long(&self) -> bool {
        !self.is_letter() || self.subscripts.iter().any(|index| index.chars().count() > 2)
    }

    /// The sign of a function that is written as an index of its argument: `·_n`.
    pub fn is_index(&self) -> bool {
        self.base == "·" && !self.subscripts.is_empty()
    }

    fn word(name: &str) -> Symbol {
        Symbol { variation: None, base: name.to_string(), accents: vec![], subscripts: vec![] }
    }

    /// A single letter, set in italics.
    pub fn is_letter(&self) -> bool {
        self.base.chars().count() == 1
    }
}

fn letter(name: &str) -> Option<String> {
    GREEK.iter().find(|(word, _)| *word == name).map(|(_, letter)| letter.to_string())
}

/// `gamma0` → γ, 0; `GammaC` → Γ, C; `x12` → x, 12; `Wall` → Wall.
fn split_base(part: &str) -> (String, Option<String>) {
    if let Some(letter) = letter(part) {
        return (letter, None);
    }
    let digits = part.len() - part.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let (front, index) = part.split_at(part.len() - digits);
    if digits > 0 && !front.is_empty() {
        if let Some(letter) = letter(front) {
            return (letter, Some(index.to_string()));
        }
        if front.chars().count() == 1 {
            return (front.to_string(), Some(index.to_string()));
        }
    }
    let greek = GREEK.iter().filter(|(word, _)| part.starts_with(word)).max_by_key(|(word, _)| word.len());
    if let Some((word, letter)) = greek {
        let rest = &part[word.len()..];
        if rest.starts_with(|c: char| c.is_uppercase() || c.is_ascii_digit()) {
            return (letter.to_string(), Some(rest.to_string()));
        }
    }
    (part.to_string(), None)
}
