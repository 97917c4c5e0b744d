//! Assembly: the loops over cells and facets that run compiled kernels.
//!
//! ```text
//! binding   a form's data against a mesh: regions, fields, parameters checked; entities are a region's cells or facets
//! walk      a region as groups of entities with common tables
//! batch     geometry, basis functions and fields at the points of some cells, one per lane
//! kernel_calls   what a kernel gives for each entity of a range, as matrices and vectors; its node_pairs, reference_tensor and
//!           sum_factorisation: three ways
//! element_kernel, fixed, sizes   the same on cells that the caller lists; loops whose lengths are known when compiled
//! block_pattern, touched, sparsity, block_index   the positions of a matrix, and where element matrices go
//! pair_groups   the points of contact pairs, which differ from entity to entity, as groups; pair_search those of a pattern
//! own_rows      the rows that a thread adds to
//! owned_cells   the partial sums of an assembler of some of the cells
//! partition, scatter   which thread adds what, in the order of one thread; group_nodes, block_finders: to which rows and places
//! residual, tangent, functional, derived   the four loops, one per kind of kernel; action runs the residual's
//! ```
//!
//! Cells and facets go through the same loops: an exterior facet is an entity with the cell that owns it, an interior one has
//! two sides. Who calls which function of a kernel, on cells and facets alike: of a tangent `cell` in `compute_in_lanes` and
//! `point`, `test`, `trial` in `factors` of `kernel_calls/matrices.rs`, `pair` and `finish` in `kernel_calls/node_pairs.rs`; of a
//! residual all in `kernel_calls/vectors.rs`; of functionals and derived fields in `functional.rs` and `derived.rs`. `fixed` and
//! `reference_tensor` call them in the same order.

mod action;
mod basis_in_lanes;
mod batch;
mod binding;
mod block_finders;
mod block_index;
mod block_pattern;
mod derived;
mod element_kernel;
mod entities;
mod error;
mod facet_groups;
mod fixed;
mod functional;
mod group_nodes;
mod kernel_calls;
mod notices;
mod outline;
mod own_rows;
mod owned_cells;
mod pair_groups;
mod pair_histories;
mod pair_reports;
mod pair_search;
mod partition;
mod positive_parts;
pub(crate) mod projection;
mod reference_tensor;
mod residual;
mod scatter;
mod sink;
mod sizes;
mod sparsity;
mod split_facets;
mod sum_factorisation;
mod tangent;
mod touched;
mod walk;

use std::borrow::Cow;
use std::sync::Arc;

pub use action::TangentAction;
pub use block_pattern::BlockPattern;
pub use derived::{FacetSample, PointValues};
pub use element_kernel::{ElementCells, ElementKernel, ElementLayout, FieldLayout};
pub use error::AssemblyError;
pub use forms_core::contract::Dependence;
pub(crate) use outline::Outline;
pub(crate) use pair_reports::FoundPairs;
pub use pair_reports::RegionPairs;
pub use positive_parts::PositivePart;
pub use sizes::{Counted, Fixed, Sizes};
pub use tangent::ElementMatrix;
pub(crate) use touched::TouchedEntries;

use self::owned_cells::OwnedCells;
use crate::lanes::InstructionSet;
use crate::mesh::Mesh;
use crate::pairs::KnownPairs;
use crate::quadrature::Quadrature;
use crate::threads::Threads;

/// Runs kernels on a mesh with a choice of quadrature.
///
/// A form's unknowns are given as fields, in the order of its arguments; vectors and matrices over
/// several unknowns have them one after the other.
#[derive(Clone, Debug)]
pub struct Assembler<const D: usize> {
    mesh: Arc<Mesh<D>>,
    quadrature: Quadrature<D>,
    instructions: InstructionSet,
    threads: Threads,
    /// The cells whose integrals are assembled, where they are not all.
    owned: Option<Arc<OwnedCells>>,
    /// Contact pairs that were searched for; copies share them.
    known_pairs: Arc<KnownPairs<D>>,
}

impl<'a, const D: usize> From<&'a Assembler<D>> for Cow<'a, Assembler<D>> {
    fn from(assembler: &'a Assembler<D>) -> Self {
        Cow::Borrowed(assembler)
    }
}

impl<const D: usize> From<Assembler<D>> for Cow<'_, Assembler<D>> {
    fn from(assembler: Assembler<D>) -> Self {
        Cow::Owned(assembler)
    }
}

/// Which integrals to assemble, by their dependence on the unknowns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// Loads.
    pub constant: bool,
    /// Integrals whose tangent does not depend on the unknowns.
    pub linear: bool,
    /// All others.
    pub nonlinear: bool,
}

impl Parts {
    /// Every integral.
    pub const ALL: Parts = Parts { constant: true, linear: true, nonlinear: true };
    /// Constant and linear integrals, which an iteration over the unknowns does not change.
    pub const LINEAR_AND_CONSTANT: Parts = Parts { constant: true, linear: true, nonlinear: false };
    /// Nonlinear integrals, which an iteration over the unknowns changes.
    pub const NONLINEAR: Parts = Parts { constant: false, linear: false, nonlinear: true };

    fn contain(self, dependence: Dependence) -> bool {
        match dependence {
            Dependence::Constant => self.constant,
            Dependence::Linear => self.linear,
            Dependence::Nonlinear => self.nonlinear,
        }
    }
}

impl<const D: usize> Assembler<D> {
    /// An assembler that takes the quadrature degree from the compiler's estimate, and all cores.
    pub fn new(mesh: &Arc<Mesh<D>>) -> Self {
        Assembler {
            mesh: mesh.clone(),
            quadrature: Quadrature::Estimated,
            instructions: InstructionSet::best(),
            threads: Threads::all(),
            owned: None,
            known_pairs: Arc::default(),
        }
    }

    /// The same with another choice of quadrature.
    pub fn with_quadrature(self, quadrature: Quadrature<D>) -> Self {
        Assembler { quadrature, ..self }
    }

    /// The same with kernels of a certain set of instructions; of the best that is available where that one is not. Without
    /// this the best set is taken.
    pub fn with_instructions(self, instructions: InstructionSet) -> Self {
        Assembler { instructions, ..self }
    }

    /// The same on another number of threads. Matrices, vectors and numbers are the same to the last bit, whatever
    /// the number (but not for different instruction sets).
    pub fn with_threads(self, threads: Threads) -> Self {
        Assembler { threads, ..self }
    }

    /// Number of threads that it uses.
    pub fn threads(&self) -> Threads {
        self.threads
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh<D>> {
        &self.mesh
    }

    /// The choice of quadrature.
    pub fn quadrature(&self) -> &Quadrature<D> {
        &self.quadrature
    }
}
