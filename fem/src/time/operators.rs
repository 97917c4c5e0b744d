//! Operators of forms of motion: what a scheme evaluates in a step, from the step's unknown.
//!
//! Each is a weight times the unknown plus a known field; a [`Step`](super::Step) gives all six as the `Data` of these modules.

use crate::contract::Given;

use crate::forms;

/// Displacement, velocity and acceleration of a vector unknown.
#[forms(crate = crate)]
pub mod vector {
    /// Weights and known parts of a step.
    pub struct Data {
        /// Weight of the unknown in the displacement \[1; time² where the unknown is an acceleration\].
        pub value_weight: Param,
        /// Weight of the unknown in the velocity \[1/time; time where the unknown is an acceleration\].
        pub rate_weight: Param,
        /// Weight of the unknown in the acceleration \[1/time²; 1 where the unknown is an acceleration\].
        pub second_rate_weight: Param,
        /// Known part of the displacement.
        pub known_value: Given<Vector>,
        /// Known part of the velocity.
        pub known_rate: Given<Vector>,
        /// Known part of the acceleration.
        pub known_second_rate: Given<Vector>,
    }

    /// The displacement at which the scheme evaluates forces.
    pub fn displacement(u: Vector) -> Vector {
        value_weight * u + known_value
    }

    /// The velocity there.
    pub fn velocity(u: Vector) -> Vector {
        rate_weight * u + known_rate
    }

    /// The acceleration at which the scheme evaluates inertia.
    pub fn acceleration(u: Vector) -> Vector {
        second_rate_weight * u + known_second_rate
    }
}

/// Value, rate and second rate of a scalar unknown.
#[forms(crate = crate)]
pub mod scalar {
    /// Weights and known parts of a step.
    pub struct Data {
        /// Weight of the unknown in the value \[1; time² where the unknown is a second rate\].
        pub value_weight: Param,
        /// Weight of the unknown in the rate \[1/time; time where the unknown is a second rate\].
        pub rate_weight: Param,
        /// Weight of the unknown in the second rate \[1/time²; 1 where the unknown is a second rate\].
        pub second_rate_weight: Param,
        /// Known part of the value.
        pub known_value: Given<Scalar>,
        /// Known part of the rate.
        pub known_rate: Given<Scalar>,
        /// Known part of the second rate.
        pub known_second_rate: Given<Scalar>,
    }

    /// The value at which the scheme evaluates the form.
    pub fn value(u: Scalar) -> Scalar {
        value_weight * u + known_value
    }

    /// The rate of change there.
    pub fn rate(u: Scalar) -> Scalar {
        rate_weight * u + known_rate
    }

    /// The rate of change of the rate there.
    pub fn second_rate(u: Scalar) -> Scalar {
        second_rate_weight * u + known_second_rate
    }
}

/// Value and rate of a scalar unknown next to a vector unknown, as temperature or pressure next to a displacement: the members of
/// [`vector`], which serve the vector, and these. `&[Step; 2]` of a [coupled loop](super::TimeLoop::coupled), the vector first, is its data.
#[forms(crate = crate)]
pub mod vector_and_scalar {
    /// Weights and known parts of a step of both unknowns.
    #[includes(super::vector::Data)]
    pub struct Data {
        /// Weight of the unknown in the value \[1\].
        pub scalar_value_weight: Param,
        /// Weight of the unknown in the rate \[1/time\].
        pub scalar_rate_weight: Param,
        /// Known part of the value.
        pub known_scalar_value: Given<Scalar>,
        /// Known part of the rate.
        pub known_scalar_rate: Given<Scalar>,
    }

    /// The value at which the scheme evaluates the form.
    pub fn value(u: Scalar) -> Scalar {
        scalar_value_weight * u + known_scalar_value
    }

    /// The rate of change there.
    pub fn rate(u: Scalar) -> Scalar {
        scalar_rate_weight * u + known_scalar_rate
    }
}

/// Data of no step: for functionals of the same module, which read none.
impl<const D: usize> Default for vector::Data<D> {
    fn default() -> Self {
        let none = || Given::constant([0.0; D]);
        vector::data()
            .value_weight(0.0)
            .rate_weight(0.0)
            .second_rate_weight(0.0)
            .known_value(none())
            .known_rate(none())
            .known_second_rate(none())
    }
}

/// Data of no step: for functionals of the same module, which read none.
impl<const D: usize> Default for scalar::Data<D> {
    fn default() -> Self {
        let none = || Given::constant(0.0);
        scalar::data()
            .value_weight(0.0)
            .rate_weight(0.0)
            .second_rate_weight(0.0)
            .known_value(none())
            .known_rate(none())
            .known_second_rate(none())
    }
}

/// Data of no step: for functionals of the same module, which read none.
impl<const D: usize> Default for vector_and_scalar::Data<D> {
    fn default() -> Self {
        let none = || Given::constant(0.0);
        vector_and_scalar::data_from(vector::Data::default())
            .scalar_value_weight(0.0)
            .scalar_rate_weight(0.0)
            .known_scalar_value(none())
            .known_scalar_rate(none())
    }
}
