//! The cycle of adaptivity: solve, estimate, mark, refine.

use std::fmt;

use thiserror::Error;

use super::ErrorEstimate;
use crate::field::Field;
use crate::mesh::{AdaptiveMesh, MarkingError, Mesh, MeshError, Surface, doerfler};

/// Unknowns beyond which a tolerance is given up where nothing else is said.
const MOST_UNKNOWNS: usize = 1_000_000;

/// The end that a cycle works towards.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Aim {
    /// |η| within a tolerance, with no more unknowns than these.
    Tolerance { tolerance: f64, most_unknowns: usize },
    /// The first mesh with as many unknowns.
    Unknowns(usize),
}

/// A cycle of adaptivity: how cells are marked, and when it ends. Cells are divided where Dörfler's rule ([`doerfler`]) marks them:
/// triangles and tetrahedra by bisection, quadrilaterals and hexahedra by trees ([`AdaptiveMesh`]); then nodes hang, and spaces are made
/// continuous by [`Constraints::join_hanging_nodes`](crate::constraints::Constraints::join_hanging_nodes).
///
/// ```
/// use forms_fem::adaptivity::{Adaptation, AdaptiveSolution, ErrorEstimate};
/// use forms_fem::prelude::*;
///
/// #[forms]
/// mod heat {
///     #[cells]
///     pub struct Omega;
///     #[interior_facets]
///     pub struct Interior;
///     pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
///         integral(Omega, dot(grad(u), grad(v)) - v)
///     }
///     /// η_T² = h²‖1 + Δu‖² + h‖½⟦∂u/∂n⟧‖².
///     pub fn residual(u: State<Scalar>, q: Test<Scalar>) -> Form {
///         integral(Omega, sqr(h) * sqr(1 + tr(hess(u))) * q)
///             + integral(Interior, avg(h) * sqr(dot(jump(grad(u)), n)) / 2 * avg(q))
///     }
/// }
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let coarse = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Triangle, 1)?;
/// let solve = |mesh: &Mesh<2>, before: Option<&Field<2>>| -> Result<_, Box<dyn std::error::Error>> {
///     let space = Space::scalar(mesh, 1)?;
///     let mut constraints = Constraints::new(&space);
///     constraints.fix("boundary", |_| 0.0)?;
///     // A nonlinear problem begins where the one before has ended.
///     let start = before.map_or(Ok(Field::zero(&space)), |before| before.onto(&space).interpolated())?;
///     let model = heat::Model::default();
///     let form = model.balance();
///     let u = Problem::new(&form, &space).constrained(&constraints).start(&start).solve()?.into_field();
///     let estimate = ErrorEstimate::residual(&Assembler::new(mesh), &model.residual(&u))?;
///     Ok(AdaptiveSolution::new(u, estimate))
/// };
/// let adapted = Adaptation::to_tolerance(0.1).run(coarse, solve, |step| println!("{step}"))?;
/// assert!(adapted.solution.estimate.value() <= 0.1);
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub struct Adaptation<'a, const D: usize> {
    aim: Aim,
    fraction: f64,
    surfaces: &'a [Surface<'a, D>],
}

/// Results of one mesh.
#[derive(Clone, Debug)]
pub struct AdaptiveSolution<const D: usize> {
    /// The solution.
    pub field: Field<D>,
    /// Its estimated error.
    pub estimate: ErrorEstimate,
    /// The goal J(u_h), where there is one.
    pub goal: Option<f64>,
    /// Cells that are divided whatever the estimate.
    pub divided: Vec<u32>,
}

impl<const D: usize> AdaptiveSolution<D> {
    /// A solution with the estimate of its error.
    pub fn new(field: Field<D>, estimate: ErrorEstimate) -> Self {
        AdaptiveSolution { field, estimate, goal: None, divided: vec![] }
    }

    /// This solution with cells that are divided whatever the estimate, such as those of an interface that are too large
    /// ([`InterfaceBand::large_cells`](super::InterfaceBand::large_cells)). While there are any the tolerance does not end the cycle.
    pub fn dividing(self, cells: Vec<u32>) -> Self {
        AdaptiveSolution { divided: cells, ..self }
    }

    /// This solution with the value of the goal, for the table.
    pub fn with_goal(self, goal: f64) -> Self {
        AdaptiveSolution { goal: Some(goal), ..self }
    }
}

/// A row of the cycle's table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptiveStep {
    /// Number of the mesh, from 0.
    pub number: usize,
    /// Cells of the mesh.
    pub cells: usize,
    /// Unknowns of the solution, prescribed ones among them.
    pub unknowns: usize,
    /// J(u_h), where there is a goal.
    pub goal: Option<f64>,
    /// The estimated error η.
    pub estimate: f64,
}

impl fmt::Display for AdaptiveStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let AdaptiveStep { number, cells, unknowns, goal, estimate } = self;
        write!(f, "mesh {number}: {cells} cells, {unknowns} unknowns, ")?;
        if let Some(goal) = goal {
            write!(f, "goal {goal:.10}, ")?;
        }
        write!(f, "estimated error {estimate:.3e}")
    }
}

/// The last mesh of a cycle and the results on it.
#[derive(Clone, Debug)]
pub struct Adapted<const D: usize> {
    /// The mesh, to go on with.
    pub mesh: AdaptiveMesh<D>,
    /// The solution.
    pub solution: AdaptiveSolution<D>,
    /// One row for each mesh.
    pub steps: Vec<AdaptiveStep>,
}

/// Errors of a cycle of adaptivity, with E those of the user's solution.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs)]
pub enum AdaptationError<E: fmt::Display> {
    /// A tolerance that cannot be reached by any estimate.
    #[error("the tolerance {tolerance} is not above zero")]
    Tolerance { tolerance: f64 },
    /// The problem on one of the meshes was not solved.
    #[error("mesh {number} of {cells} cells: {reason}")]
    Solution {
        /// Number of the mesh, from 0.
        number: usize,
        /// Cells of the mesh.
        cells: usize,
        reason: Box<E>,
    },
    /// An estimate that is not a number.
    #[error("mesh {number}: the estimated error is {value}")]
    Estimate {
        /// Number of the mesh, from 0.
        number: usize,
        /// The estimate.
        value: f64,
    },
    /// A solution on another mesh, or an estimate with another number of cells, than the cycle's.
    #[error("mesh {number} has {cells} cells; the solution or its estimate belongs to another mesh")]
    OtherMesh {
        /// Number of the mesh, from 0.
        number: usize,
        /// Cells of the mesh.
        cells: usize,
    },
    /// No cell has a share in the error.
    #[error("mesh {number}: all indicators are zero, so that no cell can be marked")]
    NothingToMark {
        /// Number of the mesh, from 0.
        number: usize,
    },
    /// The tolerance was not reached.
    #[error(
        "the estimated error is {estimate:e} with {unknowns} unknowns, beyond the {most} allowed; the tolerance is {tolerance:e}"
    )]
    TooManyUnknowns {
        /// The estimated error on the last mesh.
        estimate: f64,
        unknowns: usize,
        /// Unknowns allowed.
        most: usize,
        tolerance: f64,
    },
    /// Indicators or a fraction by which nothing can be marked.
    #[error(transparent)]
    Marking(#[from] MarkingError),
    /// A mesh that cannot be refined.
    #[error(transparent)]
    Mesh(#[from] MeshError),
}

impl<'a, const D: usize> Adaptation<'a, D> {
    /// A cycle that ends on the first mesh with |η| within the tolerance; more than 10⁶ unknowns, or than
    /// [`Adaptation::with_at_most`] says, are an error.
    pub fn to_tolerance(tolerance: f64) -> Self {
        Adaptation::towards(Aim::Tolerance { tolerance, most_unknowns: MOST_UNKNOWNS })
    }

    /// A cycle that ends on the first mesh with at least the given number of unknowns, whatever the estimate: for studies of convergence.
    pub fn to_unknowns(count: usize) -> Self {
        Adaptation::towards(Aim::Unknowns(count))
    }

    fn towards(aim: Aim) -> Self {
        Adaptation { aim, fraction: 0.5, surfaces: &[] }
    }

    /// The largest number of unknowns, at which the cycle ends without its tolerance.
    pub fn with_at_most(mut self, unknowns: usize) -> Self {
        if let Aim::Tolerance { most_unknowns, .. } = &mut self.aim {
            *most_unknowns = unknowns;
        }
        self
    }

    /// Fraction of the sum of all indicators that the marked cells have; by default one half.
    pub fn marking(mut self, fraction: f64) -> Self {
        self.fraction = fraction;
        self
    }

    /// Curved boundaries on which new nodes are placed, as [`AdaptiveMesh::refined_onto`] does.
    pub fn onto(mut self, surfaces: &'a [Surface<'a, D>]) -> Self {
        self.surfaces = surfaces;
        self
    }

    /// The cycle from a coarse mesh. `solve` is given the mesh and the solution on the mesh before, which
    /// [`Field::onto`] carries over; `progress` each row of the table as it is known.
    ///
    /// # Errors
    /// [`AdaptationError`]: what `solve` reports, with the mesh; a tolerance that was not reached.
    pub fn run<E: fmt::Display>(
        &self,
        coarse: Mesh<D>,
        mut solve: impl FnMut(&Mesh<D>, Option<&Field<D>>) -> Result<AdaptiveSolution<D>, E>,
        mut progress: impl FnMut(&AdaptiveStep),
    ) -> Result<Adapted<D>, AdaptationError<E>> {
        if let Aim::Tolerance { tolerance, .. } = self.aim
            && (tolerance.is_nan() || tolerance <= 0.0)
        {
            return Err(AdaptationError::Tolerance { tolerance });
        }
        let mut mesh = AdaptiveMesh::new(coarse)?;
        let mut before: Option<Field<D>> = None;
        let mut steps = vec![];
        loop {
            let (number, cells) = (steps.len(), mesh.mesh().cell_count());
            let solution = solve(mesh.mesh(), before.as_ref())
                .map_err(|reason| AdaptationError::Solution { number, cells, reason: Box::new(reason) })?;
            let estimate = solution.estimate.value();
            let own_mesh = solution.field.space().mesh().is_same(mesh.mesh());
            if !own_mesh || solution.estimate.indicators().len() != cells {
                return Err(AdaptationError::OtherMesh { number, cells });
            }
            if !estimate.is_finite() {
                return Err(AdaptationError::Estimate { number, value: estimate });
            }
            let unknowns = solution.field.space().unknowns();
            let step = AdaptiveStep { number, cells, unknowns, goal: solution.goal, estimate };
            progress(&step);
            steps.push(step);
            match self.aim {
                Aim::Tolerance { tolerance, .. }
                    if estimate.abs() <= tolerance && solution.divided.is_empty() =>
                {
                    return Ok(Adapted { mesh, solution, steps });
                }
                Aim::Unknowns(count) if unknowns >= count => return Ok(Adapted { mesh, solution, steps }),
                Aim::Tolerance { tolerance, most_unknowns: most } if unknowns > most => {
                    return Err(AdaptationError::TooManyUnknowns { estimate, unknowns, most, tolerance });
                }
                Aim::Tolerance { .. } | Aim::Unknowns(_) => {}
            }
            let mut marked = doerfler(solution.estimate.indicators(), self.fraction)?;
            marked.extend_from_slice(&solution.divided);
            if marked.is_empty() {
                return Err(AdaptationError::NothingToMark { number });
            }
            mesh = mesh.refined_onto(&marked, self.surfaces)?.0;
            before = Some(solution.field);
        }
    }
}
