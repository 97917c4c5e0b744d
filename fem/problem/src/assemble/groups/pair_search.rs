//! The contact pairs that a matrix pattern has places for: those of fixed points, and of sliding ones with their neighbours.

use std::collections::{BTreeSet, HashMap};
use std::sync::Arc;

use forms_core::contract::{Entity, Pairing};

use super::degrees::Estimate;
use super::pair_groups::without_coefficients;
use crate::assemble::binding::entities::Entities;
use crate::assemble::binding::outline::Coupling;
use crate::assemble::binding::{Binding, pair_error};
use crate::assemble::{Assembler, AssemblyError};
use crate::contract::Function;
use crate::cut::Cut;
use crate::field::FieldView;
use crate::instantiate::instantiate;
use crate::mesh::{Facet, Mesh};
use crate::pairs::{KnownPairs, PairError, Pairs, coupled_facets};
use crate::quadrature::Quadrature;
use crate::space::Space;
use crate::threads::Threads;

/// Source of the contact pairs of a matrix pattern.
#[derive(Debug)]
pub(in crate::assemble) struct PairSearch<const D: usize> {
    known: Arc<KnownPairs<D>>,
    quadrature: Quadrature<D>,
    threads: Threads,
    /// The body that is cut from the mesh.
    cut: Option<Arc<Cut<D>>>,
    /// The couplings of sliding pairs: those of some iterate, and of neighbours to which points may slide.
    sliding: Vec<SlidingCouplings>,
}

/// The own and opposite facets that the pairs of displaced surfaces may couple, ascending.
#[derive(Debug)]
struct SlidingCouplings {
    region: usize,
    displacement: &'static [usize],
    facets: Arc<[[Facet; 2]]>,
}

impl<const D: usize> Default for PairSearch<D> {
    fn default() -> Self {
        let (known, quadrature, threads) = (Arc::default(), Quadrature::Estimated, Threads::all());
        PairSearch { known, quadrature, threads, cut: None, sliding: vec![] }
    }
}

impl<const D: usize> PairSearch<D> {
    /// The search of an assembler.
    #[inline(never)]
    pub fn of(assembler: &Assembler<D>) -> Self {
        let Assembler { known_pairs, quadrature, threads, cut, .. } = assembler;
        let (known, quadrature, cut) = (Arc::clone(known_pairs), quadrature.clone(), cut.clone());
        PairSearch { known, quadrature, threads: *threads, cut, sliding: vec![] }
    }

    /// The cells or facets of a form's region; pairs count as facets with two sides.
    ///
    /// # Errors
    /// Those of the regions and of the search for contact pairs.
    #[inline(never)]
    pub fn entities<'a>(
        &self,
        form: &Function<D>,
        tests: &[&'a Arc<Space<D>>],
        trials: &[&'a Arc<Space<D>>],
        coupling: &Coupling,
    ) -> Result<Entities<'a>, AssemblyError> {
        let (inputs, mesh) = (form.inputs(), &tests[0].mesh);
        if inputs.regions[coupling.region].entity != Entity::Pairs {
            let region = &inputs.regions[coupling.region];
            return Entities::inside(self.cut.as_deref(), mesh, form.name(), region);
        }
        let sliding = self.sliding.iter().find(|known| known.is_of(coupling));
        let facets = match sliding {
            Some(known) => known.facets.to_vec(),
            None => self.pairs(form, tests, &without_coefficients(trials), coupling)?.facets(),
        };
        Ok(Entities::InteriorFacets(facets.into()))
    }

    /// The pairs that an integral has at an iterate.
    fn pairs(
        &self,
        form: &Function<D>,
        tests: &[&Arc<Space<D>>],
        unknowns: &[FieldView<D>],
        coupling: &Coupling,
    ) -> Result<Arc<Pairs<D>>, AssemblyError> {
        let mesh = &tests[0].mesh;
        let mut binding = Binding::new(form, mesh, unknowns)?;
        binding.searches = Some((&self.known, self.threads));
        let degrees = binding.degrees(tests);
        let history = binding.history_degree(&coupling.requirements, &self.quadrature)?;
        let of_history = history.map(|(_, degree)| degree);
        let estimate = Estimate { integrand: &coupling.degree, fields: &degrees, of_history };
        let degree = estimate.on_pairs(mesh, binding.regions[coupling.region].pairing.as_ref());
        binding.pairs(coupling.region, coupling.displacement, &self.quadrature, degree)
    }

    /// The facets of all surfaces of a coupling's pairs.
    ///
    /// # Errors
    /// [`AssemblyError`] with a [`PairError`] of a surface.
    #[inline(never)]
    pub fn surfaces(
        &self,
        form: &Function<D>,
        mesh: &Mesh<D>,
        coupling: &Coupling,
    ) -> Result<BTreeSet<Facet>, AssemblyError> {
        let region = &form.inputs().regions[coupling.region];
        let refused = |source| pair_error(form.name(), region, source);
        let pairing = region.pairing.as_ref().ok_or_else(|| refused(PairError::NoPairing))?;
        let mut facets = BTreeSet::new();
        for name in pairing.surfaces.iter().flat_map(|facing| [&facing.own, &facing.opposite]) {
            facets.extend(coupled_facets(mesh, name).map_err(refused)?.iter().copied());
        }
        Ok(facets)
    }

    /// Couplings of sliding pairs at an iterate, and of their neighbours.
    ///
    /// # Errors
    /// [`AssemblyError`] with a [`PairError`] of the search.
    #[inline(never)]
    pub fn slide_to(
        &mut self,
        form: &Function<D>,
        tests: &[&Arc<Space<D>>],
        unknowns: &[FieldView<D>],
        couplings: &[Coupling],
    ) -> Result<(), AssemblyError> {
        self.sliding.clear();
        let mesh = &tests[0].mesh;
        for coupling in couplings {
            let Some(displacement) = coupling.displacement else { continue };
            if self.sliding.iter().any(|known| known.is_of(coupling)) {
                continue;
            }
            let region = &form.inputs().regions[coupling.region];
            let refused = |source| pair_error(form.name(), region, source);
            let pairing = region.pairing.as_ref().ok_or_else(|| refused(PairError::NoPairing))?;
            let mut pairs = Vec::new();
            // Integrals of other degrees have other points.
            for like in couplings.iter().filter(|like| like.slides_as(coupling)) {
                pairs.extend(self.pairs(form, tests, unknowns, like)?.facets());
            }
            let facets = with_neighbours(mesh, pairing, pairs).map_err(refused)?;
            let region = coupling.region;
            self.sliding.push(SlidingCouplings { region, displacement, facets: facets.into() });
        }
        Ok(())
    }

    /// Whether everything that sliding pairs couple at an iterate has its place.
    ///
    /// # Errors
    /// [`AssemblyError`] with a [`PairError`] of the search.
    #[inline(never)]
    pub fn covers(
        &self,
        form: &Function<D>,
        tests: &[&Arc<Space<D>>],
        unknowns: &[FieldView<D>],
        couplings: &[Coupling],
    ) -> Result<bool, AssemblyError> {
        for coupling in couplings.iter().filter(|coupling| coupling.displacement.is_some()) {
            let Some(known) = self.sliding.iter().find(|known| known.is_of(coupling)) else {
                return Ok(false);
            };
            let pairs = self.pairs(form, tests, unknowns, coupling)?;
            if pairs.facets().iter().any(|facets| known.facets.binary_search(facets).is_err()) {
                return Ok(false);
            }
        }
        Ok(true)
    }
}

impl SlidingCouplings {
    fn is_of(&self, coupling: &Coupling) -> bool {
        self.region == coupling.region && Some(self.displacement) == coupling.displacement
    }
}

/// Facets around an opposite one to which a point may slide before the pattern is made again: the number of layers of facets that
/// share a vertex.
const LAYERS: usize = 2;

/// Pairs of facets, and each own facet with the neighbours of those opposite to it; ascending.
#[inline(never)]
fn with_neighbours<const D: usize>(
    mesh: &Mesh<D>,
    pairing: &Pairing,
    pairs: Vec<[Facet; 2]>,
) -> Result<Vec<[Facet; 2]>, PairError> {
    let mut around: HashMap<u32, Vec<Facet>> = HashMap::new();
    for facing in &pairing.surfaces {
        // A rigid surface is one cell: points stay on it wherever they slide.
        if mesh.carrier(&facing.opposite).is_some() {
            continue;
        }
        let facets = coupled_facets(mesh, &facing.opposite)?;
        for facet in &*facets {
            for vertex in mesh.facet_vertices(*facet) {
                around.entry(vertex).or_default().push(*facet);
            }
        }
    }
    let mut all: BTreeSet<[Facet; 2]> = pairs.into_iter().collect();
    for _ in 0..LAYERS {
        let neighbours = |[own, opposite]: &[Facet; 2]| -> Vec<[Facet; 2]> {
            let vertices = mesh.facet_vertices(*opposite).collect::<Vec<_>>().into_iter();
            let of_vertex = |vertex| around.get(&vertex).into_iter().flatten();
            vertices.flat_map(|vertex| of_vertex(vertex).map(|facet| [*own, *facet])).collect()
        };
        let found: Vec<_> = all.iter().flat_map(neighbours).collect();
        all.extend(found);
    }
    Ok(all.into_iter().collect())
}

instantiate!(pair_search: PairSearch::<D>::of, with_neighbours::<D>);
