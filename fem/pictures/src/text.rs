//! Lines of text as outlines of the embedded font DejaVu Sans: no system font is needed.
//!
//! `_{…}` and `^{…}` set subscripts and superscripts, as in `σ_{n} [N mm^{-2}]`.

use ttf_parser::{Face, OutlineBuilder};

use super::PictureError;
use super::path::{Point, Segment};

/// The embedded font.
pub(super) fn typeface() -> Result<Face<'static>, PictureError> {
    Face::parse(dejavu::sans::regular(), 0).map_err(|error| PictureError::Font { reason: error.to_string() })
}

/// Which point of a line of text lies at the given place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Anchor {
    /// Horizontal anchor: 0 for the left end, 0.5 for the middle, 1 for the right end.
    pub along: f64,
    /// 0 for the base line, 0.5 for the middle of a capital letter, 1 for its top.
    pub above: f64,
    /// Whether the line runs from bottom to top.
    pub upwards: bool,
}

impl Anchor {
    /// Upright text held at a fraction of its width and of its height.
    pub const fn at(along: f64, above: f64) -> Anchor {
        Anchor { along, above, upwards: false }
    }

    /// The start of the text, seen from its anchor, in the text's own directions.
    pub fn shift(&self, width: f64, size: f64) -> Point {
        [-self.along * width, self.above * CAPITAL_HEIGHT * size]
    }
}

/// Height of a capital letter of the font, in units of the font size.
pub(super) const CAPITAL_HEIGHT: f64 = 0.729;

/// The outline of a line of text from the origin, y downwards.
pub(super) struct Line {
    pub segments: Vec<Segment>,
    pub width: f64,
}

/// Sets a line of text at a font size \[pt\].
pub(super) fn outline(face: &Face<'_>, content: &str, size: f64) -> Line {
    let mut line = Line { segments: Vec::new(), width: 0.0 };
    for (run, level) in runs(content) {
        let (scale, lift) = match level {
            Level::Base => (1.0, 0.0),
            Level::Subscript => (0.7, 0.16),
            Level::Superscript => (0.7, -0.36),
        };
        let scale = scale * size / f64::from(face.units_per_em());
        for character in run.chars() {
            let Some(glyph) = face.glyph_index(character).or_else(|| face.glyph_index('\u{fffd}')) else {
                continue;
            };
            let mut pen = Pen { segments: &mut line.segments, scale, origin: [line.width, lift * size] };
            face.outline_glyph(glyph, &mut pen);
            line.width += scale * f64::from(face.glyph_hor_advance(glyph).unwrap_or(0));
        }
    }
    line
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Level {
    Base,
    Subscript,
    Superscript,
}

/// Splits `a_{b}^{c}` into its runs. An opening without its closing brace is plain text.
fn runs(content: &str) -> Vec<(&str, Level)> {
    let mut runs = Vec::new();
    let mut rest = content;
    while !rest.is_empty() {
        let opening = rest
            .find("_{")
            .into_iter()
            .chain(rest.find("^{"))
            .min()
            .and_then(|start| rest[start..].find('}').map(|length| (start, start + length)));
        let Some((start, end)) = opening else {
            runs.push((rest, Level::Base));
            break;
        };
        let level = if rest[start..].starts_with('_') { Level::Subscript } else { Level::Superscript };
        if start > 0 {
            runs.push((&rest[..start], Level::Base));
        }
        runs.push((&rest[start + 2..end], level));
        rest = &rest[end + 1..];
    }
    runs
}

/// Collects the outline of a glyph.
struct Pen<'a> {
    segments: &'a mut Vec<Segment>,
    scale: f64,
    origin: Point,
}

impl Pen<'_> {
    fn point(&self, x: f32, y: f32) -> Point {
        [self.origin[0] + self.scale * f64::from(x), self.origin[1] - self.scale * f64::from(y)]
    }
}

impl OutlineBuilder for Pen<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        self.segments.push(Segment::Move(self.point(x, y)));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.segments.push(Segment::Line(self.point(x, y)));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.segments.push(Segment::Quadratic(self.point(x1, y1), self.point(x, y)));
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.segments.push(Segment::Cubic(self.point(x1, y1), self.point(x2, y2), self.point(x, y)));
    }

    fn close(&mut self) {
        self.segments.push(Segment::Close);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scripts_are_split() {
        assert_eq!(runs("σ_{n} x"), [("σ", Level::Base), ("n", Level::Subscript), (" x", Level::Base)]);
        assert_eq!(runs("10^{-3}"), [("10", Level::Base), ("-3", Level::Superscript)]);
        assert_eq!(runs("contact_zone"), [("contact_zone", Level::Base)]);
        assert_eq!(runs("open_{"), [("open_{", Level::Base)]);
    }

    /// The font states the advance widths of its glyphs: digits are 1303 of 2048 units wide.
    #[test]
    fn widths_are_those_of_the_font() {
        let face = typeface().unwrap();
        let line = outline(&face, "12", 10.0);
        assert!((line.width - 2.0 * 1303.0 / 2048.0 * 10.0).abs() < 1e-9);
        assert!(!line.segments.is_empty());
    }
}
