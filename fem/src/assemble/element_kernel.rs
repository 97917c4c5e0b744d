//! Element matrices and vectors of a form on cells that the caller lists, without a mesh: for those who have
//! assembly of their own, and for comparisons of kernels.

use std::any::Any;
use std::marker::PhantomData;
use std::sync::Arc;

use forms_core::contract::{
    BilinearKernel, BilinearVisitor, FieldDescription, Form, Integral, LinearKernel, LinearVisitor, Role,
};

use super::AssemblyError;
use super::batch::Cells;
use super::binding::{Binding, List, Tabulated, Values};
use super::element_matrices::{ElementMatrices, MatrixBuffers, block_order};
use super::element_vectors::{ElementVectors, VectorBuffers};
use super::fixed::{FixedMatrices, FixedTables, FixedTask, FixedVectors, Listed, fits};
use super::receiver::Direct;
use super::sizes::{Array, Counted, Sizes};
use super::walk::{Group, groups};
use crate::element::Lagrange;
use crate::lanes::{Checked, InstructionSet, LaneWork, SimdLane};
use crate::mesh::Mesh;
use crate::quadrature::Quadrature;

/// How the caller's lists of coordinates, coefficients and results are laid out. Nodes are numbered as in
/// [`Lagrange`].
#[derive(Clone, Debug)]
pub struct ElementLayout {
    /// The element of the geometry map.
    pub geometry: Lagrange,
    /// The element of the test function, and of the unknown.
    pub element: Lagrange,
    /// Coordinates of geometry node n of cell c start at `c * coordinate_stride + coordinate_offsets[n]`.
    pub coordinate_stride: usize,
    /// See there.
    pub coordinate_offsets: Vec<usize>,
    /// From the coefficients of one cell to those of the next.
    pub coefficient_stride: usize,
    /// Fields (by the names in the form) whose coefficients the caller lists. The unknown need not be there if
    /// the form is linear in it.
    pub fields: Vec<FieldLayout>,
    /// Row (and column) of component a of node n, at `n * components + a`.
    pub rows: Vec<usize>,
}

/// Coefficients of one field.
#[derive(Clone, Debug)]
pub struct FieldLayout {
    /// The field's name in the form.
    pub name: String,
    /// Its element.
    pub element: Lagrange,
    /// The coefficients of node n of cell c, one component after the other, start at
    /// `c * coefficient_stride + offsets[n]`.
    pub offsets: Vec<usize>,
}

/// Cells on which a kernel is run.
#[derive(Clone, Copy, Debug)]
pub struct ElementCells<'a> {
    /// How many.
    pub count: usize,
    /// Coordinates of their geometry nodes \[length\].
    pub coordinates: &'a [f64],
    /// Coefficients of their fields.
    pub coefficients: &'a [f64],
    /// The local facet, the same for all, of integrals over facets.
    pub facet: usize,
}

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

/// What is prepared once.
struct ElementTables<const D: usize> {
    /// The reference cell as a mesh.
    reference: Arc<Mesh<D>>,
    layout: ElementLayout,
    /// Values and elements of the form's fields, if the caller lists all of them.
    known: Option<(Vec<Values<'static, D>>, Vec<Tabulated>)>,
    /// Per integral of the tangent, and of the residual: one group on cells, one per local facet.
    tangent: Vec<Vec<Group<D>>>,
    residual: Vec<Vec<Group<D>>>,
    /// Orders of the entries of a matrix, of a symmetric one, and of a vector.
    orders: [Vec<u32>; 3],
    instructions: Checked,
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
            let (expected, found) = (field.element.nodes(), field.offsets.len());
            if expected != found {
                let field = &field.name;
                return Err(unsuited(format!("`{field}` has {expected} nodes and {found} offsets")));
            }
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
            for (k, block) in blocks.iter().enumerate() {
                let (pair, entry) = (k / (components * components), k % (components * components));
                let (i, j) = (pair / nodes, pair % nodes);
                let row = layout.rows[i * components + entry / components];
                let column = layout.rows[j * components + entry % components];
                order[row * size + column] = *block;
            }
            order
        };
        let mut vector = vec![0; size];
        for (k, row) in layout.rows.iter().enumerate() {
            vector[*row] = k as u32;
        }
        let orders = [matrix(false), matrix(true), vector];
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
        binding.tabulated(Tabulated { element: tables.layout.element, on_facets: false });
        let listed: Option<Vec<_>> = tables.listed(&form, &mut binding).into_iter().collect();
        let elements = binding.elements.to_vec();
        tables.known = listed.map(|listed| (listed, elements));
        let mut prepare = Prepare { tables: &tables, form: &form, quadrature, found: vec![] };
        form.tangent(&mut prepare)?;
        let tangent = prepare.found;
        let mut prepare = Prepare { tables: &tables, form: &form, quadrature, found: vec![] };
        form.residual(&mut prepare)?;
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
        form.tangent(&mut run)?;
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
        form.residual(&mut run)?;
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

impl<const D: usize> ElementTables<D> {
    /// Values that the caller lists, by field; `None` of those that come with the form.
    fn listed<F: Form<D>>(&self, form: &F, binding: &mut Binding<D>) -> Vec<Option<Values<'static, D>>> {
        let value = |field: &FieldDescription| {
            let listed = self.layout.fields.iter().find(|known| known.name == field.name);
            let source = !matches!(field.role, Role::Unknown(_) | Role::Test(_) | Role::Direction(_));
            match listed {
                Some(listed) => {
                    let element = Tabulated { element: listed.element, on_facets: false };
                    let element = binding.tabulated(element);
                    Some(Values::Given { element, offsets: listed.offsets.as_slice().into() })
                }
                None if source => None,
                None => Some(Values::Absent),
            }
        };
        form.fields().iter().map(value).collect()
    }

    fn bind<'a, F: Form<D>>(&'a self, form: &'a F) -> Result<Binding<'a, D>, AssemblyError> {
        let inputs = form.inputs();
        let mut binding = Binding::empty(form.name(), form.fields(), &inputs.regions, &self.reference);
        if let Some((values, elements)) = &self.known {
            (binding.values, binding.elements) = (List::Other(values), List::Other(elements));
            return Ok(binding);
        }
        // The arguments' element is the first one.
        binding.tabulated(Tabulated { element: self.layout.element, on_facets: false });
        let mut values = Vec::with_capacity(form.fields().len());
        let listed = self.listed(form, &mut binding);
        for ((field, listed), source) in form.fields().iter().zip(listed).zip(&inputs.sources) {
            values.push(match (listed, source) {
                (Some(listed), _) => listed,
                (None, Some(source)) => binding.resolve(field, source, &self.reference)?,
                (None, None) => Values::Absent,
            });
        }
        binding.values = List::Own(values);
        Ok(binding)
    }

    /// The groups' tables as arrays, whose lengths must be the groups'.
    fn fixed<S: Sizes, F: Form<D>>(
        &self,
        form: &F,
        groups: &[Vec<Group<D>>],
    ) -> Result<Vec<Vec<FixedTables<S, D>>>, AssemblyError> {
        let unsuited = |what: String| AssemblyError::Layout { form: form.name(), what };
        let Some((values, _)) = &self.known else {
            let what = "with fixed sizes the caller lists the coefficients of every field";
            return Err(unsuited(what.to_owned()));
        };
        let affine = self.reference.is_affine();
        let tables = |group: &Group<D>| {
            let side = &group.sides[0];
            for (what, found, fixed) in [
                ("nodes", side.elements[0].nodes, <S::Nodes<f64> as Array<f64>>::LENGTH),
                ("points", group.points(), <S::Points<f64> as Array<f64>>::LENGTH),
                ("geometry nodes", side.geometry.nodes, <S::GeometryNodes<f64> as Array<f64>>::LENGTH),
            ] {
                if found != fixed {
                    return Err(unsuited(format!("there are {found} {what}, and {fixed} are fixed")));
                }
            }
            Ok(FixedTables::new(group, values, affine))
        };
        groups.iter().map(|groups| groups.iter().map(tables).collect()).collect()
    }

    #[inline(always)]
    fn listed_cells<'a>(&'a self, cells: &ElementCells<'a>) -> Listed<'a> {
        Listed {
            count: cells.count,
            coordinates: cells.coordinates,
            stride: self.layout.coordinate_stride,
            offsets: &self.layout.coordinate_offsets,
            coefficients: cells.coefficients,
            coefficient_stride: self.layout.coefficient_stride,
        }
    }

    fn cells<'a>(&'a self, cells: &ElementCells<'a>) -> Cells<'a, D> {
        Cells::Given {
            coordinates: cells.coordinates,
            stride: self.layout.coordinate_stride,
            offsets: &self.layout.coordinate_offsets,
            coefficients: cells.coefficients,
            coefficient_stride: self.layout.coefficient_stride,
        }
    }
}

/// Collects the groups of each integral.
struct Prepare<'a, F, const D: usize> {
    tables: &'a ElementTables<D>,
    form: &'a F,
    quadrature: &'a Quadrature<D>,
    found: Vec<Vec<Group<D>>>,
}

impl<F: Form<D>, const D: usize> Prepare<'_, F, D> {
    fn add(
        &mut self,
        integral: &Integral,
        requirements: &forms_core::contract::Requirements,
    ) -> Result<(), AssemblyError> {
        let binding = self.tables.bind(self.form)?;
        let degree = self.tables.layout.element.degree;
        let degrees: Vec<usize> = binding.degrees(&[]).into_iter().collect();
        let degrees: Vec<usize> = (self.form.fields().iter().zip(degrees))
            .map(|(field, found)| match field.role {
                Role::Test(_) | Role::Unknown(_) => degree,
                _ => found,
            })
            .collect();
        self.found.push(groups(&binding, integral, self.quadrature, &degrees, requirements)?);
        Ok(())
    }
}

impl<F: Form<D>, const D: usize> BilinearVisitor<D> for Prepare<'_, F, D> {
    type Error = AssemblyError;

    fn visit<K: BilinearKernel<D>>(&mut self, integral: &Integral, _: &K) -> Result<(), AssemblyError> {
        self.add(integral, &K::REQUIREMENTS)
    }
}

impl<F: Form<D>, const D: usize> LinearVisitor<D> for Prepare<'_, F, D> {
    type Error = AssemblyError;

    fn visit<K: LinearKernel<D>>(&mut self, integral: &Integral, _: &K) -> Result<(), AssemblyError> {
        self.add(integral, &K::REQUIREMENTS)
    }
}

/// One call: a walk over the integrals.
struct Run<'a, F, S: Sizes, const D: usize> {
    form: &'a F,
    tables: &'a ElementTables<D>,
    /// The groups of each integral, and their tables if their sizes are fixed.
    groups: &'a [Vec<Group<D>>],
    fixed: &'a [Vec<FixedTables<S, D>>],
    /// One per integral.
    memory: &'a mut Vec<Kept>,
    addend: &'a mut Vec<f64>,
    cells: &'a ElementCells<'a>,
    target: &'a mut [f64],
    /// Number of integrals that were walked.
    index: usize,
}

#[cold]
fn no_facet(form: &'static str, facet: usize) -> AssemblyError {
    AssemblyError::Layout { form, what: format!("there is no facet {facet}") }
}

/// The entry of the facet that was asked for, or of the cells.
#[inline(always)]
fn choose<T>(groups: &[T], facet: usize) -> Option<&T> {
    if groups.len() == 1 { groups.first() } else { groups.get(facet) }
}

impl<'a, F: Form<D>, S: Sizes, const D: usize> Run<'a, F, S, D> {
    /// The group of the next integral.
    #[inline(always)]
    fn group(&self) -> Result<&'a Group<D>, AssemblyError> {
        let facet = self.cells.facet;
        choose(&self.groups[self.index], facet).ok_or_else(|| no_facet(self.form.name(), facet))
    }

    #[inline(always)]
    fn fixed(&self) -> Result<&'a FixedTables<S, D>, AssemblyError> {
        let facet = self.cells.facet;
        choose(&self.fixed[self.index], facet).ok_or_else(|| no_facet(self.form.name(), facet))
    }
}

/// Whether a kernel's loops have fixed lengths.
struct Path<K, S>(PhantomData<(K, S)>);

impl<K, S: Sizes> Path<K, S> {
    const fn fixed(requirements: &forms_core::contract::Requirements, components: usize) -> bool {
        S::FIXED && components <= 3 && fits(requirements)
    }
}

impl<F: Form<D>, S: Sizes, const D: usize> BilinearVisitor<D> for Run<'_, F, S, D> {
    type Error = AssemblyError;

    #[inline]
    fn visit<K: BilinearKernel<D>>(&mut self, _: &Integral, kernel: &K) -> Result<(), AssemblyError> {
        let (tables, add) = (self.tables, self.index > 0);
        let order = &tables.orders[usize::from(K::SYMMETRIC)];
        if const { Path::<K, S>::fixed(&K::REQUIREMENTS, K::TEST_COMPONENTS) } {
            let (group, fixed) = (self.group()?, self.fixed()?);
            tables.instructions.run(FixedMatrices {
                task: FixedTask { kernel, group, tables: fixed, listed: tables.listed_cells(self.cells) },
                order,
                memory: &mut self.memory[self.index],
                target: &mut *self.target,
                add,
            });
            self.index += 1;
            return Ok(());
        }
        let (binding, group) = (tables.bind(self.form)?, self.group()?);
        let task = ElementMatrices {
            binding: &binding,
            group,
            cells: tables.cells(self.cells),
            sides: [0, 0],
            elements: [0, 0],
            symmetric: K::SYMMETRIC,
        };
        let mut receiver = Direct { target: &mut *self.target, addend: add.then_some(&mut *self.addend) };
        let result = tables.instructions.run(Matrices::<K, D> {
            task: &task,
            kernel,
            order,
            count: self.cells.count,
            memory: &mut self.memory[self.index],
            receiver: &mut receiver,
        });
        self.index += 1;
        result
    }
}

impl<F: Form<D>, S: Sizes, const D: usize> LinearVisitor<D> for Run<'_, F, S, D> {
    type Error = AssemblyError;

    #[inline]
    fn visit<K: LinearKernel<D>>(&mut self, _: &Integral, kernel: &K) -> Result<(), AssemblyError> {
        let (tables, add) = (self.tables, self.index > 0);
        let order = &tables.orders[2];
        if const { Path::<K, S>::fixed(&K::REQUIREMENTS, K::TEST_COMPONENTS) } {
            let (group, fixed) = (self.group()?, self.fixed()?);
            tables.instructions.run(FixedVectors {
                task: FixedTask { kernel, group, tables: fixed, listed: tables.listed_cells(self.cells) },
                order,
                memory: &mut self.memory[self.index],
                target: &mut *self.target,
                add,
            });
            self.index += 1;
            return Ok(());
        }
        let (binding, group) = (tables.bind(self.form)?, self.group()?);
        let task =
            ElementVectors { binding: &binding, group, cells: tables.cells(self.cells), side: 0, element: 0 };
        let mut receiver = Direct { target: &mut *self.target, addend: add.then_some(&mut *self.addend) };
        let result = tables.instructions.run(Vectors::<K, D> {
            task: &task,
            kernel,
            order,
            count: self.cells.count,
            memory: &mut self.memory[self.index],
            receiver: &mut receiver,
        });
        self.index += 1;
        result
    }
}

struct Matrices<'a, 'r, K, const D: usize> {
    task: &'a ElementMatrices<'a, D>,
    kernel: &'a K,
    order: &'a [u32],
    count: usize,
    memory: &'a mut Kept,
    receiver: &'a mut Direct<'r>,
}

/// Memory of the loops, whose types are known inside them.
pub(super) type Kept = Option<Box<dyn Any + Send>>;

/// The memory of a run before, if it was of the same type, or new memory.
#[inline(always)]
pub(super) fn recall<T: Any + Send + Default>(memory: &mut Kept) -> &mut T {
    if !memory.as_ref().is_some_and(|known| known.is::<T>()) {
        *memory = Some(Box::new(T::default()));
    }
    match memory.as_mut().and_then(|known| known.downcast_mut::<T>()) {
        Some(known) => known,
        None => unreachable!("memory of this type was just put there"),
    }
}

impl<K: BilinearKernel<D>, const D: usize> LaneWork for Matrices<'_, '_, K, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let buffers = recall::<MatrixBuffers<K, L, D>>(self.memory);
        let range = 0..self.count;
        self.task.compute_in_lanes::<K, L>(self.kernel, self.order, range, buffers, self.receiver)
    }
}

struct Vectors<'a, 'r, K, const D: usize> {
    task: &'a ElementVectors<'a, D>,
    kernel: &'a K,
    order: &'a [u32],
    count: usize,
    memory: &'a mut Kept,
    receiver: &'a mut Direct<'r>,
}

impl<K: LinearKernel<D>, const D: usize> LaneWork for Vectors<'_, '_, K, D> {
    type Output = Result<(), AssemblyError>;

    #[inline(always)]
    fn run<L: SimdLane>(self) -> Self::Output {
        let buffers = recall::<VectorBuffers<L, D>>(self.memory);
        let range = 0..self.count;
        self.task.compute_in_lanes::<K, L>(self.kernel, Some(self.order), range, buffers, self.receiver)
    }
}
