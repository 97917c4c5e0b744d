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

/// Where a function of one scalar has a kink, a jump or a singularity: the distance from there.
pub fn distance_from_kink(function: Function, a: f64) -> f64 {
    #[allow(unreachable_patterns)]
    match function {
        Function::Exp | Function::Sin | Function::Cos | Function::Tanh => f64::INFINITY,
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
