//! Derived fields: any function of a forms module at points, at quadrature points, or along facets.

mod found;
mod on_cells;

use std::sync::Arc;

use forms_core::contract::{Entity, Pairing, Region, Requirements};

pub(crate) use self::found::Found;
use super::binding::{Binding, pair_error};
use super::functional::chunks_of;
use super::groups::{Group, Places};
use super::{Assembler, AssemblyError};
use crate::assemble::binding::entities::Entities;
use crate::assemble::element_loops::point_values::PointBuffers;
use crate::assemble::groups::facet_groups::facet_groups;
use crate::assemble::groups::means::FurtherTables;
use crate::assemble::groups::pair_groups::groups_of;
use crate::contract::Expression;
use crate::cut::CutError;
use crate::element::CellShape;
use crate::field::Field;
use crate::history::{HistoryMismatch, PointsOfPairs};
use crate::instantiate::instantiate;
use crate::locate::Locator;
use crate::mesh::{Facet, MeshError};
use crate::pairs::Pairs;
use crate::quadrature::QuadratureRule;
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
    /// The facet; an interior one from its first side.
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
    /// A point outside the mesh, a function that needs a facet, a value that is not finite, data that do not fit.
    #[inline(never)]
    pub fn at_points(
        &self,
        expression: &Expression<D>,
        points: &[[f64; D]],
    ) -> Result<PointValues<D>, AssemblyError> {
        let form = expression.name();
        self.expect_no_history(expression)?;
        let locator = Locator::new(&self.mesh);
        let mut places = Vec::new();
        for point in points {
            let outside = || AssemblyError::Outside { form, position: point.to_vec() };
            places.push(locator.find(point).ok_or_else(outside)?);
        }
        let found = self.values(expression, &mut |binding| {
            let one = |(cell, reference): &(usize, [f64; D])| {
                let places = Places { points: vec![*reference], facet: None };
                let cells = (self.mesh.cell_shape(*cell), vec![*cell as u32]);
                Group::new(binding, "points".to_owned(), cells, &places, vec![0.0], further(expression))
            };
            let groups = places.iter().map(one).collect::<Result<_, _>>();
            groups.map_err(|source| AssemblyError::Quadrature { form, source })
        })?;
        Ok(found.into())
    }

    /// A derived field at one point: its components, row-major.
    ///
    /// # Errors
    /// As [`Assembler::at_points`].
    pub fn at_point(&self, expression: &Expression<D>, point: [f64; D]) -> Result<Vec<f64>, AssemblyError> {
        Ok(self.at_points(expression, &[point])?.values.into_iter().flatten().collect())
    }

    /// A derived field at the quadrature points of a cell or facet region, with their weights. Where the
    /// choice of quadrature is the compiler's estimate, `degree` is taken, unless the function reads a history:
    /// then it is evaluated at that history's points.
    ///
    /// # Errors
    /// An unknown region, a function that needs a facet, a value that is not finite, or data that do not
    /// fit.
    #[inline(never)]
    pub fn at_quadrature_points(
        &self,
        expression: &Expression<D>,
        entity: Entity,
        region: &str,
        degree: usize,
    ) -> Result<PointValues<D>, AssemblyError> {
        Ok(self.found_at_quadrature_points(expression, entity, region, degree)?.into())
    }

    /// As [`Assembler::at_quadrature_points`].
    ///
    /// # Errors
    /// As there.
    pub(crate) fn found_at_quadrature_points(
        &self,
        expression: &Expression<D>,
        entity: Entity,
        region: &str,
        degree: usize,
    ) -> Result<Found<D>, AssemblyError> {
        let form = expression.name();
        if entity == Entity::Interface {
            return Err(values_refused(form, region));
        }
        self.expect_whole_cells(form, region)?;
        let missing = |source: MeshError| AssemblyError::Region { form, symbol: "derived field", source };
        let quadrature = |source| AssemblyError::Quadrature { form, source };
        let degree = self.history_degree(expression)?.unwrap_or(degree);
        match entity {
            Entity::Cells => {
                let cells = self.mesh.cell_region(region).map_err(missing)?;
                self.values(expression, &mut |binding| {
                    let group = |(shape, cells): (CellShape, &[u32])| {
                        let rule = self.quadrature.rule_on_cells(&self.mesh.shapes(), shape, degree)?;
                        let places = Places { points: rule.points, facet: None };
                        let cells = (shape, cells.to_vec());
                        Group::new(binding, place(region), cells, &places, rule.weights, further(expression))
                    };
                    self.mesh.runs_of_shape(cells).map(|run| group(run).map_err(quadrature)).collect()
                })
            }
            // Pairs are no named facets: an error that names `at_pairs`.
            Entity::Facets | Entity::InteriorFacets | Entity::Pairs | Entity::Interface => {
                let facets = self.facets(form, entity, region)?;
                let shape = self.mesh.shape_of_facets();
                let rule = self.quadrature.facet_reference_rule(shape, degree).map_err(quadrature)?;
                self.facet_values(expression, region, &facets, &rule)
            }
        }
    }

    /// A derived field at the quadrature points of contact pairs, with their weights: gap, jump, what the opposite side
    /// has. Where the choice of quadrature is the compiler's estimate, `degree` is taken. Points without an opposite one
    /// are left out.
    ///
    /// # Errors
    /// Surfaces that cannot be paired, a function that reads a history of something else, a function of position that is another
    /// body's on a surface ([`PairError::Jump`](crate::pairs::PairError::Jump)), a value that is not finite, or data that do not fit.
    #[inline(never)]
    pub fn at_pairs(
        &self,
        expression: &Expression<D>,
        pairing: &Pairing,
        degree: usize,
    ) -> Result<PointValues<D>, AssemblyError> {
        Ok(self.found_at_pairs(expression, pairing, degree)?.into())
    }

    /// A derived field at the own points of contact pairs whose surfaces a displacement moves: what `gap`, `toward` and the opposite side
    /// are in `integral(Touch(u), ..)`. Where the choice of quadrature is the compiler's estimate, `degree` is taken, unless the function
    /// reads a history: then that of its rule. Points without an opposite one are left out.
    ///
    /// # Errors
    /// As [`Assembler::at_pairs`] and [`Assembler::pairs_at`].
    #[inline(never)]
    pub fn at_sliding_pairs(
        &self,
        expression: &Expression<D>,
        pairing: &Pairing,
        degree: usize,
        displacement: &Field<D>,
    ) -> Result<PointValues<D>, AssemblyError> {
        Ok(self.found_on_pairs(expression, pairing, degree, Some(displacement))?.0.into())
    }

    /// As [`Assembler::at_pairs`].
    ///
    /// # Errors
    /// As there.
    pub(crate) fn found_at_pairs(
        &self,
        expression: &Expression<D>,
        pairing: &Pairing,
        degree: usize,
    ) -> Result<Found<D>, AssemblyError> {
        Ok(self.found_on_pairs(expression, pairing, degree, None)?.0)
    }

    /// As [`Assembler::at_pairs`], or [`Assembler::at_sliding_pairs`] where a displacement is given; with the pairs.
    ///
    /// # Errors
    /// As there.
    #[inline(never)]
    pub(crate) fn found_on_pairs(
        &self,
        expression: &Expression<D>,
        pairing: &Pairing,
        degree: usize,
        displacement: Option<&Field<D>>,
    ) -> Result<(Found<D>, Arc<Pairs<D>>), AssemblyError> {
        let described = expression;
        let region = Region::of_pairs("derived field", pairing.clone());
        let failed = |source| pair_error(described.name(), &region, source);
        let binding = Binding::new(described, &self.mesh, &[])?;
        let requirements = requirements(expression);
        let points = PointsOfPairs::of(pairing, displacement.is_some());
        binding.histories_on_pairs(requirements, pairing, points)?;
        let read = binding.history_degree(requirements, &self.quadrature)?;
        let degree = read.map_or(degree, |(_, degree)| degree);
        binding.check_functions(&self.known_pairs, &region, &self.quadrature, degree, requirements.fields)?;
        let pairs = match displacement {
            Some(displacement) => self.pairs_displaced(pairing, degree, displacement),
            None => self.pairs_of(pairing, degree),
        };
        let pairs = Pairs::of_cells(pairs.map_err(failed)?, &self.mesh);
        let place = format!("the pairs {pairing}");
        let found =
            self.values(expression, &mut |binding| groups_of(binding, &place, &pairs, requirements))?;
        Ok((found, pairs))
    }

    /// A derived field along a facet region, exterior or interior: on each facet, in the region's order, at
    /// the given coordinates of the facet's own reference cell (in two dimensions the second one is zero).
    ///
    /// # Errors
    /// An unknown region, a value that is not finite, or data that do not fit.
    #[inline(never)]
    pub fn along_facets(
        &self,
        expression: &Expression<D>,
        region: &str,
        parameters: &[[f64; 2]],
    ) -> Result<Vec<FacetSample<D>>, AssemblyError> {
        let form = expression.name();
        self.expect_no_history(expression)?;
        let interior = self.mesh.interior_facet_region(region).is_ok();
        let entity = if interior { Entity::InteriorFacets } else { Entity::Facets };
        let facets = self.facets(form, entity, region)?;
        let rule = QuadratureRule { points: parameters.to_vec(), weights: vec![0.0; parameters.len()] };
        let found = self.facet_values(expression, region, &facets, &rule)?;
        let facets = (0..facets.count()).map(|index| facets.sides(index)[0]);
        let places = facets.flat_map(|facet| parameters.iter().map(move |parameter| (facet, *parameter)));
        let sample = |(point, (facet, parameter))| FacetSample {
            facet,
            parameter,
            position: found.positions[point],
            value: found.value(point).to_vec(),
        };
        Ok(places.enumerate().map(sample).collect())
    }

    /// `count` equidistant samples on each facet of a two-dimensional mesh's region, both ends included.
    ///
    /// # Errors
    /// As [`Assembler::along_facets`].
    pub fn along_facets_uniformly(
        &self,
        expression: &Expression<D>,
        region: &str,
        count: usize,
    ) -> Result<Vec<FacetSample<D>>, AssemblyError> {
        let last = count.max(2) - 1;
        let parameters: Vec<[f64; 2]> = (0..=last).map(|k| [k as f64 / last as f64, 0.0]).collect();
        self.along_facets(expression, region, &parameters)
    }

    /// A derived field at the nodes of a facet region, averaged over the facets that share a node; zero at
    /// all other nodes of the space. This shows a pressure on the body, for example.
    ///
    /// # Errors
    /// An unknown region, a wrong number of components, a value that is not finite, or data that do not
    /// fit.
    #[inline(never)]
    pub fn at_facet_nodes(
        &self,
        expression: &Expression<D>,
        region: &str,
        space: &Arc<Space<D>>,
    ) -> Result<Field<D>, AssemblyError> {
        let form = expression.name();
        let components = expression.shape().iter().product::<usize>();
        if components != space.components() {
            let (expected, found) = (components, space.components());
            return Err(AssemblyError::Components { form, field: "the space", expected, found });
        }
        self.expect_no_history(expression)?;
        if let Some(region) = space.facet_region() {
            let (place, region) = ("its cells".to_owned(), region.to_owned());
            return Err(AssemblyError::OffItsFacets { form, field: "the space", place, region });
        }
        if !space.is_on_all_cells() {
            let (elements, scope) = (space.elements().clone(), space.scope().clone());
            return Err(AssemblyError::NoValuesOn { form, elements, scope });
        }
        let facets = self.facets(form, Entity::Facets, region)?;
        let points = space.element_of(self.mesh.shape_of_facets()).facet_node_points();
        let rule = QuadratureRule { weights: vec![0.0; points.len()], points };
        let found = self.facet_values(expression, region, &facets, &rule)?;
        let mut sums = vec![0.0; space.unknowns()];
        let mut counts = vec![0.0_f64; space.node_count()];
        let mut point = 0;
        for index in 0..facets.count() {
            let facet = facets.sides(index)[0];
            for node in space.cell_element(facet.cell as usize).facet_nodes(usize::from(facet.local)) {
                let number = space.cell_nodes(facet.cell as usize)[node] as usize;
                counts[number] += 1.0;
                for (component, value) in found.value(point).iter().enumerate() {
                    sums[number * components + component] += value;
                }
                point += 1;
            }
        }
        for (index, sum) in sums.iter_mut().enumerate() {
            *sum /= counts[index / components].max(1.0);
        }
        Ok(Field::of_known(space, sums))
    }

    /// Refuses cut bodies, which have points in parts of cells.
    fn expect_whole_cells(&self, form: &'static str, region: &str) -> Result<(), AssemblyError> {
        if self.cut.is_some() { Err(values_refused(form, region)) } else { Ok(()) }
    }

    fn facets(
        &self,
        form: &'static str,
        entity: Entity,
        region: &str,
    ) -> Result<Entities<'_>, AssemblyError> {
        Entities::of(&self.mesh, form, &Region::named(entity, "derived field", region))
    }

    /// The values at the points of a rule on the facet's own reference cell, facet after facet.
    /// Facets that are numbered alike are computed together, because they share their tables.
    fn facet_values(
        &self,
        expression: &Expression<D>,
        region: &str,
        facets: &Entities,
        rule: &QuadratureRule<2>,
    ) -> Result<Found<D>, AssemblyError> {
        let mut indices = Vec::new();
        let found = self.values(expression, &mut |binding| {
            let (groups, of_groups): (Vec<_>, Vec<Vec<usize>>) =
                facet_groups(binding, &place(region), facets, rule, further(expression))?.into_iter().unzip();
            indices = of_groups.concat();
            Ok(groups)
        })?;
        let mut places = vec![0; indices.len()];
        indices.iter().enumerate().for_each(|(place, index)| places[*index] = place);
        let mut ordered = Found { components: found.components, ..Found::default() };
        for point in places.into_iter().flat_map(|place| place * rule.len()..(place + 1) * rule.len()) {
            let (weight, position) = (found.weights[point], &found.positions[point]);
            ordered.add(expression.name(), found.value(point), weight, position)?;
        }
        Ok(ordered)
    }

    /// The degree of the rule of the histories that a function reads, if it reads any.
    #[inline(never)]
    pub(super) fn history_degree(&self, expression: &Expression<D>) -> Result<Option<usize>, AssemblyError> {
        Ok(self.history_read(expression)?.map(|(_, degree)| degree))
    }

    /// The name of a history that a function reads, and the degree of its rule.
    fn history_read(
        &self,
        expression: &Expression<D>,
    ) -> Result<Option<(&'static str, usize)>, AssemblyError> {
        let binding = Binding::new(expression, &self.mesh, &[])?;
        binding.history_degree(requirements(expression), &self.quadrature)
    }

    /// Points that are not those of a rule have no history.
    fn expect_no_history(&self, expression: &Expression<D>) -> Result<(), AssemblyError> {
        let form = expression.name();
        match self.history_read(expression)? {
            Some((field, _)) => Err(AssemblyError::History { form, field, source: HistoryMismatch::Points }),
            None => Ok(()),
        }
    }

    /// The values at every point of the groups, in their order.
    fn values(
        &self,
        expression: &Expression<D>,
        build: &mut dyn FnMut(&Binding<D>) -> Result<Vec<Group<D>>, AssemblyError>,
    ) -> Result<Found<D>, AssemblyError> {
        let mut binding = Binding::new(expression, &self.mesh, &[])?;
        binding.instructions = self.instructions;
        let groups = build(&binding)?;
        let components = expression.shape().iter().product();
        let mut found = Found { components, ..Found::default() };
        let receive = |found: &mut Found<D>, value: &[f64], weight: f64, position: &[f64; D]| {
            found.add(binding.name, value, weight, position)
        };
        let (mut buffers, mut shapes) = (PointBuffers::default(), vec![]);
        for group in &groups {
            // Memory is made for the sizes of the group before.
            let own: Vec<CellShape> = group.sides.iter().map(|side| side.shape).collect();
            if own != shapes {
                (buffers, shapes) = (PointBuffers::default(), own);
            }
            for term in expression.densities() {
                let chunks = chunks_of(&binding, group, &term.kernel, self.threads, &mut buffers, &receive)?;
                chunks.into_iter().for_each(|chunk| found.append(chunk));
            }
        }
        Ok(found)
    }
}

/// The tables that a derived field reads.
fn further<const D: usize>(expression: &Expression<D>) -> FurtherTables {
    FurtherTables::of(requirements(expression))
}

/// The inputs of an expression's kernel.
fn requirements<const D: usize>(expression: &Expression<D>) -> &'static Requirements {
    expression.densities().first().map_or(&Requirements::NONE, |term| term.kernel.constants().requirements)
}

fn values_refused(form: &'static str, region: &str) -> AssemblyError {
    let (what, place) = ("a list of values at quadrature points", format!("\"{region}\""));
    AssemblyError::Cut { form, place, source: CutError::Refused { what } }
}

fn place(region: &str) -> String {
    format!("the region \"{region}\"")
}

instantiate!(
    derived: Assembler::<D>::at_pairs,
    Assembler::<D>::at_sliding_pairs,
    Assembler::<D>::found_on_pairs,
    Assembler::<D>::at_quadrature_points,
    Assembler::<D>::at_facet_nodes,
    Assembler::<D>::history_degree,
    Assembler::<D>::at_points,
    Assembler::<D>::along_facets,
);
