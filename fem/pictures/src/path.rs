//! Points, rectangles and pieces of paths of a page.

/// A point of the page \[pt\], x to the right and y downwards.
pub type Point = [f64; 2];

/// An upright rectangle of the page \[pt\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    pub left: f64,
    pub top: f64,
    pub width: f64,
    pub height: f64,
}

impl Rectangle {
    pub fn right(&self) -> f64 {
        self.left + self.width
    }

    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }

    pub fn contains(&self, point: Point) -> bool {
        (self.left..=self.right()).contains(&point[0]) && (self.top..=self.bottom()).contains(&point[1])
    }

    pub(crate) fn moved(&self, by: Point) -> Rectangle {
        Rectangle { left: self.left + by[0], top: self.top + by[1], ..*self }
    }
}

/// A piece of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment {
    Move(Point),
    Line(Point),
    Quadratic(Point, Point),
    Cubic(Point, Point, Point),
    Close,
}

impl Segment {
    /// The segment under a map of its points.
    pub fn map(self, map: impl Fn(Point) -> Point) -> Segment {
        match self {
            Segment::Move(p) => Segment::Move(map(p)),
            Segment::Line(p) => Segment::Line(map(p)),
            Segment::Quadratic(a, p) => Segment::Quadratic(map(a), map(p)),
            Segment::Cubic(a, b, p) => Segment::Cubic(map(a), map(b), map(p)),
            Segment::Close => Segment::Close,
        }
    }
}
