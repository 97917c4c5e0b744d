//! Contact zones as parts of the outer circle, bounded by the zeros of β_h.

use forms_contact::ContactProblem;
use forms_contact::forms;
use forms_contact::hollow_cylinder::{CONTACT, OUTER_RADIUS};
use forms_fem::prelude::*;

/// β_h along a facet is interpolated with this degree before its zeros are found; on the straight facet it has degree 2.
const DEGREE: usize = 8;
/// Parts whose ends are this close are one: facets meet within rounding \[cm\].
const MEETING: f64 = 1e-9;

/// The contact zone, β_h > 0, as intervals of the arc length on the outer circle from its lowest point \[cm\], ascending.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactZone {
    /// Neither overlapping nor meeting.
    pub parts: Vec<[f64; 2]>,
}

impl ContactZone {
    /// The zone of a displacement.
    pub fn of(problem: &ContactProblem<2>, u: &Field<2>) -> Result<ContactZone, AssemblyError> {
        let indicator = forms::contact_indicator(&problem.law.data, u);
        let found = problem.assembler.positive_parts(&indicator, CONTACT, DEGREE)?;
        let arc = |[x, y]: [f64; 2]| OUTER_RADIUS * x.atan2(-y);
        let ends = |part: &[[f64; 2]; 2]| {
            let [a, b] = part.map(arc);
            [a.min(b), a.max(b)]
        };
        Ok(ContactZone::joined(found.iter().map(|part| ends(&part.positions)).collect()))
    }

    fn joined(mut parts: Vec<[f64; 2]>) -> ContactZone {
        parts.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut joined: Vec<[f64; 2]> = Vec::new();
        for [start, end] in parts {
            match joined.last_mut() {
                Some(last) if start - last[1] < MEETING => last[1] = last[1].max(end),
                _ => joined.push([start, end]),
            }
        }
        ContactZone { parts: joined }
    }

    /// Its length \[cm\].
    pub fn length(&self) -> f64 {
        self.parts.iter().map(|[start, end]| end - start).sum()
    }

    /// Length of the part outside another zone \[cm\]; exactly zero if it lies inside.
    pub fn outside(&self, other: &ContactZone) -> f64 {
        let mut outside = 0.0;
        for &[start, end] in &self.parts {
            let mut reached = start;
            for &[from, to] in &other.parts {
                outside += (from.min(end) - reached).max(0.0);
                reached = reached.max(to);
            }
            outside += (end - reached).max(0.0);
        }
        outside
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn zone(parts: &[[f64; 2]]) -> ContactZone {
        ContactZone::joined(parts.to_vec())
    }

    #[test]
    fn parts_that_meet_are_one() {
        let joined = zone(&[[1.0, 2.0], [-1.0, 0.0], [0.0, 0.5], [2.0 - 1e-12, 3.0]]);
        assert_eq!(joined.parts, [[-1.0, 0.5], [1.0, 3.0]]);
        assert!((joined.length() - 3.5).abs() < 1e-15);
    }

    #[test]
    fn what_lies_outside_is_measured() {
        let (a, b) = (zone(&[[-3.0, -1.0], [0.0, 4.0]]), zone(&[[-2.0, 1.0], [2.0, 5.0]]));
        assert!((a.outside(&b) - 2.0).abs() < 1e-15);
        assert!((b.outside(&a) - 2.0).abs() < 1e-15);
        assert_eq!(zone(&[[0.5, 0.7]]).outside(&a), 0.0);
        assert!((a.outside(&ContactZone::default()) - 6.0).abs() < 1e-15);
        assert_eq!(ContactZone::default().outside(&a), 0.0);
    }
}
