//! Comparison and arithmetic of dual numbers, among themselves and with plain ones.

use std::cmp::Ordering;
use std::iter::Sum;
use std::ops::{Add, AddAssign, Div, DivAssign, Mul, MulAssign, Neg, Sub, SubAssign};

use super::Dual;
use crate::real::Real;

/// By value: derivatives do not count.
impl<R: Real> PartialEq for Dual<R> {
    #[inline]
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl<R: Real> PartialEq<f64> for Dual<R> {
    #[inline]
    fn eq(&self, other: &f64) -> bool {
        self.value == *other
    }
}

/// By value: derivatives do not count.
impl<R: Real> PartialOrd for Dual<R> {
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

impl<R: Real> PartialOrd<f64> for Dual<R> {
    #[inline]
    fn partial_cmp(&self, other: &f64) -> Option<Ordering> {
        self.value.partial_cmp(other)
    }
}

impl<R: Real> Neg for Dual<R> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Dual { value: -self.value, derivative: -self.derivative }
    }
}

impl<R: Real> Add for Dual<R> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Dual { value: self.value + other.value, derivative: self.derivative + other.derivative }
    }
}

impl<R: Real> Sub for Dual<R> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Dual { value: self.value - other.value, derivative: self.derivative - other.derivative }
    }
}

impl<R: Real> Mul for Dual<R> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        let derivative = self.derivative * other.value + self.value * other.derivative;
        Dual { value: self.value * other.value, derivative }
    }
}

impl<R: Real> Div for Dual<R> {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Dual { value, derivative: (self.derivative - value * other.derivative) / other.value }
    }
}

impl<R: Real> Add<f64> for Dual<R> {
    type Output = Self;
    #[inline]
    fn add(self, other: f64) -> Self {
        Dual { value: self.value + other, ..self }
    }
}

impl<R: Real> Sub<f64> for Dual<R> {
    type Output = Self;
    #[inline]
    fn sub(self, other: f64) -> Self {
        Dual { value: self.value - other, ..self }
    }
}

impl<R: Real> Mul<f64> for Dual<R> {
    type Output = Self;
    #[inline]
    fn mul(self, other: f64) -> Self {
        Dual { value: self.value * other, derivative: self.derivative * other }
    }
}

impl<R: Real> Div<f64> for Dual<R> {
    type Output = Self;
    #[inline]
    fn div(self, other: f64) -> Self {
        Dual { value: self.value / other, derivative: self.derivative / other }
    }
}

/// `a += b` and the like, from `a + b`.
macro_rules! assignments {
    ($($assign:ident $method:ident $operator:tt),*) => {
        $(impl<R: Real> $assign for Dual<R> {
            #[inline]
            fn $method(&mut self, other: Self) {
                *self = *self $operator other;
            }
        }
        impl<R: Real> $assign<f64> for Dual<R> {
            #[inline]
            fn $method(&mut self, other: f64) {
                *self = *self $operator other;
            }
        })*
    };
}

assignments!(AddAssign add_assign +, SubAssign sub_assign -, MulAssign mul_assign *, DivAssign div_assign /);

impl<R: Real> Sum for Dual<R> {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::zero(), |sum, term| sum + term)
    }
}
