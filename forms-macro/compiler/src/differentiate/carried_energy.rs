//! Energies over contact pairs that an unknown displaces: densities whose motion of points completes the first variation.

use super::lowering::Lowering;
use super::sources::Source;
use crate::check::Term;
use crate::tensor::{FieldInfo, FieldRole, Operator};

/// The densities of an energy on pairs that its unknowns displace. All integrals on a region with a displacement are together: what is assembled of
/// them has one rule.
#[derive(Default)]
pub(super) struct CarriedEnergy {
    /// The fields of unknowns, each with its test function.
    varied: Vec<(usize, usize)>,
    /// Regions and displacements.
    pub keys: Vec<(usize, Vec<usize>)>,
    /// Of each of them, the integrals with lowered densities.
    lowered: Vec<Vec<Term>>,
    sources: Vec<Vec<Source>>,
}

impl CarriedEnergy {
    pub fn vary(&mut self, pair: (usize, usize)) {
        self.varied.push(pair);
    }

    /// Finds the integrals of an energy whose points move. None has means over own facets, nor a density that is a derivative at held points itself.
    pub fn take(&mut self, lowering: &mut Lowering, energy: &[Term], fields: &[FieldInfo]) {
        let unknown = |field: &usize| matches!(fields[*field].role, FieldRole::Unknown(_));
        let mut held = vec![];
        for term in energy.iter().filter(|term| term.means.is_none()) {
            let Some(by) = term.displacement.as_ref().filter(|by| by.iter().any(unknown)) else { continue };
            let key = (term.region, by.clone());
            if lowering.moves_points(term.density, by, &[]) {
                held.push(key.clone());
            }
            let density = lowering.lower(term.density);
            let parts = lowering.parts(density).into_iter().map(|density| Source {
                density,
                directions: self.varied.clone(),
                by_shape: false,
                moves: true,
            });
            let place = self.keys.iter().position(|known| *known == key).unwrap_or_else(|| {
                self.keys.push(key);
                self.lowered.push(vec![]);
                self.sources.push(vec![]);
                self.keys.len() - 1
            });
            self.sources[place].extend(parts);
            self.lowered[place].push(term.with(density));
        }
        for place in
            (0..self.keys.len()).rev().filter(|place| held.contains(&self.keys[*place])).collect::<Vec<_>>()
        {
            self.keys.remove(place);
            self.lowered.remove(place);
            self.sources.remove(place);
        }
    }

    fn place_of(&self, term: &Term) -> Option<usize> {
        let by = term.displacement.as_ref().filter(|_| term.means.is_none())?;
        self.keys.iter().position(|(region, known)| *region == term.region && known == by)
    }

    /// All densities on the points of an integral: its derivatives have the same ones.
    pub fn sources_of(&self, term: &Term) -> Vec<Source> {
        self.place_of(term).map_or(vec![], |place| self.sources[place].clone())
    }

    /// In the plane, where points have second derivatives, each density times the first component of the test function of each unknown that displaces
    /// its points.
    pub fn terms(&self, lowering: &mut Lowering, fields: &[FieldInfo]) -> Vec<Term> {
        let mut terms = vec![];
        if lowering.dimension != 2 {
            return terms;
        }
        for ((_, by), lowered) in self.keys.iter().zip(&self.lowered) {
            for (_, test) in self.varied.iter().filter(|(unknown, _)| by.contains(unknown)) {
                for term in lowered {
                    let operator = Operator::Field { field: *test, order: 0 };
                    let span = lowering.arena.span(term.density);
                    let direction = lowering.arena.push(operator, fields[*test].shape.clone(), span);
                    terms.push(term.with(lowering.times_first_component(term.density, direction)));
                }
            }
        }
        terms
    }
}
