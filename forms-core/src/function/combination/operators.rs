//! Arithmetic of forms, energies and functionals: `&a + &b`, `a - b`, `2.0 * &a`, `-a`, and sums of iterators.

use std::iter::Sum;
use std::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};
use std::sync::Arc;

use super::{Use, combine};
use crate::function::{Energy, Form, Function, Functional};
use crate::integrals::CombiningBackend;

impl<const D: usize, B: CombiningBackend<D>> Form<D, B> {
    fn combined<'a>(addends: impl IntoIterator<Item = (f64, &'a Function<D, B>)>) -> Self {
        Form(Arc::new(combine(addends, Use::Form)))
    }
}

impl<const D: usize, B: CombiningBackend<D>> Energy<D, B> {
    fn combined<'a>(addends: impl IntoIterator<Item = (f64, &'a Function<D, B>)>) -> Self {
        Energy(Form(Arc::new(combine(addends, Use::Value))))
    }
}

impl<const D: usize, B: CombiningBackend<D>> Functional<D, B> {
    fn combined<'a>(addends: impl IntoIterator<Item = (f64, &'a Function<D, B>)>) -> Self {
        Functional(Arc::new(combine(addends, Use::Value)))
    }
}

/// Sums and differences of two types.
macro_rules! sums {
    ($($left:ty, $right:ty => $sum:ident;)*) => {$(
        impl<const D: usize, B: CombiningBackend<D>> Add<$right> for $left {
            type Output = $sum<D, B>;

            fn add(self, other: $right) -> $sum<D, B> {
                $sum::combined([(1.0, self.function()), (1.0, other.function())])
            }
        }

        impl<const D: usize, B: CombiningBackend<D>> Sub<$right> for $left {
            type Output = $sum<D, B>;

            fn sub(self, other: $right) -> $sum<D, B> {
                $sum::combined([(1.0, self.function()), (-1.0, other.function())])
            }
        }
    )*};
}

/// Sums and differences of values and of references.
macro_rules! all_sums {
    ($($left:ident, $right:ident => $sum:ident;)*) => {$(
        sums! {
            $left<D, B>, $right<D, B> => $sum;
            &$left<D, B>, $right<D, B> => $sum;
            $left<D, B>, &$right<D, B> => $sum;
            &$left<D, B>, &$right<D, B> => $sum;
        }
    )*};
}

all_sums! {
    Form, Form => Form;
    Form, Energy => Form;
    Energy, Form => Form;
    Energy, Energy => Energy;
    Functional, Functional => Functional;
}

/// Multiples of a type.
macro_rules! multiples {
    ($($type:ty => $multiple:ident;)*) => {$(
        impl<const D: usize, B: CombiningBackend<D>> Mul<$type> for f64 {
            type Output = $multiple<D, B>;

            fn mul(self, function: $type) -> $multiple<D, B> {
                $multiple::combined([(self, function.function())])
            }
        }

        impl<const D: usize, B: CombiningBackend<D>> Mul<f64> for $type {
            type Output = $multiple<D, B>;

            fn mul(self, factor: f64) -> $multiple<D, B> {
                $multiple::combined([(factor, self.function())])
            }
        }

        impl<const D: usize, B: CombiningBackend<D>> Neg for $type {
            type Output = $multiple<D, B>;

            fn neg(self) -> $multiple<D, B> {
                $multiple::combined([(-1.0, self.function())])
            }
        }
    )*};
}

multiples! {
    Form<D, B> => Form;
    &Form<D, B> => Form;
    Energy<D, B> => Energy;
    &Energy<D, B> => Energy;
    Functional<D, B> => Functional;
    &Functional<D, B> => Functional;
}

/// Sums of lists, and in place.
macro_rules! lists {
    ($($sum:ident)*) => {$(
        impl<'a, const D: usize, B: CombiningBackend<D>> Sum<&'a $sum<D, B>> for $sum<D, B> {
            fn sum<I: Iterator<Item = &'a $sum<D, B>>>(list: I) -> Self {
                $sum::combined(list.map(|one| (1.0, one.function())))
            }
        }

        impl<const D: usize, B: CombiningBackend<D>> Sum for $sum<D, B> {
            fn sum<I: Iterator<Item = Self>>(list: I) -> Self {
                let list: Vec<Self> = list.collect();
                list.iter().sum()
            }
        }

        impl<const D: usize, B: CombiningBackend<D>> AddAssign<&$sum<D, B>> for $sum<D, B> {
            fn add_assign(&mut self, other: &$sum<D, B>) {
                *self = &*self + other;
            }
        }

        impl<const D: usize, B: CombiningBackend<D>> AddAssign for $sum<D, B> {
            fn add_assign(&mut self, other: Self) {
                *self += &other;
            }
        }

        impl<const D: usize, B: CombiningBackend<D>> SubAssign<&$sum<D, B>> for $sum<D, B> {
            fn sub_assign(&mut self, other: &$sum<D, B>) {
                *self = &*self - other;
            }
        }

        impl<const D: usize, B: CombiningBackend<D>> SubAssign for $sum<D, B> {
            fn sub_assign(&mut self, other: Self) {
                *self -= &other;
            }
        }
    )*};
}

lists! { Form Energy Functional }
