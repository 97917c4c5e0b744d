//! Numbers of nodes and points: counted when a program runs, or fixed when it is compiled.

/// How the loops over nodes and points learn their lengths.
pub trait Sizes: Copy + Send + Sync + 'static {
    /// What does not depend on the kernel is compiled once, not into each loop.
    const SHARED: bool;
    /// Number of nodes of the test (and trial) functions' element, given what was found in its tables.
    fn nodes(found: usize) -> usize;
    /// Number of quadrature points.
    fn points(found: usize) -> usize;
    /// Number of nodes of the geometry map.
    fn geometry_nodes(found: usize) -> usize;
}

/// Any element and rule.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counted;

impl Sizes for Counted {
    const SHARED: bool = true;

    #[inline(always)]
    fn nodes(found: usize) -> usize {
        found
    }
    #[inline(always)]
    fn points(found: usize) -> usize {
        found
    }
    #[inline(always)]
    fn geometry_nodes(found: usize) -> usize {
        found
    }
}

/// One element and one rule: loops are compiled for their lengths.
#[derive(Clone, Copy, Debug, Default)]
pub struct Fixed<const NODES: usize, const POINTS: usize, const GEOMETRY_NODES: usize>;

impl<const NODES: usize, const POINTS: usize, const GEOMETRY_NODES: usize> Sizes
    for Fixed<NODES, POINTS, GEOMETRY_NODES>
{
    const SHARED: bool = false;

    #[inline(always)]
    fn nodes(_: usize) -> usize {
        NODES
    }
    #[inline(always)]
    fn points(_: usize) -> usize {
        POINTS
    }
    #[inline(always)]
    fn geometry_nodes(_: usize) -> usize {
        GEOMETRY_NODES
    }
}
