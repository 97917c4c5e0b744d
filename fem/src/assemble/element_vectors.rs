//! Element vectors of a linear integral: the loops over batches, points and basis functions.

use std::ops::Range;

use forms_core::contract::{Lane, LinearKernel};

use super::AssemblyError;
use super::batch::{Batch, WIDEST};
use super::binding::Binding;
use super::walk::Group;

/// What the element vectors of a group depend on, besides the kernel.
pub(super) struct ElementVectors<'a, const D: usize> {
    pub binding: &'a Binding<'a, D>,
    pub group: &'a Group<D>,
    /// The side on which the test function lives.
    pub side: usize,
    /// Its element, by index into the binding's.
    pub element: usize,
}

impl<const D: usize> ElementVectors<'_, D> {
    /// Number of test nodes.
    pub fn nodes(&self) -> usize {
        self.group.sides[self.side].elements[self.element].nodes
    }

    /// Computes the element vectors of the group's entities in a range, and hands them over in their order:
    /// `deliver(first, vectors)` gets whole element vectors, that of entity `first` first, each as
    /// `[node][component]`.
    ///
    /// # Errors
    /// What the data of the form, or `deliver`, has to say.
    pub fn compute<K: LinearKernel<D>>(
        &self,
        kernel: &K,
        range: Range<usize>,
        deliver: &mut dyn FnMut(usize, &[f64]) -> Result<(), AssemblyError>,
    ) -> Result<(), AssemblyError> {
        self.compute_in_lanes::<K, f64>(kernel, range, deliver)
    }

    fn compute_in_lanes<K: LinearKernel<D>, L: Lane>(
        &self,
        kernel: &K,
        range: Range<usize>,
        deliver: &mut dyn FnMut(usize, &[f64]) -> Result<(), AssemblyError>,
    ) -> Result<(), AssemblyError> {
        let components = K::TEST_COMPONENTS;
        let size = self.nodes() * components;
        let zero = L::splat(0.0);
        let mut batch = Batch::<L, D>::new(self.binding, self.group, K::REQUIREMENTS)?;
        let mut sums = vec![zero; size];
        let mut vectors = vec![0.0; size * L::WIDTH];
        let mut lanes = [0.0; WIDEST];
        let mut start = range.start;
        while start < range.end {
            let filled = L::WIDTH.min(range.end - start);
            let cell = kernel.cell(&batch.load(start, filled));
            sums.fill(zero);
            for q in 0..self.group.points() {
                let geometry = batch.point(q)?;
                let flux = kernel.point(&cell, &geometry, batch.fields());
                let hessians = batch.hessians(self.side, self.element);
                let functions = batch.basis(self.side, self.element).iter().zip(hessians);
                for ((basis, hessian), sums) in functions.zip(sums.chunks_mut(components)) {
                    let block = kernel.test(&flux, basis, hessian);
                    for (sum, value) in sums.iter_mut().zip(block.as_ref()) {
                        *sum += *value;
                    }
                }
            }
            for (entry, sum) in sums.iter().enumerate() {
                sum.store(&mut lanes);
                for (lane, value) in lanes[..filled].iter().enumerate() {
                    vectors[lane * size + entry] = *value;
                }
            }
            deliver(start, &vectors[..filled * size])?;
            start += filled;
        }
        Ok(())
    }
}
