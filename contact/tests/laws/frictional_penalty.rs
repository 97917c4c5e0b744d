//! The penalty method with friction.

use forms_contact::laws::frictional_penalty as law;
use forms_fem::prelude::*;

use crate::gradients::{Moves, check_law};
use crate::layer::{Answer, Inside, Layer, check, plane_layers, solid_layers};
use crate::setting::{Friction, LAMBDA, MU, YOUNG, data};

fn model<const D: usize>(data: law::Data<D>) -> law::Model<D> {
    law::Model { data, regions: law::Regions::default().gamma_n("right").gamma_c("bottom") }
}

/// Springs of stiffness γ in series with the layer: p (H/(λ + 2μ) + 1/γ) = δ, and τ (H/μ + 1/γ) = U while it sticks, where the
/// flat's points move by τ/γ.
fn layers<const D: usize>(layer: &Layer<D>)
where
    Dim: Dimension<D>,
{
    // All cells have one diameter.
    let gamma = 20.0 * YOUNG / layer.mesh.diameter(0);
    let pressure = 0.01 / (1.0 / (LAMBDA + 2.0 * MU) + 1.0 / gamma);
    let bound = 0.3 * pressure;
    for friction in [Friction::Coulomb(0.3), Friction::Tresca(bound)] {
        let label = format!("{D}D, {friction:?}");
        let data = data(friction, 0.0, 20.0 * YOUNG);
        let shear = 0.009 / (1.0 / MU + 1.0 / gamma);
        let sticks = Answer { pressure, shear, slip: shear / gamma };
        assert!(shear < bound);
        check(&label, layer, model(data.clone()), [0.009, 0.01], sticks, 1e-12);
        let slips = Answer { pressure, shear: bound, slip: 0.02 - bound / MU };
        check(&label, layer, model(data), [0.02, 0.01], slips, 1e-12);
    }
}

#[test]
fn a_layer_sticks_and_slips_as_known() {
    plane_layers(Inside::Alike).iter().for_each(layers);
    solid_layers(Inside::Alike).iter().for_each(layers);
}

#[test]
fn tangents_and_adjoint_gradients() {
    check_law(
        Moves { wave: 0.02, aside: 0.008, down: 0.01 },
        (model, |law, u, p| law.by_friction(u, p)),
        (model, |law, u, p| law.by_friction(u, p)),
    );
}
