//! Types and arithmetic of the bodies of forms, as an editor reads them: it shows what a name is, the compiler judges shapes.

use std::ops::{Add, Div, Index, Mul, Neg, Sub};

use super::{Form, Scalar, Tensor, Vector};

pub type Param<T = Scalar> = T;
pub type Given<T> = T;
pub type Carried<T> = T;
pub type History<T> = T;
pub type Unknown<T> = T;
pub type Test<T> = T;
pub type State<T> = T;
pub type Table = fn(Scalar) -> Scalar;
pub type Energy = Form;
pub type Functional = Form;
pub type Tensor4 = Tensor;

/// A value of any kind.
#[inline]
pub fn any<T>() -> T {
    unreachable!("bodies of forms are read by editors, and run by nobody")
}

macro_rules! arithmetic {
    ($($left:ty, $right:ty => $result:ty;)*) => { $(
        impl Mul<$right> for $left {
            type Output = $result;
            fn mul(self, _: $right) -> $result {
                any()
            }
        }
    )* };
}

arithmetic! {
    Scalar, Scalar => Scalar; Scalar, Vector => Vector; Scalar, Tensor => Tensor;
    Vector, Scalar => Vector; Tensor, Scalar => Tensor; Tensor, Vector => Vector; Tensor, Tensor => Tensor;
    i32, Scalar => Scalar; i32, Vector => Vector; i32, Tensor => Tensor;
    f64, Scalar => Scalar; f64, Vector => Vector; f64, Tensor => Tensor;
    Scalar, Form => Form; f64, Form => Form; i32, Form => Form;
}

macro_rules! with_numbers {
    ($($number:ty)*) => { $(
        impl Add<Scalar> for $number {
            type Output = Scalar;
            fn add(self, _: Scalar) -> Scalar {
                any()
            }
        }
        impl Sub<Scalar> for $number {
            type Output = Scalar;
            fn sub(self, _: Scalar) -> Scalar {
                any()
            }
        }
        impl Div<Scalar> for $number {
            type Output = Scalar;
            fn div(self, _: Scalar) -> Scalar {
                any()
            }
        }
        impl Add<$number> for Scalar {
            type Output = Scalar;
            fn add(self, _: $number) -> Scalar {
                any()
            }
        }
        impl Sub<$number> for Scalar {
            type Output = Scalar;
            fn sub(self, _: $number) -> Scalar {
                any()
            }
        }
    )* };
}

with_numbers! { i32 f64 }

macro_rules! linear {
    ($($kind:ty)*) => { $(
        impl Add for $kind {
            type Output = $kind;
            fn add(self, _: $kind) -> $kind {
                any()
            }
        }
        impl Sub for $kind {
            type Output = $kind;
            fn sub(self, _: $kind) -> $kind {
                any()
            }
        }
        impl Neg for $kind {
            type Output = $kind;
            fn neg(self) -> $kind {
                any()
            }
        }
        impl Div<Scalar> for $kind {
            type Output = $kind;
            fn div(self, _: Scalar) -> $kind {
                any()
            }
        }
        impl Div<i32> for $kind {
            type Output = $kind;
            fn div(self, _: i32) -> $kind {
                any()
            }
        }
    )* };
}

linear! { Scalar Vector Tensor Form }

impl Index<usize> for Vector {
    type Output = Scalar;
    fn index(&self, _: usize) -> &Scalar {
        &Scalar
    }
}

impl Index<usize> for Tensor {
    type Output = Vector;
    fn index(&self, _: usize) -> &Vector {
        &Vector
    }
}
