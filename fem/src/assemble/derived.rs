//! Derived fields: any function of a forms module at points, at quadrature points, along facets, or
//! projected to a space.

use std::collections::BTreeMap;
use std::sync::Arc;

use forms_core::contract::{Entity, Expression, ExpressionKernel, ExpressionVisitor, Integral};

use super::batch::Batch;
use super::binding::Binding;
use super::walk::{Group, Places};
use super::{Assembler, AssemblyError};
use crate::field::Field;
use crate::linear_algebra::{Analysis, CsrMatrix, LinearAlgebraError, Ordering, SymmetricFactor};
use crate::locate::Locator;
use crate::mesh::{Facet, MeshError};
use crate::norms::{Measure, Measured};
use crate::quadrature::{FacetRule, QuadratureError, QuadratureRule, map_to_facet};
use crate::space::Space;

/// A derived field at a list of points.
#[derive(Clone, Debug, PartialEq)]
pub struct PointValues<const D: usize> {
    /// Position of each point.
    pub positions: Vec<[f64; D]>,
    /// Quadrature weight times measure; zero where the points are not those of a rule.
    pub weights: Vec<f64>,
    /// Components of the value at each point, row-major.
    pub values: Vec<Vec<f64>>,
}

/// A derived field at a point of a facet.
#[derive(Clone, Debug, PartialEq)]
pub struct FacetSample<const D: usize> {
    /// The facet.
    pub facet: Facet,
    /// Coordinates on the facet's own reference cell; the second is zero in two dimensions.
    pub parameter: [f64; 2],
    /// Position.
    pub position: [f64; D],
    /// Components of the value, row-major.
    pub value: Vec<f64>,
}

impl<const D: usize> Assembler<D> {
    /// A derived field at points, cell by cell as they are located.
    ///
    /// # Errors
    /// A point outside the mesh, a function that needs a facet, a value that is not finite, or data that
    /// do not fit.
    pub fn at_points<E: Expression<D>>(
        &self,
        expression: &E,
        points: &[[f64; D]],
    ) -> Result<PointValues<D>, AssemblyError> {
        let form = expression.name();
        let locator = Locator::new(&self.mesh);
        let mut places = Vec::new();
        for point in points {
            let outside = || AssemblyError::Outside { form, position: point.to_vec() };
            places.push(locator.find(point).ok_or_else(outside)?);
        }
        let build = |binding: &Binding<D>| {
            let one = |(cell, reference): &(usize, [f64; D])| {
                let places = Places { points: vec![*reference], facet: None };
                Group::new(binding, "points".to_owned(), vec![*cell as u32], &places, vec![0.0], true)
            };
            places.iter().map(one).collect::<Result<Vec<_>, _>>()
        };
        let found = self.values(expression, |binding| {
            build(binding).map_err(|source| AssemblyError::Quadrature { form, source })
        })?;
        Ok(found.into_iter().collect())
    }

    /// A derived field at one point: its components, row-major.
    ///
    /// # Errors
    /// As [`Assembler::at_points`].
    pub fn at_point<E: Expression<D>>(
        &self,
        expression: &E,
        point: [f64; D],
    ) -> Result<Vec<f64>, AssemblyError> {
        Ok(self.at_points(expression, &[point])?.values.into_iter().flatten().collect())
    }

    /// A derived field at the quadrature points of a cell or facet region, with their weights. Where the
    /// choice of quadrature is the compiler's estimate, `degree` is taken.
    ///
    /// # Errors
    /// An unknown region, a function that needs a facet, a value that is not finite, or data that do not
    /// fit.
    pub fn at_quadrature_points<E: Expression<D>>(
        &self,
        expression: &E,
        entity: Entity,
        region: &str,
        degree: usize,
    ) -> Result<PointValues<D>, AssemblyError> {
        let form = expression.name();
        let missing = |source: MeshError| AssemblyError::Region { form, symbol: "derived field", source };
        let quadrature = |source| AssemblyError::Quadrature { form, source };
        let shape = self.mesh.shape();
        let found = match entity {
            Entity::Cells => {
                let cells = self.mesh.cell_region(region).map_err(missing)?.to_vec();
                let rule = self.quadrature.cell_rule(shape, degree).map_err(quadrature)?;
                self.values(expression, |binding| {
                    let places = Places { points: rule.points, facet: None };
                    Group::new(binding, place(region), cells, &places, rule.weights, true)
                        .map(|group| vec![group])
                        .map_err(quadrature)
                })?
            }
            // A derived field has one side only: that out of which the normal points.
            Entity::Facets | Entity::InteriorFacets => {
                let first;
                let facets = if entity == Entity::Facets {
                    self.mesh.facet_region(region).map_err(missing)?
                } else {
                    let sides = self.mesh.interior_facet_region(region).map_err(missing)?;
                    first = sides.iter().map(|sides| sides[0]).collect::<Vec<_>>();
                    &first[..]
                };
                self.facet_values(expression, place(region), facets, |local| {
                    self.quadrature.facet_rule(shape, usize::from(local), degree)
                })?
            }
        };
        Ok(found.into_iter().collect())
    }

    /// A derived field along a facet region: on each facet, in the region's order, at the given
    /// coordinates of the facet's own reference cell (in two dimensions the second one is zero).
    ///
    /// # Errors
    /// An unknown region, a value that is not finite, or data that do not fit.
    pub fn along_facets<E: Expression<D>>(
        &self,
        expression: &E,
        region: &str,
        parameters: &[[f64; 2]],
    ) -> Result<Vec<FacetSample<D>>, AssemblyError> {
        let form = expression.name();
        let missing = |source: MeshError| AssemblyError::Region { form, symbol: "derived field", source };
        let facets = self.mesh.facet_region(region).map_err(missing)?;
        let rule = QuadratureRule { points: parameters.to_vec(), weights: vec![0.0; parameters.len()] };
        let shape = self.mesh.shape();
        let found = self.facet_values(expression, place(region), facets, |local| {
            map_to_facet::<D>(shape, usize::from(local), &rule)
        })?;
        let places =
            facets.iter().flat_map(|facet| parameters.iter().map(move |parameter| (*facet, *parameter)));
        let sample =
            |((facet, parameter), (position, _, value))| FacetSample { facet, parameter, position, value };
        Ok(places.zip(found).map(sample).collect())
    }

    /// `count` equidistant samples on each facet of a two-dimensional mesh's region, both ends included.
    ///
    /// # Errors
    /// As [`Assembler::along_facets`].
    pub fn along_facets_uniformly<E: Expression<D>>(
        &self,
        expression: &E,
        region: &str,
        count: usize,
    ) -> Result<Vec<FacetSample<D>>, AssemblyError> {
        let last = count.max(2) - 1;
        let parameters: Vec<[f64; 2]> = (0..=last).map(|k| [k as f64 / last as f64, 0.0]).collect();
        self.along_facets(expression, region, &parameters)
    }

    /// The L² projection of a derived field to a space. Facet quantities cannot be projected.
    ///
    /// # Errors
    /// A wrong number of components, a function that needs a facet, a value that is not finite, data
    /// that do not fit, or a mass matrix that cannot be factored.
    pub fn project<E: Expression<D>>(
        &self,
        expression: &E,
        space: &Arc<Space<D>>,
    ) -> Result<Field<D>, AssemblyError>
    where
        Measured: Measure<D>,
    {
        let form = expression.name();
        let components: usize = expression.shape().iter().product();
        if components != space.components() {
            let (expected, found) = (components, space.components());
            return Err(AssemblyError::Components { form, field: "the space", expected, found });
        }
        let linear_algebra = |source: LinearAlgebraError| AssemblyError::LinearAlgebra { form, source };
        // Exact for the mass matrix on affine cells.
        let degree = 2 * space.element.degree + self.mesh.degree();
        let values = self.at_quadrature_points(expression, Entity::Cells, crate::mesh::EVERYWHERE, degree)?;
        let rule = self
            .quadrature
            .cell_rule(self.mesh.shape(), degree)
            .map_err(|source| AssemblyError::Quadrature { form, source })?;
        let tables = space.element.tabulate(&rule.points);
        let mut load = vec![vec![0.0; space.node_count()]; components];
        for (index, (value, weight)) in values.values.iter().zip(&values.weights).enumerate() {
            let (cell, q) = (index / rule.points.len(), index % rule.points.len());
            for (node, number) in space.cell_nodes(cell).iter().enumerate() {
                let share = weight * tables.value[q * tables.nodes + node];
                for (load, value) in load.iter_mut().zip(value) {
                    load[*number as usize] += share * value;
                }
            }
        }
        let mass = crate::norms::mass_matrix(self, space, degree)?;
        let factor = factor(&mass).map_err(linear_algebra)?;
        let mut coefficients = vec![0.0; space.unknowns()];
        for (component, mut load) in load.into_iter().enumerate() {
            factor.solve_in_place(&mut load).map_err(linear_algebra)?;
            for (node, value) in load.into_iter().enumerate() {
                coefficients[node * components + component] = value;
            }
        }
        Ok(Field { space: space.clone(), values: Arc::new(coefficients) })
    }

    /// A derived field at the nodes of a facet region, averaged over the facets that share a node; zero at
    /// all other nodes of the space. This shows a contact pressure on the body, for example.
    ///
    /// # Errors
    /// An unknown region, a wrong number of components, a value that is not finite, or data that do not
    /// fit.
    pub fn at_facet_nodes<E: Expression<D>>(
        &self,
        expression: &E,
        region: &str,
        space: &Arc<Space<D>>,
    ) -> Result<Field<D>, AssemblyError> {
        let form = expression.name();
        let components: usize = expression.shape().iter().product();
        if components != space.components() {
            let (expected, found) = (components, space.components());
            return Err(AssemblyError::Components { form, field: "the space", expected, found });
        }
        let missing = |source: MeshError| AssemblyError::Region { form, symbol: "derived field", source };
        let facets = self.mesh.facet_region(region).map_err(missing)?;
        let points = space.element.node_points::<D>();
        let found = self.facet_values(expression, place(region), facets, |local| {
            let local = usize::from(local);
            let empty = QuadratureRule { points: vec![], weights: vec![] };
            let tangents = map_to_facet::<D>(self.mesh.shape(), local, &empty)?.tangents;
            let points: Vec<[f64; D]> =
                space.element.facet_nodes(local).into_iter().map(|node| points[node]).collect();
            let weights = vec![0.0; points.len()];
            Ok(FacetRule { points, weights, tangents })
        })?;
        let mut sums = vec![0.0; space.unknowns()];
        let mut counts = vec![0.0_f64; space.node_count()];
        let mut values = found.into_iter();
        for facet in facets {
            for node in space.element.facet_nodes(usize::from(facet.local)) {
                let number = space.cell_nodes(facet.cell as usize)[node] as usize;
                counts[number] += 1.0;
                for (component, value) in values.next().iter().flat_map(|(_, _, value)| value).enumerate() {
                    sums[number * components + component] += value;
                }
            }
        }
        for (index, sum) in sums.iter_mut().enumerate() {
            *sum /= counts[index / components].max(1.0);
        }
        Ok(Field { space: space.clone(), values: Arc::new(sums) })
    }

    /// (position, weight, value) at the points that `rule` gives for each local facet number, facet after
    /// facet. Facets of one local number are computed together, because they share their tables.
    fn facet_values<E: Expression<D>>(
        &self,
        expression: &E,
        place: String,
        facets: &[Facet],
        rule: impl Fn(u8) -> Result<FacetRule<D>, QuadratureError>,
    ) -> Result<Vec<PointValue<D>>, AssemblyError> {
        let form = expression.name();
        let mut by_local: BTreeMap<u8, Vec<usize>> = BTreeMap::new();
        for (index, facet) in facets.iter().enumerate() {
            by_local.entry(facet.local).or_default().push(index);
        }
        let mut counts = Vec::new();
        let found = self.values(expression, |binding| {
            let mut groups = Vec::new();
            for (local, indices) in &by_local {
                let cells = indices.iter().map(|index| facets[*index].cell).collect();
                let group = rule(*local).and_then(|rule| {
                    let (places, weights) = Places::on_facet(*local, rule);
                    Group::new(binding, place.clone(), cells, &places, weights, true)
                });
                let group = group.map_err(|source| AssemblyError::Quadrature { form, source })?;
                counts.push(group.points());
                groups.push(group);
            }
            Ok(groups)
        })?;
        let mut found = found.into_iter();
        let mut ordered = vec![vec![]; facets.len()];
        for (indices, count) in by_local.values().zip(counts) {
            for index in indices {
                ordered[*index] = found.by_ref().take(count).collect();
            }
        }
        Ok(ordered.into_iter().flatten().collect())
    }

    /// (position, weight, value) at every point of the groups, in their order.
    fn values<E: Expression<D>>(
        &self,
        expression: &E,
        build: impl FnOnce(&Binding<D>) -> Result<Vec<Group<D>>, AssemblyError>,
    ) -> Result<Vec<PointValue<D>>, AssemblyError> {
        let binding =
            Binding::new(expression.name(), expression.fields(), expression.inputs(), &self.mesh, &[])?;
        let groups = build(&binding)?;
        let mut visitor = ValueVisitor { binding: &binding, groups: &groups, found: vec![] };
        expression.expression(&mut visitor)?;
        Ok(visitor.found)
    }
}

fn place(region: &str) -> String {
    format!("the region \"{region}\"")
}

/// One factorisation for one use.
fn factor(matrix: &CsrMatrix) -> Result<SymmetricFactor, LinearAlgebraError> {
    let analysis = Arc::new(Analysis::new(matrix.pattern(), &Ordering::default())?);
    SymmetricFactor::cholesky(&analysis, matrix, Vec::new())
}

type PointValue<const D: usize> = ([f64; D], f64, Vec<f64>);

impl<const D: usize> FromIterator<PointValue<D>> for PointValues<D> {
    fn from_iter<T: IntoIterator<Item = PointValue<D>>>(points: T) -> Self {
        let mut all = PointValues { positions: vec![], weights: vec![], values: vec![] };
        for (position, weight, value) in points {
            all.positions.push(position);
            all.weights.push(weight);
            all.values.push(value);
        }
        all
    }
}

struct ValueVisitor<'a, const D: usize> {
    binding: &'a Binding<'a, D>,
    groups: &'a [Group<D>],
    found: Vec<PointValue<D>>,
}

impl<const D: usize> ExpressionVisitor<D> for ValueVisitor<'_, D> {
    type Error = AssemblyError;

    fn visit<K: ExpressionKernel<D>>(&mut self, _: &Integral, kernel: &K) -> Result<(), AssemblyError> {
        for group in self.groups {
            let mut batch = Batch::<f64, D>::new(self.binding, group, K::REQUIREMENTS)?;
            for index in 0..batch.count() {
                let cell = kernel.cell(&batch.load(index));
                for q in 0..group.points() {
                    let geometry = batch.point(q)?;
                    let value = kernel.evaluate(&cell, &geometry, batch.fields()).as_ref().to_vec();
                    if !value.iter().all(|entry| entry.is_finite()) {
                        let (form, position) = (self.binding.name, geometry.position.to_vec());
                        return Err(AssemblyError::ValueNotFinite { form, position });
                    }
                    self.found.push((geometry.position, geometry.weight, value));
                }
            }
        }
        Ok(())
    }
}
