//! Curves and the markers at their points.

use super::PictureError;
use super::axes::{Scale, number};
use super::colour_map::Colour;
use super::drawing::polyline;
use super::path::{Point, Segment};

/// The sign drawn at each point of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// A disc.
    Circle,
    /// A square.
    Square,
    /// A triangle standing on its side.
    Triangle,
    /// A square standing on its corner.
    Diamond,
}

impl Marker {
    pub(super) const ALL: [Marker; 4] = [Marker::Circle, Marker::Square, Marker::Triangle, Marker::Diamond];

    /// The outline about a point, for a marker as wide as 2 `radius`. Another crate of the backend draws markers, too.
    #[doc(hidden)]
    pub fn outline(self, [x, y]: Point, radius: f64) -> Vec<Segment> {
        let corners: Vec<Point> = match self {
            Marker::Circle => return circle([x, y], radius),
            Marker::Square => [[-0.89, -0.89], [0.89, -0.89], [0.89, 0.89], [-0.89, 0.89]].to_vec(),
            Marker::Triangle => [[0.0, -1.25], [1.08, 0.62], [-1.08, 0.62]].to_vec(),
            Marker::Diamond => [[0.0, -1.25], [1.25, 0.0], [0.0, 1.25], [-1.25, 0.0]].to_vec(),
        };
        let corners: Vec<Point> = corners.iter().map(|c| [x + radius * c[0], y + radius * c[1]]).collect();
        let mut segments = polyline(&corners);
        segments.push(Segment::Close);
        segments
    }
}

/// A circle as four cubic curves, within 3·10⁻⁴ of its radius.
fn circle([x, y]: Point, radius: f64) -> Vec<Segment> {
    const HANDLE: f64 = 0.552_284_75;
    let at = |dx: f64, dy: f64| [x + radius * dx, y + radius * dy];
    let mut segments = vec![Segment::Move(at(1.0, 0.0))];
    let (mut dx, mut dy) = (1.0, 0.0);
    for _ in 0..4 {
        let (ex, ey) = (-dy, dx);
        segments.push(Segment::Cubic(
            at(dx + HANDLE * ex, dy + HANDLE * ey),
            at(ex + HANDLE * dx, ey + HANDLE * dy),
            at(ex, ey),
        ));
        (dx, dy) = (ex, ey);
    }
    segments.push(Segment::Close);
    segments
}

/// A curve through points.
#[derive(Clone, Debug)]
pub struct Curve {
    pub(super) name: String,
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    pub(super) colour: Option<Colour>,
    pub(super) marker: Option<Option<Marker>>,
    pub(super) dashes: Vec<f64>,
    pub(super) line: bool,
    order_over: Option<usize>,
    pub(super) triangles: Vec<SlopeTriangle>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct SlopeTriangle {
    pub order: f64,
    pub above: bool,
}

impl Curve {
    /// A curve; the name is in the legend unless it is empty.
    ///
    /// ```
    /// # use forms_pictures::Curve;
    /// let curve = Curve::new("measured", &[0.0, 1.0, 2.0], &[0.0, 0.9, 2.1]).without_line();
    /// ```
    pub fn new(name: &str, x: &[f64], y: &[f64]) -> Curve {
        Curve {
            name: name.into(),
            x: x.to_vec(),
            y: y.to_vec(),
            colour: None,
            marker: None,
            dashes: Vec::new(),
            line: true,
            order_over: None,
            triangles: Vec::new(),
        }
    }

    /// Colour of the curve; without it the curve takes the next one of [`Colour::of_series`].
    pub fn colour(mut self, colour: Colour) -> Curve {
        self.colour = Some(colour);
        self
    }

    /// Marker of the points; without it curves of at most 30 points are marked, each in its own way.
    pub fn marker(mut self, marker: Marker) -> Curve {
        self.marker = Some(Some(marker));
        self
    }

    /// The curve as a line only.
    pub fn without_markers(mut self) -> Curve {
        self.marker = Some(None);
        self
    }

    /// The curve as markers only, for values that have no order.
    pub fn without_line(mut self) -> Curve {
        self.line = false;
        self
    }

    /// The curve as a dashed line.
    ///
    /// ```
    /// # use forms_pictures::Curve;
    /// let curve = Curve::new("closed form", &[0.0, 2.0], &[0.0, 2.0]).dashed();
    /// ```
    pub fn dashed(mut self) -> Curve {
        self.dashes = vec![5.0, 3.0];
        self
    }

    /// Slope of log y over log x for the legend, fitted to the last `points` points.
    pub fn fitted_order(mut self, points: usize) -> Curve {
        self.order_over = Some(points);
        self
    }

    /// Triangle of a slope below the curve, at its smallest x. Both axes must be logarithmic.
    pub fn slope_triangle(mut self, order: f64) -> Curve {
        self.triangles.push(SlopeTriangle { order, above: false });
        self
    }

    /// Triangle of a slope above the curve, at its smallest x. Both axes must be logarithmic.
    pub fn slope_triangle_above(mut self, order: f64) -> Curve {
        self.triangles.push(SlopeTriangle { order, above: true });
        self
    }

    pub(super) fn check(&self, scales: [Scale; 2]) -> Result<(), PictureError> {
        if self.x.len() != self.y.len() {
            let name = self.name.clone();
            return Err(PictureError::Length { name, expected: self.x.len(), found: self.y.len() });
        }
        if self.x.is_empty() {
            return Err(PictureError::Empty { picture: format!("the curve \"{}\"", self.name) });
        }
        for (values, scale) in [&self.x, &self.y].into_iter().zip(scales) {
            for (index, &value) in values.iter().enumerate() {
                let name = || self.name.clone();
                if !value.is_finite() {
                    return Err(PictureError::NotFinite { name: name(), index, value });
                }
                if scale == Scale::Logarithmic && value <= 0.0 {
                    return Err(PictureError::NotPositive { name: name(), index, value });
                }
            }
        }
        Ok(())
    }

    /// The slope of log y over log x by least squares over the last `points` points; `None` with fewer than two
    /// different positive points.
    pub fn order(&self, points: usize) -> Option<f64> {
        let start = self.x.len().saturating_sub(points);
        let logarithms: Vec<Point> =
            self.x[start..].iter().zip(&self.y[start..]).map(|(x, y)| [x.ln(), y.ln()]).collect();
        let count = logarithms.len() as f64;
        let mean = |k: usize| logarithms.iter().map(|p| p[k]).sum::<f64>() / count;
        let (mean_x, mean_y) = (mean(0), mean(1));
        let covariance: f64 = logarithms.iter().map(|p| (p[0] - mean_x) * (p[1] - mean_y)).sum();
        let variance: f64 = logarithms.iter().map(|p| (p[0] - mean_x).powi(2)).sum();
        let order = covariance / variance;
        order.is_finite().then_some(order)
    }

    pub(super) fn legend_text(&self) -> String {
        match self.order_over.and_then(|points| self.order(points)) {
            Some(order) => format!("{}, order {}", self.name, number(order, 2)),
            None => self.name.clone(),
        }
    }
}
