//! The order in which a region is walked: groups of entities that share tables, each along the mesh's cell order.
//! Cells group by their shape, facets by that and by their local number, because their points lie elsewhere in the reference cell; interior
//! facets also by their local number on the other side, and by how the two sides are turned.

pub(super) mod cut_groups;
pub(super) mod degrees;
pub(super) mod dual_functions;
pub(super) mod facet_groups;
pub(super) mod means;
pub(super) mod own_facets;
pub(super) mod pair_groups;
pub(super) mod pair_reports;
pub(super) mod pair_search;
mod piece_entries;
pub(super) mod positive_parts;
pub(super) mod shared_facets;
pub(super) mod split_facets;

use forms_core::contract::{Entity, FieldSlot, Integral, Order, RegionRule, Requirements, Role, Side};

use self::cut_groups::{
    CutTables, clipped_between, clipped_facets, inside_of_cells, interface_groups, refusals,
};
use self::degrees::{Estimate, cells_by_degree, facets_by_degree};
use self::facet_groups::facet_groups;
use self::means::{FurtherTables, MeanTables};
use self::own_facets::{UnitMeans, groups_with_means};
use self::pair_groups::{PairTables, pair_groups};
use super::AssemblyError;
use super::binding::{Binding, Tabulated, notices};
use crate::assemble::binding::entities::Entities;
use crate::assemble::element_loops::sum_factorisation::ProductTables;
use crate::cut::heights::FacetPart;
use crate::element::{CellShape, Element, Tables};
use crate::instantiate::instantiate;
use crate::mesh::{Facet, Mesh};
use crate::quadrature::{
    Quadrature, QuadratureError, QuadratureRule, cell_rule, facet_node_rule, facet_rule,
};
use crate::space::{Scope, Space};

/// Entities with the same points in the reference cell.
pub(super) struct Group<const D: usize> {
    /// The place, for messages.
    pub place: String,
    /// One side of cells and exterior facets, two of interior ones. Entry k of both sides' cells is one facet.
    pub sides: Vec<GroupSide<D>>,
    pub weights: Vec<f64>,
    /// Points that differ from entity to entity; the sides' tables are at one point then, and the weights count points only.
    pub own: Option<OwnPoints<D>>,
    /// Means over own facets, of integrals of `means(..)`.
    pub means: Option<UnitMeans>,
}

/// Points that differ from entity to entity.
pub(super) enum OwnPoints<const D: usize> {
    /// Those of contact pairs, on two sides.
    Pairs(PairTables<D>),
    /// Those of pieces of cells, of facets or of an interface.
    Cut(CutTables<D>),
}

/// The cells on one side of a group's facets, or a group's cells, with their tables.
#[derive(Clone)]
pub(super) struct GroupSide<const D: usize> {
    /// Cells, or the cells that own the facets.
    pub cells: Vec<u32>,
    /// Their shape.
    pub shape: CellShape,
    /// Local facet number and reference tangents; `None` inside cells.
    pub facet: Option<(u8, [[f64; D]; 2])>,
    /// The geometry map's basis.
    pub geometry: Tables<D>,
    /// One table per element of the binding; of a space on facets, the traces that do not vanish.
    pub elements: Vec<Tables<D>>,
    /// The same as products of functions along the axes, where they are, inside cells.
    pub products: Vec<Option<ProductTables>>,
    /// Second derivatives of the geometry map's basis along the facet's tangents, for the curvature:
    /// [t₀t₀, t₀t₁, t₁t₁] at `q * nodes + i`.
    pub bending: Vec<[f64; 3]>,
    /// The points, where an element has values at points only.
    pub points: Vec<[f64; D]>,
    /// The geometry map's basis at the centre of the reference cell, where an element has functions of the position.
    pub centre: Option<Tables<D>>,
    /// For |T| and |F|: a rule that is exact for the measure of every cell of the mesh.
    pub measure: Measure<D>,
    /// For means over whole cells, where a kernel reads them.
    pub means: Option<MeanTables<D>>,
}

/// Tables that integrate 1 over a cell and a facet.
#[derive(Clone)]
pub(super) struct Measure<const D: usize> {
    pub cell: Tables<D>,
    pub cell_weights: Vec<f64>,
    pub facet: Option<(Tables<D>, Vec<f64>)>,
}

/// Points in a reference cell, and the facet that they are on.
pub(super) struct Places<const D: usize> {
    pub points: Vec<[f64; D]>,
    pub facet: Option<(u8, [[f64; D]; 2])>,
}

impl FurtherTables {
    /// The tables that a kernel reads.
    pub fn of(requirements: &Requirements) -> Self {
        let is_second = |slot: &FieldSlot| slot.order == Order::Hessian;
        let hessians = requirements.hessian || requirements.fields.iter().any(is_second);
        FurtherTables { hessians, means: requirements.reads_means(), coefficients: false }
    }
}

impl<const D: usize> Group<D> {
    /// A group of cells of one shape; weights may be of any kind.
    ///
    /// # Errors
    /// An element that is not known on the shape.
    #[inline(never)]
    pub fn new(
        binding: &Binding<D>,
        place: String,
        (shape, cells): (CellShape, Vec<u32>),
        places: &Places<D>,
        weights: Vec<f64>,
        further: FurtherTables,
    ) -> Result<Self, QuadratureError> {
        let side = GroupSide::new(binding.mesh, &binding.elements, (shape, cells), places, further)?;
        Ok(Group { place, sides: vec![side], weights, own: None, means: None })
    }

    pub fn points(&self) -> usize {
        self.weights.len()
    }

    /// The points of contact pairs, if it consists of these.
    pub fn pairs(&self) -> Option<&PairTables<D>> {
        match &self.own {
            Some(OwnPoints::Pairs(pairs)) => Some(pairs),
            _ => None,
        }
    }

    /// Whether its points are those of an interface inside cells.
    pub fn is_on_interface(&self) -> bool {
        matches!(&self.own, Some(OwnPoints::Cut(cut)) if cut.is_interface())
    }

    /// Number of cells or facets.
    pub fn entities(&self) -> usize {
        self.sides[0].cells.len()
    }

    /// Whether the Jacobians of its cells are constant, on all sides.
    pub fn is_affine(&self, mesh: &Mesh<D>) -> bool {
        self.sides.iter().all(|side| mesh.is_affine_on(side.shape))
    }

    /// The index of a side.
    ///
    /// # Errors
    /// [`AssemblyError::NeedsInteriorFacet`] where there is no other side.
    pub fn side(&self, form: &'static str, side: Side) -> Result<usize, AssemblyError> {
        match side {
            Side::This => Ok(0),
            Side::Other if self.sides.len() == 2 => Ok(1),
            Side::Other => Err(AssemblyError::NeedsInteriorFacet { form, place: self.place.clone() }),
        }
    }

    /// Check that a space on facets has nodes on all of this; of contact pairs, on one side.
    ///
    /// # Errors
    /// [`AssemblyError`]: a facet where the space has no nodes.
    #[inline(never)]
    pub fn check_support(
        &self,
        form: &'static str,
        field: &'static str,
        space: &Space<D>,
        side: usize,
    ) -> Result<(), AssemblyError> {
        let Some(region) = space.facet_region() else {
            let known = &self.sides[side];
            let at_points = space.element_of(known.shape).is_at_points();
            let inside = known.facet.is_none() && self.own.is_none();
            if at_points && !(inside && space.element_of(known.shape).node_points::<D>() == known.points) {
                let (place, elements) = (self.place.clone(), space.elements().clone());
                return Err(AssemblyError::OffItsPoints { form, field, place, elements });
            }
            return self.check_cells(form, field, space, side);
        };
        let side = &self.sides[if self.pairs().is_some() { side } else { 0 }];
        let local = side.facet.map(|(local, _)| local);
        if side.cells.iter().all(|cell| !space.nodes_at(*cell, local).is_empty()) {
            return Ok(());
        }
        let (place, region) = (self.place.clone(), region.to_owned());
        Err(AssemblyError::OffItsFacets { form, field, place, region })
    }
}

impl<const D: usize> Group<D> {
    /// Checks that a space that is limited to some cells has nodes on all of a side.
    fn check_cells(
        &self,
        form: &'static str,
        field: &'static str,
        space: &Space<D>,
        side: usize,
    ) -> Result<(), AssemblyError> {
        let cells = &self.sides[side].cells;
        let scope = space.scope();
        if !matches!(scope, Scope::Within(..))
            || cells.iter().all(|cell| !space.cell_nodes(*cell as usize).is_empty())
        {
            return Ok(());
        }
        Err(AssemblyError::OffItsCells { form, field, place: self.place.clone(), scope: scope.clone() })
    }
}

impl<const D: usize> GroupSide<D> {
    /// The degree of the rule for |F|: more than the Jacobian's determinant has in each direction, as a curved facet's area is no
    /// integral of a polynomial.
    pub fn degree_of_areas(mesh: &Mesh<D>) -> usize {
        D * mesh.degree() + 6
    }

    pub fn new(
        mesh: &Mesh<D>,
        elements: &[Tabulated],
        (shape, cells): (CellShape, Vec<u32>),
        places: &Places<D>,
        further: FurtherTables,
    ) -> Result<Self, QuadratureError> {
        let FurtherTables { hessians, means, .. } = further;
        let geometry = mesh.element_of(shape);
        let Places { points, facet } = places;
        // The Jacobian's determinant has at most this degree in each direction.
        let exact = D * mesh.degree();
        let rule = cell_rule::<D>(shape, exact)?;
        let facet_measure = match facet {
            Some((local, _)) => {
                let rule = facet_rule::<D>(shape, usize::from(*local), Self::degree_of_areas(mesh))?;
                Some((geometry.tabulate(&rule.points), rule.weights))
            }
            None => None,
        };
        let curved = facet.filter(|_| !mesh.has_affine_facets());
        let map = if hessians || curved.is_some() {
            geometry.tabulate_with_hessians(points)
        } else {
            geometry.tabulate(points)
        };
        let bending = match curved {
            Some((_, tangents)) => map.hessian.iter().map(|second| bending(second, &tangents)).collect(),
            None => vec![],
        };
        let local = facet.map(|(local, _)| local);
        Ok(GroupSide {
            cells,
            shape,
            facet: *facet,
            geometry: map,
            elements: elements
                .iter()
                .map(|element| element.tabulate(shape, points, local, further))
                .collect(),
            products: elements.iter().map(|element| element.products(shape, places)).collect(),
            bending,
            points: match elements.iter().any(|element| element.elements[shape].is_at_points()) {
                true => points.clone(),
                false => vec![],
            },
            centre: elements
                .iter()
                .any(|element| element.elements[shape].is_in_space())
                .then(|| geometry.tabulate(&[shape.centre()])),
            measure: Measure {
                cell: geometry.tabulate(&rule.points),
                cell_weights: rule.weights,
                facet: facet_measure,
            },
            means: means.then(|| MeanTables::new(mesh, elements, shape)).transpose()?,
        })
    }
}

impl Tabulated {
    fn products<const D: usize>(&self, shape: CellShape, places: &Places<D>) -> Option<ProductTables> {
        let inside = places.facet.is_none() && !self.on_facets;
        let lagrange = self.elements[shape].as_lagrange().filter(|_| inside)?;
        ProductTables::new(&lagrange, &places.points)
    }

    fn tabulate<const D: usize>(
        &self,
        shape: CellShape,
        points: &[[f64; D]],
        facet: Option<u8>,
        FurtherTables { hessians, coefficients, .. }: FurtherTables,
    ) -> Tables<D> {
        let element = &self.elements[shape];
        let nodal = element.of_coefficients().filter(|_| coefficients).map(Element::Lagrange);
        let element = nodal.as_ref().unwrap_or(element);
        let whole = if hessians { element.tabulate_with_hessians(points) } else { element.tabulate(points) };
        if !self.on_facets || self.degree == 0 {
            return whole;
        }
        // Only the nodes on the facet have traces that do not vanish.
        let kept = facet.map(|local| element.facet_nodes(usize::from(local))).unwrap_or_default();
        let entries = || (0..points.len()).flat_map(|q| kept.iter().map(move |i| q * whole.nodes + i));
        let traces = Tables {
            nodes: kept.len(),
            points: points.len(),
            value: entries().map(|entry| whole.value[entry]).collect(),
            gradient: entries().map(|entry| whole.gradient[entry]).collect(),
            hessian: if hessians { entries().map(|entry| whole.hessian[entry]).collect() } else { vec![] },
        };
        match facet.and_then(|local| element.dual_on_facet(usize::from(local))) {
            Some(coefficients) => combined(&traces, &coefficients),
            None => traces,
        }
    }
}

/// The groups of an integral's region; where the compiler's estimate of the quadrature degree is wanted,
/// it is made from the degrees of the form's fields. A kernel that reads a history takes the history's degree.
#[inline(never)]
pub(super) fn groups<const D: usize>(
    binding: &Binding<D>,
    integral: &Integral,
    quadrature: &Quadrature<D>,
    degrees: &[usize],
    requirements: &Requirements,
    arguments: &[(Role, &Space<D>)],
) -> Result<Vec<Group<D>>, AssemblyError> {
    let mesh = binding.mesh;
    let region = &binding.regions[integral.region];
    let place = format!("the region `{}` (\"{}\")", region.symbol, region.name);
    let at_nodes = match region.rule {
        RegionRule::OfBackend => None,
        RegionRule::Vertices => {
            let degree = binding.degree_of_coefficients(requirements, arguments, &place)?;
            let cell = QuadratureRule { points: vec![], weights: vec![] };
            Some(Quadrature::Explicit { cell, facet: facet_node_rule(mesh.shape_of_facets(), degree) })
        }
    };
    let quadrature = at_nodes.as_ref().unwrap_or(quadrature);
    let history = binding.history_degree(requirements, quadrature)?;
    let of_history = history.map(|(_, degree)| degree);
    let of_history = binding.degree_at_points(requirements, arguments, of_history, &place)?;
    let estimate = Estimate { integrand: &integral.degree, fields: degrees, of_history };
    let further = FurtherTables { coefficients: at_nodes.is_some(), ..FurtherTables::of(requirements) };
    let form = binding.name;
    if requirements.curvature && mesh.has_affine_facets() {
        notices::tell_of_straight_facets(form, &place);
    }
    let failed = |source| AssemblyError::Quadrature { form, source };
    if let Some(cut) = binding.cut {
        refusals(binding, &place, cut, (quadrature, history.is_some()))?;
    }
    if region.entity == Entity::Interface {
        return interface_groups(binding, integral, quadrature, &estimate, requirements);
    }
    if region.entity == Entity::Pairs {
        let degree = estimate.on_pairs(mesh, region.pairing.as_ref());
        return match integral.means {
            Some(means) => groups_with_means(binding, (integral, means), (quadrature, degree), requirements),
            None => pair_groups(binding, integral, quadrature, degree, requirements),
        };
    }
    match binding.entities(integral.region)? {
        Entities::Cells(cells) => {
            let group = |shape: CellShape, (degree, cells): (usize, Vec<u32>)| {
                let rule = quadrature.rule_on_cells(&mesh.shapes(), shape, degree)?;
                let places = Places { points: rule.points, facet: None };
                Group::new(binding, place.clone(), (shape, cells), &places, rule.weights, further)
            };
            let mut groups = Vec::new();
            for (shape, cells) in mesh.by_shape(mesh.walk_of_cells(&cells)) {
                let parts =
                    cells_by_degree(binding, quadrature, &estimate, (shape, cells)).map_err(failed)?;
                for (degree, cells) in parts {
                    let Some(cut) = binding.cut else {
                        groups.push(group(shape, (degree, cells)).map_err(failed)?);
                        continue;
                    };
                    let (whole, cells) = cut.whole_cells(cells);
                    if !whole.is_empty() {
                        groups.push(group(shape, (degree, whole)).map_err(failed)?);
                    }
                    let entry = (shape, quadrature, degree);
                    groups.extend(inside_of_cells(binding, &place, (cut, &cells), entry, requirements)?);
                }
            }
            Ok(groups)
        }
        facets => {
            let shape = mesh.shape_of_facets();
            let mut groups = Vec::new();
            let parts = facets_by_degree(binding, quadrature, &estimate, facets).map_err(failed)?;
            for (degree, facets) in parts {
                let rule = quadrature.facet_reference_rule(shape, degree).map_err(failed)?;
                let grouped = |facets: &Entities, rule: &QuadratureRule<2>| {
                    let groups = facet_groups(binding, &place, facets, rule, further)?;
                    Ok(groups.into_iter().map(|(group, _)| group).collect::<Vec<_>>())
                };
                // A history has values at the points of the whole facet.
                let part = |facet: &Facet| match (binding.cut, quadrature) {
                    (Some(cut), _) => cut.part_of_facet(*facet),
                    (None, Quadrature::Split { facets, .. }) => {
                        facets.pieces(*facet).map(|pieces| FacetPart::Pieces(pieces.to_vec()))
                    }
                    (None, _) => None,
                };
                let split = binding.cut.is_some() || matches!(quadrature, Quadrature::Split { .. });
                let (Entities::Facets(listed), true, None) = (&facets, split, history) else {
                    let (whole, clipped) = clipped_between(binding, &region.name, facets);
                    groups.extend(grouped(&whole, &rule)?);
                    for (sides, part) in clipped {
                        let rule = part.rule(quadrature, shape, degree).map_err(failed)?;
                        groups.extend(grouped(&Entities::InteriorFacets(vec![sides].into()), &rule)?);
                    }
                    continue;
                };
                let (mut whole, mut clipped) = (vec![], vec![]);
                for facet in &**listed {
                    match part(facet) {
                        None => whole.push(*facet),
                        Some(part) => clipped.push((*facet, part)),
                    }
                }
                groups.extend(grouped(&Entities::Facets(whole.into()), &rule)?);
                groups.extend(clipped_facets(binding, &place, &clipped, (quadrature, degree), requirements)?);
            }
            Ok(groups)
        }
    }
}

/// The facets whose sides satisfy a condition.
fn facets_with<'a>(facets: &Entities<'a>, condition: &dyn Fn(&[Facet]) -> bool) -> Entities<'a> {
    match facets {
        Entities::Cells(cells) => Entities::Cells(cells.clone()),
        Entities::Facets(all) => {
            let own = all.iter().filter(|facet| condition(std::slice::from_ref(facet)));
            Entities::Facets(own.copied().collect())
        }
        Entities::InteriorFacets(all) => {
            Entities::InteriorFacets(all.iter().filter(|sides| condition(&sides[..])).copied().collect())
        }
    }
}

/// Functions that are sums of a table's, with coefficients row after row. Facets' functions have no second derivatives.
fn combined<const D: usize>(table: &Tables<D>, coefficients: &[f64]) -> Tables<D> {
    let count = table.nodes;
    let mut value = vec![0.0; table.value.len()];
    let mut gradient = vec![[0.0; D]; table.gradient.len()];
    for start in (0..table.points).map(|q| q * count) {
        for i in 0..count {
            for j in 0..count {
                let factor = coefficients[i * count + j];
                value[start + i] += factor * table.value[start + j];
                let target = gradient[start + i].iter_mut();
                target.zip(table.gradient[start + j]).for_each(|(sum, slope)| *sum += factor * slope);
            }
        }
    }
    Tables { value, gradient, ..table.clone() }
}

/// Second derivatives along the tangents: t₀ᵀHt₀, t₀ᵀHt₁, t₁ᵀHt₁.
fn bending<const D: usize>(second: &[[f64; D]; D], tangents: &[[f64; D]; 2]) -> [f64; 3] {
    let along = |a: &[f64; D], b: &[f64; D]| -> f64 {
        (0..D).map(|k| (0..D).map(|l| a[k] * second[k][l] * b[l]).sum::<f64>()).sum()
    };
    let [first, last] = tangents;
    [along(first, first), along(first, last), along(last, last)]
}

instantiate!(groups: groups::<D>, Group::<D>::check_support, Group::<D>::new);
