//! A problem as the system of equations that Newton's method solves, with the integrals that no iterate changes assembled
//! once, and sums over processes where there are several.

use std::borrow::Cow;
use std::ops::Range;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

use super::Problem;
use crate::assemble::{AssemblyError, Outline, Parts, Terms};
use crate::history::commits;
use crate::solve::communicator::{agreed, all_active};
use crate::solve::linear_and_nonlinear::Nonlinear;
use crate::solve::{
    ActivePoints, DividedVectors, FieldUnknowns, LinearPart, NonlinearProblem, NonlinearTangent,
    PartlyLinear, Processes, Products, Tangent,
};
use crate::space::Space;

impl<const D: usize, const N: usize> Problem<'_, D, N> {
    fn own_residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        if let Some(split) = &self.split {
            let start = Instant::now();
            let residual = self.system.residual_of_parts(split, u);
            self.seconds += start.elapsed().as_secs_f64();
            return residual;
        }
        let (system, assembled) = self.ready()?;
        let start = Instant::now();
        let residual = system.residual(assembled, u);
        self.seconds += start.elapsed().as_secs_f64();
        residual
    }

    /// The sum of the parts of a vector over all unknowns that the processes assembled.
    pub(super) fn added_up(&self, own: Result<Vec<f64>, AssemblyError>) -> Result<Vec<f64>, AssemblyError> {
        let form = self.system.form.name();
        Processes::new(self.communicator, self.divided.clone()).added_up(form, own)
    }

    /// Brings the matrix to the tangent at u, in a time proportional to the number of entries that nonlinear integrals touch.
    ///
    /// # Errors
    /// [`AssemblyError::NotFinite`] where u is not finite at an unknown that nonlinear integrals read; otherwise those of the integrals.
    fn update(&mut self, u: &[f64]) -> Result<(), AssemblyError> {
        if self.system.slides() && self.system.follow(u)? {
            self.assembled = None;
        }
        let (system, assembled) = self.ready()?;
        let start = Instant::now();
        let mut views = system.views(u)?;
        // A judgement of the iterate may have asked for it before the next step does.
        if assembled.is_at(u) {
            return Ok(());
        }
        // Nothing else is read: a pass over all values would cost more than the update.
        for (number, (view, touched)) in views.iter_mut().zip(&assembled.touched.unknowns).enumerate() {
            let finite =
                |unknowns: &Range<usize>| view.values[unknowns.clone()].iter().all(|u| u.is_finite());
            if !touched.iter().all(finite) {
                let (form, field) = (system.form.name(), system.unknown_name(number));
                return Err(AssemblyError::NotFinite { form, field, position: None });
            }
            view.finite = true;
        }
        let (assembler, spaces) = (system.assembler_at(u)?, system.spaces.each_ref());
        let (arguments, pattern) = ((&views[..], &spaces[..]), system.pattern()?);
        let (before, matrix) = (assembled.before_update(), &mut assembled.matrix);
        let written =
            assembler.write_tangent(&system.form, arguments, Parts::NONLINEAR, pattern, matrix, before);
        assembled.set_iterate(u);
        self.seconds += start.elapsed().as_secs_f64();
        written
    }

    fn own_active_points(&mut self, u: &[f64]) -> Result<Option<ActivePoints>, AssemblyError> {
        let start = Instant::now();
        let set = self.system.active_set(u)?;
        self.seconds += start.elapsed().as_secs_f64();
        // A point with several switches counts once; which of them are on tells sets apart.
        Ok(set.map(|bits| {
            let on = bits.iter().enumerate().filter(|(_, bits)| **bits != 0);
            let set = ActivePoints::from_numbers(on.map(|(point, bits)| point << 32 | *bits as usize));
            self.switches.record(bits);
            set
        }))
    }
}

impl<const D: usize, const N: usize> NonlinearProblem for Problem<'_, D, N> {
    fn residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let own = self.own_residual(u);
        self.added_up(own)
    }

    fn tangent(&mut self, u: &[f64]) -> Result<Tangent<'_>, AssemblyError> {
        let own = self.update(u);
        agreed(self.communicator, self.system.form.name(), own)?;
        // Which places change is known of this process's part alone.
        let alone = self.communicator.is_none() && !self.system.slides();
        let (_, assembled) = self.ready()?;
        let changed = assembled.changed().filter(|_| alone);
        Ok(Tangent { matrix: Cow::Borrowed(&assembled.matrix), changed })
    }

    fn divided(&self) -> Option<Rc<dyn DividedVectors>> {
        self.divided.clone()
    }

    fn active_points(&mut self, u: &[f64]) -> Result<Option<ActivePoints>, AssemblyError> {
        let switches = !self.system.form.switches().is_empty();
        if !switches || self.system.assembler_at.is_some() || self.system.slides() {
            return Ok(None);
        }
        let (own, form) = (self.own_active_points(u), self.system.form.name());
        match (agreed(self.communicator, form, own)?, self.communicator) {
            (Some(own), Some(communicator)) => all_active(communicator, own)
                .map(Some)
                .map_err(|source| AssemblyError::Communication { form, source }),
            (own, _) => Ok(own),
        }
    }

    fn fields(&self) -> Vec<FieldUnknowns> {
        let layout = |space: &Arc<Space<D>>| FieldUnknowns {
            unknowns: space.unknowns(),
            components: space.components(),
        };
        self.system.spaces.iter().map(layout).collect()
    }

    fn products(&mut self, u: &[f64], x: &[f64]) -> Result<Products, AssemblyError> {
        if let Some(split) = &mut self.split {
            let nonlinear = self.system.nonlinear_tangent(split, u)?.matrix.clone();
            let mut products = Tangent::lent(&split.linear).products(x);
            products.add(&Tangent::lent(&nonlinear).products(x));
            return Ok(products);
        }
        // The last tangent serves, where it was not taken apart for a residual.
        let kept = self.assembled.as_ref().filter(|assembled| assembled.is_tangent());
        let own = match kept {
            Some(assembled) => Ok(Tangent::lent(&assembled.matrix).products(x)),
            // Other processes may know their parts of the tangent, and are at the sum already.
            None => self.update(u).and_then(|()| Ok(Tangent::lent(&self.ready()?.1.matrix).products(x))),
        };
        // All processes must come to the same judgement of convergence.
        let (sums, sizes) = match own {
            Ok(Products { sums, sizes }) => (Ok(sums), Ok(sizes)),
            Err(error) => (Err(error), Ok(vec![])),
        };
        Ok(Products { sums: self.added_up(sums)?, sizes: self.added_up(sizes)? })
    }

    fn sizes_of_terms(&mut self, u: &[f64], terms: Terms) -> Result<Option<Vec<f64>>, AssemblyError> {
        let own = self.system.sizes_of_contributions(u, terms);
        self.added_up(own).map(Some)
    }

    fn largest_step(&mut self, u: &[f64], step: &[f64]) -> Result<f64, AssemblyError> {
        self.positive_part_of_step(u, step)
    }

    fn partly_linear(&mut self) -> Option<&mut dyn PartlyLinear> {
        // Steps on few unknowns are not limited, and known solutions repel all unknowns.
        if self.positive.is_empty() && self.repulsion.is_none() { Some(self) } else { None }
    }

    fn factor_of_step(&mut self, u: &[f64], step: &[f64]) -> f64 {
        self.repulsion.as_ref().map_or(1.0, |repulsion| repulsion.factor(u, step))
    }
}

impl<const D: usize, const N: usize> PartlyLinear for Problem<'_, D, N> {
    fn linear_part(&mut self) -> Result<Option<LinearPart<'_>>, AssemblyError> {
        if self.communicator.is_some() {
            return Ok(None);
        }
        let is_symmetric = Outline::of(&self.system.form, Parts::LINEAR_AND_CONSTANT).is_symmetric();
        if self.system.slides() {
            let start = Instant::now();
            let commits = commits(self.system.form.inputs());
            if self.split.as_ref().is_none_or(|known| known.commits != commits) {
                self.split = self.system.assemble_parts(commits)?;
            }
            self.seconds += start.elapsed().as_secs_f64();
            return Ok(self.split.as_ref().map(|split| LinearPart { matrix: &split.linear, is_symmetric }));
        }
        Ok(self.ready()?.1.linear_part().map(|matrix| LinearPart { matrix, is_symmetric }))
    }

    fn nonlinear_tangent(&mut self, u: &[f64]) -> Result<Option<NonlinearTangent<'_>>, AssemblyError> {
        let Some(split) = &mut self.split else { return Ok(None) };
        let start = Instant::now();
        let Nonlinear { matrix, rows, reads, .. } = self.system.nonlinear_tangent(split, u)?;
        self.seconds += start.elapsed().as_secs_f64();
        Ok(Some(NonlinearTangent { matrix, rows, reads }))
    }

    fn nonlinear_residual(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let start = Instant::now();
        let residual = self.system.nonlinear_residual(u);
        self.seconds += start.elapsed().as_secs_f64();
        residual
    }
}
