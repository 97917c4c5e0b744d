//! Heat across contacts of random displacements, materials and conductances: each is one linear system, whose solution is in balance.

use forms_contact::laws::contact_heat::{contact_heat as law, heat_problem};
use forms_contact::laws::two_bodies as mechanics;
use forms_fem::prelude::*;

use super::{Random, runs};
use crate::setting::{LAMBDA, MU, YOUNG};
use crate::two_bodies::layers;

#[test]
fn heat_is_in_balance_for_any_displacement() {
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 4], 0.0);
    let (displacements, temperatures) = (Space::vector(&mesh, 1).unwrap(), Space::scalar(&mesh, 1).unwrap());
    let per_cell = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let mut random = Random(7);
    let mut touched = [false; 2];
    for run in 0..runs() {
        // Pressed, apart, or both in turn along the surface.
        let down = random.between(-0.02, 0.02);
        let noise = random.start(&displacements, 0.01);
        let moved =
            Field::interpolate(&displacements, |x: &[f64; 2]| [0.0, if x[1] > 0.505 { -down } else { 0.0 }]);
        let u = Field::combination(&[(1.0, &noise), (1.0, &moved.unwrap())]).unwrap();
        let before = random.start(&displacements, 0.01);
        let mut number = |orders: f64| 10_f64.powf(random.between(-orders, orders));
        let mut varied = |orders: f64| {
            let values = (0..per_cell.unknowns()).map(|_| number(orders)).collect();
            Given::field(Field::from_values(&per_cell, values).unwrap())
        };
        let (conductivity, effusivity) = (varied(1.0), varied(1.0));
        let (conductance, hardness, duration) = (8.0 * number(3.0), 40.0 * number(2.0), number(2.0));
        let required = mechanics::data().lambda(LAMBDA).mu(MU).gamma0(20.0 * YOUNG);
        let base = required.friction(random.between(0.0, 0.8)).displacement_before(before);
        let data = law::data_from(base)
            .conductivity(conductivity)
            .conductance(conductance)
            .hardness(hardness)
            .effusivity(effusivity)
            .duration(duration)
            .exponent(random.between(0.0, 2.0));
        let touch = Pairing::between("lower top", "upper bottom");
        let regions = law::Regions::default().touch(touch).gamma_n("upper right");
        let model = law::Model { data, regions };
        let ends = [random.between(-50.0, 50.0), random.between(-50.0, 50.0)];
        let mut held = Constraints::new(&temperatures);
        held.fix("lower bottom", |_| ends[0]).unwrap();
        held.fix("upper top", |_| ends[1]).unwrap();
        let solved = heat_problem(&model, &temperatures, &u).unwrap().constrained(&held).solve();
        let solved = solved.unwrap_or_else(|error| panic!("run {run}: {error}"));
        let flows = ["lower bottom", "upper top"].map(|end| solved.reaction(end).unwrap()[0]);
        let power = solved.functional(&model.total_friction_power(&u)).unwrap();
        let left = flows[0] + flows[1] + power;
        // Between two bodies that are held at other temperatures some heat flows at least along each.
        let size = flows[0].abs() + flows[1].abs() + power.abs() + 1e-3;
        println!("run {run}: flows {flows:?}, power {power:.3e}, left {left:.1e}");
        assert!(left.abs() < 1e-9 * size, "run {run}: {left:e} of {size}");
        assert!(solved.field().values().iter().all(|value| value.is_finite()));
        touched[usize::from(flows[1].abs() > 1e-6)] = true;
    }
    assert!(touched[1], "heat flows in some");
}
