//! Element matrices of a bilinear integral: the loops over batches, points and pairs of basis functions.

use std::ops::Range;

use forms_core::contract::{BilinearKernel, Lane};

use super::AssemblyError;
use super::batch::{Batch, WIDEST};
use super::binding::Binding;
use super::walk::Group;

/// What the element matrices of a group depend on, besides the kernel.
pub(super) struct ElementMatrices<'a, const D: usize> {
    pub binding: &'a Binding<'a, D>,
    pub group: &'a Group<D>,
    /// The sides on which test and trial functions live.
    pub sides: [usize; 2],
    /// Their elements, by index into the binding's.
    pub elements: [usize; 2],
    /// Only pairs of nodes i ≤ j are computed, and mirrored.
    pub symmetric: bool,
}

impl<const D: usize> ElementMatrices<'_, D> {
    /// Number of test and of trial nodes.
    pub fn nodes(&self) -> [usize; 2] {
        [0, 1].map(|k| self.group.sides[self.sides[k]].elements[self.elements[k]].nodes)
    }

    /// Computes the element matrices of the group's entities in a range, and hands them over in their order:
    /// `deliver(first, matrices)` gets whole element matrices, that of entity `first` first, each as
    /// `[test node][trial node][row component][column component]`.
    ///
    /// # Errors
    /// What the data of the form, or `deliver`, has to say.
    pub fn compute<K: BilinearKernel<D>>(
        &self,
        kernel: &K,
        range: Range<usize>,
        deliver: &mut dyn FnMut(usize, &[f64]) -> Result<(), AssemblyError>,
    ) -> Result<(), AssemblyError> {
        self.compute_in_lanes::<K, f64>(kernel, range, deliver)
    }

    fn compute_in_lanes<K: BilinearKernel<D>, L: Lane>(
        &self,
        kernel: &K,
        range: Range<usize>,
        deliver: &mut dyn FnMut(usize, &[f64]) -> Result<(), AssemblyError>,
    ) -> Result<(), AssemblyError> {
        let [rows, columns] = self.nodes();
        let [test_side, trial_side] = self.sides;
        let [test_element, trial_element] = self.elements;
        let entries = K::TEST_COMPONENTS * K::TRIAL_COMPONENTS;
        let mut batch = Batch::<L, D>::new(self.binding, self.group, K::REQUIREMENTS)?;
        let mut accumulators = vec![K::zero::<L>(); rows * columns];
        let mut trial_factors = Vec::with_capacity(columns);
        let size = rows * columns * entries;
        let mut matrices = vec![0.0; size * L::WIDTH];
        let mut lanes = [0.0; WIDEST];
        let mut start = range.start;
        while start < range.end {
            let filled = L::WIDTH.min(range.end - start);
            let cell = kernel.cell(&batch.load(start, filled));
            accumulators.fill(K::zero::<L>());
            for q in 0..self.group.points() {
                let geometry = batch.point(q)?;
                let point = kernel.point(&cell, &geometry, batch.fields());
                trial_factors.clear();
                let hessians = batch.hessians(trial_side, trial_element);
                for (basis, hessian) in batch.basis(trial_side, trial_element).iter().zip(hessians) {
                    trial_factors.push(kernel.trial(&point, basis, hessian));
                }
                let hessians = batch.hessians(test_side, test_element);
                let functions = batch.basis(test_side, test_element).iter().zip(hessians);
                for (i, (basis, hessian)) in functions.enumerate() {
                    let factors = kernel.test(&point, basis, hessian);
                    let first = if self.symmetric { i } else { 0 };
                    let row = &mut accumulators[i * columns + first..(i + 1) * columns];
                    for (accumulator, trial) in row.iter_mut().zip(&trial_factors[first..]) {
                        K::pair(accumulator, &factors, trial);
                    }
                }
            }
            for i in 0..rows {
                for j in if self.symmetric { i } else { 0 }..columns {
                    let block = kernel.finish(&cell, &accumulators[i * columns + j]);
                    for (entry, value) in block.as_ref().iter().enumerate() {
                        value.store(&mut lanes);
                        let (a, b) = (entry / K::TRIAL_COMPONENTS, entry % K::TRIAL_COMPONENTS);
                        let mirrored = (j * columns + i) * entries + b * K::TRIAL_COMPONENTS + a;
                        for (lane, value) in lanes[..filled].iter().enumerate() {
                            matrices[lane * size + (i * columns + j) * entries + entry] = *value;
                            if self.symmetric && i != j {
                                matrices[lane * size + mirrored] = *value;
                            }
                        }
                    }
                }
            }
            deliver(start, &matrices[..filled * size])?;
            start += filled;
        }
        Ok(())
    }
}
