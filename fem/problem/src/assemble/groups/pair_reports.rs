//! The contact pairs of a form in numbers, at given unknowns, and the motion of surfaces from one displacement to another.

use std::fmt;
use std::sync::Arc;

use forms_core::contract::{Entity, FieldDescription, Integral, Pairing, Requirements, Role};

use super::degrees::Estimate;
use crate::assemble::binding::Binding;
use crate::assemble::{Assembler, AssemblyError};
use crate::contract::Function;
use crate::field::{Field, FieldView};
use crate::instantiate::instantiate;
use crate::mesh::TAKE_THE_WHOLE;
use crate::pairs::{FollowedMotion, Follower, PairError, PairReport, Pairs};
use crate::quadrature::Quadrature;
use crate::space::Space;

/// The contact pairs of a form's region in numbers. It displays as a sentence about points without a partner.
#[derive(Clone, Debug, PartialEq)]
pub struct RegionPairs<const D: usize> {
    /// The region's name in the form.
    pub symbol: &'static str,
    /// Its surfaces.
    pub surfaces: String,
    /// Whether an unknown or another field displaces them.
    pub displaced: bool,
    /// The numbers; of several rules those of the first integral.
    pub report: PairReport<D>,
    /// The degree of the rule where it is the compiler's estimate; of several integrals that of the first.
    pub estimated_degree: Option<usize>,
    /// The own and the opposite surface where none of the own one's points has an opposite point.
    pub unpaired: Vec<[String; 2]>,
}

/// An estimated degree above this is that of no polynomial: products of normals, gaps and projections on curved or displaced facets.
const HIGH_ESTIMATE: usize = 20;

impl<const D: usize> RegionPairs<D> {
    /// A note on a rule of many points that the user did not choose: integrands with rays and normals are no polynomials, and their estimated degree
    /// says little.
    pub fn note_on_quadrature(&self) -> Option<String> {
        let degree = self.estimated_degree.filter(|degree| *degree > HIGH_ESTIMATE)?;
        Some(format!(
            "`{}`: the rule has degree {degree}, an estimate for what is no polynomial; a chosen one costs less: \
             `assembler.with_quadrature(Quadrature::Degree(..))`",
            self.symbol
        ))
    }

    /// A note on pairs of surfaces without opposite points, if there are any: no contact is possible between them.
    pub fn note(&self) -> Option<String> {
        if self.unpaired.is_empty() {
            return None;
        }
        let faces = |[own, opposite]: &[String; 2]| format!("no point of \"{own}\" faces \"{opposite}\"");
        let told: Vec<String> = self.unpaired.iter().map(faces).collect();
        let met = match self.report.rejected {
            0 => String::new(),
            met => format!(" ({met} points met a surface from behind or beyond the reach)"),
        };
        Some(format!(
            "`{}`: {} within reach, so that nothing touches there{met}",
            self.symbol,
            told.join(", ")
        ))
    }
}

impl<const D: usize> fmt::Display for RegionPairs<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let PairReport { points, open, rejected, deepest_overlap, deepest_at, .. } = &self.report;
        let all = points + open;
        write!(f, "{open} of {all} points of `{}` ({}) have no opposite point", self.symbol, self.surfaces)?;
        if *rejected > 0 {
            write!(f, ", {rejected} of them with a surface behind them or beyond the reach")?;
        }
        match deepest_at {
            Some(at) => write!(f, "; the deepest overlap is {deepest_overlap:e} at {at:?}"),
            None => write!(f, "; nothing overlaps"),
        }
    }
}

/// The pairs of a form's region on surfaces that the same fields displace, and how they were found.
#[doc(hidden)]
pub struct FoundPairs<const D: usize> {
    /// The region's number.
    region: usize,
    /// The fields that displace the surfaces.
    displacement: Option<&'static [usize]>,
    pairing: Option<Pairing>,
    /// The rule's.
    degree: usize,
    pub pairs: Arc<Pairs<D>>,
    pub report: RegionPairs<D>,
}

impl<const D: usize> FoundPairs<D> {
    /// The number of the unknown that displaces the surfaces by itself.
    pub fn displacing_unknown(&self, fields: &[FieldDescription]) -> Option<usize> {
        let &[field] = self.displacement? else { return None };
        match fields[field].role {
            Role::Unknown(number) => Some(number),
            _ => None,
        }
    }
}

struct PairReports<'a, 'b, const D: usize> {
    assembler: &'a Assembler<D>,
    binding: &'a Binding<'b, D>,
    degrees: Vec<usize>,
    found: Vec<FoundPairs<D>>,
}

impl<const D: usize> PairReports<'_, '_, D> {
    /// The pairs of an integral, if it is the first of its region and displacement.
    #[inline(never)]
    fn add(&mut self, integral: &Integral, requirements: &Requirements) -> Result<(), AssemblyError> {
        let (number, displacement) = (integral.region, integral.displacement);
        let region = &self.binding.regions[number];
        let is_known =
            self.found.iter().any(|known| (known.region, known.displacement) == (number, displacement));
        if region.entity != Entity::Pairs || is_known {
            return Ok(());
        }
        let quadrature = &self.assembler.quadrature;
        let of_history = self.binding.history_degree(requirements, quadrature)?.map(|(_, degree)| degree);
        let estimate = Estimate { integrand: &integral.degree, fields: &self.degrees, of_history };
        let degree = estimate.on_pairs(self.binding.mesh, region.pairing.as_ref());
        let is_estimated = of_history.is_none() && matches!(quadrature, Quadrature::Estimated);
        let pairs = self.binding.pairs(number, displacement, &self.assembler.quadrature, degree)?;
        let report = RegionPairs {
            symbol: region.symbol,
            surfaces: region.name.clone(),
            displaced: displacement.is_some(),
            report: pairs.report,
            estimated_degree: is_estimated.then_some(degree),
            unpaired: match &region.pairing {
                Some(pairing) => pairs
                    .unpaired
                    .iter()
                    .map(|number| &pairing.surfaces[*number])
                    .map(|facing| [facing.own.clone(), facing.opposite.clone()])
                    .collect(),
                None => vec![],
            },
        };
        let pairing = region.pairing.clone();
        self.found.push(FoundPairs { region: number, displacement, pairing, degree, pairs, report });
        Ok(())
    }
}

instantiate!(
    pair_reports: PairReports::<D>::add,
    Assembler::<D>::follow,
    Assembler::<D>::follow_found,
    Assembler::<D>::pairs_of_form,
);

impl<const D: usize> Assembler<D> {
    /// The contact pairs of a form at some unknowns, in the order of its integrals. Pairs that were assembled on are not searched
    /// for again.
    ///
    /// # Errors
    /// Those of the search for contact pairs.
    #[doc(hidden)]
    #[inline(never)]
    pub fn pairs_of_form(
        &self,
        form: &Function<D>,
        unknowns: &[FieldView<D>],
        tests: &[&Arc<Space<D>>],
    ) -> Result<Vec<FoundPairs<D>>, AssemblyError> {
        if form.inputs().regions.iter().all(|region| region.entity != Entity::Pairs) {
            return Ok(vec![]);
        }
        let binding = self.bind(form, unknowns)?;
        let degrees = binding.degrees(tests);
        let mut reports = PairReports { assembler: self, binding: &binding, degrees, found: vec![] };
        for term in form.residual() {
            reports.add(term.integral, term.kernel.constants().requirements)?;
        }
        Ok(reports.found)
    }

    /// Follows the motion of the surfaces of some found pairs, which one unknown displaces, from one state of all unknowns to
    /// another ([`Assembler::follow`]). Surfaces that other fields displace do not move in a step.
    #[inline(never)]
    pub(crate) fn follow_found(
        &self,
        form: &'static str,
        fields: &[FieldDescription],
        found: &[FoundPairs<D>],
        (before, after): (&[FieldView<D>], &[FieldView<D>]),
    ) -> Result<(), AssemblyError> {
        for pairs in found {
            let found = pairs.pairing.as_ref().zip(pairs.displacing_unknown(fields));
            let Some((pairing, unknown)) = found else { continue };
            let ends = [before, after].map(|state| (&**state[unknown].space, state[unknown].values));
            self.follower(pairing, pairs.degree).follow(ends[0].0, [ends[0].1, ends[1].1]).map_err(
                |source| {
                    let RegionPairs { symbol, surfaces, .. } = &pairs.report;
                    AssemblyError::Pairs { form, symbol, pairing: surfaces.clone(), source }
                },
            )?;
        }
        Ok(())
    }

    fn follower<'a>(&'a self, pairing: &'a Pairing, degree: usize) -> Follower<'a, D> {
        let Assembler { mesh, quadrature, threads, known_pairs, .. } = self;
        Follower { mesh, pairing, quadrature, degree, known: known_pairs, threads: *threads }
    }

    /// The motion of a pairing's surfaces from one displacement to another, straight from one to the other, if no point of them passes
    /// through the opposite body. Newton's method knows the end of a step alone: a body that was thrown through another is in
    /// balance, untouched. [`Problem::increment`](crate::solve::Problem::increment) asks for it, so that
    /// [`LoadSteps::advance`](crate::solve::LoadSteps::advance) halves a step that may have done so; others ask for it themselves.
    ///
    /// A point may lie behind the opposite surface by half of what contact can see there, which is the smaller of its reach and
    /// the opposite body's thickness. Rigid surfaces have no thickness.
    ///
    /// # Errors
    /// As [`Assembler::pairs_at`]; [`PairError::Tunnelling`] with the point, [`PairError::TooFar`] where surfaces move too far to be
    /// followed; displacements in different spaces.
    pub fn follow(
        &self,
        pairing: &Pairing,
        degree: usize,
        before: &Field<D>,
        after: &Field<D>,
    ) -> Result<FollowedMotion<D>, PairError> {
        let whole = self.mesh.without_pieces("the motion of surfaces between two states", TAKE_THE_WHOLE);
        whole.map_err(|source| PairError::Surface { source })?;
        self.check_displacement(before)?;
        self.check_displacement(after)?;
        if !Arc::ptr_eq(before.space(), after.space()) {
            return Err(PairError::TwoSpaces);
        }
        self.follower(pairing, degree).follow(after.space(), [before.values(), after.values()])
    }
}
