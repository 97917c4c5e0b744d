//! The outline of a plane mesh: closed loops of parabolas, with the body to their left.

use std::collections::BTreeMap;

use super::RemeshingError;
use crate::facet::Facet;
use crate::mesh::{BOUNDARY, Mesh};

/// Straight pieces that replace a parabola where distances are measured.
const PIECES: usize = 8;
/// The cosine of the turn of an outline, 30°, beyond which a node is a corner, which stays.
const CORNER: f64 = 0.866;

/// The same between straight facets, 10°: an outline of degree 1 is a polygon, off which a chord across a corner would cut a part. Below it the
/// outline approximates a smooth curve, off which it is itself as far.
const CORNER_OF_POLYGON: f64 = 0.985;

/// A facet of the boundary as a parabola.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    /// The start, the middle node and the end, with the body to the left \[length\].
    pub nodes: [[f64; 2]; 3],
    /// The facet; none for what cuts a body into sectors.
    pub facet: Option<Facet>,
    /// Which set of regions the facet belongs to.
    pub regions: usize,
}

impl Arc {
    /// A straight line that is no facet.
    pub fn line(from: [f64; 2], to: [f64; 2], regions: usize) -> Self {
        let middle = std::array::from_fn(|k| 0.5 * (from[k] + to[k]));
        Arc { nodes: [from, middle, to], facet: None, regions }
    }

    /// The point at a parameter between 0 and 1.
    pub fn point(&self, t: f64) -> [f64; 2] {
        let [a, m, b] = self.nodes;
        let shape = [(1.0 - t) * (1.0 - 2.0 * t), 4.0 * t * (1.0 - t), t * (2.0 * t - 1.0)];
        std::array::from_fn(|k| shape[0] * a[k] + shape[1] * m[k] + shape[2] * b[k])
    }

    /// The direction at a parameter, of length 1.
    pub fn direction(&self, t: f64) -> [f64; 2] {
        let [a, m, b] = self.nodes;
        let slope = [4.0 * t - 3.0, 4.0 - 8.0 * t, 4.0 * t - 1.0];
        let d: [f64; 2] = std::array::from_fn(|k| slope[0] * a[k] + slope[1] * m[k] + slope[2] * b[k]);
        let length = d[0].hypot(d[1]);
        d.map(|x| x / length)
    }

    /// Whether the middle node lies in the middle of a straight line.
    fn is_straight(&self) -> bool {
        let [a, m, b] = self.nodes;
        let off = (0..2).map(|k| (0.5 * (a[k] + b[k]) - m[k]).abs()).fold(0.0, f64::max);
        off <= 1e-9 * (b[0] - a[0]).hypot(b[1] - a[1])
    }

    /// The distance of a point.
    pub fn distance(&self, x: &[f64; 2]) -> f64 {
        let points: Vec<[f64; 2]> = (0..=PIECES).map(|k| self.point(k as f64 / PIECES as f64)).collect();
        points.windows(2).map(|pair| to_segment(x, pair[0], pair[1])).fold(f64::INFINITY, f64::min)
    }
}

/// Closed loops of arcs, each beginning at a corner if it has one.
#[derive(Clone, Debug)]
pub(super) struct Outline {
    pub loops: Vec<Vec<Arc>>,
    /// The names of the regions of each set.
    pub sets: Vec<Vec<String>>,
}

impl Outline {
    /// The outline of a mesh.
    ///
    /// # Errors
    /// [`RemeshingError`]: an outline that is not closed.
    pub fn of(mesh: &Mesh<2>) -> Result<Self, RemeshingError> {
        let mut names: BTreeMap<Facet, Vec<String>> = BTreeMap::new();
        for name in mesh.facet_region_names().filter(|name| *name != BOUNDARY) {
            for facet in mesh.facet_region(name)? {
                names.entry(*facet).or_default().push(name.to_owned());
            }
        }
        let mut sets: Vec<Vec<String>> = vec![];
        let mut from: BTreeMap<u32, Vec<(u32, Arc)>> = BTreeMap::new();
        for &facet in mesh.boundary_facets() {
            let cell = mesh.cell(facet.cell as usize);
            let [a, b] = mesh.cell_shape(facet.cell as usize).edges()[usize::from(facet.local)];
            let nodes = ends_and_middle(mesh, facet);
            let own = names.remove(&facet).unwrap_or_default();
            let regions = sets.iter().position(|set| *set == own).unwrap_or_else(|| {
                sets.push(own);
                sets.len() - 1
            });
            let arc = Arc { nodes, facet: Some(facet), regions };
            from.entry(cell[a]).or_default().push((cell[b], arc));
        }
        let mut loops = vec![];
        while let Some((&first, _)) = from.iter().find(|(_, arcs)| !arcs.is_empty()) {
            let (mut node, mut arcs) = (first, Vec::<Arc>::new());
            while let Some((next, arc)) = from.get_mut(&node).and_then(Vec::pop) {
                arcs.push(arc);
                node = next;
                if node == first {
                    break;
                }
            }
            if node != first {
                return Err(RemeshingError::Open { at: arcs[0].nodes[0] });
            }
            from.retain(|_, arcs| !arcs.is_empty());
            loops.push(from_a_corner(arcs));
        }
        Ok(Outline { loops, sets })
    }

    /// All arcs.
    pub fn arcs(&self) -> impl Iterator<Item = &Arc> {
        self.loops.iter().flatten()
    }

    /// The arc that is nearest to a point.
    pub fn nearest(&self, x: &[f64; 2]) -> Option<&Arc> {
        let reach = |arc: &Arc| {
            let [a, m, b] = arc.nodes;
            // A bound of the distance, which costs little.
            let radius = (a[0] - m[0]).hypot(a[1] - m[1]).max((b[0] - m[0]).hypot(b[1] - m[1]));
            (x[0] - m[0]).hypot(x[1] - m[1]) - 1.5 * radius
        };
        let mut best: Option<(f64, &Arc)> = None;
        for arc in self.arcs() {
            if best.is_none_or(|(least, _)| reach(arc) < least) {
                let distance = arc.distance(x);
                if best.is_none_or(|(least, _)| distance < least) {
                    best = Some((distance, arc));
                }
            }
        }
        best.map(|(_, arc)| arc)
    }
}

/// Whether a node between two arcs must stay: the outline turns there, or its name changes.
pub(super) fn is_corner(before: &Arc, after: &Arc) -> bool {
    let (a, b) = (before.direction(1.0), after.direction(0.0));
    let polygon = before.is_straight() && after.is_straight();
    let least = if polygon { CORNER_OF_POLYGON } else { CORNER };
    before.regions != after.regions || a[0] * b[0] + a[1] * b[1] < least
}

fn from_a_corner(mut arcs: Vec<Arc>) -> Vec<Arc> {
    let count = arcs.len();
    if let Some(start) = (0..count).find(|&k| is_corner(&arcs[(k + count - 1) % count], &arcs[k])) {
        arcs.rotate_left(start);
    }
    arcs
}

/// The distance of a point from a segment.
pub(super) fn to_segment(x: &[f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let product = (x[0] - a[0]) * along[0] + (x[1] - a[1]) * along[1];
    let t = if square > 0.0 { (product / square).clamp(0.0, 1.0) } else { 0.0 };
    (x[0] - a[0] - t * along[0]).hypot(x[1] - a[1] - t * along[1])
}

/// The start of a facet, the node in its middle or the place between its ends, and the end.
pub(super) fn ends_and_middle(mesh: &Mesh<2>, facet: Facet) -> [[f64; 2]; 3] {
    let cell = mesh.cell(facet.cell as usize);
    let nodes = mesh.cell_element(facet.cell as usize).facet_nodes(facet.local.into());
    let [a, b] = mesh.cell_shape(facet.cell as usize).edges()[usize::from(facet.local)];
    let place = |local: usize| mesh.nodes()[cell[local] as usize];
    let middle = match nodes.iter().find(|local| **local != a && **local != b) {
        Some(local) => place(*local),
        None => std::array::from_fn(|k| 0.5 * (place(a)[k] + place(b)[k])),
    };
    [place(a), middle, place(b)]
}
