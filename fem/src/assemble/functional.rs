//! Numbers: integrals of densities, and the count of active quadrature points.

use std::ops::Range;

use forms_core::contract::{ExpressionKernel, ExpressionVisitor, Form, Functional, Integral, Requirements};

use super::batch::{Batch, BatchBuffers, Cells};
use super::binding::Binding;
use super::walk::groups;
use super::{Assembler, AssemblyError};
use crate::field::{Field, FieldView, views};
use crate::lanes::{SimdLane, WIDEST};
use crate::quadrature::Quadrature;
use crate::threads::Threads;

impl<const D: usize> Assembler<D> {
    /// The value of a functional or energy; `unknowns` are its arguments declared `Unknown`.
    ///
    /// # Errors
    /// An [`AssemblyError`] that names the functional and what does not fit.
    pub fn functional<F: Functional<D>>(
        &self,
        form: &F,
        unknowns: &[&Field<D>],
    ) -> Result<f64, AssemblyError> {
        let unknowns = views(unknowns);
        let binding = Binding::new(form.name(), form.fields(), form.inputs(), &self.mesh, &unknowns)?;
        let degrees = binding.degrees(&[]);
        let walk =
            PointWalk { binding: &binding, quadrature: &self.quadrature, threads: self.threads, degrees };
        let mut visitor = DensityVisitor { walk, sum: 0.0 };
        form.density(&mut visitor)?;
        Ok(visitor.sum)
    }

    /// For every quadrature point of the nonlinear integrals that have kinks, in the order of the walk,
    /// which of its switches are on (bit k: the k-th `neg_part`, `max`, comparison, …). `None` if the
    /// form has no kinks. Two iterates with equal lists have the same active set.
    ///
    /// # Errors
    /// An [`AssemblyError`] that names the form and what does not fit.
    pub fn active_set<F: Form<D>>(
        &self,
        form: &F,
        unknowns: &[&Field<D>],
    ) -> Result<Option<Vec<u32>>, AssemblyError> {
        self.active_set_of(form, &views(unknowns))
    }

    /// [`Assembler::active_set`] at coefficients that need not be those of a field.
    pub(crate) fn active_set_of<F: Form<D>>(
        &self,
        form: &F,
        unknowns: &[FieldView<D>],
    ) -> Result<Option<Vec<u32>>, AssemblyError> {
        let binding = Binding::new(form.name(), form.fields(), form.inputs(), &self.mesh, unknowns)?;
        // Test functions count in the estimate of the degree as the unknowns do.
        let spaces: Vec<_> = unknowns.iter().map(|view| view.space).collect();
        let degrees = binding.degrees(&spaces);
        let walk =
            PointWalk { binding: &binding, quadrature: &self.quadrature, threads: self.threads, degrees };
        let mut visitor = SwitchVisitor { walk, found: None };
        form.switches(&mut visitor)?;
        Ok(visitor.found)
    }
}

struct DensityVisitor<'a, const D: usize> {
    walk: PointWalk<'a, D>,
    sum: f64,
}

impl<const D: usize> ExpressionVisitor<D> for DensityVisitor<'_, D> {
    type Error = AssemblyError;

    fn visit<K: ExpressionKernel<D>>(
        &mut self,
        integral: &Integral,
        kernel: &K,
    ) -> Result<(), AssemblyError> {
        let form = self.walk.binding.name;
        let chunks = self.walk.chunks::<K, f64, f64>(integral, kernel, |total, value, weight, x| {
            let contribution = value[0] * weight;
            if !contribution.is_finite() {
                return Err(AssemblyError::ValueNotFinite { form, position: x.to_vec() });
            }
            *total += contribution;
            Ok(())
        })?;
        self.sum += chunks.into_iter().sum::<f64>();
        Ok(())
    }
}

struct SwitchVisitor<'a, const D: usize> {
    walk: PointWalk<'a, D>,
    found: Option<Vec<u32>>,
}

impl<const D: usize> ExpressionVisitor<D> for SwitchVisitor<'_, D> {
    type Error = AssemblyError;

    fn visit<K: ExpressionKernel<D>>(
        &mut self,
        integral: &Integral,
        kernel: &K,
    ) -> Result<(), AssemblyError> {
        let chunks = self.walk.chunks::<K, f64, Vec<u32>>(integral, kernel, |found, value, _, _| {
            // More than 32 kinks at a point share the last bit.
            let bits = value.iter().enumerate().filter(|(_, value)| **value > 0.0);
            found.push(bits.fold(0, |bits, (index, _)| bits | 1 << index.min(31)));
            Ok(())
        })?;
        self.found.get_or_insert_default().extend(chunks.into_iter().flatten());
        Ok(())
    }
}

/// Entities whose values are put together before those of other chunks, on any number of threads.
const CHUNK: usize = 1024;

/// What a walk over the quadrature points of an integral's region needs.
struct PointWalk<'a, const D: usize> {
    binding: &'a Binding<'a, D>,
    quadrature: &'a Quadrature<D>,
    threads: Threads,
    degrees: Vec<usize>,
}

impl<const D: usize> PointWalk<'_, D> {
    /// Calls `receive(result of the chunk, value, weight, position)` at every quadrature point of an integral's
    /// region, and gives the results of all chunks in their order.
    fn chunks<K: ExpressionKernel<D>, L: SimdLane, R: Default + Send>(
        &self,
        integral: &Integral,
        kernel: &K,
        receive: impl Fn(&mut R, &[f64], f64, &[f64; D]) -> Result<(), AssemblyError> + Send + Sync,
    ) -> Result<Vec<R>, AssemblyError> {
        let mut results = Vec::new();
        for group in groups(self.binding, integral, self.quadrature, &self.degrees, &K::REQUIREMENTS)? {
            let (entities, chunks) = (group.entities(), group.entities().div_ceil(CHUNK));
            let parts = self.threads.count().min(chunks).max(1);
            let parts = (0..parts).map(|part| part * chunks / parts..(part + 1) * chunks / parts).collect();
            let done = self.threads.run(parts, |chunks: Range<usize>| {
                let located = Requirements { position: true, ..K::REQUIREMENTS };
                let (cells, mut buffers) = (Cells::Mesh(self.binding.mesh), BatchBuffers::default());
                let mut batch = Batch::<L, D>::new(self.binding, &group, cells, located, &[], &mut buffers)?;
                let mut results = Vec::with_capacity(chunks.len());
                for chunk in chunks {
                    let range = chunk * CHUNK..entities.min((chunk + 1) * CHUNK);
                    let mut result = R::default();
                    let receive =
                        |value: &[f64], weight, x: &[f64; D]| receive(&mut result, value, weight, x);
                    each_point(&mut batch, group.points(), range, kernel, receive)?;
                    results.push(result);
                }
                Ok(results)
            });
            for part in done {
                results.extend(part?);
            }
        }
        Ok(results)
    }
}

/// Calls `receive(value, weight, position)` at every quadrature point of some of a group's entities.
fn each_point<K: ExpressionKernel<D>, L: SimdLane, const D: usize>(
    batch: &mut Batch<L, D>,
    points: usize,
    range: Range<usize>,
    kernel: &K,
    mut receive: impl FnMut(&[f64], f64, &[f64; D]) -> Result<(), AssemblyError>,
) -> Result<(), AssemblyError> {
    let count: usize = K::SHAPE.iter().product();
    let mut lanes = vec![[0.0; WIDEST]; count + 1 + D];
    let mut value = vec![0.0; count];
    for start in range.clone().step_by(L::WIDTH) {
        let filled = L::WIDTH.min(range.end - start);
        let cell = kernel.cell(&batch.load(start, filled));
        for q in 0..points {
            let geometry = batch.point(q)?;
            let values = kernel.evaluate(&cell, &geometry, batch.fields());
            let all = values.as_ref().iter().chain([&geometry.weight]).chain(&geometry.position);
            for (lanes, entry) in lanes.iter_mut().zip(all) {
                entry.store(lanes);
            }
            for lane in 0..batch.cells(0).len() {
                for (value, lanes) in value.iter_mut().zip(&lanes) {
                    *value = lanes[lane];
                }
                let x: [f64; D] = std::array::from_fn(|axis| lanes[count + 1 + axis][lane]);
                receive(&value, lanes[count][lane], &x)?;
            }
        }
    }
    Ok(())
}
