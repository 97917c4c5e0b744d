//! One sector of a ring that looks the same in all of them, and the ring that is made of its copies.

use std::f64::consts::TAU;

use super::RemeshingError;
use super::outline::{Arc, Outline};
use super::sampling::{NewEdge, of_chain};
use super::sizes::SizeField;

/// A pattern that repeats itself around a centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sectors {
    pub centre: [f64; 2],
    pub count: usize,
    /// Angle at which a sector begins \[rad\].
    pub angle: f64,
}

/// Angles that are equal [rad].
const SAME: f64 = 1e-6;

/// The outline of the first sector.
pub(super) struct Sector {
    /// Loops inside.
    pub whole: Vec<Vec<Arc>>,
    /// The parts of the outer and of the inner loop around the centre.
    pub across: [Vec<Arc>; 2],
}

impl Sectors {
    /// The angle of a point from the beginning of the first sector, in sectors, in [0, count).
    fn place(&self, x: &[f64; 2]) -> f64 {
        let angle = (x[1] - self.centre[1]).atan2(x[0] - self.centre[0]) - self.angle;
        let turns = angle.rem_euclid(TAU) / TAU * self.count as f64;
        if turns > self.count as f64 - SAME { 0.0 } else { turns }
    }

    /// A point turned by the given number of sectors.
    pub fn turned(&self, x: &[f64; 2], sectors: usize) -> [f64; 2] {
        if sectors.is_multiple_of(self.count) {
            return *x;
        }
        let (sine, cosine) = (TAU * (sectors % self.count) as f64 / self.count as f64).sin_cos();
        let arm = [x[0] - self.centre[0], x[1] - self.centre[1]];
        [self.centre[0] + cosine * arm[0] - sine * arm[1], self.centre[1] + sine * arm[0] + cosine * arm[1]]
    }

    /// The first sector of an outline.
    ///
    /// # Errors
    /// [`RemeshingError::AcrossSectors`] with the position.
    pub fn first(&self, outline: &Outline) -> Result<Sector, RemeshingError> {
        let (mut whole, mut across) = (vec![], vec![]);
        for arcs in &outline.loops {
            let places: Vec<f64> = arcs.iter().map(|arc| self.place(&arc.nodes[1])).collect();
            let (least, most) = places
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), place| (a.min(*place), b.max(*place)));
            if most - least < 1.0 {
                if least.floor() != most.floor() {
                    return Err(RemeshingError::AcrossSectors { at: arcs[0].nodes[0] });
                }
                if least.floor() == 0.0 {
                    whole.push(arcs.clone());
                }
                continue;
            }
            let inside = |k: usize| places[k % arcs.len()] < 1.0;
            let count = arcs.len();
            let starts: Vec<usize> = (0..count).filter(|&k| inside(k) && !inside(k + count - 1)).collect();
            let [start] = starts[..] else {
                return Err(RemeshingError::AcrossSectors { at: arcs[0].nodes[0] });
            };
            let chain: Vec<Arc> =
                (start..start + count).take_while(|&k| inside(k)).map(|k| arcs[k % count]).collect();
            across.push(chain);
        }
        // The outer loop runs with the angle, the inner against it.
        across.sort_by_key(|chain| !self.runs_with_the_angle(chain));
        let pair: Result<[Vec<Arc>; 2], _> = across.try_into();
        let across = pair.map_err(|chains: Vec<_>| RemeshingError::Loops { found: chains.len() })?;
        for (chain, sides) in across.iter().zip([[0.0, 1.0], [1.0, 0.0]]) {
            for (arc, node, side) in [(0, 0, sides[0]), (chain.len() - 1, 2, sides[1])] {
                let at = chain[arc].nodes[node];
                let off = (self.place(&at) - side).abs();
                if off > SAME {
                    return Err(RemeshingError::NoNodeOnTheCut { at });
                }
            }
        }
        Ok(Sector { whole, across })
    }

    fn runs_with_the_angle(&self, chain: &[Arc]) -> bool {
        let [a, m, _] = chain[0].nodes.map(|x| [x[0] - self.centre[0], x[1] - self.centre[1]]);
        a[0] * m[1] - a[1] * m[0] > 0.0
    }

    /// The new edges of the first sector's loop around: outer part, side, inner part, side. The sides are the same, turned.
    /// With them the numbers of the edges of each part.
    pub fn edges_around(&self, sector: &Sector, sizes: &SizeField) -> (Vec<NewEdge>, [usize; 4]) {
        let [outer, inner] = &sector.across;
        let (outer_start, inner_end) = (outer[0].nodes[0], inner[inner.len() - 1].nodes[2]);
        let side = of_chain(&[Arc::line(inner_end, outer_start, usize::MAX)], sizes, 1);
        let edges_of = |arcs: &[Arc]| super::sampling::of_open_chain(arcs, sizes);
        let (mut edges, inner_edges) = (edges_of(outer), edges_of(inner));
        let counts = [edges.len(), side.len(), inner_edges.len(), side.len()];
        // Back along the image of the side, from the outer loop to the inner.
        for k in (0..side.len()).rev() {
            let start = side.get(k + 1).map_or(outer_start, |edge| edge[0]);
            edges.push([self.turned(&start, 1), self.turned(&side[k][1], 1)]);
        }
        let first_of_inner = edges.len();
        edges.extend(inner_edges);
        // Where the inner loop begins is where the side's image ends, to the last bit.
        edges[first_of_inner][0] = self.turned(&inner_end, 1);
        edges.extend(side);
        (edges, counts)
    }
}
