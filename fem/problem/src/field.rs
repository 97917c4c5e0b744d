//! Discrete fields: coefficients on a space.

mod file;
mod sums;
mod transfer;

use std::any::Any;
use std::sync::{Arc, OnceLock};

use forms_core::contract::{Datum, DiscreteField, FieldHandle, FieldValue, Given, Source};
use thiserror::Error;

use crate::element::Elements;
use crate::element::MAXIMUM_NODES;
use crate::instantiate::instantiate;
use crate::linear_algebra::vector::{first_not_finite, is_finite};
use crate::mesh::small_matrices::inverse;
use crate::space::{CellInSpace, Scope, Space};

pub use file::FieldFileError;
pub(crate) use transfer::places;
pub use transfer::{Transfer, TransferError};

/// Nodes up to which a cell has few: simplices of degree 2 and triangles of degree 3.
const FEW_NODES: usize = 10;

/// A field on a space: one coefficient per unknown, `values[node * components + component]`.
///
/// ```
/// # use forms_fem::prelude::*;
/// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
/// # let space = Space::scalar(&mesh, 1)?;
/// let u = Field::interpolate(&space, |x| x[0])?;
/// let known: Given<f64, 2> = Given::field(&u); // data of a form
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Field<const D: usize> {
    pub(crate) space: Arc<Space<D>>,
    coefficients: Arc<Coefficients>,
}

/// Numbers that do not change, so that it is found out once whether they are finite.
#[derive(Debug)]
struct Coefficients {
    values: Vec<f64>,
    finite: OnceLock<bool>,
}

/// Coefficients on a space, borrowed.
#[derive(Clone, Copy)]
#[doc(hidden)]
pub struct FieldView<'a, const D: usize> {
    pub space: &'a Arc<Space<D>>,
    pub values: &'a [f64],
    /// Those that will be read are known to be finite.
    pub finite: bool,
}

/// Fields as coefficients on their spaces.
#[inline(never)]
pub(crate) fn views<'a, const D: usize>(fields: &[&'a Field<D>]) -> Vec<FieldView<'a, D>> {
    fields.iter().map(|field| field.view()).collect()
}

/// Coefficients of several fields, one field after the other, as views on their spaces.
#[doc(hidden)]
pub fn views_on<'a, const D: usize>(
    spaces: &[&'a Arc<Space<D>>],
    values: &'a [f64],
) -> Vec<FieldView<'a, D>> {
    let mut rest = values;
    let view = |space: &&'a Arc<Space<D>>| {
        let (values, others) = rest.split_at(space.unknowns());
        rest = others;
        FieldView { space, values, finite: false }
    };
    spaces.iter().map(view).collect()
}

/// Coefficients of several fields, one field after the other, as fields on their spaces.
///
/// # Errors
/// [`FieldError::NotFinite`].
#[doc(hidden)]
pub fn fields_on<const D: usize>(
    spaces: &[&Arc<Space<D>>],
    values: &[f64],
) -> Result<Vec<Field<D>>, FieldError> {
    let field = |view: FieldView<D>| Field::from_values(view.space, view.values.to_vec());
    views_on(spaces, values).into_iter().map(field).collect()
}

/// The coefficients of a function on facets by its values at the nodes: facets give a common node the same one.
fn coefficients_by_values<const D: usize>(space: &Space<D>, values: &[f64]) -> Vec<f64> {
    let (components, mut coefficients) = (space.components(), values.to_vec());
    for (facet, nodes) in space.facets.iter() {
        let Some(rows) = space.cell_element(facet.cell as usize).coefficients_by_values() else { continue };
        for (node, row) in nodes.iter().zip(rows) {
            for component in 0..components {
                let at = |node: u32| node as usize * components + component;
                let terms = nodes.iter().zip(&row).map(|(other, factor)| factor * values[at(*other)]);
                coefficients[at(*node)] = terms.sum();
            }
        }
    }
    coefficients
}

/// Errors of a field or of its evaluation.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum FieldError {
    /// A wrong number of coefficients.
    #[error("the space has {unknowns} unknowns, but {length} values were given")]
    Length {
        /// Unknowns of the space.
        unknowns: usize,
        /// Values given.
        length: usize,
    },
    /// The function's value has another number of components than the space.
    #[error("the space has {space} components, but the function gives {function}")]
    Components {
        /// Components of the space.
        space: usize,
        /// Components of the function's value.
        function: usize,
    },
    /// Values of cells for a space that is not constant on each cell, or values of facets likewise.
    #[error(
        "values on {entities} are those of a space that is constant on each of them; this one has {elements} {scope}"
    )]
    NotConstant {
        /// "cells" or "facets".
        entities: &'static str,
        /// Elements of the space.
        elements: Elements,
        /// Scope of the space.
        scope: Scope,
    },
    /// Coefficients that are no values.
    #[error("a space of {elements} interpolates no function: its coefficients are not values at nodes")]
    NotNodal {
        /// Elements of the space.
        elements: Elements,
    },
    /// A coefficient is NaN or infinite.
    #[error("component {component} at node {node}, position {position:?}, is not finite: {value}")]
    NotFinite { node: usize, component: usize, position: Vec<f64>, value: f64 },
    /// Fields on different spaces cannot be added.
    #[error("the fields are not on one space: {differ}")]
    OtherSpace {
        /// In what the spaces differ.
        differ: String,
    },
    /// A sum without terms has no space.
    #[error("a combination of fields needs at least one")]
    NothingToAdd,
    /// The field lives on facets alone, and a point of the mesh is hardly ever on one.
    #[error(
        "the field lives on the facets of \"{region}\" alone: evaluate it along that region with a function"
    )]
    OnFacets {
        /// The facet region of its space.
        region: String,
    },
    /// The field is known at the points of a rule only.
    #[error(
        "the field is known at the points of its rule only: integrate it, or `project` a function that reads it"
    )]
    AtPoints,
    /// The point is in no cell of the space.
    #[error("the point {point:?} lies outside the mesh")]
    Outside { point: Vec<f64> },
}

impl<const D: usize> From<&Field<D>> for Source<D> {
    fn from(field: &Field<D>) -> Self {
        Source::Discrete(field.into())
    }
}

impl<const D: usize> From<Field<D>> for Source<D> {
    fn from(field: Field<D>) -> Self {
        Source::Discrete(field.into())
    }
}

impl<const D: usize> Field<D> {
    /// The field that is zero.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// assert_eq!(Field::zero(&space).values(), [0.0; 15]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[inline(never)]
    pub fn zero(space: &Arc<Space<D>>) -> Self {
        Field::of_known(space, vec![0.0; space.unknowns()])
    }

    /// The field with the function's values at the nodes, also where coefficients are others: `f64` for a scalar space, `[f64; D]` for
    /// vectors, `[[f64; D]; D]` for tensors.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// let field = Field::interpolate(&space, |x| x[0] + 2.0 * x[1])?;
    /// assert_eq!(field.evaluate(&[1.0, 0.5])?, [2.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`FieldError::Components`] when the value does not fit the space, [`FieldError::NotFinite`] names
    /// the node.
    pub fn interpolate<V: FieldValue>(
        space: &Arc<Space<D>>,
        function: impl Fn(&[f64; D]) -> V,
    ) -> Result<Self, FieldError> {
        let components = space.components();
        if V::COMPONENTS != components {
            return Err(FieldError::Components { space: components, function: V::COMPONENTS });
        }
        if space.elements().is_dual() {
            return Err(FieldError::NotNodal { elements: space.elements().clone() });
        }
        let mut values = vec![0.0; space.unknowns()];
        for (position, value) in space.positions().iter().zip(values.chunks_mut(components)) {
            function(position).write(value);
        }
        if !space.elements().is_nodal() {
            values = coefficients_by_values(space, &values);
        }
        Field::from_values(space, values)
    }

    /// The field with the given coefficients: all components of node 0, then those of node 1, in the space's numbering.
    ///
    /// [`Space::positions`] has the place of each node, and [`Space::cell_nodes`] the nodes of each cell. Nodes are numbered along a
    /// curve through the mesh, not as the mesh numbers its nodes and cells, in degree 0 neither:
    /// [`Field::from_cell_values`] takes a list of values of cells.
    ///
    /// # Errors
    /// [`FieldError::Length`], or [`FieldError::NotFinite`], which names the node.
    #[inline(never)]
    pub fn from_values(space: &Arc<Space<D>>, values: Vec<f64>) -> Result<Self, FieldError> {
        let unknowns = space.unknowns();
        if values.len() != unknowns {
            return Err(FieldError::Length { unknowns, length: values.len() });
        }
        if let Some(unknown) = first_not_finite(&values) {
            let (node, component) = (unknown / space.components(), unknown % space.components());
            let position = space.positions()[node].to_vec();
            return Err(FieldError::NotFinite { node, component, position, value: values[unknown] });
        }
        let coefficients = Arc::new(Coefficients { values, finite: OnceLock::from(true) });
        Ok(Field { space: Arc::clone(space), coefficients })
    }

    /// The field that is constant on each cell, from the values of the cells in the order of the mesh: all components of cell 0, then
    /// those of cell 1. Cells that carry rigid surfaces are not counted.
    ///
    /// ```
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = rectangle([0.0; 2], [3.0, 2.0], [3, 2], CellShape::Quadrilateral, 1)?;
    /// let stiffness = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0];
    /// let space = Space::discontinuous_scalar(&mesh, 0)?;
    /// let k = Field::from_cell_values(&space, &stiffness)?;
    /// // Cell 4 has its centre at (1.5, 1.5).
    /// assert_eq!(k.evaluate(&[1.5, 1.5])?, [50.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`FieldError::NotConstant`] unless the space is discontinuous of degree 0; [`FieldError::Length`];
    /// [`FieldError::NotFinite`], which names the position.
    #[inline(never)]
    pub fn from_cell_values(space: &Arc<Space<D>>, values: &[f64]) -> Result<Self, FieldError> {
        let of_cells = space.mesh().cells_of_bodies().map(|cell| space.cell_nodes(cell).first().copied());
        let is_constant = *space.scope() == Scope::Cell && space.is_constant();
        Field::from_constants(space, values, ("cells", is_constant), &of_cells.flatten().collect::<Vec<_>>())
    }

    /// The field that is constant on each facet of the region of a space on facets, from the values of the facets in the order of the
    /// region: all components of its first facet, then those of its second.
    ///
    /// ```
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = rectangle([0.0; 2], [3.0, 2.0], [3, 2], CellShape::Quadrilateral, 1)?;
    /// let space = Space::on_facets(&mesh, "top", 0)?;
    /// let pressure = Field::from_facet_values(&space, &[1.0, 2.0, 3.0])?;
    /// let first = mesh.facet_centre(mesh.facet_region("top")?[0]);
    /// let node = space.nearest_node(&first).ok_or("no node")?;
    /// assert_eq!(pressure.at_node(node), [1.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`FieldError::NotConstant`] unless the space is one on facets of degree 0; [`FieldError::Length`]; [`FieldError::NotFinite`],
    /// which names the position.
    #[inline(never)]
    pub fn from_facet_values(space: &Arc<Space<D>>, values: &[f64]) -> Result<Self, FieldError> {
        let facets = space.facet_region().map(|region| space.mesh().sides_of(region));
        let first = facets.and_then(Result::ok).unwrap_or_default().into_iter().map(|sides| sides[0]);
        let nodes = first.filter_map(|facet| space.nodes_at(facet.cell, Some(facet.local)).first().copied());
        let is_constant = space.facet_region().is_some() && space.is_constant();
        Field::from_constants(space, values, ("facets", is_constant), &nodes.collect::<Vec<_>>())
    }

    /// The field with these values at these nodes, one node after the other.
    fn from_constants(
        space: &Arc<Space<D>>,
        values: &[f64],
        (entities, is_constant): (&'static str, bool),
        nodes: &[u32],
    ) -> Result<Self, FieldError> {
        if !is_constant {
            let (elements, scope) = (space.elements().clone(), space.scope().clone());
            return Err(FieldError::NotConstant { entities, elements, scope });
        }
        let components = space.components();
        if values.len() != nodes.len() * components {
            return Err(FieldError::Length { unknowns: nodes.len() * components, length: values.len() });
        }
        let mut ordered = vec![0.0; space.unknowns()];
        for (&node, value) in nodes.iter().zip(values.chunks(components)) {
            let first = node as usize * components;
            ordered[first..first + components].copy_from_slice(value);
        }
        Field::from_values(space, ordered)
    }

    /// The field with coefficients of the right number.
    #[inline(never)]
    #[doc(hidden)]
    pub fn of_known(space: &Arc<Space<D>>, values: Vec<f64>) -> Self {
        let coefficients = Arc::new(Coefficients { values, finite: OnceLock::new() });
        Field { space: Arc::clone(space), coefficients }
    }

    #[inline(never)]
    #[doc(hidden)]
    pub fn view(&self) -> FieldView<'_, D> {
        let Coefficients { values, finite } = &*self.coefficients;
        let finite = *finite.get_or_init(|| is_finite(values));
        FieldView { space: &self.space, values, finite }
    }

    /// The space.
    pub fn space(&self) -> &Arc<Space<D>> {
        &self.space
    }

    /// The coefficients.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// // All components of node 0, then those of node 1.
    /// let field = Field::from_values(&space, vec![3.0; 15])?;
    /// assert_eq!(field.values(), [3.0; 15]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn values(&self) -> &[f64] {
        &self.coefficients.values
    }

    /// The components at a node.
    ///
    /// # Panics
    /// When `node` is not below [`Space::node_count`].
    pub fn at_node(&self, node: usize) -> &[f64] {
        let components = self.space.components();
        &self.coefficients.values[node * components..(node + 1) * components]
    }

    /// The components at a point of the mesh; of a discontinuous field, in the cell with the lowest index.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// let space = Space::vector(&mesh, 1)?;
    /// let field = Field::interpolate(&space, |x| [x[1], -x[0]])?;
    /// assert_eq!(field.evaluate(&[0.5, 0.5])?, [0.5, -0.5]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`FieldError::OnFacets`]; [`FieldError::Outside`], where [`crate::locate::Locator::find_nearest`] helps
    /// with points that are nearly inside.
    #[inline(never)]
    pub fn evaluate(&self, point: &[f64; D]) -> Result<Vec<f64>, FieldError> {
        let (cell, reference) = self.find(point)?;
        Ok(self.evaluate_in(cell, &reference))
    }

    /// The gradient \[1/length\] at a point of the mesh, row-major: component, then direction. On facets it
    /// is that of the cell with the lowest index.
    ///
    /// # Errors
    /// [`FieldError::OnFacets`], [`FieldError::Outside`].
    #[inline(never)]
    pub fn gradient(&self, point: &[f64; D]) -> Result<Vec<f64>, FieldError> {
        let (cell, reference) = self.find(point)?;
        Ok(self.gradient_in(cell, &reference))
    }

    /// The components at a reference point of a cell, which may lie outside it (extrapolation). NaN for a
    /// field on facets.
    ///
    /// # Panics
    /// When the mesh has no such cell.
    #[inline(never)]
    pub fn evaluate_in(&self, cell: usize, reference: &[f64; D]) -> Vec<f64> {
        let mut result = vec![self.empty_sum(cell); self.space.components()];
        self.add_value_in(cell, reference, &mut result);
        result
    }

    /// Adds the components at a reference point of a cell to a sum; nothing for a field on facets.
    pub(crate) fn add_value_in(&self, cell: usize, reference: &[f64; D], sum: &mut [f64]) {
        // To set the room of the largest element to zero takes longer than to fill that of most.
        match self.space.cell_nodes(cell).len() {
            ..=FEW_NODES => self.add_value_with::<FEW_NODES>(cell, reference, sum),
            _ => self.add_value_with::<MAXIMUM_NODES>(cell, reference, sum),
        }
    }

    /// [`Field::add_value_in`] with room for the given number of basis functions.
    fn add_value_with<const N: usize>(&self, cell: usize, reference: &[f64; D], sum: &mut [f64]) {
        let mut value = [0.0; N];
        self.space.basis_in(cell, reference, &mut value);
        for (&node, phi) in self.space.cell_nodes(cell).iter().zip(&value) {
            for (sum, coefficient) in sum.iter_mut().zip(self.at_node(node as usize)) {
                *sum += phi * coefficient;
            }
        }
    }

    /// The gradient \[1/length\] at a reference point of a cell, row-major. Where the cell's Jacobian is
    /// singular, which can only happen outside the cell, it is NaN, and so it is for a field on facets.
    ///
    /// # Panics
    /// When the mesh has no such cell.
    #[inline(never)]
    pub fn gradient_in(&self, cell: usize, reference: &[f64; D]) -> Vec<f64> {
        let (mut value, mut slopes) = ([0.0; MAXIMUM_NODES], [[0.0; D]; MAXIMUM_NODES]);
        let element = self.space.cell_element(cell);
        element.evaluate(reference, &mut value, &mut slopes);
        let (_, jacobian) = self.space.mesh().map(cell, reference);
        let inverse = match element.is_in_space() {
            // Functions of degree 1: their slopes are the same everywhere.
            true => *CellInSpace::of(self.space.mesh(), cell).inverse(),
            false => inverse(&jacobian).unwrap_or([[f64::NAN; D]; D]),
        };
        let mut result = vec![self.empty_sum(cell); self.space.components() * D];
        for (&node, slope) in self.space.cell_nodes(cell).iter().zip(&slopes) {
            let gradient: [f64; D] = std::array::from_fn(|j| (0..D).map(|k| slope[k] * inverse[k][j]).sum());
            for (sums, coefficient) in result.chunks_mut(D).zip(self.at_node(node as usize)) {
                for (sum, derivative) in sums.iter_mut().zip(gradient) {
                    *sum += coefficient * derivative;
                }
            }
        }
        result
    }

    fn empty_sum(&self, cell: usize) -> f64 {
        if self.space.cell_nodes(cell).is_empty() { f64::NAN } else { 0.0 }
    }

    fn find(&self, point: &[f64; D]) -> Result<(usize, [f64; D]), FieldError> {
        if let Some(region) = self.space.facet_region() {
            return Err(FieldError::OnFacets { region: region.to_owned() });
        }
        if *self.space.scope().sharing() == Scope::Point {
            return Err(FieldError::AtPoints);
        }
        let found =
            self.space.locator().find(point).filter(|(cell, _)| !self.space.cell_nodes(*cell).is_empty());
        found.ok_or_else(|| FieldError::Outside { point: point.to_vec() })
    }
}

impl<const D: usize> DiscreteField for Field<D> {
    fn components(&self) -> usize {
        self.space.components()
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}

impl<const D: usize> From<Field<D>> for FieldHandle {
    fn from(field: Field<D>) -> Self {
        Arc::new(field)
    }
}

impl<const D: usize> From<&Field<D>> for FieldHandle {
    fn from(field: &Field<D>) -> Self {
        Arc::new(field.clone())
    }
}

impl<V: FieldValue, const D: usize> Datum<V, D> for Field<D> {
    fn given(self) -> Given<V, D> {
        Given::field(self)
    }
}

impl<V: FieldValue, const D: usize> Datum<V, D> for &Field<D> {
    fn given(self) -> Given<V, D> {
        Given::field(self)
    }
}

instantiate!(
    field:
    views::<D>,
    coefficients_by_values::<D>,
    Field::<D>::zero,
    Field::<D>::from_values,
    Field::<D>::from_cell_values,
    Field::<D>::from_facet_values,
    Field::<D>::of_known,
    Field::<D>::view,
    Field::<D>::evaluate,
    Field::<D>::gradient,
    Field::<D>::evaluate_in,
    Field::<D>::gradient_in
);

#[cfg(test)]
mod tests;
