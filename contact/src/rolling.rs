//! Positions of a wheel that rolls slowly on flat ground, and a criterion over all of them.
//!
//! The mesh stays, and the ground turns around it. With θ = 0 all positions have the same linear part, so that problems with one
//! [`CondensedSolver`] and [`Problem::expecting_changes_at`] share its factor, adjoint problems included. For other θ the term
//! σ_n(u) σ_n(v) of (15) has the normal of the position in it, and each has its own.

use std::f64::consts::TAU;

use forms_fem::prelude::*;
use thiserror::Error;

use crate::forms;
use crate::load_and_pressure::load_and_pressure;

/// Flat ground as a wheel about the origin sees it after it has rolled by an angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ground {
    /// The angle by which the wheel has turned clockwise, and the ground about it counter-clockwise; at 0 the ground is below.
    pub angle: f64,
    /// Distance from the origin \[length\].
    pub distance: f64,
}

impl Ground {
    /// A number of positions M between two sectors of a wheel that has n equal ones, or one: the angles 2πm/(nM), m = 0 … M − 1.
    pub fn in_sector(distance: f64, sectors: usize, count: usize) -> Vec<Self> {
        let step = TAU / (sectors.max(1) * count) as f64;
        (0..count).map(|m| Ground { angle: step * m as f64, distance }).collect()
    }

    /// A vector of the room, as the wheel sees it.
    pub fn seen(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sine, cosine) = self.angle.sin_cos();
        [cosine * x - sine * y, sine * x + cosine * y]
    }

    /// n_y, into the ground.
    pub fn normal(&self) -> [f64; 2] {
        self.seen([0.0, -1.0])
    }

    /// The gap g at a point of the wheel \[length\].
    pub fn gap(&self, x: &[f64; 2]) -> f64 {
        let normal = self.normal();
        self.distance - (normal[0] * x[0] + normal[1] * x[1])
    }

    /// The paper's law on this ground: n_y, the gap, and F of the criterion, which is `criterion_force` in the room.
    pub fn law(&self, law: &forms::Model<2>, criterion_force: [f64; 2]) -> forms::Model<2> {
        let (ground, normal) = (*self, self.normal());
        let gap = Given::function_with_gradient(move |x| ground.gap(x), move |_| normal.map(|n| -n));
        let data = law.data.clone().obstacle_normal(normal).gap(gap);
        let data = data.criterion_force(self.seen(criterion_force));
        forms::Model { data, regions: law.regions.clone() }
    }
}

/// Numbers of a wheel in a position, or the derivatives of a criterion by them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PositionNumbers {
    /// W = ∫ F·u.
    pub work: f64,
    /// ∫p, the reaction of the ground.
    pub reaction: f64,
    /// ∫p².
    pub square: f64,
}

impl PositionNumbers {
    /// Numbers of a displacement, with the contact pressure p = \[σ_n − γ(u_n − g)\]₋.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn of(law: &forms::Model<2>, assembler: &Assembler<2>, u: &Field<2>) -> Result<Self, AssemblyError> {
        // All by the form whose derivative the adjoint has, so that they have its quadrature points.
        let of = |weights: PositionNumbers| assembler.functional(&weights.criterion(law).criterion(u));
        let none = PositionNumbers::default();
        Ok(PositionNumbers {
            work: of(PositionNumbers { work: 1.0, ..none })?,
            reaction: of(PositionNumbers { reaction: 1.0, ..none })?,
            square: of(PositionNumbers { square: 1.0, ..none })?,
        })
    }

    /// The criterion with these weights.
    fn criterion(&self, law: &forms::Model<2>) -> load_and_pressure::Model<2> {
        let forms::Regions { omega, gamma_n, gamma_c, .. } = law.regions.clone();
        let data = load_and_pressure::data_from(law.data.clone()).load(0.0);
        let data = data.square(self.square).linear(self.reaction).weight(self.work);
        load_and_pressure::Model { data, regions: load_and_pressure::Regions { omega, gamma_n, gamma_c } }
    }

    /// The discrete adjoint (21) of a criterion with these derivatives.
    pub fn adjoint(&self, law: &forms::Model<2>, u: &Field<2>) -> Form<2> {
        self.criterion(law).adjoint(u)
    }

    /// L ∫p²/(∫p)²: 1 where the pressure is constant over the length L, more where it is higher on less.
    pub fn unevenness(&self, length: f64) -> f64 {
        length * self.square / self.reaction.powi(2)
    }
}

/// J over M positions: (mean of W^q)^{1/q} + a × mean of L ∫p²/(∫p)² + b × variance of ∫p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollingCriterion {
    /// q ≥ 1; with 1 it is the mean, with a large one almost the largest.
    pub exponent: f64,
    /// a \[criterion\].
    pub unevenness: f64,
    /// L \[length\].
    pub length: f64,
    /// b \[criterion/force²\].
    pub variance: f64,
}

impl Default for RollingCriterion {
    /// The mean of W.
    fn default() -> Self {
        RollingCriterion { exponent: 1.0, unevenness: 0.0, length: 1.0, variance: 0.0 }
    }
}

/// Reasons why there is no J.
#[derive(Clone, Debug, PartialEq, Error)]
#[allow(missing_docs)]
pub enum RollingError {
    #[error("there is no position of the wheel")]
    NoPositions,
    #[error("q = {exponent} is no exponent of a mean: it is at least 1")]
    Exponent { exponent: f64 },
    #[error("position {position} does not touch the ground, and has no even pressure")]
    Apart { position: usize },
    #[error("position {position} has W = {work}, and powers are of positive numbers")]
    Work { position: usize, work: f64 },
}

impl RollingCriterion {
    /// J.
    ///
    /// # Errors
    /// [`RollingError`]: no positions, or numbers without J.
    pub fn value(&self, positions: &[PositionNumbers]) -> Result<f64, RollingError> {
        self.check(positions)?;
        let mut sum = self.mean_work(positions);
        if self.unevenness != 0.0 {
            sum += self.unevenness * mean(positions, |of| of.unevenness(self.length));
        }
        if self.variance != 0.0 {
            let middle = mean(positions, |of| of.reaction);
            sum += self.variance * mean(positions, |of| (of.reaction - middle).powi(2));
        }
        Ok(sum)
    }

    /// The derivatives of J by the numbers of each position.
    ///
    /// # Errors
    /// As [`RollingCriterion::value`].
    pub fn derivatives(&self, positions: &[PositionNumbers]) -> Result<Vec<PositionNumbers>, RollingError> {
        self.check(positions)?;
        let share = 1.0 / positions.len() as f64;
        let (mean_work, middle) = (self.mean_work(positions), mean(positions, |of| of.reaction));
        let of_position = |of: &PositionNumbers| {
            let mut by = PositionNumbers { work: share, ..PositionNumbers::default() };
            if self.exponent != 1.0 {
                by.work *= (of.work / mean_work).powf(self.exponent - 1.0);
            }
            if self.unevenness != 0.0 {
                let weight = share * self.unevenness;
                by.square += weight * self.length / of.reaction.powi(2);
                by.reaction -= 2.0 * weight * of.unevenness(self.length) / of.reaction;
            }
            by.reaction += 2.0 * share * self.variance * (of.reaction - middle);
            by
        };
        Ok(positions.iter().map(of_position).collect())
    }

    fn mean_work(&self, positions: &[PositionNumbers]) -> f64 {
        match self.exponent {
            1.0 => mean(positions, |of| of.work),
            // Relative to the largest, powers stay within the range of numbers.
            q => {
                let largest = positions.iter().map(|of| of.work).fold(0.0, f64::max);
                largest * mean(positions, |of| (of.work / largest).powf(q)).powf(1.0 / q)
            }
        }
    }

    fn check(&self, positions: &[PositionNumbers]) -> Result<(), RollingError> {
        let exponent = self.exponent;
        if positions.is_empty() {
            return Err(RollingError::NoPositions);
        }
        if !(exponent >= 1.0 && exponent.is_finite()) {
            return Err(RollingError::Exponent { exponent });
        }
        for (position, PositionNumbers { work, reaction, .. }) in positions.iter().enumerate() {
            // NaN is not positive.
            if exponent != 1.0 && (*work <= 0.0 || work.is_nan()) {
                return Err(RollingError::Work { position, work: *work });
            }
            if self.unevenness != 0.0 && *reaction <= 0.0 {
                return Err(RollingError::Apart { position });
            }
        }
        Ok(())
    }
}

fn mean(positions: &[PositionNumbers], of: impl Fn(&PositionNumbers) -> f64) -> f64 {
    positions.iter().map(of).sum::<f64>() / positions.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    const POSITIONS: [PositionNumbers; 3] = [
        PositionNumbers { work: 3.0, reaction: 2.0, square: 5.0 },
        PositionNumbers { work: 2.5, reaction: 1.5, square: 2.0 },
        PositionNumbers { work: 4.0, reaction: 2.5, square: 3.0 },
    ];

    #[test]
    fn j_by_hand() {
        let mean = RollingCriterion::default();
        assert!((mean.value(&POSITIONS).unwrap() - 9.5 / 3.0).abs() < 1e-15);
        let all = RollingCriterion { exponent: 2.0, unevenness: 0.1, length: 0.5, variance: 3.0 };
        let root = ((9.0 + 6.25 + 16.0) / 3.0_f64).sqrt();
        let unevenness = 0.5 * (5.0 / 4.0 + 2.0 / 2.25 + 3.0 / 6.25) / 3.0;
        let by_hand = root + 0.1 * unevenness + 3.0 * 0.5 / 3.0;
        assert!((all.value(&POSITIONS).unwrap() - by_hand).abs() < 1e-14);
        let large = RollingCriterion { exponent: 2000.0, ..mean };
        assert!((large.value(&POSITIONS).unwrap() - 4.0).abs() < 3e-3);
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let all = RollingCriterion { exponent: 3.0, unevenness: 0.7, length: 0.5, variance: 1.3 };
        let derivatives = all.derivatives(&POSITIONS).unwrap();
        let step = 1e-5;
        for (position, by) in derivatives.iter().enumerate() {
            let moved = |change: &dyn Fn(&mut PositionNumbers)| {
                let mut positions = POSITIONS;
                change(&mut positions[position]);
                all.value(&positions).unwrap()
            };
            let slopes = [
                moved(&|of| of.work += step) - moved(&|of| of.work -= step),
                moved(&|of| of.reaction += step) - moved(&|of| of.reaction -= step),
                moved(&|of| of.square += step) - moved(&|of| of.square -= step),
            ];
            for (slope, by) in slopes.iter().zip([by.work, by.reaction, by.square]) {
                assert!((slope / (2.0 * step) - by).abs() < 1e-9, "{slope} {by}");
            }
        }
    }

    #[test]
    fn numbers_without_a_criterion_are_refused() {
        let all = RollingCriterion { exponent: 2.0, unevenness: 1.0, ..RollingCriterion::default() };
        assert_eq!(all.value(&[]), Err(RollingError::NoPositions));
        let apart = PositionNumbers { work: 1.0, ..PositionNumbers::default() };
        assert_eq!(all.derivatives(&[apart]), Err(RollingError::Apart { position: 0 }));
        let even = RollingCriterion { unevenness: 0.0, ..all };
        let negative = PositionNumbers { work: -1.0, ..apart };
        assert_eq!(even.value(&[apart, negative]), Err(RollingError::Work { position: 1, work: -1.0 }));
        assert!(RollingCriterion { exponent: 0.5, ..even }.value(&[apart]).is_err());
    }

    /// A point of the rim that faces the ground is as far from it in all positions, and the wheel sees vectors turned.
    #[test]
    fn ground_turns_about_the_wheel() {
        for (m, ground) in Ground::in_sector(30.0, 24, 4).iter().enumerate() {
            assert!((ground.angle - TAU * m as f64 / 96.0).abs() < 1e-15);
            let below = ground.seen([0.0, -29.0]);
            assert!((ground.gap(&below) - 1.0).abs() < 1e-12 && (ground.gap(&[0.0; 2]) - 30.0).abs() < 1e-12);
            let (normal, along) = (ground.normal(), ground.seen([1.0, 0.0]));
            assert!((normal[0] * along[0] + normal[1] * along[1]).abs() < 1e-15);
            assert!(m > 0 || (normal, ground.gap(&[0.3, -29.0])) == ([0.0, -1.0], 1.0));
            assert!((normal[0] > 0.0) == (m > 0));
        }
    }
}
