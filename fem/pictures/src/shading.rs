//! Surfaces coloured by values: triangles with linear values, sampled several times per pixel.
//!
//! The value is interpolated and then coloured, so colours between two nodes lie on the colour map.
//! Neighbouring triangles share every sample on their common edge: there are no seams, and the
//! outline is smooth because each pixel is the mean of its samples.

use std::num::NonZeroUsize;
use std::sync::Arc;

use super::colour_map::{Colour, ColourMap};
use super::on_threads;
use super::path::Point;
use super::sampling::{Rows, Triangles};

/// Samples per pixel in each direction.
const SAMPLES: usize = 4;
/// Rows of pixels that are sampled at once; bounds the memory.
const BAND: usize = 32;

/// The colours of values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shading {
    pub map: ColourMap,
    /// Values at the ends of the colour map.
    pub range: [f64; 2],
    /// Number of bands of equal colour; `None` for a continuous map.
    pub levels: Option<usize>,
    /// One colour for all values.
    pub flat: Option<Colour>,
}

impl Shading {
    /// The colour of a value.
    pub fn colour(&self, value: f64) -> Colour {
        if let Some(colour) = self.flat {
            return colour;
        }
        let [low, high] = self.range;
        let t = if high > low { ((value - low) / (high - low)).clamp(0.0, 1.0) } else { 0.5 };
        self.map.at(match self.levels {
            Some(levels) if levels > 1 => {
                (t * levels as f64).floor().min((levels - 1) as f64) / (levels - 1) as f64
            }
            Some(_) => 0.5,
            None => t,
        })
    }
}

/// Triangles with a value at each point. Copies share their data, because a panel shows surfaces that are also drawn by themselves.
#[derive(Clone, Debug)]
pub struct ShadedSurface {
    /// Points, counted from `origin`.
    pub points: Arc<Vec<Point>>,
    pub values: Arc<Vec<f32>>,
    pub triangles: Arc<Vec<[u32; 3]>>,
    pub shading: Shading,
    /// The place on the page that points are counted from.
    pub origin: Point,
}

/// Pixels of a surface: rows of RGB with the covered fraction as alpha (not premultiplied).
pub struct Pixels {
    /// Left and top of the picture, in pixels of the page.
    pub origin: [usize; 2],
    pub size: [usize; 2],
    pub rgba: Vec<u8>,
}

impl ShadedSurface {
    /// A surface whose points are counted from the corner of the page.
    pub fn new(points: Vec<Point>, values: Vec<f32>, triangles: Vec<[u32; 3]>, shading: Shading) -> Self {
        let (points, values, triangles) = (Arc::new(points), Arc::new(values), Arc::new(triangles));
        ShadedSurface { points, values, triangles, shading, origin: [0.0; 2] }
    }

    /// The surface at `scale` pixels per point, on a page of `page` pixels; `None` if nothing is seen. Bands of rows are sampled on the given
    /// number of threads, with the same pixels on any number.
    pub fn pixels(&self, scale: f64, page: [usize; 2], threads: NonZeroUsize) -> Option<Pixels> {
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for point in self.points.iter() {
            for k in 0..2 {
                let place = (point[k] + self.origin[k]) * scale;
                (low[k], high[k]) = (low[k].min(place), high[k].max(place));
            }
        }
        let start: [usize; 2] = std::array::from_fn(|k| low[k].floor().max(0.0) as usize);
        let end: [usize; 2] = std::array::from_fn(|k| (high[k].ceil().max(0.0) as usize).min(page[k]));
        if start[0] >= end[0] || start[1] >= end[1] {
            return None;
        }
        let size = [end[0] - start[0], end[1] - start[1]];
        let samples = SAMPLES as f64;
        // Points in samples, so that sample (i, j) has its centre at (i + 1/2, j + 1/2).
        let points: Vec<Point> = self
            .points
            .iter()
            .map(|p| std::array::from_fn(|k| ((p[k] + self.origin[k]) * scale - start[k] as f64) * samples))
            .collect();
        let table: Vec<[u8; 3]> = self.colour_table();
        let numbers: Vec<f64> = self.values.iter().map(|&value| self.place_in(value, table.len())).collect();
        let all = Triangles { points: &points, numbers: &numbers, triangles: &self.triangles };
        let mut bands = vec![Vec::new(); size[1].div_ceil(BAND)];
        let rows = (BAND * SAMPLES) as f64;
        for (t, triangle) in self.triangles.iter().enumerate() {
            let y = triangle.map(|n| points[n as usize][1]);
            let (top, bottom) = (y[0].min(y[1]).min(y[2]), y[0].max(y[1]).max(y[2]));
            if bottom < 0.0 {
                continue;
            }
            let last = ((bottom / rows) as usize).min(bands.len() - 1);
            for band in bands.iter_mut().take(last + 1).skip((top.max(0.0) / rows) as usize) {
                band.push(t as u32);
            }
        }
        let uncovered = table.len() as u16;
        let colours: Vec<u64> = table.iter().map(|&rgb| packed(rgb)).chain([0]).collect();
        let width = size[0] * SAMPLES;
        let coloured = |band: usize| {
            let mut sampled = vec![uncovered; BAND * SAMPLES * width];
            let first = band * BAND * SAMPLES;
            let rows = &mut Rows { first, width, colours: table.len(), sampled: &mut sampled };
            all.sample(&bands[band], rows);
            let mut rgba = vec![0; 4 * size[0] * BAND.min(size[1] - band * BAND)];
            let rows = rgba.chunks_exact_mut(4 * size[0]);
            for (row, samples) in rows.zip(sampled.chunks_exact(SAMPLES * width)) {
                average(samples, uncovered, &colours, row);
            }
            rgba
        };
        let order: Vec<usize> = (0..bands.len()).collect();
        let rgba = on_threads(&order, threads, coloured).concat();
        Some(Pixels { origin: start, size, rgba })
    }

    /// The place of a value in a table of the given number of colours.
    fn place_in(&self, value: f32, colours: usize) -> f64 {
        let [low, high] = self.shading.range;
        let t = if high > low { (f64::from(value) - low) / (high - low) } else { 0.5 };
        t * colours as f64
    }

    /// Colours of evenly spaced values in the range.
    fn colour_table(&self) -> Vec<[u8; 3]> {
        let [low, high] = self.shading.range;
        (0..1024)
            .map(|k| self.shading.colour(low + (high - low) * (f64::from(k) + 0.5) / 1024.0).rgb)
            .collect()
    }
}

/// A colour and a count of one, as four numbers of sixteen bits. Sums over the samples of a pixel do not overflow from
/// one number into the next.
fn packed([red, green, blue]: [u8; 3]) -> u64 {
    u64::from(red) | u64::from(green) << 16 | u64::from(blue) << 32 | 1 << 48
}

/// Mean colours of the samples of a row of pixels, with the covered fraction as alpha. Colours of samples outside are zero.
fn average(samples: &[u16], uncovered: u16, colours: &[u64], pixels: &mut [u8]) {
    let width = samples.len() / SAMPLES;
    for (column, pixel) in pixels.chunks_exact_mut(4).enumerate() {
        // Most pixels next to a body have no sample in it.
        let row = |row: usize| &samples[row * width + column * SAMPLES..][..SAMPLES];
        if (0..SAMPLES).all(|k| row(k) == [uncovered; SAMPLES]) {
            continue;
        }
        let mut sum = 0;
        for k in 0..SAMPLES {
            sum += row(k).iter().map(|&number| colours[usize::from(number)]).sum::<u64>();
        }
        let covered = (sum >> 48) as usize;
        if covered > 0 {
            let mean = |k: usize| (((sum >> (16 * k)) as usize & 0xffff) + covered / 2) / covered;
            let alpha = covered * 255 / (SAMPLES * SAMPLES);
            pixel.copy_from_slice(&[mean(0), mean(1), mean(2), alpha].map(|channel| channel as u8));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(values: [f32; 4]) -> ShadedSurface {
        let points = vec![[2.0, 3.0], [12.0, 3.0], [12.0, 13.0], [2.0, 13.0]];
        let shading = Shading { map: ColourMap::Viridis, range: [0.0, 1.0], levels: None, flat: None };
        ShadedSurface::new(points, values.to_vec(), vec![[0, 1, 2], [0, 2, 3]], shading)
    }

    /// A square of 10 × 10 pixels covers 100 pixels fully: no seam on the diagonal, no fringe.
    #[test]
    fn a_square_has_its_pixels_and_no_seam() {
        let pixels = square([0.25; 4]).pixels(1.0, [20, 20], NonZeroUsize::MIN).unwrap();
        assert_eq!((pixels.origin, pixels.size), ([2, 3], [10, 10]));
        assert!(pixels.rgba.chunks(4).all(|pixel| pixel[3] == 255 && pixel == &pixels.rgba[..4]));
    }

    /// Coverage of a half-covered pixel column is one half.
    #[test]
    fn outline_is_antialiased() {
        let mut surface = square([0.5; 4]);
        surface.origin[0] += 0.5;
        let pixels = surface.pixels(1.0, [20, 20], NonZeroUsize::MIN).unwrap();
        assert_eq!(pixels.size, [11, 10]);
        assert_eq!(pixels.rgba[3], 127);
        assert_eq!(pixels.rgba[7], 255);
    }

    /// A linear value gives the colour map's own colours along the square.
    #[test]
    fn linear_values_run_through_the_map() {
        let pixels = square([0.0, 1.0, 1.0, 0.0]).pixels(1.0, [20, 20], NonZeroUsize::MIN).unwrap();
        for column in 0..10 {
            // The mean of the map over the width of the pixel.
            let colours =
                (0..100).map(|k| ColourMap::Viridis.at((column as f64 + f64::from(k) / 100.0) / 10.0).rgb);
            let mut mean = [0.0; 3];
            colours.for_each(|rgb| (0..3).for_each(|k| mean[k] += f64::from(rgb[k]) / 100.0));
            for (mean, found) in mean.into_iter().zip(&pixels.rgba[4 * column..]) {
                assert!((f64::from(*found) - mean).abs() < 2.0, "column {column}: {found} and {mean}");
            }
        }
    }

    #[test]
    fn levels_are_even() {
        let shading = Shading { map: ColourMap::Viridis, range: [0.0, 4.0], levels: Some(4), flat: None };
        assert_eq!(shading.colour(0.9), shading.colour(0.1));
        assert_eq!(shading.colour(4.0), ColourMap::Viridis.at(1.0));
        assert_eq!(shading.colour(0.0), ColourMap::Viridis.at(0.0));
    }
}
