//! Degrees of the rules of estimated integrands. Where a map is not affine, the measure, which is no constant there, counts as well, and
//! so do the normals of curved facets: cells and facets of a region are parted by their maps, each with its rule.

use forms_core::contract::{Degree, Derivatives, GeometryDegrees, Pairing};

use super::facets_with;
use crate::assemble::binding::Binding;
use crate::assemble::binding::entities::Entities;
use crate::element::CellShape;
use crate::instantiate::instantiate;
use crate::mesh::{Facet, Mesh};
use crate::quadrature::{MAXIMUM_DEGREE, Quadrature, QuadratureError};

/// Map of a reference cell, or of a facet's, to its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::assemble) enum Map {
    /// Constant Jacobian or tangents.
    Affine,
    Varying,
}

/// The degree of det J on the cells of a shape: total on simplices, in each direction on others.
fn degree_of_volumes<const D: usize>(shape: CellShape, degree: usize) -> usize {
    if shape.is_simplex() { D * (degree - 1) } else { D * degree - 1 }
}

/// The degree of the surface element on facets. The cross product of the tangents is a polynomial, its length the root of one,
/// which counts as in UFL: two more.
fn degree_of_areas<const D: usize>(simplex: bool, degree: usize) -> usize {
    let product = if simplex || D == 2 { (D - 1) * (degree - 1) } else { (D - 1) * degree - 1 };
    2 * product + 2
}

/// An integrand with the degrees of a form's fields, or the degree of the rule that a history has.
pub(in crate::assemble) struct Estimate<'a> {
    pub integrand: &'a Degree,
    pub fields: &'a [usize],
    pub of_history: Option<usize>,
}

impl Estimate<'_> {
    fn on<const D: usize>(&self, mesh: &Mesh<D>, simplex: bool, varying: Option<GeometryDegrees>) -> usize {
        if let Some(degree) = self.of_history {
            return degree;
        }
        let affine = self.integrand.of(self.fields, mesh.degree(), simplex);
        let Some(geometry) = varying else { return affine };
        let bare = self.integrand.over(self.fields, &GeometryDegrees { measure: 0, ..geometry });
        // What has a rule by itself has one with its measure.
        self.integrand.over(self.fields, &geometry).min(MAXIMUM_DEGREE).max(bare)
    }

    /// The degree on cells of a shape.
    fn on_cells<const D: usize>(&self, mesh: &Mesh<D>, shape: CellShape, map: Map) -> usize {
        let simplex = shape.is_simplex();
        let measure = degree_of_volumes::<D>(shape, mesh.degree());
        let geometry =
            GeometryDegrees { measure, ..GeometryDegrees::affine(mesh.degree(), derivatives(simplex)) };
        self.on(mesh, simplex, (map == Map::Varying).then_some(geometry))
    }

    /// The degree on facets; `simplex` says whether all cells at them are simplices.
    fn on_facets<const D: usize>(&self, mesh: &Mesh<D>, simplex: bool, map: Map) -> usize {
        let of_facets = mesh.shape_of_facets().is_simplex();
        let affine = GeometryDegrees::affine(mesh.degree(), derivatives(simplex));
        // Normals follow the slopes of a nearly flat facet: of a bilinear face these are linear.
        let normal = if D == 2 || of_facets { affine.normal } else { mesh.degree() };
        let measure = degree_of_areas::<D>(of_facets, mesh.degree());
        let geometry = GeometryDegrees { normal, measure, ..affine };
        self.on(mesh, simplex, (map == Map::Varying).then_some(geometry))
    }

    /// The degree on the parts of an interface in cells of a shape.
    pub fn on_interface<const D: usize>(&self, mesh: &Mesh<D>, shape: CellShape) -> usize {
        let map = if mesh.is_affine_on(shape) { Map::Affine } else { Map::Varying };
        self.on_facets(mesh, shape.is_simplex(), map)
    }

    /// The degree on pairs, whose cells may have several shapes: the highest, with that of the measure where a facet of the
    /// surfaces is curved or skewed.
    #[inline(never)]
    pub fn on_pairs<const D: usize>(&self, mesh: &Mesh<D>, pairing: Option<&Pairing>) -> usize {
        let map = map_of_surfaces(mesh, pairing);
        let degree = |shape: CellShape| self.on_facets(mesh, shape.is_simplex(), map);
        mesh.shapes_of_all().into_iter().map(degree).max().unwrap_or(0)
    }
}

fn derivatives(simplex: bool) -> Derivatives {
    if simplex { Derivatives::LowerDegrees } else { Derivatives::KeepDegrees }
}

fn map_of_surfaces<const D: usize>(mesh: &Mesh<D>, pairing: Option<&Pairing>) -> Map {
    if mesh.has_affine_facets() {
        return Map::Affine;
    }
    let maps = mesh.affine_maps();
    let surfaces = pairing.iter().flat_map(|pairing| &pairing.surfaces);
    let names = surfaces.flat_map(|facing| [&facing.own, &facing.opposite]);
    let is_affine = |name: &String| {
        // What is no surface is an error of the search.
        let facets = mesh.facets_of_surface(name).unwrap_or_default();
        facets.iter().all(|facet| maps.of_facet(*facet))
    };
    if names.into_iter().all(is_affine) { Map::Affine } else { Map::Varying }
}

/// Cells of one shape with the degrees of their rules: those with an affine map first, if the others need more points.
pub(super) fn cells_by_degree<const D: usize>(
    binding: &Binding<D>,
    quadrature: &Quadrature<D>,
    estimate: &Estimate,
    (shape, cells): (CellShape, Vec<u32>),
) -> Result<Vec<(usize, Vec<u32>)>, QuadratureError> {
    let mesh = binding.mesh;
    let [affine, varying] = [Map::Affine, Map::Varying].map(|map| estimate.on_cells(mesh, shape, map));
    let rule = |degree| quadrature.rule_on_cells(&mesh.shapes(), shape, degree);
    if affine == varying || !quadrature.follows_estimates() || mesh.is_affine_on(shape) {
        return Ok(vec![(affine, cells)]);
    }
    if rule(affine)? == rule(varying)? {
        return Ok(vec![(affine, cells)]);
    }
    if binding.lists_cells() {
        return Ok(vec![(varying, cells)]);
    }
    let maps = mesh.affine_maps();
    let (straight, others): (Vec<u32>, Vec<u32>) =
        cells.into_iter().partition(|cell| maps.of_cell(*cell as usize));
    Ok(match (straight.is_empty(), others.is_empty()) {
        (_, true) => vec![(affine, straight)],
        (true, false) => vec![(varying, others)],
        (false, false) => vec![(affine, straight), (varying, others)],
    })
}

/// Facets with the degrees of their rules: by whether all of their cells are simplices, on which derivatives lower degrees, and by
/// their maps. An interior facet has one rule, that of its smaller side.
pub(super) fn facets_by_degree<'a, const D: usize>(
    binding: &Binding<D>,
    quadrature: &Quadrature<D>,
    estimate: &Estimate,
    facets: Entities<'a>,
) -> Result<Vec<(usize, Entities<'a>)>, QuadratureError> {
    let mesh = binding.mesh;
    let rule = |degree| quadrature.facet_reference_rule(mesh.shape_of_facets(), degree);
    let mut parts = Vec::new();
    for (simplex, facets) in by_cells(mesh, facets) {
        let [affine, varying] = [Map::Affine, Map::Varying].map(|map| estimate.on_facets(mesh, simplex, map));
        if affine == varying
            || !quadrature.follows_estimates()
            || mesh.has_affine_facets()
            || rule(affine)? == rule(varying)?
        {
            parts.push((affine, facets));
            continue;
        }
        if binding.lists_cells() {
            parts.push((varying, facets));
            continue;
        }
        let maps = mesh.affine_maps();
        let is_affine = |sides: &[Facet]| match sides {
            [first, second] => maps.of_facet(mesh.smaller_side(&[*first, *second])),
            sides => maps.of_facet(sides[0]),
        };
        let straight = facets_with(&facets, &is_affine);
        match straight.count() {
            count if count == facets.count() => parts.push((affine, facets)),
            0 => parts.push((varying, facets)),
            _ => {
                let curved = facets_with(&facets, &|sides| !is_affine(sides));
                parts.extend([(affine, straight), (varying, curved)]);
            }
        }
    }
    Ok(parts)
}

/// Facets by whether all of their cells are simplices.
fn by_cells<'a, const D: usize>(mesh: &Mesh<D>, facets: Entities<'a>) -> Vec<(bool, Entities<'a>)> {
    if let [shape] = mesh.shapes()[..] {
        return vec![(shape.is_simplex(), facets)];
    }
    let simplex =
        |sides: &[Facet]| sides.iter().all(|facet| mesh.cell_shape(facet.cell as usize).is_simplex());
    [true, false].map(|wanted| (wanted, facets_with(&facets, &|sides| simplex(sides) == wanted))).into()
}

/// The degree that the geometry adds to that of a product of fields on all cells of bodies: the degree of the map where it is affine.
pub(crate) fn degree_on_all_cells<const D: usize>(mesh: &Mesh<D>, product: usize) -> usize {
    let affine = product + mesh.degree();
    if mesh.is_affine() {
        return affine;
    }
    let maps = mesh.affine_maps();
    let varying = mesh.body_blocks().filter(|block| block.cells.clone().any(|cell| !maps.of_cell(cell)));
    varying.map(|block| product + degree_of_volumes::<D>(block.shape, mesh.degree())).fold(affine, usize::max)
}

instantiate!(walk_degrees: degree_on_all_cells::<D>);
