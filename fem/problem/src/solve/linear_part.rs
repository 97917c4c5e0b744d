//! Linear part of a problem: the integrals that no iterate changes, assembled once, and one tangent that is updated in place.

use std::borrow::Cow;
use std::cell::OnceCell;
use std::ops::Range;
use std::sync::Arc;

use forms_core::contract::Role;

use super::rigid_loads::RigidLoads;
use crate::assemble::{
    Assembler, AssemblyError, BlockPattern, FoundPairs, Outline, Parts, RegionPairs, Terms, TouchedEntries,
    ValuesBefore,
};
use crate::contract::Form;
use crate::field::{Field, FieldView, views};
use crate::linear_algebra::error::check_size;
use crate::linear_algebra::vector::{add_scaled, is_finite};
use crate::linear_algebra::{BlockMatrix, LinearAlgebraError};
use crate::space::Space;

/// A form, the spaces of its unknowns and test functions, and who assembles it.
pub(super) struct System<'a, const D: usize, const N: usize> {
    pub form: Form<D>,
    pub assembler: Cow<'a, Assembler<D>>,
    /// Who assembles the nonlinear integrals at an iterate, where that depends on the iterate.
    pub assembler_at: Option<AssemblerAt<'a, D>>,
    pub spaces: [Arc<Space<D>>; N],
    /// Positions of the tangent's entries, from the first use on.
    pub pattern: OnceCell<Arc<BlockPattern<D>>>,
    /// Given forces and couples on rigid surfaces.
    pub loads: Vec<&'a RigidLoads<D>>,
}

/// The assembler for the nonlinear integrals at given unknowns.
pub(super) type AssemblerAt<'a, const D: usize> =
    Box<dyn Fn(&[Field<D>]) -> Result<Assembler<D>, AssemblyError> + 'a>;

/// The parts that no iterate changes, and the matrix.
pub(super) struct Assembled {
    /// Commits of the form's histories up to this assembly.
    pub commits: u64,
    /// The residual at 0 of the integrals that are constant or linear in the unknowns.
    load: Vec<f64>,
    /// Whether there are linear integrals.
    linear: bool,
    /// The tangent of the linear integrals; if `iterate` is known, also that of the others there.
    pub matrix: BlockMatrix,
    /// The unknowns that the tangent depends on, as ascending ranges.
    reads: Vec<Range<usize>>,
    /// Their values at the last update.
    iterate: Option<Vec<f64>>,
    /// The entries that the nonlinear integrals touch, and the linear ones' values there (none without linear integrals).
    pub touched: TouchedEntries,
    linear_values: Vec<f64>,
}

impl Assembled {
    /// Whether the matrix is the tangent at u.
    pub fn is_at(&self, u: &[f64]) -> bool {
        let Some(mut known) = self.iterate.as_deref() else { return false };
        self.reads.iter().all(|places| {
            let (own, later) = known.split_at(places.len());
            known = later;
            *own == u[places.clone()]
        })
    }

    /// Notes that the matrix is the tangent at u.
    pub fn set_iterate(&mut self, u: &[f64]) {
        let mut values = Vec::with_capacity(self.reads.iter().map(|places| places.len()).sum());
        self.reads.iter().for_each(|places| values.extend_from_slice(&u[places.clone()]));
        self.iterate = Some(values);
    }

    /// The values to which the tangent at an iterate is written: those of the linear integrals, or none if all are overwritten.
    pub fn before_update(&mut self) -> ValuesBefore {
        if !self.linear && self.changes_everywhere() {
            self.iterate = None;
            return ValuesBefore::Vanish;
        }
        self.restore();
        ValuesBefore::Count
    }

    /// Takes the nonlinear integrals out of the matrix, in a time proportional to what they touch.
    fn restore(&mut self) {
        if self.iterate.take().is_none() {
            return;
        }
        let mut linear = &self.linear_values[..];
        for places in &self.touched.places {
            let values = &mut self.matrix.values_mut()[places.clone()];
            if self.linear {
                let (own, later) = linear.split_at(places.len());
                values.copy_from_slice(own);
                linear = later;
            } else {
                values.fill(0.0);
            }
        }
    }

    /// Whether the matrix is the tangent at some iterate.
    pub fn is_tangent(&self) -> bool {
        self.iterate.is_some()
    }

    /// The tangent of the linear integrals, where it serves to know it apart from the whole.
    pub fn linear_part(&mut self) -> Option<&BlockMatrix> {
        self.restore();
        self.changed().is_some().then_some(&self.matrix)
    }

    /// The places where the whole differs from the linear part, if it does not differ everywhere.
    pub fn changed(&self) -> Option<&[Range<usize>]> {
        (self.linear && !self.changes_everywhere()).then_some(&self.touched.places)
    }

    fn changes_everywhere(&self) -> bool {
        let changed: usize = self.touched.places.iter().map(|places| places.len()).sum();
        changed == self.matrix.values().len()
    }
}

impl<const D: usize, const N: usize> System<'_, D, N> {
    /// The matrix pattern: blocks that the form leaves empty are not stored, nor those that the assembler's cells leave empty.
    ///
    /// # Errors
    /// [`AssemblyError`]: what the form reads does not fit the spaces, or the pattern cannot be made.
    pub fn pattern(&self) -> Result<&Arc<BlockPattern<D>>, AssemblyError> {
        if let Some(known) = self.pattern.get() {
            return Ok(known);
        }
        let spaces = self.spaces.each_ref();
        let pattern = BlockPattern::for_cells_of(
            &Outline::of(&self.form, Parts::ALL),
            &spaces,
            &spaces,
            &self.assembler,
        )?;
        Ok(self.pattern.get_or_init(|| Arc::new(pattern)))
    }

    /// Whether pairs of points depend on the unknowns, and with them the positions of the tangent's entries.
    pub fn slides(&self) -> bool {
        self.form.slides()
    }

    /// True if the tangent at u has entries outside the known positions. The positions are then found again.
    ///
    /// # Errors
    /// [`AssemblyError`]: a vector of another length, or pairs at u that cannot be found.
    pub fn follow(&mut self, u: &[f64]) -> Result<bool, AssemblyError> {
        let (views, outline) = (self.views(u)?, Outline::of(&self.form, Parts::ALL));
        if self.pattern()?.covers(&outline, &views)? {
            return Ok(false);
        }
        let spaces = self.spaces.each_ref();
        let pattern = BlockPattern::at_iterate(&outline, &spaces, &views, &self.assembler)?;
        self.pattern = OnceCell::from(Arc::new(pattern));
        Ok(true)
    }

    /// The contact pairs at u, in numbers.
    ///
    /// # Errors
    /// [`AssemblyError`]: a vector of another length, or pairs at u that cannot be found.
    pub fn pairs(&self, u: &[f64]) -> Result<Vec<RegionPairs<D>>, AssemblyError> {
        Ok(self.found_pairs(u)?.into_iter().map(|found| found.report).collect())
    }

    pub fn found_pairs(&self, u: &[f64]) -> Result<Vec<FoundPairs<D>>, AssemblyError> {
        self.assembler.pairs_of_form(&self.form, &self.views(u)?, &self.spaces.each_ref())
    }

    /// The motion of all pairs that an unknown displaces, followed from one state to another; see [`Assembler::follow`].
    ///
    /// # Errors
    /// [`AssemblyError`]: those of [`System::pairs`], and surfaces that may have passed through each other.
    pub fn follow_motion(&self, before: &[f64], after: &[f64]) -> Result<(), AssemblyError> {
        if !self.slides() {
            return Ok(());
        }
        let (found, ends) = (self.found_pairs(after)?, (self.views(before)?, self.views(after)?));
        self.assembler.follow_found(self.form.name(), self.form.fields(), &found, (&ends.0, &ends.1))
    }

    /// Number of unknowns of all spaces.
    pub fn unknowns(&self) -> usize {
        self.spaces.iter().map(|space| space.unknowns()).sum()
    }

    /// The parts of a vector over all unknowns that belong to the spaces.
    ///
    /// # Errors
    /// [`AssemblyError::LinearAlgebra`]: a vector of another length.
    pub fn views<'u>(&'u self, u: &'u [f64]) -> Result<[FieldView<'u, D>; N], AssemblyError> {
        check_size("the vector of all unknowns", self.unknowns(), u.len()).map_err(|why| self.misfit(why))?;
        let mut rest = u;
        Ok(self.spaces.each_ref().map(|space| {
            let (values, later) = rest.split_at(space.unknowns());
            rest = later;
            FieldView { space, values, finite: false }
        }))
    }

    /// The fields of a vector over all unknowns.
    pub fn fields(&self, u: &[f64]) -> [Field<D>; N] {
        let mut offset = 0;
        self.spaces.each_ref().map(|space| {
            let values = u[offset..offset + space.unknowns()].to_vec();
            offset += space.unknowns();
            Field::of_known(space, values)
        })
    }

    /// The assembler of the nonlinear integrals at u.
    ///
    /// # Errors
    /// [`AssemblyError`] of the function that chooses it.
    pub fn assembler_at(&self, u: &[f64]) -> Result<Cow<'_, Assembler<D>>, AssemblyError> {
        match &self.assembler_at {
            // Of several processes each has its cells, whichever facets are split.
            Some(choose) => Ok(Cow::Owned(choose(&self.fields(u))?.on_cells_of(&self.assembler))),
            None => Ok(Cow::Borrowed(&*self.assembler)),
        }
    }

    pub fn misfit(&self, source: LinearAlgebraError) -> AssemblyError {
        AssemblyError::LinearAlgebra { form: self.form.name(), source }
    }

    /// The name of an unknown in the form.
    pub fn unknown_name(&self, number: usize) -> &'static str {
        let fields = self.form.fields();
        fields.iter().find(|field| field.role == Role::Unknown(number)).map_or("unknown", |field| field.name)
    }

    /// The active quadrature points at u, bit by bit; see [`Assembler::active_set`].
    ///
    /// # Errors
    /// [`AssemblyError`]: a vector of another length, and what the form refuses at u.
    pub fn active_set(&self, u: &[f64]) -> Result<Option<Vec<u32>>, AssemblyError> {
        self.assembler.active_set_of(&self.form, &self.views(u)?)
    }

    /// The points of the active set, each with the number of its region.
    ///
    /// # Errors
    /// As [`System::active_set`].
    pub fn switch_places(&self, u: &[f64]) -> Result<Vec<(usize, [f64; D])>, AssemblyError> {
        self.assembler.switch_places(&self.form, &self.views(u)?)
    }

    /// The parts that no iterate changes, assembled in the memory of an earlier assembly, or of a matrix with the same positions.
    ///
    /// # Errors
    /// [`AssemblyError`] of the pattern, the load or the linear integrals.
    pub fn assemble(
        &self,
        commits: u64,
        earlier: Option<Assembled>,
        memory: Option<BlockMatrix>,
    ) -> Result<Assembled, AssemblyError> {
        let (form, pattern) = (&self.form, self.pattern()?);
        let zero = self.spaces.each_ref().map(Field::zero);
        let (zero, spaces) = (views(&zero.each_ref()), self.spaces.each_ref());
        let linear = Outline::of(form, Parts::LINEAR_AND_CONSTANT);
        let mut load = self.assembler.load(form, &spaces)?;
        self.for_each_load(|unknown, force| load[unknown] -= force)?;
        let mut assembled = match earlier {
            Some(earlier) => Assembled { commits, load, ..earlier },
            None => {
                let nonlinear = Outline::of(form, Parts::NONLINEAR);
                let touched = pattern.touched(&nonlinear)?;
                let all = 0..self.unknowns();
                let reads = match N == 1 && self.assembler_at.is_none() && nonlinear.sees_one_cell() {
                    true => touched.unknowns[0].clone(),
                    false => vec![all],
                };
                let linear = linear.has_tangent();
                // All of it is written below where there are linear integrals.
                let fits =
                    |matrix: &BlockMatrix| linear && Arc::ptr_eq(matrix.sparsity(), pattern.sparsity());
                let zero = || BlockMatrix::zero(pattern.sparsity());
                let (matrix, linear_values) = (memory.filter(fits).unwrap_or_else(zero), vec![]);
                Assembled { commits, load, linear, matrix, reads, iterate: None, touched, linear_values }
            }
        };
        if assembled.linear {
            let Assembled { load, matrix, linear_values, touched, .. } = &mut assembled;
            let arguments = (&zero[..], &spaces[..]);
            let (parts, vanish) = (Parts::LINEAR_AND_CONSTANT, ValuesBefore::Vanish);
            self.assembler.write_tangent(form, arguments, parts, pattern, matrix, vanish)?;
            // Newton's method names the place of what is no number, by residuals; an affine problem shows it in its matrix.
            if !form.is_affine() && !is_finite(matrix.values()) {
                *load = self.assembler.residual_of(form, &zero, &spaces, parts)?;
            }
            linear_values.clear();
            linear_values.reserve_exact(touched.places.iter().map(|places| places.len()).sum());
            for places in &touched.places {
                linear_values.extend_from_slice(&matrix.values()[places.clone()]);
            }
            assembled.iterate = None;
        }
        Ok(assembled)
    }

    /// The residual at u.
    ///
    /// # Errors
    /// [`AssemblyError`]: a vector of another length, and what the nonlinear integrals refuse.
    pub fn residual(&self, assembled: &mut Assembled, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let mut residual = assembled.load.clone();
        if assembled.linear && u.iter().any(|u| *u != 0.0) {
            assembled.restore();
            let mut linear = vec![0.0; residual.len()];
            let product = assembled.matrix.multiply_on(self.assembler.threads(), u, &mut linear);
            product.map_err(|why| self.misfit(why))?;
            add_scaled(&mut residual, 1.0, &linear);
        }
        add_scaled(&mut residual, 1.0, &self.nonlinear_residual(u)?);
        Ok(residual)
    }

    /// The residual of all integrals at u, assembled by itself, and the forces on rigid surfaces.
    ///
    /// # Errors
    /// [`AssemblyError`]: a vector of another length, and what the integrals refuse.
    pub fn whole_residual(&self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let (views, spaces) = (self.views(u)?, self.spaces.each_ref());
        let mut residual = self.assembler_at(u)?.residual_of(&self.form, &views, &spaces, Parts::ALL)?;
        self.for_each_load(|unknown, force| residual[unknown] -= force)?;
        Ok(residual)
    }

    /// The residual of the nonlinear integrals at u.
    ///
    /// # Errors
    /// [`AssemblyError`]: a vector of another length, and what the integrals refuse.
    pub fn nonlinear_residual(&self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let (views, spaces) = (self.views(u)?, self.spaces.each_ref());
        self.assembler_at(u)?.residual_of(&self.form, &views, &spaces, Parts::NONLINEAR)
    }

    /// A visit to each force on rigid surfaces, with its unknowns among those of all spaces. Of several processes the one that owns the cell
    /// that carries a surface has its loads.
    ///
    /// # Errors
    /// [`AssemblyError::OtherSpace`]: forces on a space that is not one of the problem's.
    pub fn for_each_load(&self, mut visit: impl FnMut(usize, f64)) -> Result<(), AssemblyError> {
        for loads in &self.loads {
            let Some(number) = self.spaces.iter().position(|space| space.numbers_as(&loads.space)) else {
                let (form, field) = (self.form.name(), self.unknown_name(0));
                return Err(AssemblyError::OtherSpace { form, field, what: "loads" });
            };
            let offset: usize = self.spaces[..number].iter().map(|space| space.unknowns()).sum();
            for (_, entries) in loads.entries.iter().filter(|(cell, _)| self.assembler.owns_cell(*cell)) {
                entries.iter().for_each(|(unknown, force)| visit(offset + unknown, *force));
            }
        }
        Ok(())
    }

    /// See [`Assembler::sizes_of_contributions`].
    ///
    /// # Errors
    /// [`AssemblyError`]: a vector of another length, and what the integrals refuse.
    pub fn sizes_of_contributions(&self, u: &[f64], terms: Terms) -> Result<Vec<f64>, AssemblyError> {
        let (views, spaces) = (self.views(u)?, self.spaces.each_ref());
        let mut sizes = self.assembler_at(u)?.sizes_of_contributions(&self.form, &views, &spaces, terms)?;
        self.for_each_load(|unknown, force| sizes[unknown] += force.abs())?;
        Ok(sizes)
    }
}
