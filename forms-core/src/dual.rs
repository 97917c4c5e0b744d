//! Dual numbers: a value together with its derivative in one direction. Nested, they carry higher derivatives.

mod arithmetic;

use crate::real::Real;

/// value + derivative · ε with ε² = 0. `Dual<Dual<f64>>` has second derivatives.
#[derive(Clone, Copy, Debug)]
pub struct Dual<R> {
    /// The value.
    pub value: R,
    /// Its derivative in the direction at hand.
    pub derivative: R,
}

/// A number that can be started as the variable of a derivative.
pub trait Seeded: Real {
    /// The `input`-th variable with this value, differentiated in turn by the variables `directions`;
    /// there are [`Real::ORDER`].
    fn seed(value: f64, input: usize, directions: &[usize]) -> Self;
    /// The derivative of highest order: by all the directions.
    fn highest(self) -> f64;
}

impl Seeded for f64 {
    #[inline]
    fn seed(value: f64, _: usize, _: &[usize]) -> Self {
        value
    }
    #[inline]
    fn highest(self) -> f64 {
        self
    }
}

impl<R: Seeded> Seeded for Dual<R> {
    #[inline]
    fn seed(value: f64, input: usize, directions: &[usize]) -> Self {
        let (moves, rest) = match directions {
            [first, rest @ ..] => (*first == input, rest),
            [] => (false, directions),
        };
        let derivative = R::from(if moves { 1.0 } else { 0.0 });
        Dual { value: R::seed(value, input, rest), derivative }
    }
    #[inline]
    fn highest(self) -> f64 {
        self.derivative.highest()
    }
}

impl<R: Real> Dual<R> {
    /// f(self) from f and f′ at the value. What does not move has no derivative, whatever the slope: √0 of a
    /// constant is no reason for a NaN.
    #[inline]
    fn chain(self, value: R, slope: impl FnOnce() -> R) -> Self {
        let derivative = if self.derivative.vanishes() { R::zero() } else { slope() * self.derivative };
        Dual { value, derivative }
    }
}

impl<R: Real> From<f64> for Dual<R> {
    #[inline]
    fn from(value: f64) -> Self {
        Dual { value: R::from(value), derivative: R::zero() }
    }
}

impl<R: Real> Real for Dual<R> {
    const ORDER: usize = R::ORDER + 1;

    #[inline]
    fn value(self) -> f64 {
        self.value.value()
    }
    #[inline]
    fn vanishes(self) -> bool {
        self.value.vanishes() && self.derivative.vanishes()
    }

    #[inline]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, || R::from(0.5) / root)
    }
    #[inline]
    fn cbrt(self) -> Self {
        let root = self.value.cbrt();
        self.chain(root, || (root * root * 3.0).powi(-1))
    }
    #[inline]
    fn exp(self) -> Self {
        let power = self.value.exp();
        self.chain(power, || power)
    }
    #[inline]
    fn exp_m1(self) -> Self {
        self.chain(self.value.exp_m1(), || self.value.exp())
    }
    #[inline]
    fn ln(self) -> Self {
        self.chain(self.value.ln(), || self.value.powi(-1))
    }
    #[inline]
    fn ln_1p(self) -> Self {
        self.chain(self.value.ln_1p(), || (self.value + 1.0).powi(-1))
    }
    #[inline]
    fn powi(self, exponent: i32) -> Self {
        if exponent == 0 {
            return Self::one();
        }
        self.chain(self.value.powi(exponent), || self.value.powi(exponent - 1) * f64::from(exponent))
    }
    #[inline]
    fn powf(self, exponent: Self) -> Self {
        let power = self.value.powf(exponent.value);
        let by_base = || match exponent.value.vanishes() {
            true => R::zero(),
            false => exponent.value * self.value.powf(exponent.value - 1.0),
        };
        let by_exponent = exponent.chain(power, || power * self.value.ln());
        self.chain(power, by_base) + Dual { value: R::zero(), derivative: by_exponent.derivative }
    }
    #[inline]
    fn sin(self) -> Self {
        self.chain(self.value.sin(), || self.value.cos())
    }
    #[inline]
    fn cos(self) -> Self {
        self.chain(self.value.cos(), || -self.value.sin())
    }
    #[inline]
    fn tan(self) -> Self {
        let tangent = self.value.tan();
        self.chain(tangent, || tangent * tangent + 1.0)
    }
    #[inline]
    fn asin(self) -> Self {
        self.chain(self.value.asin(), || (R::one() - self.value * self.value).sqrt().powi(-1))
    }
    #[inline]
    fn acos(self) -> Self {
        self.chain(self.value.acos(), || -(R::one() - self.value * self.value).sqrt().powi(-1))
    }
    #[inline]
    fn atan(self) -> Self {
        self.chain(self.value.atan(), || (self.value * self.value + 1.0).powi(-1))
    }
    #[inline]
    fn atan2(self, x: Self) -> Self {
        let angle = self.value.atan2(x.value);
        let square = self.value * self.value + x.value * x.value;
        let by_x = x.chain(angle, || -self.value / square);
        self.chain(angle, || x.value / square) + Dual { value: R::zero(), derivative: by_x.derivative }
    }
    #[inline]
    fn sinh(self) -> Self {
        self.chain(self.value.sinh(), || self.value.cosh())
    }
    #[inline]
    fn cosh(self) -> Self {
        self.chain(self.value.cosh(), || self.value.sinh())
    }
    #[inline]
    fn tanh(self) -> Self {
        let tangent = self.value.tanh();
        self.chain(tangent, || R::one() - tangent * tangent)
    }
    #[inline]
    fn abs(self) -> Self {
        self.chain(self.value.abs(), || self.value.signum())
    }
    #[inline]
    fn signum(self) -> Self {
        Dual { value: self.value.signum(), derivative: R::zero() }
    }
    #[inline]
    fn min(self, other: Self) -> Self {
        if self.value().is_nan() || self <= other { self } else { other }
    }
    #[inline]
    fn max(self, other: Self) -> Self {
        if self.value().is_nan() || self > other { self } else { other }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Twice = Dual<Dual<f64>>;

    /// First derivative by duals against central differences, second against central differences of the first.
    fn check(
        name: &str,
        x: f64,
        f: fn(f64) -> f64,
        once: fn(Dual<f64>) -> Dual<f64>,
        twice: fn(Twice) -> Twice,
    ) {
        let first = |x: f64| once(Dual { value: x, derivative: 1.0 });
        let h = 1e-5;
        let slope = (f(x + h) - f(x - h)) / (2.0 * h);
        let bend = (first(x + h).derivative - first(x - h).derivative) / (2.0 * h);
        let second = twice(Seeded::seed(x, 0, &[0, 0]));
        assert_eq!(first(x).value, f(x), "{name}");
        assert!((first(x).derivative - slope).abs() < 1e-8 * (1.0 + slope.abs()), "{name}′");
        assert!((second.derivative.value - slope).abs() < 1e-8 * (1.0 + slope.abs()), "{name}′");
        assert!((second.highest() - bend).abs() < 1e-8 * (1.0 + bend.abs()), "{name}″");
    }

    macro_rules! functions {
        ($($name:literal at $x:literal: |$s:ident| $body:expr;)*) => {
            $({
                fn function<R: Real>($s: R) -> R {
                    $body
                }
                check($name, $x, function, function, function);
            })*
        };
    }

    #[test]
    fn derivatives_agree_with_central_differences() {
        functions! {
            "arithmetic" at 0.7: |s| (s * s - 3.0) / (s + 2.0) * s - s / 4.0 + R::from(2.0) / s;
            "sqrt" at 0.7: |s| s.sqrt();
            "cbrt" at 0.7: |s| s.cbrt();
            "exp" at 0.7: |s| (s * 2.0).exp();
            "exp_m1" at 0.7: |s| s.exp_m1();
            "ln" at 0.7: |s| s.ln();
            "ln_1p" at 0.7: |s| s.ln_1p();
            "powi" at -0.7: |s| s.powi(3) + s.powi(-2) + s.powi(0);
            "powf" at 0.7: |s| s.powf(R::from(2.5)) + R::from(1.5).powf(s) + s.powf(s);
            "trigonometric" at 0.7: |s| s.sin() * s.cos() + s.tan();
            "inverse trigonometric" at 0.3: |s| s.asin() * s + s.acos() + s.atan() * s;
            "atan2" at 0.3: |s| s.atan2(s * s - 2.0);
            "hyperbolic" at 0.3: |s| s.sinh() * s + s.cosh() * s + s.tanh();
            "kinks" at -0.3: |s| s.abs() * s + s.max(s * s) * s + s.min(s * s) + s.signum();
            "loop" at 0.3: |s| {
                let mut sum = R::zero();
                for k in 1..9 {
                    sum += s.powi(k) / f64::from(k);
                }
                sum
            };
        }
    }

    #[test]
    fn kinks_follow_the_language() {
        let at = |derivative| Dual { value: 0.0, derivative };
        assert_eq!(at(1.0).abs().derivative, 0.0);
        assert_eq!(at(1.0).max(at(2.0)).derivative, 2.0);
        assert_eq!(at(1.0).min(at(2.0)).derivative, 1.0);
        assert!(Real::max(f64::NAN, 1.0).is_nan() && Real::max(1.0, f64::NAN).is_nan());
        assert!(Real::min(f64::NAN, 1.0).is_nan() && Real::min(1.0, f64::NAN).is_nan());
    }

    #[test]
    fn a_constant_has_no_derivative_where_the_slope_is_infinite() {
        let zero = Dual::<f64>::from(0.0);
        assert_eq!(zero.sqrt().derivative, 0.0);
        assert_eq!(zero.powf(Dual::from(0.5)).derivative, 0.0);
        let moving = Dual { value: 0.0, derivative: 1.0 };
        assert_eq!(moving.powf(Dual::from(2.0)).derivative, 0.0);
        assert_eq!(moving.powf(Dual::from(0.0)).derivative, 0.0);
        assert_eq!(moving.powf(Dual::from(1.0)).derivative, 1.0);
    }
}
