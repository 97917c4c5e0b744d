//! Tractions at the points of a contact near the origin, and what Hertz's profile would be like that fits them.

use forms_fem::prelude::*;

use crate::contact_problem::ContactProblem;
use crate::hertz::Hertz;
use crate::laws::two_bodies as law;

/// Tractions at a point of one of the surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Traction<const D: usize> {
    /// The point \[mm\].
    pub position: [f64; D],
    /// Weight of the quadrature, for the mean of both surfaces.
    pub weight: f64,
    /// Contact pressure \[MPa\].
    pub pressure: f64,
    /// Friction on the lower body along x \[MPa\].
    pub shear: f64,
}

impl<const D: usize> Traction<D> {
    /// Distance from the axis \[mm\].
    pub fn distance(&self) -> f64 {
        super::distance_from_axis(&self.position)
    }
}

/// Tractions of both surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct Tractions<const D: usize> {
    /// Tractions at all points that have an opposite point.
    pub points: Vec<Traction<D>>,
}

impl<const D: usize> Tractions<D>
where
    Dim: Dimension<D>,
{
    /// The tractions of a displacement.
    ///
    /// # Errors
    /// Data that do not fit.
    pub fn of(problem: &ContactProblem<D, law::Model<D>>, u: &Field<D>) -> Result<Self, AssemblyError> {
        let (degree, mut points) = (super::DEGREES[D - 2], Vec::new());
        let pairings = problem.law.regions.touch.0.pairing.iter();
        for facing in pairings.flat_map(|pairing| &pairing.surfaces) {
            let pairing = Pairing::onto(&facing.own, &facing.opposite);
            let pressures = problem.assembler.at_pairs(&problem.law.contact_pressure(u), &pairing, degree)?;
            let frictions =
                problem.assembler.at_pairs(&problem.law.friction_traction(u), &pairing, degree)?;
            let sign = if facing.own == super::SURFACES[0] { 1.0 } else { -1.0 };
            let places = pressures.positions.into_iter().zip(pressures.weights);
            let values = pressures.values.iter().zip(&frictions.values);
            points.extend(places.zip(values).map(|((position, weight), (pressure, friction))| Traction {
                position,
                weight: problem.law.data.share * weight,
                pressure: pressure[0],
                shear: sign * friction[0],
            }));
        }
        Ok(Tractions { points })
    }

    fn sum(&self, value: impl Fn(&Traction<D>) -> f64) -> f64 {
        self.points.iter().map(|point| point.weight * value(point)).sum()
    }

    /// The force that presses \[N, in the plane N/mm\], of the part of the bodies that is computed.
    pub fn force(&self) -> f64 {
        self.sum(|point| point.pressure)
    }

    /// The force of friction on the lower body along x.
    pub fn shear(&self) -> f64 {
        self.sum(|point| point.shear)
    }

    /// a and p0 of the profile p0 √(1 − r²/a²) that has the second moment of the pressure and its mean within a quarter of a.
    pub fn fitted(&self) -> Hertz {
        // ∫ p r² / ∫ p is a²/4 in the plane and 2a²/5 in space.
        let part = if D == 2 { 0.25 } else { 0.4 };
        let moment = self.sum(|point| point.pressure * point.distance().powi(2));
        let reach = (moment / (part * self.force())).sqrt();
        let unit = Hertz { reach, peak: 1.0 };
        let near = |point: &Traction<D>| f64::from(u8::from(point.distance() < 0.25 * reach));
        let peak = self.sum(|point| near(point) * point.pressure)
            / self.sum(|point| near(point) * unit.pressure(point.distance()));
        Hertz { reach, peak }
    }

    /// ‖p_h − p‖/‖p‖ in L² of the surfaces.
    pub fn profile_error(&self, hertz: &Hertz) -> f64 {
        let exact = |point: &Traction<D>| hertz.pressure(point.distance());
        (self.sum(|point| (point.pressure - exact(point)).powi(2)) / self.sum(|point| exact(point).powi(2)))
            .sqrt()
    }
}
