//! Checks of multipliers on own facets: each node has one condition of contact at most, and none where displacements are prescribed.

use std::collections::{BTreeMap, BTreeSet};

use forms_fem::locate::long_normal;
use forms_fem::mesh::{Facet, MeshError};
use forms_fem::prelude::*;
use thiserror::Error;

/// Reasons for which multipliers of contact are not determined.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum MultiplierError {
    /// Data that do not fit.
    #[error("{source}")]
    Assembly {
        #[from]
        source: AssemblyError,
    },
    /// A surface that the mesh does not have.
    #[error("{source}")]
    Surface {
        #[from]
        source: MeshError,
    },
    /// A pairing with several own surfaces, or none.
    #[error(
        "multipliers belong to one own surface, and the pairing {pairing} has {count}: write `Pairing::onto(own, opposite)`, and one region of pairs \
         per own surface"
    )]
    OwnSurfaces { pairing: String, count: usize },
    /// Multipliers on other facets than those of the own surface.
    #[error(
        "the multipliers are {found}, and the own surface of the pairing is \"{own}\": make their space by \
         `Space::on_facets(&mesh, \"{own}\", degree)`"
    )]
    OtherFacets { own: String, found: String },
    /// Multipliers whose functions have integrals over covers that may be negative.
    #[error(
        "the multipliers of \"{own}\" are {found}, and conditions hold for functions with positive integrals over any cover: take those of degree 1, \
         `Space::on_facets(&mesh, \"{own}\", 1)`, dual ones, or Bernstein elements of degree 2"
    )]
    Negative { own: String, found: String },
    /// Facets with more multipliers than nodes of the displacement.
    #[error(
        "\"{own}\" has facets with {multipliers} functions of multipliers and {nodes} nodes of the displacement, which cannot meet their conditions: take \
         multipliers of degree 1, or displacements in Lagrange elements of degree 2"
    )]
    TooMany { own: String, multipliers: usize, nodes: usize },
    /// A node with a multiplier whose displacement is prescribed.
    #[error(
        "the node at {position:?} of \"{own}\" has a multiplier, and all of its displacement is prescribed: both cannot be. End \
         the own surface before it (`mesh.name_facets`), or leave a component free"
    )]
    Prescribed { own: String, position: Vec<f64> },
    /// A node with two multipliers.
    #[error(
        "the node at {position:?} has multipliers of two own surfaces, \"{first}\" and \"{second}\": one displacement cannot meet both conditions. Let \
         one of them end before it, or be the opposite surface"
    )]
    Shared { first: String, second: String, position: Vec<f64> },
    /// Two nodes with a multiplier each, whose displacements a periodic condition makes one.
    #[error(
        "the nodes at {position:?} and {other:?} of \"{own}\" have a multiplier each, and one displacement by a periodic condition: it cannot meet both \
         conditions. Let the own surface end before one of them, or be the opposite surface"
    )]
    Periodic { own: String, position: Vec<f64>, other: Vec<f64> },
    /// An own surface in space that faces away from the axis of its multipliers.
    #[error(
        "the normal of \"{own}\" at {position:?} is near −axis, where tangents turn: set `axis` to a unit vector near the normals of the own \
         surface, or divide it"
    )]
    OppositeAxis { own: String, position: Vec<f64> },
}

/// Least cosine of the angle between the axis of multipliers and normals: tangents turn once around −axis.
const LEAST_COSINE: f64 = -0.8;

/// Least cosine of the angle between the normals of two facets at a node that is on no sharp edge: that of 60°.
const SHARP: f64 = 0.5;

/// Parts of a cell's diameter up to which two positions are one.
const SAME: f64 = 1e-9;

/// Check of the multipliers of some pairings, each with their space, against each other and against the conditions on the displacement.
///
/// # Errors
/// [`MultiplierError`].
pub fn check_multipliers<const D: usize>(
    multipliers: &[(&Pairing, &Arc<Space<D>>)],
    held: &Constraints<D>,
) -> Result<(), MultiplierError> {
    let displacements = held.space();
    let (mesh, positions) = (displacements.mesh(), displacements.positions());
    let mut known: Vec<(&str, BTreeSet<u32>)> = vec![];
    for (pairing, space) in multipliers {
        let [facing] = &pairing.surfaces[..] else {
            let (pairing, count) = (pairing.to_string(), pairing.surfaces.len());
            return Err(MultiplierError::OwnSurfaces { pairing, count });
        };
        let own = &facing.own;
        if space.facet_region() != Some(own) {
            let on = |region: &str| format!("those of \"{region}\"");
            let found = space.facet_region().map_or("no multipliers on facets".to_owned(), on);
            return Err(MultiplierError::OtherFacets { own: own.clone(), found });
        }
        let is_positive = matches!(space.elements(), Elements::Lagrange(1) | Elements::Bernstein(_));
        if !(is_positive || space.elements().is_dual()) {
            let (own, found) = (own.clone(), space.elements().to_string());
            return Err(MultiplierError::Negative { own, found });
        }
        let is_multiplier = |node: u32, near: f64| {
            let position = positions[node as usize];
            let is_here = |other: &[f64; D]| (0..D).all(|k| (other[k] - position[k]).abs() < near);
            space.positions().iter().any(is_here)
        };
        let (mut nodes, mut tied) = (BTreeSet::new(), vec![]);
        for facet in mesh.facet_region(own)? {
            let cell = facet.cell as usize;
            let local = usize::from(facet.local);
            let of_facet = displacements.cell_element(cell).facet_nodes(local);
            let (multipliers, nodes_there) =
                (space.cell_element(cell).facet_nodes(local).len(), of_facet.len());
            if multipliers > nodes_there {
                let own = own.clone();
                return Err(MultiplierError::TooMany { own, multipliers, nodes: nodes_there });
            }
            for node in of_facet.into_iter().map(|node| displacements.cell_nodes(cell)[node]) {
                let first = node as usize * D;
                let is_held = (first..first + D).all(|unknown| held.is_prescribed(unknown));
                let master = master_of(held, first);
                if (is_held || master.is_some()) && is_multiplier(node, SAME * mesh.diameter(cell)) {
                    let Some(master) = master else {
                        let (own, position) = (own.clone(), positions[node as usize].to_vec());
                        return Err(MultiplierError::Prescribed { own, position });
                    };
                    tied.push((node, master));
                }
                nodes.insert(node);
            }
        }
        if let Some((node, master)) = tied.into_iter().find(|(_, master)| nodes.contains(master)) {
            let [position, other] = [node, master].map(|node| positions[node as usize].to_vec());
            return Err(MultiplierError::Periodic { own: own.clone(), position, other });
        }
        for (other, theirs) in &known {
            if let Some(node) = nodes.intersection(theirs).next() {
                let (first, second) = ((*other).to_owned(), own.clone());
                let position = positions[*node as usize].to_vec();
                return Err(MultiplierError::Shared { first, second, position });
            }
        }
        known.push((own, nodes));
    }
    Ok(())
}

/// The other node that gives all of a node's displacement, whose unknowns begin with this one.
fn master_of<const D: usize>(held: &Constraints<D>, first: usize) -> Option<u32> {
    let mut found = BTreeSet::new();
    for unknown in first..first + D {
        found.extend(held.relations().get(&unknown)?.terms.iter().map(|(other, _)| other / D));
    }
    found.into_iter().reduce(|_, _| usize::MAX).and_then(|node| u32::try_from(node).ok())
}

/// Check of the axis of multipliers with friction on the own surface in space, by the cosine of its angle with the outward normal.
pub(crate) fn check_axis<const D: usize>(
    cosine: &Expression<D>,
    multipliers: &Space<D>,
) -> Result<(), MultiplierError> {
    let own = multipliers.facet_region().unwrap_or_default();
    let found = Assembler::new(multipliers.mesh()).at_quadrature_points(cosine, Entity::Facets, own, 2)?;
    match found.values.iter().position(|value| value[0] < LEAST_COSINE) {
        None => Ok(()),
        Some(place) => Err(MultiplierError::OppositeAxis {
            own: own.to_owned(),
            position: found.positions[place].to_vec(),
        }),
    }
}

/// A note on sharp edges of a pairing's own surface, where the normals of a node's facets differ by more than 60°. The mean gap of such a
/// node counts both sides, and where one of them is open the node bears nothing. It names the sharpest one. None: there are no such edges.
///
/// # Errors
/// A surface that the mesh does not have.
pub fn note_on_sharp_edges<const D: usize>(
    pairing: &Pairing,
    mesh: &Mesh<D>,
) -> Result<Option<String>, MeshError> {
    let mut normals: BTreeMap<u32, Vec<[f64; D]>> = BTreeMap::new();
    for facing in &pairing.surfaces {
        for facet in mesh.facet_region(&facing.own)? {
            for (place, vertex) in mesh.facet_vertices(*facet).enumerate() {
                normals.entry(vertex).or_default().push(normal_at(mesh, *facet, place));
            }
        }
    }
    let cosine = |a: &[f64; D], b: &[f64; D]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let least = |of_node: &Vec<[f64; D]>| {
        let pairs = of_node.iter().enumerate().flat_map(|(k, a)| of_node[..k].iter().map(move |b| (a, b)));
        pairs.map(|(a, b)| cosine(a, b)).fold(1.0, f64::min)
    };
    let sharp: Vec<(u32, f64)> = normals.iter().map(|(vertex, all)| (*vertex, least(all))).collect();
    let sharp: Vec<(u32, f64)> = sharp.into_iter().filter(|(_, cosine)| *cosine < SHARP).collect();
    let Some((vertex, cosine)) = sharp.iter().min_by(|a, b| a.1.total_cmp(&b.1)) else { return Ok(None) };
    let (position, angle) = (mesh.nodes()[*vertex as usize], cosine.clamp(-1.0, 1.0).acos().to_degrees());
    let further = match sharp.len() - 1 {
        0 => String::new(),
        count => format!(", and by more than 60° at {count} more nodes"),
    };
    Ok(Some(format!(
        "the own surface of {pairing} turns by {angle:.0}° at {position:?}{further}: the mean gap of a node there counts both sides, and where one of them is \
         open the node bears nothing. End the own surface at sharp edges (`mesh.name_facets`)"
    )))
}

/// The outward unit normal of a facet at one of its vertices, whose place among them is given.
fn normal_at<const D: usize>(mesh: &Mesh<D>, facet: Facet, place: usize) -> [f64; D] {
    let (cell, shape) = (facet.cell as usize, mesh.cell_shape(facet.cell as usize));
    let (vertices, points) = (shape.facet_vertices(usize::from(facet.local)), shape.vertex_points());
    let at = |place: usize| &points[vertices[place % vertices.len()]];
    let (x, jacobian) = mesh.map(cell, &std::array::from_fn(|k| at(place)[k]));
    // Corners along the edges that meet there, in the facet's order.
    let along = |to: &[f64; 3]| -> [f64; D] {
        let turned = |row: &[f64; D]| (0..D).map(|k| row[k] * (to[k] - at(place)[k])).sum::<f64>();
        std::array::from_fn(|i| x[i] + turned(&jacobian[i]))
    };
    let corners = match D {
        2 => [0, 1, 1],
        _ => [place, place + 1, place + vertices.len() - 1],
    };
    let normal = long_normal(&std::array::from_fn(|k| along(at(corners[k]))));
    let length = normal.iter().map(|part| part * part).sum::<f64>().sqrt();
    normal.map(|part| part / length)
}
