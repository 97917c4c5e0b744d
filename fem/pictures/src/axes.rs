//! Axes: ticks at round numbers, their labels, and the frame they are drawn on.

use super::PictureError;
use super::colour_map::Colour;
use super::drawing::{Drawing, Stroke, polyline};
use super::path::{Point, Rectangle};
use super::text::{Anchor, CAPITAL_HEIGHT};

/// Font size of tick labels \[pt\].
pub const TICK_TEXT: f64 = 8.5;
/// Font size of axis labels and legends \[pt\].
pub const LABEL_TEXT: f64 = 9.5;
/// Font size of titles \[pt\].
pub const TITLE_TEXT: f64 = 11.0;
/// Length of a tick \[pt\].
pub const TICK: f64 = 3.5;
/// Width of axis lines \[pt\].
pub const AXIS_LINE: f64 = 0.7;
/// Distance between neighbouring things \[pt\].
pub const GAP: f64 = 4.0;

/// Scales of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Scale {
    /// Even steps for even differences.
    #[default]
    Linear,
    /// Even steps for even ratios; values must be positive.
    Logarithmic,
}

/// An axis with the values at its ends.
#[derive(Clone, Debug)]
pub struct Axis {
    pub label: String,
    pub scale: Scale,
    pub range: [f64; 2],
}

/// The marks of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Ticks {
    pub major: Vec<(f64, String)>,
    pub minor: Vec<f64>,
    /// The labels are to be multiplied by this power of ten.
    pub exponent: i32,
}

impl Axis {
    /// Axis of a range that can be drawn.
    ///
    /// # Errors
    /// [`PictureError::Range`]: a range that is empty or not finite, or not positive on a logarithmic axis.
    pub fn new(label: &str, scale: Scale, range: [f64; 2]) -> Result<Axis, PictureError> {
        let [low, high] = range;
        let usable = low.is_finite() && high.is_finite() && low < high && high - low > 1e-12 * high.abs();
        if !usable || (scale == Scale::Logarithmic && low <= 0.0) {
            return Err(PictureError::Range { name: label.into(), low, high });
        }
        Ok(Axis { label: label.into(), scale, range })
    }

    /// The place of a value: 0 at the lower end, 1 at the upper end.
    pub fn fraction(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        match self.scale {
            Scale::Linear => (value - low) / (high - low),
            Scale::Logarithmic => (value / low).ln() / (high / low).ln(),
        }
    }

    /// Ticks for about `count` labels.
    pub fn ticks(&self, count: usize) -> Ticks {
        match self.scale {
            Scale::Linear => linear_ticks(self.range, count.max(2)),
            Scale::Logarithmic => logarithmic_ticks(self.range, count.max(2)),
        }
    }
}

fn linear_ticks([low, high]: [f64; 2], count: usize) -> Ticks {
    let rough = (high - low) / count as f64;
    let power = 10_f64.powf(rough.log10().floor());
    let (step, parts) = [(1.0, 5), (2.0, 4), (2.5, 5), (5.0, 5), (10.0, 5)]
        .into_iter()
        .map(|(factor, parts)| (factor * power, parts))
        .find(|(step, _)| *step >= rough * 0.999)
        .unwrap_or((10.0 * power, 5));
    let slack = 1e-9 * (high - low);
    let multiples = |step: f64| -> Vec<f64> {
        let first = ((low - slack) / step).ceil() as i64;
        let last = ((high + slack) / step).floor() as i64;
        (first..=last).map(|k| k as f64 * step).collect()
    };
    let largest = low.abs().max(high.abs());
    let exponent = if (1e-2..1e5).contains(&largest) { 0 } else { largest.log10().floor() as i32 };
    let unit = 10_f64.powi(exponent);
    let decimals = (0..12).find(|&decimals| {
        let scaled = step / unit * 10_f64.powi(decimals);
        (scaled - scaled.round()).abs() < 1e-6 * scaled
    });
    let decimals = decimals.unwrap_or(12) as usize;
    Ticks {
        major: multiples(step).into_iter().map(|value| (value, number(value / unit, decimals))).collect(),
        minor: multiples(step / f64::from(parts)),
        exponent,
    }
}

/// A number with a true minus sign, and no minus before a zero.
pub fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let digits = text.trim_start_matches('-');
    let zero = digits.chars().all(|digit| digit == '0' || digit == '.');
    if text.starts_with('-') && !zero { format!("−{digits}") } else { digits.into() }
}

fn logarithmic_ticks([low, high]: [f64; 2], count: usize) -> Ticks {
    let (low, high) = (low * (1.0 - 1e-9), high * (1.0 + 1e-9));
    let decades = (low.log10().floor() as i32)..=(high.log10().ceil() as i32);
    let within = |factors: &[i32], every: i32| -> Vec<(i32, i32)> {
        decades
            .clone()
            .filter(|power| power.rem_euclid(every) == 0)
            .flat_map(|power| factors.iter().map(move |&factor| (factor, power)))
            .filter(|&(factor, power)| (low..=high).contains(&(f64::from(factor) * 10_f64.powi(power))))
            .collect()
    };
    // The densest set of labels that stays within the count.
    let choices: [(&[i32], i32); 8] = [
        (&[1, 2, 3, 4, 5, 6, 7, 8, 9], 1),
        (&[1, 2, 3, 5, 7], 1),
        (&[1, 2, 5], 1),
        (&[1, 3], 1),
        (&[1], 1),
        (&[1], 2),
        (&[1], 5),
        (&[1], 10),
    ];
    let labelled = choices.iter().map(|(factors, every)| within(factors, *every));
    let labelled = labelled.into_iter().find(|labels| labels.len() <= count).unwrap_or_default();
    let value = |(factor, power): (i32, i32)| f64::from(factor) * 10_f64.powi(power);
    let plain = labelled.iter().any(|&(factor, _)| factor != 1)
        && labelled.iter().all(|&(_, power)| (-2..=3).contains(&power));
    let label = |(factor, power): (i32, i32)| {
        if plain {
            number(value((factor, power)), usize::try_from(-power).unwrap_or(0))
        } else {
            let exponent = number(f64::from(power), 0);
            if factor == 1 { format!("10^{{{exponent}}}") } else { format!("{factor}·10^{{{exponent}}}") }
        }
    };
    Ticks {
        major: labelled.iter().map(|&mark| (value(mark), label(mark))).collect(),
        minor: within(&[1, 2, 3, 4, 5, 6, 7, 8, 9], 1).into_iter().map(value).collect(),
        exponent: 0,
    }
}

/// `×10^n`, or nothing if the labels need none.
pub fn multiplier(exponent: i32) -> Option<String> {
    (exponent != 0).then(|| format!("×10^{{{}}}", number(f64::from(exponent), 0)))
}

/// A rectangle of the page with a horizontal and a vertical axis.
#[derive(Clone, Debug)]
pub struct Frame {
    pub area: Rectangle,
    pub x: Axis,
    pub y: Axis,
}

impl Frame {
    /// The point of the page where a pair of values lies.
    pub fn place(&self, [x, y]: [f64; 2]) -> Point {
        [
            self.area.left + self.x.fraction(x) * self.area.width,
            self.area.bottom() - self.y.fraction(y) * self.area.height,
        ]
    }

    /// The horizontal and the vertical axis.
    pub fn axes(&self) -> [&Axis; 2] {
        [&self.x, &self.y]
    }

    /// Whether a power of ten is drawn above the vertical axis.
    pub fn has_vertical_exponent(&self) -> bool {
        self.y_ticks().exponent != 0
    }

    fn x_ticks(&self) -> Ticks {
        self.x.ticks(((self.area.width / 48.0) as usize).max(3))
    }

    fn y_ticks(&self) -> Ticks {
        self.y.ticks(((self.area.height / 32.0) as usize).max(3))
    }

    /// Faint lines at the labelled ticks.
    pub fn draw_grid(&self, drawing: &mut Drawing) {
        let stroke = Stroke::solid(Colour::grey(225), 0.5);
        for (value, _) in self.x_ticks().major {
            let x = self.place([value, self.y.range[0]])[0];
            drawing.polyline(&[[x, self.area.top], [x, self.area.bottom()]], stroke.clone(), None);
        }
        for (value, _) in self.y_ticks().major {
            let y = self.place([self.x.range[0], value])[1];
            drawing.polyline(&[[self.area.left, y], [self.area.right(), y]], stroke.clone(), None);
        }
    }

    /// Drawing of the box, the ticks and the labels.
    pub fn draw(&self, drawing: &mut Drawing) {
        let stroke = Stroke::solid(Colour::BLACK, AXIS_LINE);
        let Rectangle { left, top, .. } = self.area;
        let (right, bottom) = (self.area.right(), self.area.bottom());
        let mut marks = Vec::new();
        let x_ticks = self.x_ticks();
        let all = x_ticks.minor.iter().map(|&value| (value, 0.55));
        for (value, length) in all.chain(x_ticks.major.iter().map(|(value, _)| (*value, 1.0))) {
            let x = self.place([value, self.y.range[0]])[0];
            marks.extend(polyline(&[[x, bottom], [x, bottom - length * TICK]]));
        }
        let y_ticks = self.y_ticks();
        let all = y_ticks.minor.iter().map(|&value| (value, 0.55));
        for (value, length) in all.chain(y_ticks.major.iter().map(|(value, _)| (*value, 1.0))) {
            let y = self.place([self.x.range[0], value])[1];
            marks.extend(polyline(&[[left, y], [left + length * TICK, y]]));
        }
        drawing.path(marks, None, Some(stroke.clone()));
        drawing.rectangle(self.area, None, Some(stroke));
        let below = bottom + GAP;
        for (value, label) in &x_ticks.major {
            let x = self.place([*value, self.y.range[0]])[0];
            drawing.text(label, TICK_TEXT, [x, below], Anchor::at(0.5, 1.0));
        }
        let mut widest: f64 = 0.0;
        for (value, label) in &y_ticks.major {
            let y = self.place([self.x.range[0], *value])[1];
            widest = widest.max(drawing.text(label, TICK_TEXT, [left - GAP, y], Anchor::at(1.0, 0.5)));
        }
        if let Some(text) = multiplier(x_ticks.exponent) {
            let under = below + TICK_TEXT * CAPITAL_HEIGHT + GAP + LABEL_TEXT * CAPITAL_HEIGHT;
            drawing.text(&text, TICK_TEXT, [right, under], Anchor::at(1.0, 0.0));
        }
        if let Some(text) = multiplier(y_ticks.exponent) {
            drawing.text(&text, TICK_TEXT, [left, top - GAP], Anchor::at(0.0, 0.0));
        }
        let centre = [(left + right) / 2.0, (top + bottom) / 2.0];
        let under = below + TICK_TEXT * CAPITAL_HEIGHT + 1.5 * GAP;
        drawing.text(&self.x.label, LABEL_TEXT, [centre[0], under], Anchor::at(0.5, 1.0));
        let beside = left - GAP - widest - 1.5 * GAP;
        let upwards = Anchor { along: 0.5, above: 0.0, upwards: true };
        drawing.text(&self.y.label, LABEL_TEXT, [beside, centre[1]], upwards);
    }

    /// Room that the labels take to the left of and below the area \[pt\].
    pub fn margins(&self, drawing: &Drawing) -> [f64; 2] {
        let widths = self.y_ticks().major.into_iter().map(|(_, label)| drawing.text_width(&label, TICK_TEXT));
        let widest = widths.fold(0.0, f64::max);
        let room = |label: &str| if label.is_empty() { 0.0 } else { 1.5 * GAP + LABEL_TEXT };
        let exponent = if self.x_ticks().exponent == 0 { 0.0 } else { GAP };
        let below = TICK_TEXT * CAPITAL_HEIGHT + GAP + room(&self.x.label).max(exponent);
        [widest + GAP + room(&self.y.label), below]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ticks: &Ticks) -> Vec<&str> {
        ticks.major.iter().map(|(_, label)| label.as_str()).collect()
    }

    #[test]
    fn linear_ticks_are_round_numbers() {
        assert_eq!(labels(&linear_ticks([-0.3, 1.02], 5)), ["0.0", "0.5", "1.0"]);
        assert_eq!(labels(&linear_ticks([-30.0, 30.0], 6)), ["−30", "−20", "−10", "0", "10", "20", "30"]);
        let small = linear_ticks([0.0, 0.0042], 4);
        assert_eq!((labels(&small), small.exponent), (vec!["0", "2", "4"], -3));
    }

    #[test]
    fn logarithmic_ticks_are_decades_or_their_parts() {
        assert_eq!(labels(&logarithmic_ticks([1e-6, 1e-1], 6)).len(), 6);
        assert_eq!(labels(&logarithmic_ticks([1e-6, 1e-1], 6))[0], "10^{−6}");
        assert_eq!(labels(&logarithmic_ticks([0.15, 3.0], 5)), ["0.2", "0.5", "1", "2"]);
    }

    #[test]
    fn fractions_follow_the_scale() {
        let axis = Axis::new("h", Scale::Logarithmic, [1e-4, 1.0]).unwrap();
        assert!((axis.fraction(1e-2) - 0.5).abs() < 1e-12);
        assert!(Axis::new("h", Scale::Logarithmic, [0.0, 1.0]).is_err());
        assert!(Axis::new("h", Scale::Linear, [1.0, 1.0]).is_err());
        assert!(Axis::new("h", Scale::Linear, [f64::NAN, 1.0]).is_err());
    }
}
