//! Element kernels and assembly compared with other programs: a basket of forms, and what compares them.

pub mod assembly;
pub mod basix;
pub mod basket;
pub mod beside_petsc;
pub mod bodies;
pub mod comparison;
pub mod element_batch;
pub mod forms;
pub mod plugin;
pub mod random_cells;
pub mod register;
