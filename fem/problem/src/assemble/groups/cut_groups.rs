//! Pieces as groups: parts of cut cells inside a body, parts of its interface, and parts of exterior facets. Entities with nearly equal numbers
//! of points make a group.

use forms_core::contract::{Integral, Requirements};

use super::degrees::Estimate;
use super::means::FurtherTables;
use super::piece_entries::{Entries, add_entry};
use super::{Group, GroupSide, OwnPoints, Places};
use crate::assemble::AssemblyError;
use crate::assemble::batch::basis_in_lanes::LaneElement;
use crate::assemble::binding::Binding;
use crate::assemble::binding::entities::Entities;
use crate::cut::heights::{CellPolynomial, FacetPart, LineRules};
use crate::cut::known_points::{PieceRule, PointsOn};
use crate::cut::number::{VARIED, Varied};
use crate::cut::{Cut, CutError, CutSide, GHOST, VertexValues};
use crate::element::{CellShape, Element};
use crate::instantiate::instantiate;
use crate::mesh::Facet;
use crate::quadrature::{
    Quadrature, QuadratureError, QuadratureRule, cell_rule, facet_reference_rule, map_to_facet,
};

/// Location of a group's pieces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::assemble) enum PieceKind {
    Cell,
    Facet,
    Interface,
}

impl PieceKind {
    /// Numbers per point.
    #[inline(always)]
    fn stride<const D: usize>(self) -> usize {
        match self {
            PieceKind::Cell | PieceKind::Facet => D + 1,
            PieceKind::Interface => 2 * D + 1,
        }
    }
}

/// The points of a group's pieces, with the elements that are evaluated there.
pub(in crate::assemble) struct CutTables<const D: usize> {
    pub kind: PieceKind,
    /// The rule on each piece, where a level set function cuts.
    rule: Option<PieceRule<D>>,
    /// Points of each entity.
    pub count: usize,
    /// Of each entity and point: reference coordinates in the cell, the weight in these coordinates or on the facet's own reference
    /// cell, and of an interface its unit normal in reference coordinates.
    pub points: Vec<f64>,
    pub geometry: LaneElement,
    /// The binding's elements; of a space on facets, the traces that do not vanish.
    pub elements: Vec<LaneElement>,
}

impl<const D: usize> CutTables<D> {
    /// Numbers per point.
    #[inline(always)]
    pub fn stride(&self) -> usize {
        self.kind.stride::<D>()
    }

    pub fn is_interface(&self) -> bool {
        self.kind == PieceKind::Interface
    }

    /// The derivatives of an entity's integral by the level set function's values at the nodes of its cell, from its slopes by all numbers
    /// of its points.
    pub fn by_nodal_values(
        &self,
        (cut, side): (&Cut<D>, &GroupSide<D>),
        entity: usize,
        slopes: &[f64],
        points: &mut Vec<Varied>,
        derivatives: &mut Vec<f64>,
    ) {
        let cell = side.cells[entity];
        let nodes = cut.level_nodes(cell).len();
        for first in (0..nodes).step_by(VARIED) {
            points.clear();
            self.vary((cut, side), cell, first, points);
            let mut sums = [0.0; VARIED];
            for (slope, number) in slopes.iter().zip(&*points) {
                sums.iter_mut().zip(number.slopes).for_each(|(sum, rate)| *sum += slope * rate);
            }
            // What no rule moves must not pass for something that is held.
            let known = if points.is_empty() { f64::NAN } else { 1.0 };
            derivatives.extend(sums.iter().take(nodes - first).map(|sum| known * sum));
        }
    }

    /// The points of a cell with their derivatives by the values at its nodes from one on.
    fn vary(&self, (cut, side): (&Cut<D>, &GroupSide<D>), cell: u32, first: usize, points: &mut Vec<Varied>) {
        let is_by_heights = cut.is_by_heights(side.shape);
        let polynomial = || CellPolynomial::varied_from(cut, cell, first);
        let values = || VertexValues::new(cut, cell);
        match (&self.rule, self.kind, side.facet.map(|(local, _)| local)) {
            (Some(PieceRule::Lines(rules)), PieceKind::Cell, _) => {
                polynomial().points_inside::<D>(rules, points);
            }
            (Some(PieceRule::Lines(rules)), PieceKind::Interface, _) => {
                polynomial().points_of_interface::<D>(rules, points);
            }
            (Some(PieceRule::Lines(rules)), PieceKind::Facet, Some(local)) => {
                polynomial().points_on_face::<D>(local, rules, points);
            }
            (Some(PieceRule::Facets(rule)), PieceKind::Facet, Some(local)) if is_by_heights => {
                polynomial().points_on_edge::<D>(local, rule, points);
            }
            (Some(PieceRule::Cells(rule)), PieceKind::Cell, _) => values().points_inside(rule, points),
            (Some(PieceRule::Facets(rule)), PieceKind::Interface, _) => {
                values().points_of_interface::<D>(rule, points);
            }
            (Some(PieceRule::Facets(rule)), PieceKind::Facet, Some(local)) => {
                values().points_on_facet::<D>(local, rule, points);
            }
            _ => {}
        }
    }

    /// The points of an entity in the cell's reference coordinates.
    pub fn points_of(&self, entity: usize) -> impl Iterator<Item = [f64; D]> {
        let length = self.count * self.stride();
        let own = self.points[entity * length..][..length].chunks(self.stride());
        own.map(|point| std::array::from_fn(|k| point[k]))
    }
}

/// Refusal of integrals that a cut mesh does not have.
///
/// # Errors
/// [`AssemblyError::Cut`].
pub(in crate::assemble) fn refusals<const D: usize>(
    binding: &Binding<D>,
    place: &str,
    cut: &Cut<D>,
    (quadrature, reads_history): (&Quadrature<D>, bool),
) -> Result<(), AssemblyError> {
    let refused = |what| Err(CutError::Refused { what });
    let found = match quadrature {
        _ if !cut.mesh().is_same(binding.mesh) => Err(CutError::OtherMesh),
        _ if reads_history => refused("a history"),
        Quadrature::Split { .. } => refused("a rule with split facets"),
        _ => Ok(()),
    };
    found.map_err(|source| AssemblyError::Cut { form: binding.name, place: place.to_owned(), source })
}

/// The rule on the pieces of a shape's cells, for a degree in each direction of those that are no simplices.
fn rule_on_pieces<const D: usize>(
    cut: &Cut<D>,
    kind: PieceKind,
    (shape, degree): (CellShape, usize),
) -> Result<PieceRule<D>, QuadratureError> {
    let total = if shape.is_simplex() { degree } else { D * degree };
    let simplex = if D == 2 { CellShape::Triangle } else { CellShape::Tetrahedron };
    match kind {
        _ if cut.is_by_heights(shape) => LineRules::new(degree, D, cut.degree()).map(PieceRule::Lines),
        PieceKind::Cell => cell_rule(simplex, total).map(PieceRule::Cells),
        _ => facet_reference_rule(simplex, total).map(PieceRule::Facets),
    }
}

/// The parts of cells inside; `shape` is that of all of them.
#[inline(never)]
pub(in crate::assemble) fn inside_of_cells<const D: usize>(
    binding: &Binding<D>,
    place: &str,
    (cut, cells): (&Cut<D>, &[u32]),
    (shape, quadrature, degree): (CellShape, &Quadrature<D>, usize),
    requirements: &Requirements,
) -> Result<Vec<Group<D>>, AssemblyError> {
    if cells.is_empty() {
        return Ok(vec![]);
    }
    let form = binding.name;
    let refused = |source| AssemblyError::Cut { form, place: place.to_owned(), source };
    let degree = quadrature.degree(degree).ok_or(CutError::ExplicitPoints).map_err(refused)?;
    let rule = rule_on_pieces(cut, PieceKind::Cell, (shape, degree))
        .map_err(|source| AssemblyError::Quadrature { form, source })?;
    let points = cut.points(PointsOn::Inside(shape, degree), &rule, binding.threads());
    let mut entries = Entries::new();
    for cell in cells {
        add_entry(&mut entries, (shape, None), *cell, D + 1, points.of(*cell));
    }
    groups_of_pieces(binding, place, (PieceKind::Cell, Some(rule)), entries, requirements)
}

/// The parts of the interface in the cells of a region.
#[inline(never)]
pub(in crate::assemble) fn interface_groups<const D: usize>(
    binding: &Binding<D>,
    integral: &Integral,
    quadrature: &Quadrature<D>,
    estimate: &Estimate,
    requirements: &Requirements,
) -> Result<Vec<Group<D>>, AssemblyError> {
    let (form, mesh, region) = (binding.name, binding.mesh, &binding.regions[integral.region]);
    let place = format!("the interface `{}` (\"{}\")", region.symbol, region.name);
    let refused = |source| AssemblyError::Cut { form, place: place.clone(), source };
    let Some(cut) = binding.cut else { return Err(refused(CutError::NoCut)) };
    let Entities::Cells(cells) = binding.entities(integral.region)? else { return Ok(vec![]) };
    let crossed: Vec<u32> =
        cells.iter().copied().filter(|cell| cut.side_of_cell(*cell) == CutSide::Cut).collect();
    let mut groups = Vec::new();
    for (shape, cells) in mesh.by_shape(mesh.walk_of_cells(&crossed)) {
        if requirements.curvature && cut.is_by_heights(shape) {
            let what = "the curvature of an interface in hexahedra, or of a function of degree 2,";
            return Err(refused(CutError::Refused { what }));
        }
        let degree = quadrature.degree(estimate.on_interface(mesh, shape));
        let degree = degree.ok_or(CutError::ExplicitPoints).map_err(refused)?;
        let rule = rule_on_pieces(cut, PieceKind::Interface, (shape, degree))
            .map_err(|source| AssemblyError::Quadrature { form, source })?;
        let points = cut.points(PointsOn::Interface(shape, degree), &rule, binding.threads());
        let mut entries = Entries::new();
        for cell in cells {
            add_entry(&mut entries, (shape, None), cell, 2 * D + 1, points.of(cell));
        }
        let kind = (PieceKind::Interface, Some(rule));
        groups.extend(groups_of_pieces(binding, &place, kind, entries, requirements)?);
    }
    Ok(groups)
}

/// An interior facet that an interface crosses, with its part inside.
type ClippedBetween = ([Facet; 2], FacetPart);

/// Interior facets that are taken whole, as all of a ghost penalty are, and those that an interface crosses, with their parts inside.
pub(in crate::assemble) fn clipped_between<'a, const D: usize>(
    binding: &Binding<D>,
    name: &str,
    facets: Entities<'a>,
) -> (Entities<'a>, Vec<ClippedBetween>) {
    let (Some(cut), Entities::InteriorFacets(listed)) = (binding.cut, &facets) else {
        return (facets, vec![]);
    };
    if name == GHOST {
        return (facets, vec![]);
    }
    let (mut whole, mut clipped) = (vec![], vec![]);
    for sides in &**listed {
        match cut.part_of_facet(sides[0]) {
            None => whole.push(*sides),
            Some(part) => clipped.push((*sides, part)),
        }
    }
    (Entities::InteriorFacets(whole.into()), clipped)
}

/// Facets with their parts on their own reference cell.
#[inline(never)]
pub(in crate::assemble) fn clipped_facets<const D: usize>(
    binding: &Binding<D>,
    place: &str,
    facets: &[(Facet, FacetPart)],
    (quadrature, degree): (&Quadrature<D>, usize),
    requirements: &Requirements,
) -> Result<Vec<Group<D>>, AssemblyError> {
    let (mesh, form) = (binding.mesh, binding.name);
    let failed = |source| AssemblyError::Quadrature { form, source };
    let mut walk: Vec<(u32, usize)> =
        facets.iter().enumerate().map(|(index, (facet, _))| (mesh.walk_of_facet(&[*facet]), index)).collect();
    walk.sort_unstable();
    let (mut entries, mut own) = (Entries::new(), Vec::new());
    for (facet, part) in walk.into_iter().map(|(_, index)| &facets[index]) {
        let shape = mesh.cell_shape(facet.cell as usize);
        let rule = part.rule(quadrature, mesh.shape_of_facets(), degree).map_err(failed)?;
        let rule = map_to_facet::<D>(shape, usize::from(facet.local), &rule).map_err(failed)?;
        own.clear();
        for (point, weight) in rule.points.iter().zip(&rule.weights) {
            own.extend_from_slice(point);
            own.push(*weight);
        }
        add_entry(&mut entries, (shape, Some(facet.local)), facet.cell, D + 1, &own);
    }
    let rule = match binding.cut {
        None => None,
        Some(cut) if mesh.shape_of_facets() == CellShape::Hexahedron => {
            // Explicit points were refused above.
            let degree = quadrature.degree(degree).unwrap_or(degree);
            Some(PieceRule::Lines(LineRules::new(degree, 2, cut.degree()).map_err(failed)?))
        }
        Some(_) => {
            let rule = quadrature.facet_reference_rule(mesh.shape_of_facets(), degree).map_err(failed)?;
            Some(PieceRule::Facets(rule))
        }
    };
    groups_of_pieces(binding, place, (PieceKind::Facet, rule), entries, requirements)
}

/// The groups of some pieces.
fn groups_of_pieces<const D: usize>(
    binding: &Binding<D>,
    place: &str,
    (kind, rule): (PieceKind, Option<PieceRule<D>>),
    entries: Entries,
    requirements: &Requirements,
) -> Result<Vec<Group<D>>, AssemblyError> {
    let (mesh, form) = (binding.mesh, binding.name);
    let failed = |source| AssemblyError::Quadrature { form, source };
    // Second derivatives are evaluated in lanes, means over whole cells as everywhere.
    let further = FurtherTables { means: requirements.reads_means(), ..FurtherTables::default() };
    let mut groups = Vec::new();
    let stride = kind.stride::<D>();
    let grouped = entries.into_iter().flat_map(|(key, entry)| {
        entry.grouped::<D>(stride).into_iter().map(move |(count, cells, points)| (key, count, cells, points))
    });
    for ((shape, local), count, cells, points) in grouped {
        // One point, for what is the same at all of them: Jacobians of affine cells.
        let places = match local {
            None => Places { points: vec![shape.centre()], facet: None },
            Some(local) => {
                let vertex = QuadratureRule { points: vec![[0.0; 2]], weights: vec![0.0] };
                let rule = map_to_facet::<D>(shape, usize::from(local), &vertex).map_err(failed)?;
                Places { points: rule.points, facet: Some((local, rule.tangents)) }
            }
        };
        let mut side =
            GroupSide::new(mesh, &binding.elements, (shape, cells), &places, further).map_err(failed)?;
        // These points are no grid.
        side.products.fill_with(|| None);
        let elements = binding.elements.iter().map(|element| {
            let own = &element.elements[shape];
            match (element.on_facets && element.degree > 0, local) {
                (true, Some(local)) => LaneElement::new(own, Some(usize::from(local))),
                (true, None) => LaneElement::without_functions(),
                (false, _) => LaneElement::new(own, None),
            }
        });
        let geometry = LaneElement::new(&Element::Lagrange(mesh.element_of(shape)), None);
        let elements = elements.collect();
        let own = CutTables { kind, rule: rule.clone(), count, points, geometry, elements };
        groups.push(Group {
            place: place.to_owned(),
            sides: vec![side],
            weights: vec![0.0; count],
            own: Some(OwnPoints::Cut(own)),
            means: None,
        });
    }
    Ok(groups)
}

impl<const D: usize> Cut<D> {
    /// Cells that are whole, and those that are cut; others are left out.
    pub(in crate::assemble) fn whole_cells(&self, cells: Vec<u32>) -> (Vec<u32>, Vec<u32>) {
        let active = cells.into_iter().filter(|cell| self.side_of_cell(*cell) != CutSide::Outside);
        active.partition(|cell| self.side_of_cell(*cell) == CutSide::Inside)
    }
}

instantiate!(cut_groups: inside_of_cells::<D>, interface_groups::<D>, clipped_facets::<D>);
