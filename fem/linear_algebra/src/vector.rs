//! Dot products and norms of dense vectors.

use crate::threads::Threads;

/// Entries whose products are summed before those of other chunks, on any number of threads.
const CHUNK: usize = 1024;

/// Σ x_i y_i, summed in chunks of 1024, in each of them in eight interleaved parts (which vectorises and loses less
/// to rounding).
pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    dot_on(Threads::ONE, x, y)
}

/// [`dot`] on some threads: the same number, to the last bit, for each number of threads.
pub fn dot_on(threads: Threads, x: &[f64], y: &[f64]) -> f64 {
    let chunks = x.len().div_ceil(CHUNK);
    let length = chunks.div_ceil(threads.for_work(x.len())).max(1) * CHUNK;
    let parts = x.chunks(length).zip(y.chunks(length)).collect();
    let sums = threads.run(parts, |(x, y): (&[f64], &[f64])| -> Vec<f64> {
        x.chunks(CHUNK).zip(y.chunks(CHUNK)).map(|(x, y)| dot_of_chunk(x, y)).collect()
    });
    sums.iter().flatten().sum()
}

fn dot_of_chunk(x: &[f64], y: &[f64]) -> f64 {
    let mut parts = [0.0; 8];
    let (x_chunks, y_chunks) = (x.chunks_exact(8), y.chunks_exact(8));
    let tail: f64 = x_chunks.remainder().iter().zip(y_chunks.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in x_chunks.zip(y_chunks) {
        for lane in 0..8 {
            parts[lane] += a[lane] * b[lane];
        }
    }
    parts.iter().sum::<f64>() + tail
}

/// Euclidean norm.
pub fn norm(x: &[f64]) -> f64 {
    norm_on(Threads::ONE, x)
}

/// [`norm`] on some threads: the same number, to the last bit, for each number of threads.
pub fn norm_on(threads: Threads, x: &[f64]) -> f64 {
    let plain = dot_on(threads, x, x);
    if plain.is_normal() && plain > 1e-280 {
        return plain.sqrt();
    }
    // The squares overflow or underflow (or something is not finite): scale by the largest entry.
    let largest = largest(x);
    if largest == 0.0 || !largest.is_finite() {
        return largest;
    }
    largest * x.iter().map(|value| (value / largest).powi(2)).sum::<f64>().sqrt()
}

/// Largest absolute value; NaN if an entry is NaN; 0 for an empty vector.
pub fn largest(x: &[f64]) -> f64 {
    let mut result = 0.0_f64;
    for value in x {
        if value.is_nan() {
            return f64::NAN;
        }
        result = result.max(value.abs());
    }
    result
}

/// Whether no entry is NaN or infinite: in pieces without an early end, which vectorise.
pub fn is_finite(x: &[f64]) -> bool {
    let of_piece = |piece: &[f64]| piece.iter().fold(true, |finite, value| finite & value.is_finite());
    x.chunks(CHUNK).all(of_piece)
}

/// The first entry that is NaN or infinite.
pub fn first_not_finite(x: &[f64]) -> Option<usize> {
    if is_finite(x) { None } else { x.iter().position(|value| !value.is_finite()) }
}

/// y += factor * x.
pub fn add_scaled(y: &mut [f64], factor: f64, x: &[f64]) {
    for (target, value) in y.iter_mut().zip(x) {
        *target += factor * value;
    }
}

/// [`add_scaled`] on some threads.
pub fn add_scaled_on(threads: Threads, y: &mut [f64], factor: f64, x: &[f64]) {
    in_pieces(threads, y, 1, |first, y| add_scaled(y, factor, &x[first..]));
}

/// Calls `work` on some threads with pieces of a vector and the place of their first entry, a multiple of `block`.
pub(crate) fn in_pieces(
    threads: Threads,
    y: &mut [f64],
    block: usize,
    work: impl Fn(usize, &mut [f64]) + Send + Sync,
) {
    let block = block.max(1);
    let length = y.len().div_ceil(block).div_ceil(threads.for_work(y.len())).max(1) * block;
    let parts = y.chunks_mut(length).enumerate().collect();
    threads.run(parts, |(part, y): (usize, &mut [f64])| work(part * length, y));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dot_and_norm_of_known_vectors() {
        let x: Vec<f64> = (1..=19).map(f64::from).collect();
        assert_eq!(dot(&x, &x), 2470.0); // n (n + 1) (2 n + 1) / 6
        assert_eq!(norm(&[3.0, -4.0]), 5.0);
        assert_eq!(largest(&[1.0, -7.0, 2.0]), 7.0);
        assert_eq!(norm(&[]), 0.0);
    }

    #[test]
    fn dot_products_do_not_depend_on_threads() {
        for count in [0, 7, 1024, 40_000, 100_003] {
            let x: Vec<f64> = (0..count).map(|k| (k as f64 * 0.7).sin()).collect();
            let y: Vec<f64> = (0..count).map(|k| (k as f64 * 0.3).cos()).collect();
            let alone = dot(&x, &y);
            for threads in [2, 3, 7, 16] {
                assert_eq!(dot_on(Threads::new(threads), &x, &y).to_bits(), alone.to_bits());
            }
            let plain: f64 = x.iter().zip(&y).map(|(a, b)| a * b).sum();
            assert!((plain - alone).abs() < 1e-10);
        }
    }

    #[test]
    fn one_number_that_is_none_is_found_wherever_it_stands() {
        for count in [1, 7, 1024, 2500] {
            let finite = vec![f64::MAX; count];
            assert!(is_finite(&finite) && is_finite(&[]));
            for (place, wrong) in [(0, f64::NAN), (count / 2, f64::INFINITY), (count - 1, f64::NEG_INFINITY)]
            {
                let mut x = finite.clone();
                x[place] = wrong;
                assert!(!is_finite(&x), "{count}, {place}");
            }
        }
    }

    #[test]
    fn the_norm_neither_overflows_nor_hides_nan() {
        assert!((norm(&[3e200, 4e200]) / 5e200 - 1.0).abs() < 1e-15);
        assert!((norm(&[3e-200, 4e-200]) / 5e-200 - 1.0).abs() < 1e-15);
        assert!(norm(&[1.0, f64::NAN]).is_nan());
        assert_eq!(norm(&[1.0, f64::INFINITY]), f64::INFINITY);
    }
}
