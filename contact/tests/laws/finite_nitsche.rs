//! Nitsche's method with friction at finite strains.

use forms_contact::laws::finite_nitsche::finite_nitsche as law;
use forms_fem::prelude::*;

use crate::block::{Block, plane_block, solid_block};
use crate::layer::{Answer, Inside, Layer, check_from, plane_layers, solid_layers};
use crate::setting::{Friction, LAMBDA, MU, YOUNG, along, check_tangent, close, data, difference, wave};

fn model<const D: usize>(data: law::Data<D>) -> law::Model<D> {
    law::Model { data, regions: law::Regions::default().gamma_n("right").gamma_c("bottom") }
}

/// F = [[1, k], [0, J]]: p = μ (1/J − J) − λ ln J/J whatever k, and the shear stress is μ k up to κp.
fn layers<const D: usize>(layer: &Layer<D>)
where
    Dim: Dimension<D>,
{
    let volume: f64 = 0.8;
    let pressure = MU * (1.0 / volume - volume) - LAMBDA * volume.ln() / volume;
    let bound = 0.3 * pressure;
    let most = bound / MU;
    assert!((pressure - 66.799_55).abs() < 1e-5 && (most - 0.260_518).abs() < 1e-6, "{pressure} {most}");
    for friction in [Friction::Coulomb(0.3), Friction::Tresca(bound)] {
        let label = format!("{D}D, {friction:?}");
        let data = data(friction, 0.0, 20.0 * YOUNG);
        // Cells beside the top would be inverted, were the others at rest.
        let start = Field::interpolate(&layer.space, |x| along::<D>(D - 1, -0.2 * x[D - 1])).unwrap();
        let sticks = Answer { pressure, shear: 0.2 * MU, slip: 0.0 };
        check_from(&label, layer, model(data.clone()), [0.2, 0.2], &start, sticks, 1e-10);
        let slips = Answer { pressure, shear: bound, slip: 0.4 - most };
        check_from(&label, layer, model(data), [0.4, 0.2], &start, slips, 1e-10);
    }
}

#[test]
fn a_layer_sticks_and_slips_as_known() {
    plane_layers(Inside::Distorted).iter().for_each(layers);
    solid_layers(Inside::Distorted).iter().for_each(layers);
}

#[test]
fn tangents_and_adjoint_gradients() {
    fn check<const D: usize>(block: &Block<D>)
    where
        Dim: Dimension<D>,
    {
        for friction in [Friction::Coulomb(0.6), Friction::Tresca(20.0)] {
            let problem = block.problem(model(data(friction, 0.0, 10.0 * YOUNG)), 0.0, 0.0);
            let (u, direction) = (wave(&block.space, 0.05, 0.4), wave(&block.space, 0.05, 2.3));
            let form = problem.law.direct();
            check_tangent(&format!("{D}D, {friction:?}"), &problem.assembler, &form, &[&u], &[&direction]);
        }
        let solve = |coefficient: f64| {
            let data = data(Friction::Coulomb(coefficient), 0.0, 20.0 * YOUNG);
            let problem = block.problem(model(data), 0.08, 0.1);
            let zero = Field::zero(&block.space);
            let solved = problem.solve_from_stick(&zero, &mut TangentSolver::default(), |_| ()).unwrap();
            (problem, solved.into_field())
        };
        let (problem, u) = solve(0.3);
        let p = problem.adjoint(&u).unwrap().solve().unwrap().into_field();
        let gradient = problem.assembler.functional(&problem.law.by_friction(&u, &p)).unwrap();
        let found = difference(6e-5, |change| {
            let (problem, u) = solve(0.3 + change);
            Ok((problem.criterion(&u)?, problem.assembler.active_set(&problem.law.direct(), &[&u])?))
        });
        close(&format!("{D}D"), gradient, found, 1e-8);
    }
    check(&plane_block(4));
    check(&solid_block());
}
