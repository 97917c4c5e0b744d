//! One argument per unknown: a reference for a form with one unknown, an array of references for several.

/// References for each of N unknowns: `&u` for one, `[&u, &p]` or `&[u, p]` for two.
pub trait PerUnknown<'a, T, const N: usize> {
    /// One reference per unknown, in the order of the form's arguments.
    fn per_unknown(self) -> [&'a T; N];
}

impl<'a, T> PerUnknown<'a, T, 1> for &'a T {
    fn per_unknown(self) -> [&'a T; 1] {
        [self]
    }
}

impl<'a, T, const N: usize> PerUnknown<'a, T, N> for [&'a T; N] {
    fn per_unknown(self) -> [&'a T; N] {
        self
    }
}

impl<'a, T, const N: usize> PerUnknown<'a, T, N> for &'a [T; N] {
    fn per_unknown(self) -> [&'a T; N] {
        self.each_ref()
    }
}
