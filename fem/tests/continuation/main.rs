//! Branches of solutions of forms, compared with closed forms: limit points, bifurcations, deflation, adjoint states.

mod adjoint;
mod column;
mod deflation;
mod limit_points;
mod refusals;
mod soft_contact;
