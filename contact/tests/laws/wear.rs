//! Wear of a layer under a given displacement, compared with its own recursion and with the exponential that it tends to with
//! shorter steps; tangents.

use forms_contact::laws::frictional_nitsche as flat;
use forms_contact::laws::wear as law;
use forms_fem::prelude::*;

use crate::block::{Block, plane_block, solid_block};
use crate::layer::{Inside, Layer, plane_layers, solid_layers};
use crate::setting::{Friction, LAMBDA, MU, THETAS, YOUNG, along, check_tangent, data, wave};

/// k_w \[1/stress\].
const RATE: f64 = 2e-4;
/// Depth to which the top is moved down.
const DOWN: f64 = 0.01;
/// Stiffness of the layer of height 1.
const STIFFNESS: f64 = LAMBDA + 2.0 * MU;

fn model<const D: usize>(base: flat::Data<D>, worn: History<f64, D>) -> law::Model<D> {
    let data = law::data_from(base).wear_rate(RATE).worn(worn);
    law::Model { data, regions: law::Regions::default().gamma_n("right").gamma_c("bottom") }
}

/// The worn depths of all points after each of some steps of equal length, κ and θ given.
fn worn<const D: usize>(layer: &Layer<D>, friction: f64, theta: f64, length: f64, steps: usize) -> Vec<f64>
where
    Dim: Dimension<D>,
{
    let assembler = Assembler::new(&layer.mesh).with_quadrature(Quadrature::Degree(4));
    let depth = assembler.history(Entity::Facets, "bottom", 4, 0.0).unwrap();
    let law = model(data(Friction::Coulomb(friction), theta, 20.0 * YOUNG), depth);
    let mut problem = layer.problem(law, 0.0, DOWN);
    // The obstacle slides along the first axis.
    problem.law.data.sliding = Given::constant(along(0, length / steps as f64));
    let mut u = Field::zero(&layer.space);
    let mut depths = vec![];
    for _ in 0..steps {
        problem.law.data.displacement_before = Given::field(&u);
        let solved = problem.direct().unwrap().start(&u).solve().unwrap();
        u = solved.into_field();
        let worn = &problem.law.data.worn;
        problem.assembler.update_history(&problem.law.worn_after(&u), worn).unwrap();
        worn.commit();
        let values = problem.assembler.history_values(worn).unwrap().concat();
        let (least, most) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), w| (a.min(*w), b.max(*w)));
        assert!(most - least < 1e-10 * DOWN, "wear is even: {least}, {most}");
        let volume = problem.assembler.functional(&problem.law.worn_volume()).unwrap();
        assert!((volume - most * layer.area()).abs() < 1e-10 * DOWN * layer.area());
        depths.push(most);
    }
    depths
}

/// p = M (δ − w)/H, and friction drags the base along by κ p H/μ: w ← w + k_w p (ΔS − κ (H/μ) Δp).
fn recursion(friction: f64, length: f64, steps: usize) -> Vec<f64> {
    let (mut worn, mut dragged) = (0.0, 0.0);
    let step = |_| {
        let pressure = STIFFNESS * (DOWN - worn);
        let now = friction * pressure / MU;
        worn += RATE * pressure * (length / steps as f64 - (now - dragged));
        dragged = now;
        worn
    };
    (0..steps).map(step).collect()
}

fn follows_recursion<const D: usize>(layer: &Layer<D>, thetas: &[f64])
where
    Dim: Dimension<D>,
{
    for &theta in thetas {
        for friction in [0.0, 0.3] {
            let found = worn(layer, friction, theta, 12.0, 6);
            for (found, expected) in found.iter().zip(recursion(friction, 12.0, 6)) {
                let error = (found - expected) / DOWN;
                assert!(error.abs() < 1e-10, "{D}D, theta = {theta}: {found} is not {expected}");
            }
        }
    }
}

#[test]
fn a_layer_wears_by_the_schemes_own_recursion() {
    plane_layers(Inside::Distorted).iter().for_each(|layer| follows_recursion(layer, &THETAS));
    follows_recursion(&solid_layers(Inside::Distorted)[0], &[0.0]);
}

/// dw/dS = k_w M (δ − w)/H without friction: w = δ (1 − exp(−k_w M S/H)).
#[test]
fn shorter_steps_come_to_the_exponential_in_first_order() {
    let layer = &plane_layers(Inside::Distorted)[0];
    let length = 20.0;
    let exact = DOWN * (1.0 - (-RATE * STIFFNESS * length).exp());
    let error = |steps: usize| (worn(layer, 0.0, 0.0, length, steps)[steps - 1] - exact).abs() / DOWN;
    let errors = [8, 16, 32].map(error);
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    println!("errors {errors:.3?}, orders {orders:.3?}");
    assert!(orders.iter().all(|order| (order - 1.0).abs() < 0.1), "{errors:?}");
    assert!((orders[1] - 1.0).abs() < (orders[0] - 1.0).abs(), "{orders:?}");
}

#[test]
fn tangents_pass_their_taylor_test() {
    fn check<const D: usize>(block: &Block<D>)
    where
        Dim: Dimension<D>,
    {
        let assembler = Assembler::new(&block.mesh).with_quadrature(Quadrature::Degree(4));
        for theta in THETAS {
            let depth = assembler.history(Entity::Facets, "bottom", 4, 0.0).unwrap();
            let mut law = model(data(Friction::Coulomb(0.6), theta, 10.0 * YOUNG), depth);
            law.data.sliding = Given::constant(along(0, 0.01));
            // A depth that differs from point to point.
            let worn = &law.data.worn;
            assembler.update_history(&law.worn_after(wave(&block.space, 0.03, 1.7)), worn).unwrap();
            worn.commit();
            let (u, direction) = (wave(&block.space, 0.02, 0.4), wave(&block.space, 0.02, 2.3));
            let depths = assembler.history_values(worn).unwrap().concat();
            let pressures =
                assembler.at_quadrature_points(&law.contact_pressure(&u), Entity::Facets, "bottom", 4);
            let pressures = pressures.unwrap().values.concat();
            let [worn, pressed] = [depths, pressures].map(|v| v.iter().filter(|v| **v > 1e-6).count());
            println!("{D}D: {worn} points are worn, {pressed} pressed");
            assert!(worn > 0 && pressed > 0);
            check_tangent(&format!("{D}D, {theta}"), &assembler, &law.direct(), &[&u], &[&direction]);
        }
    }
    check(&plane_block(4));
    check(&solid_block());
}
