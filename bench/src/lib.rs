//! Element kernels and assembly beside other programs: a basket of forms, and what compares them.

pub mod basix;
