//! The positive parts of a scalar along the facets of a plane mesh: those between its zeros, which lie anywhere on a
//! facet, not at quadrature points.

use crate::contract::Expression;

use crate::assemble::{Assembler, AssemblyError, FacetSample};
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
    pub fn positive_parts(
        &self,
        expression: &Expression<2>,
        region: &str,
        degree: usize,
    ) -> Result<Vec<PositivePart>, AssemblyError> {
        let facets = self.facet_zeros(expression, region, degree)?;
        let mut parameters = vec![0.0, 1.0];
        parameters.extend(facets.iter().flat_map(|facet| facet.zeros.iter().copied()));
        let places: Vec<[f64; 2]> = parameters.iter().map(|s| [*s, 0.0]).collect();
        let ends = self.along_facets(expression, region, &places)?;
        let (mut parts, mut used) = (Vec::new(), 2);
        for (index, FacetZeros { facet, zeros, along }) in facets.iter().enumerate() {
            let mine = used..used + zeros.len();
            used = mine.end;
            let places: Vec<usize> = [0].into_iter().chain(mine).chain([1]).collect();
            for pair in places.windows(2) {
                let parameters = [pair[0], pair[1]].map(|place| parameters[place]);
                if along.at(0.5 * (parameters[0] + parameters[1])) > 0.0 {
                    let position = |place: usize| ends[index * ends.len() / facets.len() + place].position;
                    let positions = [pair[0], pair[1]].map(position);
                    parts.push(PositivePart { facet: *facet, parameters, positions });
                }
            }
        }
        Ok(parts)
    }
}

/// The zeros of a scalar along a facet.
pub(in crate::assemble) struct FacetZeros {
    pub facet: Facet,
    /// Ascending, inside (0, 1).
    pub zeros: Vec<f64>,
    /// The scalar, interpolated.
    pub along: Polynomial,
}

impl<const D: usize> Assembler<D> {
    /// The zeros of a scalar along each facet of a plane mesh's region.
    pub(in crate::assemble) fn facet_zeros(
        &self,
        expression: &Expression<D>,
        region: &str,
        degree: usize,
    ) -> Result<Vec<FacetZeros>, AssemblyError> {
        self.expect_scalar(expression)?;
        let at = |parameters: &[f64]| -> Result<Vec<FacetSample<D>>, AssemblyError> {
            let places: Vec<[f64; 2]> = parameters.iter().map(|s| [*s, 0.0]).collect();
            self.along_facets(expression, region, &places)
        };
        let nodes = samples(degree);
        let mut facets = Vec::new();
        let mut zeros = Vec::new();
        for (index, sampled) in at(&nodes)?.chunks(nodes.len()).enumerate() {
            let values: Vec<f64> = sampled.iter().map(|sample| sample.value[0]).collect();
            let along = Polynomial::through(&values);
            zeros.extend(Zero::all(index, &along));
            facets.push(FacetZeros { facet: sampled[0].facet, zeros: vec![], along });
        }
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
        for zero in zeros {
            facets[zero.facet].zeros.push(zero.at);
        }
        Ok(facets)
    }

    pub(in crate::assemble) fn expect_scalar(&self, expression: &Expression<D>) -> Result<(), AssemblyError> {
        match expression.shape().iter().product() {
            1 => Ok(()),
            found => {
                let (form, field) = (expression.name(), "a scalar");
                Err(AssemblyError::Components { form, field, expected: 1, found })
            }
        }
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
