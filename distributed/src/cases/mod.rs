//! Problems on which several processes are compared with one.

pub mod adaptive;
pub mod adaptive_contact;
pub mod ball_on_flat;
pub mod divided_contact;
pub mod drawn_block;
pub mod eigenmodes;
pub mod facets_between;
pub mod field_controls;
pub mod hanging_block;
pub mod histories;
pub mod mixed_block;
pub mod mortar_block;
pub mod motions;
pub mod pair_histories;
pub mod part_adaptivity;
pub mod part_steps;
pub mod parts;
pub mod poisson;
pub mod report;
pub mod whole_body;
