//! Where a scalar is positive along the facets of a plane mesh: the parts between its zeros, which lie anywhere on a
//! facet, not at quadrature points.

use forms_core::contract::Expression;

use super::{Assembler, AssemblyError, FacetSample};
use crate::mesh::Facet;
use crate::quadrature::sign_changes::{Polynomial, samples};

/// Corrections of a zero by the function itself; each gains the digits to which the interpolation is right.
const CORRECTIONS: usize = 6;

/// A part of a facet on which a scalar is positive.
#[derive(Clone, Debug, PartialEq)]
pub struct PositivePart {
    /// The facet; an interior one from its first side.
    pub facet: Facet,
    /// Its ends on the facet's own \[0, 1\].
    pub parameters: [f64; 2],
    /// Its ends in the plane.
    pub positions: [[f64; 2]; 2],
}

impl Assembler<2> {
    /// The parts of a region's facets on which a scalar is positive, facet by facet in the region's order. On each facet
    /// the scalar is interpolated by a polynomial of a degree, whose every change of sign is found, and each zero is
    /// corrected by the scalar itself. Exact to rounding where the scalar is such a polynomial along each facet (σ_n and u of
    /// degree k on affine cells); on curved facets zeros that the interpolation misses, closer to each other than it is
    /// right, are missed.
    ///
    /// # Errors
    /// An unknown region, a function that is no scalar, a value that is not finite, or data that do not fit.
    pub fn positive_parts<E: Expression<2>>(
        &self,
        expression: &E,
        region: &str,
        degree: usize,
    ) -> Result<Vec<PositivePart>, AssemblyError> {
        let components: usize = expression.shape().iter().product();
        if components != 1 {
            let (form, field) = (expression.name(), "a scalar");
            return Err(AssemblyError::Components { form, field, expected: 1, found: components });
        }
        let at = |parameters: &[f64]| -> Result<Vec<FacetSample<2>>, AssemblyError> {
            let places: Vec<[f64; 2]> = parameters.iter().map(|s| [*s, 0.0]).collect();
            self.along_facets(expression, region, &places)
        };
        let nodes = samples(degree);
        let sampled = at(&nodes)?;
        let facets: Vec<Polynomial> = sampled
            .chunks(nodes.len())
            .map(|facet| Polynomial::through(&facet.iter().map(|sample| sample.value[0]).collect::<Vec<_>>()))
            .collect();
        let mut zeros: Vec<Zero> =
            facets.iter().enumerate().flat_map(|(k, facet)| Zero::all(k, facet)).collect();
        // All zeros of all facets at once: there are few of them.
        for _ in 0..CORRECTIONS {
            let parameters: Vec<f64> = zeros.iter().map(|zero| zero.at).collect();
            if parameters.is_empty() {
                break;
            }
            let values = at(&parameters)?;
            for (k, zero) in zeros.iter_mut().enumerate() {
                zero.correct(values[zero.facet * parameters.len() + k].value[0]);
            }
        }
        let mut parameters = vec![0.0, 1.0];
        parameters.extend(zeros.iter().map(|zero| zero.at));
        let ends = at(&parameters)?;
        let mut parts = Vec::new();
        for (index, polynomial) in facets.iter().enumerate() {
            let mine = zeros.iter().enumerate().filter(|(_, zero)| zero.facet == index).map(|(k, _)| k + 2);
            let places: Vec<usize> = [0].into_iter().chain(mine).chain([1]).collect();
            for pair in places.windows(2) {
                let bounds = [pair[0], pair[1]].map(|place| &ends[index * parameters.len() + place]);
                let parameters = [pair[0], pair[1]].map(|place| parameters[place]);
                if polynomial.at(0.5 * (parameters[0] + parameters[1])) > 0.0 {
                    let positions = bounds.map(|sample| sample.position);
                    parts.push(PositivePart { facet: bounds[0].facet, parameters, positions });
                }
            }
        }
        Ok(parts)
    }
}

/// A zero of the scalar on a facet.
struct Zero {
    /// Index in the region.
    facet: usize,
    at: f64,
    /// The interpolation's slope there.
    slope: f64,
    /// It must not leave these bounds, half way to its neighbours.
    bounds: [f64; 2],
}

impl Zero {
    fn all(facet: usize, polynomial: &Polynomial) -> Vec<Zero> {
        let found = polynomial.sign_changes();
        let before = |k: usize| if k == 0 { 0.0 } else { 0.5 * (found[k - 1] + found[k]) };
        let bounds = |k: usize| [before(k), if k + 1 == found.len() { 1.0 } else { before(k + 1) }];
        let zero =
            |(k, at): (usize, &f64)| Zero { facet, at: *at, slope: polynomial.slope(*at), bounds: bounds(k) };
        found.iter().enumerate().map(zero).collect()
    }

    fn correct(&mut self, value: f64) {
        let corrected = self.at - value / self.slope;
        if corrected > self.bounds[0] && corrected < self.bounds[1] {
            self.at = corrected;
        }
    }
}
