//! Identity of a search: what two searches with the same pairs have in common.

use forms_core::contract::Pairing;

use crate::quadrature::Quadrature;

/// The object of a search.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SearchKey<const D: usize> {
    pub pairing: Pairing,
    pub quadrature: Quadrature<D>,
    pub degree: usize,
}

impl<const D: usize> SearchKey<D> {
    /// The object of a search with a choice of quadrature; `estimated` is the degree where the choice is the compiler's estimate.
    pub fn new(pairing: &Pairing, quadrature: &Quadrature<D>, estimated: usize) -> Self {
        // Where facets are split elsewhere, pairs keep pieces of their own.
        let mut choice = quadrature;
        while let Quadrature::Split { whole, .. } = choice {
            choice = whole;
        }
        let degree = if choice.follows_estimates() { estimated } else { 0 };
        SearchKey { pairing: pairing.clone(), quadrature: choice.clone(), degree }
    }
}
