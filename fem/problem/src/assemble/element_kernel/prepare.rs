//! The integrals of an element kernel, each prepared once: with loops of fixed lengths, or with those that count them.

use std::any::Any;
use std::marker::PhantomData;

use forms_core::contract::{
    BilinearKernel, BilinearVisitor, Form, Integral, LinearKernel, LinearVisitor, Requirements, Role,
};

use super::tables::ElementTables;
use crate::assemble::AssemblyError;
use crate::assemble::element_kernel::fixed::{FixedIntegral, PrepareMatrices, PrepareVectors, fits};
use crate::assemble::element_kernel::sizes::Sizes;
use crate::assemble::kernel_calls::BilinearConstants;
use crate::assemble::kernel_calls::matrices::{along_axes, by_moments};
use crate::assemble::walk::{Group, groups};
use crate::quadrature::Quadrature;

/// Memory of the loops, whose types are known inside them.
pub(super) type Kept = Option<Box<dyn Any + Send>>;

/// An integral: of one group on cells, or of one per local facet.
pub(super) enum Prepared<const D: usize> {
    /// Loops of fixed lengths, ready to be run.
    Fixed(Vec<Box<dyn FixedIntegral>>),
    /// Loops that count their lengths, which run when the form hands over the kernel.
    Counted { groups: Vec<Group<D>>, memory: Kept },
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

/// Prepares each integral of a form.
pub(super) struct Prepare<'a, F, S, const D: usize> {
    pub tables: &'a ElementTables<D>,
    pub form: &'a F,
    pub quadrature: &'a Quadrature<D>,
    pub found: Vec<Prepared<D>>,
    pub sizes: PhantomData<S>,
}

impl<F: Form<D>, S: Sizes, const D: usize> Prepare<'_, F, S, D> {
    fn groups(
        &self,
        integral: &Integral,
        requirements: &Requirements,
    ) -> Result<Vec<Group<D>>, AssemblyError> {
        let binding = self.tables.bind(self.form)?;
        let degree = self.tables.layout.element.degree;
        let degrees: Vec<usize> = binding.degrees(&[]).into_iter().collect();
        let degrees: Vec<usize> = (self.form.fields().iter().zip(degrees))
            .map(|(field, found)| match field.role {
                Role::Test(_) | Role::Unknown(_) => degree,
                _ => found,
            })
            .collect();
        groups(&binding, integral, self.quadrature, &degrees, requirements)
    }
}

impl<F: Form<D>, S: Sizes, const D: usize> BilinearVisitor<D> for Prepare<'_, F, S, D> {
    type Error = AssemblyError;

    fn visit<K: BilinearKernel<D>>(&mut self, integral: &Integral, kernel: &K) -> Result<(), AssemblyError> {
        let (tables, groups) = (self.tables, self.groups(integral, &K::REQUIREMENTS)?);
        let factorised = |group: &Group<D>| {
            let (kernel, tables) = (BilinearConstants::of::<K, D>(), group.sides[0].products[0].as_ref());
            tables.is_some_and(|tables| {
                along_axes::<D>(&kernel, tables, K::SYMMETRIC)
                    && by_moments::<D>(&kernel, tables, K::SYMMETRIC).is_none()
            })
        };
        if const { Lengths::<K, S>::of_matrices() } && !groups.iter().any(factorised) {
            let order = &tables.orders[usize::from(K::SYMMETRIC)];
            let prepared = groups.iter().map(|group| {
                let tables = tables.fixed::<S>(self.form.name(), group)?;
                let work = PrepareMatrices { kernel, group, tables, order };
                Ok(self.tables.instructions.run(work))
            });
            self.found.push(Prepared::Fixed(prepared.collect::<Result<_, AssemblyError>>()?));
        } else {
            self.found.push(Prepared::Counted { groups, memory: None });
        }
        Ok(())
    }
}

impl<F: Form<D>, S: Sizes, const D: usize> LinearVisitor<D> for Prepare<'_, F, S, D> {
    type Error = AssemblyError;

    fn visit<K: LinearKernel<D>>(&mut self, integral: &Integral, kernel: &K) -> Result<(), AssemblyError> {
        let (tables, groups) = (self.tables, self.groups(integral, &K::REQUIREMENTS)?);
        if const { Lengths::<K, S>::of_vectors() } {
            let prepared = groups.iter().map(|group| {
                let fixed = tables.fixed::<S>(self.form.name(), group)?;
                let work = PrepareVectors { kernel, tables: fixed, order: &tables.orders[2] };
                Ok(tables.instructions.run(work))
            });
            self.found.push(Prepared::Fixed(prepared.collect::<Result<_, AssemblyError>>()?));
        } else {
            self.found.push(Prepared::Counted { groups, memory: None });
        }
        Ok(())
    }
}
