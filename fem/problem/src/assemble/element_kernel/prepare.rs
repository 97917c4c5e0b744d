//! The integrals of an element kernel, each prepared once: with loops of fixed lengths, or with those that count them.

use std::marker::PhantomData;

use forms_core::contract::{
    Backend, BilinearConstants, BilinearKernel, ExpressionKernel, Integral, LinearKernel, Requirements, Role,
};

use super::run::{Counted, Kept, run_matrices, run_vectors};

use super::tables::ElementTables;
use crate::assemble::AssemblyError;
use crate::assemble::element_kernel::fixed::{FixedIntegral, PrepareMatrices, PrepareVectors, fits};
use crate::assemble::element_kernel::sizes::Sizes;
use crate::assemble::element_loops::matrices::{along_axes, by_moments};
use crate::assemble::groups::{Group, groups};
use crate::contract::Form;
use crate::quadrature::Quadrature;

/// An integral: of one group on cells, or of one per local facet.
pub(super) enum Prepared<const D: usize> {
    /// Loops of fixed lengths, ready to be run.
    Fixed(Vec<Box<dyn FixedIntegral>>),
    /// Loops that count their lengths.
    Counted { kernel: Box<dyn ElementIntegral<D>>, groups: Vec<Group<D>>, memory: Kept },
}

/// The entry of the facet that was asked for, or of the cells.
#[inline(always)]
pub(super) fn of_facet<'a, T>(
    form: &'static str,
    groups: &'a mut [T],
    facet: usize,
) -> Result<&'a mut T, AssemblyError> {
    let place = if groups.len() == 1 { 0 } else { facet };
    groups.get_mut(place).ok_or_else(|| no_facet(form, facet))
}

#[cold]
#[inline(never)]
fn no_facet(form: &'static str, facet: usize) -> AssemblyError {
    AssemblyError::Layout { form, what: format!("there is no facet {facet}") }
}

/// Conditions for loops of fixed lengths.
pub(super) struct Lengths<K, S>(PhantomData<(K, S)>);

impl<K, S: Sizes> Lengths<K, S> {
    const fn may_be_fixed(requirements: &Requirements, components: usize) -> bool {
        S::FIXED && components <= 3 && fits(requirements)
    }

    /// Whether the loops of a matrix may have fixed lengths.
    pub const fn of_matrices<const D: usize>() -> bool
    where
        K: BilinearKernel<D>,
    {
        Self::may_be_fixed(&K::REQUIREMENTS, K::TEST_COMPONENTS)
    }

    /// Whether they do for every element: sums do not go along axes, which only loops that count do.
    pub const fn of_matrices_always<const D: usize>() -> bool
    where
        K: BilinearKernel<D>,
    {
        Self::of_matrices() && !BilinearConstants::of::<K, D>().scalar()
    }

    /// Whether the loops of a vector have fixed lengths.
    pub const fn of_vectors<const D: usize>() -> bool
    where
        K: LinearKernel<D>,
    {
        Self::may_be_fixed(&K::REQUIREMENTS, K::TEST_COMPONENTS)
    }
}

/// The backend of element kernels of some sizes.
pub(super) struct Standalone<S>(PhantomData<S>);

impl<S: Sizes, const D: usize> Backend<D> for Standalone<S> {
    type Linear = Box<dyn ElementIntegral<D>>;
    type Bilinear = Box<dyn ElementIntegral<D>>;
    type Expression = ();

    fn linear<K: LinearKernel<D>>(kernel: K) -> Self::Linear {
        Box::new(Vectors { kernel, sizes: PhantomData::<S> })
    }

    fn bilinear<K: BilinearKernel<D>>(kernel: K) -> Self::Bilinear {
        Box::new(Matrices { kernel, sizes: PhantomData::<S> })
    }

    fn expression<K: ExpressionKernel<D>>(_: K) {}
}

/// An integral whose kernel's type is behind a virtual call.
pub(super) trait ElementIntegral<const D: usize>: Send + Sync {
    /// Inputs of its kernel.
    fn requirements(&self) -> &'static Requirements;

    /// Loops of fixed lengths, one per group; none where lengths are counted.
    ///
    /// # Errors
    /// Tables of other lengths.
    fn with_fixed_lengths(
        &self,
        form: &'static str,
        tables: &ElementTables<D>,
        groups: &[Group<D>],
    ) -> Result<Option<Vec<Box<dyn FixedIntegral>>>, AssemblyError>;

    /// Runs loops that count their lengths.
    ///
    /// # Errors
    /// Errors of the form's data, or of the lengths of the lists.
    fn run(&self, call: Counted<D>) -> Result<(), AssemblyError>;
}

struct Matrices<K, S> {
    kernel: K,
    sizes: PhantomData<S>,
}

struct Vectors<K, S> {
    kernel: K,
    sizes: PhantomData<S>,
}

impl<K: BilinearKernel<D>, S: Sizes, const D: usize> ElementIntegral<D> for Matrices<K, S> {
    fn requirements(&self) -> &'static Requirements {
        const { &K::REQUIREMENTS }
    }

    fn with_fixed_lengths(
        &self,
        form: &'static str,
        tables: &ElementTables<D>,
        groups: &[Group<D>],
    ) -> Result<Option<Vec<Box<dyn FixedIntegral>>>, AssemblyError> {
        let factorised = |group: &Group<D>| {
            let (kernel, tables) = (BilinearConstants::of::<K, D>(), group.sides[0].products[0].as_ref());
            tables.is_some_and(|tables| {
                along_axes::<D>(&kernel, tables, K::SYMMETRIC)
                    && by_moments::<D>(&kernel, tables, K::SYMMETRIC).is_none()
            })
        };
        if !const { Lengths::<K, S>::of_matrices() } || groups.iter().any(factorised) {
            return Ok(None);
        }
        let (kernel, order) = (&self.kernel, &tables.orders[usize::from(K::SYMMETRIC)]);
        let prepared = groups.iter().map(|group| {
            let fixed = tables.fixed::<S>(form, group)?;
            Ok(tables.instructions.run(PrepareMatrices { kernel, group, tables: fixed, order }))
        });
        prepared.collect::<Result<_, AssemblyError>>().map(Some)
    }

    fn run(&self, call: Counted<D>) -> Result<(), AssemblyError> {
        // Loops of fixed lengths were prepared, so that this is not reached: it keeps others from being compiled.
        if const { Lengths::<K, S>::of_matrices_always() } {
            return Ok(());
        }
        run_matrices(&self.kernel, call)
    }
}

impl<K: LinearKernel<D>, S: Sizes, const D: usize> ElementIntegral<D> for Vectors<K, S> {
    fn requirements(&self) -> &'static Requirements {
        const { &K::REQUIREMENTS }
    }

    fn with_fixed_lengths(
        &self,
        form: &'static str,
        tables: &ElementTables<D>,
        groups: &[Group<D>],
    ) -> Result<Option<Vec<Box<dyn FixedIntegral>>>, AssemblyError> {
        if !const { Lengths::<K, S>::of_vectors() } {
            return Ok(None);
        }
        let (kernel, order) = (&self.kernel, &tables.orders[2]);
        let prepared = groups.iter().map(|group| {
            let fixed = tables.fixed::<S>(form, group)?;
            Ok(tables.instructions.run(PrepareVectors { kernel, tables: fixed, order }))
        });
        prepared.collect::<Result<_, AssemblyError>>().map(Some)
    }

    fn run(&self, call: Counted<D>) -> Result<(), AssemblyError> {
        // As above.
        if const { Lengths::<K, S>::of_vectors() } {
            return Ok(());
        }
        run_vectors(&self.kernel, call)
    }
}

/// An integral of a form, prepared with its groups.
///
/// # Errors
/// A region or data that do not fit, or sizes that are not those of the tables.
pub(super) fn prepare<const D: usize>(
    form: &Form<D>,
    tables: &ElementTables<D>,
    quadrature: &Quadrature<D>,
    integral: &Integral,
    kernel: Box<dyn ElementIntegral<D>>,
) -> Result<Prepared<D>, AssemblyError> {
    let binding = tables.bind(form)?;
    let degree = tables.layout.element.degree;
    let degrees: Vec<usize> = (form.fields().iter().zip(binding.degrees(&[])))
        .map(|(field, found)| match field.role {
            Role::Test(_) | Role::Unknown(_) => degree,
            _ => found,
        })
        .collect();
    let groups = groups(&binding, integral, quadrature, &degrees, kernel.requirements(), &[])?;
    Ok(match kernel.with_fixed_lengths(form.name(), tables, &groups)? {
        Some(fixed) => Prepared::Fixed(fixed),
        None => Prepared::Counted { kernel, groups, memory: None },
    })
}
