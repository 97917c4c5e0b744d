//! Lanes that carry a derivative: a kernel that is run on them gives its values together with their derivatives along a motion of its points.
//! Lanes whose values carry one themselves have two derivatives. Points of a facet in space move in two directions: there lanes carry both derivatives.
//!
//! A value that goes through memory by [`Lane::store`] and [`Lane::load`] loses its derivative, which is NaN then: so functions of a user that have
//! no derivative do not count as constants. Data that do not move are gathered.

// Closures and iterator adaptors do not inherit a caller's target features: loops over lanes are plain.
#![allow(clippy::needless_range_loop)]

use std::marker::PhantomData;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

use forms_core::contract::Lane;

use super::slope::{SimdSlope, Slope};
use super::{SharedWork, SimdLane, WIDEST};

/// Values with their derivatives.
#[derive(Clone, Copy)]
pub(crate) struct Moving<L, S = L> {
    pub value: L,
    pub slope: S,
}

impl<L: SimdLane, S: SimdSlope<L>> Moving<L, S> {
    /// A value that does not move.
    #[inline(always)]
    fn constant(value: L) -> Self {
        Moving { value, slope: S::all(L::splat(0.0)) }
    }

    /// f(self) from f and f′.
    #[inline(always)]
    fn chain(self, value: L, slope: L) -> Self {
        Moving { value, slope: self.slope.chained(slope) }
    }
}

impl<L: Lane, S: Slope<L>> Add for Moving<L, S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Moving { value: self.value + other.value, slope: self.slope + other.slope }
    }
}

impl<L: Lane, S: Slope<L>> Sub for Moving<L, S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Moving { value: self.value - other.value, slope: self.slope - other.slope }
    }
}

impl<L: Lane, S: Slope<L>> Mul for Moving<L, S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let slope = self.slope.times_add(other.value, other.slope.times(self.value));
        Moving { value: self.value * other.value, slope }
    }
}

impl<L: Lane, S: Slope<L>> Div for Moving<L, S> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Moving { value, slope: (self.slope - other.slope.times(value)).over(other.value) }
    }
}

impl<L: Lane, S: Slope<L>> Neg for Moving<L, S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Moving { value: -self.value, slope: -self.slope }
    }
}

impl<L: Lane, S: Slope<L>> AddAssign for Moving<L, S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

/// Functions of one number by their derivatives.
macro_rules! functions {
    ($($name:ident: |$x:ident, $value:ident| $slope:expr),+ $(,)?) => {
        $(#[inline]
        fn $name(self) -> Self {
            let ($x, $value) = (self.value, self.value.$name());
            let _ = ($x, $value);
            self.chain($value, $slope)
        })+
    };
}

impl<L: SimdLane, S: SimdSlope<L>> Lane for Moving<L, S> {
    const WIDTH: usize = L::WIDTH;
    type Mask = L::Mask;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self::constant(L::splat(value))
    }
    #[inline(always)]
    fn load(values: &[f64]) -> Self {
        // A product, so that derivatives of the slope are lost, too.
        let value = L::load(values);
        Moving { value, slope: S::all(value * L::splat(f64::NAN)) }
    }
    #[inline(always)]
    fn store(self, values: &mut [f64]) {
        self.value.store(values);
    }
    #[inline(always)]
    fn multiply_add(self, factor: Self, addend: Self) -> Self {
        let slope = factor.slope.times_add(self.value, addend.slope);
        let slope = self.slope.times_add(factor.value, slope);
        Moving { value: self.value.multiply_add(factor.value, addend.value), slope }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let value = self.value.sqrt();
        self.chain(value, L::splat(0.5) / value)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        let negative = self.value.less(L::splat(0.0));
        Moving { value: self.value.abs(), slope: S::chosen(negative, -self.slope, self.slope) }
    }
    #[inline(always)]
    fn powi(self, exponent: i32) -> Self {
        // Of values with derivatives: no quotient by zero.
        match exponent {
            0 => return Self::splat(1.0),
            1 => return self,
            _ => {}
        }
        let slope = L::splat(f64::from(exponent)) * self.value.powi(exponent - 1);
        self.chain(self.value.powi(exponent), slope)
    }
    #[inline(always)]
    fn minimum(self, other: Self) -> Self {
        Self::select(other.value.less(self.value), other, self)
    }
    #[inline(always)]
    fn maximum(self, other: Self) -> Self {
        Self::select(self.value.less(other.value), other, self)
    }
    #[inline]
    fn powf(self, exponent: Self) -> Self {
        let value = self.value.powf(exponent.value);
        let one = L::splat(1.0);
        let along_base = self.chain(value, exponent.value * self.value.powf(exponent.value - one));
        let along_exponent = exponent.chain(value, value * self.value.ln());
        Moving { value, slope: along_base.slope + along_exponent.slope }
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        let square = self.value * self.value + x.value * x.value;
        let slope = (self.slope.times(x.value) - x.slope.times(self.value)).over(square);
        Moving { value: self.value.atan2(x.value), slope }
    }
    functions! {
        exp: |x, value| value,
        ln: |x, value| L::splat(1.0) / x,
        sin: |x, value| x.cos(),
        cos: |x, value| -x.sin(),
        tan: |x, value| L::splat(1.0) + value * value,
        tanh: |x, value| L::splat(1.0) - value * value,
        asin: |x, value| L::splat(1.0) / (L::splat(1.0) - x * x).sqrt(),
        acos: |x, value| L::splat(-1.0) / (L::splat(1.0) - x * x).sqrt(),
        atan: |x, value| L::splat(1.0) / (L::splat(1.0) + x * x),
        sinh: |x, value| x.cosh(),
        cosh: |x, value| x.sinh(),
        asinh: |x, value| L::splat(1.0) / (L::splat(1.0) + x * x).sqrt(),
        acosh: |x, value| L::splat(1.0) / (x * x - L::splat(1.0)).sqrt(),
        atanh: |x, value| L::splat(1.0) / (L::splat(1.0) - x * x),
        log10: |x, value| L::splat(std::f64::consts::LOG10_E) / x,
        erf: |x, value| L::splat(std::f64::consts::FRAC_2_SQRT_PI) * (-(x * x)).exp(),
        erfc: |x, value| L::splat(-std::f64::consts::FRAC_2_SQRT_PI) * (-(x * x)).exp(),
    }
    #[inline(always)]
    fn less(self, other: Self) -> L::Mask {
        self.value.less(other.value)
    }
    #[inline(always)]
    fn less_equal(self, other: Self) -> L::Mask {
        self.value.less_equal(other.value)
    }
    #[inline(always)]
    fn equal(self, other: Self) -> L::Mask {
        self.value.equal(other.value)
    }
    #[inline(always)]
    fn and(first: L::Mask, second: L::Mask) -> L::Mask {
        L::and(first, second)
    }
    #[inline(always)]
    fn or(first: L::Mask, second: L::Mask) -> L::Mask {
        L::or(first, second)
    }
    #[inline(always)]
    fn not(mask: L::Mask) -> L::Mask {
        L::not(mask)
    }
    #[inline(always)]
    fn select(mask: L::Mask, taken: Self, otherwise: Self) -> Self {
        Moving {
            value: L::select(mask, taken.value, otherwise.value),
            slope: S::chosen(mask, taken.slope, otherwise.slope),
        }
    }
}

/// Work in these lanes as work in those of their values, for whose instructions it is compiled.
struct InValues<W, S>(W, PhantomData<S>);

impl<L: SimdLane, S: SimdSlope<L>, W: SharedWork<Moving<L, S>>> SharedWork<L> for InValues<W, S> {
    type Output = W::Output;

    #[inline(always)]
    fn run(self) -> W::Output {
        self.0.run()
    }
}

impl<L: SimdLane, S: SimdSlope<L>> SimdLane for Moving<L, S> {
    const REGISTERS: usize = L::REGISTERS / (1 + S::DIRECTIONS);
    const DIRECTIONS: usize = S::DIRECTIONS;

    #[inline(always)]
    fn call<W: SharedWork<Self>>(work: W) -> W::Output {
        L::call(InValues(work, PhantomData::<S>))
    }

    #[inline(always)]
    fn multiply_add_constant(self, factor: Self, addend: Self) -> Self {
        Moving {
            value: self.value.multiply_add_constant(factor.value, addend.value),
            slope: self.slope.times_add(factor.value, addend.slope),
        }
    }

    #[inline(always)]
    fn gather<const COUNT: usize>(values: &[f64], places: &[usize; WIDEST]) -> [Self; COUNT] {
        let entries = L::gather::<COUNT>(values, places);
        let mut moving = [Self::splat(0.0); COUNT];
        for k in 0..COUNT {
            moving[k].value = entries[k];
        }
        moving
    }

    #[inline(always)]
    fn gather_with_slopes<const COUNT: usize>(
        values: &[f64],
        slopes: [&[f64]; 2],
        places: &[usize; WIDEST],
    ) -> [Self; COUNT] {
        let entries = L::gather_with_slopes::<COUNT>(values, slopes, places);
        let slopes = S::gathered::<COUNT>(slopes, places);
        let mut moving = [Self::splat(0.0); COUNT];
        for k in 0..COUNT {
            moving[k] = Moving { value: entries[k], slope: slopes[k] };
        }
        moving
    }

    #[inline(always)]
    fn vanishes(self) -> L::Mask {
        L::and(self.value.vanishes(), self.slope.is_zero())
    }

    #[inline(always)]
    fn with_slope(self, slope: Self) -> Self {
        Moving { value: self.value, slope: S::all(slope.value) }
    }

    #[inline(always)]
    fn moved_by<const D: usize>(self, gradient: &[Self; D], position: &[Self; D]) -> Self {
        let mut slope = S::all(L::splat(0.0));
        for axis in 0..D {
            slope = position[axis].slope.times_add(gradient[axis].value, slope);
        }
        Moving { value: self.value, slope }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::Both;

    /// Derivatives of all functions are those of differences; comparisons and choices are those of values.
    #[test]
    fn slopes_are_derivatives() {
        type M = Moving<f64>;
        type Named = (&'static str, fn(M) -> M);
        let all: [Named; 26] = [
            ("product", |x| x * x * M::splat(3.0) + x),
            ("quotient", |x| (x + M::splat(1.0)) / (x * x)),
            ("multiply_add", |x| x.multiply_add(x, -x)),
            ("sqrt", M::sqrt),
            ("abs", |x| (x - M::splat(2.0)).abs()),
            ("powi", |x| x.powi(3) + x.powi(-2)),
            ("minimum", |x| x.minimum(x * x)),
            ("maximum", |x| x.maximum(x * x)),
            ("powf", |x| x.powf(M::splat(1.7)) + M::splat(1.7).powf(x) + x.powf(x)),
            ("atan2", |x| x.atan2(M::splat(2.0)) + M::splat(0.4).atan2(x)),
            ("exp", M::exp),
            ("ln", M::ln),
            ("sin", M::sin),
            ("cos", M::cos),
            ("tan", M::tan),
            ("tanh", M::tanh),
            ("asin", M::asin),
            ("acos", M::acos),
            ("atan", M::atan),
            ("sinh", M::sinh),
            ("cosh", M::cosh),
            ("asinh", M::asinh),
            ("acosh", |x| (x + M::splat(1.0)).acosh()),
            ("atanh", M::atanh),
            ("log10", M::log10),
            ("erf", |x| x.erf() + M::splat(2.0) * x.erfc()),
        ];
        type Along2 = Moving<f64, Both<f64>>;
        type NamedAlong2 = (&'static str, fn(Along2) -> Along2);
        let both: [NamedAlong2; 6] = [
            ("product", |x| x * x * Along2::splat(3.0) + x),
            ("quotient", |x| (x + Along2::splat(1.0)) / (x * x)),
            ("multiply_add", |x| x.multiply_add(x, -x)),
            ("sqrt", Along2::sqrt),
            ("abs", |x| (x - Along2::splat(2.0)).abs()),
            ("atan2", |x| x.atan2(Along2::splat(2.0)) + Along2::splat(0.4).atan2(x)),
        ];
        for (name, function) in all {
            let at = |x: f64| function(Moving { value: x, slope: 1.0 });
            let (x, h) = (0.37, 1e-3);
            let central = |h: f64| (at(x + h).value - at(x - h).value) / (2.0 * h);
            let difference = (4.0 * central(h) - central(2.0 * h)) / 3.0;
            let found = at(x).slope;
            assert!((found - difference).abs() < 1e-9 * (1.0 + found.abs()), "{name}: {found} {difference}");
            assert!(function(M::splat(x)).slope == 0.0, "{name}");
        }
        let product =
            M { value: 0.4, slope: 1.0 }.multiply_add_constant(M::splat(3.0), M { value: 1.0, slope: 2.0 });
        assert!(product.value == 0.4 * 3.0 + 1.0 && product.slope == 5.0);
        // Along two directions, each as along one.
        for (name, function) in both {
            let (x, y) = (0.37, 0.8);
            let slope = |slope: f64| M { value: x, slope };
            let found = function(Moving { value: x, slope: Both([1.0, y]) });
            let one = all.iter().find(|(known, _)| *known == name).unwrap().1;
            assert_eq!(found.slope.0, [one(slope(1.0)).slope, one(slope(y)).slope], "{name}");
            assert_eq!(found.value, one(slope(1.0)).value, "{name}");
        }
        assert_eq!(Moving { value: 0.0, slope: Both([0.0, 1.0]) }.sqrt().slope.0, [0.0, f64::INFINITY]);
        assert!(M::splat(0.0).sqrt().slope == 0.0);
        assert!(M::splat(0.3).each(f64::cbrt).slope.is_nan());
    }

    /// Second derivatives are those of differences of first ones, also where the first derivative of an argument is zero.
    #[test]
    fn slopes_of_slopes_are_second_derivatives() {
        type M = Moving<f64>;
        type Named<L> = (&'static str, fn(L) -> L);
        fn all<L: SimdLane>() -> [Named<L>; 9] {
            [
                ("quotient", |x| (x + L::splat(1.0)) / (x * x)),
                ("multiply_add", |x| x.multiply_add(x, -x)),
                ("sqrt", L::sqrt),
                ("square root of a square", |x| (x * x + L::splat(0.1)).sqrt()),
                ("square", |x| x.powi(2)),
                ("powi", |x| x.powi(3) + x.powi(-2) + x.powi(1)),
                ("powf", |x| x.powf(L::splat(1.7)) + L::splat(1.7).powf(x)),
                ("exp", |x| (x * x).exp()),
                ("minimum", |x| (x * x).minimum(x)),
            ]
        }
        // The argument 0.4 + t², whose first derivative vanishes at t = 0.
        let along = |t: f64| M { value: 0.4 + t * t, slope: 2.0 * t };
        for (number, (name, function)) in all::<M>().into_iter().enumerate() {
            for t in [0.0, 0.2] {
                let twice = Moving { value: along(t), slope: M { value: 2.0 * t, slope: 2.0 } };
                let found = all::<Moving<M>>()[number].1(twice);
                let h = 1e-3;
                let central =
                    |h: f64| (function(along(t + h)).slope - function(along(t - h)).slope) / (2.0 * h);
                let difference = (4.0 * central(h) - central(2.0 * h)) / 3.0;
                let second = found.slope.slope;
                let off = (second - difference).abs() / (1.0 + second.abs());
                assert!(off < 1e-9, "{name} at {t}: {second} {difference}");
                assert!(found.value.slope == found.slope.value, "{name}");
            }
        }
        // A square at zero, where its argument stays or moves.
        let zero = M { value: 0.0, slope: 1.5 };
        let square = Moving { value: zero, slope: M { value: 1.5, slope: 0.0 } }.powi(2);
        assert!(square.slope.slope == 4.5);
        assert!(Moving::<M>::splat(0.0).sqrt().slope.slope == 0.0);
        assert!(Moving::<M>::splat(0.3).each(f64::cbrt).slope.slope.is_nan());
    }
}
