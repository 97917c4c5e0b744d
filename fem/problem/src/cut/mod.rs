//! Bodies that are cut from a mesh: where a level set function is negative.
//!
//! ```text
//! aggregation  unknowns of badly cut cells, given by those of well-posed cells
//! values   the values at nodes of cells
//! simplices   the pieces of one simplex
//! heights   rules on quadrilaterals and hexahedra that a polynomial cuts
//! pieces   a cell and a facet in pieces, with the points of rules
//! band     active cells and ghost facets that stay while the function changes a little
//! ties    facets that join badly cut cells to well-posed ones
//! parts    parts of the body that no cell connects
//! known_points  points of rules, made once
//! number  values with derivatives by nodal values
//! interface  the interface in space, the distance to it and to a given surface
//! holding  unknowns that no active cell has
//! body     the pieces as a mesh of their own, to be drawn and written
//! ```

mod aggregation;
mod band;
mod body;
mod error;
pub(crate) mod heights;
mod holding;
mod interface;
pub(crate) mod known_points;
pub(crate) mod number;
mod parts;
mod pieces;
mod simplices;
mod ties;
mod values;

use std::collections::BTreeMap;
use std::sync::Arc;

pub use self::band::CutBand;
use self::band::Kept;
pub use self::body::CutBody;
pub use self::error::CutError;
use self::heights::CellPolynomial;
pub use self::interface::{InterfacePiece, signed_distance};
use self::known_points::KnownPoints;
pub use self::parts::BodyPart;
pub(crate) use self::pieces::VertexValues;
pub(crate) use self::simplices::{determinant_of, edges_of};
use self::values::{away_from_zero, degree_of, lattice_of, nodes_of, side};
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::mesh::{Facet, Mesh};
use crate::pairs::Pairs;

/// The name of the interior facets on which ghost penalties are.
pub const GHOST: &str = "ghost";
/// The name of the cells through which the interface passes.
pub const CUT: &str = "cut";
/// The name of the cells that are whole.
pub const INSIDE: &str = "inside";

/// Values at nodes that are nearer to zero than this part of the function's range on the cells around are moved.
const NEAR_ZERO: f64 = 1e-12;

/// Location of a cell or a facet in a cut mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CutSide {
    /// The function is negative all over it.
    Inside,
    /// The interface passes through it.
    Cut,
    /// Nothing of the body is in it.
    Outside,
}

/// The body {φ < 0} of a level set function φ of degree 1 or 2 on the mesh of its space.
///
/// On triangles and tetrahedra φ is linear, and so are the pieces: the body is a polygon or polyhedron. With φ of degree 1 a quadrilateral counts as two
/// triangles, on which φ is linear between its values at the corners. On hexahedra, and with φ of degree 2 on quadrilaterals, φ is the polynomial
/// that it is, and the body has curved boundaries. Cells with φ < 0 somewhere are *active*. Integrals of an assembler on
/// the cut ([`Assembler::cut_by`](crate::assemble::Assembler::cut_by)) are over the parts of cells and exterior facets inside.
///
/// ```
/// use forms_fem::prelude::*;
///
/// let mesh = rectangle([-1.0; 2], [1.0; 2], [32, 32], CellShape::Triangle, 1)?;
/// let phi = Field::interpolate(&Space::scalar(&mesh, 1)?, |x| x[0].hypot(x[1]) - 0.7)?;
/// let disc = Assembler::new(&mesh).cut_by(&phi)?;
/// let area = form!(|| -> Functional { integral(cells("all"), 1) });
/// let length = form!(|| -> Functional { integral(interface("all"), 1) });
/// assert!((disc.functional(&area)? - 1.539_380).abs() < 3e-3);
/// assert!((disc.functional(&length)? - 4.398_230).abs() < 3e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Cut<const D: usize> {
    mesh: Mesh<D>,
    /// φ at the nodes of its space, moved away from zero, and the nodes of each cell, those at its vertices first.
    values: Vec<f64>,
    nodes: Vec<u32>,
    /// The start of each cell's nodes.
    starts: Vec<u32>,
    /// φ's degree, and where nodes of quadrilaterals and hexahedra are among those of degree 2.
    degree: usize,
    lattice: Vec<u8>,
    moved: Vec<u32>,
    sides: Vec<CutSide>,
    /// Cells of either kind, ascending.
    inside: Vec<u32>,
    cut: Vec<u32>,
    ghost: Vec<[Facet; 2]>,
    /// Active cells of a band that have nothing of the body and no ghost facet.
    untied: Vec<u32>,
    /// The well-posed cell of each badly cut one, where aggregates take the place of ghost facets.
    roots: Option<BTreeMap<u32, u32>>,
    known: KnownPoints,
    /// What stays, and the cells that are active therefore.
    band: Option<Arc<CutBand<D>>>,
    kept: Vec<bool>,
}

impl<const D: usize> Cut<D> {
    /// The body on which a function is negative.
    ///
    /// A value at a node that is zero, or nearer to it than 10⁻¹² of the function's range on the cells around, becomes this small number: the
    /// node is outside then ([`Cut::moved_nodes`]).
    ///
    /// # Errors
    /// [`CutError`]: a field that is no continuous scalar of degree 1 on all cells, or 2 on quadrilaterals and hexahedra; a mesh with hanging nodes, regions of
    /// the mesh that have a name of the cut's, or a function that is nowhere negative.
    pub fn by(phi: &Field<D>) -> Result<Arc<Self>, CutError> {
        Self::made(phi, None)
    }

    #[inline(never)]
    fn made(phi: &Field<D>, band: Option<&Arc<CutBand<D>>>) -> Result<Arc<Self>, CutError> {
        let space = phi.space();
        let mesh = space.mesh();
        mesh.without_pieces("a cut", crate::mesh::TAKE_THE_WHOLE)
            .map_err(|error| CutError::Mesh { text: error.to_string() })?;
        let degree = degree_of(space)?;
        if mesh.facet_parts().next().is_some() {
            return Err(CutError::HangingNodes);
        }
        let names = [
            (CUT, mesh.cell_region(CUT).is_ok()),
            (INSIDE, mesh.cell_region(INSIDE).is_ok()),
            (GHOST, mesh.interior_facet_region(GHOST).is_ok()),
        ];
        if let Some((name, _)) = names.into_iter().find(|(_, taken)| *taken) {
            return Err(CutError::Name { name });
        }
        if let Some(node) = phi.values().iter().position(|value| !value.is_finite()) {
            return Err(CutError::NotFinite { position: space.positions()[node].to_vec() });
        }
        let (nodes, starts) = nodes_of(phi);
        let of_cell = |cell: usize| &nodes[starts[cell] as usize..starts[cell + 1] as usize];
        let (values, moved) = away_from_zero(phi.values(), mesh.body_cells().map(of_cell));
        let sides = vec![CutSide::Outside; mesh.cell_count()];
        let (lattice, mesh) = (lattice_of(space, mesh), mesh.clone());
        let (inside, cut, ghost, untied) = (vec![], vec![], vec![], vec![]);
        let (band, kept, known) = (band.cloned(), vec![], KnownPoints::default());
        let mut made = Cut {
            mesh,
            values,
            nodes,
            starts,
            degree,
            lattice,
            moved,
            sides,
            inside,
            cut,
            ghost,
            untied,
            roots: None,
            known,
            band,
            kept,
        };
        for cell in made.mesh.body_cells() {
            made.sides[cell] = made.side_by_values(cell as u32);
        }
        made.fit_band()?;
        made.list();
        if made.inside.is_empty() && made.cut.is_empty() {
            return Err(CutError::Empty);
        }
        Ok(Arc::new(made))
    }

    /// The lists of cells and facets, by the sides of the cells.
    fn list(&mut self) {
        let of_side = |wanted: CutSide| -> Vec<u32> {
            (0..self.sides.len() as u32).filter(|cell| self.sides[*cell as usize] == wanted).collect()
        };
        (self.inside, self.cut) = (of_side(CutSide::Inside), of_side(CutSide::Cut));
        (self.ghost, self.untied) = match self.kept_by_band() {
            Some(Kept { cells, ghost, untied }) => {
                self.kept = cells;
                (ghost, untied)
            }
            None => {
                let active: Vec<bool> = self.sides.iter().map(|side| *side != CutSide::Outside).collect();
                (self.ties(&active, 0.0), vec![])
            }
        };
        if self.roots.is_some() {
            let ties: Vec<[u32; 2]> =
                std::mem::take(&mut self.ghost).iter().map(|[a, b]| [a.cell, b.cell]).collect();
            self.roots = Some(self.roots_of(&ties));
        }
    }

    /// Whether something of the body is in a cell, or a band keeps it.
    pub(crate) fn is_active(&self, cell: u32) -> bool {
        match &self.band {
            Some(_) => self.kept[cell as usize],
            None => self.sides[cell as usize] != CutSide::Outside,
        }
    }

    /// The background mesh.
    pub fn mesh(&self) -> &Mesh<D> {
        &self.mesh
    }

    /// Location of a cell.
    ///
    /// # Panics
    /// When the mesh has no such cell.
    pub fn side_of_cell(&self, cell: u32) -> CutSide {
        self.sides[cell as usize]
    }

    /// Location of a facet, seen from its cell.
    ///
    /// # Panics
    /// When the mesh has no such cell or facet.
    pub fn side_of_facet(&self, facet: Facet) -> CutSide {
        match self.sides[facet.cell as usize] {
            CutSide::Outside => CutSide::Outside,
            side if self.cuts_by_heights(facet.cell) => match side {
                CutSide::Cut => CellPolynomial::<f64>::new(self, facet.cell).side_of_facet(facet.local),
                side => side,
            },
            _ => {
                let values = self.vertex_values(facet.cell);
                let shape = self.mesh.cell_shape(facet.cell as usize);
                side(shape.facet_vertices(usize::from(facet.local)).iter().map(|vertex| values[*vertex]))
            }
        }
    }

    /// A number per cell that says where it is, and where there are aggregates the cells that they join. Where one changes, a node has changed
    /// sides or a cell has another root, and what is assembled jumps by a little: in a line search and in Taylor tests these are switches. Of hexahedra,
    /// and of quadrilaterals with φ of degree 2, a number tells how lines through the cell are cut: where it changes, points of rules do.
    /// [`Cut::ghost_facets`] may change, too, where the middle of a cell changes sides or two cells become equally deep.
    pub fn sides(&self) -> impl Iterator<Item = u32> {
        let roots = self.roots.iter().flatten().flat_map(|(cell, root)| [*cell, *root]);
        self.sides.iter().map(|side| *side as u32).chain(roots).chain(self.structures())
    }

    /// The cells that are whole, ascending.
    pub fn inside_cells(&self) -> &[u32] {
        &self.inside
    }

    /// The cells through which the interface passes, ascending.
    pub fn cut_cells(&self) -> &[u32] {
        &self.cut
    }

    /// The interior facets of the ghost penalty, with both sides: over them cut cells whose middle is outside are tied to deeper ones, and so to
    /// a cell with enough of the body. The body is on each, so that none joins what a gap divides. None with [aggregates](Cut::aggregated).
    pub fn ghost_facets(&self) -> &[[Facet; 2]] {
        &self.ghost
    }

    /// The nodes of φ's space at which a value that was zero was moved, ascending.
    pub fn moved_nodes(&self) -> &[u32] {
        &self.moved
    }

    /// Check that contact pairs are on facets inside.
    ///
    /// # Errors
    /// [`CutError::PairedFacet`].
    pub(crate) fn check_pairs(&self, pairs: &Pairs<D>) -> Result<(), CutError> {
        for facet in pairs.groups.iter().flat_map(|group| &group.facets).flatten() {
            if !self.mesh.carries(facet.cell) && self.side_of_facet(*facet) != CutSide::Inside {
                return Err(CutError::PairedFacet { position: self.mesh.facet_centre(*facet).to_vec() });
            }
        }
        Ok(())
    }
}

instantiate!(cut: Cut::<D>::made, Cut::<D>::side_of_facet, nodes_of::<D>, lattice_of::<D>);
