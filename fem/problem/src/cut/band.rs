//! A band around the interface: active cells and ghost facets that stay while the level set function changes a little, so that a line search
//! compares values of one discrete problem.

use std::sync::Arc;

use super::{Cut, CutError, CutSide};
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::mesh::{Facet, Mesh};

/// The active cells and ghost facets of all level set functions that differ by less than a width from one.
#[derive(Clone, Debug)]
pub struct CutBand<const D: usize> {
    mesh: Mesh<D>,
    active: Vec<bool>,
    /// Cells that do not count as a part of the body: those of islands that were removed.
    removed: Vec<bool>,
    /// Cells in which the interface may be.
    near: Vec<bool>,
    ghost: Vec<[Facet; 2]>,
}

/// The part of a band that belongs to a cut within it.
pub(super) struct Kept {
    /// Cells that something of the body reaches.
    pub cells: Vec<bool>,
    /// The ghost facets between them.
    pub ghost: Vec<[Facet; 2]>,
    /// Those of the cells that have nothing of the body and no ghost facet.
    pub untied: Vec<u32>,
}

impl<const D: usize> Cut<D> {
    /// The band |φ| < `width` \[unit of φ\]: its cells stay active, and the facets of these keep the ghost penalty.
    ///
    /// What is assembled on a body depends on which cells are active, and jumps by a little where a node changes sides. On cuts within a
    /// band ([`Cut::within`]) this jump is near rounding.
    ///
    /// ```
    /// use forms_fem::cut::Cut;
    /// use forms_fem::prelude::*;
    ///
    /// let mesh = rectangle([-1.0; 2], [1.0; 2], [16, 16], CellShape::Triangle, 1)?;
    /// let space = Space::scalar(&mesh, 1)?;
    /// let disc = |radius: f64| Field::interpolate(&space, |x| x[0].hypot(x[1]) - radius);
    /// let cut = Cut::by(&disc(0.7)?)?;
    /// let band = cut.band(0.05);
    /// let larger = Cut::within(&disc(0.74)?, &band)?;
    /// assert_eq!(larger.ghost_facets(), Cut::within(&disc(0.66)?, &band)?.ghost_facets());
    /// assert!(larger.ghost_facets().len() > cut.ghost_facets().len());
    /// assert!(Cut::within(&disc(0.9)?, &band).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[inline(never)]
    pub fn band(&self, width: f64) -> Arc<CutBand<D>> {
        let count = self.sides.len();
        let (mut active, mut removed, mut near) =
            (vec![false; count], vec![false; count], vec![false; count]);
        for cell in self.mesh.body_cells() {
            let [least, most] = self.bounds_of(cell as u32);
            removed[cell] = self.sides[cell] == CutSide::Outside
                && least < 0.0
                && self.side_by_values(cell as u32) != CutSide::Outside;
            active[cell] = least < width && !removed[cell];
            near[cell] = active[cell] && most > -width;
        }
        let active = self.reached(&active);
        let ghost = self.ties(&active, width);
        Arc::new(CutBand { mesh: self.mesh.clone(), active, removed, near, ghost })
    }

    /// The body on which a function is negative, with the active cells and ghost facets of a band. Islands that were removed before the
    /// band was made are no part of it.
    ///
    /// # Errors
    /// Those of [`Cut::by`], [`CutError::OtherMesh`], and [`CutError::LeftBand`] for a function that differs by more than the band allows.
    pub fn within(phi: &Field<D>, band: &Arc<CutBand<D>>) -> Result<Arc<Self>, CutError> {
        match phi.space().mesh().is_same(&band.mesh) {
            true => Self::made(phi, Some(band)),
            false => Err(CutError::OtherMesh),
        }
    }

    /// The check that a cut fits its band, without the islands that the band left out.
    ///
    /// # Errors
    /// [`CutError::LeftBand`].
    pub(super) fn fit_band(&mut self) -> Result<(), CutError> {
        if let Some(band) = &self.band {
            for (cell, side) in self.sides.iter_mut().enumerate() {
                if band.removed[cell] {
                    *side = CutSide::Outside;
                }
                // Ghost facets are around the cells near the interface only.
                let fits = match side {
                    CutSide::Outside => true,
                    CutSide::Cut => band.near[cell],
                    CutSide::Inside => band.active[cell],
                };
                if !fits {
                    return Err(CutError::LeftBand { position: self.mesh.cell_centre(cell).to_vec() });
                }
            }
        }
        Ok(())
    }

    /// The cells and facets that a band keeps; none without a band.
    pub(super) fn kept_by_band(&self) -> Option<Kept> {
        let band = self.band.as_ref()?;
        let kept = self.reached(&band.active);
        // Tied cells that have lost all of the body follow what is left.
        let mut held: Vec<bool> =
            (0..kept.len()).map(|cell| kept[cell] && self.sides[cell] != CutSide::Outside).collect();
        let of_cells = |sides: &[Facet; 2], own: &[bool]| sides.map(|facet| own[facet.cell as usize]);
        let mut grows = true;
        while std::mem::take(&mut grows) {
            for sides in band.ghost.iter().filter(|sides| of_cells(sides, &kept) == [true; 2]) {
                if let [true, false] | [false, true] = of_cells(sides, &held) {
                    sides.iter().for_each(|facet| held[facet.cell as usize] = true);
                    grows = true;
                }
            }
        }
        let own =
            |sides: &&[Facet; 2]| of_cells(sides, &kept) == [true; 2] && of_cells(sides, &held) == [true; 2];
        let mut ghost: Vec<[Facet; 2]> = band.ghost.iter().filter(own).copied().collect();
        let untied = self.tie_empty(&kept, &mut held, &mut ghost);
        Some(Kept { cells: kept, ghost, untied })
    }

    /// Of some cells, those that are connected over facets between them with one in which something of the body is.
    fn reached(&self, cells: &[bool]) -> Vec<bool> {
        let mut kept: Vec<bool> =
            self.sides.iter().zip(cells).map(|(side, own)| *own && *side != CutSide::Outside).collect();
        loop {
            let mut is_done = true;
            for [a, b] in self.mesh.interior_facets() {
                let (a, b) = (a.cell as usize, b.cell as usize);
                if cells[a] && cells[b] && kept[a] != kept[b] {
                    (kept[a], kept[b], is_done) = (true, true, false);
                }
            }
            if is_done {
                return kept;
            }
        }
    }
}

instantiate!(cut_band: Cut::<D>::band);
