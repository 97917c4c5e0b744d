//! Formulations of contact compared on problems with known answers.
//!
//! A [`Problem`] is a file that knows no formulation: meshes, materials, loads, closed forms. A [`Formulation`] is a file that knows no problem: its
//! form, or a law of the library, and a driver. [`program`] runs each on each, and writes a table, JSON and plots.
//!
//! A formulation of your own is a program of one file: implement [`Formulation`], and call `contact_bench::program(&[&MyFormulation])` in `main`.

mod at_once;
pub mod balance;
pub mod body;
pub mod case;
pub mod cut_body;
pub mod filled;
pub mod formulation;
pub mod gradient;
pub mod membrane;
pub mod options;
pub mod others;
pub mod outcome;
pub mod plots;
pub mod posed;
pub mod problem;
pub mod problems;
pub mod rows;
pub mod rubber;
pub mod run;
pub mod sliding;
pub mod solution;
pub mod table;
pub mod two_bodies;

pub use case::{Case, Contact, Sides};
pub use cut_body::CutBody;
pub use filled::{Filled, Step};
pub use formulation::{Formulation, Meshing};
pub use membrane::{Membrane, volume};
pub use outcome::{Outcome, Pressures, Refusal};
pub use posed::Posed;
pub use problem::{Problem, Quantity};
pub use rubber::{Pressed, Rubber};
pub use run::program;
pub use sliding::{Slid, Sliding};
pub use two_bodies::{AfterLoad, TwoBodies};
