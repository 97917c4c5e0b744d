//! A value for each shape of cell.

use std::ops::Index;

use super::CellShape;

/// A value for each of the shapes that a mesh's cells have, by shape. A list: there are two of them at most.
#[derive(Clone, Debug, PartialEq)]
pub struct PerShape<T> {
    values: Vec<(CellShape, T)>,
}

impl<T> FromIterator<(CellShape, T)> for PerShape<T> {
    fn from_iter<I: IntoIterator<Item = (CellShape, T)>>(values: I) -> Self {
        PerShape { values: values.into_iter().collect() }
    }
}

impl<T> PerShape<T> {
    /// The values.
    pub fn values(&self) -> impl Iterator<Item = &T> {
        self.values.iter().map(|(_, value)| value)
    }
}

/// # Panics
/// A shape without a value.
impl<T> Index<CellShape> for PerShape<T> {
    type Output = T;

    fn index(&self, shape: CellShape) -> &T {
        let found = self.values.iter().find(|(own, _)| *own == shape);
        &found.expect("a shape of the mesh").1
    }
}
