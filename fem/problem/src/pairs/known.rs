//! Searches for pairs that are kept, so that each is done once, and the candidates that the next one may use.

use std::sync::{Arc, Mutex, PoisonError};

use forms_core::contract::Pairing;

use super::candidates::KeptCandidates;
use super::jumping_data::{ReadFunction, SmoothFunctions};
use super::newest::{KEPT, keep};
use super::rest::SurfacesAtRest;
use super::search_key::SearchKey;
use super::surface_values::SurfaceNodes;
use super::{Displacement, PairError, Pairs};
use crate::instantiate::instantiate;
use crate::mesh::Mesh;
use crate::quadrature::Quadrature;
use crate::threads::Threads;

/// Pairs that were searched for on one mesh.
#[derive(Debug, Default)]
pub(crate) struct KnownPairs<const D: usize> {
    known: Mutex<Vec<Known<D>>>,
    candidates: Mutex<Vec<(SearchKey<D>, Arc<Vec<KeptCandidates<D>>>)>>,
    nodes: SurfaceNodes,
    pub(super) at_rest: SurfacesAtRest<D>,
    functions: SmoothFunctions<D>,
}

#[derive(Debug)]
struct Known<const D: usize> {
    key: SearchKey<D>,
    /// The displacement of the surfaces.
    displacement: Option<Vec<f64>>,
    pairs: Arc<Pairs<D>>,
}

impl<const D: usize> KnownPairs<D> {
    /// The pairs of the mesh, always the same one, with the rules of a choice of quadrature; `estimated` is the degree
    /// where the choice is the compiler's estimate.
    ///
    /// # Errors
    /// Those of the search.
    #[inline(never)]
    pub fn find(
        &self,
        mesh: &Mesh<D>,
        pairing: &Pairing,
        quadrature: &Quadrature<D>,
        estimated: usize,
        displacement: Option<&Displacement<D>>,
        threads: Threads,
    ) -> Result<Arc<Pairs<D>>, PairError> {
        let key = SearchKey::new(pairing, quadrature, estimated);
        let values =
            displacement.map(|displacement| self.nodes.values(mesh, pairing, displacement)).transpose()?;
        let lock = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let is_known = |known: &&Known<D>| known.key == key && known.displacement == values;
        if let Some(known) = lock().iter().find(is_known) {
            return Ok(Arc::clone(&known.pairs));
        }
        let lock_candidates = || self.candidates.lock().unwrap_or_else(PoisonError::into_inner);
        let earlier = values.as_ref().and_then(|_| {
            let candidates = lock_candidates();
            let known = candidates.iter().find(|(known, _)| *known == key);
            known.map(|(_, kept)| Arc::clone(kept))
        });
        let earlier = earlier.as_ref().map_or(&[][..], |kept| kept);
        // Not under the lock: a search runs on several threads.
        let rule = (&key.quadrature, key.degree);
        let (pairs, kept) = Pairs::find(mesh, pairing, rule, displacement, &self.at_rest, threads, earlier)?;
        if values.is_some() {
            let (mut candidates, kept) = (lock_candidates(), Arc::new(kept));
            match candidates.iter_mut().find(|(known, _)| *known == key) {
                Some((_, known)) => *known = kept,
                None => keep(&mut candidates, (key.clone(), kept), KEPT, |_| true),
            }
        }
        let pairs = Arc::new(pairs);
        let displaced = values.is_some();
        let entry = Known { key, displacement: values, pairs: Arc::clone(&pairs) };
        keep(&mut lock(), entry, KEPT, |known| known.displacement.is_some() == displaced);
        Ok(pairs)
    }

    /// Whether a function of position that kernels read on the pairs is that of the body on its surface.
    ///
    /// # Errors
    /// [`PairError::Jump`].
    #[inline(never)]
    pub fn check_function(
        &self,
        mesh: &Mesh<D>,
        pairing: &Pairing,
        quadrature: &Quadrature<D>,
        estimated: usize,
        read: &ReadFunction<'_, D>,
    ) -> Result<(), PairError> {
        self.functions.check(mesh, &SearchKey::new(pairing, quadrature, estimated), read)
    }
}

instantiate!(known: KnownPairs::<D>::find, KnownPairs::<D>::check_function);
