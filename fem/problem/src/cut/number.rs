//! Numbers for places and weights of points: values, or values with their derivatives by some nodal values of the level set function.

use std::fmt::Debug;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// Nodal values by which is differentiated at a time: those of a square of degree 2, and a third of those of a cube.
pub(crate) const VARIED: usize = 9;

/// A number with arithmetic and square roots. Choices are made by its value, so that derivatives come from the same lines.
pub(crate) trait Number:
    Copy
    + Debug
    + 'static
    + From<f64>
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Add<f64, Output = Self>
    + Mul<f64, Output = Self>
    + AddAssign
    + Sum
{
    /// The value at the node of this number among those by which is differentiated.
    fn of_node(value: f64, number: usize) -> Self;
    /// The number without its derivatives.
    fn value(self) -> f64;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self {
        if self.value() < 0.0 { -self } else { self }
    }
    /// 0.
    fn zero() -> Self {
        Self::from(0.0)
    }
    /// 1.
    fn one() -> Self {
        Self::from(1.0)
    }
}

impl Number for f64 {
    fn of_node(value: f64, _: usize) -> f64 {
        value
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
}

/// A value with its derivatives by several nodal values: a dual number with [`VARIED`] components.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Varied {
    pub value: f64,
    pub slopes: [f64; VARIED],
}

impl Varied {
    /// A function of two numbers with its derivatives by them.
    #[inline(always)]
    fn of(value: f64, [a, b]: [f64; 2], [x, y]: [&Self; 2]) -> Self {
        Varied { value, slopes: std::array::from_fn(|k| a * x.slopes[k] + b * y.slopes[k]) }
    }

    /// A function of one number with its derivative.
    #[inline(always)]
    fn chain(value: f64, a: f64, x: &Self) -> Self {
        Varied { value, slopes: x.slopes.map(|slope| a * slope) }
    }
}

impl Number for Varied {
    fn of_node(value: f64, number: usize) -> Self {
        let slopes = std::array::from_fn(|k| if k == number { 1.0 } else { 0.0 });
        Varied { value, slopes }
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        Varied::chain(root, 0.5 / root, &self)
    }
}

impl From<f64> for Varied {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Varied { value, slopes: [0.0; VARIED] }
    }
}

impl Neg for Varied {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Varied::chain(-self.value, -1.0, &self)
    }
}

/// Operators between two numbers, with the derivatives of the result.
macro_rules! operators {
    ($($operator:ident::$name:ident: |$a:ident, $b:ident| $value:expr, $slopes:expr;)+) => {
        $(impl $operator for Varied {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let ($a, $b) = (self.value, other.value);
                Varied::of($value, $slopes, [&self, &other])
            }
        })+
    };
}

operators! {
    Add::add: |a, b| a + b, [1.0, 1.0];
    Sub::sub: |a, b| a - b, [1.0, -1.0];
    Mul::mul: |a, b| a * b, [b, a];
    Div::div: |a, b| a / b, [1.0 / b, -a / (b * b)];
}

impl Add<f64> for Varied {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f64) -> Self {
        Varied { value: self.value + other, ..self }
    }
}

impl Mul<f64> for Varied {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        Varied::chain(self.value * factor, factor, &self)
    }
}

impl AddAssign for Varied {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl Sum for Varied {
    fn sum<I: Iterator<Item = Self>>(numbers: I) -> Self {
        numbers.fold(Varied::zero(), |sum, number| sum + number)
    }
}
