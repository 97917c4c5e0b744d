//! Residuals and tangents that are asked for as a whole: what [`Dependence`] keeps apart on a region, for Newton's method, is one
//! integral here, so that geometry and fields of a facet are computed once.

use super::Dependence;
use super::groups::Group;
use super::scalar::Graph;
use crate::sorted::SortedMap;
use crate::tensor::{FieldInfo, FieldRole};

/// The sum of the groups of each region on which at least two depend on the unknowns. None where the form has a history, whose
/// points belong to the integrals that read it.
pub(super) fn groups(groups: &[Group], fields: &[FieldInfo], graph: &mut Graph) -> Vec<Group> {
    if fields.iter().any(|field| field.role == FieldRole::History) {
        return vec![];
    }
    let mut regions: SortedMap<_, Vec<&Group>> = SortedMap::new();
    // Means are made for one integral after the other.
    for group in groups.iter().filter(|group| group.description.means.is_none() && !group.description.moves) {
        let super::Description { region, displacement, .. } = &group.description;
        regions.get_or_default((*region, displacement)).push(group);
    }
    let depends = |group: &&&Group| group.description.dependence != Dependence::Constant;
    let several = |groups: &Vec<&Group>| groups.iter().filter(depends).count() >= 2;
    let whole = |groups: Vec<&Group>| -> Option<Group> {
        let mut groups = groups.into_iter().cloned();
        let mut whole = groups.next()?;
        groups.for_each(|group| whole.join(group, graph));
        whole.description.dependence = Dependence::Nonlinear;
        Some(whole)
    };
    regions.into_values().filter(several).filter_map(whole).collect()
}
