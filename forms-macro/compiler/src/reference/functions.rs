//! The functions of the language on dual numbers, with the derivatives at kinks that
//! `docs/language.md` states.

use super::number::Number;
use crate::tensor::Function;

/// sign(0) = 0.
fn sign(a: f64) -> f64 {
    if a > 0.0 {
        1.0
    } else if a < 0.0 {
        -1.0
    } else {
        a * 0.0
    }
}

/// heaviside(0) = 0.
fn heaviside(a: f64) -> f64 {
    if a > 0.0 { 1.0 } else { 0.0 }
}

fn nothing(_: &Number) -> Number {
    Number::real(0.0)
}

fn root_of(a: &Number) -> Number {
    function(Function::Sqrt, a)
}

fn one_minus_square(a: &Number) -> Number {
    Number::real(1.0).minus(&a.times(a))
}

/// 2/√π exp(−a²)
fn bell(a: &Number) -> Number {
    function(Function::Exp, &a.times(a).scaled(-1.0)).scaled(std::f64::consts::FRAC_2_SQRT_PI)
}

/// erf a = 2/√π exp(−a²) Σ 2ⁿ a²ⁿ⁺¹ / (2n+1)!!, whose terms have one sign (Abramowitz and Stegun 7.1.6).
pub fn error_function(a: f64) -> f64 {
    if a.abs() > 6.0 {
        return a.signum();
    }
    let (mut term, mut sum, mut n) = (a, 0.0, 0.0);
    while term != 0.0 && f64::abs(term) > 1e-18 * f64::abs(sum) {
        sum += term;
        n += 1.0;
        term *= 2.0 * a * a / (2.0 * n + 1.0);
    }
    std::f64::consts::FRAC_2_SQRT_PI * (-a * a).exp() * sum
}

/// The angle of the point (second, first): an arc tangent and a constant, in each of four sectors.
pub fn angle(first: &Number, second: &Number) -> Number {
    let arc = match second.value().abs() >= first.value().abs() {
        true => function(Function::Atan, &first.over(second)),
        false => function(Function::Atan, &second.over(first)).scaled(-1.0),
    };
    let constant = first.value().atan2(second.value()) - arc.value();
    arc.plus(&Number::real(constant))
}

/// From the origin, and from the ray on which the angle jumps.
pub fn distance_from_cut(first: f64, second: f64) -> f64 {
    if second < 0.0 { first.abs() } else { first.hypot(second) }
}

/// A function of one scalar.
pub fn function(function: Function, a: &Number) -> Number {
    let real = |value: f64| Number::real(value);
    let again = move |which: Function| move |a: &Number| self::function(which, a);
    #[allow(unreachable_patterns)]
    match function {
        Function::Sqrt => a.apply(&f64::sqrt, &|a| again(Function::Sqrt)(a).reciprocal().scaled(0.5)),
        Function::Exp => a.apply(&f64::exp, &again(Function::Exp)),
        Function::Ln => a.apply(&f64::ln, &Number::reciprocal),
        Function::Sin => a.apply(&f64::sin, &again(Function::Cos)),
        Function::Cos => a.apply(&f64::cos, &|a| again(Function::Sin)(a).scaled(-1.0)),
        // tan′ = 1 / cos²
        Function::Tan => a.apply(&f64::tan, &|a| {
            let cosine = again(Function::Cos)(a);
            cosine.times(&cosine).reciprocal()
        }),
        // tanh′ = 1 / cosh², cosh = (eᵃ + e⁻ᵃ) / 2
        Function::Tanh => a.apply(&f64::tanh, &|a| {
            let exponential = again(Function::Exp);
            let cosh = exponential(a).plus(&exponential(&a.scaled(-1.0))).scaled(0.5);
            cosh.times(&cosh).reciprocal()
        }),
        Function::Asin => a.apply(&f64::asin, &|a| root_of(&one_minus_square(a)).reciprocal()),
        Function::Acos => a.apply(&f64::acos, &|a| root_of(&one_minus_square(a)).reciprocal().scaled(-1.0)),
        // atan′ = 1 / (1 + a²), asinh′ = 1 / √(1 + a²)
        Function::Atan => a.apply(&f64::atan, &|a| real(1.0).plus(&a.times(a)).reciprocal()),
        Function::Asinh => a.apply(&f64::asinh, &|a| root_of(&real(1.0).plus(&a.times(a))).reciprocal()),
        Function::Acosh => a.apply(&f64::acosh, &|a| root_of(&a.times(a).minus(&real(1.0))).reciprocal()),
        Function::Atanh => a.apply(&f64::atanh, &|a| one_minus_square(a).reciprocal()),
        Function::Sinh => a.apply(&f64::sinh, &again(Function::Cosh)),
        Function::Cosh => a.apply(&f64::cosh, &again(Function::Sinh)),
        Function::Log10 => a.apply(&f64::log10, &|a| a.reciprocal().scaled(1.0 / std::f64::consts::LN_10)),
        Function::Erf => a.apply(&error_function, &bell),
        Function::Erfc => a.apply(&|a| 1.0 - error_function(a), &|a| bell(a).scaled(-1.0)),
        Function::Abs => a.apply(&f64::abs, &|a| real(sign(a.value()))),
        Function::Sign => a.apply(&sign, &nothing),
        Function::Heaviside => a.apply(&heaviside, &nothing),
        Function::PositivePart => {
            a.apply(&|a| if a > 0.0 { a } else { 0.0 }, &|a| real(heaviside(a.value())))
        }
        Function::NegativePart => {
            a.apply(&|a| if a < 0.0 { -a } else { 0.0 }, &|a| real(-heaviside(-a.value())))
        }
        // A function that is new: add its meaning here and below.
        other => panic!("the reference evaluator has no rule for {other:?}"),
    }
}

/// The distance of a function of one scalar from its kink, jump or singularity.
pub fn distance_from_kink(function: Function, a: f64) -> f64 {
    #[allow(unreachable_patterns)]
    match function {
        Function::Exp | Function::Sin | Function::Cos | Function::Tanh => f64::INFINITY,
        Function::Atan | Function::Asinh | Function::Sinh | Function::Cosh => f64::INFINITY,
        Function::Erf | Function::Erfc => f64::INFINITY,
        Function::Asin | Function::Acos | Function::Atanh => 1.0 - a.abs(),
        Function::Acosh => a - 1.0,
        Function::Log10 => a.abs(),
        Function::Tan => a.cos().abs(),
        Function::Sqrt
        | Function::Ln
        | Function::Abs
        | Function::Sign
        | Function::Heaviside
        | Function::PositivePart
        | Function::NegativePart => a.abs(),
        other => panic!("the reference evaluator has no kinks for {other:?}"),
    }
}

/// aᵇ. A whole exponent allows any sign of the base; ∂/∂a = b aᵇ⁻¹, ∂/∂b = aᵇ ln a.
pub fn power(a: &Number, b: &Number) -> Number {
    let exponent = b.value();
    if b.is_real() && exponent.fract() == 0.0 && exponent.abs() <= 64.0 {
        let mut product = Number::real(1.0);
        for _ in 0..exponent.abs() as u32 {
            product = product.times(a);
        }
        return if exponent < 0.0 { product.reciprocal() } else { product };
    }
    if b.is_real() {
        return a.apply(&|a| a.powf(exponent), &|a| power(a, &Number::real(exponent - 1.0)).scaled(exponent));
    }
    // aᵇ = exp(b ln a), for a positive base.
    function(Function::Exp, &b.times(&function(Function::Ln, a)))
}
