//! Histories by an assembler: made, written with the values of a module's function, read.

use std::sync::Arc;

use crate::contract::Expression;
use crate::cut::CutError;
use forms_core::contract::{Entity, History, Pairing, QuadratureValues, Source};
use forms_core::source::{FieldValue, HistoryHandle};

use super::{HistoryMismatch, NONE, PointStorage, Snapshot};
use crate::assemble::{Assembler, AssemblyError};
use crate::instantiate::instantiate;
use crate::mesh::MeshError;
use crate::pairs::PairError;
use crate::quadrature::QuadratureError;

/// A cell, or a local facet of it, with its number of points.
type EntityOfHistory = (u32, Option<u8>, usize);

/// Errors of making a history.
pub(super) enum MadeError {
    Mesh(MeshError),
    Quadrature(QuadratureError),
}

impl From<MeshError> for MadeError {
    fn from(source: MeshError) -> Self {
        MadeError::Mesh(source)
    }
}

impl From<QuadratureError> for MadeError {
    fn from(source: QuadratureError) -> Self {
        MadeError::Quadrature(source)
    }
}

/// Name in messages of a history that is being made.
pub(super) const NEW: &str = "new history";

/// The same as an error of the assembler.
pub(super) fn not_made(why: MadeError) -> AssemblyError {
    match why {
        MadeError::Mesh(source) => AssemblyError::Region { form: NEW, symbol: "of it", source },
        MadeError::Quadrature(source) => AssemblyError::Quadrature { form: NEW, source },
    }
}

/// The components of an initial value, which is finite.
pub(super) fn components_of<V: FieldValue>(initial: V) -> Result<Vec<f64>, AssemblyError> {
    let mut components = vec![0.0; V::COMPONENTS];
    initial.write(&mut components);
    match components.iter().all(|value| value.is_finite()) {
        true => Ok(components),
        false => Err(AssemblyError::NotFinite { form: NEW, field: "the initial value", position: None }),
    }
}

/// The error of a history that cannot be written with a function.
pub(super) fn not_written<const D: usize>(
    expression: &Expression<D>,
    source: HistoryMismatch,
) -> AssemblyError {
    AssemblyError::History { form: expression.name(), field: "the history to be written", source }
}

impl<const D: usize> Assembler<D> {
    /// A history with the same value at all quadrature points of a cell or facet region. Where the assembler
    /// takes the compiler's estimate, its rule is that of `degree`; the integrals that read it take this rule.
    ///
    /// # Errors
    /// An unknown region, contact pairs (for which there are `history_on_pairs` and `history_on_sliding_pairs`), a rule that does not exist, or a value that is
    /// not finite.
    pub fn history<V: FieldValue>(
        &self,
        entity: Entity,
        region: &str,
        degree: usize,
        initial: V,
    ) -> Result<History<V, D>, AssemblyError> {
        if entity == Entity::Interface || self.cut().is_some() {
            let source = CutError::Refused { what: "a history" };
            return Err(AssemblyError::Cut { form: NEW, place: format!("\"{region}\""), source });
        }
        if entity == Entity::Pairs {
            let (pairing, source) = (region.to_owned(), PairError::History);
            return Err(AssemblyError::Pairs { form: NEW, symbol: "of it", pairing, source });
        }
        let initial = components_of(initial)?;
        let storage = PointStorage::new(self, entity, &[region], degree, &initial).map_err(not_made)?;
        Ok(History::from_handle(Arc::new(storage)))
    }

    /// A history with the same value at all points of contact pairs that have an opposite one, on the undeformed mesh: read by
    /// `this` in integrals over this pairing, and in no others. Where the assembler takes the compiler's estimate, its rule
    /// is that of `degree`.
    ///
    /// # Errors
    /// Surfaces that cannot be paired, or a value that is not finite.
    pub fn history_on_pairs<V: FieldValue>(
        &self,
        pairing: &Pairing,
        degree: usize,
        initial: V,
    ) -> Result<History<V, D>, AssemblyError> {
        let storage = PointStorage::on_pairs(self, pairing, degree, &components_of(initial)?);
        let refused = |source| AssemblyError::Pairs {
            form: NEW,
            symbol: "of it",
            pairing: pairing.to_string(),
            source,
        };
        Ok(History::from_handle(Arc::new(storage.map_err(refused)?)))
    }

    /// Known values at the quadrature points of all cells, `values[(cell * points + point) * components + component]`,
    /// for the forms of this assembler to read.
    #[inline(never)]
    pub(crate) fn known_at_points(
        &self,
        degree: usize,
        components: usize,
        values: Vec<f64>,
    ) -> Result<Source<D>, AssemblyError> {
        let everywhere = crate::mesh::EVERYWHERE;
        let zeros = vec![0.0; components];
        let storage =
            PointStorage::new(self, Entity::Cells, &[everywhere], degree, &zeros).map_err(not_made)?;
        storage.write(values);
        storage.commit();
        Ok(Source::History(Arc::new(storage)))
    }

    /// Values of a function of a forms module at the points of a history, kept aside until
    /// [`History::commit`] or [`History::revert`]. All histories that the function reads have their committed
    /// values, so that several can be written in any order.
    ///
    /// # Errors
    /// A wrong number of components, a value that is not finite, or data that do not fit; nothing is written
    /// then.
    pub fn update_history<V: FieldValue>(
        &self,
        expression: &Expression<D>,
        history: &History<V, D>,
    ) -> Result<(), AssemblyError> {
        let storage = self.storage_to_write(expression, history.handle())?;
        // At its own points, whatever this assembler would take.
        let own = self.clone().with_quadrature(storage.quadrature.clone());
        let mut values = vec![];
        if let Some(pairs) = &storage.pairs {
            values = own.found_at_pairs(expression, &pairs.pairing, storage.degree)?.values;
        }
        for region in &storage.regions {
            let found =
                own.found_at_quadrature_points(expression, storage.entity, region, storage.degree)?.values;
            values.extend(found);
        }
        if values.len() != storage.committed().len() {
            return Err(not_written(expression, HistoryMismatch::Rule));
        }
        storage.write(values);
        Ok(())
    }

    /// The storage of a history, for the values of a function.
    pub(super) fn storage_to_write<'h>(
        &self,
        expression: &Expression<D>,
        history: &'h HistoryHandle,
    ) -> Result<&'h PointStorage<D>, AssemblyError> {
        let storage = PointStorage::<D>::of(&**history).map_err(|why| not_written(expression, why))?;
        storage.snapshot(self.mesh()).map_err(|why| not_written(expression, why))?;
        let (expected, found) = (expression.shape().iter().product(), storage.components);
        if expected != found {
            let (form, field) = (expression.name(), "the history");
            return Err(AssemblyError::Components { form, field, expected, found });
        }
        Ok(storage)
    }

    /// The committed values: the components at each point, for the cells (or facets) in the order of their
    /// region, point by point.
    ///
    /// ```
    /// use forms_fem::prelude::*;
    ///
    /// #[forms(dimension = 2)]
    /// mod largest {
    ///     pub struct Data {
    ///         pub before: History<Scalar>,
    ///     }
    ///     pub fn after(u: Scalar) -> Scalar {
    ///         max(before, u)
    ///     }
    /// }
    ///
    /// let mesh = rectangle([0.0; 2], [1.0; 2], [2, 1], CellShape::Quadrilateral, 1)?;
    /// let assembler = Assembler::new(&mesh);
    /// let data = largest::data().before(assembler.history(Entity::Cells, "all", 3, 0.25)?);
    /// let u = Field::interpolate(&Space::scalar(&mesh, 1)?, |x: &[f64; 2]| x[0])?;
    /// assembler.update_history(&largest::after(&data, &u), &data.before)?;
    /// assert!(assembler.history_values(&data.before)?.iter().all(|value| *value == [0.25]));
    /// data.before.commit();
    /// // Two cells with 2 × 2 points each.
    /// let values = assembler.history_values(&data.before)?;
    /// assert_eq!(values.len(), 8);
    /// assert!(values.iter().all(|value| value[0] >= 0.25 && value[0] < 1.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A history of another mesh or backend.
    pub fn history_values<V: FieldValue>(
        &self,
        history: &History<V, D>,
    ) -> Result<Vec<Vec<f64>>, AssemblyError> {
        let snapshot = self.snapshot_of("history_values", history.handle())?;
        Ok(snapshot.values.chunks(snapshot.storage.components).map(<[f64]>::to_vec).collect())
    }

    fn snapshot_of<'h>(
        &self,
        form: &'static str,
        history: &'h HistoryHandle,
    ) -> Result<Snapshot<'h, D>, AssemblyError> {
        let mismatch = |source| AssemblyError::History { form, field: "the history", source };
        let storage = PointStorage::<D>::of(&**history).map_err(mismatch)?;
        storage.snapshot(self.mesh()).map_err(mismatch)
    }

    /// Commits values as [`Assembler::history_values`] gives them, for example those of an earlier run.
    ///
    /// # Errors
    /// Another number of points or components than the history has, a value that is not finite, a history of another mesh or backend.
    pub fn set_history_values<V: FieldValue>(
        &self,
        history: &History<V, D>,
        values: &[Vec<f64>],
    ) -> Result<(), AssemblyError> {
        let (form, field) = ("set_history_values", "the history");
        let Snapshot { storage, values: before } = self.snapshot_of(form, history.handle())?;
        if let Some(other) = values.iter().find(|value| value.len() != storage.components) {
            let (expected, found) = (storage.components, other.len());
            return Err(AssemblyError::Components { form, field, expected, found });
        }
        let values = values.concat();
        if values.len() != before.len() {
            return Err(AssemblyError::History { form, field, source: HistoryMismatch::Rule });
        }
        if !values.iter().all(|value| value.is_finite()) {
            return Err(AssemblyError::NotFinite { form, field, position: None });
        }
        storage.write(values);
        storage.commit();
        Ok(())
    }

    /// The cells, or facets of cells, in the order of [`Assembler::history_values`], each with its number of points. None of pairs.
    ///
    /// # Errors
    /// A history of another mesh or backend.
    #[doc(hidden)]
    pub fn history_entities<V: FieldValue>(
        &self,
        history: &History<V, D>,
    ) -> Result<Vec<EntityOfHistory>, AssemblyError> {
        let storage = self.snapshot_of("history_entities", history.handle())?.storage;
        let facets = storage.mesh.most_facets();
        let places = storage.entities.iter().enumerate().filter(|(_, entity)| **entity != NONE);
        let mut found: Vec<(u32, EntityOfHistory)> = vec![];
        for (place, entity) in places {
            let points = storage.starts[*entity as usize + 1] - storage.starts[*entity as usize];
            let (cell, local) = match storage.entity {
                Entity::Cells => (place, None),
                _ => (place / facets, Some((place % facets) as u8)),
            };
            found.push((*entity, (cell as u32, local, points)));
        }
        found.sort_unstable();
        Ok(found.into_iter().map(|(_, entity)| entity).collect())
    }
}

instantiate!(of_assembler: Assembler::<D>::known_at_points);
