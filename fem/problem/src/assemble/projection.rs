//! The L² projection of derived fields, and of what is known at quadrature points, to a space.

mod loads;
mod mass;
mod pieces;
mod solve;
mod start;
mod together;

use std::collections::BTreeMap;
use std::ops::{ControlFlow, Range};
use std::sync::Arc;

use self::loads::{Block, Receive, Systems, ValuesOfCells, blocks, systems};
use self::mass::MassByCells;
pub(super) use self::pieces::Pieces;
pub(super) use self::solve::cells_of_parts;
use self::solve::{by_cells, by_factor, by_matrix};
use super::groups::degrees::degree_on_all_cells;
use super::{Assembler, AssemblyError};
use crate::constraints::{Constraints, Relation};
use crate::contract::Expression;
use crate::dimension::{Dim, Dimension};
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::linear_algebra::{CsrMatrix, Entry, LinearAlgebraError};
use crate::solve::Elimination;
use crate::space::Space;

/// Values of a function at the quadrature points of all cells of bodies, cell by cell.
pub(crate) struct ValuesAtPoints<'a> {
    /// The function's name in messages.
    pub name: &'static str,
    /// The degree of the rule, where the assembler takes the compiler's estimate.
    pub degree: usize,
    /// Components at each point, one point after the other.
    pub values: &'a [f64],
    /// Quadrature weight times measure of each point.
    pub weights: &'a [f64],
}

impl<const D: usize> Assembler<D> {
    /// The L² projection of a derived field to a space. Facet quantities cannot be projected. Where nodes hang in a mesh of
    /// trees, it is the nearest of the continuous fields.
    ///
    /// # Errors
    /// A wrong number of components, a function that needs a facet, a value that is not finite, data
    /// that do not fit, or a mass matrix that cannot be factored.
    pub fn project(
        &self,
        expression: &Expression<D>,
        space: &Arc<Space<D>>,
    ) -> Result<Field<D>, AssemblyError>
    where
        Dim: Dimension<D>,
    {
        self.project_together([(expression, space)]).map(|[found]| found)
    }

    /// The L² projections of derived fields, each to its space. Spaces with the same nodes share one mass matrix, and all components of
    /// their fields are found in one iteration.
    ///
    /// # Errors
    /// As [`Assembler::project`].
    pub fn project_together<const N: usize>(
        &self,
        fields: [(&Expression<D>, &Arc<Space<D>>); N],
    ) -> Result<[Field<D>; N], AssemblyError>
    where
        Dim: Dimension<D>,
    {
        fields.iter().try_for_each(|(expression, space)| check_field(expression, space))?;
        let mut found: Vec<Vec<f64>> = vec![vec![]; N];
        let mut is_left = vec![true; N];
        for first in 0..N {
            let space = fields[first].1;
            let group: Vec<usize> =
                (first..N).filter(|k| is_left[*k] && has_nodes_of(fields[*k].1, space)).collect();
            if group.is_empty() {
                continue;
            }
            let (mut systems, pieces) = (vec![], Pieces::new(space));
            for k in &group {
                is_left[*k] = false;
                systems.extend(self.systems_of(fields[*k], &pieces)?);
            }
            let mut components = self.solutions(fields[first].0.name(), space, &pieces, systems)?.into_iter();
            for k in group {
                let own = components.by_ref().take(fields[k].1.components());
                found[k] = interleaved(space.node_count(), own.collect());
            }
        }
        let mut found = found.into_iter();
        Ok(fields.map(|(_, space)| Field::of_known(space, found.next().unwrap_or_default())))
    }

    /// The systems for a derived field's components.
    #[inline(never)]
    fn systems_of(
        &self,
        (expression, space): (&Expression<D>, &Arc<Space<D>>),
        pieces: &Pieces,
    ) -> Result<Systems, AssemblyError> {
        let degree = self.history_degree(expression)?.unwrap_or_else(|| self.degree_of_mass(space));
        let values = self.values_on_cells(expression, degree)?;
        let blocks = self.blocks(expression.name(), degree, space)?;
        self.systems(&blocks, space, pieces, &|block, cells, receive| values.at_cells(block, cells, receive))
    }

    /// The degree of the rule that is exact for a space's mass matrix on all cells.
    pub(crate) fn degree_of_mass(&self, space: &Space<D>) -> usize {
        degree_on_all_cells(&self.mesh, 2 * space.degree)
    }

    /// The L² projection of a function that is known at quadrature points.
    ///
    /// # Errors
    /// A space on facets, or a mass matrix that cannot be factored.
    pub(crate) fn project_values(
        &self,
        known: &ValuesAtPoints,
        space: &Arc<Space<D>>,
    ) -> Result<Field<D>, AssemblyError>
    where
        Dim: Dimension<D>,
    {
        check_space(known.name, space)?;
        let pieces = Pieces::new(space);
        let blocks = self.blocks(known.name, known.degree, space)?;
        let (mut starts, components) = (vec![0], space.components());
        starts.extend(blocks.iter().scan(0, |sum, block| {
            *sum += block.cells * block.points;
            Some(*sum)
        }));
        let at_cells = |block: usize, cells: Range<usize>, receive: Receive| {
            let point = |cell: usize| starts[block] + cell * blocks[block].points;
            let points = point(cells.start)..point(cells.end);
            let values = known.values[points.start * components..].chunks(components);
            values.zip(&known.weights[points]).for_each(|(value, weight)| receive(value, *weight));
            Ok(())
        };
        let systems = self.systems(&blocks, space, &pieces, &at_cells)?;
        let found = self.solutions(known.name, space, &pieces, systems)?;
        Ok(Field::of_known(space, interleaved(space.node_count(), found)))
    }

    fn blocks(
        &self,
        form: &'static str,
        degree: usize,
        space: &Space<D>,
    ) -> Result<Vec<Block>, AssemblyError> {
        blocks(degree, &self.quadrature, space).map_err(|source| AssemblyError::Quadrature { form, source })
    }

    fn systems(
        &self,
        blocks: &[Block],
        space: &Space<D>,
        pieces: &Pieces,
        values: &ValuesOfCells,
    ) -> Result<Systems, AssemblyError> {
        systems(values, blocks, space.components(), pieces, (self.instructions, self.threads))
    }

    /// The solutions of systems with a space's scalar mass matrix.
    fn solutions(
        &self,
        form: &'static str,
        space: &Arc<Space<D>>,
        pieces: &Pieces,
        systems: Systems,
    ) -> Result<Vec<Vec<f64>>, AssemblyError>
    where
        Dim: Dimension<D>,
    {
        let (systems, joined) = match self.solve_by_cells(form, space, pieces, systems)? {
            ControlFlow::Break(found) => return Ok(found),
            ControlFlow::Continue(left) => left,
        };
        let mass = crate::norms::mass_matrix(&self.on_all_cells(), space, self.degree_of_mass(space))?;
        self.solve_with_mass(form, space, (mass, systems), joined)
    }

    /// The solutions without a matrix, or the systems and relations for which one is needed.
    #[inline(never)]
    fn solve_by_cells(
        &self,
        form: &'static str,
        space: &Arc<Space<D>>,
        pieces: &Pieces,
        mut systems: Systems,
    ) -> Result<ControlFlow<Vec<Vec<f64>>, Joined<D>>, AssemblyError> {
        // Where nodes hang, the nearest of the continuous fields is asked for.
        let joined = Constraints::joining(space)
            .map_err(|source| AssemblyError::Hanging { form, source: Box::new(source) })?;
        if joined.is_none() {
            let degree = self.degree_of_mass(space);
            let mass = MassByCells::new(space, pieces, degree, self.instructions)
                .map_err(|source| AssemblyError::Quadrature { form, source })?;
            // Cells that are all but flat: the matrix says what is wrong, or its factor solves the systems.
            if let Ok(found) = by_cells(&mass, &mut systems, self.threads) {
                return Ok(ControlFlow::Break(found));
            }
        }
        Ok(ControlFlow::Continue((systems, joined)))
    }

    /// The solutions with the space's scalar mass matrix, on the free nodes of joined ones.
    #[inline(never)]
    fn solve_with_mass(
        &self,
        form: &'static str,
        space: &Arc<Space<D>>,
        (mut mass, mut systems): (CsrMatrix, Systems),
        joined: Option<Constraints<D>>,
    ) -> Result<Vec<Vec<f64>>, AssemblyError> {
        let linear_algebra = |source: LinearAlgebraError| AssemblyError::LinearAlgebra { form, source };
        // Cells that carry rigid surfaces have no quantities: the projection is zero there.
        let carriers = self.mesh.body_cells().end..self.mesh.cell_count();
        let nodes = carriers.flat_map(|cell| space.cell_nodes(cell));
        let entries: Vec<Entry> = nodes.map(|node| Entry { row: *node, column: *node, value: 1.0 }).collect();
        if !entries.is_empty() {
            mass = mass.plus(&entries).map_err(linear_algebra)?;
        }
        let Some(joined) = joined else {
            return by_factor(&mass, systems).map_err(linear_algebra);
        };
        let elimination = Elimination::new(space.node_count(), &BTreeMap::new())
            .and_then(|all| all.with_relations(of_nodes(&joined, space.components())));
        let mut elimination = elimination.map_err(linear_algebra)?;
        mass = elimination.reduce_matrix(&mass.into()).map_err(linear_algebra)?;
        for (load, start) in &mut systems {
            *load = elimination.reduce(load).map_err(linear_algebra)?;
            *start = vec![0.0; mass.rows()];
        }
        let found = by_matrix(&mass, systems, self.threads).map_err(linear_algebra)?;
        let extended = found.into_iter().map(|values| elimination.extend_by_zero(&values));
        extended.collect::<Result<_, _>>().map_err(linear_algebra)
    }
}

instantiate!(assemble_projection: Assembler::<D>::systems_of, Assembler::<D>::solve_by_cells, Assembler::<D>::solve_with_mass);

/// The systems for which a matrix is needed, with the relations of hanging nodes.
type Joined<const D: usize> = (Systems, Option<Constraints<D>>);

/// The relations of a space's first component between nodes, which are those of all components.
fn of_nodes<const D: usize>(joined: &Constraints<D>, components: usize) -> BTreeMap<usize, Relation> {
    let relations = joined.relations().iter().filter(|(unknown, _)| *unknown % components == 0);
    let of_nodes = |(unknown, relation): (&usize, &Relation)| {
        let mut relation = relation.clone();
        relation.terms.iter_mut().for_each(|term| term.0 /= components);
        (unknown / components, relation)
    };
    relations.map(of_nodes).collect()
}

/// Refuses a space that a derived field does not fit.
fn check_field<const D: usize>(expression: &Expression<D>, space: &Space<D>) -> Result<(), AssemblyError> {
    let form = expression.name();
    let expected: usize = expression.shape().iter().product();
    let found = space.components();
    if found != expected {
        return Err(AssemblyError::Components { form, field: "the space", expected, found });
    }
    check_space(form, space)
}

/// Refuses a space that has no values in some cells.
fn check_space<const D: usize>(form: &'static str, space: &Space<D>) -> Result<(), AssemblyError> {
    let whole = space.mesh().without_pieces("a projection", crate::mesh::TAKE_THE_WHOLE);
    whole.map_err(|source| AssemblyError::Mesh { form, source })?;
    if let Some(region) = space.facet_region() {
        let (place, region) = ("all cells".to_owned(), region.to_owned());
        return Err(AssemblyError::OffItsFacets { form, field: "the space", place, region });
    }
    if !space.is_on_all_cells() {
        let (elements, scope) = (space.elements().clone(), space.scope().clone());
        return Err(AssemblyError::NoValuesOn { form, elements, scope });
    }
    Ok(())
}

/// Whether two spaces have the same nodes, so that they have one scalar mass matrix.
fn has_nodes_of<const D: usize>(space: &Space<D>, other: &Space<D>) -> bool {
    space.mesh().is_same(other.mesh())
        && space.degree == other.degree
        && space.elements() == other.elements()
        && space.scope() == other.scope()
}

/// The coefficients with these values at the nodes, component by component.
fn interleaved(nodes: usize, found: Vec<Vec<f64>>) -> Vec<f64> {
    let components = found.len();
    let mut coefficients = vec![0.0; nodes * components];
    for (component, values) in found.into_iter().enumerate() {
        for (node, value) in values.into_iter().enumerate() {
            coefficients[node * components + component] = value;
        }
    }
    coefficients
}
