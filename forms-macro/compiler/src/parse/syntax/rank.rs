//! Declared shapes: `Scalar`, `Vector<3>`, `Matrix<2, 3>`.

use std::fmt;

/// The extent of one axis of a declared shape.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// D, the dimension of the form.
    Dimension,
    /// The same number in every dimension.
    Fixed(usize),
}

/// A declared shape: the extents of its axes, at most four. `Scalar` has none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rank {
    axes: usize,
    /// Those after the first `axes` mean nothing and are [`Extent::Dimension`].
    extents: [Extent; Rank::LARGEST],
}

impl Rank {
    /// No declared shape has more axes.
    pub const LARGEST: usize = 4;
    /// `Scalar`
    pub const SCALAR: Rank = Rank::of_dimension(0);
    /// `Vector`
    pub const VECTOR: Rank = Rank::of_dimension(1);
    /// `Tensor`
    pub const TENSOR: Rank = Rank::of_dimension(2);
    /// `Tensor4`
    pub const TENSOR4: Rank = Rank::of_dimension(4);

    const fn of_dimension(axes: usize) -> Rank {
        Rank { axes, extents: [Extent::Dimension; Rank::LARGEST] }
    }

    /// `None` for more than [`Rank::LARGEST`] axes.
    pub fn new(extents: &[Extent]) -> Option<Rank> {
        let mut rank = Rank::of_dimension(extents.len());
        rank.extents.get_mut(..extents.len())?.copy_from_slice(extents);
        Some(rank)
    }

    /// One per axis.
    pub fn extents(&self) -> &[Extent] {
        &self.extents[..self.axes]
    }

    /// The extents in numbers.
    pub fn shape(self, dimension: usize) -> Vec<usize> {
        let number = |extent: &Extent| match extent {
            Extent::Dimension => dimension,
            Extent::Fixed(number) => *number,
        };
        self.extents().iter().map(number).collect()
    }
}

/// As it is written: `Tensor`, `Vector<3>`.
impl fmt::Display for Rank {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = match (*self, self.axes) {
            (Rank::SCALAR, _) => return f.write_str("Scalar"),
            (Rank::VECTOR, _) => return f.write_str("Vector"),
            (Rank::TENSOR, _) => return f.write_str("Tensor"),
            (Rank::TENSOR4, _) => return f.write_str("Tensor4"),
            (_, 1) => "Vector",
            (_, 2) => "Matrix",
            // Not to be written, yet a result may be of it.
            _ => "Tensor",
        };
        let extents = self.extents().iter().map(|extent| match extent {
            Extent::Dimension => "D".to_string(),
            Extent::Fixed(number) => number.to_string(),
        });
        write!(f, "{word}<{}>", extents.collect::<Vec<_>>().join(", "))
    }
}
