//! Bars of ratios on a logarithmic axis: how many times faster, larger, or more accurate.

use super::axes::{AXIS_LINE, Axis, GAP, LABEL_TEXT, Scale, TICK, TICK_TEXT, TITLE_TEXT};
use super::colour_map::Colour;
use super::drawing::{Drawing, Stroke};
use super::path::Rectangle;
use super::text::{Anchor, CAPITAL_HEIGHT};
use super::{Picture, PictureError};

/// Height of a bar with the gap above it \[pt\].
const ROW: f64 = 13.0;
/// Length of the axis \[pt\].
const AXIS: f64 = 320.0;

/// A picture of horizontal bars that start at 1 and end at a ratio, one under the other.
///
/// ```no_run
/// # mod forms_fem { pub mod output { pub use forms_pictures as picture; } }
/// use forms_fem::output::picture::{BarChart, Picture};
///
/// BarChart::new("times faster")
///     .bar("mass", 3.4)
///     .bar("stiffness", 9.1)
///     .line(2.0, "2×")
///     .write_png("ratios.png")?;
/// # Ok::<(), forms_fem::output::picture::PictureError>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct BarChart {
    title: String,
    label: String,
    bars: Vec<(String, f64)>,
    lines: Vec<(f64, String)>,
}

impl BarChart {
    /// A chart without bars; the label is under the axis.
    pub fn new(label: &str) -> BarChart {
        BarChart { label: label.into(), ..BarChart::default() }
    }

    /// Title above the chart.
    pub fn title(mut self, title: &str) -> BarChart {
        self.title = title.into();
        self
    }

    /// One more bar, under those before; its ratio must be positive.
    pub fn bar(mut self, name: &str, ratio: f64) -> BarChart {
        self.bars.push((name.into(), ratio));
        self
    }

    /// Dotted vertical line with a label at its top.
    pub fn line(mut self, ratio: f64, label: &str) -> BarChart {
        self.lines.push((ratio, label.into()));
        self
    }

    fn check(&self) -> Result<[f64; 2], PictureError> {
        if self.bars.is_empty() {
            return Err(PictureError::Empty { picture: format!("the chart \"{}\"", self.title) });
        }
        let (mut low, mut high) = (1.0_f64, 1.0_f64);
        for (index, (name, value)) in self.bars.iter().map(|(name, ratio)| (name, *ratio)).enumerate() {
            if !value.is_finite() {
                return Err(PictureError::NotFinite { name: name.clone(), index, value });
            }
            if value <= 0.0 {
                return Err(PictureError::NotPositive { name: name.clone(), index, value });
            }
            (low, high) = (low.min(value), high.max(value));
        }
        for (ratio, _) in self.lines.iter().filter(|(ratio, _)| ratio.is_finite() && *ratio > 0.0) {
            (low, high) = (low.min(*ratio), high.max(*ratio));
        }
        // Room for the numbers at the ends of the bars.
        let room = (high / low).max(2.0).powf(0.12);
        Ok([if low < 1.0 { low / room } else { low }, high * room])
    }
}

impl Picture for BarChart {
    fn draw(&self) -> Result<Drawing, PictureError> {
        let axis = Axis::new(&self.label, Scale::Logarithmic, self.check()?)?;
        let probe = Drawing::new([100.0, 100.0])?;
        let names = self.bars.iter().map(|(name, _)| probe.text_width(name, TICK_TEXT));
        let left = names.fold(0.0, f64::max) + 3.0 * GAP;
        let title = if self.title.is_empty() { 0.0 } else { TITLE_TEXT + 2.0 * GAP };
        let top = title + TICK_TEXT + 2.0 * GAP;
        let area = Rectangle { left, top, width: AXIS, height: ROW * self.bars.len() as f64 + GAP };
        let below = TICK_TEXT + LABEL_TEXT + 5.0 * GAP;
        let width = area.right() + 4.0 * GAP;
        let mut drawing = Drawing::new([width, area.bottom() + below])?;
        let place = |ratio: f64| area.left + axis.fraction(ratio) * area.width;
        let ticks = axis.ticks((AXIS / 48.0) as usize);
        for (value, label) in &ticks.major {
            let x = place(*value);
            let faint = Stroke::solid(Colour::grey(225), 0.5);
            drawing.polyline(&[[x, area.top], [x, area.bottom()]], faint, None);
            let mark = Stroke::solid(Colour::BLACK, AXIS_LINE);
            drawing.polyline(&[[x, area.bottom()], [x, area.bottom() - TICK]], mark, None);
            drawing.text(label, TICK_TEXT, [x, area.bottom() + GAP], Anchor::at(0.5, 1.0));
        }
        let start = place(1.0);
        for (row, (name, ratio)) in self.bars.iter().enumerate() {
            let middle = area.top + GAP / 2.0 + ROW * (row as f64 + 0.5);
            let end = place(*ratio);
            let bar = Rectangle {
                left: start.min(end),
                top: middle - 0.36 * ROW,
                width: (end - start).abs(),
                height: 0.72 * ROW,
            };
            drawing.rectangle(bar, Some(Colour::of_series(usize::from(*ratio < 1.0))), None);
            drawing.text(name, TICK_TEXT, [area.left - GAP, middle], Anchor::at(1.0, 0.5));
        }
        for (ratio, label) in self.lines.iter().filter(|(ratio, _)| ratio.is_finite() && *ratio > 0.0) {
            let x = place(*ratio);
            let dotted = Stroke::dashed(Colour::BLACK, 0.9, &[1.5, 2.0]);
            drawing.polyline(&[[x, area.top], [x, area.bottom()]], dotted, None);
            drawing.text(label, TICK_TEXT, [x, area.top - GAP], Anchor::at(0.5, 0.0));
        }
        // Above the lines, which would cross them.
        for (row, (_, ratio)) in self.bars.iter().enumerate() {
            let beside =
                [start.max(place(*ratio)) + GAP / 2.0, area.top + GAP / 2.0 + ROW * (row as f64 + 0.5)];
            let (number, size) = (significant(*ratio), TICK_TEXT - 1.0);
            let ground = Rectangle {
                left: beside[0],
                top: beside[1] - 0.45 * size,
                width: drawing.text_width(&number, size),
                height: 0.9 * size,
            };
            drawing.rectangle(ground, Some(Colour::grey(255)), None);
            drawing.text(&number, size, beside, Anchor::at(0.0, 0.5));
        }
        drawing.rectangle(area, None, Some(Stroke::solid(Colour::BLACK, AXIS_LINE)));
        let under = area.bottom() + 2.5 * GAP + TICK_TEXT * CAPITAL_HEIGHT;
        drawing.text(&self.label, LABEL_TEXT, [area.left + 0.5 * AXIS, under], Anchor::at(0.5, 1.0));
        drawing.text(&self.title, TITLE_TEXT, [width / 2.0, GAP + TITLE_TEXT], Anchor::at(0.5, 0.0));
        Ok(drawing)
    }
}

// Two or three significant figures.
fn significant(ratio: f64) -> String {
    match ratio {
        ratio if ratio >= 100.0 => format!("{ratio:.0}"),
        ratio if ratio >= 10.0 => format!("{ratio:.1}"),
        _ => format!("{ratio:.2}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_must_be_positive_numbers() {
        assert!(matches!(BarChart::new("times").draw(), Err(PictureError::Empty { .. })));
        let chart = BarChart::new("times").bar("good", 3.0);
        assert!(chart.draw().is_ok());
        assert!(matches!(
            chart.clone().bar("none", 0.0).draw(),
            Err(PictureError::NotPositive { index: 1, .. })
        ));
        assert!(matches!(chart.bar("bad", f64::NAN).draw(), Err(PictureError::NotFinite { index: 1, .. })));
    }

    #[test]
    fn the_axis_holds_bars_and_lines() {
        let range = BarChart::new("times").bar("slow", 0.5).bar("fast", 8.0).line(20.0, "").check().unwrap();
        assert!(range[0] < 0.5 && range[1] > 20.0);
        assert_eq!([0.123, 4.567, 45.67, 456.7].map(significant), ["0.12", "4.57", "45.7", "457"]);
    }
}
