//! Four cells side by side: a lane type made of plain loops, to show that kernels are generic.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use forms_core::contract::Lane;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Four([f64; 4]);

impl Four {
    fn one(self, operation: impl Fn(f64) -> f64) -> Self {
        Four(self.0.map(operation))
    }
    fn two(self, other: Self, operation: impl Fn(f64, f64) -> f64) -> Self {
        Four(std::array::from_fn(|lane| operation(self.0[lane], other.0[lane])))
    }
    fn test(self, other: Self, operation: impl Fn(&f64, &f64) -> bool) -> [bool; 4] {
        std::array::from_fn(|lane| operation(&self.0[lane], &other.0[lane]))
    }
}

macro_rules! operator {
    ($($trait:ident $method:ident;)*) => { $(
        impl $trait for Four {
            type Output = Four;
            fn $method(self, other: Four) -> Four {
                self.two(other, f64::$method)
            }
        }
    )* };
}
operator! { Add add; Sub sub; Mul mul; Div div; }

impl Neg for Four {
    type Output = Four;
    fn neg(self) -> Four {
        self.one(f64::neg)
    }
}

impl AddAssign for Four {
    fn add_assign(&mut self, other: Four) {
        *self = *self + other;
    }
}

impl Lane for Four {
    const WIDTH: usize = 4;
    type Mask = [bool; 4];

    fn splat(value: f64) -> Self {
        Four([value; 4])
    }
    fn load(values: &[f64]) -> Self {
        Four(std::array::from_fn(|lane| values[lane]))
    }
    fn store(self, values: &mut [f64]) {
        values[..4].copy_from_slice(&self.0);
    }
    fn multiply_add(self, factor: Self, addend: Self) -> Self {
        self * factor + addend
    }
    fn sqrt(self) -> Self {
        self.one(f64::sqrt)
    }
    fn abs(self) -> Self {
        self.one(f64::abs)
    }
    fn powi(self, exponent: i32) -> Self {
        self.one(|value| value.powi(exponent))
    }
    fn minimum(self, other: Self) -> Self {
        self.two(other, |a, b| if b < a { b } else { a })
    }
    fn maximum(self, other: Self) -> Self {
        self.two(other, |a, b| if b > a { b } else { a })
    }
    fn less(self, other: Self) -> [bool; 4] {
        self.test(other, f64::lt)
    }
    fn less_equal(self, other: Self) -> [bool; 4] {
        self.test(other, f64::le)
    }
    fn equal(self, other: Self) -> [bool; 4] {
        self.test(other, f64::eq)
    }
    fn and(first: [bool; 4], second: [bool; 4]) -> [bool; 4] {
        std::array::from_fn(|lane| first[lane] && second[lane])
    }
    fn or(first: [bool; 4], second: [bool; 4]) -> [bool; 4] {
        std::array::from_fn(|lane| first[lane] || second[lane])
    }
    fn not(mask: [bool; 4]) -> [bool; 4] {
        mask.map(|truth| !truth)
    }
    fn select(mask: [bool; 4], taken: Self, otherwise: Self) -> Self {
        Four(std::array::from_fn(|lane| if mask[lane] { taken.0[lane] } else { otherwise.0[lane] }))
    }
}
