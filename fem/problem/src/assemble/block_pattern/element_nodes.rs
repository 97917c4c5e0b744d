//! Nodes of elements that a matrix couples.

/// Sets of test and trial nodes that are all coupled with each other.
pub(in crate::assemble) struct ElementNodes<'a> {
    /// Test nodes, set after set.
    pub rows: Vec<&'a [u32]>,
    /// Trial nodes of each set.
    pub columns: Vec<&'a [u32]>,
}
