//! Nitsche's method with friction at finite strains.

use forms_contact::laws::finite_nitsche as law;
use forms_fem::prelude::*;

use crate::gradients::{Moves, check_law};
use crate::layer::{Answer, Inside, Layer, check_from, plane_layers, solid_layers};
use crate::setting::{Friction, LAMBDA, MU, YOUNG, along, data};

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
        // Cells next to the top would be inverted, were the others at rest.
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
    check_law(
        Moves { wave: 0.05, aside: 0.08, down: 0.1 },
        (model, |law, u, p| law.by_friction(u, p)),
        (model, |law, u, p| law.by_friction(u, p)),
    );
}
