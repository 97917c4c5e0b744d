//! Groups of exterior or interior facets, by how their cells number them: their points lie elsewhere in the reference cells otherwise.
//! An interior facet may be the whole facet of both cells, or that of a small cell and a part of a larger one's.

use std::collections::BTreeMap;

use super::means::FurtherTables;
use super::{Group, GroupSide, Places};
use crate::assemble::AssemblyError;
use crate::assemble::binding::Binding;
use crate::assemble::binding::entities::Entities;
use crate::element::CellShape;
use crate::instantiate::instantiate;
use crate::mesh::{Facet, Facing};
use crate::quadrature::{FacetRule, QuadratureError, QuadratureRule, facet_reference_rule, map_to_corners};

/// The numbering of a facet's sides: the local number and the cell's shape on each, and of interior ones how they face each other.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Numbering {
    first: (u8, CellShape),
    second: Option<(u8, Facing, CellShape)>,
}

/// A side of a facet: local number, shape of the cell, and the facet's first, second and last vertices in its reference coordinates,
/// in the same order on both sides.
struct NumberedSide<const D: usize> {
    local: u8,
    shape: CellShape,
    corners: [[f64; D]; 3],
    in_part: bool,
}

impl<const D: usize> NumberedSide<D> {
    /// A whole facet; its vertices from the first one on, or in the order of the other side's.
    fn whole(local: u8, shape: CellShape, order: Option<[u8; 4]>) -> Self {
        let (vertices, points) = (shape.facet_vertices(usize::from(local)), shape.vertex_points());
        let corners = [0, 1, vertices.len() - 1].map(|corner| {
            let vertex = vertices[order.map_or(corner, |order| usize::from(order[corner]))];
            std::array::from_fn(|k| points[vertex][k])
        });
        NumberedSide { local, shape, corners, in_part: false }
    }

    /// The same facet with its corners in the other direction around it.
    fn turned_over(self) -> Self {
        let [first, second, last] = self.corners;
        let corners = if D == 2 { [second, first, last] } else { [first, last, second] };
        NumberedSide { corners, ..self }
    }
}

/// The groups of exterior or interior facets at the points of a rule on the facet's own reference cell, that of the smaller cell's facet,
/// and the places of each group's facets in the region.
#[inline(never)]
pub(in crate::assemble) fn facet_groups<const D: usize>(
    binding: &Binding<D>,
    place: &str,
    facets: &Entities,
    rule: &QuadratureRule<2>,
    further: FurtherTables,
) -> Result<Vec<(Group<D>, Vec<usize>)>, AssemblyError> {
    let (mesh, form) = (binding.mesh, binding.name);
    let shape = |facet: &Facet| mesh.cell_shape(facet.cell as usize);
    let mut numberings: BTreeMap<Numbering, Vec<usize>> = BTreeMap::new();
    let mut walk: Vec<(u32, usize)> =
        (0..facets.count()).map(|index| (mesh.walk_of_facet(facets.sides(index)), index)).collect();
    walk.sort_unstable();
    for (_, index) in walk {
        let numbering = match facets.sides(index) {
            [first, second] => {
                let twisted = |source| AssemblyError::Facets { form, place: place.to_owned(), source };
                let facing = mesh.facing(&[*first, *second]).map_err(twisted)?;
                let second = Some((second.local, facing, shape(second)));
                Numbering { first: (first.local, shape(first)), second }
            }
            sides => Numbering { first: (sides[0].local, shape(&sides[0])), second: None },
        };
        numberings.entry(numbering).or_default().push(index);
    }
    let in_part = |local: u8, shape: CellShape, number: u32| NumberedSide {
        local,
        shape,
        corners: *mesh.part_corners(number),
        in_part: true,
    };
    let group = |(Numbering { first: (first, shape), second }, indices): (Numbering, Vec<usize>)| {
        let whole = |order| NumberedSide::<D>::whole(first, shape, order);
        let numbered = match second {
            None => vec![whole(None)],
            Some((local, Facing::Whole(order), shape)) => {
                vec![whole(None), NumberedSide::whole(local, shape, Some(order))]
            }
            Some((local, Facing::FirstIsPart(number), shape)) => {
                vec![whole(None), in_part(local, shape, number)]
            }
            Some((local, Facing::SecondIsPart(number), other)) => {
                // Around the facet as the first side sees it, so that the normal points out of its cell.
                let both = [in_part(first, shape, number), NumberedSide::whole(local, other, None)];
                both.map(NumberedSide::turned_over).into()
            }
        };
        let mut sides = Vec::new();
        for (index, side) in numbered.into_iter().enumerate() {
            let cells = indices.iter().map(|facet| facets.sides(*facet)[index].cell).collect();
            sides.push(side_of_group(binding, cells, &side, rule, further)?);
        }
        Ok((
            Group { place: place.to_owned(), sides, weights: rule.weights.clone(), own: None, means: None },
            indices,
        ))
    };
    let failed = |source| AssemblyError::Quadrature { form, source };
    numberings.into_iter().map(|entry| group(entry).map_err(failed)).collect()
}

/// One side of the facets of a group. Where it is a part of its cells' facets, the tangents are those of the part, so that weights count
/// the part's area, and so does |F|.
fn side_of_group<const D: usize>(
    binding: &Binding<D>,
    cells: Vec<u32>,
    side: &NumberedSide<D>,
    rule: &QuadratureRule<2>,
    further: FurtherTables,
) -> Result<GroupSide<D>, QuadratureError> {
    let mesh = binding.mesh;
    let FacetRule { points, tangents, .. } = map_to_corners(side.corners, rule);
    let places = Places { points, facet: Some((side.local, tangents)) };
    let mut group = GroupSide::new(mesh, &binding.elements, (side.shape, cells), &places, further)?;
    if side.in_part
        && let Some((table, weights)) = &mut group.measure.facet
    {
        let exact = facet_reference_rule(side.shape, GroupSide::<D>::degree_of_areas(mesh))?;
        *table = mesh.element_of(side.shape).tabulate(&map_to_corners(side.corners, &exact).points);
        *weights = exact.weights;
    }
    Ok(group)
}

instantiate!(facet_groups: facet_groups::<D>);
