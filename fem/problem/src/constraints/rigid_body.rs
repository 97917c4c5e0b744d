//! Boundaries that move as a rigid body: a few of their unknowns give all the others.

use super::{Constraints, ConstraintsError, RigidMap};
use crate::instantiate::instantiate;
use crate::linear_algebra::rigid_motions;

/// A motion is new if it differs from those before by more than this part of the largest.
const INDEPENDENT: f64 = 1e-8;

/// Factors below this are rounding.
const ROUNDING: f64 = 1e-14;

impl<const D: usize> Constraints<D> {
    /// The nodes of a region move as one rigid body: u(x) = a + W x with a skew W, the small rotation of linear
    /// elasticity. Three of its unknowns (six in space) stay free and give all others. A load on the region acts on the
    /// body by its resultant and moment alone: a traction F/|Γ| states the total force F, and what the body feels is F
    /// whatever shape the traction has. On a part of a mesh each process has the region whole (`part.with_surfaces(..)`).
    ///
    /// # Errors
    /// A space without vectors of D components, an unknown region, on a part of a mesh one that is not whole, or a contradiction to earlier conditions.
    pub fn rigid_body(&mut self, region: &str) -> Result<(), ConstraintsError> {
        self.rigid_body_from(region, &RigidMap::translation([0.0; D]))
    }

    /// The nodes of a region move as one rigid body from where a motion has brought it: u(x) = y − x + a + W y with y = map(x) and a skew
    /// W. For large rotations: with the motion of the last solution ([`RigidMap::nearest`]) the problem is solved again, until W is zero
    /// to a tolerance; then the body is turned and not stretched, and its forces and moments balance where it is.
    ///
    /// # Errors
    /// As [`Constraints::rigid_body`]; [`ConstraintsError::NotRigid`].
    #[inline(never)]
    pub fn rigid_body_from(&mut self, region: &str, motion: &RigidMap<D>) -> Result<(), ConstraintsError> {
        let place = format!("region \"{region}\"");
        self.check_vectors(&place)?;
        check_motion(motion, &place)?;
        let nodes = self.nodes_to_relate(region, &place)?;
        let before = |node: &u32| self.space.positions()[*node as usize];
        let moved: Vec<f64> = nodes.iter().flat_map(|node| motion.displacement(&before(node))).collect();
        let positions: Vec<[f64; D]> = nodes.iter().map(|node| motion.apply(&before(node))).collect();
        let motions = rigid_motions(&positions);
        let Leading { unknowns: leaders, factors } = leading_unknowns(&motions);
        let unknown = |k: usize| nodes[k / D] as usize * D + k % D;
        let mut changed = self.clone();
        for (k, factors) in factors.iter().enumerate().filter(|(k, _)| !leaders.contains(k)) {
            let mut terms = vec![(unknown(k), 1.0)];
            let given = leaders.iter().zip(factors).filter(|(_, factor)| factor.abs() > ROUNDING);
            terms.extend(given.map(|(leader, factor)| (unknown(*leader), -factor)));
            let of_leaders: f64 =
                leaders.iter().zip(factors).map(|(leader, factor)| factor * moved[*leader]).sum();
            changed.add_equation(&place, &terms, moved[k] - of_leaders)?;
        }
        *self = changed;
        Ok(())
    }

    /// Prescribed rigid motion of a region, finite rotations included: u(x) = map(x) − x at its nodes.
    ///
    /// # Errors
    /// As [`Constraints::fix`]; [`ConstraintsError::NotRigid`].
    #[inline(never)]
    pub fn move_rigidly(&mut self, region: &str, motion: &RigidMap<D>) -> Result<(), ConstraintsError> {
        let place = format!("region \"{region}\"");
        self.check_vectors(&place)?;
        check_motion(motion, &place)?;
        let mut entries = Vec::new();
        for node in self.nodes_on(region, &place)? {
            let by = motion.displacement(&self.space.positions()[node as usize]);
            entries.extend((node as usize * D..).zip(by));
        }
        self.insert(&place, &entries)
    }
}

fn check_motion<const D: usize>(motion: &RigidMap<D>, place: &str) -> Result<(), ConstraintsError> {
    if motion.is_motion() {
        return Ok(());
    }
    let rotation = motion.rotation.iter().map(|row| row.to_vec()).collect();
    Err(ConstraintsError::NotRigid {
        place: place.to_owned(),
        rotation,
        translation: motion.translation.to_vec(),
    })
}

/// Unknowns whose values determine a motion.
struct Leading {
    unknowns: Vec<usize>,
    /// For every unknown, its value in the motion in which one leading unknown is 1 and the others 0.
    factors: Vec<Vec<f64>>,
}

/// Picks one unknown after the other, each time the one in which the motions that are left differ most, and orthogonalises
/// the others against it. Nodes on a point or on a line in space leave fewer unknowns than there are motions.
fn leading_unknowns(motions: &[Vec<f64>]) -> Leading {
    let count = motions.first().map_or(0, Vec::len);
    let values = |unknown: usize| -> Vec<f64> { motions.iter().map(|motion| motion[unknown]).collect() };
    let rows: Vec<Vec<f64>> = (0..count).map(values).collect();
    let mut rest = rows.clone();
    let mut leaders: Vec<usize> = Vec::new();
    let mut axes: Vec<Vec<f64>> = Vec::new();
    let mut first = 0.0;
    while leaders.len() < motions.len() {
        let largest = (0..count)
            .map(|k| (k, norm(&rest[k])))
            .reduce(|best, next| if next.1 > best.1 { next } else { best });
        let Some((leader, length)) = largest.filter(|(_, length)| *length > INDEPENDENT * first) else {
            break;
        };
        first = f64::max(first, length);
        let axis: Vec<f64> = rest[leader].iter().map(|value| value / length).collect();
        for row in &mut rest {
            let along = dot(row, &axis);
            row.iter_mut().zip(&axis).for_each(|(value, axis)| *value -= along * axis);
        }
        leaders.push(leader);
        axes.push(axis);
    }
    // A leader's row is a sum over the axes up to its own: the factors follow from the last to the first.
    let factors = rows.iter().map(|row| {
        let mut left: Vec<f64> = axes.iter().map(|axis| dot(row, axis)).collect();
        for last in (0..leaders.len()).rev() {
            let own = &rows[leaders[last]];
            left[last] /= dot(own, &axes[last]);
            for before in 0..last {
                left[before] -= left[last] * dot(own, &axes[before]);
            }
        }
        left
    });
    Leading { factors: factors.collect(), unknowns: leaders }
}

instantiate!(rigid_body: Constraints::<D>::rigid_body_from, Constraints::<D>::move_rigidly);

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leading_unknowns_give_every_rigid_motion() {
        let points = [[0.3, 0.1, 0.0], [1.0, 0.2, 0.4], [0.0, 0.9, 0.7], [0.5, 0.5, -1.0], [2.0, -0.3, 0.2]];
        let motions = rigid_motions(&points);
        let Leading { unknowns, factors } = leading_unknowns(&motions);
        assert_eq!(unknowns.len(), 6);
        for motion in &motions {
            for (value, factors) in motion.iter().zip(&factors) {
                let given: f64 = unknowns.iter().zip(factors).map(|(leader, a)| a * motion[*leader]).sum();
                assert!((given - value).abs() < 1e-12, "{given} {value}");
            }
        }
    }

    #[test]
    fn a_line_in_space_does_not_turn_about_itself() {
        let line: Vec<[f64; 3]> = (0..4).map(|k| [f64::from(k), 2.0 * f64::from(k), 0.5]).collect();
        assert_eq!(leading_unknowns(&rigid_motions(&line)).unknowns.len(), 5);
        assert_eq!(leading_unknowns(&rigid_motions(&[[0.5, 1.0]])).unknowns.len(), 2);
    }
}
