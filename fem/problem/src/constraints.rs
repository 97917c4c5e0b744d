//! Constraints of a space: prescribed unknowns (Dirichlet conditions), and relations that give unknowns by others.

mod equations;
mod error;
mod hanging_nodes;
mod joined;
mod mean_value;
mod periodic;
mod rigid_body;
mod rigid_map;
mod sliding;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::Arc;

pub use equations::Relation;
pub use error::ConstraintsError;
use forms_core::contract::FieldValue;
pub(crate) use joined::Dependence;
pub use rigid_map::RigidMap;

use crate::instantiate::instantiate;
use crate::space::Space;

/// Prescribed unknowns of a space, and relations by which free unknowns give others (sliding,
/// periodic conditions, rigid bodies, mean values, hanging nodes).
/// Solvers eliminate both: u = C y + d with the free unknowns y; residuals become Cᵀ R, tangents Cᵀ K C.
#[derive(Clone, Debug)]
pub struct Constraints<const D: usize> {
    space: Arc<Space<D>>,
    conditions: Arc<Conditions>,
}

/// The numbers of constraints. Of no dimension, and shared, so that programs do not compile what clones and drops them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Conditions {
    prescribed: BTreeMap<usize, f64>,
    relations: BTreeMap<usize, Relation>,
    // The conditions that prescribed unknowns come from.
    origins: BTreeMap<usize, Arc<str>>,
    // The relations that use a free unknown.
    users: HashMap<usize, BTreeSet<usize>>,
    // Unknowns on small facets, which have the values of the large ones.
    hanging: BTreeSet<usize>,
    // Values that a piece of a mesh prescribes for hanging unknowns: other processes may prescribe those that give them.
    at_hanging: BTreeMap<usize, f64>,
    // The largest size of a prescribed value: formulas for others may round as it does.
    largest: f64,
}

// Two formulas for one value may differ by round-off, relative to the largest value prescribed.
const SAME: f64 = 1e-13;

impl<const D: usize> Constraints<D> {
    /// No condition at all.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// let mut constraints = Constraints::new(&space);
    /// constraints.fix("left", |_| 0.0)?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[inline(never)]
    pub fn new(space: &Arc<Space<D>>) -> Self {
        Constraints { space: Arc::clone(space), conditions: Arc::default() }
    }

    /// The space.
    pub fn space(&self) -> &Arc<Space<D>> {
        &self.space
    }

    /// Prescribed values of all components on a region of facets (exterior or interior) or cells.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// let space = Space::vector(&mesh, 1)?;
    /// let mut constraints = Constraints::new(&space);
    /// constraints.fix("left", |x| [0.0, 0.1 * x[1]])?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// An unknown region, a value that does not fit the space, is not finite, or contradicts an earlier one.
    pub fn fix<V: FieldValue>(
        &mut self,
        region: &str,
        value: impl Fn(&[f64; D]) -> V,
    ) -> Result<(), ConstraintsError> {
        self.fix_written(region, V::COMPONENTS, &|x, written| value(x).write(written))
    }

    #[inline(never)]
    fn fix_written(
        &mut self,
        region: &str,
        count: usize,
        write: &dyn Fn(&[f64; D], &mut [f64]),
    ) -> Result<(), ConstraintsError> {
        let place = format!("region \"{region}\"");
        let components = self.space.components();
        if count != components {
            return Err(ConstraintsError::Components { place, space: components, value: count });
        }
        let nodes = self.nodes_on(region, &place)?;
        let mut written = vec![0.0; components];
        let mut entries = Vec::with_capacity(nodes.len() * components);
        for node in nodes {
            write(&self.space.positions()[node as usize], &mut written);
            let first = node as usize * components;
            entries.extend(written.iter().enumerate().map(|(component, &value)| (first + component, value)));
        }
        self.insert(&place, &entries)
    }

    /// Prescribed values of one component (counted from 0, row-major) on a facet or cell region.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// let space = Space::vector(&mesh, 1)?;
    /// let mut constraints = Constraints::new(&space);
    /// constraints.fix_component("bottom", 1, |_| 0.0)?; // a symmetry: no vertical motion
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Constraints::fix`], or a component that the space does not have.
    pub fn fix_component(
        &mut self,
        region: &str,
        component: usize,
        value: impl Fn(&[f64; D]) -> f64,
    ) -> Result<(), ConstraintsError> {
        self.fix_component_to(region, component, &value)
    }

    #[inline(never)]
    fn fix_component_to(
        &mut self,
        region: &str,
        component: usize,
        value: &dyn Fn(&[f64; D]) -> f64,
    ) -> Result<(), ConstraintsError> {
        let place = format!("region \"{region}\"");
        let components = self.check_component(&place, component)?;
        let entry = |node: u32| {
            let node = node as usize;
            (node * components + component, value(&self.space.positions()[node]))
        };
        let entries: Vec<_> = self.nodes_on(region, &place)?.into_iter().map(entry).collect();
        self.insert(&place, &entries)
    }

    /// Prescribed value of one component at one node.
    ///
    /// # Errors
    /// A node or component that the space does not have, a value that is not finite or contradicts an
    /// earlier one.
    #[inline(never)]
    pub fn fix_node(&mut self, node: usize, component: usize, value: f64) -> Result<(), ConstraintsError> {
        let place = format!("node {node}");
        let components = self.check_component(&place, component)?;
        let count = self.space.node_count();
        if node >= count {
            return Err(ConstraintsError::Node { node, count });
        }
        self.insert(&place, &[(node * components + component, value)])
    }

    /// Prescribed values of all components at the node nearest to a point. This pins what is determined only up to a
    /// constant, as the pressure of a flow in a closed vessel is.
    ///
    /// # Errors
    /// A value that does not fit the space, is not finite, or contradicts an earlier one.
    pub fn fix_nearest<V: FieldValue>(&mut self, point: &[f64; D], value: V) -> Result<(), ConstraintsError> {
        let components = self.space.components();
        self.space.mesh().without_pieces("the nearest node", "call `part.fix_nearest(..)`")?;
        let Some(node) = self.space.nearest_node(point) else {
            return Err(ConstraintsError::NoNearest { point: point.to_vec() });
        };
        let place = format!("node {node}");
        if V::COMPONENTS != components {
            return Err(ConstraintsError::Components { place, space: components, value: V::COMPONENTS });
        }
        let mut written = vec![0.0; components];
        value.write(&mut written);
        let entries: Vec<_> = (node * components..).zip(written).collect();
        self.insert(&place, &entries)
    }

    /// Prescribed unknowns and their values.
    pub fn prescribed(&self) -> &BTreeMap<usize, f64> {
        &self.conditions.prescribed
    }

    /// Values that a piece of a mesh prescribes for hanging unknowns, which hold where nothing prescribes the unknowns that give them.
    pub(crate) fn prescribed_at_hanging(&self) -> &BTreeMap<usize, f64> {
        &self.conditions.at_hanging
    }

    /// Whether an unknown is prescribed.
    pub fn is_prescribed(&self, unknown: usize) -> bool {
        self.conditions.prescribed.contains_key(&unknown)
    }

    /// Unknowns that free ones give.
    pub fn relations(&self) -> &BTreeMap<usize, Relation> {
        &self.conditions.relations
    }

    /// The other unknowns, ascending.
    #[inline(never)]
    pub fn free(&self) -> Vec<usize> {
        let is_free = |unknown: &usize| {
            !self.conditions.prescribed.contains_key(unknown)
                && !self.conditions.relations.contains_key(unknown)
        };
        (0..self.space.unknowns()).filter(is_free).collect()
    }

    /// The prescribed values, written into a vector of all unknowns, and then those that its free entries determine.
    ///
    /// # Panics
    /// When the vector is shorter than the space has unknowns.
    #[inline(never)]
    pub fn apply(&self, values: &mut [f64]) {
        for (&unknown, &value) in &self.conditions.prescribed {
            values[unknown] = value;
        }
        for (&unknown, relation) in &self.conditions.relations {
            values[unknown] =
                relation.terms.iter().fold(relation.value, |sum, (free, a)| sum + a * values[*free]);
        }
    }

    /// These constraints with zero values: for increments and adjoint states.
    #[inline(never)]
    pub fn homogeneous(&self) -> Self {
        let mut same = self.clone();
        let conditions = Arc::make_mut(&mut same.conditions);
        conditions.prescribed.values_mut().for_each(|value| *value = 0.0);
        conditions.relations.values_mut().for_each(|relation| relation.value = 0.0);
        conditions.at_hanging.values_mut().for_each(|value| *value = 0.0);
        conditions.largest = 0.0;
        same
    }

    // At least one node.
    #[inline(never)]
    pub(crate) fn nodes_on(&self, region: &str, place: &str) -> Result<Vec<u32>, ConstraintsError> {
        if !self.space.elements().is_nodal() {
            let elements = self.space.elements().clone();
            return Err(ConstraintsError::NotNodal { place: place.to_owned(), elements });
        }
        let nodes = self.space.nodes_on(region)?;
        // Other processes may have some of them, where this one has nothing of the region.
        let mesh = self.space.mesh();
        let is_elsewhere = mesh.is_piece()
            && mesh
                .facet_region(region)
                .map_or_else(|_| mesh.cell_region(region).is_ok_and(<[_]>::is_empty), <[_]>::is_empty);
        if nodes.is_empty() && !is_elsewhere {
            let (elements, scope) = (self.space.elements().clone(), self.space.scope().clone());
            return Err(ConstraintsError::NoNodes { place: place.to_owned(), elements, scope });
        }
        Ok(nodes)
    }

    /// The nodes of a region that a condition relates to each other. On a piece of a mesh they are known where each process has the whole surface.
    fn nodes_to_relate(&self, region: &str, place: &str) -> Result<Vec<u32>, ConstraintsError> {
        if !self.space.mesh().is_piece() {
            return self.nodes_on(region, place);
        }
        self.nodes_on(region, place)?;
        Ok(self.space.nodes_on_whole_surface(region)?)
    }

    pub(crate) fn check_component(&self, place: &str, component: usize) -> Result<usize, ConstraintsError> {
        let components = self.space.components();
        if component < components {
            return Ok(components);
        }
        Err(ConstraintsError::Component { place: place.to_owned(), component, components })
    }

    // All or nothing.
    #[inline(never)]
    fn insert(&mut self, place: &str, entries: &[(usize, f64)]) -> Result<(), ConstraintsError> {
        let components = self.space.components();
        let node = |unknown: usize| self.space.positions()[unknown / components].to_vec();
        // All earlier values are in `largest`: to go through them again would take a time quadratic in their number.
        let values = entries.iter().map(|(_, value)| value);
        let scale = values.fold(self.conditions.largest, |scale, value| scale.max(value.abs()));
        for &(unknown, value) in entries {
            let (place, component) = (place.to_owned(), unknown % components);
            if !value.is_finite() {
                let position = node(unknown);
                return Err(ConstraintsError::NotFinite { place, component, position, value });
            }
            if let Some(&earlier) = self.conditions.prescribed.get(&unknown)
                && (earlier - value).abs() > SAME * scale
                && !self.conditions.hanging.contains(&unknown)
            {
                let position = node(unknown);
                return Err(ConstraintsError::Conflict { place, component, position, value, earlier });
            }
        }
        let origin: Arc<str> = place.into();
        let mut changed = if self.conditions.relations.is_empty() { None } else { Some(self.clone()) };
        let conditions = changed.as_mut().map_or(&mut self.conditions, |changed| &mut changed.conditions);
        Arc::make_mut(conditions).largest = scale;
        // A hanging unknown interpolates the values on the large facet, once these are prescribed: it comes last.
        let (hanging, others): (Vec<_>, Vec<_>) =
            entries.iter().copied().partition(|(unknown, _)| self.conditions.hanging.contains(unknown));
        for (unknown, value) in others.into_iter().chain(hanging) {
            match &mut changed {
                Some(changed) if self.conditions.hanging.contains(&unknown) => {
                    if changed.is_prescribed(unknown) {
                        continue;
                    }
                    if changed.space.mesh().is_piece() {
                        Arc::make_mut(&mut changed.conditions).at_hanging.entry(unknown).or_insert(value);
                    } else {
                        changed.add_equation(place, &[(unknown, 1.0)], value)?;
                    }
                }
                Some(changed) if !self.conditions.prescribed.contains_key(&unknown) => {
                    changed.add_equation(place, &[(unknown, 1.0)], value)?;
                }
                Some(_) => {}
                None => {
                    let conditions = Arc::make_mut(&mut self.conditions);
                    conditions.prescribed.entry(unknown).or_insert(value);
                    conditions.origins.entry(unknown).or_insert_with(|| origin.clone());
                }
            }
        }
        if let Some(changed) = changed {
            *self = changed;
        }
        Ok(())
    }
}

instantiate!(
    constraints:
    Constraints::<D>::new,
    Constraints::<D>::insert,
    Constraints::<D>::nodes_on,
    Constraints::<D>::fix_written,
    Constraints::<D>::fix_component_to,
    Constraints::<D>::fix_node,
    Constraints::<D>::free,
    Constraints::<D>::apply,
    Constraints::<D>::homogeneous
);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;
    use crate::mesh::rectangle;

    type Outcome = Result<(), Box<dyn std::error::Error>>;

    fn space() -> Result<Arc<Space<2>>, Box<dyn std::error::Error>> {
        let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1)?;
        Ok(Space::vector(&mesh, 2)?)
    }

    #[test]
    fn prescribed_and_free_unknowns_are_complementary() -> Outcome {
        let space = space()?;
        let mut constraints = Constraints::new(&space);
        constraints.fix("left", |x| [x[1], 0.0])?;
        constraints.fix_component("bottom", 1, |_| 0.0)?;
        // 5 nodes with two components, 4 more with one.
        assert_eq!(constraints.prescribed().len(), 14);
        let free = constraints.free();
        assert_eq!(free.len() + 14, space.unknowns());
        assert!(free.iter().all(|&unknown| !constraints.is_prescribed(unknown)));
        let mut values = vec![7.0; space.unknowns()];
        constraints.apply(&mut values);
        for (node, x) in space.positions().iter().enumerate() {
            let expected =
                [if x[0] == 0.0 { x[1] } else { 7.0 }, if x[0] == 0.0 || x[1] == 0.0 { 0.0 } else { 7.0 }];
            assert_eq!(values[2 * node..2 * node + 2], expected);
        }
        constraints.homogeneous().apply(&mut values);
        assert!(constraints.prescribed().keys().all(|&unknown| values[unknown] == 0.0));
        Ok(())
    }

    #[test]
    fn conditions_may_meet_but_not_conflict() -> Outcome {
        let mut constraints = Constraints::new(&space()?);
        constraints.fix("left", |x| [x[0] + x[1], 1.0])?;
        constraints.fix("bottom", |x| [x[0] + x[1], 1.0])?;
        let before = constraints.prescribed().clone();
        let message = |outcome: Result<(), ConstraintsError>| outcome.err().map(|error| error.to_string());
        assert_eq!(
            message(constraints.fix_component("right", 0, |x| 2.0 * x[0])).as_deref(),
            Some("region \"right\": component 0 at [1.0, 0.0] is prescribed as 2, but as 1 before")
        );
        assert_eq!(constraints.prescribed(), &before);
        assert_eq!(
            message(constraints.fix_component("right", 1, |x| 0.0 / x[1])).as_deref(),
            Some("region \"right\": the value prescribed for component 1 at [1.0, 0.0] is not finite: NaN")
        );
        assert_eq!(
            message(constraints.fix_component("right", 2, |_| 0.0)).as_deref(),
            Some("region \"right\": there is no component 2; the space has 2 (numbered from 0)")
        );
        assert_eq!(
            message(constraints.fix("right", |x| x[0])).as_deref(),
            Some("region \"right\": the space has 2 components, but the prescribed value has 1")
        );
        assert_eq!(
            message(constraints.fix_node(25, 0, 1.0)).as_deref(),
            Some("there is no node 25; the space has 25 (numbered from 0)")
        );
        assert!(message(constraints.fix("lid", |x| *x)).is_some_and(|m| m.starts_with("there is no region")));
        constraints.fix_node(24, 0, 3.0)?;
        assert_eq!(constraints.prescribed().get(&48), Some(&3.0));
        Ok(())
    }
}
