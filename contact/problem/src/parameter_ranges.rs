//! Ranges of a law's parameters: which have to be positive, which may be zero too, which have the length 1.

use forms_fem::contract::Source;
use forms_fem::prelude::*;

/// A forms module with its data bound, whose parameters have ranges: [`parameter_ranges!`](crate::parameter_ranges!) writes this for a
/// module's `Model`, and [`contact_law!`](crate::contact_law) does so on the way.
pub trait ParameterRanges {
    /// Whether the parameters are in their ranges. What is not finite is named when a form is bound to its data.
    ///
    /// # Errors
    /// [`AssemblyError::ParameterRange`] in the name of the form that was to be solved.
    fn check(&self, form: &'static str) -> Result<(), AssemblyError>;
}

/// Values that a parameter may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Above zero.
    Positive,
    /// Zero or above.
    NonNegative,
}

impl Range {
    /// Check that a constant member of the data lies in the range. Members that vary in space are not checked.
    ///
    /// # Errors
    /// [`AssemblyError::ParameterRange`].
    pub fn check(
        self,
        form: &'static str,
        parameter: &'static str,
        member: &impl Bounded,
    ) -> Result<(), AssemblyError> {
        let (outside, range): (fn(f64) -> bool, _) = match self {
            Range::Positive => (|value| value <= 0.0, "positive"),
            Range::NonNegative => (|value| value < 0.0, "zero or positive"),
        };
        match member.least() {
            Some(value) if outside(value) => {
                Err(AssemblyError::ParameterRange { form, parameter, value, range })
            }
            _ => Ok(()),
        }
    }
}

/// A member of a law's data whose least value is known.
pub trait Bounded {
    /// The least of its values, of its components if it is a vector; none where it varies in space.
    fn least(&self) -> Option<f64>;
}

impl Bounded for f64 {
    fn least(&self) -> Option<f64> {
        Some(*self)
    }
}

impl<const D: usize> Bounded for [f64; D] {
    fn least(&self) -> Option<f64> {
        self.iter().copied().reduce(f64::min)
    }
}

impl<const D: usize> Bounded for Given<f64, D> {
    fn least(&self) -> Option<f64> {
        match self.source() {
            Source::Constant(values) => values.iter().copied().reduce(f64::min),
            _ => None,
        }
    }
}

/// Rounding of a product of many rotations: entries of QᵀQ − I, and of det Q − 1, below this are none.
const ROTATION: f64 = 1e-9;

/// The check that a matrix is a rotation, QᵀQ = I and det Q = 1. What is not finite is named when a form is bound to its data.
///
/// # Errors
/// [`AssemblyError::NoRotation`].
pub fn check_rotation<const D: usize>(
    form: &'static str,
    parameter: &'static str,
    q: &[[f64; D]; D],
) -> Result<(), AssemblyError> {
    let product = |i: usize, j: usize| -> f64 { (0..D).map(|k| q[k][i] * q[k][j]).sum() };
    let pairs = (0..D).flat_map(|i| (0..D).map(move |j| (i, j)));
    let entry = |(i, j): (usize, usize)| (product(i, j) - if i == j { 1.0 } else { 0.0 }).abs();
    let largest = pairs.map(entry).fold(0.0, f64::max);
    let minor = |i: usize, j: usize| q[1][i] * q[D - 1][j] - q[1][j] * q[D - 1][i];
    let determinant = match D {
        2 => q[0][0] * q[1][1] - q[0][1] * q[1][0],
        _ => q[0][0] * minor(1, 2) - q[0][1] * minor(0, 2) + q[0][2] * minor(0, 1),
    };
    let deviation = if largest > ROTATION {
        format!("an entry of QᵀQ differs by {largest:.3} from that of the identity")
    } else if determinant < 0.0 {
        "it mirrors".to_owned()
    } else {
        return Ok(());
    };
    Err(AssemblyError::NoRotation { form, parameter, deviation })
}

/// The check that a constant vector has the length 1, up to 10⁻⁹. Members that vary in space are not checked.
///
/// # Errors
/// [`AssemblyError::NoUnitVector`].
pub fn check_unit<const D: usize>(
    form: &'static str,
    parameter: &'static str,
    vector: &Given<[f64; D], D>,
) -> Result<(), AssemblyError> {
    let Source::Constant(values) = vector.source() else { return Ok(()) };
    let length = values.iter().map(|value| value * value).sum::<f64>().sqrt();
    match (length - 1.0).abs() > ROTATION {
        true => Err(AssemblyError::NoUnitVector { form, parameter, length }),
        false => Ok(()),
    }
}

/// Says which members of a forms module's `Data` have to be positive, which may be zero too, and which are rotations and unit vectors.
/// A constant coefficient is looked at as a parameter is.
///
/// ```
/// # use forms_fem::prelude::*;
/// use forms_contact::parameter_ranges;
/// use forms_contact::parameter_ranges::ParameterRanges;
///
/// /// A layer that conducts.
/// #[forms]
/// pub mod layer {
///     pub struct Data {
///         conductivity: Param,
///         source: Param,
///     }
///     #[cells]
///     pub struct Omega;
///
///     pub fn heat(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
///         integral(Omega, conductivity * dot(grad(u), grad(v)) - source * v)
///     }
/// }
/// parameter_ranges!(layer { positive: conductivity, non_negative: source });
///
/// let model: layer::Model<2> = layer::Model::new(layer::data().conductivity(-2.0).source(0.0));
/// let told = model.check("heat").unwrap_err().to_string();
/// assert_eq!(told, "form `heat`: the parameter `conductivity` is -2; it must be positive");
/// ```
#[macro_export]
macro_rules! parameter_ranges {
    ($module:ident {
        $(positive: $($positive:ident).+,)*
        $(non_negative: $($non_negative:ident).+,)*
        $(rotation: $($rotation:ident).+,)*
        $(unit: $($unit:ident).+,)*
    }) => {
        impl<const D: usize> $crate::parameter_ranges::ParameterRanges for $module::Model<D>
        where
            $crate::fem::Dim: $crate::fem::Dimension<D>,
        {
            fn check(&self, form: &'static str) -> Result<(), $crate::fem::AssemblyError> {
                let _ = form;
                $($crate::parameter_ranges::Range::Positive.check(
                    form,
                    stringify!($($positive).+),
                    &self.data.$($positive).+,
                )?;)*
                $($crate::parameter_ranges::Range::NonNegative.check(
                    form,
                    stringify!($($non_negative).+),
                    &self.data.$($non_negative).+,
                )?;)*
                $($crate::parameter_ranges::check_rotation(
                    form,
                    stringify!($($rotation).+),
                    &self.data.$($rotation).+,
                )?;)*
                $($crate::parameter_ranges::check_unit(
                    form,
                    stringify!($($unit).+),
                    &self.data.$($unit).+,
                )?;)*
                Ok(())
            }
        }
    };
    // The last comma may be left out.
    ($module:ident { $($range:ident: $($member:ident).+),+ }) => {
        $crate::parameter_ranges!($module { $($range: $($member).+,)+ });
    };
}
