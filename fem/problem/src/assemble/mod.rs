//! Assembly: the loops over cells and facets that run compiled kernels.
//!
//! ```text
//! binding   a form's data against a mesh: regions, fields, parameters checked. Inside: entities (a region's cells or
//!           facets), owned_cells (an assembler of some of the cells), outline (a form without its type), pair_histories, means
//! groups    a region as groups of entities with common tables. Inside: facets, contact pairs and pieces of cut cells and facets
//!           (whose points differ from entity to entity), facets that are split at zeros, means over cells and over own facets, degrees of rules
//! batch     geometry, basis functions and fields at the points of some cells, one per lane
//! element_loops   what a kernel gives for each entity of a range, as matrices and vectors; its node_pairs, reference_tensor and
//!           sum_factorisation: three ways
//! element_kernel   the same on cells that the caller lists; fixed: loops whose lengths are known when compiled
//! block_pattern   the positions of a matrix. Inside: sparsity, block_index (the slots of element matrices), touched entries
//! scatter   from element matrices to the global one. Inside: partition (which thread adds what, in the order of one thread),
//!           own_rows (the rows that a thread adds to), group_nodes, block_positions (to which rows and slots), motion_blocks
//! means_tangent   products of the derivatives of means over own facets
//! residual, tangent, functional, derived   the four loops, one per kind of kernel; action runs the residual's
//! segment_tangent, foot_rates   what a tangent has of points that move with moving segments, and the motion of what they follow
//! segment_energy   what the tangent of an energy has of them besides
//! ```
//!
//! Cells and facets go through the same loops: an exterior facet is an entity with the cell that owns it, an interior one has
//! two sides. The loops know no kernel: they hold its constants, and ask it for a point through one virtual call. Who calls which
//! function of a kernel, on cells and facets alike: of a tangent `cell`, `point`, `test` and `trial` in
//! `element_loops/bilinear_calls.rs`, `pair` and `finish` in `element_loops/node_pairs.rs`; of a residual all in
//! `element_loops/linear_calls.rs`; of functionals and derived fields in `functional.rs`.
//! `element_kernel::fixed` and `element_loops::reference_tensor` call them in the same order.

mod action;
mod batch;
mod binding;
mod block_pattern;
mod cut_bodies;
mod cut_derivative;
mod derived;
mod dual_tangent;
mod element_kernel;
mod element_loops;
mod error;
mod foot_rates;
mod functional;
mod groups;
mod kernels;
mod means_tangent;
pub(crate) mod projection;
mod residual;
mod scatter;
mod segment_columns;
mod segment_energy;
mod segment_tangent;
mod shared_work;
mod tangent;

use std::borrow::Cow;
use std::sync::Arc;

pub use action::TangentAction;
#[doc(hidden)]
pub use binding::outline::Outline;
pub use block_pattern::BlockPattern;
pub(crate) use block_pattern::touched::TouchedEntries;
pub use derived::{FacetSample, PointValues};
pub use element_kernel::sizes::{Counted, Fixed, Sizes};
pub use element_kernel::{ElementCells, ElementKernel, ElementLayout, FieldLayout};
pub use error::{AssemblyError, OtherError};
pub use forms_core::contract::Dependence;
pub(crate) use groups::degrees::degree_on_all_cells;
#[doc(hidden)]
pub use groups::pair_reports::FoundPairs;
pub use groups::pair_reports::RegionPairs;
pub use groups::positive_parts::PositivePart;
pub use kernels::{Lanes, MatrixKernel, PointKernel, VectorKernel};
pub use residual::Terms;
pub use tangent::ElementMatrix;
#[doc(hidden)]
pub use tangent::ValuesBefore;

use self::binding::Binding;
use self::binding::owned_cells::OwnedCells;
use crate::contract::Function;
use crate::cut::Cut;
use crate::field::FieldView;
use crate::lanes::InstructionSet;
use crate::mesh::Mesh;
use crate::pairs::KnownPairs;
use crate::quadrature::Quadrature;
use crate::threads::Threads;

/// A mesh with a choice of quadrature, on which kernels run.
///
/// A form's unknowns are given as fields, in the order of its arguments; vectors and matrices over
/// several unknowns have them one after the other.
#[derive(Clone, Debug)]
pub struct Assembler<const D: usize> {
    mesh: Mesh<D>,
    quadrature: Quadrature<D>,
    instructions: InstructionSet,
    threads: Threads,
    /// The cells whose integrals are assembled, where they are not all.
    owned: Option<Arc<OwnedCells>>,
    /// The body that is cut from the mesh, where it is not all of it.
    cut: Option<Arc<Cut<D>>>,
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

/// The integrals to assemble, by their dependence on the unknowns.
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
    /// A form's data on the mesh, for integrals over the cells that the assembler owns.
    fn bind<'a>(
        &'a self,
        form: &'a Function<D>,
        unknowns: &[FieldView<'a, D>],
    ) -> Result<Binding<'a, D>, AssemblyError> {
        if self.owned.is_none() {
            // Whoever names the cells that are assembled adds up over processes.
            let instead = "write `.on(&part)` in the problem, and `part.functional(..)` for a functional";
            let whole = self.mesh.without_pieces("an integral of one process", instead);
            whole.map_err(|source| AssemblyError::Mesh { form: form.name(), source })?;
        }
        Ok(Binding::new(form, &self.mesh, unknowns)?.assembled_by(self))
    }

    /// An assembler that takes the quadrature degree from the compiler's estimate, and all cores.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// let area = form!(|| -> Functional { integral(cells("all"), 1) });
    /// assert!((Assembler::new(&mesh).functional(&area)? - 2.0).abs() < 1e-14);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(mesh: &Mesh<D>) -> Self {
        Assembler {
            mesh: mesh.clone(),
            quadrature: Quadrature::Estimated,
            instructions: InstructionSet::best(),
            threads: Threads::all(),
            owned: None,
            cut: None,
            known_pairs: Arc::default(),
        }
    }

    /// This assembler with another choice of quadrature.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(6));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_quadrature(self, quadrature: Quadrature<D>) -> Self {
        Assembler { quadrature, ..self }
    }

    /// This assembler with kernels of a certain set of instructions; of the best that is available where that one is not. Without
    /// this the best set is taken.
    pub fn with_instructions(self, instructions: InstructionSet) -> Self {
        Assembler { instructions, ..self }
    }

    /// This assembler on another number of threads. Matrices, vectors and numbers are the same to the last bit, whatever
    /// the number (but not for different instruction sets).
    pub fn with_threads(self, threads: Threads) -> Self {
        Assembler { threads, ..self }
    }

    /// Number of threads that it uses.
    pub fn threads(&self) -> Threads {
        self.threads
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh<D> {
        &self.mesh
    }

    /// The choice of quadrature.
    pub fn quadrature(&self) -> &Quadrature<D> {
        &self.quadrature
    }
}
