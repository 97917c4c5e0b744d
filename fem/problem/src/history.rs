//! Histories: values at the quadrature points of a region, read by forms and written by steps.
//!
//! ```text
//! assembler.history(…)          storage for a region and a rule, with an initial value
//! a form reads                  the committed values
//! assembler.update_history(…)   evaluates a function of the module there and keeps what it gives aside
//! history.commit()              what was kept aside becomes what forms read; history.revert() forgets it
//! ```
//!
//! Pairs of fixed points have histories of their own (`pair_points.rs`). The own points of pairs that slide are those of whole facets, and
//! read histories of facets (`own_points.rs`).
//!
//! An integral that reads a history takes that history's quadrature rule, whatever degree the compiler estimates.

mod of_assembler;
mod own_points;
mod pair_points;
mod rule_points;

use std::any::Any;
use std::ops::Range;
use std::sync::{Arc, PoisonError, RwLock};

use forms_core::contract::{Entity, Inputs, QuadratureValues, Source};
use thiserror::Error;

use self::of_assembler::MadeError;
pub use self::own_points::WithoutPartner;
use self::pair_points::PairPoints;
pub(crate) use self::pair_points::PointsOfPairs;
use self::rule_points::rule_points;
use crate::assemble::{Assembler, AssemblyError};
use crate::element::PerShape;
use crate::instantiate::instantiate;
use crate::mesh::Mesh;
use crate::quadrature::{Quadrature, QuadratureError};

/// Errors of reading or writing a history.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum HistoryMismatch {
    /// It belongs to another backend or dimension.
    #[error("it was not made by an assembler in {dimension} dimensions")]
    Foreign {
        /// Dimension of the mesh.
        dimension: usize,
    },
    /// It was made on another mesh.
    #[error("it was made on another mesh")]
    Mesh,
    /// The assembler has another choice of quadrature than the one that made it.
    #[error("it was made with another quadrature rule than this assembler's; let one assembler do both")]
    Rule,
    /// Two histories of one integral have different points.
    #[error("its rule has degree {degree}, that of `{other}`, read at the same points, has degree {found}")]
    Degree {
        /// Its own degree.
        degree: usize,
        /// Another history.
        other: &'static str,
        /// The degree of the other.
        found: usize,
    },
    /// A cell or facet of the integral is not among those of the history.
    #[error("it was made for {entity} of \"{region}\", and {what} is read, which is none of them")]
    Region {
        /// "the cells" or "the facets".
        entity: &'static str,
        /// Name of the region in the mesh.
        region: String,
        /// "cell 7" or "facet 2 of cell 7".
        what: String,
    },
    /// It is read on contact pairs that are not its own.
    #[error(
        "it was made for \"{made_for}\", and is read on the pairs {read_on}; `history_on_pairs` makes one for a pairing"
    )]
    Pairs {
        /// The region or the pairing of the history.
        made_for: String,
        /// The pairing of the integral.
        read_on: String,
    },
    /// It is read where points slide, and is none of own facets.
    #[error(
        "it was made for \"{made_for}\", and is read at the own points of the sliding pairs {read_on}; `history_on_sliding_pairs` makes one \
         for them"
    )]
    Sliding {
        /// The region or the pairing of the history.
        made_for: String,
        /// The pairing of the integral.
        read_on: String,
    },
    /// It is read on moving segments, whose points do not stay at their places on the own facets.
    #[error(
        "it is read on the moving segments of {read_on}, whose points move along the own facets and remember nothing; leave out \
         `.at(PairQuadrature::Pieces)`, so that the points of whole facets slide"
    )]
    Segments {
        /// The pairing of the integral.
        read_on: String,
    },
    /// It is written where points slide, without their displacement or at others than its own.
    #[error(
        "a history of \"{made_for}\" is not written by `update_sliding_history`, but by `update_history`"
    )]
    NotOfFacets {
        /// The region or the pairing of the history.
        made_for: String,
    },
    /// It is read from the other side of contact pairs.
    #[error("a history of contact pairs is read from the own side, by `this`")]
    Opposite,
    /// Its gradient is read.
    #[error("it has no gradient, because it is known at quadrature points only")]
    Gradient,
    /// It is read at points that are not its own.
    #[error(
        "it is known at its quadrature points only; evaluate this there (`at_quadrature_points`), or `project` it"
    )]
    Points,
}

/// Values at the quadrature points of a region.
pub(crate) struct PointStorage<const D: usize> {
    mesh: Mesh<D>,
    entity: Entity,
    /// The region or pairing that it was made for, in messages.
    region: String,
    /// The regions whose entities have the values, one region after the other.
    regions: Vec<String>,
    degree: usize,
    quadrature: Quadrature<D>,
    components: usize,
    /// The components of the value of the start.
    initial: Vec<f64>,
    /// By cell, or by cell and local facet: which entity of the region it is.
    entities: Vec<u32>,
    /// By entity: the number of its first point, and last the number of all points.
    starts: Vec<usize>,
    /// Of contact pairs, whose points no named region has.
    pairs: Option<PairPoints>,
    state: RwLock<State>,
}

struct State {
    /// Entity, point, component.
    committed: Arc<Vec<f64>>,
    written: Option<Vec<f64>>,
    commits: u64,
}

/// No entity of the region.
const NONE: u32 = u32::MAX;

/// A history as a form reads it: the values at the time of the assembly.
pub(crate) struct Snapshot<'a, const D: usize> {
    pub storage: &'a PointStorage<D>,
    values: Arc<Vec<f64>>,
}

impl<const D: usize> PointStorage<D> {
    fn new(
        assembler: &Assembler<D>,
        entity: Entity,
        regions: &[&str],
        degree: usize,
        initial: &[f64],
    ) -> Result<Self, MadeError> {
        let mesh = assembler.mesh().clone();
        let quadrature = assembler.quadrature().clone();
        let rules = rule_points(&mesh, &quadrature, entity, degree)?;
        let points: PerShape<usize> = rules.iter().map(|(shape, points)| (*shape, points.len())).collect();
        let facets = mesh.most_facets();
        let mut entities;
        let mut starts = vec![0];
        let mut number = |entry: &mut u32, cell: u32| {
            let count = starts.len() - 1;
            *entry = count as u32;
            starts.push(starts[count] + points[mesh.cell_shape(cell as usize)]);
        };
        match entity {
            Entity::Cells => {
                entities = vec![NONE; mesh.cell_count()];
                for region in regions {
                    for cell in mesh.cell_region(region)? {
                        number(&mut entities[*cell as usize], *cell);
                    }
                }
            }
            Entity::Facets | Entity::InteriorFacets | Entity::Pairs | Entity::Interface => {
                entities = vec![NONE; mesh.cell_count() * facets];
                for region in regions {
                    for facet in mesh.facet_region(region)? {
                        let place = facet.cell as usize * facets + usize::from(facet.local);
                        number(&mut entities[place], facet.cell);
                    }
                }
            }
        }
        let committed = Arc::new(initial.repeat(starts[starts.len() - 1]));
        Ok(PointStorage {
            mesh,
            entity,
            region: regions.join(", "),
            regions: regions.iter().map(|region| (*region).to_owned()).collect(),
            degree,
            quadrature,
            components: initial.len(),
            initial: initial.to_vec(),
            entities,
            starts,
            pairs: None,
            state: RwLock::new(State { committed, written: None, commits: 0 }),
        })
    }

    /// The storage behind a source.
    ///
    /// # Errors
    /// [`HistoryMismatch::Foreign`]: a source that is no history of this dimension.
    pub fn of(source: &dyn QuadratureValues) -> Result<&Self, HistoryMismatch> {
        source.as_any().downcast_ref().ok_or(HistoryMismatch::Foreign { dimension: D })
    }

    /// The values that forms read now.
    ///
    /// # Errors
    /// [`HistoryMismatch::Mesh`]: a history of another mesh.
    #[inline(never)]
    pub fn snapshot(&self, mesh: &Mesh<D>) -> Result<Snapshot<'_, D>, HistoryMismatch> {
        if !self.mesh.is_same(mesh) {
            return Err(HistoryMismatch::Mesh);
        }
        Ok(Snapshot { storage: self, values: self.committed() })
    }

    /// The numbers of the points of a cell, or of a cell's local facet, among all points; none where it has none.
    fn points_of(&self, cell: u32, facet: Option<u8>) -> Range<usize> {
        let index = match (self.entity, facet) {
            (Entity::Cells, None) => self.entities.get(cell as usize),
            (Entity::Facets | Entity::InteriorFacets | Entity::Pairs | Entity::Interface, Some(local)) => {
                self.entities.get(cell as usize * self.mesh.most_facets() + usize::from(local))
            }
            _ => None,
        };
        match index {
            Some(index) if *index != NONE => self.starts[*index as usize]..self.starts[*index as usize + 1],
            _ => 0..0,
        }
    }

    /// The number of the q-th point of a cell, or of a cell's local facet, among all points.
    fn point_of(&self, cell: u32, facet: Option<u8>, q: usize) -> Result<usize, HistoryMismatch> {
        let points = self.points_of(cell, facet);
        if q < points.len() {
            return Ok(points.start + q);
        }
        Err(HistoryMismatch::Region {
            entity: if self.entity == Entity::Cells { "the cells" } else { "the facets" },
            region: self.region.clone(),
            what: match facet {
                Some(local) => format!("facet {local} of cell {cell}"),
                None => format!("cell {cell}"),
            },
        })
    }

    fn committed(&self) -> Arc<Vec<f64>> {
        self.state.read().unwrap_or_else(PoisonError::into_inner).committed.clone()
    }

    /// Is this choice of quadrature the one that it was made with, at its degree?
    fn has_rule(&self, quadrature: &Quadrature<D>) -> Result<bool, QuadratureError> {
        Ok(*quadrature == self.quadrature
            || rule_points(&self.mesh, quadrature, self.entity, self.degree)?
                == rule_points(&self.mesh, &self.quadrature, self.entity, self.degree)?)
    }

    /// Keeps values aside, in the order of [`Assembler::at_quadrature_points`].
    fn write(&self, values: Vec<f64>) {
        self.state.write().unwrap_or_else(PoisonError::into_inner).written = Some(values);
    }
}

impl<const D: usize> Snapshot<'_, D> {
    /// The components at the q-th point of a cell, or of a cell's local facet.
    ///
    /// # Errors
    /// [`HistoryMismatch`]: an entity or a point where the history has no values.
    pub fn at(&self, cell: u32, facet: Option<u8>, q: usize) -> Result<&[f64], HistoryMismatch> {
        let start = self.storage.point_of(cell, facet, q)? * self.storage.components;
        Ok(&self.values[start..start + self.storage.components])
    }
}

impl<const D: usize> QuadratureValues for PointStorage<D> {
    fn components(&self) -> usize {
        self.components
    }

    fn commit(&self) {
        let mut state = self.state.write().unwrap_or_else(PoisonError::into_inner);
        if let Some(written) = state.written.take() {
            state.committed = Arc::new(written);
            state.commits += 1;
        }
    }

    fn revert(&self) {
        self.state.write().unwrap_or_else(PoisonError::into_inner).written = None;
    }

    #[inline(never)]
    fn commits(&self) -> u64 {
        self.state.read().unwrap_or_else(PoisonError::into_inner).commits
    }

    fn as_any(&self) -> &dyn Any {
        self
    }
}

/// The degree of the rule of all histories among the fields that a kernel reads, and the name of one of them;
/// `None` if it reads none.
#[inline(never)]
pub(crate) fn degree_of<'a, const D: usize>(
    form: &'static str,
    read: impl Iterator<Item = (&'static str, &'a PointStorage<D>)>,
    quadrature: &Quadrature<D>,
) -> Result<Option<(&'static str, usize)>, AssemblyError> {
    let mut found: Option<(&'static str, usize)> = None;
    for (field, storage) in read {
        let mismatch = |source| AssemblyError::History { form, field, source };
        let same = storage.has_rule(quadrature);
        if !same.map_err(|source| AssemblyError::Quadrature { form, source })? {
            return Err(mismatch(HistoryMismatch::Rule));
        }
        match found {
            Some((other, degree)) if degree != storage.degree => {
                let degree = HistoryMismatch::Degree { degree: storage.degree, other, found: degree };
                return Err(mismatch(degree));
            }
            _ => found = Some((field, storage.degree)),
        }
    }
    Ok(found)
}

/// The number of commits of a form's histories: integrals that were assembled before are out of date
/// when this number has changed.
pub(crate) fn commits<const D: usize>(inputs: &Inputs<D>) -> u64 {
    let histories = inputs.sources.iter().map(|source| match source {
        Some(Source::History(history)) => history.commits(),
        _ => 0,
    });
    histories.sum()
}

/// Whether a form reads values at quadrature points.
pub(crate) fn reads_history<const D: usize>(inputs: &Inputs<D>) -> bool {
    inputs.sources.iter().any(|source| matches!(source, Some(Source::History(_))))
}

instantiate!(history: PointStorage::<D>::snapshot, PointStorage::<D>::on_pairs, commits::<D>);
