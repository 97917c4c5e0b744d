//! Finite elements on several processes: each assembles the integrals over its own cells from the same kernels as one
//! process, PETSc adds up and solves over MPI.
//!
//! What is partitioned: the integrals (residuals, tangents, functionals), the matrix with its factor or hierarchy, the work of
//! the linear solver. What every process has: the mesh, the spaces, the vectors of Newton's method; on a `MeshPart` it has those of
//! its part only.
//!
//! ```no_run
//! # #[cfg(not(feature = "petsc"))]
//! # fn main() {}
//! # #[cfg(feature = "petsc")]
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use forms_distributed::{Method, PetscSolver, World};
//! use forms_fem::prelude::*;
//!
//! let world = World::start()?;
//! let mesh = cuboid([0.0; 3], [1.0; 3], [8; 3], CellShape::Hexahedron, 1)?;
//! let space = Space::scalar(&mesh, 2)?;
//! let poisson = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v)) - v));
//! let mut constraints = Constraints::new(&space);
//! constraints.fix("boundary", |_| 0.0)?;
//! let mut solver = PetscSolver::new(&world, &constraints, Method::conjugate_gradients())?;
//! let solved = Problem::new(&poisson, &space).on(&world).constrained(&constraints).solver(&mut solver).solve()?;
//! # Ok(())
//! # }
//! ```

#![cfg(feature = "petsc")]

pub mod cases;
mod dropped_objects;
mod error;
mod functional;
mod local_matrix;
mod matrix;
mod meeting;
mod method;
mod mpi;
mod node_rows;
mod object;
mod part;
mod petsc;
mod petsc_solver;
mod rows;
mod shared_rows;
mod system;
mod vector;
mod world;

pub use error::{DistributedError, PetscError};
pub use functional::distributed_functional;
pub use meeting::Traffic;
pub use method::{Method, TOLERANCE, UnknownMethod};
pub use part::{MeshPart, PartCheckpoint, StoredCheckpoint};
pub use petsc_solver::{PetscReport, PetscSolver};
pub use world::World;
