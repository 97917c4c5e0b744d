//! Elements times scopes: what each space holds, its orders, stable pairs, locking, refusals.

mod bernstein;
mod bodies;
mod crouzeix_raviart;
mod dual;
mod incomplete_cells;
mod inf_sup;
mod linear_in_space;
mod local_unknowns;
mod locking;
mod mini;
mod own;
mod pairs;
mod points;
mod serendipity;
mod shared;
mod uniform_pressure;
