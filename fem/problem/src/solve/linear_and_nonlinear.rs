//! Linear and nonlinear integrals in matrices of their own, where pairs of points slide: the positions of the nonlinear ones' entries
//! follow the iterate, and those of the linear ones stay with their factor.

use super::linear_part::System;
use crate::assemble::{AssemblyError, BlockPattern, Outline, Parts, ValuesBefore};
use crate::field::Field;
use crate::linear_algebra::BlockMatrix;
use crate::linear_algebra::vector::add_scaled;

/// The system as the sum of both parts.
pub(super) struct SplitSystem<const D: usize> {
    /// Commits of the form's histories up to this assembly.
    pub commits: u64,
    /// The residual at 0 of the integrals that are constant or linear in the unknowns.
    load: Vec<f64>,
    pub linear: BlockMatrix,
    nonlinear: Option<Nonlinear<D>>,
}

/// The tangent of the nonlinear integrals.
pub(super) struct Nonlinear<const D: usize> {
    pattern: BlockPattern<D>,
    pub matrix: BlockMatrix,
    /// The rows with entries, and the unknowns that are read.
    pub rows: Vec<usize>,
    pub reads: Vec<usize>,
    /// The iterate of the matrix.
    iterate: Option<Vec<f64>>,
}

impl<const D: usize, const N: usize> System<'_, D, N> {
    /// The linear part by itself; none where there is none, or where nonlinear integrals go over cells, so that it has no factor
    /// that serves.
    ///
    /// # Errors
    /// [`AssemblyError`] of the pattern, the load or the linear integrals.
    pub fn assemble_parts(&self, commits: u64) -> Result<Option<SplitSystem<D>>, AssemblyError> {
        let parts = Parts::LINEAR_AND_CONSTANT;
        let outline = Outline::of(&self.form, parts);
        let zero = self.spaces.each_ref().map(Field::zero);
        let (zero, spaces) = (zero.each_ref(), self.spaces.each_ref());
        let views = zero.map(Field::view);
        if !outline.has_tangent() || BlockPattern::couples_cells(&Outline::of(&self.form, Parts::NONLINEAR)) {
            return Ok(None);
        }
        let pattern = BlockPattern::at_iterate(&outline, &spaces, &views, &self.assembler)?;
        let mut load = self.assembler.residual_of(&self.form, &views, &spaces, parts)?;
        self.for_each_load(|unknown, force| load[unknown] -= force)?;
        let mut linear = BlockMatrix::zero(pattern.sparsity());
        let (arguments, vanish) = ((&views[..], &spaces[..]), ValuesBefore::Vanish);
        self.assembler.write_tangent(&self.form, arguments, parts, &pattern, &mut linear, vanish)?;
        Ok(Some(SplitSystem { commits, load, linear, nonlinear: None }))
    }

    /// The residual at u.
    ///
    /// # Errors
    /// [`AssemblyError`]: a vector of another length, and what the nonlinear integrals refuse.
    pub fn residual_of_parts(&self, split: &SplitSystem<D>, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let mut linear = vec![0.0; split.load.len()];
        let product = split.linear.multiply_on(self.assembler.threads(), u, &mut linear);
        product.map_err(|why| self.misfit(why))?;
        add_scaled(&mut linear, 1.0, &split.load);
        add_scaled(&mut linear, 1.0, &self.nonlinear_residual(u)?);
        Ok(linear)
    }

    /// The tangent of the nonlinear integrals at u, whose positions are made again where pairs have left them.
    ///
    /// # Errors
    /// [`AssemblyError`]: a vector of another length, and what the pattern or the integrals refuse.
    pub fn nonlinear_tangent<'p>(
        &self,
        split: &'p mut SplitSystem<D>,
        u: &[f64],
    ) -> Result<&'p Nonlinear<D>, AssemblyError> {
        // A judgement of the iterate may have asked for it before the next step does.
        if let Some(known) = split.nonlinear.take_if(|known| known.iterate.as_deref() == Some(u)) {
            return Ok(split.nonlinear.insert(known));
        }
        let (spaces, views) = (self.spaces.each_ref(), self.views(u)?);
        let outline = Outline::of(&self.form, Parts::NONLINEAR);
        let known = match split.nonlinear.take() {
            Some(known) if known.pattern.covers(&outline, &views)? => Some(known),
            _ => None,
        };
        let mut nonlinear = match known {
            Some(known) => known,
            None => {
                let pattern = BlockPattern::at_iterate(&outline, &spaces, &views, &self.assembler)?;
                let reads = pattern.read_unknowns(&outline)?;
                let matrix = BlockMatrix::zero(pattern.sparsity());
                let rows = (0..matrix.rows()).filter(|row| matrix.row(*row).next().is_some()).collect();
                Nonlinear { pattern, matrix, rows, reads, iterate: None }
            }
        };
        let Nonlinear { pattern, matrix, .. } = &mut nonlinear;
        let (arguments, vanish) = ((&views[..], &spaces[..]), ValuesBefore::Vanish);
        self.assembler.write_tangent(&self.form, arguments, Parts::NONLINEAR, pattern, matrix, vanish)?;
        nonlinear.iterate = Some(u.to_vec());
        Ok(split.nonlinear.insert(nonlinear))
    }
}
