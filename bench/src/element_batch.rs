//! Element matrices and vectors of a batch of cells in the layouts of FFCx: prepared once per kernel and thread.

use forms_fem::assemble::{AssemblyError, ElementCells, ElementKernel, ElementLayout, FieldLayout, Sizes};
use forms_fem::contract::Form;
use forms_fem::element::{CellShape, Lagrange};
use thiserror::Error;

use crate::basix::{Entities, NodeOrder, RuleError, node_count, our_node_numbers, quadrature};
use crate::forms::given::WithIntegrals;

/// Whether a kernel is that of a residual or of its tangent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Output {
    /// Element vectors.
    Residual,
    /// Element matrices.
    Tangent,
}

/// The elements and the rule of a kernel.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Vector or matrix.
    pub output: Output,
    /// Cells or facets.
    pub entities: Entities,
    /// The cell.
    pub shape: CellShape,
    /// Degree of the unknown's element.
    pub degree: usize,
    /// Degree of the geometry map.
    pub geometry: usize,
    /// Degree of basix's default quadrature rule.
    pub rule: usize,
    /// Fields whose coefficients the kernel reads, by their names in the form, with the degrees of their elements.
    pub fields: &'static [(&'static str, usize)],
    /// Basix's node order, of geometry and unknown alike.
    pub order: NodeOrder,
}

/// Errors of running a kernel.
#[derive(Debug, Error)]
pub enum BatchError {
    /// No such rule.
    #[error(transparent)]
    Rule(#[from] RuleError),
    /// Errors of the form or its data.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
}

impl Setting {
    /// Starts of each field's coefficients in a cell's list, and the length of that list.
    pub fn coefficients<const D: usize>(&self, form: &Form<D>) -> (Vec<usize>, usize) {
        let mut starts = Vec::new();
        let mut start = 0;
        for (name, degree) in self.fields {
            starts.push(start);
            start += node_count(self.shape, *degree) * components_of(form, name);
        }
        (starts, start)
    }

    /// FFCx's layout of coordinates, coefficients and matrices.
    fn layout<const D: usize>(&self, form: &Form<D>) -> ElementLayout {
        let Setting { shape, degree, geometry, order, .. } = *self;
        // Entry `ours` is at the position of `theirs`.
        let places = |degree: usize, start: usize, stride: usize| {
            let mut places = vec![0; node_count(shape, degree)];
            for (theirs, ours) in our_node_numbers(shape, degree, order).into_iter().enumerate() {
                places[ours] = start + stride * theirs;
            }
            places
        };
        let components = test_components(form);
        let (starts, coefficient_stride) = self.coefficients(form);
        let fields = self.fields.iter().zip(starts).map(|((name, degree), start)| FieldLayout {
            name: (*name).to_owned(),
            element: Lagrange { shape, degree: *degree },
            offsets: places(*degree, start, components_of(form, name)),
        });
        let rows = places(degree, 0, components);
        ElementLayout {
            geometry: Lagrange { shape, degree: geometry },
            element: Lagrange { shape, degree },
            coordinate_stride: 3 * node_count(shape, geometry),
            coordinate_offsets: places(geometry, 0, 3),
            coefficient_stride,
            fields: fields.collect(),
            rows: rows.iter().flat_map(|row| (0..components).map(move |a| row + a)).collect(),
        }
    }
}

fn components_of<const D: usize>(form: &Form<D>, name: &str) -> usize {
    form.fields().iter().find(|field| field.name == name).map_or(0, |field| field.components())
}

/// Components of a form's test function.
pub fn test_components<const D: usize>(form: &Form<D>) -> usize {
    let is_test = |role| matches!(role, forms_fem::contract::Role::Test(_));
    form.fields().iter().find(|field| is_test(field.role)).map_or(0, |field| field.components())
}

/// A kernel of any form, element and rule, ready to run.
pub trait Batch {
    /// Computes element matrices or vectors, one after the other; `cells.facet` is our number.
    ///
    /// # Errors
    /// Errors of the form or its data.
    fn run(&mut self, cells: &ElementCells, results: &mut [f64]) -> Result<(), AssemblyError>;
}

struct Prepared<const D: usize> {
    kernel: ElementKernel<D>,
    output: Output,
}

impl<const D: usize> Batch for Prepared<D> {
    #[inline]
    fn run(&mut self, cells: &ElementCells, results: &mut [f64]) -> Result<(), AssemblyError> {
        match self.output {
            Output::Tangent => self.kernel.matrices(cells, results),
            Output::Residual => self.kernel.vectors(cells, results),
        }
    }
}

/// Prepares a form for a setting, with the integrals of its type.
///
/// # Errors
/// No such rule, or a form that does not fit.
pub fn prepare<T: WithIntegrals<D>, S: Sizes, const D: usize>(
    setting: &Setting,
    typed: &T,
) -> Result<Box<dyn Batch>, BatchError> {
    let form = typed.form();
    let layout = setting.layout(form);
    let rule = quadrature(setting.shape, setting.rule)?;
    let kernel = ElementKernel::with_sizes::<T::Integrals, S>(form, layout, &rule)?;
    Ok(Box::new(Prepared { kernel, output: setting.output }))
}
