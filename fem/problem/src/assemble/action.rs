//! Matrix-free products: the tangent of a form applied to a direction, ∂R/∂u (u; φ_i e_a) w, by the residual's loops.

use std::sync::Arc;

use forms_core::contract::{Entity, Region};

use super::binding::outline::Outline;
use super::binding::pair_error;
use super::residual::Added;
use super::segment_tangent::has_segments;
use super::{Assembler, AssemblyError, BlockPattern, Parts, ValuesBefore};
use crate::constraints::Constraints;
use crate::contract::Form;
use crate::field::{Field, FieldView, views, views_on};
use crate::linear_algebra::{BlockMatrix, LinearOperator, OperatorError};
use crate::pairs::PairError;
use crate::space::Space;

impl<const D: usize> Assembler<D> {
    /// The tangent of a form at given unknowns times a vector, given as one field per unknown: one entry per
    /// unknown of the test spaces, in a row. With the option `#[forms(matrix_free)]` of the form's module no matrix is made, and it costs
    /// about as much as a residual.
    ///
    /// # Errors
    /// An [`AssemblyError`] that names the form and what does not fit.
    pub fn action(
        &self,
        form: &Form<D>,
        unknowns: &[&Field<D>],
        directions: &[&Field<D>],
        tests: &[&Arc<Space<D>>],
    ) -> Result<Vec<f64>, AssemblyError> {
        self.action_parts(form, unknowns, directions, tests, Parts::ALL)
    }

    /// Some of the integrals of [`Assembler::action`].
    ///
    /// # Errors
    /// As there.
    pub fn action_parts(
        &self,
        form: &Form<D>,
        unknowns: &[&Field<D>],
        directions: &[&Field<D>],
        tests: &[&Arc<Space<D>>],
        parts: Parts,
    ) -> Result<Vec<f64>, AssemblyError> {
        let (unknowns, directions) = (views(unknowns), views(directions));
        if has_kernels(form) && !has_segments(form) {
            return self.action_on(form, &unknowns, &directions, tests, parts);
        }
        self.bind(form, &unknowns)?.bind_directions(&directions, &self.mesh)?;
        let outline = Outline::of(form, parts);
        let pattern = BlockPattern::at_iterate(&outline, tests, &unknowns, self)?;
        let mut matrix = BlockMatrix::zero(pattern.sparsity());
        let before = ValuesBefore::Vanish;
        self.write_tangent(form, (&unknowns, tests), parts, &pattern, &mut matrix, before)?;
        let along: Vec<f64> = directions.iter().flat_map(|direction| direction.values).copied().collect();
        let mut product = vec![0.0; matrix.rows()];
        let failed = |source| AssemblyError::LinearAlgebra { form: form.name(), source };
        matrix.multiply_on(self.threads, &along, &mut product).map_err(failed)?;
        Ok(product)
    }

    fn action_on(
        &self,
        form: &Form<D>,
        unknowns: &[FieldView<D>],
        directions: &[FieldView<D>],
        tests: &[&Arc<Space<D>>],
        parts: Parts,
    ) -> Result<Vec<f64>, AssemblyError> {
        if !has_kernels(form) {
            return Err(AssemblyError::NoAction { form: form.name() });
        }
        if has_segments(form) {
            let is_pairs = |region: &&Region| region.entity == Entity::Pairs;
            let region = form.inputs().regions.iter().find(is_pairs);
            let place = "a product without a matrix";
            let refused = |region| pair_error(form.name(), region, PairError::Refused { place });
            return region
                .map_or(Err(AssemblyError::NoAction { form: form.name() }), |region| Err(refused(region)));
        }
        let mut binding = self.bind(form, unknowns)?;
        binding.bind_directions(directions, &self.mesh)?;
        let terms = form.action().iter();
        let terms: Vec<_> = terms.filter(|term| parts.contain(term.integral.dependence)).collect();
        self.sum_of_terms(binding, tests, &terms, Added::Vectors)
    }
}

/// Whether a form has kernels for products without a matrix.
fn has_kernels<const D: usize>(form: &Form<D>) -> bool {
    let has_tangent = !form.tangent().is_empty() || !form.residual_by_means().is_empty();
    !has_tangent || !form.action().is_empty()
}

/// The tangent of a form at given unknowns as a linear operator without a matrix, for Krylov methods. Test spaces are
/// those of the unknowns.
///
/// With constraints it acts on the free unknowns, and as the identity on the prescribed ones: with zeros there in the
/// right-hand side, the solution is the increment that keeps the prescribed values. Where free unknowns give others,
/// u = C y, it is Cᵀ K C on the free ones, and the identity on those given.
///
/// ```
/// use forms_fem::linear_algebra::{GmresOptions, gmres};
/// use forms_fem::prelude::*;
///
/// #[forms(matrix_free)]
/// mod reaction {
///     #[cells]
///     pub struct Omega;
///     pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
///         integral(Omega, (1 + u * u) * dot(grad(u), grad(v)) + (u - 1) * v)
///     }
/// }
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [4, 4], CellShape::Triangle, 1)?;
/// let space = Space::scalar(&mesh, 2)?;
/// let mut constraints = Constraints::new(&space);
/// constraints.fix("boundary", |_: &[f64; 2]| 0.0)?;
/// let form = reaction::balance(&reaction::Omega::on("all"));
/// let assembler = Assembler::new(&mesh);
/// let u = Field::zero(&space);
///
/// // One step of Newton's method: ∂R/∂u (u) w = −R(u).
/// let mut right: Vec<f64> = assembler.residual(&form, &[&u], &[&space])?.iter().map(|r| -r).collect();
/// constraints.homogeneous().apply(&mut right);
/// let tangent = TangentAction::new(&assembler, &form, &[&u]).with_constraints(&[&constraints]);
/// let mut w = vec![0.0; space.unknowns()];
/// let options = GmresOptions { tolerance: 1e-10, ..GmresOptions::default() };
/// let identity = |_: &mut [f64]| Ok(());
/// gmres(|w, product| tangent.apply(w, product), identity, &right, &mut w, &options)?;
/// let mut product = vec![0.0; w.len()];
/// tangent.apply(&w, &mut product)?;
/// assert!(product.iter().zip(&right).all(|(a, b)| (a - b).abs() < 1e-9));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct TangentAction<'a, const D: usize> {
    assembler: &'a Assembler<D>,
    form: &'a Form<D>,
    unknowns: Vec<&'a Field<D>>,
    parts: Parts,
    /// Positions of the prescribed unknowns, in a row over all spaces.
    prescribed: Vec<usize>,
    /// Unknowns that free ones give, with these and their factors.
    relations: Vec<(usize, Vec<(usize, f64)>)>,
}

impl<'a, const D: usize> TangentAction<'a, D> {
    /// The operator at the unknowns, in the order of the form's arguments.
    pub fn new(assembler: &'a Assembler<D>, form: &'a Form<D>, unknowns: &[&'a Field<D>]) -> Self {
        let unknowns = unknowns.to_vec();
        TangentAction { assembler, form, unknowns, parts: Parts::ALL, prescribed: vec![], relations: vec![] }
    }

    /// This action with some of the integrals only.
    pub fn with_parts(self, parts: Parts) -> Self {
        TangentAction { parts, ..self }
    }

    /// This action on the free unknowns, and the identity on the prescribed ones; constraints in the order of the
    /// unknowns.
    pub fn with_constraints(self, constraints: &[&Constraints<D>]) -> Self {
        let mut prescribed = Vec::new();
        let mut relations = Vec::new();
        let mut offset = 0;
        for (field, constraints) in self.unknowns.iter().zip(constraints) {
            prescribed.extend(constraints.prescribed().keys().map(|unknown| offset + unknown));
            relations.extend(constraints.relations().iter().map(|(unknown, relation)| {
                let terms = relation.terms.iter().map(|(free, factor)| (offset + free, *factor));
                (offset + unknown, terms.collect::<Vec<_>>())
            }));
            offset += field.space().unknowns();
        }
        TangentAction { prescribed, relations, ..self }
    }

    /// Number of rows, and of columns.
    pub fn size(&self) -> usize {
        self.unknowns.iter().map(|field| field.space().unknowns()).sum()
    }

    /// The tangent times `direction`, written to `product`. Both have all unknowns in a row.
    ///
    /// # Errors
    /// As [`Assembler::action`]; also where a vector is not of the operator's [`size`](TangentAction::size).
    pub fn apply(&self, direction: &[f64], product: &mut [f64]) -> Result<(), AssemblyError> {
        for found in [direction.len(), product.len()] {
            if found != self.size() {
                let (form, expected) = (self.form.name(), self.size());
                return Err(AssemblyError::Count { form, what: "entries of a vector", expected, found });
            }
        }
        let mut free = direction.to_vec();
        for &unknown in &self.prescribed {
            free[unknown] = 0.0;
        }
        for (unknown, terms) in &self.relations {
            free[*unknown] = terms.iter().map(|(index, factor)| factor * free[*index]).sum();
        }
        let tests: Vec<&Arc<Space<D>>> = self.unknowns.iter().map(|field| field.space()).collect();
        let directions = views_on(&tests, &free);
        let unknowns = views(&self.unknowns);
        let found = self.assembler.action_on(self.form, &unknowns, &directions, &tests, self.parts)?;
        product.copy_from_slice(&found);
        for (unknown, terms) in &self.relations {
            terms.iter().for_each(|(index, factor)| product[*index] += factor * found[*unknown]);
            product[*unknown] = direction[*unknown];
        }
        for &unknown in &self.prescribed {
            product[unknown] = direction[unknown];
        }
        Ok(())
    }
}

impl<const D: usize> LinearOperator for TangentAction<'_, D> {
    fn size(&self) -> usize {
        TangentAction::size(self)
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) -> Result<(), OperatorError> {
        Ok(TangentAction::apply(self, x, y)?)
    }
}
