//! Numbers of nodes and points: counted when a program runs, or fixed when it is compiled.

/// A list whose length is part of its type.
pub trait Array<T: Copy + Send + 'static>: Copy + Send + 'static {
    /// Its length.
    const LENGTH: usize;
    /// The same value in each place.
    fn filled(value: T) -> Self;
    /// Its entries.
    fn entries(&self) -> &[T];
    /// Its entries, to be changed.
    fn entries_mut(&mut self) -> &mut [T];
}

impl<T: Copy + Send + 'static, const LENGTH: usize> Array<T> for [T; LENGTH] {
    const LENGTH: usize = LENGTH;

    #[inline(always)]
    fn filled(value: T) -> Self {
        [value; LENGTH]
    }
    #[inline(always)]
    fn entries(&self) -> &[T] {
        self
    }
    #[inline(always)]
    fn entries_mut(&mut self) -> &mut [T] {
        self
    }
}

/// The lengths of the loops over nodes and points of an [`crate::assemble::ElementKernel`].
pub trait Sizes: Copy + Send + Sync + 'static {
    /// Whether the lengths are those of the arrays; if not, they are counted.
    const FIXED: bool;
    /// A value per node of the test (and trial) functions' element.
    type Nodes<T: Copy + Send + 'static>: Array<T>;
    /// A value per quadrature point.
    type Points<T: Copy + Send + 'static>: Array<T>;
    /// A value per node of the geometry map.
    type GeometryNodes<T: Copy + Send + 'static>: Array<T>;
}

/// Any element and rule.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counted;

impl Sizes for Counted {
    const FIXED: bool = false;
    type Nodes<T: Copy + Send + 'static> = [T; 0];
    type Points<T: Copy + Send + 'static> = [T; 0];
    type GeometryNodes<T: Copy + Send + 'static> = [T; 0];
}

/// One element and one rule: loops are compiled for their lengths.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fixed<const NODES: usize, const POINTS: usize, const GEOMETRY_NODES: usize>;

impl<const NODES: usize, const POINTS: usize, const GEOMETRY_NODES: usize> Sizes
    for Fixed<NODES, POINTS, GEOMETRY_NODES>
{
    const FIXED: bool = true;
    type Nodes<T: Copy + Send + 'static> = [T; NODES];
    type Points<T: Copy + Send + 'static> = [T; POINTS];
    type GeometryNodes<T: Copy + Send + 'static> = [T; GEOMETRY_NODES];
}
