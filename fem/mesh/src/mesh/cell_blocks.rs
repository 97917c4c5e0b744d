//! Which cells of a mesh have which shape: cells of one shape follow each other in blocks.

use std::ops::Range;

use super::{Facet, Mesh, MeshError};
use crate::element::{CellShape, Lagrange};

/// Cells of one shape that follow each other in the numbering of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellBlock {
    /// Their shape.
    pub shape: CellShape,
    /// Their numbers.
    pub cells: Range<usize>,
}

impl CellBlock {
    /// The block whose cells are each divided into the given number of the same shape.
    pub(super) fn divided(&self, parts: usize) -> CellBlock {
        CellBlock { shape: self.shape, cells: self.cells.start * parts..self.cells.end * parts }
    }
}

/// Places of each cell's numbers in a list of all cells' numbers, cell after cell: within a block each cell has
/// equally many.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellLists {
    blocks: Vec<ListBlock>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct ListBlock {
    cells: Range<usize>,
    /// The start of the first cell's numbers.
    start: usize,
    per_cell: usize,
}

impl CellLists {
    /// Lists with a given number of numbers per cell of a shape.
    pub fn new(blocks: &[CellBlock], per_cell: impl Fn(CellShape) -> usize) -> Self {
        let mut start = 0;
        let mut list = |block: &CellBlock| {
            let (cells, per_cell, first) = (block.cells.clone(), per_cell(block.shape), start);
            start += cells.len() * per_cell;
            ListBlock { cells, start: first, per_cell }
        };
        CellLists { blocks: blocks.iter().map(&mut list).collect() }
    }

    /// The places of a cell's numbers; beyond the end of the list where there is no such cell.
    #[inline]
    pub fn of(&self, cell: usize) -> Range<usize> {
        let block = match &self.blocks[..] {
            [block] => block,
            blocks => &blocks[block_of(blocks, |block| block.cells.end, cell)],
        };
        let start = block.start + (cell - block.cells.start) * block.per_cell;
        start..start + block.per_cell
    }

    /// Length of the list.
    pub fn length(&self) -> usize {
        self.blocks.last().map_or(0, |last| last.start + last.cells.len() * last.per_cell)
    }

    /// The cells of a list, in their order.
    pub fn chunks<'a, T>(&'a self, list: &'a [T]) -> impl Iterator<Item = &'a [T]> {
        self.blocks.iter().flat_map(move |block| {
            let end = block.start + block.cells.len() * block.per_cell;
            list[block.start..end].chunks(block.per_cell)
        })
    }
}

/// The block of a cell; the last one where there is no such cell.
#[inline]
fn block_of<B>(blocks: &[B], end: impl Fn(&B) -> usize, cell: usize) -> usize {
    blocks.partition_point(|block| end(block) <= cell).min(blocks.len() - 1)
}

impl<const D: usize> Mesh<D> {
    /// The blocks of the cells: one where all cells have one shape.
    pub fn blocks(&self) -> &[CellBlock] {
        &self.blocks
    }

    /// The blocks of the bodies' cells, without those that carry rigid surfaces.
    #[doc(hidden)]
    pub fn body_blocks(&self) -> impl Iterator<Item = CellBlock> + '_ {
        let end = self.body_cells().end;
        let cut = move |block: &CellBlock| CellBlock {
            shape: block.shape,
            cells: block.cells.start.min(end)..block.cells.end.min(end),
        };
        self.blocks.iter().map(cut).filter(|block| !block.cells.is_empty())
    }

    /// The shapes of the cells, each once, in the order of the blocks.
    pub fn shapes(&self) -> Vec<CellShape> {
        let mut shapes = Vec::new();
        for block in &self.blocks {
            if !shapes.contains(&block.shape) {
                shapes.push(block.shape);
            }
        }
        shapes
    }

    /// The shape of all cells, for functions that do not support several shapes.
    ///
    /// # Errors
    /// [`MeshError::SeveralShapes`], which says what it was needed for.
    pub fn one_shape(&self, feature: &'static str) -> Result<CellShape, MeshError> {
        match self.shapes()[..] {
            [shape] => Ok(shape),
            ref shapes => Err(MeshError::SeveralShapes { feature, shapes: shapes.to_vec() }),
        }
    }

    /// The shape of a cell.
    ///
    /// # Panics
    /// When `cell` is not below [`Mesh::cell_count`].
    #[inline]
    pub fn cell_shape(&self, cell: usize) -> CellShape {
        match &self.blocks[..] {
            [block] => block.shape,
            blocks => blocks[block_of(blocks, |block| block.cells.end, cell)].shape,
        }
    }

    /// The element of a cell's geometry map.
    ///
    /// # Panics
    /// When `cell` is not below [`Mesh::cell_count`].
    pub fn cell_element(&self, cell: usize) -> Lagrange {
        self.element_of(self.cell_shape(cell))
    }

    /// The element of the geometry map of the cells of a shape.
    #[doc(hidden)]
    pub fn element_of(&self, shape: CellShape) -> Lagrange {
        Lagrange { shape, degree: self.degree }
    }

    /// Whether the Jacobian of the cells of a shape is constant.
    #[doc(hidden)]
    pub fn is_affine_on(&self, shape: CellShape) -> bool {
        self.degree == 1 && shape.is_simplex()
    }

    /// The vertices of a cell.
    #[doc(hidden)]
    pub fn cell_vertices(&self, cell: usize) -> &[u32] {
        &self.cell(cell)[..self.cell_shape(cell).vertices()]
    }

    /// The vertices of a facet, in the order of [`CellShape::facet_vertices`].
    #[doc(hidden)]
    pub fn facet_vertices(&self, facet: Facet) -> impl Iterator<Item = u32> {
        let cell = facet.cell as usize;
        let nodes = self.cell(cell);
        self.cell_shape(cell)
            .facet_vertices(usize::from(facet.local))
            .iter()
            .map(move |&vertex| nodes[vertex])
    }

    /// The most facets that a cell has.
    #[doc(hidden)]
    pub fn most_facets(&self) -> usize {
        self.blocks.iter().map(|block| block.shape.facets()).max().unwrap_or(0)
    }

    /// The shape whose facets have the reference cell of all facets: any of the mesh's.
    #[doc(hidden)]
    pub fn shape_of_facets(&self) -> CellShape {
        self.blocks[0].shape
    }

    /// Runs of cells of one shape in a list.
    #[doc(hidden)]
    pub fn runs_of_shape<'a>(&'a self, cells: &'a [u32]) -> impl Iterator<Item = (CellShape, &'a [u32])> {
        let shape = |cell: u32| self.cell_shape(cell as usize);
        let runs = cells.chunk_by(move |a, b| shape(*a) == shape(*b));
        runs.map(move |run| (shape(run[0]), run))
    }

    /// A list of cells by their shapes, each part in the order of the list.
    #[doc(hidden)]
    pub fn by_shape(&self, cells: Vec<u32>) -> Vec<(CellShape, Vec<u32>)> {
        match self.shapes()[..] {
            [shape] => vec![(shape, cells)],
            ref shapes => {
                let of = |shape| {
                    let own = cells.iter().filter(|cell| self.cell_shape(**cell as usize) == shape);
                    (shape, own.copied().collect::<Vec<u32>>())
                };
                shapes.iter().map(|shape| of(*shape)).filter(|(_, cells)| !cells.is_empty()).collect()
            }
        }
    }
}
