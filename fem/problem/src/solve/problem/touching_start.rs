//! Surfaces that just touch at a start from rest, made to overlap by a trace.
//!
//! At a gap and a stress of zero contact's \[·\]₋ has its kink, and its derivative there is that of bodies apart: the first
//! step would press one body through the other as if nothing held it, and with friction the next ones would start from surfaces
//! that slip everywhere. A trace of overlap, along the normal, has the derivative of bodies that press and stick.

use super::Problem;
use super::SolveError;
use crate::assemble::FoundPairs;
use crate::mesh::{Facet, Mesh};
use crate::pairs::PairGroup;
use crate::solve::{Elimination, NewtonFailure, Processes};

/// A gap below this part of the own facet's diameter is none, and not apart or overlapping by rounding.
const TOUCHING: f64 = 1e-11;

/// The overlap that is given to surfaces that touch, relative to the own facet's diameter.
const OVERLAP: f64 = 1e-9;

/// The sum of the ways of a node and their number.
type Ways<const D: usize> = Vec<([f64; D], usize)>;

fn diameter<const D: usize>(mesh: &Mesh<D>, facet: Facet) -> f64 {
    let corners: Vec<[f64; D]> =
        mesh.facet_vertices(facet).map(|vertex| mesh.nodes()[vertex as usize]).collect();
    let distance = |a: &[f64; D], b: &[f64; D]| (0..D).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
    corners.iter().flat_map(|a| corners.iter().map(move |b| distance(a, b))).fold(0.0, f64::max)
}

impl<const D: usize, const N: usize> Problem<'_, D, N> {
    /// Makes surfaces that slide and just touch overlap by a trace, if the unknown that displaces them starts from zero and something acts on it
    /// there.
    pub(super) fn overlap_touching(
        &self,
        elimination: &Elimination,
        u: &mut [f64],
    ) -> Result<(), SolveError> {
        if !self.system.slides() || !self.leaves_rest(elimination, u)? {
            return Ok(());
        }
        for found in self.system.found_pairs(u)? {
            let Some(number) = found.displacing_unknown(self.system.form.fields()) else { continue };
            let offset: usize = self.system.spaces[..number].iter().map(|space| space.unknowns()).sum();
            let own = &mut u[offset..offset + self.system.spaces[number].unknowns()];
            if own.iter().any(|value| *value != 0.0) {
                continue;
            }
            for (node, (sum, count)) in self.ways(number, &found).iter().enumerate() {
                let part = 1.0 / (*count).max(1) as f64;
                for (value, way) in own[node * D..(node + 1) * D].iter_mut().zip(sum) {
                    *value = part * way;
                }
            }
        }
        Ok(())
    }

    /// Whether something acts at u: values that are prescribed there, or forces.
    fn leaves_rest(&self, elimination: &Elimination, u: &[f64]) -> Result<bool, SolveError> {
        let processes = Processes::new(self.communicator, self.divided.clone());
        let form = self.system.form.name();
        let mut imposed = u.to_vec();
        elimination.impose(&mut imposed).map_err(NewtonFailure::Mismatch)?;
        if processes.any(form, imposed != u)? {
            return Ok(true);
        }
        let forces = processes.added_up(form, self.system.whole_residual(u))?;
        let forces = elimination.reduce(&forces).map_err(NewtonFailure::Mismatch)?;
        Ok(processes.any(form, forces.iter().any(|force| *force != 0.0))?)
    }

    /// The ways of all nodes of an unknown, of each cell at a surface that touches: half of the overlap toward the other one.
    fn ways(&self, number: usize, found: &FoundPairs<D>) -> Ways<D> {
        let space = &self.system.spaces[number];
        let mesh = space.mesh();
        let mut ways: Ways<D> = vec![([0.0; D], 0); space.unknowns() / D];
        for group in &found.pairs.groups {
            let stride = PairGroup::<D>::STRIDE;
            for (facets, points) in group.facets.iter().zip(group.points.chunks(group.count * stride)) {
                let size = diameter(mesh, facets[0]);
                for point in points.chunks(stride) {
                    let (gap, toward) = (point[2 * D + 1], &point[2 * D + 2..]);
                    if gap.abs() > TOUCHING * size {
                        continue;
                    }
                    for (facet, sign) in facets.iter().zip([0.5, -0.5]) {
                        if mesh.carries(facet.cell) {
                            continue;
                        }
                        for node in space.cell_nodes(facet.cell as usize) {
                            let (sum, count) = &mut ways[*node as usize];
                            (0..D).for_each(|k| sum[k] += sign * OVERLAP * size * toward[k]);
                            *count += 1;
                        }
                    }
                }
            }
        }
        ways
    }
}
