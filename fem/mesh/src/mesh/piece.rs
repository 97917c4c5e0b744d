//! Pieces of a mesh that is divided among processes: cells that one process has of a larger mesh.

use std::collections::BTreeMap;
use std::ops::Range;

use super::facet_parts::{FacetParts, PartCorners};
use super::{BOUNDARY, EVERYWHERE, Facet, INTERIOR, Mesh, MeshError};
use crate::element::CellShape;

/// The extent of a mesh's cells.
#[derive(Clone, Debug, Default)]
pub(super) enum Extent {
    /// They are all cells of the body.
    #[default]
    Whole,
    /// Other processes have further ones.
    Piece(Box<Replicas>),
}

/// Copies of other processes' cells in a piece: those at some surfaces, or behind its facets to other pieces.
#[derive(Clone, Debug, Default)]
pub(super) struct Replicas {
    /// Number of the last cells, copies of others' cells. They are in no region.
    ghost_cells: usize,
    /// Number of the last nodes, which only copies have.
    ghost_nodes: usize,
    /// All facets of some surfaces, those of the copies, too, ascending.
    surfaces: BTreeMap<String, Vec<Facet>>,
    /// Whether copies are behind facets to other pieces, on any process.
    behind_facets: bool,
    /// The shapes of all processes' cells.
    shapes: Vec<CellShape>,
    /// Whether nodes hang on exterior facets of the larger mesh, which a piece does not know.
    hangs_outside: bool,
}

/// Copies of other processes' cells.
#[doc(hidden)]
#[derive(Clone, Debug)]
pub struct GhostCells<const D: usize> {
    /// Nodes that come after those of the piece.
    pub nodes: Vec<[f64; D]>,
    /// Their cells, block after block.
    pub blocks: Vec<(CellShape, Vec<u32>)>,
    /// All facets of each surface: of the piece's own cells, and of the copies.
    pub surfaces: BTreeMap<String, Vec<Facet>>,
    /// The copies, ascending, whose facets to this piece's cells this process integrates over: facets between pieces are interior ones then.
    /// They may be among earlier copies. Without them interior facets stay as they are.
    pub behind_facets: Option<Vec<u32>>,
    /// Facets that are parts of larger ones, of the piece's own cells, too, as [`Mesh::facet_parts`] has them: in addition to the known ones.
    pub facet_parts: Vec<(Facet, Facet, [[f64; D]; 3])>,
    /// The shapes of all processes' cells.
    pub shapes: Vec<CellShape>,
}

/// Advice for what needs the whole mesh.
#[doc(hidden)]
pub const TAKE_THE_WHOLE: &str = "take the whole mesh on each process";

/// Names of the regions of the mesh that is divided.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct RegionNames<'a> {
    pub cells: &'a [String],
    pub facets: &'a [String],
}

impl<const D: usize> Mesh<D> {
    /// This mesh as a piece of a larger one. `cut` are its facets to cells of other processes, ascending: they are on no boundary. It has the
    /// regions of the larger mesh, empty ones where nothing of them is here, and no interior facets, because no process has both sides of those
    /// between pieces.
    #[doc(hidden)]
    #[must_use]
    pub fn into_piece(mut self, cut: &[Facet], names: RegionNames<'_>) -> Self {
        let data = self.data_mut();
        let mut facets: BTreeMap<String, Vec<Facet>> = BTreeMap::new();
        for name in names.facets.iter().map(String::as_str).chain([BOUNDARY]) {
            let mut own = data.facet_regions.remove(name).unwrap_or_default();
            own.retain(|facet| cut.binary_search(facet).is_err());
            // Lists of names have that of the boundary, too.
            facets.entry(name.to_owned()).or_insert(own);
        }
        let mut cells: BTreeMap<String, Vec<u32>> = BTreeMap::new();
        for name in names.cells.iter().map(String::as_str).chain([EVERYWHERE]) {
            let own = data.cell_regions.remove(name).unwrap_or_default();
            cells.entry(name.to_owned()).or_insert(own);
        }
        (data.facet_regions, data.cell_regions) = (facets, cells);
        data.interior_regions.clear();
        data.extent = Extent::Piece(Box::default());
        self
    }

    /// This piece with copies of other processes' cells, so that each process has some surfaces whole, or one of two the cells on both sides of
    /// a facet. The copies come last, behind those that it has already, and are in no region: integrals over cells, conditions and files are those
    /// of the piece's own cells.
    ///
    /// # Errors
    /// Cells that do not fit each other.
    #[doc(hidden)]
    pub fn with_ghost_cells(&self, ghosts: GhostCells<D>) -> Result<Self, MeshError> {
        let GhostCells { nodes, blocks, surfaces, behind_facets, facet_parts, shapes } = ghosts;
        let known = self.replicas().cloned().unwrap_or_default();
        let own = self.ghost_cells().start;
        let of_block = |block: &super::CellBlock| {
            let cells = block.cells.clone().flat_map(|cell| self.cell(cell));
            (block.shape, cells.copied().collect())
        };
        let ghost_nodes = known.ghost_nodes + nodes.len();
        let all_nodes = self.nodes.iter().copied().chain(nodes).collect();
        let all_blocks = self.blocks().iter().map(of_block).chain(blocks).collect();
        // Each was looked at where it is a process's own, and may have hanging nodes there.
        let mut mesh = Mesh::of_sound_cells(self.degree, all_nodes, all_blocks)?;
        let ghost_cells = mesh.cell_count() - own;
        let mut all_surfaces = known.surfaces;
        for (name, mut facets) in surfaces {
            facets.sort_unstable();
            facets.dedup();
            all_surfaces.insert(name, facets);
        }
        let mut parts: BTreeMap<Facet, (Facet, PartCorners<D>)> = BTreeMap::new();
        parts.extend(facet_parts.into_iter().map(|(small, large, at)| (small, (large, at))));
        parts.extend(self.facet_parts().map(|(small, large, at)| (small, (large, *at))));
        let data = mesh.data_mut();
        data.facet_regions.clone_from(&self.facet_regions);
        data.cell_regions.clone_from(&self.cell_regions);
        let mut interior = data.interior_regions.remove(INTERIOR).unwrap_or_default();
        data.interior_regions.clone_from(&self.interior_regions);
        if let Some(behind) = &behind_facets {
            interior.extend(parts.iter().map(|(small, (large, _))| [*small.min(large), *small.max(large)]));
            // The first side is of the cell with the lower number; copies come last.
            let is_own = |facet: &Facet| (facet.cell as usize) < own;
            let is_behind = |facet: &Facet| is_own(facet) || behind.binary_search(&facet.cell).is_ok();
            interior.retain(|[first, second]| is_own(first) && is_behind(second));
            interior.sort_unstable();
            data.interior_regions.insert(INTERIOR.to_owned(), interior);
        }
        data.parts =
            FacetParts::new(parts.into_iter().map(|(small, (large, at))| (small, large, at)).collect());
        data.extent = Extent::Piece(Box::new(Replicas {
            ghost_cells,
            ghost_nodes,
            surfaces: all_surfaces,
            behind_facets: known.behind_facets || behind_facets.is_some(),
            shapes,
            hangs_outside: known.hangs_outside,
        }));
        Ok(mesh)
    }

    /// This piece, with whether nodes hang on exterior facets of the larger mesh.
    #[doc(hidden)]
    #[must_use]
    pub fn with_hanging_outside(mut self, hangs_outside: bool) -> Self {
        if let Extent::Piece(replicas) = &mut self.data_mut().extent {
            replicas.hangs_outside = hangs_outside;
        }
        self
    }

    /// An error for a piece of a mesh whose nodes hang on exterior facets: the large facet and the small ones may be on two processes.
    pub(super) fn without_hanging_outside(&self) -> Result<(), MeshError> {
        match self.replicas().is_some_and(|replicas| replicas.hangs_outside) {
            true => Err(MeshError::Piece {
                what: "continuity at hanging nodes of a mesh that is given by its cells",
                instead: TAKE_THE_WHOLE,
            }),
            false => Ok(()),
        }
    }

    fn replicas(&self) -> Option<&Replicas> {
        match &self.extent {
            Extent::Whole => None,
            Extent::Piece(replicas) => Some(replicas),
        }
    }

    /// The copies of other processes' cells: the last ones.
    #[doc(hidden)]
    pub fn ghost_cells(&self) -> Range<usize> {
        let count = self.replicas().map_or(0, |replicas| replicas.ghost_cells);
        self.cell_count() - count..self.cell_count()
    }

    /// Number of nodes that only copies of other processes' cells have: the last ones.
    pub(super) fn ghost_nodes(&self) -> usize {
        self.replicas().map_or(0, |replicas| replicas.ghost_nodes)
    }

    /// Whether processes may have copies of others' cells; the same on all processes.
    #[doc(hidden)]
    pub fn has_copies(&self) -> bool {
        self.replicas().is_some_and(|replicas| !replicas.surfaces.is_empty())
            || self.has_facets_between_pieces()
    }

    /// Whether facets between pieces are interior ones, each on one process; the same on all processes.
    #[doc(hidden)]
    pub fn has_facets_between_pieces(&self) -> bool {
        self.replicas().is_some_and(|replicas| replicas.behind_facets)
    }

    /// The shapes of the cells of all processes, where there are copies; else of those that are here.
    #[doc(hidden)]
    pub fn shapes_of_all(&self) -> Vec<CellShape> {
        match self.replicas() {
            Some(replicas) if !replicas.shapes.is_empty() => replicas.shapes.clone(),
            _ => self.shapes(),
        }
    }

    /// All facets of a surface, ascending; of a piece also those of copies.
    ///
    /// # Errors
    /// Those of [`Mesh::facet_region`]; [`MeshError::DividedSurface`] where no process has all of them.
    #[doc(hidden)]
    pub fn facets_of_surface(&self, name: &str) -> Result<&[Facet], MeshError> {
        let here = self.facet_region(name)?;
        match self.replicas() {
            None => Ok(here),
            Some(replicas) => {
                let divided = || MeshError::DividedSurface { name: name.to_owned() };
                replicas.surfaces.get(name).map(Vec::as_slice).ok_or_else(divided)
            }
        }
    }

    /// A name for some facets of a surface that each process has whole; nothing where that surface is none.
    pub(super) fn name_on_surface(
        &mut self,
        name: &str,
        within: &str,
        condition: &dyn Fn(&[f64; D]) -> bool,
    ) {
        let all = self.replicas().and_then(|replicas| replicas.surfaces.get(within));
        let Some(all) = all else { return };
        let found = all.iter().copied().filter(|facet| condition(&self.facet_centre(*facet))).collect();
        if let Extent::Piece(replicas) = &mut self.data_mut().extent {
            replicas.surfaces.insert(name.to_owned(), found);
        }
    }

    /// Whether it is one process's piece of a larger mesh. What needs the whole mesh refuses it.
    #[inline]
    pub fn is_piece(&self) -> bool {
        matches!(self.extent, Extent::Piece(_))
    }

    /// Check that the mesh is no piece of a larger one, for functions that need all of it, with what to do instead.
    ///
    /// # Errors
    /// [`MeshError::Piece`].
    #[doc(hidden)]
    pub fn without_pieces(&self, what: &'static str, instead: &'static str) -> Result<(), MeshError> {
        if self.is_piece() { Err(MeshError::Piece { what, instead }) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;
    use crate::mesh::rectangle;

    #[test]
    fn a_piece_has_the_regions_of_the_whole_and_no_boundary_at_its_cut() -> Result<(), MeshError> {
        let half = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1)?;
        let facets = ["left", "right", "top", "bottom", BOUNDARY];
        let cut = half.facet_region("right")?.to_vec();
        let names = RegionNames { cells: &["steel".to_owned()], facets: &facets.map(str::to_owned) };
        let mut piece = half.into_piece(&cut, names);
        let count = |name: &str| piece.facet_region(name).map(<[Facet]>::len);
        assert_eq!([count("left")?, count("right")?, count("boundary")?], [2, 0, 6]);
        assert!(piece.cell_region("steel")?.is_empty() && piece.cell_region(EVERYWHERE)?.len() == 4);
        assert!(piece.interior_facets().is_empty() && piece.interior_facet_region("interior").is_err());
        // On this process a region may have nothing.
        piece.name_facets("support", "right", |_| true)?;
        assert!(piece.facet_region("support")?.is_empty() && piece.is_piece());
        let said = piece.refined().map(|_| ()).unwrap_err().to_string();
        let text =
            "refinement is not available on a mesh that is divided among processes; take the whole mesh";
        assert!(said.starts_with(text), "{said}");
        Ok(())
    }

    #[test]
    fn facets_to_copies_are_interior() -> Result<(), MeshError> {
        let half = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1)?;
        let cut = half.facet_region("right")?.to_vec();
        let piece = half.into_piece(&cut, RegionNames { cells: &[], facets: &["bottom".to_owned()] });
        let part = piece.with_ghost_cells(GhostCells {
            nodes: vec![[1.5, 0.0], [1.5, 0.5], [1.5, 1.0]],
            blocks: vec![(CellShape::Quadrilateral, vec![2, 9, 10, 5, 5, 10, 11, 8])],
            surfaces: BTreeMap::new(),
            behind_facets: Some(vec![4, 5]),
            facet_parts: vec![],
            shapes: vec![CellShape::Quadrilateral],
        })?;
        // Four inside, two to copies, and not the one between copies.
        let cells = |sides: &[Facet; 2]| sides.map(|side| side.cell);
        let found: Vec<[u32; 2]> = part.interior_facets().iter().map(cells).collect();
        assert_eq!(found, [[0, 1], [0, 2], [1, 4], [1, 3], [2, 3], [3, 5]]);
        assert!(part.has_copies() && !piece.has_copies() && part.boundary_facets().len() == 6);
        // Further copies come behind those, and change no interior facets.
        let bottom = [Facet { cell: 0, local: 0 }, Facet { cell: 6, local: 0 }];
        let more = part.with_ghost_cells(GhostCells {
            nodes: vec![[2.0, 0.0], [2.0, 0.5]],
            blocks: vec![(CellShape::Quadrilateral, vec![9, 12, 13, 10])],
            surfaces: BTreeMap::from([("bottom".to_owned(), bottom.to_vec())]),
            behind_facets: None,
            facet_parts: vec![],
            shapes: vec![CellShape::Quadrilateral],
        })?;
        assert_eq!(more.interior_facets(), part.interior_facets());
        assert_eq!((more.body_cells(), more.ghost_cells(), more.body_nodes()), (0..4, 4..7, (9, 16)));
        assert!(more.has_facets_between_pieces() && more.facets_of_surface("bottom")?.len() == 2);
        Ok(())
    }

    #[test]
    fn copies_of_cells_are_in_surfaces_only() -> Result<(), MeshError> {
        let half = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Quadrilateral, 1)?;
        let (cut, top) = (half.facet_region("right")?.to_vec(), half.facet_region("top")?.to_vec());
        let names = RegionNames { cells: &[], facets: &["top", "left"].map(str::to_owned) };
        let piece = half.into_piece(&cut, names);
        // The other half's cell below the top, next to the corner: two nodes are here, and two come with it.
        let copy = Facet { cell: 4, local: 2 };
        let mut part = piece.with_ghost_cells(GhostCells {
            nodes: vec![[1.5, 0.5], [1.5, 1.0]],
            blocks: vec![(CellShape::Quadrilateral, vec![5, 9, 10, 8])],
            surfaces: BTreeMap::from([("top".to_owned(), [&[copy], &top[..]].concat())]),
            behind_facets: None,
            facet_parts: vec![],
            shapes: vec![CellShape::Quadrilateral],
        })?;
        assert_eq!((part.cell_count(), part.body_cells(), part.ghost_cells()), (5, 0..4, 4..5));
        assert_eq!(part.body_nodes(), (9, 16));
        assert!(part.cell_region(EVERYWHERE)?.len() == 4 && part.boundary_facets().len() == 6);
        assert_eq!((part.facet_region("top")?, part.facets_of_surface("top")?.len()), (&top[..], 3));
        part.name_facets("far", "top", |x| x[0] > 1.0)?;
        assert!(part.facet_region("far")?.is_empty());
        assert_eq!(part.facets_of_surface("far")?, [copy]);
        let divided = MeshError::DividedSurface { name: "left".to_owned() };
        assert_eq!(part.facets_of_surface("left"), Err(divided));
        Ok(())
    }
}
