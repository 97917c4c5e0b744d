//! Functionals, and the active set of a form.

use std::ops::Range;

use forms_core::contract::Term;

use super::binding::Binding;
use super::element_loops::point_values::PointBuffers;
use super::groups::{Group, groups};
use super::kernels::PointKernel;
use super::{Assembler, AssemblyError};
use crate::contract::{Form, Function, Functional};
use crate::field::{Field, FieldView, views};
use crate::instantiate::instantiate;
use crate::quadrature::Quadrature;
use crate::threads::Threads;

impl<const D: usize> Assembler<D> {
    /// The value of a functional.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// let u = Field::interpolate(&space, |x| x[0])?;
    /// let integral = form!(|u: State<Scalar>| -> Functional { integral(cells("all"), u) });
    /// assert!((Assembler::new(&mesh).functional(&integral(&u))? - 2.0).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// An [`AssemblyError`] that names the functional and what does not fit.
    pub fn functional(&self, functional: &Functional<D>) -> Result<f64, AssemblyError> {
        self.sum_of(functional, &[])
    }

    /// The value of an energy, or of a functional of unknowns, at its unknowns.
    ///
    /// # Errors
    /// As [`Assembler::functional`].
    pub fn energy(
        &self,
        energy: impl Into<Functional<D>>,
        unknowns: &[&Field<D>],
    ) -> Result<f64, AssemblyError> {
        self.sum_of(&energy.into(), &views(unknowns))
    }

    #[inline(never)]
    fn sum_of(&self, form: &Function<D>, unknowns: &[FieldView<D>]) -> Result<f64, AssemblyError> {
        let binding = self.bind(form, unknowns)?;
        let degrees = binding.degrees(&[]);
        let points =
            PointWalk { binding: &binding, quadrature: &self.quadrature, threads: self.threads, degrees };
        let name = binding.name;
        let receive = |total: &mut f64, value: &[f64], weight: f64, x: &[f64; D]| {
            let contribution = value[0] * weight;
            if !contribution.is_finite() {
                return Err(AssemblyError::ValueNotFinite { form: name, position: x.to_vec() });
            }
            *total += contribution;
            Ok(())
        };
        let chunks = points.all_chunks(form.densities(), &receive)?;
        Ok(chunks.into_iter().fold(0.0, |sum, chunks| sum + chunks.into_iter().sum::<f64>()))
    }

    /// The values of the integrands of a functional of unknowns at its quadrature points, whatever they are, with their positions.
    ///
    /// # Errors
    /// As [`Assembler::functional`].
    pub(crate) fn values_of(
        &self,
        functional: &Function<D>,
        unknowns: &[&Field<D>],
    ) -> Result<Vec<(f64, [f64; D])>, AssemblyError> {
        let binding = self.bind(functional, &views(unknowns))?;
        // Test functions count in the estimate of the degree, as in that of a residual.
        let spaces: Vec<_> = unknowns.iter().map(|field| field.space()).collect();
        let degrees = binding.degrees(&spaces);
        let points =
            PointWalk { binding: &binding, quadrature: &self.quadrature, threads: self.threads, degrees };
        let receive = |found: &mut Vec<(f64, [f64; D])>, value: &[f64], _: f64, x: &[f64; D]| {
            found.push((value[0], *x));
            Ok(())
        };
        let found = points.all_chunks(functional.densities(), &receive)?;
        Ok(found.into_iter().flatten().flatten().collect())
    }

    /// For every quadrature point of the nonlinear integrals that have kinks, in the order of the walk,
    /// which of its switches are on (bit k: the k-th `neg_part`, `max`, comparison, …). `None` if the
    /// form has no kinks. Two iterates with equal lists have the same active set.
    ///
    /// # Errors
    /// An [`AssemblyError`] that names the form and what does not fit.
    pub fn active_set(
        &self,
        form: &Form<D>,
        unknowns: &[&Field<D>],
    ) -> Result<Option<Vec<u32>>, AssemblyError> {
        self.active_set_of(form, &views(unknowns))
    }

    /// [`Assembler::active_set`] at coefficients that need not be those of a field.
    ///
    /// # Errors
    /// As there.
    #[doc(hidden)]
    #[inline(never)]
    pub fn active_set_of(
        &self,
        form: &Function<D>,
        unknowns: &[FieldView<D>],
    ) -> Result<Option<Vec<u32>>, AssemblyError> {
        let binding = self.bind(form, unknowns)?;
        // Test functions count in the estimate of the degree as the unknowns do.
        let spaces: Vec<_> = unknowns.iter().map(|view| view.space).collect();
        let degrees = binding.degrees(&spaces);
        let points =
            PointWalk { binding: &binding, quadrature: &self.quadrature, threads: self.threads, degrees };
        let receive = |found: &mut Vec<u32>, value: &[f64], _: f64, _: &[f64; D]| {
            // More than 32 kinks at a point share the last bit.
            let bits = value.iter().enumerate().filter(|(_, value)| **value > 0.0);
            found.push(bits.fold(0, |bits, (index, _)| bits | 1 << index.min(31)));
            Ok(())
        };
        let found = points.all_chunks(form.switches(), &receive)?;
        Ok((!found.is_empty()).then(|| found.into_iter().flatten().flatten().collect()))
    }

    /// The points of [`Assembler::active_set`], each with the number of its integral's region and its place.
    ///
    /// # Errors
    /// As there.
    #[inline(never)]
    pub(crate) fn switch_places(
        &self,
        form: &Function<D>,
        unknowns: &[FieldView<D>],
    ) -> Result<Vec<(usize, [f64; D])>, AssemblyError> {
        let binding = self.bind(form, unknowns)?;
        let spaces: Vec<_> = unknowns.iter().map(|view| view.space).collect();
        let degrees = binding.degrees(&spaces);
        let points =
            PointWalk { binding: &binding, quadrature: &self.quadrature, threads: self.threads, degrees };
        let receive = |found: &mut Vec<[f64; D]>, _: &[f64], _: f64, x: &[f64; D]| {
            found.push(*x);
            Ok(())
        };
        let mut places = vec![];
        for term in form.switches() {
            let found = points.chunks(term, &receive)?;
            places.extend(found.into_iter().flatten().map(|x| (term.integral.region, x)));
        }
        Ok(places)
    }
}

/// Entities whose values are put together before those of other chunks, on any number of threads.
const CHUNK: usize = 1024;

/// Inputs of a walk over the quadrature points of an integral's region.
struct PointWalk<'a, const D: usize> {
    binding: &'a Binding<'a, D>,
    quadrature: &'a Quadrature<D>,
    threads: Threads,
    degrees: Vec<usize>,
}

impl<const D: usize> PointWalk<'_, D> {
    /// The results of the chunks of each term.
    fn all_chunks<R: Default + Send>(
        &self,
        terms: &[Term<PointKernel<D>>],
        receive: &Receive<R, D>,
    ) -> Result<Vec<Vec<R>>, AssemblyError> {
        terms.iter().map(|term| self.chunks(term, receive)).collect()
    }

    /// Calls `receive(result of the chunk, value, weight, position)` at every quadrature point of an integral's
    /// region, and gives the results of all chunks in their order.
    fn chunks<R: Default + Send>(
        &self,
        Term { integral, kernel }: &Term<PointKernel<D>>,
        receive: &Receive<R, D>,
    ) -> Result<Vec<R>, AssemblyError> {
        let (requirements, mut results) = (kernel.constants().requirements, Vec::new());
        for group in groups(self.binding, integral, self.quadrature, &self.degrees, requirements, &[])? {
            let mut buffers = PointBuffers::default();
            results.extend(chunks_of(self.binding, &group, kernel, self.threads, &mut buffers, receive)?);
        }
        Ok(results)
    }
}

/// Results of the chunks of a group's entities, in their order. `buffers` serve where there is one part.
pub(super) fn chunks_of<R: Default + Send, const D: usize>(
    binding: &Binding<D>,
    group: &Group<D>,
    kernel: &PointKernel<D>,
    threads: Threads,
    buffers: &mut PointBuffers,
    receive: &Receive<R, D>,
) -> Result<Vec<R>, AssemblyError> {
    let task = kernel.at_points(binding, group);
    let (entities, chunks) = (group.entities(), group.entities().div_ceil(CHUNK));
    let of_part = |chunks: Range<usize>, buffers: &mut PointBuffers| {
        let mut results = Vec::with_capacity(chunks.len());
        for chunk in chunks {
            let range = chunk * CHUNK..entities.min((chunk + 1) * CHUNK);
            let mut result = R::default();
            let mut receive = |value: &[f64], weight, x: &[f64; D]| receive(&mut result, value, weight, x);
            kernel.each_point(&task, buffers, range, &mut receive)?;
            results.push(result);
        }
        Ok(results)
    };
    let mut parts = parts_of(chunks, threads.count());
    if parts.len() <= 1 {
        return of_part(parts.pop().unwrap_or_default(), buffers);
    }
    let done = threads.run(parts, |chunks| of_part(chunks, &mut PointBuffers::default()));
    let mut results = Vec::with_capacity(chunks);
    for part in done {
        results.extend(part?);
    }
    Ok(results)
}

/// Runs of chunks for at most the given number of threads.
fn parts_of(chunks: usize, threads: usize) -> Vec<Range<usize>> {
    let parts = threads.min(chunks);
    (0..parts).map(|part| part * chunks / parts..(part + 1) * chunks / parts).collect()
}

/// Entities of each thread in a walk over the quadrature points of the given number.
pub(super) fn entities_of_parts(entities: usize, threads: usize) -> Vec<f64> {
    let parts = parts_of(entities.div_ceil(CHUNK), threads).into_iter();
    parts.map(|chunks| (entities.min(chunks.end * CHUNK) - chunks.start * CHUNK) as f64).collect()
}

/// Takes a chunk's result so far, and the value, weight and position of a quadrature point.
pub(super) type Receive<'a, R, const D: usize> =
    dyn Fn(&mut R, &[f64], f64, &[f64; D]) -> Result<(), AssemblyError> + Sync + 'a;

instantiate!(functional: Assembler::<D>::sum_of, Assembler::<D>::active_set_of, Assembler::<D>::switch_places);
