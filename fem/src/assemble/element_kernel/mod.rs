//! Element matrices and vectors of a form on cells that the caller lists, without a mesh: for those who have
//! assembly of their own, and for comparisons of kernels.

mod layout;
mod run;
mod tables;

use std::sync::Arc;

use forms_core::contract::{Form, Role};

pub use layout::{ElementCells, ElementLayout, FieldLayout};
pub(super) use run::{Kept, recall};

use self::run::Run;
use self::tables::{ElementTables, Prepare};
use super::AssemblyError;
use super::binding::{Binding, Tabulated};
use super::element_matrices::block_order;
use super::fixed::FixedTables;
use super::sizes::{Counted, Sizes};
use super::walk::Group;
use crate::element::CellShape;
use crate::lanes::{InstructionSet, Order};
use crate::mesh::Mesh;
use crate::quadrature::Quadrature;

/// A form's element matrices and vectors on cells that the caller lists.
///
/// The form's cell integrals must be bound to the region "all", its facet integrals to "boundary". With
/// [`super::Fixed`] sizes the loops are compiled for one element and rule.
pub struct ElementKernel<F, S: Sizes, const D: usize> {
    form: F,
    tables: ElementTables<D>,
    /// The tables of each integral's groups, if sizes are fixed.
    fixed_tangent: Vec<Vec<FixedTables<S, D>>>,
    fixed_residual: Vec<Vec<FixedTables<S, D>>>,
    memory: Memory,
}

/// Memory of the loops, whose types are known inside them.
#[derive(Default)]
struct Memory {
    tangent: Vec<Kept>,
    residual: Vec<Kept>,
    addend: Vec<f64>,
}

impl<F: Form<D>, const D: usize> ElementKernel<F, Counted, D> {
    /// A kernel whose loops count their lengths.
    ///
    /// # Errors
    /// As [`ElementKernel::with_sizes`].
    pub fn new(form: F, layout: ElementLayout, quadrature: &Quadrature<D>) -> Result<Self, AssemblyError> {
        Self::with_sizes(form, layout, quadrature)
    }
}

impl<F: Form<D>, S: Sizes, const D: usize> ElementKernel<F, S, D> {
    /// Prepares a form of one test function and one unknown.
    ///
    /// # Errors
    /// An [`AssemblyError`] that names the form and what does not fit: a region, a field, a size.
    pub fn with_sizes(
        form: F,
        layout: ElementLayout,
        quadrature: &Quadrature<D>,
    ) -> Result<Self, AssemblyError> {
        let name = form.name();
        let unsuited = |what: String| AssemblyError::Layout { form: name, what };
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
        let matrix = |symmetric| {
            let blocks = block_order([nodes, nodes], [components, components], symmetric);
            let mut order = vec![0; size * size];
            for (k, block) in blocks.places().enumerate() {
                let (pair, entry) = (k / (components * components), k % (components * components));
                let (i, j) = (pair / nodes, pair % nodes);
                let row = layout.rows[i * components + entry / components];
                let column = layout.rows[j * components + entry % components];
                order[row * size + column] = block;
            }
            Order::new(order)
        };
        let mut vector = vec![0; size];
        for (k, row) in layout.rows.iter().enumerate() {
            vector[*row] = k as u32;
        }
        let orders = [matrix(false), matrix(true), Order::new(vector)];
        let mut tables = ElementTables {
            reference: Arc::new(reference),
            layout,
            known: None,
            tangent: vec![],
            residual: vec![],
            orders,
            instructions: InstructionSet::best().checked(),
        };
        let mut binding = Binding::empty(name, form.fields(), &form.inputs().regions, &tables.reference);
        binding.tabulated(Tabulated { degree: tables.layout.element.degree, on_facets: false });
        let listed: Option<Vec<_>> = tables.listed(&form, &mut binding).into_iter().collect();
        let elements = binding.elements.to_vec();
        tables.known = listed.map(|listed| (listed, elements));
        let mut prepare = Prepare { tables: &tables, form: &form, quadrature, found: vec![] };
        form.whole_tangent(&mut prepare)?;
        let tangent = prepare.found;
        let mut prepare = Prepare { tables: &tables, form: &form, quadrature, found: vec![] };
        form.whole_residual(&mut prepare)?;
        let residual = prepare.found;
        (tables.tangent, tables.residual) = (tangent, residual);
        let (fixed_tangent, fixed_residual) = if S::FIXED {
            (tables.fixed(&form, &tables.tangent)?, tables.fixed(&form, &tables.residual)?)
        } else {
            (vec![], vec![])
        };
        let memory = |groups: &[Vec<Group<D>>]| groups.iter().map(|_| None).collect();
        let memory =
            Memory { tangent: memory(&tables.tangent), residual: memory(&tables.residual), addend: vec![] };
        Ok(ElementKernel { form, tables, fixed_tangent, fixed_residual, memory })
    }

    /// The same with kernels compiled for a certain set of instructions.
    pub fn with_instructions(mut self, instructions: InstructionSet) -> Self {
        self.tables.instructions = instructions.checked();
        self
    }

    /// The form.
    pub fn form(&self) -> &F {
        &self.form
    }

    /// Number of rows of an element matrix, or length of an element vector.
    pub fn size(&self) -> usize {
        self.tables.layout.rows.len()
    }

    /// Element matrices of the tangent, one after the other, row-major.
    ///
    /// # Errors
    /// What the form's data have to say, or the lengths of the lists.
    #[inline]
    pub fn matrices(&mut self, cells: &ElementCells, matrices: &mut [f64]) -> Result<(), AssemblyError> {
        let ElementKernel { form, tables, fixed_tangent, memory, .. } = self;
        let size = tables.layout.rows.len();
        let mut run = Run::<F, S, D> {
            form,
            tables,
            groups: &tables.tangent,
            fixed: fixed_tangent,
            memory: &mut memory.tangent,
            addend: &mut memory.addend,
            cells,
            target: target(form.name(), matrices, cells.count * size * size)?,
            index: 0,
        };
        form.whole_tangent(&mut run)?;
        if run.index == 0 {
            run.target.fill(0.0);
        }
        Ok(())
    }

    /// Element vectors of the residual, one after the other.
    ///
    /// # Errors
    /// As [`ElementKernel::matrices`].
    #[inline]
    pub fn vectors(&mut self, cells: &ElementCells, vectors: &mut [f64]) -> Result<(), AssemblyError> {
        let ElementKernel { form, tables, fixed_residual, memory, .. } = self;
        let mut run = Run::<F, S, D> {
            form,
            tables,
            groups: &tables.residual,
            fixed: fixed_residual,
            memory: &mut memory.residual,
            addend: &mut memory.addend,
            cells,
            target: target(form.name(), vectors, cells.count * tables.layout.rows.len())?,
            index: 0,
        };
        form.whole_residual(&mut run)?;
        if run.index == 0 {
            run.target.fill(0.0);
        }
        Ok(())
    }
}

#[inline(always)]
fn target<'a>(
    form: &'static str,
    values: &'a mut [f64],
    expected: usize,
) -> Result<&'a mut [f64], AssemblyError> {
    let found = values.len();
    values.get_mut(..expected).ok_or_else(|| AssemblyError::Layout {
        form,
        what: format!("the results have room for {found} numbers, not for {expected}"),
    })
}
