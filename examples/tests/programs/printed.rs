//! Numbers in what a program has printed.

/// The number after the first occurrence of some words. A full stop after it ends a sentence.
pub(crate) fn after(printed: &str, words: &str) -> f64 {
    let rest = printed.split(words).nth(1).unwrap_or_else(|| panic!("`{words}`: {printed}"));
    let number: String = rest.chars().take_while(|c| c.is_ascii_digit() || "+-.e".contains(*c)).collect();
    number.trim_end_matches('.').parse().unwrap_or_else(|error| panic!("`{words}` {number}: {error}"))
}
