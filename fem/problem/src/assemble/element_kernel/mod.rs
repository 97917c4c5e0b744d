//! Element matrices and vectors of a form on cells that the caller lists, without a mesh: for those who have
//! assembly of their own, and for comparisons of kernels.

pub(super) mod fixed;
mod layout;
mod prepare;
mod run;
pub(super) mod sizes;
mod tables;

use forms_core::contract::{Integrals as Compiled, Role, Term, is_on_same_points};

pub use layout::{ElementCells, ElementLayout, FieldLayout};

use self::prepare::{ElementIntegral, Prepared, Standalone, of_facet, prepare};
use self::run::Counted as CountedCall;
use self::sizes::{Counted, Sizes};
use self::tables::ElementTables;
use super::AssemblyError;
use super::binding::notices;
use super::binding::{Binding, Tabulated};
use super::element_loops::matrices::block_order;
use super::element_loops::sink::Direct;
use crate::contract::Form;
use crate::element::CellShape;
use crate::lanes::{InstructionSet, Order};
use crate::mesh::Mesh;
use crate::mesh::determinant::{JacobianDeterminant, Sign};
use crate::quadrature::Quadrature;

/// A form's element matrices and vectors on cells that the caller lists.
///
/// The form's cell integrals must be bound to the region "all", its facet integrals to "boundary". With
/// [`super::Fixed`] sizes the loops are compiled for one element and rule. The type `f::Kernels` of a form `f` says which
/// kernels to compile:
///
/// ```no_run
/// # use forms_fem::assemble::{AssemblyError, ElementKernel, ElementLayout};
/// # use forms_fem::prelude::*;
/// # #[forms(dimension = 2)]
/// # mod heat {
/// #     #[cells]
/// #     pub struct Omega;
/// #     pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form { integral(Omega, dot(grad(u), grad(v))) }
/// # }
/// # fn kernel(layout: ElementLayout) -> Result<(), AssemblyError> {
/// let form = heat::balance(&heat::Omega::on("all"));
/// let kernel = ElementKernel::<2>::new::<heat::balance::Kernels>(&form, layout, &Quadrature::Estimated)?;
/// # Ok(())
/// # }
/// ```
pub struct ElementKernel<const D: usize> {
    form: Form<D>,
    tables: ElementTables<D>,
    tangent: Integrals<D>,
    residual: Integrals<D>,
}

/// The integrals of a tangent or of a residual.
struct Integrals<const D: usize> {
    list: Vec<Prepared<D>>,
    /// None of them counts its lengths: known beforehand, because it decides at each call.
    all_fixed: bool,
    /// Room for results before they are added.
    addend: Vec<f64>,
}

impl<const D: usize> Integrals<D> {
    fn new(list: Vec<Prepared<D>>) -> Self {
        let all_fixed = list.iter().all(|integral| matches!(integral, Prepared::Fixed(_)));
        Integrals { list, all_fixed, addend: vec![] }
    }
}

impl<const D: usize> ElementKernel<D> {
    /// A kernel whose loops count their lengths.
    ///
    /// # Errors
    /// As [`ElementKernel::with_sizes`].
    pub fn new<I: Compiled<D>>(
        form: &Form<D>,
        layout: ElementLayout,
        quadrature: &Quadrature<D>,
    ) -> Result<Self, AssemblyError> {
        Self::with_sizes::<I, Counted>(form, layout, quadrature)
    }

    /// The kernel of a form of one test function and one unknown.
    ///
    /// # Errors
    /// An [`AssemblyError`] that names the form and what does not fit: a region, a field, a size.
    pub fn with_sizes<I: Compiled<D>, S: Sizes>(
        form: &Form<D>,
        layout: ElementLayout,
        quadrature: &Quadrature<D>,
    ) -> Result<Self, AssemblyError> {
        Self::with_instructions::<I, S>(form, layout, quadrature, InstructionSet::best())
    }

    /// An element kernel in a certain set of instructions; of the best that is available where that one is not.
    ///
    /// # Errors
    /// As [`ElementKernel::with_sizes`].
    pub fn with_instructions<I: Compiled<D>, S: Sizes>(
        form: &Form<D>,
        layout: ElementLayout,
        quadrature: &Quadrature<D>,
        instructions: InstructionSet,
    ) -> Result<Self, AssemblyError> {
        let name = form.name();
        let unsuited = |what: String| AssemblyError::Layout { form: name, what };
        if !form.has_integrals::<I>() {
            return Err(unsuited("the kernels are those of another form, or of a part of a sum".to_owned()));
        }
        let tests = form.fields().iter().filter(|field| matches!(field.role, Role::Test(_)));
        let components: Vec<usize> = tests.map(|field| field.components()).collect();
        let &[components] = &components[..] else {
            return Err(unsuited(format!("the form has {} test functions, not one", components.len())));
        };
        for field in &layout.fields {
            let known = form.fields().iter().find(|known| known.name == field.name);
            if known.is_none() {
                return Err(unsuited(format!("the form has no field `{}`", field.name)));
            }
            if field.element.shape != layout.geometry.shape {
                let [own, cells] = [field.element.shape, layout.geometry.shape].map(CellShape::name);
                return Err(unsuited(format!("`{}` has the element of a {own} on a {cells}", field.name)));
            }
            let (expected, found) = (field.element.nodes(), field.offsets.len());
            if expected != found {
                let field = &field.name;
                return Err(unsuited(format!("`{field}` has {expected} nodes and {found} offsets")));
            }
        }
        if layout.element.shape != layout.geometry.shape {
            let [own, cells] = [layout.element.shape, layout.geometry.shape].map(CellShape::name);
            return Err(unsuited(format!("the test function has the element of a {own} on a {cells}")));
        }
        let nodes = layout.element.nodes();
        for (what, expected, found) in [
            ("offsets of coordinates", layout.geometry.nodes(), layout.coordinate_offsets.len()),
            ("rows", nodes * components, layout.rows.len()),
        ] {
            if expected != found {
                return Err(unsuited(format!("there should be {expected} {what}, not {found}")));
            }
        }
        let size = nodes * components;
        if let Some(row) = layout.rows.iter().find(|row| **row >= size) {
            return Err(unsuited(format!("row {row} of {size}")));
        }
        let points = layout.geometry.node_points::<D>();
        let cells = (0..points.len() as u32).collect();
        let reference = Mesh::from_parts(layout.geometry.shape, layout.geometry.degree, points, cells);
        let reference = reference.map_err(|source| unsuited(source.to_string()))?;
        let lanes = instructions.checked().width();
        let matrix = |symmetric| {
            let blocks = block_order([nodes, nodes], [components, components], symmetric);
            let mut order = vec![0; size * size];
            for (k, block) in blocks.into_iter().enumerate() {
                let (pair, entry) = (k / (components * components), k % (components * components));
                let (i, j) = (pair / nodes, pair % nodes);
                let row = layout.rows[i * components + entry / components];
                let column = layout.rows[j * components + entry % components];
                order[row * size + column] = block;
            }
            Order::new(order, lanes)
        };
        let mut vector = vec![0; size];
        for (k, row) in layout.rows.iter().enumerate() {
            vector[*row] = k as u32;
        }
        let orders = [matrix(false), matrix(true), Order::new(vector, lanes)];
        let mut tables =
            ElementTables { reference, layout, known: None, orders, instructions: instructions.checked() };
        notices::check_instructions(name, InstructionSet::best())?;
        notices::tell(name, form.inputs());
        let mut binding = Binding::empty(name, form.fields(), &form.inputs().regions, &tables.reference);
        binding.tabulated(Tabulated::lagrange(tables.layout.element));
        let listed: Option<Vec<_>> = tables.listed(form, &mut binding).into_iter().collect();
        let elements = binding.elements.to_vec();
        tables.known = listed.map(|listed| (listed, elements));
        let constants = form.inputs().constants();
        let joined = I::joined_residual::<Standalone<S>>(constants);
        let places: Vec<_> = joined.iter().map(|term| term.integral).collect();
        let is_apart = |term: &Term<_>| !places.iter().any(|place| is_on_same_points(place, term.integral));
        let residual = joined.into_iter().chain(apart(I::residual::<Standalone<S>>(constants), is_apart));
        let prepared = |terms: &mut dyn Iterator<Item = Term<Box<dyn ElementIntegral<D>>>>| {
            let one = |Term { integral, kernel }| prepare(form, &tables, quadrature, integral, kernel);
            terms.map(one).collect::<Result<Vec<_>, AssemblyError>>().map(Integrals::new)
        };
        let residual = prepared(&mut residual.collect::<Vec<_>>().into_iter())?;
        let tangent: Vec<_> = match places.is_empty() {
            true => I::tangent::<Standalone<S>>(constants),
            false => {
                let joined = I::joined_tangent::<Standalone<S>>(constants);
                joined.into_iter().chain(apart(I::tangent::<Standalone<S>>(constants), is_apart)).collect()
            }
        };
        let tangent = prepared(&mut tangent.into_iter())?;
        Ok(ElementKernel { form: form.clone(), tables, tangent, residual })
    }

    /// The form.
    pub fn form(&self) -> &Form<D> {
        &self.form
    }

    /// Number of rows of an element matrix, or length of an element vector.
    pub fn size(&self) -> usize {
        self.tables.layout.rows.len()
    }

    /// The check that the Jacobian determinants of listed cells are positive everywhere in them. The kernels take the caller's cells as
    /// they are: to look at each again would cost as much as a small kernel itself.
    ///
    /// # Errors
    /// [`AssemblyError::Weight`], which names the cell; [`AssemblyError::Layout`] where the list of coordinates is too short.
    pub fn check_cells(&self, cells: &ElementCells) -> Result<(), AssemblyError> {
        let ElementLayout { geometry, coordinate_stride, coordinate_offsets, .. } = &self.tables.layout;
        let form = self.form.name();
        let tested = JacobianDeterminant::<D>::new(geometry);
        let numbers: Vec<u32> = (0..geometry.nodes() as u32).collect();
        for cell in 0..cells.count {
            let node = |offset: &usize| -> Option<[f64; D]> {
                let own = cells.coordinates.get(cell * coordinate_stride + offset..)?.get(..D)?;
                Some(std::array::from_fn(|k| own[k]))
            };
            let nodes: Option<Vec<[f64; D]>> = coordinate_offsets.iter().map(node).collect();
            let what = || format!("the list of coordinates ends before cell {cell} of {}", cells.count);
            let nodes = nodes.ok_or_else(|| AssemblyError::Layout { form, what: what() })?;
            let (reference, determinant) = match tested.sign(&numbers, &nodes) {
                Sign::Positive => continue,
                Sign::Folded { reference, determinant } => (reference, determinant),
                Sign::Undecided { reference, bound } => (reference, bound),
            };
            let values = geometry.tabulate(&[reference]).value;
            let at = |k: usize| values.iter().zip(&nodes).map(|(value, x)| value * x[k]).sum();
            let (place, position) = ("the caller's cells".to_owned(), (0..D).map(at).collect());
            return Err(AssemblyError::Weight { form, place, cell, determinant, position });
        }
        Ok(())
    }

    /// Element matrices of the tangent, one after the other, row-major.
    ///
    /// # Errors
    /// Errors of the form's data, or of the lengths of the lists.
    #[inline]
    pub fn matrices(&mut self, cells: &ElementCells, matrices: &mut [f64]) -> Result<(), AssemblyError> {
        let size = self.size();
        let form = self.form.name();
        let target = target(form, matrices, cells.count * size * size)?;
        if self.tangent.all_fixed {
            return run_fixed(form, &mut self.tangent.list, cells, target);
        }
        run_all((&self.form, &self.tables), &mut self.tangent, cells, target)
    }

    /// Element vectors of the residual, one after the other.
    ///
    /// # Errors
    /// As [`ElementKernel::matrices`].
    #[inline]
    pub fn vectors(&mut self, cells: &ElementCells, vectors: &mut [f64]) -> Result<(), AssemblyError> {
        let form = self.form.name();
        let target = target(form, vectors, cells.count * self.size())?;
        if self.residual.all_fixed {
            return run_fixed(form, &mut self.residual.list, cells, target);
        }
        run_all((&self.form, &self.tables), &mut self.residual, cells, target)
    }
}

/// The terms for which a condition holds.
fn apart<K>(terms: Vec<Term<K>>, is_apart: impl Fn(&Term<K>) -> bool) -> impl Iterator<Item = Term<K>> {
    terms.into_iter().filter(move |term| is_apart(term))
}

/// Runs integrals, with fixed lengths and without.
#[inline(never)]
fn run_all<const D: usize>(
    (form, tables): (&Form<D>, &ElementTables<D>),
    integrals: &mut Integrals<D>,
    cells: &ElementCells,
    target: &mut [f64],
) -> Result<(), AssemblyError> {
    let Integrals { list, addend, .. } = integrals;
    for (index, integral) in list.iter_mut().enumerate() {
        match integral {
            Prepared::Fixed(groups) => {
                of_facet(form.name(), groups, cells.facet)?.run(cells, target, index > 0);
            }
            Prepared::Counted { kernel, groups, memory } => {
                let group = of_facet(form.name(), groups, cells.facet)?;
                let sink = Direct { target: &mut *target, addend: (index > 0).then_some(&mut *addend) };
                kernel.run(CountedCall { form, tables, group, cells, memory, sink })?;
            }
        }
    }
    Ok(())
}

/// Runs integrals that all have fixed lengths.
#[inline(always)]
fn run_fixed<const D: usize>(
    form: &'static str,
    integrals: &mut [Prepared<D>],
    cells: &ElementCells,
    target: &mut [f64],
) -> Result<(), AssemblyError> {
    // Mostly there is one.
    if let [Prepared::Fixed(groups)] = integrals {
        of_facet(form, groups, cells.facet)?.run(cells, target, false);
        return Ok(());
    }
    if integrals.is_empty() {
        target.fill(0.0);
    }
    for (index, integral) in integrals.iter_mut().enumerate() {
        if let Prepared::Fixed(groups) = integral {
            of_facet(form, groups, cells.facet)?.run(cells, target, index > 0);
        }
    }
    Ok(())
}

#[inline(always)]
fn target<'a>(
    form: &'static str,
    values: &'a mut [f64],
    expected: usize,
) -> Result<&'a mut [f64], AssemblyError> {
    let found = values.len();
    values.get_mut(..expected).ok_or_else(|| too_short(form, found, expected))
}

#[cold]
#[inline(never)]
fn too_short(form: &'static str, found: usize, expected: usize) -> AssemblyError {
    AssemblyError::Layout {
        form,
        what: format!("the results have room for {found} numbers, not for {expected}"),
    }
}

#[cfg(test)]
mod tests;
