//! Stage 3: [`CheckedFunction`] → [`Derived`]: the operators of differentiation are carried out, and
//! residuals and tangents are derived. Nothing of a [`Derived`] holds `Gradient`, `Partial` or `Gateaux`.

mod carried_energy;
mod cell_mean;
mod facet_means;
mod lowering;
mod map_operands;
pub mod rules;
mod sources;
mod summands;

use std::collections::HashMap;

use crate::check::regions::check_sides;
use crate::check::{CheckedFunction, Content, Term};
use crate::diagnostics::Diagnostics;
use crate::parse::syntax::Region;
use crate::tensor::{Arena, FieldInfo, FieldRole, Tensor};
use carried_energy::CarriedEnergy;
use facet_means::FacetMeans;
use lowering::Lowering;
pub use lowering::multi_indices;
pub use map_operands::map_operands;
pub use sources::Source;

/// A function in which all derivatives have been carried out.
pub struct Derived {
    pub function: usize,
    pub dimension: usize,
    pub arena: Arena,
    /// As checked, then (energies) a test function per unknown, the means over own facets and their test functions, then a trial function
    /// per unknown and the directions of the means.
    pub fields: Vec<FieldInfo>,
    /// Additive parts of the residual, with their tangents. Empty for functionals and values.
    pub residual: Vec<ResidualPart>,
    /// Densities of an energy or functional.
    pub density: Vec<Term>,
    /// By density, or part of one, that was asked for as a derivative: the integrands that were differentiated.
    pub sources: HashMap<Tensor, Vec<Source>>,
    /// Regions and displacements of the integrals of an energy whose variation is completed by the motion of their points.
    pub carried: Vec<(usize, Vec<usize>)>,
    /// A derived field.
    pub value: Option<Tensor>,
    /// The residual is the first variation of an energy: its tangent is symmetric (Schwarz).
    pub from_energy: bool,
}

impl Derived {
    /// Whether some integrals read means over own facets.
    pub fn has_facet_means(&self) -> bool {
        self.fields.iter().any(|field| matches!(field.role, FieldRole::Mean(_)))
    }
}

/// One additive part of a residual's density on a region.
pub struct ResidualPart {
    pub term: Term,
    /// Its derivative in the direction of each trial function (field index), where not zero.
    pub tangent: Vec<(usize, Tensor)>,
    /// It is integrated along the motion of its points, which another part holds.
    pub moves: bool,
}

/// Carries out all derivatives of a function.
pub fn differentiate(checked: CheckedFunction, regions: &[Region], diagnostics: &mut Diagnostics) -> Derived {
    let CheckedFunction { function, dimension, arena, mut fields, content } = checked;
    let names = arena.varied_nodes();
    let known = HashMap::new();
    let declared = fields.clone();
    let mut lowering =
        Lowering { arena, dimension, fields: declared, known, names, exhausted: false, diagnostics };
    let unknowns: Vec<(usize, usize)> = fields
        .iter()
        .enumerate()
        .filter_map(|(index, field)| match field.role {
            FieldRole::Unknown(number) => Some((index, number)),
            _ => None,
        })
        .collect();
    let mut density = Vec::new();
    let mut value = None;
    let mut from_energy = false;
    let mut terms = Vec::new();
    let mut carried = CarriedEnergy::default();
    match content {
        Content::Form(form) => {
            terms = form;
            lowering.check_regions(&terms, &fields, regions);
        }
        Content::Functional(functional) => {
            density = functional;
            lowering.check_regions(&density, &fields, regions);
        }
        Content::Value(tensor) => {
            let lowered = lowering.lower(tensor);
            if lowering.has_sides(lowered) {
                check_sides(&lowering.arena, &fields, lowered, None, lowering.diagnostics);
            }
            value = Some(lowered);
        }
        Content::Energy(energy) => {
            lowering.check_regions(&energy, &fields, regions);
            from_energy = true;
            for &(index, number) in &unknowns {
                let name = format!("δ{}", fields[index].name);
                let shape = fields[index].shape.clone();
                fields.push(FieldInfo { name, role: FieldRole::Test(number), shape });
                let test = fields.len() - 1;
                let varied =
                    energy.iter().map(|term| term.with(lowering.gateaux(term.density, index, test, &fields)));
                terms.extend(varied);
                carried.vary((index, test));
            }
            carried.take(&mut lowering, &energy, &fields);
            density = energy;
        }
    }
    let mut means = FacetMeans::default();
    for term in terms.iter().chain(&density).filter(|term| term.means.is_some()) {
        let lowered = lowering.lower(term.density);
        means.collect(&lowering, &fields, term, lowered);
        // Along the motion of points all means of an integrand are read.
        let carried = term.displacement.as_deref().map(|by| lowering.carried(term.density, by, &fields));
        if let Some(Some(carried)) = carried {
            means.collect(&lowering, &fields, term, carried);
        }
    }
    means.add_fields(&mut fields);
    let mut trials = Vec::new();
    for (index, number) in unknowns {
        let name = format!("d{}", fields[index].name);
        let shape = fields[index].shape.clone();
        fields.push(FieldInfo { name, role: FieldRole::Trial(number), shape });
        trials.push((index, fields.len() - 1));
    }
    means.add_directions(&mut fields);
    // The integrals of means first: what reads them depends on the unknowns as they do.
    let mut residual = means.integrals(&mut lowering, &fields, &trials);
    trials.extend(means.varying());
    let mut sources = HashMap::<Tensor, Vec<Source>>::new();
    for term in carried.terms(&mut lowering, &fields) {
        sources.insert(term.density, carried.sources_of(&term));
        residual.push(ResidualPart { term, tangent: vec![], moves: true });
    }
    for term in terms {
        let mut found = if from_energy { carried.sources_of(&term) } else { lowering.sources(term.density) };
        let by = term.displacement.as_deref().filter(|_| !from_energy && !found.is_empty());
        if let Some(density) = by.and_then(|by| lowering.carried(term.density, by, &fields)) {
            found.iter_mut().for_each(|source| source.moves = true);
            let density = means.replace(&mut lowering, &term, density);
            sources.entry(density).or_default().extend(found.iter().cloned());
            let tangent = vec![];
            residual.push(ResidualPart { term: term.with(density), tangent, moves: true });
        }
        let lowered = lowering.lower(term.density);
        let lowered = means.replace(&mut lowering, &term, lowered);
        for part in lowering.parts(lowered) {
            let tangent = lowering.tangent(part, &trials, &fields);
            if !found.is_empty() {
                sources.entry(part).or_default().extend(found.iter().cloned());
            }
            residual.push(ResidualPart { term: term.with(part), tangent, moves: false });
        }
    }
    let density = density
        .into_iter()
        .map(|term| {
            let found = lowering.sources(term.density);
            let density = lowering.lower(term.density);
            let density = means.replace(&mut lowering, &term, density);
            if !found.is_empty() {
                sources.entry(density).or_default().extend(found);
            }
            term.with(density)
        })
        .collect();
    let arena = lowering.arena;
    let carried = carried.keys;
    Derived { function, dimension, arena, fields, residual, density, sources, carried, value, from_energy }
}
