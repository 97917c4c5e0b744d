//! Dual functions on own facets of contact pairs: ψ = A φ, biorthogonal to φ over the part of a facet that has opposite points.
//!
//! With integrals over the cover, M_ij = ∫ φ_i φ_j and D_i = ∫ φ_i, A = D M⁻¹ gives ∫ ψ_i φ_j = δ_ij D_i. Functions of a small cover c, a part of
//! the facet, would be large, up to 1/c. So M is (1 − ε) M + ε D with ε = (1 − c)²: then functions are bounded, and dual on whole facets only. As
//! A D = D and 1ᵀA = 1ᵀ for every ε, they have the integrals D_i > 0 and the sum 1 over any cover. With P = M D⁻¹,
//!
//! ```text
//! A = C⁻¹,  C = ε 1 + (1 − ε) P,  δA = −A δC A,  δC = δε (1 − P) + (1 − ε) δP,  δP = (δM − P δD) D⁻¹
//! ```
//!
//! Areas are those of the facet's reference coordinates, as of `Elements::Dual`.

use std::collections::HashMap;
use std::sync::Arc;

use crate::assemble::binding::Tabulated;
use crate::element::{CellShape, Element};
use crate::linear_algebra::small_inverse::small_inverse;
use crate::mesh::Facet;
use crate::pairs::{PairGroup, Pairs};

/// The largest number of functions on a facet.
pub(in crate::assemble) const MOST_FUNCTIONS: usize = 9;
/// A facet whose cover is smaller by less than this part is covered.
const ROUNDING: f64 = 1e-12;

/// The dual functions of the units of a group.
#[derive(Clone)]
pub(in crate::assemble) struct DualFunctions {
    /// A of each unit's own facet, row after row.
    pub matrices: Vec<f64>,
    /// Of all own facets.
    pub covers: Arc<Covers>,
}

impl DualFunctions {
    /// The dual functions of a group's units.
    pub fn of_units<const D: usize>(covers: &Arc<Covers>, group: &PairGroup<D>) -> Self {
        let of_unit = |[own, _]: &[Facet; 2]| covers.facets[own].functions.clone();
        DualFunctions {
            matrices: group.facets.iter().flat_map(of_unit).collect(),
            covers: Arc::clone(covers),
        }
    }
}

/// The covers of the own facets of some pairs.
pub(in crate::assemble) struct Covers {
    facets: HashMap<Facet, Cover>,
}

/// The covered part of an own facet.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::assemble) struct Cover {
    /// ∫ φ_i φ_j, row after row.
    moments: Vec<f64>,
    /// ∫ φ_i.
    areas: Vec<f64>,
    /// ∫ 1 over the whole facet.
    whole: f64,
    /// A.
    functions: Vec<f64>,
}

/// The values of the functions φ at a point of an own facet, and their derivatives along some directions.
fn functions_at<const D: usize>(
    element: &Element,
    nodes: &[usize],
    point: &[f64],
) -> (Vec<f64>, Vec<[f64; D]>) {
    let point: [f64; D] = std::array::from_fn(|k| point[k]);
    let (mut value, mut gradient) = (vec![0.0; element.nodes()], vec![[0.0; D]; element.nodes()]);
    element.evaluate(&point, &mut value, &mut gradient);
    (nodes.iter().map(|node| value[*node]).collect(), nodes.iter().map(|node| gradient[*node]).collect())
}

/// ∫ 1 over a facet of a cell in the facet's coordinates.
fn area_of_facet(shape: CellShape) -> f64 {
    if shape == CellShape::Tetrahedron { 0.5 } else { 1.0 }
}

impl Covers {
    /// The covers of all own facets, with an element whose functions on facets are dual ones.
    pub fn new<const D: usize>(pairs: &Pairs<D>, element: &Tabulated) -> Self {
        let mut facets: HashMap<Facet, Cover> = HashMap::new();
        let mut whole_functions = HashMap::new();
        for group in &pairs.groups {
            let (shape, local) = group.sides[0];
            let element = &element.elements[shape];
            let nodes = element.facet_nodes(usize::from(local));
            let on_whole = || element.dual_on_facet(usize::from(local)).unwrap_or_default();
            whole_functions.entry((shape, local)).or_insert_with(on_whole);
            let stride = PairGroup::<D>::STRIDE;
            for (unit, [own, _]) in group.facets.iter().enumerate() {
                let cover = facets.entry(*own).or_insert_with(|| Cover::empty(nodes.len(), shape));
                for point in
                    group.points[unit * group.count * stride..][..group.count * stride].chunks(stride)
                {
                    let (values, _) = functions_at::<D>(element, &nodes, point);
                    cover.add(&values, point[2 * D]);
                }
            }
        }
        for group in &pairs.groups {
            for [own, _] in &group.facets {
                let whole = &whole_functions[&group.sides[0]];
                if let Some(cover) = facets.get_mut(own).filter(|cover| cover.functions.is_empty()) {
                    cover.functions = if cover.is_whole() { whole.clone() } else { cover.dual_functions() };
                }
            }
        }
        Covers { facets }
    }

    /// The cover of an own facet that is covered in part.
    pub fn in_part(&self, own: Facet) -> Option<&Cover> {
        self.facets.get(&own).filter(|cover| !cover.is_whole())
    }

    /// Whether some facet is covered in part.
    pub fn has_parts(&self) -> bool {
        self.facets.values().any(|cover| !cover.is_whole())
    }
}

impl Cover {
    fn empty(functions: usize, shape: CellShape) -> Self {
        let (moments, areas) = (vec![0.0; functions * functions], vec![0.0; functions]);
        Cover { moments, areas, whole: area_of_facet(shape), functions: vec![] }
    }

    fn add(&mut self, values: &[f64], weight: f64) {
        for (i, value) in values.iter().enumerate() {
            self.areas[i] += weight * value;
            for (j, other) in values.iter().enumerate() {
                self.moments[i * values.len() + j] += weight * value * other;
            }
        }
    }

    /// 1 − c, what is open of the facet.
    fn open(&self) -> f64 {
        1.0 - self.areas.iter().sum::<f64>() / self.whole
    }

    fn is_whole(&self) -> bool {
        self.open() < ROUNDING
    }

    /// The number of functions.
    pub fn count(&self) -> usize {
        self.areas.len()
    }

    /// P = M D⁻¹, whose columns have the sum 1; that of a function that the cover does not see is the unit vector.
    fn quotients(&self) -> Vec<f64> {
        let count = self.count();
        let entry = |k: usize| {
            let (i, j) = (k / count, k % count);
            let unseen = if i == j { 1.0 } else { 0.0 };
            if self.areas[j] > 0.0 { self.moments[k] / self.areas[j] } else { unseen }
        };
        (0..count * count).map(entry).collect()
    }

    /// A = (ε 1 + (1 − ε) P)⁻¹. Assembly refuses the numbers of a cover without one by name.
    fn dual_functions(&self) -> Vec<f64> {
        let (count, sliver) = (self.count(), self.open().powi(2));
        let mut combined = self.quotients();
        for (k, entry) in combined.iter_mut().enumerate() {
            *entry = (1.0 - sliver) * *entry + if k % (count + 1) == 0 { sliver } else { 0.0 };
        }
        small_inverse(combined, &vec![1.0; count]).unwrap_or_else(|| vec![f64::NAN; count * count])
    }

    /// δA A⁻¹ = −A δC of a change δM of ∫ φ_i φ_j; that of the areas has its rows' sums.
    pub fn rate(&self, of_moments: &[f64]) -> Vec<f64> {
        let (count, open, quotients) = (self.count(), self.open(), self.quotients());
        let of_areas: Vec<f64> = of_moments.chunks_exact(count).map(|row| row.iter().sum()).collect();
        let of_sliver = -2.0 * open * of_areas.iter().sum::<f64>() / self.whole;
        let change = |k: usize| {
            let j = k % count;
            let one = if k / count == j { 1.0 } else { 0.0 };
            let of_quotient = match self.areas[j] > 0.0 {
                true => (of_moments[k] - quotients[k] * of_areas[j]) / self.areas[j],
                false => 0.0,
            };
            of_sliver * (one - quotients[k]) + (1.0 - open * open) * of_quotient
        };
        let changes: Vec<f64> = (0..count * count).map(change).collect();
        let product = |k: usize| {
            let (i, j) = (k / count, k % count);
            -(0..count).map(|l| self.functions[i * count + l] * changes[l * count + j]).sum::<f64>()
        };
        (0..count * count).map(product).collect()
    }
}

/// The derivatives of ∫ φ_i φ_j over a unit's cover by the coordinates of its feet, coordinate after coordinate.
pub(in crate::assemble) fn moments_by_feet<const D: usize>(
    group: &PairGroup<D>,
    element: &Tabulated,
    unit: usize,
) -> Vec<f64> {
    let (shape, local) = group.sides[0];
    let element = &element.elements[shape];
    let nodes = element.facet_nodes(usize::from(local));
    let (count, stride) = (nodes.len(), PairGroup::<D>::STRIDE);
    let coordinates = group.motion.coordinates(group.facets.len());
    let mut rates = vec![0.0; coordinates * count * count];
    for index in unit * group.count..(unit + 1) * group.count {
        let point = &group.points[index * stride..][..stride];
        let (values, gradients) = functions_at::<D>(element, &nodes, point);
        let weight = point[2 * D];
        let along = |slopes: &[f64], i: usize| -> f64 { (0..D).map(|k| gradients[i][k] * slopes[k]).sum() };
        for (shares, rates) in group.motion.shares[index * coordinates * D..][..coordinates * D]
            .chunks_exact(D)
            .zip(rates.chunks_exact_mut(count * count))
        {
            let of_value = |i: usize| -> f64 {
                let of_axis = |axis: usize| &group.motion.slopes[axis][index * stride..][..D];
                (0..D - 1).map(|axis| shares[axis] * along(of_axis(axis), i)).sum()
            };
            let moved: Vec<f64> = (0..count).map(of_value).collect();
            for (k, rate) in rates.iter_mut().enumerate() {
                let (i, j) = (k / count, k % count);
                let of_product = moved[i] * values[j] + values[i] * moved[j];
                *rate += weight * (shares[D - 1] * values[i] * values[j] + of_product);
            }
        }
    }
    rates
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::Elements;

    /// The cover of a facet by the part between two places, with the points of a rule.
    fn cover_between(from: f64, to: f64) -> Cover {
        let mut cover = Cover::empty(2, CellShape::Quadrilateral);
        let apart = (1.0_f64 / 3.0).sqrt();
        for place in [0.5 - 0.5 * apart, 0.5 + 0.5 * apart] {
            let s = from + (to - from) * place;
            cover.add(&[1.0 - s, s], 0.5 * (to - from));
        }
        cover.functions = cover.dual_functions();
        cover
    }

    #[test]
    fn functions_have_the_sum_one_their_areas_and_a_bound_over_any_cover() {
        for size in [1.0, 0.9, 0.5, 0.1, 1e-2, 1e-4, 1e-8] {
            for part in 0..11 {
                let from = (1.0 - size) * f64::from(part) / 10.0;
                let cover = cover_between(from, from + size);
                let [a, b, c, d]: [f64; 4] = cover.functions.clone().try_into().unwrap();
                assert!((a + c - 1.0).abs() < 1e-12 && (b + d - 1.0).abs() < 1e-12, "{size} {from}");
                let areas = [[a, b], [c, d]].map(|row| row[0] * cover.areas[0] + row[1] * cover.areas[1]);
                for (area, expected) in areas.iter().zip(&cover.areas) {
                    assert!((area - expected).abs() < 1e-12 * size, "{size} {from}: {area} {expected}");
                }
                // A linear function is largest at an end of the cover.
                let at = |s: f64| [a * (1.0 - s) + b * s, c * (1.0 - s) + d * s];
                let largest =
                    [from, from + size].map(at).as_flattened().iter().fold(0.0, |m: f64, v| m.max(v.abs()));
                // The most is 2.19, with a cover of 0.84 from an end.
                assert!(largest < 2.2, "{size} {from}: {largest}");
            }
        }
    }

    #[test]
    fn on_a_whole_facet_they_are_those_of_the_element() {
        let element = Elements::Dual.on(CellShape::Quadrilateral).unwrap();
        for (found, expected) in
            cover_between(0.0, 1.0).functions.iter().zip(element.dual_on_facet(0).unwrap())
        {
            assert!((found - expected).abs() < 1e-13, "{found} {expected}");
        }
    }

    #[test]
    fn rates_are_those_of_differences() {
        let (from, to, step) = (0.23, 0.61, 1e-5);
        let [before, here, after] = [-step, 0.0, step].map(|move_by| cover_between(from, to + move_by));
        let slope = |a: &[f64], b: &[f64]| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| (b - a) / (2.0 * step)).collect()
        };
        let of_moments = slope(&before.moments, &after.moments);
        let of_functions = slope(&before.functions, &after.functions);
        let rate = here.rate(&of_moments);
        // δA = (δA A⁻¹) A.
        for i in 0..2 {
            for j in 0..2 {
                let found: f64 = (0..2).map(|k| rate[2 * i + k] * here.functions[2 * k + j]).sum();
                assert!((found - of_functions[2 * i + j]).abs() < 1e-7, "{i} {j}: {found}");
            }
        }
    }
}
