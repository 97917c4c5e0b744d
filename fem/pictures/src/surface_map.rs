//! A surface in space, seen from a direction: triangles with a colour each, lit from next to the eye.

use super::colour_map::{Colour, ColourMap};
use super::drawing::{Drawing, polyline};
use super::layout::Layout;
use super::legend::Legend;
use super::path::{Point, Segment};
use super::shading::Shading;
use super::{Picture, PictureError};

/// Triangles grow by this on the page, so that no seams show between neighbours \[pt\].
const SEAM: f64 = 0.25;
/// The part of the light that reaches every triangle.
const AMBIENT: f64 = 0.45;

/// A picture of triangles in space \[length\], coloured by a value each. What is nearer hides what is behind it.
///
/// ```no_run
/// # use forms_pictures::{Picture, SurfaceMap};
/// let roof = [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.5, 1.0]], [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.5, 0.5, 1.0]]];
/// SurfaceMap::new(&roof, &[1.0, 2.0], "pressure").seen_from([2.0, -1.0, 1.0]).write_png("roof.png")?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct SurfaceMap<'a> {
    triangles: &'a [[[f64; 3]; 3]],
    values: &'a [f64],
    label: String,
    title: String,
    from: [f64; 3],
    largest: [f64; 2],
    colours: ColourMap,
}

impl<'a> SurfaceMap<'a> {
    /// A picture of triangles with a value each; the label, with the unit, is at the colour bar.
    pub fn new(triangles: &'a [[[f64; 3]; 3]], values: &'a [f64], label: &str) -> Self {
        let (label, title, from) = (label.to_owned(), String::new(), [1.0, -2.0, 1.0]);
        SurfaceMap {
            triangles,
            values,
            label,
            title,
            from,
            largest: [300.0; 2],
            colours: ColourMap::default(),
        }
    }

    /// The direction toward the eye. The third axis is up, except where the eye is on it.
    pub fn seen_from(mut self, from: [f64; 3]) -> Self {
        self.from = from;
        self
    }

    /// Title above the picture.
    pub fn title(mut self, title: &str) -> Self {
        self.title = title.into();
        self
    }

    /// Largest width and height of the surface on the page \[pt\].
    pub fn size(mut self, width: f64, height: f64) -> Self {
        self.largest = [width, height];
        self
    }

    /// The directions to the right, up and toward the eye.
    fn directions(&self) -> Result<[[f64; 3]; 3], PictureError> {
        let Some(eye) = unit(self.from) else {
            let name = "direction toward the eye".into();
            return Err(PictureError::NotFinite { name, index: 0, value: f64::NAN });
        };
        let right = unit(cross([0.0, 0.0, 1.0], eye)).unwrap_or([1.0, 0.0, 0.0]);
        Ok([right, cross(eye, right), eye])
    }

    fn check(&self) -> Result<(), PictureError> {
        let (name, expected, found) = (self.label.clone(), self.triangles.len(), self.values.len());
        if expected == 0 {
            return Err(PictureError::Empty { picture: name });
        }
        if expected != found {
            return Err(PictureError::Length { name, expected, found });
        }
        let coordinates = self.triangles.as_flattened().as_flattened().iter();
        let numbers = self.values.iter().chain(coordinates).enumerate();
        match numbers.into_iter().find(|(_, value)| !value.is_finite()) {
            Some((index, &value)) => Err(PictureError::NotFinite { name, index, value }),
            None => Ok(()),
        }
    }
}

impl Picture for SurfaceMap<'_> {
    fn draw(&self) -> Result<Drawing, PictureError> {
        self.check()?;
        let [right, up, eye] = self.directions()?;
        let flat = |x: &[f64; 3]| [inner(&right, x), inner(&up, x)];
        let mut window = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for point in self.triangles.as_flattened().iter().map(flat) {
            for k in 0..2 {
                window[0][k] = window[0][k].min(point[k]);
                window[1][k] = window[1][k].max(point[k]);
            }
        }
        let [low, high] =
            self.values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(*v), b.max(*v)]);
        let range = if high > low { [low, high] } else { [low - 1.0, low + 1.0] };
        let shading = Shading { map: self.colours, range, levels: None, flat: None };
        let layout = Layout {
            title: &self.title,
            unit: None,
            axes: ["", ""],
            largest: self.largest,
            window,
            bar: Some((shading, self.label.clone())),
            legend: Legend::new(vec![]),
        };
        let (mut drawing, frame) = layout.begin()?;
        let depth = |triangle: &[[f64; 3]; 3]| triangle.iter().map(|x| inner(&eye, x)).sum::<f64>();
        let mut order: Vec<usize> = (0..self.triangles.len()).collect();
        order.sort_by(|a, b| depth(&self.triangles[*a]).total_cmp(&depth(&self.triangles[*b])));
        let light = unit([0, 1, 2].map(|k| eye[k] + 0.6 * up[k] - 0.3 * right[k])).unwrap_or(eye);
        for number in order {
            let triangle = &self.triangles[number];
            let [a, b] = [1, 2].map(|k| [0, 1, 2].map(|i| triangle[k][i] - triangle[0][i]));
            // Neither side is the outward one; the one toward the eye is seen.
            let lit = unit(cross(a, b)).map_or(1.0, |n| {
                let seen = if inner(&n, &eye) < 0.0 { -inner(&n, &light) } else { inner(&n, &light) };
                AMBIENT + (1.0 - AMBIENT) * seen.max(0.0)
            });
            let corners = grown(triangle.map(|x| frame.place(flat(&x))));
            let mut segments = polyline(&corners);
            segments.push(Segment::Close);
            drawing.path(segments, Some(dimmed(shading.colour(self.values[number]), lit)), None);
        }
        layout.finish(&mut drawing, &frame);
        Ok(drawing)
    }
}

fn inner(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

/// The direction of a vector; none of zero, or of what is not finite.
fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = inner(&a, &a).sqrt();
    (length > 0.0 && length.is_finite()).then(|| a.map(|x| x / length))
}

/// A triangle whose corners are moved away from its centre.
fn grown(corners: [Point; 3]) -> [Point; 3] {
    let centre = [0, 1].map(|k| corners.iter().map(|x| x[k]).sum::<f64>() / 3.0);
    corners.map(|[x, y]| {
        let off = [x - centre[0], y - centre[1]];
        let factor = SEAM / off[0].hypot(off[1]).max(SEAM);
        [x + factor * off[0], y + factor * off[1]]
    })
}

fn dimmed(colour: Colour, lit: f64) -> Colour {
    Colour { rgb: colour.rgb.map(|part| (f64::from(part) * lit).round() as u8), ..colour }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::Item;

    /// The nearer triangle is drawn last, from either side.
    #[test]
    fn nearer_triangles_hide_others() {
        let at = |z: f64| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
        let (both, values) = ([at(0.0), at(1.0)], [0.0, 1.0]);
        for (from, last) in [([0.0, 0.0, 1.0], 1.0), ([0.0, 0.0, -3.0], 0.0)] {
            let drawing = SurfaceMap::new(&both, &values, "height").seen_from(from).draw().unwrap();
            let mut fills = drawing.items().iter().filter_map(|item| match item {
                Item::Path { segments, fill: Some(fill), .. } if segments.len() == 4 => Some(fill.rgb),
                _ => None,
            });
            let lit = 1.0 / (1.0_f64 + 0.36 + 0.09).sqrt();
            let expected = dimmed(ColourMap::default().at(last), AMBIENT + (1.0 - AMBIENT) * lit);
            assert_eq!(fills.next_back(), Some(expected.rgb));
        }
        assert!(SurfaceMap::new(&both, &[0.0], "height").draw().is_err());
        assert!(SurfaceMap::new(&both, &[0.0, f64::NAN], "height").draw().is_err());
        assert!(SurfaceMap::new(&both, &values, "height").seen_from([0.0; 3]).draw().is_err());
        assert!(SurfaceMap::new(&[], &[], "height").draw().is_err());
    }
}
