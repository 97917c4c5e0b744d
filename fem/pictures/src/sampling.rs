//! The samples inside triangles: the inner loop of shaded surfaces, compiled for the vectors of the machine too.
//!
//! The same operations in the same order whatever the machine: pictures are equal to the last pixel.

#![allow(unsafe_code)]

use super::path::Point;

/// Samples that are judged at once.
const LANES: usize = 8;
/// Edges that rise by less than this many samples bound no run of columns: where they meet a row is not known.
const FLAT: f64 = 0.01;

/// Rows of samples of a picture: each has the number of a colour.
pub struct Rows<'a> {
    /// The number of the first row in the picture.
    pub first: usize,
    /// Samples in a row.
    pub width: usize,
    /// Colours that there are.
    pub colours: usize,
    pub sampled: &'a mut [u16],
}

/// Triangles with a number at each point, which is a colour where it is rounded down.
pub struct Triangles<'a> {
    /// Points in samples: sample (i, j) has its centre at (i + 1/2, j + 1/2).
    pub points: &'a [Point],
    pub numbers: &'a [f64],
    pub triangles: &'a [[u32; 3]],
}

impl Triangles<'_> {
    /// Colours of the samples inside the chosen triangles, one triangle after the other.
    pub fn sample(&self, chosen: &[u32], rows: &mut Rows<'_>) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the line above has asked for the instructions that the function is compiled for.
            return unsafe { sample_with_avx2(self, chosen, rows) };
        }
        sample_all(self, chosen, rows, |row, column, samples| row.judge(column, samples));
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn sample_with_avx2(all: &Triangles<'_>, chosen: &[u32], rows: &mut Rows<'_>) {
    sample_all(all, chosen, rows, |row, column, samples| row.judge_with_avx2(column, samples));
}

#[inline(always)]
fn sample_all(
    all: &Triangles<'_>,
    chosen: &[u32],
    rows: &mut Rows<'_>,
    judge: impl Fn(&Row, usize, &mut [u16; LANES]),
) {
    for &triangle in chosen {
        let [a, b, c] = all.triangles[triangle as usize];
        let corners = [all.points[a as usize], all.points[b as usize], all.points[c as usize]];
        let numbers = [all.numbers[a as usize], all.numbers[b as usize], all.numbers[c as usize]];
        sample_one(corners, numbers, rows, &judge);
    }
}

/// Barycentric coordinates are linear in x and y; a sample on an edge belongs to both sides.
#[inline(always)]
fn sample_one(
    [a, b, c]: [Point; 3],
    numbers: [f64; 3],
    rows: &mut Rows<'_>,
    judge: &impl Fn(&Row, usize, &mut [u16; LANES]),
) {
    let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    if area == 0.0 {
        return;
    }
    let (width, first, last_number) = (rows.width, rows.first as f64, (rows.colours - 1) as f64);
    let top = a[1].min(b[1]).min(c[1]) - 0.5 - first;
    let bottom = a[1].max(b[1]).max(c[1]) - 0.5 - first;
    let left = a[0].min(b[0]).min(c[0]);
    let right = a[0].max(b[0]).max(c[0]);
    if bottom < 0.0 || right < 0.5 {
        return;
    }
    let mut line = Row {
        rise: [0.0; 2],
        fall: [c[1] - b[1], a[1] - c[1]],
        start: [b[0], c[0]],
        scale: 1.0 / area,
        numbers,
        last: last_number,
    };
    let edges = [Edge::new(a, b, area), Edge::new(b, c, area), Edge::new(c, a, area)];
    let end_row = (rows.sampled.len() / width).min(bottom as usize + 1);
    for row in (top.ceil().max(0.0) as usize)..end_row {
        let y = (rows.first + row) as f64 + 0.5;
        // The samples inside are a run of columns; half a sample more on each side is for rounding.
        let (mut low, mut high) = (left, right);
        for edge in &edges {
            edge.narrow(y, &mut low, &mut high);
        }
        let start = (low - 1.0).ceil().max(0.0) as usize;
        let end = width.min(high.max(0.0) as usize + 1);
        if start >= end {
            continue;
        }
        line.rise = [(c[0] - b[0]) * (y - b[1]), (a[0] - c[0]) * (y - c[1])];
        let samples = &mut rows.sampled[row * width..(row + 1) * width];
        for column in (start..end).step_by(LANES) {
            let rest = &mut samples[column..];
            match rest.first_chunk_mut::<LANES>() {
                Some(samples) => judge(&line, column, samples),
                // The last ones of a row.
                None => {
                    let mut room = [0; LANES];
                    room[..rest.len()].copy_from_slice(rest);
                    judge(&line, column, &mut room);
                    rest.copy_from_slice(&room[..rest.len()]);
                }
            }
        }
    }
}

/// A triangle in a row of samples: two barycentric coordinates are (rise − fall (x − start)) scale.
struct Row {
    rise: [f64; 2],
    fall: [f64; 2],
    start: [f64; 2],
    scale: f64,
    /// Numbers of colours at the corners, and the last colour's.
    numbers: [f64; 3],
    last: f64,
}

/// The least barycentric coordinate of a sample that counts as inside. It is negative, so that rounding leaves no gap between triangles.
const INSIDE: f64 = -1e-9;

impl Row {
    /// Writes the colours of the samples inside among those from a column on.
    fn judge(&self, column: usize, samples: &mut [u16; LANES]) {
        let [a, b] =
            [0, 1].map(|k| move |x: f64| (self.rise[k] - self.fall[k] * (x - self.start[k])) * self.scale);
        for (k, sample) in samples.iter_mut().enumerate() {
            let x = column as f64 + (k as f64 + 0.5);
            let (wa, wb) = (a(x), b(x));
            let wc = 1.0 - wa - wb;
            if wa >= INSIDE && wb >= INSIDE && wc >= INSIDE {
                let number = self.numbers[0] * wa + self.numbers[1] * wb + self.numbers[2] * wc;
                *sample = number.max(0.0).min(self.last) as u16;
            }
        }
    }

    /// [`Row::judge`] by four samples at a time.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    #[inline]
    fn judge_with_avx2(&self, column: usize, samples: &mut [u16; LANES]) {
        use std::arch::x86_64::*;
        let all = |value: f64| _mm256_set1_pd(value);
        let four = |offsets: __m256d| {
            let x = _mm256_add_pd(all(column as f64), offsets);
            let weight = |k: usize| {
                let along = _mm256_mul_pd(all(self.fall[k]), _mm256_sub_pd(x, all(self.start[k])));
                _mm256_mul_pd(_mm256_sub_pd(all(self.rise[k]), along), all(self.scale))
            };
            let (wa, wb) = (weight(0), weight(1));
            let wc = _mm256_sub_pd(_mm256_sub_pd(all(1.0), wa), wb);
            let term = |k: usize, weight: __m256d| _mm256_mul_pd(all(self.numbers[k]), weight);
            let number = _mm256_add_pd(_mm256_add_pd(term(0, wa), term(1, wb)), term(2, wc));
            let number = _mm256_min_pd(_mm256_max_pd(number, all(0.0)), all(self.last));
            let inside = |weight: __m256d| _mm256_cmp_pd::<_CMP_GE_OQ>(weight, all(INSIDE));
            let inside = _mm256_and_pd(_mm256_and_pd(inside(wa), inside(wb)), inside(wc));
            let inside = _mm256_castpd_si256(inside);
            let halves = (_mm256_castsi256_si128(inside), _mm256_extracti128_si256::<1>(inside));
            (_mm256_cvttpd_epi32(number), _mm_packs_epi32(halves.0, halves.1))
        };
        let low = four(_mm256_setr_pd(0.5, 1.5, 2.5, 3.5));
        let high = four(_mm256_setr_pd(4.5, 5.5, 6.5, 7.5));
        let (numbers, inside) = (_mm_packus_epi32(low.0, high.0), _mm_packs_epi32(low.1, high.1));
        let place = samples.as_mut_ptr().cast::<__m128i>();
        // SAFETY: the eight numbers of sixteen bits are the sixteen bytes that are read and written, wherever they begin.
        unsafe { _mm_storeu_si128(place, _mm_blendv_epi8(_mm_loadu_si128(place), numbers, inside)) };
    }
}

/// The line through an edge, as a bound of the columns inside.
struct Edge {
    start: Point,
    /// Columns per row.
    run: f64,
    side: Side,
}

/// The side of an edge on which the triangle lies.
#[derive(PartialEq)]
enum Side {
    Right,
    Left,
    /// The edge is too flat for a decision.
    Unknown,
}

impl Edge {
    #[inline(always)]
    fn new(p: Point, q: Point, area: f64) -> Edge {
        let rise = q[1] - p[1];
        let side = if rise.abs() < FLAT {
            Side::Unknown
        } else if (rise < 0.0) == (area > 0.0) {
            Side::Right
        } else {
            Side::Left
        };
        Edge { start: p, run: (q[0] - p[0]) / rise, side }
    }

    /// Bounds the columns of a row.
    #[inline(always)]
    fn narrow(&self, y: f64, low: &mut f64, high: &mut f64) {
        let at = self.start[0] + self.run * (y - self.start[1]);
        *low = if self.side == Side::Right { low.max(at) } else { *low };
        *high = if self.side == Side::Left { high.min(at) } else { *high };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers between 0 and 1 (SplitMix64, Steele, Lea and Flood 2014).
    fn random(state: &mut u64) -> f64 {
        *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Triangles of all sizes, in and next to a picture whose rows are no multiple of eight: each sample is judged by its
    /// barycentric coordinates as they are written down, and vectors find what single numbers find.
    #[test]
    fn samples_are_those_inside() {
        let (width, height, first) = (61, 32, 16);
        let mut state = 1;
        for case in 0..2000 {
            let size = [3.0, 20.0, 200.0][case % 3];
            let middle = [random(&mut state) * 61.0, 16.0 + random(&mut state) * 32.0];
            let mut point = || middle.map(|x| x + size * (random(&mut state) - 0.5));
            let mut points = [point(), point(), point()];
            if case % 5 == 0 {
                // A level edge, through the centres of samples.
                points[1][1] = points[0][1].floor() + 0.5;
                points[0][1] = points[1][1];
            }
            let numbers = [0, 1, 2].map(|_| random(&mut state) * 130.0 - 15.0);
            let all = Triangles { points: &points, numbers: &numbers, triangles: &[[0, 1, 2]] };
            let mut found = vec![100; width * height];
            all.sample(&[0], &mut Rows { first, width, colours: 100, sampled: &mut found });
            let mut plain = vec![100; width * height];
            let mut rows = Rows { first, width, colours: 100, sampled: &mut plain };
            sample_all(&all, &[0], &mut rows, |row, column, samples| row.judge(column, samples));
            assert_eq!(found, plain, "case {case}");
            let [a, b, c] = points;
            let double =
                |p: Point, q: Point, r: Point| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
            for (k, sample) in found.into_iter().enumerate() {
                let at = [(k % width) as f64 + 0.5, (first + k / width) as f64 + 0.5];
                let weights =
                    [double(b, c, at), double(c, a, at), double(a, b, at)].map(|area| area / double(a, b, c));
                let least = weights.iter().copied().fold(f64::INFINITY, f64::min);
                if least.abs() > 1e-8 {
                    assert_eq!(sample < 100, least > 0.0, "case {case}, sample {k}");
                }
                let number: f64 = weights.iter().zip(numbers).map(|(weight, number)| weight * number).sum();
                if sample < 100 && (number - number.round()).abs() > 1e-6 {
                    assert_eq!(f64::from(sample), number.clamp(0.0, 99.0).floor(), "case {case}, sample {k}");
                }
            }
        }
    }
}
