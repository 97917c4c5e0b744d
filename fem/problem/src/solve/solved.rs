//! A solution: fields, history, reactions, and what is computed from them.

mod at_bounds;

use std::sync::Arc;

pub(super) use self::at_bounds::AtBounds;
use crate::contract::{Expression, Functional};
use thiserror::Error;

use super::{NewtonStep, SolverReport};
use crate::assemble::{Assembler, AssemblyError, PointValues, RegionPairs};
use crate::dimension::{Dim, Dimension};
use crate::field::Field;
use crate::instantiate::instantiate;
use crate::mesh::MeshError;
use crate::space::Space;

/// A solution of a [`Problem`](super::Problem) with N unknowns.
#[derive(Clone, Debug)]
pub struct Solved<const D: usize, const N: usize = 1> {
    /// The unknowns, in the order of the form's arguments.
    pub fields: [Field<D>; N],
    /// The start and each iterate; of an affine problem the one system that was solved.
    pub history: Vec<NewtonStep>,
    /// R(u) on all unknowns, space after space: reactions where values are prescribed, about zero elsewhere.
    pub residual: Vec<f64>,
    /// Account of the linear solver since it was made, where it keeps one.
    pub report: Option<SolverReport>,
    /// Seconds spent in assembly for this problem so far.
    pub assembly_seconds: f64,
    /// Seconds of this solution in all.
    pub seconds: f64,
    /// The contact pairs at the solution, in numbers: open points, gaps, overlaps; and pairings without contact pairs, which
    /// [`Solved::notes`] puts into words.
    pub pairs: Vec<RegionPairs<D>>,
    pub(super) at_bounds: AtBounds<D, N>,
    pub(super) assembler: Assembler<D>,
    /// Those of [`Problem::with_notes`](super::Problem::with_notes).
    pub(super) remarks: Vec<String>,
}

/// A reaction that does not exist.
#[derive(Debug, Error)]
#[allow(missing_docs)]
pub enum ReactionError {
    /// No such region.
    #[error(transparent)]
    Region(#[from] MeshError),
    /// An unknown that is no displacement.
    #[error("forces on an unknown of {components} components have no moment: it takes a displacement")]
    NoMoment {
        /// Components of the unknown.
        components: usize,
    },
    /// No such unknown.
    #[error("there is no unknown {number}; the problem has {count} (numbered from 0)")]
    Unknown { number: usize, count: usize },
}

impl<const D: usize, const N: usize> Solved<D, N> {
    /// Number of Newton steps; 1 of an affine problem.
    pub fn iterations(&self) -> usize {
        self.history.len().saturating_sub(1)
    }

    /// Remarks on the solution: surfaces that may touch, but whose points have no opposite one. Bodies that come together later
    /// begin so; a surface that is turned away, or beyond the reach, would stay so, and the bodies pass through each other. And integrals
    /// over contact pairs whose rule has the compiler's estimate for its degree, where that is above 20. Unknowns at bounds that do not act on them. Last, what whoever made the
    /// problem has to say ([`Problem::with_notes`](super::Problem::with_notes)), as contact problems of a γ₀ that is too small.
    pub fn notes(&self) -> Vec<String> {
        let of_pairs =
            self.pairs.iter().flat_map(|pairs| [pairs.note(), pairs.note_on_quadrature()]).flatten();
        of_pairs.chain(self.at_bounds.remark.clone()).chain(self.remarks.iter().cloned()).collect()
    }

    /// The assembler that the problem was solved with, for all that is asked of the solution in other ways.
    pub fn assembler(&self) -> &Assembler<D> {
        &self.assembler
    }

    /// The value of a functional, with the quadrature that the problem was solved with. After [`Problem::on`](super::Problem::on) several
    /// processes it is integrated over all cells on each process that asks, without an exchange.
    ///
    /// # Errors
    /// As [`Assembler::functional`].
    pub fn functional(&self, functional: &Functional<D>) -> Result<f64, AssemblyError> {
        self.assembler.functional(functional)
    }

    /// A derived quantity at points of the domain.
    ///
    /// # Errors
    /// As [`Assembler::at_points`].
    pub fn at_points(
        &self,
        expression: &Expression<D>,
        points: &[[f64; D]],
    ) -> Result<PointValues<D>, AssemblyError> {
        self.assembler.at_points(expression, points)
    }

    /// A derived quantity as a field on a space, by projection.
    ///
    /// # Errors
    /// As [`Assembler::project`].
    pub fn project(
        &self,
        expression: &Expression<D>,
        space: &Arc<Space<D>>,
    ) -> Result<Field<D>, AssemblyError>
    where
        Dim: Dimension<D>,
    {
        self.assembler.project(expression, space)
    }

    /// The resultant of the forces by which the constraints of an unknown hold the nodes of a facet or cell region, one
    /// number per component \[the form's residual: force, or force per depth in the plane; of a scalar unknown, flux\]:
    /// ΣR(u) over these nodes. Where values are prescribed these are the supports' forces on the body; where unknowns are
    /// related, as by sliding, periodic conditions or a rigid body, they are the forces that keep the relations. The load
    /// on free nodes is balanced there, and contact in the form is no constraint: neither counts.
    ///
    /// A node on the edge of two regions counts in both: over the whole boundary the forces of supports balance the loads.
    ///
    /// # Errors
    /// [`ReactionError::Region`], [`ReactionError::Unknown`].
    pub fn reaction_of(&self, unknown: usize, region: &str) -> Result<Vec<f64>, ReactionError> {
        let field = self.fields.get(unknown).ok_or(ReactionError::Unknown { number: unknown, count: N })?;
        let offset = self.fields[..unknown].iter().map(|field| field.values().len()).sum();
        resultant(field.space(), &self.residual[offset..], region)
    }
}

impl<const D: usize> Solved<D, 1> {
    /// The unknown.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// # let mut held = Constraints::new(&space);
    /// # held.fix("boundary", |_| 0.0)?;
    /// # let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v)) - v));
    /// let solved = Problem::new(&form, &space).constrained(&held).solve()?;
    /// let mean = form!(|u: State<Scalar>| -> Functional { integral(cells("all"), u) / 2 });
    /// println!("{}", solved.functional(&mean(solved.field()))?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn field(&self) -> &Field<D> {
        &self.fields[0]
    }

    /// The unknown, without the rest of the solution.
    ///
    /// ```
    /// # use forms_fem::prelude::*;
    /// # let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 2], CellShape::Triangle, 1)?;
    /// # let space = Space::scalar(&mesh, 1)?;
    /// # let mut held = Constraints::new(&space);
    /// # held.fix("boundary", |_| 0.0)?;
    /// # let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v)) - v));
    /// let u = Problem::new(&form, &space).constrained(&held).solve()?.into_field();
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn into_field(self) -> Field<D> {
        let [field] = self.fields;
        field
    }

    /// [`Solved::reaction_of`] the only unknown.
    ///
    /// # Errors
    /// [`ReactionError::Region`].
    pub fn reaction(&self, region: &str) -> Result<Vec<f64>, ReactionError> {
        self.reaction_of(0, region)
    }

    /// The moment of the same forces about a point, where they act: Σ (x + u − about) × R(u) over the nodes of a region, one number in the
    /// plane (counter-clockwise), three in space \[force × length\]. Of a rigid surface it is that of the forces which hold the tool.
    ///
    /// # Errors
    /// [`ReactionError::Region`]; [`ReactionError::NoMoment`] where the unknown is no vector of D components.
    #[inline(never)]
    pub fn reaction_moment(&self, region: &str, about: [f64; D]) -> Result<Vec<f64>, ReactionError> {
        let (field, space) = (self.field(), self.field().space());
        if space.shape() != [D] {
            return Err(ReactionError::NoMoment { components: space.components() });
        }
        space.mesh().without_pieces("the moment of a reaction", crate::mesh::TAKE_THE_WHOLE)?;
        let axes: &[[usize; 2]] = if D == 2 { &[[0, 1]] } else { &[[1, 2], [2, 0], [0, 1]] };
        let mut moment = vec![0.0; axes.len()];
        for node in space.nodes_on(region)? {
            let (x, u) = (space.positions()[node as usize], field.at_node(node as usize));
            let force = &self.residual[node as usize * D..][..D];
            for (moment, [i, j]) in moment.iter_mut().zip(axes) {
                let arm = |k: usize| x[k] + u[k] - about[k];
                *moment += arm(*i) * force[*j] - arm(*j) * force[*i];
            }
        }
        Ok(moment)
    }
}

/// The sum of a space's part of a residual over the nodes of a region, one number per component.
///
/// # Errors
/// [`ReactionError`]: the mesh has no such region.
#[doc(hidden)]
pub fn resultant<const D: usize>(
    space: &Arc<Space<D>>,
    residual: &[f64],
    region: &str,
) -> Result<Vec<f64>, ReactionError> {
    let components = space.components();
    space.mesh().without_pieces("a reaction of one process", "call `part.reaction(..)`")?;
    let mut sums = vec![0.0; components];
    for node in space.nodes_on(region)? {
        let at_node = &residual[node as usize * components..][..components];
        sums.iter_mut().zip(at_node).for_each(|(sum, value)| *sum += value);
    }
    Ok(sums)
}

instantiate!(solved: Solved::<D, 1>::reaction_moment);
