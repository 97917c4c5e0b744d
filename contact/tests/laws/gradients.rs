//! Checks of laws of friction with a flat: Taylor tests of tangents, and adjoint gradients against differences.

use forms_contact::ContactProblem;
use forms_contact::law::{WithAdjoint, WithFriction};
use forms_contact::laws::frictional_nitsche::Data;
use forms_fem::contract::Functional;
use forms_fem::prelude::*;

use crate::block::{Block, plane_block, solid_block};
use crate::setting::{Friction, YOUNG, check_tangent, close, data, difference, wave};

/// Displacements of a block.
#[derive(Clone, Copy)]
pub struct Moves {
    /// The amplitude of the displacement at which the tangent is tested.
    pub wave: f64,
    /// Of the top, where the gradient is.
    pub aside: f64,
    pub down: f64,
}

/// Both in the plane and in space: the tangent's order where parts stick, slip and lift off, and dJ/dκ.
pub fn check_law<L2, L3>(
    moves: Moves,
    plane: (impl Fn(Data<2>) -> L2, impl Fn(&L2, &Field<2>, &Field<2>) -> Functional<2>),
    space: (impl Fn(Data<3>) -> L3, impl Fn(&L3, &Field<3>, &Field<3>) -> Functional<3>),
) where
    L2: WithFriction<2> + WithAdjoint<2>,
    L3: WithFriction<3> + WithAdjoint<3>,
{
    check(&plane_block(4), moves, plane);
    check(&solid_block(), moves, space);
}

fn check<L, const D: usize>(
    block: &Block<D>,
    moves: Moves,
    (law, by_friction): (impl Fn(Data<D>) -> L, impl Fn(&L, &Field<D>, &Field<D>) -> Functional<D>),
) where
    L: WithFriction<D> + WithAdjoint<D>,
    Dim: Dimension<D>,
{
    for friction in [Friction::Coulomb(0.6), Friction::Tresca(20.0)] {
        let problem = block.problem(law(data(friction, 0.0, 10.0 * YOUNG)), 0.0, 0.0);
        let (u, direction) = (wave(&block.space, moves.wave, 0.4), wave(&block.space, moves.wave, 2.3));
        let form = problem.law.direct();
        check_tangent(&format!("{D}D, {friction:?}"), &problem.assembler, &form, &[&u], &[&direction]);
    }
    let solve = |coefficient: f64| -> (ContactProblem<D, L>, Field<D>) {
        let law = law(data(Friction::Coulomb(coefficient), 0.0, 20.0 * YOUNG));
        let problem = block.problem(law, moves.aside, moves.down);
        let solved = problem.from_stick().unwrap().solve().unwrap();
        (problem, solved.into_field())
    };
    let (problem, u) = solve(0.3);
    let p = problem.adjoint(&u).unwrap().solve().unwrap().into_field();
    let gradient = problem.assembler.functional(&by_friction(&problem.law, &u, &p)).unwrap();
    let found = difference(6e-5, |change| {
        let (problem, u) = solve(0.3 + change);
        Ok((problem.criterion(&u)?, problem.assembler.active_set(&problem.law.direct(), &[&u])?))
    });
    close(&format!("{D}D"), gradient, found, 1e-8);
}
