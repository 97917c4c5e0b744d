//! Legends: keys with their names, put where they hide no curve.

use super::axes::{AXIS_LINE, GAP, LABEL_TEXT};
use super::colour_map::Colour;
use super::curve::Marker;
use super::drawing::{Drawing, Stroke};
use super::path::{Point, Rectangle};
use super::text::Anchor;

/// Length of the line before a name \[pt\].
const SAMPLE: f64 = 24.0;
/// Distance of base lines \[pt\].
const LEADING: f64 = 14.0;
/// Font size \[pt\].
const TEXT: f64 = LABEL_TEXT - 0.5;

/// One entry of a legend.
#[derive(Clone, Debug)]
pub struct Key {
    pub text: String,
    pub stroke: Stroke,
    pub marker: Option<Marker>,
}

/// The entries, one below the other.
#[derive(Clone, Debug)]
pub struct Legend {
    keys: Vec<Key>,
}

impl Legend {
    pub fn new(keys: Vec<Key>) -> Legend {
        Legend { keys }
    }

    /// Width of an entry \[pt\].
    fn entry(&self, drawing: &Drawing) -> f64 {
        let widest = self.keys.iter().map(|key| drawing.text_width(&key.text, TEXT)).fold(0.0, f64::max);
        SAMPLE + 4.0 * GAP + widest
    }

    /// The number of columns that fit a width \[pt\].
    pub fn columns(&self, drawing: &Drawing, width: f64) -> usize {
        ((width / self.entry(drawing)) as usize).clamp(1, self.keys.len().max(1))
    }

    /// Width and height \[pt\] with a number of columns; zero without entries.
    pub fn size(&self, drawing: &Drawing, columns: usize) -> [f64; 2] {
        if self.keys.is_empty() {
            return [0.0; 2];
        }
        let rows = self.keys.len().div_ceil(columns);
        [self.entry(drawing) * columns as f64, LEADING * rows as f64 + GAP]
    }

    /// The upper left point for the legend inside an area, in a corner where no curve passes.
    pub fn corner(
        &self,
        area: &Rectangle,
        [width, height]: [f64; 2],
        curves: &[Vec<Point>],
    ) -> Option<Point> {
        let inset = 2.0 * GAP;
        let left = [area.left + inset, area.right() - inset - width];
        let top = [area.top + inset, area.bottom() - inset - height];
        if left[1] < left[0] || top[1] < top[0] {
            return None;
        }
        let corners = [[left[1], top[0]], [left[0], top[0]], [left[1], top[1]], [left[0], top[1]]];
        corners.into_iter().find(|corner| {
            let room = Rectangle {
                left: corner[0] - GAP,
                top: corner[1] - GAP,
                width: width + 2.0 * GAP,
                height: height + 2.0 * GAP,
            };
            !curves.iter().any(|curve| passes(curve, &room))
        })
    }

    /// Drawing of the legend with its upper left corner at a point, in a number of columns.
    pub fn draw(&self, drawing: &mut Drawing, at: Point, columns: usize) {
        if self.keys.is_empty() {
            return;
        }
        let [width, height] = self.size(drawing, columns);
        let area = Rectangle { left: at[0], top: at[1], width, height };
        let edge = Stroke::solid(Colour::grey(180), AXIS_LINE);
        drawing.rectangle(area, Some(Colour::WHITE.with_opacity(0.9)), Some(edge));
        let entry = self.entry(drawing);
        for (k, key) in self.keys.iter().enumerate() {
            let y = at[1] + GAP / 2.0 + LEADING * ((k / columns) as f64 + 0.5);
            let x = at[0] + GAP + entry * (k % columns) as f64;
            drawing.polyline(&[[x, y], [x + SAMPLE, y]], key.stroke.clone(), None);
            if let Some(marker) = key.marker {
                let edge = Stroke::solid(Colour::WHITE, 0.5);
                let outline = marker.outline([x + SAMPLE / 2.0, y], 3.0);
                drawing.path(outline, Some(key.stroke.colour), Some(edge));
            }
            drawing.text(&key.text, TEXT, [x + SAMPLE + 1.5 * GAP, y], Anchor::at(0.0, 0.5));
        }
    }
}

/// True if a polyline passes through a rectangle, tested every two points of length.
pub fn passes(curve: &[Point], room: &Rectangle) -> bool {
    let alone = curve.len() == 1 && room.contains(curve[0]);
    alone
        || curve.windows(2).any(|pair| {
            let [a, b] = [pair[0], pair[1]];
            let length = (b[0] - a[0]).hypot(b[1] - a[1]);
            let steps = (length / 2.0).ceil().clamp(1.0, 5000.0) as usize;
            (0..=steps).any(|k| {
                let t = k as f64 / steps as f64;
                room.contains([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])])
            })
        })
}
