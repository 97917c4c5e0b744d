//! The layout that pictures of bodies share: title, axes of equal scale, colour bar, legend.

use super::PictureError;
use super::axes::{AXIS_LINE, Axis, Frame, GAP, LABEL_TEXT, Scale, TICK, TICK_TEXT, TITLE_TEXT, multiplier};
use super::colour_map::Colour;
use super::drawing::{Drawing, Stroke, polyline};
use super::legend::Legend;
use super::path::{Point, Rectangle};
use super::shading::{ShadedSurface, Shading};
use super::text::{Anchor, CAPITAL_HEIGHT};

/// Width of a colour bar \[pt\].
const BAR: f64 = 12.0;
/// Least height of a colour bar \[pt\].
const BAR_HEIGHT: f64 = 90.0;

/// The surroundings of a body on its page.
pub struct Layout<'a> {
    pub title: &'a str,
    /// Unit of length, for the labels of the axes; no axes without it.
    pub unit: Option<&'a str>,
    /// Names of the horizontal and the vertical coordinate.
    pub axes: [&'a str; 2],
    /// Largest width and height of the body's area \[pt\].
    pub largest: [f64; 2],
    /// Lower left and upper right corner of what is shown.
    pub window: [[f64; 2]; 2],
    /// Shading and label of the colour bar.
    pub bar: Option<(Shading, String)>,
    pub legend: Legend,
}

impl Layout<'_> {
    /// The page and the frame for the body.
    ///
    /// # Errors
    /// [`PictureError`]: a range or a size that cannot be drawn.
    pub fn begin(&self) -> Result<(Drawing, Frame), PictureError> {
        let [low, high] = self.window;
        let label = |name: &str| match self.unit {
            None => String::new(),
            Some("") => name.to_owned(),
            Some(unit) => format!("{name} [{unit}]"),
        };
        let x = Axis::new(&label(self.axes[0]), Scale::Linear, [low[0], high[0]])?;
        let y = Axis::new(&label(self.axes[1]), Scale::Linear, [low[1], high[1]])?;
        let scale = (self.largest[0] / (high[0] - low[0])).min(self.largest[1] / (high[1] - low[1]));
        let (width, height) = (scale * (high[0] - low[0]), scale * (high[1] - low[1]));
        let mut frame = Frame { area: Rectangle { left: 0.0, top: 0.0, width, height }, x, y };
        let probe = Drawing::new([100.0, 100.0])?;
        let [left, below] = if self.unit.is_some() { frame.margins(&probe) } else { [0.0; 2] };
        let right =
            self.bar.as_ref().map_or(0.0, |(shading, label)| bar_width(&probe, shading, label, height));
        let title = if self.title.is_empty() { 0.0 } else { TITLE_TEXT + 2.0 * GAP };
        let bar_exponent = self.bar.as_ref().is_some_and(|(shading, label)| {
            bar_axis(shading, label).is_ok_and(|axis| axis.ticks(bar_ticks_count(height)).exponent != 0)
        });
        let has_exponent = bar_exponent || (self.unit.is_some() && frame.has_vertical_exponent());
        let exponent = if has_exponent { TICK_TEXT * CAPITAL_HEIGHT + GAP } else { 0.0 };
        let mut page_width = left + width + right + 3.0 * GAP;
        let columns = self.legend.columns(&probe, page_width - 2.0 * GAP);
        let [legend_width, legend_height] = self.legend.size(&probe, columns);
        page_width = page_width
            .max(legend_width + 2.0 * GAP)
            .max(probe.text_width(self.title, TITLE_TEXT) + 2.0 * GAP);
        let body_height = if self.bar.is_some() { height.max(BAR_HEIGHT) } else { height };
        let foot = if legend_height > 0.0 { legend_height + 2.0 * GAP } else { 0.0 };
        let top = title + exponent + 1.5 * GAP;
        let mut drawing = Drawing::new([page_width, top + body_height + below + foot + GAP])?;
        let spare = (page_width - (left + width + right + 3.0 * GAP)) / 2.0;
        frame.area.left = left + GAP + spare;
        frame.area.top = top + (body_height - height) / 2.0;
        let middle = frame.area.left + width / 2.0;
        let half = drawing.text_width(self.title, TITLE_TEXT) / 2.0;
        let centre = middle.clamp(half + GAP, (page_width - half - GAP).max(half + GAP));
        drawing.text(self.title, TITLE_TEXT, [centre, GAP + TITLE_TEXT], Anchor::at(0.5, 0.0));
        if let Some((shading, label)) = &self.bar {
            let bar_height = height.max(BAR_HEIGHT);
            let area =
                Rectangle { left: frame.area.right() + 3.0 * GAP, top, width: BAR, height: bar_height };
            draw_bar(&mut drawing, area, shading, label)?;
        }
        let foot_left =
            (frame.area.left + (width - legend_width) / 2.0).min(page_width - legend_width - GAP).max(GAP);
        let foot_top = drawing.size()[1] - legend_height - GAP;
        self.legend.draw(&mut drawing, [foot_left, foot_top], columns);
        Ok((drawing, frame))
    }

    /// The finished drawing, with the axes above the body.
    pub fn finish(&self, drawing: &mut Drawing, frame: &Frame) {
        if self.unit.is_some() {
            frame.draw(drawing);
        }
    }
}

/// Ticks of a colour bar of a height \[pt\].
fn bar_axis(shading: &Shading, label: &str) -> Result<Axis, PictureError> {
    Axis::new(label, Scale::Linear, shading.range)
}

fn bar_ticks_count(height: f64) -> usize {
    (height / 30.0) as usize
}

/// Room of a colour bar with its ticks and its label \[pt\].
fn bar_width(drawing: &Drawing, shading: &Shading, label: &str, height: f64) -> f64 {
    let Ok(axis) = bar_axis(shading, label) else { return 0.0 };
    let ticks = axis.ticks(bar_ticks_count(height.max(BAR_HEIGHT)));
    let widths = ticks.major.iter().map(|(_, text)| drawing.text_width(text, TICK_TEXT));
    let room = if label.is_empty() { 0.0 } else { 1.5 * GAP + LABEL_TEXT };
    3.0 * GAP + BAR + TICK + GAP + widths.fold(0.0, f64::max) + room
}

fn draw_bar(
    drawing: &mut Drawing,
    area: Rectangle,
    shading: &Shading,
    label: &str,
) -> Result<(), PictureError> {
    let axis = bar_axis(shading, label)?;
    let [low, high] = shading.range.map(|value| value as f32);
    let corners: Vec<Point> = vec![
        [area.left, area.bottom()],
        [area.right(), area.bottom()],
        [area.right(), area.top],
        [area.left, area.top],
    ];
    let values = vec![low, low, high, high];
    drawing.surface(ShadedSurface::new(corners, values, vec![[0, 1, 2], [0, 2, 3]], *shading), None);
    drawing.rectangle(area, None, Some(Stroke::solid(Colour::BLACK, AXIS_LINE)));
    let ticks = axis.ticks(bar_ticks_count(area.height));
    let (mut marks, mut widest) = (Vec::new(), 0.0_f64);
    for (value, text) in &ticks.major {
        let y = area.bottom() - axis.fraction(*value) * area.height;
        marks.extend(polyline(&[[area.right(), y], [area.right() + TICK, y]]));
        let at = [area.right() + TICK + GAP / 2.0, y];
        widest = widest.max(drawing.text(text, TICK_TEXT, at, Anchor::at(0.0, 0.5)));
    }
    drawing.path(marks, None, Some(Stroke::solid(Colour::BLACK, AXIS_LINE)));
    if let Some(text) = multiplier(ticks.exponent) {
        drawing.text(&text, TICK_TEXT, [area.left, area.top - GAP], Anchor::at(0.0, 0.0));
    }
    let beside = area.right() + TICK + GAP / 2.0 + widest + 1.5 * GAP;
    let upwards = Anchor { along: 0.5, above: 1.0, upwards: true };
    drawing.text(label, LABEL_TEXT, [beside, area.top + area.height / 2.0], upwards);
    Ok(())
}
