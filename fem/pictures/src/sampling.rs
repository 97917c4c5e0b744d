//! The samples inside triangles: the inner loop of shaded surfaces, compiled for the vectors of the machine too.
//!
//! The same operations in the same order whatever the machine: pictures are equal to the last pixel.

use super::drawing::Point;

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
    /// Writes the colour of each sample inside the chosen triangles, one triangle after the other.
    pub fn sample(&self, chosen: &[u32], rows: &mut Rows<'_>) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the line above has asked for the instructions that the function is compiled for.
            return unsafe { sample_with_avx2(self, chosen, rows) };
        }
        sample_all(self, chosen, rows);
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn sample_with_avx2(all: &Triangles<'_>, chosen: &[u32], rows: &mut Rows<'_>) {
    sample_all(all, chosen, rows);
}

#[inline(always)]
fn sample_all(all: &Triangles<'_>, chosen: &[u32], rows: &mut Rows<'_>) {
    for &triangle in chosen {
        let [a, b, c] = all.triangles[triangle as usize];
        let corners = [all.points[a as usize], all.points[b as usize], all.points[c as usize]];
        let numbers = [all.numbers[a as usize], all.numbers[b as usize], all.numbers[c as usize]];
        sample_one(corners, numbers, rows);
    }
}

/// Barycentric coordinates are linear in x and y; a sample on an edge belongs to both sides.
#[inline(always)]
fn sample_one([a, b, c]: [Point; 3], numbers: [f64; 3], rows: &mut Rows<'_>) {
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
    let scale = 1.0 / area;
    let inside = -1e-9;
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
        let (rise_a, rise_b) = ((c[0] - b[0]) * (y - b[1]), (a[0] - c[0]) * (y - c[1]));
        let samples = &mut rows.sampled[row * width..(row + 1) * width];
        let mut column = start;
        while column < end {
            let (mut number, mut covered) = ([0; LANES], [0; LANES]);
            for k in 0..LANES {
                let x = column as f64 + (k as f64 + 0.5);
                let wa = (rise_a - (c[1] - b[1]) * (x - b[0])) * scale;
                let wb = (rise_b - (a[1] - c[1]) * (x - c[0])) * scale;
                let wc = 1.0 - wa - wb;
                let value = numbers[0] * wa + numbers[1] * wb + numbers[2] * wc;
                number[k] = value.clamp(0.0, last_number) as i32 as u16;
                covered[k] = if (wa >= inside) & (wb >= inside) & (wc >= inside) { u16::MAX } else { 0 };
            }
            for k in 0..LANES.min(width - column) {
                let sample = &mut samples[column + k];
                *sample = (number[k] & covered[k]) | (*sample & !covered[k]);
            }
            column += LANES;
        }
    }
}

/// The line through an edge, as a bound of the columns inside.
struct Edge {
    start: Point,
    /// Columns per row.
    run: f64,
    side: Side,
}

/// Where the triangle lies beside an edge.
#[derive(PartialEq)]
enum Side {
    Right,
    Left,
    /// The edge is too flat to tell.
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
