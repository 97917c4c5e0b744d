//! Random well-typed forms modules: a list of choices → the text of a module.
//!
//! The first choice everywhere is the simplest, and a list that has ended goes on with zeros: shorter lists and
//! smaller numbers give simpler modules, which is how failures shrink.

mod expression;
mod module;
mod templates;

pub use module::module;

/// Shapes of random expressions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Shape {
    Scalar,
    Vector,
    Tensor,
    Fourth,
}

impl Shape {
    pub const FIELDS: [Shape; 3] = [Shape::Scalar, Shape::Vector, Shape::Tensor];

    /// The shape of a hole.
    fn of_letter(letter: char) -> Option<Shape> {
        match letter.to_ascii_lowercase() {
            's' => Some(Shape::Scalar),
            'v' => Some(Shape::Vector),
            't' => Some(Shape::Tensor),
            'q' => Some(Shape::Fourth),
            _ => None,
        }
    }

    /// As a hole.
    fn letter(self) -> char {
        match self {
            Shape::Scalar => 's',
            Shape::Vector => 'v',
            Shape::Tensor => 't',
            Shape::Fourth => 'q',
        }
    }

    /// As a type.
    fn name(self) -> &'static str {
        match self {
            Shape::Scalar => "Scalar",
            Shape::Vector => "Vector",
            Shape::Tensor => "Tensor",
            Shape::Fourth => "Tensor4",
        }
    }

    fn axes(self) -> usize {
        match self {
            Shape::Scalar => 0,
            Shape::Vector => 1,
            Shape::Tensor => 2,
            Shape::Fourth => 4,
        }
    }

    fn of_axes(axes: usize) -> Option<Shape> {
        [Shape::Scalar, Shape::Vector, Shape::Tensor, Shape::Fourth]
            .into_iter()
            .find(|shape| shape.axes() == axes)
    }
}

/// A list of choices that is read from the front.
pub struct Choices<'a> {
    list: &'a [u32],
    next: usize,
}

impl<'a> Choices<'a> {
    pub fn new(list: &'a [u32]) -> Self {
        Choices { list, next: 0 }
    }

    /// One of the given number.
    pub fn below(&mut self, count: usize) -> usize {
        let choice = self.list.get(self.next).copied().unwrap_or(0);
        self.next += 1;
        choice as usize % count.max(1)
    }

    pub fn one_of<'l, T>(&mut self, list: &'l [T]) -> &'l T {
        &list[self.below(list.len())]
    }
}
