//! The L² projection of derived fields, and of what is known at quadrature points, to a space.

mod start;

use std::collections::BTreeMap;
use std::sync::Arc;

use forms_core::contract::{Entity, Expression};

use self::start::{Start, nearest_on_reference};
use super::{Assembler, AssemblyError};
use crate::compiled_here::compiled_here;
use crate::constraints::{Constraints, Relation};
use crate::dimension::{Dim, Dimension};
use crate::field::Field;
use crate::linear_algebra::{
    Analysis, CsrMatrix, Entry, Jacobi, KrylovError, KrylovOptions, LinearAlgebraError, OnThreads, Ordering,
    SymmetricFactor, cg,
};
use crate::solve::Elimination;
use crate::space::Space;
use crate::threads::Threads;

/// Relative residual at which the coefficients of a projection are as good as rounding lets them be.
const TOLERANCE: f64 = 1e-14;
/// Iterations beyond which a factor is the better way.
const ITERATIONS: usize = 300;

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
    pub fn project<E: Expression<D>>(
        &self,
        expression: &E,
        space: &Arc<Space<D>>,
    ) -> Result<Field<D>, AssemblyError>
    where
        Dim: Dimension<D>,
    {
        let name = expression.name();
        let components: usize = expression.shape().iter().product();
        if components != space.components() {
            let (expected, found) = (components, space.components());
            return Err(AssemblyError::Components { form: name, field: "the space", expected, found });
        }
        let degree = self.degree_of_mass(space);
        let found = self.at_quadrature_points(expression, Entity::Cells, crate::mesh::EVERYWHERE, degree)?;
        let degree = self.history_degree(expression)?.unwrap_or(degree);
        let (values, weights) = (found.values.concat(), found.weights);
        self.project_values(&ValuesAtPoints { name, degree, values: &values, weights: &weights }, space)
    }

    /// The degree of the rule that is exact for a space's mass matrix on affine cells.
    pub(crate) fn degree_of_mass(&self, space: &Space<D>) -> usize {
        2 * space.degree + self.mesh.degree()
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
        let form = known.name;
        if let Some(region) = space.facet_region() {
            let (place, region) = ("all cells".to_owned(), region.to_owned());
            return Err(AssemblyError::OffItsFacets { form, field: "the space", place, region });
        }
        let mass = crate::norms::mass_matrix(&self.on_all_cells(), space, self.degree_of_mass(space))?;
        self.project_with_mass(known, space, mass)
    }

    /// The projection with the space's scalar mass matrix.
    #[inline(never)]
    fn project_with_mass(
        &self,
        known: &ValuesAtPoints,
        space: &Arc<Space<D>>,
        mut mass: CsrMatrix,
    ) -> Result<Field<D>, AssemblyError> {
        let (form, components) = (known.name, space.components());
        let linear_algebra = |source: LinearAlgebraError| AssemblyError::LinearAlgebra { form, source };
        let mut load = vec![vec![0.0; space.node_count()]; components];
        let (mut start, mut first) = (Start::new(space.node_count(), components), 0);
        for block in self.mesh.body_blocks() {
            let rule = self.quadrature.rule_on_cells(&self.mesh.shapes(), block.shape, known.degree);
            let rule = rule.map_err(|source| AssemblyError::Quadrature { form, source })?;
            let tables = space.element_of(block.shape).tabulate(&rule.points);
            let nearest = nearest_on_reference(&rule, &tables);
            for cell in block.cells.clone() {
                let points = first..first + rule.len();
                first = points.end;
                let values = &known.values[points.start * components..points.end * components];
                let nodes = space.cell_nodes(cell);
                let values_and_weights = values.chunks(components).zip(&known.weights[points]);
                for (q, (value, weight)) in values_and_weights.enumerate() {
                    for (node, number) in nodes.iter().enumerate() {
                        let share = weight * tables.value[q * tables.nodes + node];
                        for (load, value) in load.iter_mut().zip(value) {
                            load[*number as usize] += share * value;
                        }
                    }
                }
                if let Some(nearest) = &nearest {
                    start.add(nodes, nearest, values);
                }
            }
        }
        let mut start = start.averages();
        // Cells that carry rigid surfaces have no quantities: the projection is zero there.
        let carriers = self.mesh.body_cells().end..self.mesh.cell_count();
        let nodes = carriers.flat_map(|cell| space.cell_nodes(cell));
        let entries: Vec<Entry> = nodes.map(|node| Entry { row: *node, column: *node, value: 1.0 }).collect();
        if !entries.is_empty() {
            mass = mass.plus(&entries).map_err(linear_algebra)?;
        }
        // Where nodes hang, the nearest of the continuous fields is asked for.
        let hanging = |source| AssemblyError::Hanging { form, source: Box::new(source) };
        let mut elimination = match Constraints::joining(space).map_err(hanging)? {
            Some(joined) => {
                let found = Elimination::new(space.node_count(), &BTreeMap::new())
                    .and_then(|all| all.with_relations(of_nodes(&joined, components)));
                Some(found.map_err(linear_algebra)?)
            }
            None => None,
        };
        if let Some(elimination) = &mut elimination {
            mass = elimination.reduce_matrix(&mass.into()).map_err(linear_algebra)?;
            for values in &mut load {
                *values = elimination.reduce(values).map_err(linear_algebra)?;
            }
            start = vec![vec![0.0; mass.rows()]; components];
        }
        let mut coefficients = vec![0.0; space.unknowns()];
        let found =
            solve(&mass, load.into_iter().zip(start).collect(), self.threads).map_err(linear_algebra)?;
        for (component, mut values) in found.into_iter().enumerate() {
            if let Some(elimination) = &elimination {
                values = elimination.extend_by_zero(&values).map_err(linear_algebra)?;
            }
            for (node, value) in values.into_iter().enumerate() {
                coefficients[node * components + component] = value;
            }
        }
        Ok(Field::of_known(space, coefficients))
    }
}

compiled_here!(Assembler::<D>::project_with_mass);

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

/// The systems of a mass matrix with some right-hand sides, each with a start.
///
/// The condition of a mass matrix scaled by its diagonal does not depend on the mesh, only on the element (Wathen 1987: 6.25
/// for biquadratic quadrilaterals): some forty iterations reach rounding, where a factor would have many times the
/// entries of the matrix.
fn solve(
    mass: &CsrMatrix,
    loads: Vec<(Vec<f64>, Vec<f64>)>,
    threads: Threads,
) -> Result<Vec<Vec<f64>>, LinearAlgebraError> {
    // As many right-hand sides at once as there are threads, and the threads that are left for each of them.
    let at_once = threads.count().min(loads.len()).max(1);
    let own = Threads::new(threads.count() / at_once);
    let options = KrylovOptions {
        tolerance: TOLERANCE,
        max_iterations: ITERATIONS,
        threads: own,
        ..Default::default()
    };
    let inverse = Jacobi::of(mass)?;
    let one = |(load, start): &(Vec<f64>, Vec<f64>)| -> Result<Vec<f64>, KrylovError> {
        let mut values = start.clone();
        cg(&OnThreads(mass, own), &mut &inverse, load, &mut values, &options)?;
        Ok(values)
    };
    let mut found = Vec::with_capacity(loads.len());
    for some in loads.chunks(at_once) {
        found.extend(threads.run(some.iter().collect(), one));
    }
    match found.into_iter().collect::<Result<Vec<_>, _>>() {
        Ok(found) => Ok(found),
        // Cells that are all but flat: the factor says what is wrong, or solves the systems.
        Err(_) => {
            let analysis = Arc::new(Analysis::new(mass.pattern(), &Ordering::default())?);
            let factor = SymmetricFactor::cholesky(&analysis, mass, Vec::new())?;
            let mut found: Vec<Vec<f64>> = loads.into_iter().map(|(load, _)| load).collect();
            found.iter_mut().try_for_each(|load| factor.solve_in_place(load))?;
            Ok(found)
        }
    }
}
