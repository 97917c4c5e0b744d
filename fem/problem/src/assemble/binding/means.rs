//! Means over own facets of a form that is bound, kept for the integrals that read them.

use std::collections::HashMap;
use std::sync::{Arc, PoisonError};

use forms_core::contract::Term;

use super::{Binding, Tabulated};
use crate::assemble::AssemblyError;
use crate::assemble::kernels::VectorKernel;
use crate::contract::Function;
use crate::element::{Element, Lagrange};
use crate::instantiate::instantiate;
use crate::mesh::Facet;

/// The means of one list over all own facets.
pub(in crate::assemble) struct FacetMeans {
    /// Number of means, without ∫ ψ.
    pub count: usize,
    /// The largest number of weights of a facet.
    pub weights: usize,
    /// The place of each own facet.
    pub facets: HashMap<Facet, usize>,
    /// Of each facet and weight: the means, then ∫ ψ.
    pub values: Vec<f64>,
}

impl FacetMeans {
    /// The means of a facet with a weight, and ∫ ψ.
    pub fn of(&self, facet: usize, weight: usize) -> (&[f64], f64) {
        let length = self.count + 1;
        let own = &self.values[(facet * self.weights + weight) * length..][..length];
        (&own[..self.count], own[self.count])
    }
}

/// A list of means with a rule of some degree.
pub(super) struct FoundMeans {
    number: usize,
    degree: usize,
    means: Arc<FacetMeans>,
}

impl<'a, const D: usize> Binding<'a, D> {
    /// The lists of means of a form, and the element whose only function is 1, with which they are integrated.
    #[inline(never)]
    pub(super) fn bind_means(&mut self, form: &'a Function<D>) {
        self.means = form.means();
        if self.means.is_empty() {
            return;
        }
        let constant = |shape| (shape, Element::Lagrange(Lagrange { shape, degree: 0 }));
        let elements = Arc::new(self.mesh.shapes().into_iter().map(constant).collect());
        self.constant = Some(self.tabulated(Tabulated { elements, degree: 0, on_facets: false }));
    }

    /// The integrals that make the lists of means.
    pub fn lists_of_means(&self) -> &'a [Term<VectorKernel<D>>] {
        self.means
    }

    /// The element whose only function is 1.
    ///
    /// # Errors
    /// [`AssemblyError::Means`] where the form has no means.
    pub fn constant_element(&self) -> Result<usize, AssemblyError> {
        self.constant.ok_or(AssemblyError::Means { form: self.name })
    }

    /// The means that were made.
    pub fn known_means(&self, number: usize, degree: usize) -> Option<Arc<FacetMeans>> {
        let found = self.found_means.lock().unwrap_or_else(PoisonError::into_inner);
        let known = found.iter().find(|found| (found.number, found.degree) == (number, degree))?;
        Some(Arc::clone(&known.means))
    }

    /// Means for other integrals.
    pub fn keep_means(&self, number: usize, degree: usize, means: &Arc<FacetMeans>) {
        let mut found = self.found_means.lock().unwrap_or_else(PoisonError::into_inner);
        found.push(FoundMeans { number, degree, means: Arc::clone(means) });
    }
}

instantiate!(bound_means: Binding::<D>::bind_means);
