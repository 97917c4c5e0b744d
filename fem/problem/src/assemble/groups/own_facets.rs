//! Means over the own facets of contact pairs: what integrals of `means(..)` read, and the groups with the weights of the means.
//!
//! All points of an own facet count together, whatever facets lie opposite to them. The weights ψ_i are 1, or the functions of degree 1 of
//! the facet's vertices; they multiply the weights of the points, so that the loops know nothing of them.

use std::collections::HashMap;
use std::sync::Arc;

use forms_core::contract::{Integral, Means, Requirements, Role, Term};

use super::pair_groups::{PairTables, pair_groups};
use super::{Group, GroupSide, OwnPoints};
use crate::assemble::AssemblyError;
use crate::assemble::batch::Cells;
use crate::assemble::binding::Binding;
use crate::assemble::binding::means::FacetMeans;
use crate::assemble::element_loops::vectors::ElementVectors;
use crate::assemble::kernels::VectorKernel;
use crate::element::{CellShape, Lagrange};
use crate::instantiate::instantiate;
use crate::mesh::Facet;
use crate::pairs::PairGroup;
use crate::quadrature::Quadrature;

/// The means that the kernels on a group read, and the weight with which its points count.
pub(in crate::assemble) struct UnitMeans {
    pub weight: usize,
    /// By list that is read, the values of each unit.
    pub lists: Vec<(usize, Vec<f64>)>,
}

/// Number of weights on the facets of a shape.
fn weights_of(shape: CellShape, local: u8, degree: usize) -> usize {
    if degree == 0 { 1 } else { shape.facet_vertices(usize::from(local)).len() }
}

/// The units with their points' weights multiplied by a weight of means.
fn weighted<const D: usize>(group: &Arc<PairGroup<D>>, degree: usize, weight: usize) -> Arc<PairGroup<D>> {
    if degree == 0 {
        return Arc::clone(group);
    }
    let (shape, local) = group.sides[0];
    let element = Lagrange { shape, degree: 1 };
    let vertex = element.facet_nodes(usize::from(local))[weight];
    let (mut weighted, stride) = ((**group).clone(), PairGroup::<D>::STRIDE);
    for (index, point) in weighted.points.chunks_exact_mut(stride).enumerate() {
        let own: [f64; D] = std::array::from_fn(|axis| point[axis]);
        let tables = element.tabulate(&[own]);
        let weight = &mut point[2 * D];
        // Where the point moves, its weight ψ W has the rate ψ,_α W.
        for slopes in weighted.motion.slopes.iter_mut().filter(|slopes| !slopes.is_empty()) {
            let slopes = &mut slopes[index * stride..][..stride];
            let along: f64 = (0..D).map(|axis| tables.gradient[vertex][axis] * slopes[axis]).sum();
            slopes[2 * D] = along * *weight;
        }
        *weight *= tables.value[vertex];
    }
    Arc::new(weighted)
}

/// The groups of contact pairs once per weight, with the means that a kernel reads.
#[inline(never)]
pub(in crate::assemble) fn groups_with_means<const D: usize>(
    binding: &Binding<D>,
    (integral, means): (&Integral, Means),
    (quadrature, degree): (&Quadrature<D>, usize),
    requirements: &Requirements,
) -> Result<Vec<Group<D>>, AssemblyError> {
    let groups = pair_groups(binding, integral, quadrature, degree, requirements)?;
    let mut read = Vec::new();
    for slot in requirements.fields {
        if let Role::Mean(number) = binding.fields[slot.field].role {
            read.push((slot.field, facet_means(binding, number, (quadrature, degree))?));
        }
    }
    let mut all = Vec::new();
    let most = most_weights(&groups, means.degree);
    for weight in 0..most {
        for group in &groups {
            let Some(pairs) = group.pairs() else { continue };
            let (shape, local) = pairs.group.sides[0];
            if weight >= weights_of(shape, local, means.degree) {
                continue;
            }
            let values = |means: &FacetMeans| -> Vec<f64> {
                let own = |[own, _]: &[Facet; 2]| means.of(means.facets[own], weight).0;
                pairs.group.facets.iter().flat_map(own).copied().collect()
            };
            all.push(Group {
                place: group.place.clone(),
                sides: group.sides.iter().map(GroupSide::clone).collect(),
                weights: group.weights.clone(),
                own: Some(OwnPoints::Pairs(PairTables {
                    group: weighted(&pairs.group, means.degree, weight),
                    geometry: pairs.geometry.clone(),
                    elements: pairs.elements.clone(),
                    dual: pairs.dual.clone(),
                })),
                means: Some(UnitMeans {
                    weight,
                    lists: read.iter().map(|(field, means)| (*field, values(means))).collect(),
                }),
            });
        }
    }
    Ok(all)
}

fn most_weights<const D: usize>(groups: &[Group<D>], degree: usize) -> usize {
    let of_group = |group: &Group<D>| {
        let (shape, local) = group.pairs()?.group.sides[0];
        Some(weights_of(shape, local, degree))
    };
    groups.iter().filter_map(of_group).max().unwrap_or(0)
}

/// The means of a list at the unknowns of a binding, with a rule; made at the first call.
#[inline(never)]
pub(in crate::assemble) fn facet_means<const D: usize>(
    binding: &Binding<D>,
    number: usize,
    (quadrature, degree): (&Quadrature<D>, usize),
) -> Result<Arc<FacetMeans>, AssemblyError> {
    if let Some(known) = binding.known_means(number, degree) {
        return Ok(known);
    }
    let is_wanted = |term: &&Term<VectorKernel<D>>| of_list(term.integral, number).is_some();
    let Some(term) = binding.lists_of_means().iter().find(is_wanted) else {
        return Err(AssemblyError::Means { form: binding.name });
    };
    let constants = term.kernel.constants();
    let means = term.integral.means.ok_or(AssemblyError::Means { form: binding.name })?;
    let whole = (quadrature, degree);
    let groups = groups_with_means(binding, (term.integral, means), whole, constants.requirements)?;
    let mut facets = HashMap::new();
    let units = groups.iter().filter_map(|group| group.pairs()).flat_map(|pairs| &pairs.group.facets);
    for [own, _] in units {
        let next = facets.len();
        facets.entry(*own).or_insert(next);
    }
    let weights = groups.iter().filter_map(|group| group.means.as_ref()).map(|means| means.weight + 1);
    let (weights, length) = (weights.max().unwrap_or(1), constants.components);
    let mut values = vec![0.0; facets.len() * weights * length];
    for group in &groups {
        let (Some(pairs), Some(means)) = (group.pairs(), &group.means) else { continue };
        let task = ElementVectors {
            binding,
            group,
            cells: Cells::Mesh(binding.mesh),
            side: 0,
            element: binding.constant_element()?,
        };
        // One after the other, in the order of the units: the sums do not depend on threads.
        term.kernel.compute(&task, 0..group.entities(), &mut |first, vectors| {
            for (unit, vector) in vectors.chunks_exact(length).enumerate() {
                let facet = facets[&pairs.group.facets[first + unit][0]];
                let sums = &mut values[(facet * weights + means.weight) * length..][..length];
                sums.iter_mut().zip(vector).for_each(|(sum, value)| *sum += value);
            }
            Ok(())
        })?;
    }
    for own in values.chunks_exact_mut(length) {
        let (sums, volume) = own.split_at_mut(length - 1);
        // Without points there is no mean, and nothing that reads it.
        let divisor = if volume[0] == 0.0 { 1.0 } else { volume[0] };
        sums.iter_mut().for_each(|sum| *sum /= divisor);
    }
    let found = Arc::new(FacetMeans { count: length - 1, weights, facets, values });
    binding.keep_means(number, degree, &found);
    Ok(found)
}

/// The means of an integral that makes or varies a list.
pub(in crate::assemble) fn of_list(integral: &Integral, number: usize) -> Option<Means> {
    integral.means.filter(|means| means.number == number)
}

instantiate!(own_facets: groups_with_means::<D>, facet_means::<D>);
