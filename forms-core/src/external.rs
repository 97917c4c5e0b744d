//! Functions written in Rust, as kernels call them: lane by lane, with dual numbers for their derivatives.

// Inputs, outputs and lanes are walked by their numbers.
#![allow(clippy::needless_range_loop)]

use crate::dual::Seeded;
use crate::lane::Lane;
use crate::real::Real;

/// A function whose arguments and value are flattened to scalars, row-major.
pub trait External {
    /// Writes the components of the value.
    fn evaluate<R: Real>(inputs: &[R], outputs: &mut [R]);

    /// [`External::evaluate`] where the number of inputs is known when it is compiled.
    #[inline(always)]
    fn evaluate_fixed<R: Real, const INPUTS: usize>(inputs: &[R; INPUTS], outputs: &mut [R]) {
        Self::evaluate(inputs, outputs);
    }

    /// Which variable the `input`-th of some inputs is: those of one variable move together in a derivative by it, which
    /// bears the number of the first of them.
    #[inline(always)]
    fn variable(input: usize, _inputs: usize) -> usize {
        input
    }
}

/// The most lanes that [`external`] and [`tabulated`] serve.
const WIDEST: usize = 16;

/// Derivatives of order N of a function at each lane: for each of the K lists of directions (numbers of variables, which are
/// inputs except for [`External::variable`]) the derivative of all outputs by these, one after the other. `T` carries N derivatives: `f64`,
/// `Dual<f64>`, `Dual<Dual<f64>>`, …
pub fn external<
    F: External,
    T: Seeded,
    L: Lane,
    const INPUTS: usize,
    const OUTPUTS: usize,
    const K: usize,
    const N: usize,
>(
    inputs: [L; INPUTS],
    directions: [[usize; N]; K],
) -> [[L; OUTPUTS]; K] {
    const { assert!(L::WIDTH <= WIDEST && T::ORDER == N) }
    // Plain loops: closures would be compiled for each function, order and lane type.
    let mut read = [[0.0; WIDEST]; INPUTS];
    for input in 0..INPUTS {
        inputs[input].store(&mut read[input]);
    }
    let mut written = [[[0.0; WIDEST]; OUTPUTS]; K];
    let (mut seeded, mut outputs) = ([T::zero(); INPUTS], [T::zero(); OUTPUTS]);
    for lane in 0..L::WIDTH {
        for k in 0..K {
            for input in 0..INPUTS {
                seeded[input] = T::seed(read[input][lane], F::variable(input, INPUTS), &directions[k]);
            }
            outputs.fill(T::zero());
            F::evaluate_fixed(&seeded, &mut outputs);
            for output in 0..OUTPUTS {
                written[k][output][lane] = outputs[output].highest();
            }
        }
    }
    let mut results = [[L::splat(0.0); OUTPUTS]; K];
    for k in 0..K {
        for output in 0..OUTPUTS {
            results[k][output] = L::load(&written[k][output]);
        }
    }
    results
}

/// A tabulated law, or its derivative of the given order, at each lane.
pub fn tabulated<L: Lane>(law: &crate::table::Table, order: usize, argument: L) -> L {
    const { assert!(L::WIDTH <= WIDEST) }
    let mut lanes = [0.0; WIDEST];
    argument.store(&mut lanes);
    for value in &mut lanes[..L::WIDTH] {
        *value = law.derivative(order, *value);
    }
    L::load(&lanes)
}
