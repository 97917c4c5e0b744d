//! (41), the extended adjoint: matrix and right side (with N′ on Γ_C) against plain loops, and its symmetry.

use forms_fem::prelude::*;
use forms_tests::adjoint_form::check_adjoint;
use forms_tests::bodies::{Body, data, plane_bodies, solid_bodies};
use forms_tests::contact_by_loops::ByLoops;
use forms_tests::dense::deviation;

fn against_loops<const D: usize>(body: &Body<D>)
where
    Dim: Dimension<D>,
{
    for theta in [-1.0, 0.0, 1.0] {
        let form = body.extended_adjoint(&data(theta));
        let loops = ByLoops::new(body, theta);
        // ξ takes some points out of contact, not all.
        let [active, extended, _] = loops.points;
        assert!(0 < extended && extended < active, "{}: {extended} of {active}", body.name);
        let side = check_adjoint(body, theta, &form, &loops.extended, &loops.extended_side);
        // N′_n on Γ_C makes a right side of its own.
        assert!(deviation(&side, loops.discrete_side.as_slice()) > 1e-3, "{}, theta = {theta}", body.name);
    }
}

#[test]
fn matrix_and_right_side_are_those_of_plain_loops() {
    plane_bodies().iter().for_each(against_loops);
    solid_bodies().iter().for_each(against_loops);
}
