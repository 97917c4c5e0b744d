//! Curves over axes: convergence plots, pressure along a boundary, iteration histories.

use super::axes::{AXIS_LINE, Axis, Frame, GAP, Scale, TICK_TEXT, TITLE_TEXT, number};
use super::colour_map::Colour;
use super::curve::{Curve, Marker, SlopeTriangle};
use super::drawing::{Drawing, Stroke, polyline};
use super::legend::{Key, Legend, passes};
use super::path::{Point, Rectangle, Segment};
use super::text::{Anchor, CAPITAL_HEIGHT};
use super::{Picture, PictureError};

/// A picture of curves.
///
/// ```no_run
/// # mod forms_fem { pub mod output { pub use forms_pictures as picture; } }
/// use forms_fem::output::picture::{Curve, LinePlot, Picture, Scale};
///
/// let (h, error) = ([0.4, 0.2, 0.1], [2e-2, 5e-3, 1.25e-3]);
/// LinePlot::new()
///     .x_axis("h [mm]", Scale::Logarithmic)
///     .y_axis("relative error", Scale::Logarithmic)
///     .curve(Curve::new("k = 2", &h, &error).fitted_order(3).slope_triangle(2.0))
///     .write_png("convergence.png")?;
/// # Ok::<(), forms_fem::output::picture::PictureError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct LinePlot {
    title: String,
    labels: [String; 2],
    scales: [Scale; 2],
    ranges: [Option<[f64; 2]>; 2],
    curves: Vec<Curve>,
    references: Vec<(usize, f64, String)>,
    size: Option<[f64; 2]>,
    grid: bool,
}

impl LinePlot {
    /// A plot without curves, 330 pt × 250 pt.
    pub fn new() -> LinePlot {
        LinePlot::default()
    }

    /// Title above the plot.
    ///
    /// ```
    /// # use forms_pictures::{Curve, LinePlot};
    /// LinePlot::new().title("Force over stretch").curve(Curve::new("", &[1.0, 2.0], &[0.0, 3.0]));
    /// ```
    pub fn title(mut self, title: &str) -> LinePlot {
        self.title = title.into();
        self
    }

    /// Label, with the unit, and scale of the horizontal axis.
    ///
    /// ```
    /// # use forms_pictures::{LinePlot, Scale};
    /// LinePlot::new().x_axis("time [s]", Scale::Linear).y_axis("force [N]", Scale::Linear);
    /// ```
    pub fn x_axis(mut self, label: &str, scale: Scale) -> LinePlot {
        (self.labels[0], self.scales[0]) = (label.into(), scale);
        self
    }

    /// Label, with the unit, and scale of the vertical axis.
    pub fn y_axis(mut self, label: &str, scale: Scale) -> LinePlot {
        (self.labels[1], self.scales[1]) = (label.into(), scale);
        self
    }

    /// Ends of the horizontal axis; otherwise they follow the curves.
    pub fn x_range(mut self, low: f64, high: f64) -> LinePlot {
        self.ranges[0] = Some([low, high]);
        self
    }

    /// Ends of the vertical axis; otherwise they follow the curves.
    pub fn y_range(mut self, low: f64, high: f64) -> LinePlot {
        self.ranges[1] = Some([low, high]);
        self
    }

    /// One more curve.
    pub fn curve(mut self, curve: Curve) -> LinePlot {
        self.curves.push(curve);
        self
    }

    /// Dotted vertical line with a label at its top.
    pub fn vertical_line(mut self, x: f64, label: &str) -> LinePlot {
        self.references.push((0, x, label.into()));
        self
    }

    /// Dotted horizontal line with a label at its right end.
    pub fn horizontal_line(mut self, y: f64, label: &str) -> LinePlot {
        self.references.push((1, y, label.into()));
        self
    }

    /// Faint lines at the labelled ticks.
    pub fn grid(mut self) -> LinePlot {
        self.grid = true;
        self
    }

    /// Width and height of the picture \[pt\].
    pub fn size(mut self, width: f64, height: f64) -> LinePlot {
        self.size = Some([width, height]);
        self
    }

    /// The range of an axis: the data with a margin, unless it is given.
    fn range(&self, k: usize) -> [f64; 2] {
        if let Some(range) = self.ranges[k] {
            return range;
        }
        let curves = self.curves.iter().flat_map(|curve| if k == 0 { &curve.x } else { &curve.y });
        let lines = self.references.iter().filter(|line| line.0 == k).map(|line| &line.1);
        let (mut low, mut high) =
            curves.chain(lines).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
                (low.min(value), high.max(value))
            });
        let triangles = |above: bool| {
            k == 1 && self.curves.iter().flat_map(|curve| &curve.triangles).any(|t| t.above == above)
        };
        let margins = [false, true].map(|above| if triangles(above) { 0.14 } else { 0.06 });
        match self.scales[k] {
            Scale::Linear => {
                let length = if high > low { high - low } else { low.abs().max(1.0) };
                (low, high) = (low - margins[0] * length, high + margins[1] * length);
            }
            Scale::Logarithmic => {
                let ratio = if high > low { high / low } else { 10.0 };
                (low, high) = (low / ratio.powf(margins[0]), high * ratio.powf(margins[1]));
            }
        }
        [low, high]
    }

    /// The places of a curve's points on the page.
    fn points(frame: &Frame, curve: &Curve) -> Vec<Point> {
        curve.x.iter().zip(&curve.y).map(|(&x, &y)| frame.place([x, y])).collect()
    }

    fn keys(&self) -> Vec<Key> {
        let named = self.curves.iter().enumerate().filter(|(_, curve)| !curve.name.is_empty());
        named.map(|(k, curve)| self.key(k, curve)).collect()
    }

    fn key(&self, k: usize, curve: &Curve) -> Key {
        let colour = curve.colour.unwrap_or_else(|| Colour::of_series(k));
        let own = (curve.x.len() <= 30).then(|| Marker::ALL[k % Marker::ALL.len()]);
        Key {
            text: curve.legend_text(),
            stroke: Stroke::dashed(colour, if curve.line { 1.4 } else { 0.0 }, &curve.dashes),
            marker: curve.marker.unwrap_or(own),
        }
    }
}

impl Picture for LinePlot {
    fn draw(&self) -> Result<Drawing, PictureError> {
        if self.curves.is_empty() {
            return Err(PictureError::Empty { picture: format!("the plot \"{}\"", self.title) });
        }
        for curve in &self.curves {
            curve.check(self.scales)?;
        }
        let [width, height] = self.size.unwrap_or([330.0, 250.0]);
        let mut drawing = Drawing::new([width, height])?;
        let title = if self.title.is_empty() { 0.0 } else { TITLE_TEXT + 2.0 * GAP };
        let axis = |k: usize| Axis::new(&self.labels[k], self.scales[k], self.range(k));
        let mut frame = Frame {
            area: Rectangle { left: 50.0, top: title, width: width - 70.0, height: height - 60.0 },
            x: axis(0)?,
            y: axis(1)?,
        };
        let top = title + if frame.has_vertical_exponent() { TICK_TEXT + GAP } else { 1.5 * GAP };
        frame.area.top = top;
        let legend = Legend::new(self.keys());
        let outside = |frame: &mut Frame, foot: f64| {
            // The labels depend on the ticks, and these on the area: the second round settles it.
            for _ in 0..2 {
                let [left, below] = frame.margins(&drawing);
                frame.area.left = left + GAP;
                frame.area.width = width - frame.area.left - 3.5 * GAP;
                frame.area.height = height - top - below - foot - GAP;
            }
        };
        outside(&mut frame, 0.0);
        let mut obstacles: Vec<Vec<Point>> =
            self.curves.iter().map(|curve| LinePlot::points(&frame, curve)).collect();
        obstacles
            .extend(self.references.iter().map(|(k, value, _)| reference_line(&frame, *k, *value).to_vec()));
        let columns = legend.columns(&drawing, width - 4.0 * GAP);
        let mut legend_at =
            legend.corner(&frame.area, legend.size(&drawing, 1), &obstacles).map(|at| (at, 1));
        if legend_at.is_none() {
            let [legend_width, legend_height] = legend.size(&drawing, columns);
            outside(&mut frame, legend_height + 2.0 * GAP);
            let left = frame.area.left + (frame.area.width - legend_width) / 2.0;
            let left = left.min(width - legend_width - GAP).max(GAP);
            legend_at = Some(([left, height - legend_height - GAP], columns));
        }
        if frame.area.width < 20.0 || frame.area.height < 20.0 {
            return Err(PictureError::Size { width, height });
        }
        if self.grid {
            frame.draw_grid(&mut drawing);
        }
        let mut taken: Vec<Vec<Point>> = self.curves.iter().map(|c| LinePlot::points(&frame, c)).collect();
        for (number, (k, value, label)) in self.references.iter().enumerate() {
            let others = self.references.iter().enumerate().filter(|(other, _)| *other != number);
            let lines = others.map(|(_, (k, value, _))| reference_line(&frame, *k, *value).to_vec());
            let count = taken.len();
            taken.extend(lines);
            let label = draw_reference(&mut drawing, &frame, (*k, *value), label, &taken);
            taken.truncate(count);
            taken.extend(label);
        }
        for (k, curve) in self.curves.iter().enumerate() {
            let key = self.key(k, curve);
            let points = LinePlot::points(&frame, curve);
            drawing.polyline(&points, key.stroke.clone(), Some(frame.area));
            if let Some(marker) = key.marker {
                for point in points.into_iter().filter(|point| frame.area.contains(*point)) {
                    let edge = Stroke::solid(Colour::WHITE, 0.5);
                    drawing.path(marker.outline(point, 3.0), Some(key.stroke.colour), Some(edge));
                }
            }
            for triangle in &curve.triangles {
                self.draw_triangle(&mut drawing, &frame, curve, *triangle)?;
            }
        }
        frame.draw(&mut drawing);
        if let Some((at, columns)) = legend_at {
            legend.draw(&mut drawing, at, columns);
        }
        let middle = frame.area.left + frame.area.width / 2.0;
        drawing.text(&self.title, TITLE_TEXT, [middle, GAP + TITLE_TEXT], Anchor::at(0.5, 0.0));
        Ok(drawing)
    }
}

impl LinePlot {
    fn draw_triangle(
        &self,
        drawing: &mut Drawing,
        frame: &Frame,
        curve: &Curve,
        triangle: SlopeTriangle,
    ) -> Result<(), PictureError> {
        let mut points: Vec<Point> = curve.x.iter().zip(&curve.y).map(|(&x, &y)| [x, y]).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        // Long enough to be read, if the curve is.
        let along = |point: &Point| frame.place(*point)[0] - frame.place(points[0])[0];
        let second = points.iter().find(|point| along(point) >= 40.0).or(points.last()).copied();
        let [[x0, y0], [x1, y1]] = match (points[0], second) {
            (first, Some(second)) if first[0] < second[0] && self.scales == [Scale::Logarithmic; 2] => {
                [first, second]
            }
            _ => {
                let picture =
                    format!("the slope triangle of \"{}\" (two points, logarithmic axes)", curve.name);
                return Err(PictureError::Empty { picture });
            }
        };
        let ratio = x1 / x0;
        let (left, right) = (x0 * ratio.powf(0.2), x0 * ratio.powf(0.8));
        let on_curve = |x: f64| y0 * (y1 / y0).powf((x / x0).ln() / ratio.ln());
        // The hypotenuse keeps a distance from the curve at both of its ends.
        let side = if triangle.above { -1.0 } else { 1.0 };
        let slope = |x: f64| (x / left).powf(triangle.order);
        let factor = [left, right].map(|x| on_curve(x) / slope(x));
        let factor = if triangle.above { factor[0].max(factor[1]) } else { factor[0].min(factor[1]) };
        let shift = |[x, y]: Point| [x, y + side * 9.0];
        let start = shift(frame.place([left, factor]));
        let end = shift(frame.place([right, factor * slope(right)]));
        // The right angle lies on the side away from the curve.
        let corner_right = (triangle.order > 0.0) != triangle.above;
        let corner = if corner_right { [end[0], start[1]] } else { [start[0], end[1]] };
        let mut segments = polyline(&[start, corner, end]);
        segments.push(Segment::Close);
        drawing.path(segments, Some(Colour::grey(235)), Some(Stroke::solid(Colour::grey(60), AXIS_LINE)));
        let middle = [(start[0] + end[0]) / 2.0, (start[1] + end[1]) / 2.0];
        let above = if triangle.above { 0.0 } else { 1.0 };
        drawing.text("1", TICK_TEXT, [middle[0], corner[1] + side * 3.0], Anchor::at(0.5, above));
        let order = triangle.order.abs();
        let decimals = (0..3).find(|&d| (order * 10_f64.powi(d)).fract().abs() < 1e-9).unwrap_or(2) as usize;
        let (offset, along) = if corner_right { (3.0, 0.0) } else { (-3.0, 1.0) };
        let text = number(order, decimals);
        drawing.text(&text, TICK_TEXT, [corner[0] + offset, middle[1]], Anchor::at(along, 0.5));
        Ok(())
    }
}

/// The ends of a vertical (k = 0) or horizontal (k = 1) line through the frame.
fn reference_line(frame: &Frame, k: usize, value: f64) -> [Point; 2] {
    frame.axes()[1 - k].range.map(|end| frame.place(if k == 0 { [value, end] } else { [end, value] }))
}

/// Draws a line across the frame, with its label where nothing passes if there is such a place, and
/// returns the diagonal of the label.
fn draw_reference(
    drawing: &mut Drawing,
    frame: &Frame,
    (k, value): (usize, f64),
    label: &str,
    taken: &[Vec<Point>],
) -> Option<Vec<Point>> {
    let [start, end] = reference_line(frame, k, value);
    if !frame.area.contains(start) {
        return None;
    }
    drawing.polyline(&[start, end], Stroke::dashed(Colour::grey(90), 0.9, &[1.5, 2.0]), None);
    let (width, height) = (drawing.text_width(label, TICK_TEXT), TICK_TEXT * CAPITAL_HEIGHT);
    let (near, far) = (3.0, 2.0 * GAP);
    let Rectangle { left, top, .. } = frame.area;
    let (right, bottom) = (frame.area.right(), frame.area.bottom());
    // Upper left points of the label's box: next to a vertical line, above or below a horizontal one.
    let part = |k: u32| f64::from(k) / 10.0;
    let places: Vec<Point> = if k == 0 {
        let room = bottom - top - 2.0 * far - height;
        let heights = (0..=10).map(|k| top + far + part(k) * room);
        heights.flat_map(|y| [[start[0] + near, y], [start[0] - near - width, y]]).collect()
    } else {
        let room = right - left - 2.0 * far - width;
        let starts = (0..=10).map(|k| right - far - width - part(k) * room);
        starts.flat_map(|x| [[x, start[1] - near - height], [x, start[1] + near]]).collect()
    };
    let free = |at: &&Point| {
        let room = Rectangle {
            left: at[0] - near,
            top: at[1] - near,
            width: width + 2.0 * near,
            height: height + 2.0 * near,
        };
        let inside = frame.area.contains(**at) && frame.area.contains([at[0] + width, at[1] + height]);
        inside && !taken.iter().any(|curve| passes(curve, &room))
    };
    let at = places.iter().find(free).unwrap_or(&places[0]);
    drawing.text(label, TICK_TEXT, *at, Anchor::at(0.0, 1.0));
    Some(vec![*at, [at[0] + width, at[1] + height]])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn convergence() -> LinePlot {
        let h = [0.4, 0.2, 0.1, 0.05];
        let squared = h.map(|h| 0.3 * h * h);
        LinePlot::new()
            .x_axis("h [mm]", Scale::Logarithmic)
            .y_axis("error", Scale::Logarithmic)
            .curve(Curve::new("k = 2", &h, &squared).fitted_order(4).slope_triangle(2.0))
    }

    /// y = 0.3 x² has order 2.
    #[test]
    fn fitted_order_is_the_exponent() {
        assert_eq!(convergence().keys()[0].text, "k = 2, order 2.00");
    }

    #[test]
    fn bad_data_are_named() {
        let plot = LinePlot::new().curve(Curve::new("pressure", &[0.0, 1.0], &[1.0, f64::NAN]));
        assert!(plot.draw().err().unwrap().to_string().contains("value 1 of \"pressure\" is NaN"));
        let plot = LinePlot::new().curve(Curve::new("pressure", &[0.0, 1.0], &[1.0]));
        assert!(matches!(plot.draw(), Err(PictureError::Length { expected: 2, found: 1, .. })));
        let plot = convergence().curve(Curve::new("k = 1", &[0.1], &[0.0]));
        assert!(matches!(plot.draw(), Err(PictureError::NotPositive { .. })));
        assert!(matches!(LinePlot::new().draw(), Err(PictureError::Empty { .. })));
        assert!(convergence().size(f64::NAN, 3.0).draw().is_err());
    }
}
