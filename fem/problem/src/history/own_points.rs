//! Histories at the own points of pairs that slide: the points of whole facets stay where they are, only their opposite points move.

use std::sync::Arc;

use forms_core::contract::{Entity, History, Pairing};
use forms_core::source::FieldValue;

use super::of_assembler::{NEW, components_of, not_made, not_written};
use super::pair_points::PointsOfPairs;
use super::{HistoryMismatch, PointStorage};
use crate::assemble::{Assembler, AssemblyError};
use crate::contract::Expression;
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::mesh::Mesh;
use crate::pairs::PairError;

/// The new value of a history at an own point that has no opposite point in this step: what a function of both sides cannot give.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WithoutPartner {
    /// The value before: worn depths, plastic strains.
    Keep,
    /// The value with which the history was made: what a contact remembers as long as it lasts.
    Restart,
}

/// The own surfaces of a pairing, each once, if their points can remember.
fn own_surfaces<'p, const D: usize>(mesh: &Mesh<D>, pairing: &'p Pairing) -> Result<Vec<&'p str>, PairError> {
    if PointsOfPairs::of(pairing, true) == PointsOfPairs::Segments {
        return Err(PairError::HistoryOnSegments);
    }
    let (mut names, mut facets): (Vec<&str>, Vec<_>) = (vec![], vec![]);
    for facing in &pairing.surfaces {
        if names.contains(&facing.own.as_str()) {
            continue;
        }
        if mesh.rigid_surface(&facing.own).is_some() {
            return Err(PairError::RigidSide { surface: facing.own.clone() });
        }
        let own = mesh.facets_of_surface(&facing.own).map_err(|source| PairError::Surface { source })?;
        if own.is_empty() {
            return Err(PairError::Empty { surface: facing.own.clone() });
        }
        facets.extend(own.iter().copied());
        names.push(&facing.own);
    }
    if names.is_empty() {
        return Err(PairError::NoSurfaces);
    }
    facets.sort_unstable();
    match facets.windows(2).any(|two| two[0] == two[1]) {
        true => Err(PairError::Twice),
        false => Ok(names),
    }
}

impl<const D: usize> Assembler<D> {
    /// A history with the same value at all own points of pairs whose opposite points slide, read by `this` in `integral(Touch(u), ..)`:
    /// a history of the facets of all own surfaces, whether or not they have opposite points at the moment. Where the assembler takes the
    /// compiler's estimate, its rule is that of `degree`. [`Assembler::update_sliding_history`] writes it with functions of both sides,
    /// [`Assembler::update_history`] with those of the own body. Integrals over facets of these surfaces read it, too.
    ///
    /// ```
    /// use forms_fem::history::WithoutPartner;
    /// use forms_fem::prelude::*;
    ///
    /// #[forms(dimension = 2)]
    /// mod nearest {
    ///     pub struct Data {
    ///         pub least: History<Scalar>,
    ///     }
    ///     #[pairs]
    ///     pub struct Touch;
    ///     pub fn after() -> Scalar {
    ///         min(this(least), gap)
    ///     }
    ///     pub fn sum(u: State<Vector>) -> Functional {
    ///         integral(Touch(u), this(least))
    ///     }
    /// }
    ///
    /// let slab = rectangle([0.0, 0.0], [3.0, 1.0], [6, 2], CellShape::Quadrilateral, 1)?;
    /// let block = rectangle([0.0, 1.5], [1.0, 2.5], [3, 3], CellShape::Quadrilateral, 1)?;
    /// let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)])?;
    /// let assembler = Assembler::new(&mesh);
    /// let touch = Pairing::onto("block bottom", "slab top");
    /// let data = nearest::data().least(assembler.history_on_sliding_pairs(&touch, 3, 9.0)?);
    /// // The block moves along the slab, up and down.
    /// let space = Space::vector(&mesh, 1)?;
    /// for [along, up] in [[0.5, 0.1], [0.8, -0.2], [1.7, 0.0]] {
    ///     let u = Field::interpolate(&space, |x| if x[1] > 1.2 { [along, up] } else { [0.0; 2] })?;
    ///     let after = nearest::after(&data);
    ///     assembler.update_sliding_history(&after, &data.least, &touch, &u, WithoutPartner::Keep)?;
    ///     data.least.commit();
    /// }
    /// let sum = nearest::sum(&data, &nearest::Touch::on(touch), &Field::zero(&space));
    /// assert!((assembler.functional(&sum)? - 0.3).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// Unknown or rigid own surfaces, moving segments ([`PairError::HistoryOnSegments`]), facets that two own surfaces share, or a value
    /// that is not finite.
    pub fn history_on_sliding_pairs<V: FieldValue>(
        &self,
        pairing: &Pairing,
        degree: usize,
        initial: V,
    ) -> Result<History<V, D>, AssemblyError> {
        let refused = |source| AssemblyError::Pairs {
            form: NEW,
            symbol: "of it",
            pairing: pairing.to_string(),
            source,
        };
        let surfaces = own_surfaces(self.mesh(), pairing).map_err(refused)?;
        let initial = components_of(initial)?;
        let storage =
            PointStorage::new(self, Entity::Facets, &surfaces, degree, &initial).map_err(not_made)?;
        Ok(History::from_handle(Arc::new(storage)))
    }

    /// Values of a function of both sides at the own points of a history of facets, with the opposite points that they have at a
    /// displacement, kept aside until [`History::commit`] or [`History::revert`]. Points of the pairing's own surfaces that have no
    /// opposite point take the value that is chosen for them; those of other surfaces keep theirs.
    ///
    /// # Errors
    /// A wrong number of components, a history that is none of facets, moving segments, a point with two opposite points in the pairing
    /// ([`PairError::Twice`]), a value that is not finite, or data that do not fit; nothing is written then.
    #[inline(never)]
    pub fn update_sliding_history<V: FieldValue>(
        &self,
        expression: &Expression<D>,
        history: &History<V, D>,
        pairing: &Pairing,
        displacement: &Field<D>,
        without_partner: WithoutPartner,
    ) -> Result<(), AssemblyError> {
        let storage = self.storage_to_write(expression, history.handle())?;
        if storage.entity != Entity::Facets {
            let made_for = storage.region.clone();
            return Err(not_written(expression, HistoryMismatch::NotOfFacets { made_for }));
        }
        self.write_sliding(storage, expression, pairing, displacement, without_partner)
    }

    fn write_sliding(
        &self,
        storage: &PointStorage<D>,
        expression: &Expression<D>,
        pairing: &Pairing,
        displacement: &Field<D>,
        without_partner: WithoutPartner,
    ) -> Result<(), AssemblyError> {
        let refused = |source| AssemblyError::Pairs {
            form: expression.name(),
            symbol: "of the history",
            pairing: pairing.to_string(),
            source,
        };
        let surfaces = own_surfaces(self.mesh(), pairing).map_err(refused)?;
        // At its own points, whatever this assembler would take.
        let own = self.clone().with_quadrature(storage.quadrature.clone());
        let (found, pairs) = own.found_on_pairs(expression, pairing, storage.degree, Some(displacement))?;
        let place = |cell: u32, local: u8, q: usize| {
            storage.point_of(cell, Some(local), q).map_err(|why| not_written(expression, why))
        };
        let (mut values, width) = (storage.committed().to_vec(), storage.components);
        if without_partner == WithoutPartner::Restart {
            for name in surfaces {
                for facet in self.mesh().facet_region(name).unwrap_or_default() {
                    for point in storage.points_of(facet.cell, Some(facet.local)) {
                        values[point * width..][..width].copy_from_slice(&storage.initial);
                    }
                }
            }
        }
        let mut is_written = vec![false; values.len() / width.max(1)];
        let mut next = 0;
        for group in &pairs.groups {
            for (unit, [facet, _]) in group.facets.iter().enumerate() {
                for q in &group.rule_points[unit * group.count..][..group.count] {
                    let point = place(facet.cell, facet.local, usize::from(*q))?;
                    if std::mem::replace(&mut is_written[point], true) {
                        return Err(refused(PairError::Twice));
                    }
                    values[point * width..][..width].copy_from_slice(found.value(next));
                    next += 1;
                }
            }
        }
        storage.write(values);
        Ok(())
    }
}

instantiate!(own_points: Assembler::<D>::write_sliding);
