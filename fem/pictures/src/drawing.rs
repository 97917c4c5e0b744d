//! A drawing: paths, shaded surfaces and text on a white page, independent of the file format.

use ttf_parser::Face;

use super::PictureError;
use super::colour_map::Colour;
use super::path::{Point, Rectangle, Segment};
use super::shading::ShadedSurface;
use super::text::{self, Anchor};

/// Style of a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    pub colour: Colour,
    /// Width \[pt\].
    pub width: f64,
    /// Lengths of dashes and of the gaps between them \[pt\]; empty for a solid line.
    pub dashes: Vec<f64>,
}

impl Stroke {
    pub fn solid(colour: Colour, width: f64) -> Stroke {
        Stroke { colour, width, dashes: Vec::new() }
    }

    pub fn dashed(colour: Colour, width: f64, dashes: &[f64]) -> Stroke {
        Stroke { colour, width, dashes: dashes.to_vec() }
    }
}

/// Elements of a drawing.
#[derive(Clone, Debug)]
pub enum Item {
    Path { segments: Vec<Segment>, fill: Option<Colour>, stroke: Option<Stroke>, clip: Option<Rectangle> },
    Surface { surface: ShadedSurface, clip: Option<Rectangle> },
}

/// A picture, ready to be written in any format. Lengths are in points, 1/72 inch.
#[derive(Clone)]
pub struct Drawing {
    pub(super) size: [f64; 2],
    pub(super) items: Vec<Item>,
    typeface: Face<'static>,
}

impl Drawing {
    /// The things drawn, from the bottom to the top.
    #[doc(hidden)]
    pub fn items(&self) -> &[Item] {
        &self.items
    }

    /// An empty page of a size \[pt\].
    ///
    /// # Errors
    /// [`PictureError::Size`], and a typeface that cannot be read.
    #[doc(hidden)]
    pub fn new(size: [f64; 2]) -> Result<Drawing, PictureError> {
        if !size.iter().all(|&length| length.is_finite() && (1.0..=20_000.0).contains(&length)) {
            return Err(PictureError::Size { width: size[0], height: size[1] });
        }
        Ok(Drawing { size, items: Vec::new(), typeface: text::typeface()? })
    }

    /// Width and height \[pt\].
    pub fn size(&self) -> [f64; 2] {
        self.size
    }

    /// Drawing of a path.
    #[doc(hidden)]
    pub fn path(&mut self, segments: Vec<Segment>, fill: Option<Colour>, stroke: Option<Stroke>) {
        self.clipped_path(segments, fill, stroke, None);
    }

    /// Drawing of the part of a path inside a rectangle.
    #[doc(hidden)]
    pub fn clipped_path(
        &mut self,
        segments: Vec<Segment>,
        fill: Option<Colour>,
        stroke: Option<Stroke>,
        clip: Option<Rectangle>,
    ) {
        if !segments.is_empty() {
            self.items.push(Item::Path { segments, fill, stroke, clip });
        }
    }

    /// Drawing of an open polyline; nothing with a stroke of no width.
    #[doc(hidden)]
    pub fn polyline(&mut self, points: &[Point], stroke: Stroke, clip: Option<Rectangle>) {
        if stroke.width > 0.0 {
            self.clipped_path(polyline(points), None, Some(stroke), clip);
        }
    }

    /// Drawing of a rectangle.
    #[doc(hidden)]
    pub fn rectangle(&mut self, area: Rectangle, fill: Option<Colour>, stroke: Option<Stroke>) {
        let corners = [
            [area.left, area.top],
            [area.right(), area.top],
            [area.right(), area.bottom()],
            [area.left, area.bottom()],
        ];
        let mut segments = polyline(&corners);
        segments.push(Segment::Close);
        self.path(segments, fill, stroke);
    }

    /// Drawing of a surface shaded by values.
    #[doc(hidden)]
    pub fn surface(&mut self, surface: ShadedSurface, clip: Option<Rectangle>) {
        self.items.push(Item::Surface { surface, clip });
    }

    /// Writes a line of text at a point and returns its width \[pt\].
    pub(crate) fn text(&mut self, content: &str, size: f64, at: Point, anchor: Anchor) -> f64 {
        let line = text::outline(&self.typeface, content, size);
        let shift = anchor.shift(line.width, size);
        let segments = line
            .segments
            .into_iter()
            .map(|segment| {
                segment.map(|[x, y]| {
                    let (x, y) = (x + shift[0], y + shift[1]);
                    if anchor.upwards { [at[0] + y, at[1] - x] } else { [at[0] + x, at[1] + y] }
                })
            })
            .collect();
        self.path(segments, Some(Colour::BLACK), None);
        line.width
    }

    /// Width of a line of text \[pt\].
    pub(crate) fn text_width(&self, content: &str, size: f64) -> f64 {
        text::outline(&self.typeface, content, size).width
    }

    /// Puts another drawing onto this one.
    pub(crate) fn place(&mut self, other: Drawing, at: Point) {
        let moved = |[x, y]: Point| [x + at[0], y + at[1]];
        self.items.extend(other.items.into_iter().map(|item| match item {
            Item::Path { segments, fill, stroke, clip } => Item::Path {
                segments: segments.into_iter().map(|segment| segment.map(moved)).collect(),
                fill,
                stroke,
                clip: clip.map(|area| area.moved(at)),
            },
            Item::Surface { mut surface, clip } => {
                surface.origin = moved(surface.origin);
                Item::Surface { surface, clip: clip.map(|area| area.moved(at)) }
            }
        }));
    }
}

/// The segments of an open polyline.
pub fn polyline(points: &[Point]) -> Vec<Segment> {
    let mut segments = Vec::with_capacity(points.len() + 1);
    for (k, &point) in points.iter().enumerate() {
        segments.push(if k == 0 { Segment::Move(point) } else { Segment::Line(point) });
    }
    segments
}
