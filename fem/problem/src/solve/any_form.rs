//! Type-erased forms: a problem is compiled once, in this crate, and a user's form adds only its kernels.

use std::convert::Infallible;
use std::ops::Deref;
use std::sync::Arc;

use forms_core::contract::{
    Dependence, FieldDescription, Form, Inputs, Integral, LinearKernel, LinearVisitor, Role,
};

use crate::assemble::{Assembler, AssemblyError, BlockPattern, FoundPairs, Outline, Parts, Terms};
use crate::field::FieldView;
use crate::linear_algebra::BlockMatrix;
use crate::space::Space;

/// The form of a problem, without its type.
pub trait AnyForm<const D: usize> {
    /// See [`Form::name`].
    fn name(&self) -> &'static str;
    /// See [`Form::fields`].
    fn fields(&self) -> &'static [FieldDescription];
    /// See [`Form::inputs`].
    fn inputs(&self) -> &Inputs<D>;
    /// The form without its kernels.
    fn outline(&self, parts: Parts) -> Outline<'_, D>;
    /// Whether no integral is nonlinear in the unknowns.
    fn is_affine(&self) -> bool;
    /// Whether there are pairs of surfaces that an unknown displaces.
    fn slides(&self) -> bool;
    /// Whether there are pairs of surfaces that any field displaces.
    fn is_on_displaced_surfaces(&self) -> bool;
    /// See `Assembler::pairs_of_form`.
    fn pairs(
        &self,
        assembler: &Assembler<D>,
        unknowns: &[FieldView<D>],
        tests: &[&Arc<Space<D>>],
    ) -> Result<Vec<FoundPairs<D>>, AssemblyError>;
    /// See `Assembler::residual_of`.
    fn residual(
        &self,
        assembler: &Assembler<D>,
        unknowns: &[FieldView<D>],
        tests: &[&Arc<Space<D>>],
        parts: Parts,
    ) -> Result<Vec<f64>, AssemblyError>;
    /// See `Assembler::load`.
    fn load(&self, assembler: &Assembler<D>, tests: &[&Arc<Space<D>>]) -> Result<Vec<f64>, AssemblyError>;
    /// See `Assembler::residual_without`.
    fn residual_without(
        &self,
        assembler: &Assembler<D>,
        tests: &[&Arc<Space<D>>],
        left_out: &[usize],
    ) -> Result<Vec<f64>, AssemblyError>;
    /// See `Assembler::sizes_of_contributions`.
    fn sizes_of_contributions(
        &self,
        assembler: &Assembler<D>,
        unknowns: &[FieldView<D>],
        tests: &[&Arc<Space<D>>],
        terms: Terms,
    ) -> Result<Vec<f64>, AssemblyError>;
    /// See `Assembler::active_set_of`.
    fn active_set(
        &self,
        assembler: &Assembler<D>,
        unknowns: &[FieldView<D>],
    ) -> Result<Option<Vec<u32>>, AssemblyError>;
    /// See `Assembler::add_tangent`.
    fn add_tangent(
        &self,
        assembler: &Assembler<D>,
        arguments: (&[FieldView<D>], &[&Arc<Space<D>>]),
        parts: Parts,
        pattern: &BlockPattern<D>,
        matrix: &mut BlockMatrix,
    ) -> Result<(), AssemblyError>;
    /// See `Assembler::assemble_tangent`.
    fn assemble_tangent(
        &self,
        assembler: &Assembler<D>,
        arguments: (&[FieldView<D>], &[&Arc<Space<D>>]),
        parts: Parts,
        pattern: &BlockPattern<D>,
        matrix: &mut BlockMatrix,
    ) -> Result<(), AssemblyError>;
}

impl<F: Form<D>, const D: usize> AnyForm<D> for F {
    fn name(&self) -> &'static str {
        Form::name(self)
    }

    fn fields(&self) -> &'static [FieldDescription] {
        Form::fields(self)
    }

    fn inputs(&self) -> &Inputs<D> {
        Form::inputs(self)
    }

    fn outline(&self, parts: Parts) -> Outline<'_, D> {
        Outline::of(self, parts)
    }

    fn is_affine(&self) -> bool {
        !seen_in(self).nonlinear
    }

    fn slides(&self) -> bool {
        seen_in(self).slides
    }

    fn is_on_displaced_surfaces(&self) -> bool {
        seen_in(self).displaced
    }

    fn pairs(
        &self,
        assembler: &Assembler<D>,
        unknowns: &[FieldView<D>],
        tests: &[&Arc<Space<D>>],
    ) -> Result<Vec<FoundPairs<D>>, AssemblyError> {
        assembler.pairs_of_form(self, unknowns, tests)
    }

    fn residual(
        &self,
        assembler: &Assembler<D>,
        unknowns: &[FieldView<D>],
        tests: &[&Arc<Space<D>>],
        parts: Parts,
    ) -> Result<Vec<f64>, AssemblyError> {
        assembler.residual_of(self, unknowns, tests, parts)
    }

    fn load(&self, assembler: &Assembler<D>, tests: &[&Arc<Space<D>>]) -> Result<Vec<f64>, AssemblyError> {
        assembler.load(self, tests)
    }

    fn residual_without(
        &self,
        assembler: &Assembler<D>,
        tests: &[&Arc<Space<D>>],
        left_out: &[usize],
    ) -> Result<Vec<f64>, AssemblyError> {
        assembler.residual_without(self, tests, left_out)
    }

    fn sizes_of_contributions(
        &self,
        assembler: &Assembler<D>,
        unknowns: &[FieldView<D>],
        tests: &[&Arc<Space<D>>],
        terms: Terms,
    ) -> Result<Vec<f64>, AssemblyError> {
        assembler.sizes_of_contributions(self, unknowns, tests, terms)
    }

    fn active_set(
        &self,
        assembler: &Assembler<D>,
        unknowns: &[FieldView<D>],
    ) -> Result<Option<Vec<u32>>, AssemblyError> {
        assembler.active_set_of(self, unknowns)
    }

    fn add_tangent(
        &self,
        assembler: &Assembler<D>,
        (unknowns, tests): (&[FieldView<D>], &[&Arc<Space<D>>]),
        parts: Parts,
        pattern: &BlockPattern<D>,
        matrix: &mut BlockMatrix,
    ) -> Result<(), AssemblyError> {
        assembler.tangent_of(self, unknowns, tests, parts, pattern, matrix, true)
    }

    fn assemble_tangent(
        &self,
        assembler: &Assembler<D>,
        (unknowns, tests): (&[FieldView<D>], &[&Arc<Space<D>>]),
        parts: Parts,
        pattern: &BlockPattern<D>,
        matrix: &mut BlockMatrix,
    ) -> Result<(), AssemblyError> {
        assembler.tangent_of(self, unknowns, tests, parts, pattern, matrix, false)
    }
}

/// Properties of a form that its integrals tell.
struct Seen {
    nonlinear: bool,
    slides: bool,
    displaced: bool,
    fields: &'static [FieldDescription],
}

impl Seen {
    fn add(&mut self, integral: &Integral) {
        let unknown = |field: &usize| matches!(self.fields[*field].role, Role::Unknown(_));
        self.nonlinear |= integral.dependence == Dependence::Nonlinear;
        self.slides |= integral.displacement.is_some_and(|fields| fields.iter().any(unknown));
        self.displaced |= integral.displacement.is_some();
    }
}

impl<const D: usize> LinearVisitor<D> for Seen {
    type Error = Infallible;

    fn visit<K: LinearKernel<D>>(&mut self, integral: &Integral, _: &K) -> Result<(), Infallible> {
        self.add(integral);
        Ok(())
    }
}

fn seen_in<F: Form<D>, const D: usize>(form: &F) -> Seen {
    let mut seen = Seen { nonlinear: false, slides: false, displaced: false, fields: form.fields() };
    let Ok(()) = form.residual(&mut seen);
    seen
}

/// A form that is lent, or kept.
pub(super) enum Held<'a, const D: usize> {
    Lent(&'a dyn AnyForm<D>),
    Own(Box<dyn AnyForm<D> + 'a>),
}

impl<'a, const D: usize> Deref for Held<'a, D> {
    type Target = dyn AnyForm<D> + 'a;

    fn deref(&self) -> &Self::Target {
        match self {
            Held::Lent(form) => *form,
            Held::Own(form) => &**form,
        }
    }
}
