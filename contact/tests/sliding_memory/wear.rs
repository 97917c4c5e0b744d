//! Wear at large sliding: the worn volume is k_w N times the distance, whatever the steps; what has left the slab stays worn; tangents.

use forms_contact::laws::sliding_wear as law;
use forms_fem::history::WithoutPartner;
use forms_fem::prelude::*;
use forms_fem::verification;

use crate::bodies::{APART, LAMBDA, MU, YOUNG, along, is_of_block, moved, plane, space, touch};

/// k_w \[1/stress\].
const RATE: f64 = 5e-5;

fn data<const D: usize>(worn: &History<f64, D>) -> law::Data<D> {
    law::data().lambda(LAMBDA).mu(MU).gamma0(20.0 * YOUNG).wear_rate(RATE).worn(worn.clone()).share(1.0)
}

fn model<const D: usize>(data: law::Data<D>) -> law::Model<D> {
    let regions = law::Regions::default().touch(touch()).gamma_n("block top").worn("block bottom");
    law::Model { data, regions }
}

/// A block that is pressed by a given load, of a uniform state because it is held sideways: worn depth and volume after each of some steps.
fn worn_by_load<const D: usize>(mesh: &Mesh<D>, distance: f64, steps: usize) -> Vec<[f64; 3]>
where
    Dim: Dimension<D>,
{
    let pressure = 0.5;
    let space = Space::vector(mesh, 1).unwrap();
    let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(3));
    let worn = assembler.history_on_sliding_pairs(&touch(), 3, 0.0).unwrap();
    let mut down = along::<D>(0, 0.0);
    down[D - 1] = -APART - 1e-3;
    let mut before = moved(&space, down);
    let mut found = vec![];
    for step in 0..=steps {
        let aside = distance * step as f64 / steps as f64;
        let data = data(&worn)
            .displacement_before(Given::field(&before))
            .traction(Given::constant(along(D - 1, -pressure)))
            .force_direction(Given::constant(along(D - 1, 1.0)));
        let law = model(data);
        let mut held = Constraints::new(&space);
        held.fix("slab", |_| [0.0; D]).unwrap();
        for axis in 0..D - 1 {
            held.fix_component("block", axis, |_| if axis == 0 { aside } else { 0.0 }).unwrap();
        }
        let options = NewtonOptions {
            relative_tolerance: 1e-13,
            line_search: LineSearch::OnResidual,
            ..NewtonOptions::default()
        };
        let form = law.direct();
        let problem = Problem::new(&form, &space).constrained(&held).assembler(&assembler);
        let u = problem.start(&before).options(options).solve().unwrap().into_field();
        let force = assembler.functional(&law.contact_force(&u)).unwrap();
        assert!((force / pressure - 1.0).abs() < 1e-9, "{step}: {force}");
        if step > 0 {
            let after = law.worn_after(&u);
            assembler.update_sliding_history(&after, &worn, &touch(), &u, WithoutPartner::Keep).unwrap();
            worn.commit();
            let depths = assembler.history_values(&worn).unwrap().concat();
            let (least, most) = depths.iter().fold((f64::MAX, f64::MIN), |(a, b), w| (a.min(*w), b.max(*w)));
            assert!(most - least < 1e-10 * most, "wear is even: {least} {most}");
            let volume = assembler.functional(&law.worn_volume(&u)).unwrap();
            found.push([aside, most, volume]);
        }
        before = u;
    }
    found
}

fn follows_archard<const D: usize>(mesh: &Mesh<D>, distance: f64)
where
    Dim: Dimension<D>,
{
    for steps in [1, 5, 17] {
        for [slid, depth, volume] in worn_by_load(mesh, distance, steps) {
            let expected = RATE * 0.5 * slid;
            for found in [depth, volume] {
                assert!((found / expected - 1.0).abs() < 1e-9, "{steps}: {found} is not {expected}");
            }
        }
    }
}

#[test]
fn the_worn_volume_is_that_of_archard() {
    follows_archard(&plane(4), 2.3);
    follows_archard(&space(), 1.2);
}

/// The worn depth at the points of the block's surface, as functions of the own body read it.
#[forms]
mod shown {
    pub struct Data {
        pub worn: History<Scalar>,
    }
    pub fn depth() -> Scalar {
        worn
    }
}

/// A rigid block slides off the slab's end: points wear as long as they have opposite ones, and stay worn afterwards.
#[test]
fn points_that_have_left_stay_worn() {
    let mesh = plane(5);
    let space = Space::vector(&mesh, 1).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(3));
    let worn = assembler.history_on_sliding_pairs(&touch(), 3, 0.0).unwrap();
    let (overlap, begin, steps) = (1e-3, 2.0, 40);
    let place = |distance: f64| moved(&space, [distance, -APART - overlap]);
    let mut before = place(begin);
    let law = model(data(&worn));
    let pressures = assembler.at_sliding_pairs(&law.contact_pressure(&before), &touch(), 3, &before).unwrap();
    let gamma = pressures.values[0][0] / overlap;
    assert!(pressures.values.iter().all(|p| (p[0] / (gamma * overlap) - 1.0).abs() < 1e-9));
    for step in 1..=steps {
        let law = model(data(&worn).displacement_before(Given::field(&before)));
        let u = place(begin + f64::from(step) / f64::from(steps));
        let after = law.worn_after(&u);
        assembler.update_sliding_history(&after, &worn, &touch(), &u, WithoutPartner::Keep).unwrap();
        worn.commit();
        before = u;
    }
    let depth = shown::depth(&shown::data().worn(worn));
    let found = assembler.at_quadrature_points(&depth, Entity::Facets, "block bottom", 3).unwrap();
    let mut depths = vec![];
    for (x, value) in found.positions.iter().zip(&found.values) {
        // The slab ends at 4.
        let touched = (1..=steps).filter(|step| x[0] + begin + f64::from(*step) / f64::from(steps) < 4.0);
        let expected = touched.fold(0.0, |w, _| w + RATE * gamma * (overlap - w) / f64::from(steps));
        assert!((value[0] - expected).abs() < 1e-10 * overlap, "{x:?}: {value:?} is not {expected}");
        depths.push(value[0]);
    }
    depths.sort_by(f64::total_cmp);
    depths.dedup_by(|a, b| (*a - *b).abs() < 1e-12);
    assert!(depths.len() >= 5, "{depths:?}");
}

/// The tangent with depths that differ from point to point.
fn tangent<const D: usize>(mesh: &Mesh<D>)
where
    Dim: Dimension<D>,
{
    let space = Space::vector(mesh, 1).unwrap();
    let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(4));
    let worn = assembler.history_on_sliding_pairs(&touch(), 4, 0.0).unwrap();
    let bent = |distance: f64, phase: f64| {
        let value = |x: &[f64; D]| -> [f64; D] {
            let block = if is_of_block(x) { 1.0 } else { 0.0 };
            std::array::from_fn(|axis| match axis + 1 == D {
                true => -block * (APART + 0.02) + 0.02 * (3.0 * x[0] + x[D - 1] + phase).sin(),
                false => block * distance + 0.02 * (2.0 * x[D - 1] + x[0] + phase).cos(),
            })
        };
        Field::interpolate(&space, value).unwrap()
    };
    let (before, u, direction) = (bent(0.2, 0.3), bent(0.3, 0.5), bent(0.1, 2.3));
    let law = model(data(&worn).friction(0.3).displacement_before(Given::field(&before)));
    let after = law.worn_after(&u);
    assembler.update_sliding_history(&after, &worn, &touch(), &u, WithoutPartner::Keep).unwrap();
    worn.commit();
    let depths = assembler.history_values(&worn).unwrap().concat();
    assert!(
        depths.iter().any(|w| *w > 1e-4) && depths.windows(2).any(|w| (w[0] - w[1]).abs() > 1e-5),
        "{depths:?}"
    );
    let report = verification::tangent(&assembler, &law.direct(), &[&u], &[&direction], 1e-4).unwrap();
    let order = report.second_order().unwrap();
    assert!((order - 2.0).abs() < 0.05, "{report}");
}

#[test]
fn tangents_with_worn_points() {
    tangent(&plane(4));
    tangent(&space());
}
