//! Contact pairs as groups: a unit is the points of an own facet that face one opposite facet, an entity with two sides
//! whose points lie elsewhere in both cells than those of the next unit.

use std::collections::HashMap;
use std::sync::Arc;

use forms_core::contract::{Integral, Pairing, Requirements};

use super::dual_functions::{Covers, DualFunctions};
use super::means::FurtherTables;
use super::{Group, GroupSide, OwnPoints, Places};
use crate::assemble::batch::basis_in_lanes::LaneElement;
use crate::assemble::binding::{Binding, Tabulated, pair_error};
use crate::assemble::{Assembler, AssemblyError};
use crate::element::{CellShape, Element};
use crate::field::{Field, FieldView};
use crate::history::PointsOfPairs;
use crate::instantiate::instantiate;
use crate::pairs::{
    Approach, Displacement, DisplacementField, FirstTouch, PairError, PairGroup, PairReport, Pairs,
};
use crate::quadrature::{Quadrature, QuadratureRule, map_to_facet};
use crate::space::Space;

/// The points of a group's units, with the elements that are evaluated there.
pub(in crate::assemble) struct PairTables<const D: usize> {
    pub group: Arc<PairGroup<D>>,
    /// The geometry map on each side.
    pub geometry: [LaneElement; 2],
    /// The binding's elements on each side; of a space on facets, the traces that do not vanish.
    pub elements: [Vec<LaneElement>; 2],
    /// Of each element, the dual functions of the units' covers; none of other elements.
    pub dual: Vec<Option<DualFunctions>>,
}

/// Unknowns whose spaces are all that is needed.
#[inline(never)]
pub(in crate::assemble) fn without_coefficients<'a, const D: usize>(
    spaces: &[&'a Arc<Space<D>>],
) -> Vec<FieldView<'a, D>> {
    spaces.iter().map(|space| FieldView { space, values: &[], finite: true }).collect()
}

/// The groups of a region of contact pairs.
#[inline(never)]
pub(in crate::assemble) fn pair_groups<const D: usize>(
    binding: &Binding<D>,
    integral: &Integral,
    quadrature: &Quadrature<D>,
    degree: usize,
    requirements: &Requirements,
) -> Result<Vec<Group<D>>, AssemblyError> {
    let region = integral.region;
    if let Some(pairing) = &binding.regions[region].pairing {
        let points = PointsOfPairs::of(pairing, integral.displacement.is_some());
        binding.histories_on_pairs(requirements, pairing, points)?;
    }
    if binding.regions[region].is_on_moving_segments(integral.displacement) {
        let refused = |source| Err(pair_error(binding.name, &binding.regions[region], source));
        if requirements.holds_points {
            return refused(PairError::HeldPoints);
        }
        if requirements.varies_energy && D != 2 {
            return refused(PairError::EnergyInSpace);
        }
    }
    binding.check_functions_on_pairs(region, quadrature, degree, requirements)?;
    let pairs = binding.pairs(region, integral.displacement, quadrature, degree)?;
    let region = &binding.regions[region];
    groups_of(binding, &format!("the pairs `{}` ({})", region.symbol, region.name), &pairs, requirements)
}

/// The groups of some pairs.
#[inline(never)]
pub(in crate::assemble) fn groups_of<const D: usize>(
    binding: &Binding<D>,
    place: &str,
    pairs: &Pairs<D>,
    requirements: &Requirements,
) -> Result<Vec<Group<D>>, AssemblyError> {
    let mesh = binding.mesh;
    let form = binding.name;
    // Second derivatives are evaluated in lanes.
    let further = FurtherTables { means: requirements.reads_means(), ..FurtherTables::default() };
    let is_dual = |element: &&Tabulated| {
        let mut elements = pairs.groups.iter().map(|group| &element.elements[group.sides[0].0]);
        element.on_facets && elements.any(Element::is_dual)
    };
    let covers_of =
        |element| Some(element).filter(is_dual).map(|element| Arc::new(Covers::new(pairs, element)));
    let covers: Vec<Option<Arc<Covers>>> = binding.elements.iter().map(covers_of).collect();
    let mut groups = Vec::new();
    // Groups that differ by the number of points have the same tables.
    let mut known: HashMap<(usize, CellShape, u8), GroupSide<D>> = HashMap::new();
    for group in &pairs.groups {
        let group = match binding.owned {
            Some(owned) => Arc::new(group.filtered(|cell| owned.owns(cell))),
            None => Arc::clone(group),
        };
        if group.facets.is_empty() {
            continue;
        }
        let mut sides = Vec::new();
        for (side, (shape, local)) in group.sides.into_iter().enumerate() {
            let failed = |source| AssemblyError::Quadrature { form, source };
            let cells: Vec<u32> = group.facets.iter().map(|facets| facets[side].cell).collect();
            if let Some(known) = known.get(&(side, shape, local)) {
                sides.push(GroupSide { cells, ..known.clone() });
                continue;
            }
            // One point, for what is the same at all of them: Jacobians of affine cells.
            let vertex = QuadratureRule { points: vec![[0.0; 2]], weights: vec![0.0] };
            let rule = map_to_facet::<D>(shape, usize::from(local), &vertex).map_err(failed)?;
            let places = Places { points: rule.points, facet: Some((local, rule.tangents)) };
            let made =
                GroupSide::new(mesh, &binding.elements, (shape, vec![]), &places, further).map_err(failed)?;
            sides.push(GroupSide { cells, ..made.clone() });
            known.insert((side, shape, local), made);
        }
        let in_lanes = |element: &Tabulated, (shape, local): (CellShape, u8), of_cover: bool| {
            let own = &element.elements[shape];
            let facet = (element.on_facets && element.degree > 0).then_some(usize::from(local));
            match facet.filter(|_| of_cover) {
                Some(local) => LaneElement::before_duality(own, &own.facet_nodes(local)),
                None => LaneElement::new(own, facet),
            }
        };
        let [own, opposite] = group.sides;
        let elements = [
            binding
                .elements
                .iter()
                .zip(&covers)
                .map(|(e, cover)| in_lanes(e, own, cover.is_some()))
                .collect(),
            binding.elements.iter().map(|element| in_lanes(element, opposite, false)).collect(),
        ];
        let of_units = |covers: &Option<Arc<Covers>>| {
            covers.as_ref().map(|covers| DualFunctions::of_units(covers, &group))
        };
        let dual = covers.iter().map(of_units).collect();
        let geometry =
            group.sides.map(|(shape, _)| LaneElement::new(&Element::Lagrange(mesh.element_of(shape)), None));
        let weights = vec![0.0; group.count];
        let tables = PairTables { group, geometry, elements, dual };
        groups.push(Group {
            place: place.to_owned(),
            sides,
            weights,
            own: Some(OwnPoints::Pairs(tables)),
            means: None,
        });
    }
    Ok(groups)
}

impl<const D: usize> Assembler<D> {
    /// The pairs of two surfaces in numbers: how many points have an opposite one, how far the surfaces are apart or overlap.
    /// `degree` is that of the rule where the choice of quadrature is the compiler's estimate.
    ///
    /// ```
    /// use forms_fem::prelude::*;
    ///
    /// // Two squares, a tenth apart; the lower one in two cells, the upper one in three.
    /// let mut nodes = vec![];
    /// let mut cells: Vec<u32> = vec![];
    /// for (count, bottom) in [(2, 0.0), (3, 1.1)] {
    ///     let start = nodes.len() as u32;
    ///     for k in 0..=count {
    ///         let x = f64::from(k) / f64::from(count);
    ///         nodes.extend([[x, bottom], [x, bottom + 1.0]]);
    ///     }
    ///     cells.extend((0..count as u32).flat_map(|k| [0, 2, 3, 1].map(|node| start + 2 * k + node)));
    /// }
    /// let mut mesh = Mesh::from_parts(CellShape::Quadrilateral, 1, nodes, cells)?;
    /// mesh.name_facets("below", "boundary", |x| x[1] == 1.0)?;
    /// mesh.name_facets("above", "boundary", |x| x[1] == 1.1)?;
    /// let assembler = Assembler::new(&mesh);
    /// let report = assembler.pairs(&Pairing::onto("below", "above"), 2)?;
    /// // Four pieces with two points each: the facets are cut at the other side's nodes.
    /// assert_eq!((report.points, report.open), (8, 0));
    /// assert!((report.largest_gap - 0.1).abs() < 1e-15 && (report.paired_measure - 1.0).abs() < 1e-15);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A [`PairError`]: unknown surfaces, surfaces that overlap or have no opposite points, a reach that is no length.
    pub fn pairs(&self, pairing: &Pairing, degree: usize) -> Result<PairReport<D>, PairError> {
        Ok(self.pairs_of(pairing, degree)?.report)
    }

    /// The report on pairs with surfaces that a field displaces: open and rejected points, gaps and overlaps of sliding pairs at an iterate.
    ///
    /// # Errors
    /// As [`Assembler::pairs`], and if the field is none on cells of this mesh with as many components as there are dimensions.
    pub fn pairs_at(
        &self,
        pairing: &Pairing,
        degree: usize,
        displacement: &Field<D>,
    ) -> Result<PairReport<D>, PairError> {
        Ok(self.pairs_displaced(pairing, degree, displacement)?.report)
    }

    /// The pairs of surfaces that a field displaces.
    #[inline(never)]
    pub(crate) fn pairs_displaced(
        &self,
        pairing: &Pairing,
        degree: usize,
        displacement: &Field<D>,
    ) -> Result<Arc<Pairs<D>>, PairError> {
        self.check_displacement(displacement)?;
        let (space, values) = (displacement.space(), displacement.values());
        let displacement = Displacement { fields: vec![DisplacementField { space, values }] };
        let Assembler { mesh, quadrature, threads, known_pairs, .. } = self;
        known_pairs.find(mesh, pairing, quadrature, degree, Some(&displacement), *threads)
    }

    pub(in crate::assemble) fn check_displacement(&self, displacement: &Field<D>) -> Result<(), PairError> {
        let space = displacement.space();
        match space.displaces() && space.components() == D && space.mesh().is_same(&self.mesh) {
            true => Ok(()),
            false => Err(PairError::NoDisplacement { field: "displacement" }),
        }
    }

    /// A start in contact, for load control: one body moved rigidly along a direction from a displacement u until the first
    /// quadrature point touches, and on by a small overlap. Surfaces meet along the direction, not along their normals. A body that is
    /// held by nothing but contact has no stiffness before: from here Newton's method goes on, with [`FirstTouch::start`] for its
    /// [start](crate::solve::Problem::start).
    ///
    /// ```
    /// use forms_fem::pairs::Approach;
    /// use forms_fem::prelude::*;
    ///
    /// let slab = rectangle([0.0, 0.0], [3.0, 1.0], [6, 2], CellShape::Quadrilateral, 1)?;
    /// let punch = rectangle([1.0, 1.2], [2.0, 2.2], [3, 3], CellShape::Quadrilateral, 1)?;
    /// let mesh = Mesh::of_bodies(&[("slab", &slab), ("punch", &punch)])?;
    /// let space = Space::vector(&mesh, 1)?;
    /// let pairing = Pairing::between("slab top", "punch bottom");
    /// let down = Approach { moving: "punch".to_owned(), direction: [0.0, -1.0], overlap: 1e-3 };
    /// let touch = Assembler::new(&mesh).first_touch(&pairing, 4, &Field::zero(&space), &down)?;
    /// assert!((touch.distance - 0.2).abs() < 1e-14);
    /// // The punch has gone down by 0.201; the slab stays.
    /// assert!((touch.start.evaluate(&[1.5, 1.7])?[1] + 0.201).abs() < 1e-14);
    /// assert_eq!(touch.start.evaluate(&[1.5, 0.5])?, [0.0, 0.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`Assembler::pairs_at`]; a direction of no length, cells to which both surfaces belong or neither, surfaces that do not
    /// meet.
    pub fn first_touch(
        &self,
        pairing: &Pairing,
        degree: usize,
        u: &Field<D>,
        approach: &Approach<D>,
    ) -> Result<FirstTouch<D>, PairError> {
        self.check_displacement(u)?;
        approach.from(u, &self.mesh, pairing, (&self.quadrature, degree), self.threads)
    }

    /// The pairs, which are searched for at the first call.
    #[inline(never)]
    pub(crate) fn pairs_of(&self, pairing: &Pairing, degree: usize) -> Result<Arc<Pairs<D>>, PairError> {
        self.known_pairs.find(&self.mesh, pairing, &self.quadrature, degree, None, self.threads)
    }
}

instantiate!(pair_groups: without_coefficients::<D>, groups_of::<D>, Assembler::<D>::pairs_of);
