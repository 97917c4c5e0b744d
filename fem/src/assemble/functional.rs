//! Numbers: integrals of densities, and the count of active quadrature points.

use forms_core::contract::{ExpressionKernel, ExpressionVisitor, Form, Functional, Integral, Requirements};

use super::batch::{Batch, BatchBuffers, Cells};
use super::binding::Binding;
use super::walk::groups;
use super::{Assembler, AssemblyError};
use crate::field::Field;
use crate::lanes::{SimdLane, WIDEST};
use crate::quadrature::Quadrature;

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
        let binding = Binding::new(form.name(), form.fields(), form.inputs(), &self.mesh, unknowns)?;
        let degrees = binding.degrees(&[]);
        let mut visitor =
            DensityVisitor { binding: &binding, quadrature: &self.quadrature, degrees, sum: 0.0 };
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
        let binding = Binding::new(form.name(), form.fields(), form.inputs(), &self.mesh, unknowns)?;
        // Test functions count in the estimate of the degree as the unknowns do.
        let spaces: Vec<_> = unknowns.iter().map(|field| field.space()).collect();
        let degrees = binding.degrees(&spaces);
        let mut visitor =
            SwitchVisitor { binding: &binding, quadrature: &self.quadrature, degrees, found: None };
        form.switches(&mut visitor)?;
        Ok(visitor.found)
    }
}

struct DensityVisitor<'a, const D: usize> {
    binding: &'a Binding<'a, D>,
    quadrature: &'a Quadrature<D>,
    degrees: Vec<usize>,
    sum: f64,
}

impl<const D: usize> ExpressionVisitor<D> for DensityVisitor<'_, D> {
    type Error = AssemblyError;

    fn visit<K: ExpressionKernel<D>>(
        &mut self,
        integral: &Integral,
        kernel: &K,
    ) -> Result<(), AssemblyError> {
        let mut total = 0.0;
        let name = self.binding.name;
        each_point::<K, f64, D>(
            self.binding,
            self.quadrature,
            &self.degrees,
            integral,
            kernel,
            |value, weight, x| {
                let contribution = value[0] * weight;
                if !contribution.is_finite() {
                    return Err(AssemblyError::ValueNotFinite { form: name, position: x.to_vec() });
                }
                total += contribution;
                Ok(())
            },
        )?;
        self.sum += total;
        Ok(())
    }
}

struct SwitchVisitor<'a, const D: usize> {
    binding: &'a Binding<'a, D>,
    quadrature: &'a Quadrature<D>,
    degrees: Vec<usize>,
    found: Option<Vec<u32>>,
}

impl<const D: usize> ExpressionVisitor<D> for SwitchVisitor<'_, D> {
    type Error = AssemblyError;

    fn visit<K: ExpressionKernel<D>>(
        &mut self,
        integral: &Integral,
        kernel: &K,
    ) -> Result<(), AssemblyError> {
        let mut found = self.found.take().unwrap_or_default();
        each_point::<K, f64, D>(
            self.binding,
            self.quadrature,
            &self.degrees,
            integral,
            kernel,
            |value, _, _| {
                // More than 32 kinks at a point share the last bit.
                let bits = value.iter().enumerate().filter(|(_, value)| **value > 0.0);
                found.push(bits.fold(0, |bits, (index, _)| bits | 1 << index.min(31)));
                Ok(())
            },
        )?;
        self.found = Some(found);
        Ok(())
    }
}

/// Calls `receive(value, weight, position)` at every quadrature point of an integral's region.
fn each_point<K: ExpressionKernel<D>, L: SimdLane, const D: usize>(
    binding: &Binding<D>,
    quadrature: &Quadrature<D>,
    degrees: &[usize],
    integral: &Integral,
    kernel: &K,
    mut receive: impl FnMut(&[f64], f64, &[f64; D]) -> Result<(), AssemblyError>,
) -> Result<(), AssemblyError> {
    let count: usize = K::SHAPE.iter().product();
    let mut lanes = vec![[0.0; WIDEST]; count + 1 + D];
    let mut value = vec![0.0; count];
    let mut buffers = BatchBuffers::default();
    for group in groups(binding, integral, quadrature, degrees, &K::REQUIREMENTS)? {
        let located = Requirements { position: true, ..K::REQUIREMENTS };
        let mut batch =
            Batch::<L, D>::new(binding, &group, Cells::Mesh(binding.mesh), located, &[], &mut buffers)?;
        for start in (0..group.entities()).step_by(L::WIDTH) {
            let filled = L::WIDTH.min(group.entities() - start);
            let cell = kernel.cell(&batch.load(start, filled));
            for q in 0..group.points() {
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
    }
    Ok(())
}
