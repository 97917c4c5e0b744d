//! Conjugate gradients for several right-hand sides of one mass matrix at the same time: each product reads the matrix once.

use super::loads::Systems;
use super::mass::MassByCells;
use crate::linear_algebra::krylov::BESIDE_TERMS;
use crate::linear_algebra::vector::{add_scaled, dot, norm};
use crate::threads::Threads;

/// Relative residual at which the coefficients of a projection are as good as rounding lets them be.
pub(super) const TOLERANCE: f64 = 1e-14;
/// Iterations after which the systems are left to others. By the approximate inverse some fifteen suffice.
const ITERATIONS: usize = 60;
/// Numbers of a vector in a task. Its dot products are summed task by task.
const TASK: usize = 1 << 14;

/// Solutions of the systems as good as the recurrences of the method say; none where that takes too long, or a number is not finite.
pub(super) fn together(mass: &MassByCells, systems: &Systems, threads: Threads) -> Option<Vec<Vec<f64>>> {
    if !mass.has_inverse() {
        return None;
    }
    let (mut x, mut room): (Vec<_>, _) = (systems.iter().map(|system| system.1.clone()).collect(), vec![]);
    let mut image = x.clone();
    mass.products(threads, &x, &mut room, &mut image);
    let mut r = image.clone();
    for (r, (load, _)) in r.iter_mut().zip(systems) {
        r.iter_mut().zip(load).for_each(|(r, load)| *r = load - *r);
    }
    let targets: Vec<f64> = systems.iter().map(|(load, _)| (0.5 * TOLERANCE * norm(load)).powi(2)).collect();
    let (mut z, mut p) = (r.clone(), vec![vec![0.0; r[0].len()]; r.len()]);
    let mut products = vec![0.0; r.len()];
    let mut rests = sums(threads, pairs(&r, &r), |_, (a, b)| dot(a, b));
    for _ in 0..ITERATIONS {
        if rests.iter().zip(&targets).all(|(rest, target)| rest <= target) {
            return Some(x);
        }
        mass.precondition(threads, &r, &mut room, &mut z);
        let next = sums(threads, pairs(&r, &z), |_, (a, b)| dot(a, b));
        sums(threads, zipped(&mut p, &z), |column, (p, z)| {
            let factor = ratio(next[column], products[column]);
            p.iter_mut().zip(z).for_each(|(p, z)| *p = z + factor * *p);
            0.0
        });
        mass.products(threads, &p, &mut room, &mut image);
        let curvatures = sums(threads, pairs(&p, &image), |_, (a, b)| dot(a, b));
        if curvatures.iter().chain(&next).any(|value| !value.is_finite() || *value < 0.0) {
            return None;
        }
        let steps: Vec<f64> =
            next.iter().zip(&curvatures).map(|(next, curve)| ratio(*next, *curve)).collect();
        sums(threads, zipped(&mut x, &p), |column, (x, p)| {
            add_scaled(x, steps[column], p);
            0.0
        });
        rests = sums(threads, zipped(&mut r, &image), |column, (r, image)| {
            add_scaled(r, -steps[column], image);
            dot(r, r)
        });
        products = next;
    }
    None
}

/// Whether each equation of the systems holds relative to its own terms, and all of a system together in the norm.
pub(super) fn hold(mass: &MassByCells, systems: &Systems, x: &[Vec<f64>], threads: Threads) -> bool {
    let (mut room, mut images, mut sizes) = (vec![], x.to_vec(), x.to_vec());
    mass.products(threads, x, &mut room, &mut images);
    mass.sizes(threads, x, &mut room, &mut sizes);
    images.into_iter().zip(sizes).zip(systems).all(|((mut rest, sizes), (load, _))| {
        rest.iter_mut().zip(load).for_each(|(rest, load)| *rest = load - *rest);
        let mut terms = sizes.iter().zip(load).map(|(size, load)| size + load.abs());
        let each =
            rest.iter().all(|rest| rest.abs() <= BESIDE_TERMS * TOLERANCE * terms.next().unwrap_or(0.0));
        each && norm(&rest) <= TOLERANCE * norm(load)
    })
}

/// a / b, and zero where a right-hand side has nothing left.
fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}

/// Tasks of the columns of two lists of vectors.
fn pairs<'v>(a: &'v [Vec<f64>], b: &'v [Vec<f64>]) -> Vec<Vec<(&'v [f64], &'v [f64])>> {
    a.iter().zip(b).map(|(a, b)| a.chunks(TASK).zip(b.chunks(TASK)).collect()).collect()
}

/// The same, where the first list is changed.
fn zipped<'v>(a: &'v mut [Vec<f64>], b: &'v [Vec<f64>]) -> Vec<Vec<(&'v mut [f64], &'v [f64])>> {
    a.iter_mut().zip(b).map(|(a, b)| a.chunks_mut(TASK).zip(b.chunks(TASK)).collect()).collect()
}

/// For each column the sum of what its tasks return, in their order.
fn sums<T: Send>(
    threads: Threads,
    tasks: Vec<Vec<T>>,
    work: impl Fn(usize, T) -> f64 + Send + Sync,
) -> Vec<f64> {
    let mut sums = vec![0.0; tasks.len()];
    let numbered = tasks.into_iter().enumerate();
    let mut all: Vec<(usize, T)> =
        numbered.flat_map(|(column, tasks)| tasks.into_iter().map(move |task| (column, task))).collect();
    let at_once = all.len().div_ceil(threads.for_work(all.len() * TASK)).max(1);
    let mut parts = vec![];
    while !all.is_empty() {
        let later = all.split_off(at_once.min(all.len()));
        parts.push(std::mem::replace(&mut all, later));
    }
    let done = threads.run(parts, |part: Vec<(usize, T)>| {
        part.into_iter().map(|(column, task)| (column, work(column, task))).collect::<Vec<_>>()
    });
    for (column, sum) in done.into_iter().flatten() {
        sums[column] += sum;
    }
    sums
}
