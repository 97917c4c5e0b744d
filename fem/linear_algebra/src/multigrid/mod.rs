//! Multigrid for matrices of blocks: given transfers first (from degree 2 to degree 1, say), then aggregation.

mod aggregation;
mod chebyshev;
mod counted;
mod diagonal;
mod hierarchy;
mod tentative;

pub use chebyshev::Chebyshev;
pub use diagonal::BlockDiagonal;
pub use hierarchy::{LevelReport, Multigrid, MultigridOptions};
