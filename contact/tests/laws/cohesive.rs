//! Cohesion: a glued layer that is torn, released, pressed and torn again, compared with its closed form, the energy that it takes,
//! sliding, tangents, adjoints and data out of range.

use forms_contact::ContactProblem;
use forms_contact::laws::cohesive as law;
use forms_fem::prelude::*;

use crate::setting::{LAMBDA, MU, YOUNG, check_tangent, close};
use crate::two_bodies::{WIDTH, constraints, layers};

/// K, σ_c, G_c: separation begins at δ₀ = 0.002 and ends at δ_f = 0.04, softer than the layers.
const STIFFNESS: f64 = 1000.0;
const STRENGTH: f64 = 2.0;
const ENERGY: f64 = 0.04;
const BEGIN: f64 = STRENGTH / STIFFNESS;
pub const END: f64 = 2.0 * ENERGY / STRENGTH;
const SLOPE: f64 = STRENGTH / (END - BEGIN);
/// Stiffness of the layers of height 1 in all when stretched.
const LAYERS: f64 = LAMBDA + 2.0 * MU;

fn pairings() -> [(Pairing, f64); 3] {
    let (lower, upper) = ("lower top", "upper bottom");
    [
        (Pairing::between(lower, upper), 0.5),
        (Pairing::onto(lower, upper), 1.0),
        (Pairing::onto(upper, lower), 1.0),
    ]
}

pub fn model<const D: usize>(assembler: &Assembler<D>, (pairing, share): &(Pairing, f64)) -> law::Model<D> {
    let largest_opening = assembler.history_on_pairs(pairing, 4, 0.0).unwrap();
    let data = law::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(20.0 * YOUNG)
        .stiffness(STIFFNESS)
        .strength(STRENGTH)
        .fracture_energy(ENERGY)
        .largest_opening(largest_opening)
        .share(*share)
        .criterion_force(|x: &[f64; D]| std::array::from_fn(|k| 0.3 + x[k] - 0.5 * x[0] * x[D - 1]));
    law::Model { data, regions: law::Regions::default().touch(pairing.clone()).gamma_n("upper top") }
}

/// One step: the reaction per area at the top, and the state, with the history committed.
fn step<const D: usize>(
    problem: &mut ContactProblem<D, law::Model<D>>,
    start: &Field<D>,
    aside: f64,
    down: f64,
) -> (Vec<f64>, Field<D>)
where
    Dim: Dimension<D>,
{
    problem.constraints = constraints(&problem.space, aside, down);
    let options = NewtonOptions {
        relative_tolerance: 1e-12,
        line_search: LineSearch::OnResidual,
        ..NewtonOptions::default()
    };
    let solved = problem.direct().unwrap().start(start).options(options).solve().unwrap();
    let reaction = solved.reaction("upper top").unwrap();
    let u = solved.into_field();
    let largest = &problem.law.data.largest_opening;
    problem.assembler.update_history(&problem.law.opening_after(&u), largest).unwrap();
    largest.commit();
    let area = WIDTH.powi(D as i32 - 1);
    (reaction.iter().map(|force| force / area).collect(), u)
}

/// Opening and traction of layers whose ends are drawn apart by `length`, after the largest opening.
pub fn torn(length: f64, largest: &mut f64) -> f64 {
    if length <= 0.0 {
        return LAYERS * length;
    }
    let traction = |opening: f64| match opening {
        o if o <= BEGIN => STIFFNESS * o,
        o if o < END => SLOPE * (END - o),
        _ => 0.0,
    };
    let secant = if *largest <= BEGIN { STIFFNESS } else { traction(*largest) / *largest };
    let released = LAYERS * length / (LAYERS + secant);
    let opening = match released {
        o if o <= *largest || o <= BEGIN => o,
        _ if length >= END => length,
        _ => (LAYERS * length - SLOPE * END) / (LAYERS - SLOPE),
    };
    *largest = largest.max(opening);
    LAYERS * (length - opening)
}

/// Drawn apart, let go, pressed, drawn again until nothing holds, pressed again: each step compared with the closed form, and the
/// work that was done with G_c.
fn tears<const D: usize>(shape: CellShape, cells: [usize; 2], pairings: &[(Pairing, f64)])
where
    Dim: Dimension<D>,
{
    let mesh = layers::<D>(shape, cells, 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let area = WIDTH.powi(D as i32 - 1);
    // The length at which separation begins; with it and its end among the steps the work of each is a trapezium.
    let first = BEGIN + STRENGTH / LAYERS;
    let path = [
        0.5 * first,
        first,
        0.01,
        0.02,
        0.01,
        0.0,
        -0.01,
        0.0,
        0.01,
        0.02,
        0.03,
        0.015,
        0.03,
        END,
        0.05,
        0.02,
        0.0,
        -0.005,
        0.0,
        0.01,
    ];
    for pairing in pairings {
        let assembler = Assembler::new(&mesh);
        let law = model(&assembler, pairing);
        let mut problem =
            ContactProblem::new(&space, law, constraints(&space, 0.0, 0.0)).assembler(assembler);
        let mut u = Field::zero(&space);
        let (mut largest, mut work, mut before) = (0.0, 0.0, [0.0; 2]);
        for length in path {
            let expected = torn(length, &mut largest);
            let (found, state) = step(&mut problem, &u, 0.0, -length);
            u = state;
            let error = (found[D - 1] - expected) / STRENGTH;
            assert!(error.abs() < 1e-10, "{} at {length}: {} is not {expected}", pairing.0, found[D - 1]);
            assert!(found[0].abs() < 1e-10 * STRENGTH);
            work += 0.5 * (found[D - 1] + before[1]) * (length - before[0]);
            before = [length, found[D - 1]];
            let lost = problem.assembler.functional(&problem.law.dissipated_energy()).unwrap() / area;
            let exact = ENERGY * ((largest - BEGIN) / (END - BEGIN)).clamp(0.0, 1.0);
            assert!((lost - exact).abs() < 1e-11 * ENERGY, "{}: {lost} is not {exact}", pairing.0);
        }
        // The last state is free of stress: all the work was lost in separation.
        close(&format!("{D}D {}, work", pairing.0), work, ENERGY, 1e-10);
    }
}

#[test]
fn a_layer_is_torn_released_and_pressed() {
    tears::<2>(CellShape::Quadrilateral, [3, 4], &pairings());
    tears::<2>(CellShape::Triangle, [3, 2], &pairings()[..1]);
    tears::<3>(CellShape::Hexahedron, [2, 3], &pairings()[..1]);
}

/// Sliding by Δ opens by β Δ: μ (U − Δ) = β t(β Δ).
#[test]
fn sliding_takes_the_same_energy() {
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 4], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let weight = 0.7;
    let assembler = Assembler::new(&mesh);
    let mut law = model(&assembler, &pairings()[0]);
    law.data.shear_weight = weight;
    let mut problem = ContactProblem::new(&space, law, constraints(&space, 0.0, 0.0)).assembler(assembler);
    let (mut u, mut work, mut before) = (Field::zero(&space), 0.0, [0.0; 2]);
    let first = BEGIN / weight + weight * STRENGTH / MU;
    for aside in [first, 0.03, 0.05, END / weight, 0.07] {
        let slid = match aside {
            a if a == first => BEGIN / weight,
            a if a < END / weight => (MU * a - weight * SLOPE * END) / (MU - weight * weight * SLOPE),
            a => a,
        };
        let (found, state) = step(&mut problem, &u, aside, 0.0);
        u = state;
        let expected = MU * (aside - slid);
        assert!((found[0] - expected).abs() < 1e-10 * STRENGTH, "{found:?} is not {expected} at {aside}");
        work += 0.5 * (found[0] + before[1]) * (aside - before[0]);
        before = [aside, found[0]];
    }
    close("work of sliding", work, ENERGY, 1e-10);
}

/// A smooth field in each body; the upper one is above the height ½.
fn parted<const D: usize>(space: &Arc<Space<D>>, phase: f64) -> Field<D> {
    let value = |x: &[f64; D]| -> [f64; D] {
        let phase = if x[D - 1] > 0.501 { phase } else { 2.3 * phase + 1.0 };
        std::array::from_fn(|k| {
            let angle: f64 = x.iter().enumerate().map(|(axis, x)| (3.0 + 0.7 * axis as f64) * x).sum();
            0.02 * (angle + phase + 1.9 * k as f64).sin()
        })
    };
    Field::interpolate(space, value).unwrap()
}

/// At a state in which points open further, unload and touch, with a history that differs from point to point.
#[test]
fn tangents_pass_their_taylor_test() {
    fn check<const D: usize>(shape: CellShape, cells: [usize; 2])
    where
        Dim: Dimension<D>,
    {
        let mesh = layers::<D>(shape, cells, 0.002);
        let space = Space::vector(&mesh, 1).unwrap();
        let assembler = Assembler::new(&mesh);
        let (pairing, share) = &pairings()[0];
        let mut law = model(&assembler, &(pairing.clone(), *share));
        law.data.shear_weight = 0.7;
        let largest = &law.data.largest_opening;
        assembler.update_history(&law.opening_after(parted(&space, 1.7)), largest).unwrap();
        largest.commit();
        let (u, direction) = (parted(&space, 0.4), parted(&space, 3.9));
        let known = assembler.history_values(largest).unwrap().concat();
        let now = assembler.at_pairs(&law.opening_after(&u), pairing, 4).unwrap().values.concat();
        let further = known.iter().zip(&now).filter(|(known, now)| now > known).count();
        let pressed = assembler.at_pairs(&law.contact_pressure(&u), pairing, 4).unwrap().values.concat();
        let pressed = pressed.iter().filter(|pressure| **pressure > 0.0).count();
        println!("{D}D: of {} points {further} open further, {pressed} touch", known.len());
        assert!(further > 0 && further < known.len() && pressed > 0 && pressed < known.len());
        check_tangent(&format!("{D}D"), &assembler, &law.direct(), &[&u], &[&direction]);
    }
    check::<2>(CellShape::Quadrilateral, [3, 4]);
    check::<3>(CellShape::Hexahedron, [2, 3]);
}

/// dJ/dσ_c of a step from a damaged state, compared with differences with the history held.
#[test]
fn the_adjoint_of_a_step() {
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 4], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let assembler = Assembler::new(&mesh);
    let base = model(&assembler, &pairings()[0]);
    // Peeled: the farther to the right the wider.
    let peeled = |problem: &mut ContactProblem<2, law::Model<2>>, height: f64| {
        let mut constraints = Constraints::new(&problem.space);
        constraints.fix("lower bottom", |_| [0.0; 2]).unwrap();
        constraints.fix("upper top", move |x| [0.0, height * (0.2 + x[0] / WIDTH)]).unwrap();
        problem.constraints = constraints;
    };
    let solve = |strength: f64, height: f64, start: &Field<2>| {
        let mut law = base.clone();
        law.data.strength = strength;
        let problem = ContactProblem::new(&space, law, Constraints::new(&space));
        let mut problem = problem.assembler(assembler.clone());
        peeled(&mut problem, height);
        let solved = problem.direct().unwrap().start(start).solve().unwrap();
        (problem, solved.into_field())
    };
    let (problem, first) = solve(STRENGTH, 0.015, &Field::zero(&space));
    assembler.update_history(&problem.law.opening_after(&first), &base.data.largest_opening).unwrap();
    base.data.largest_opening.commit();
    assert!(assembler.functional(&problem.law.dissipated_energy()).unwrap() > 0.0);
    let (problem, u) = solve(STRENGTH, 0.02, &first);
    let p = problem.adjoint(&u).unwrap().solve().unwrap().into_field();
    let gradient = assembler.functional(&problem.law.by_strength(&u, &p)).unwrap();
    let value = |change: f64| {
        let (problem, u) = solve(STRENGTH + change, 0.02, &first);
        problem.criterion(&u).unwrap()
    };
    let step = 1e-3;
    let difference =
        (8.0 * (value(step) - value(-step)) - (value(2.0 * step) - value(-2.0 * step))) / (12.0 * step);
    close("by the strength", gradient, difference, 1e-8);
}

#[test]
fn parameters_out_of_range_are_named() {
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 4], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let message = |change: fn(&mut law::Data<2>)| {
        let assembler = Assembler::new(&mesh);
        let mut law = model(&assembler, &pairings()[0]);
        change(&mut law.data);
        let problem = ContactProblem::new(&space, law, Constraints::new(&space)).assembler(assembler);
        problem.direct().map(|_| ()).unwrap_err().to_string()
    };
    // Softening that would begin after its end.
    let steep = message(|data| data.stiffness = 49.0);
    assert!(steep.contains("`stiffness` is 49; it must be above strength²/(2 fracture_energy)"), "{steep}");
    assert!(message(|data| data.strength = 0.0).contains("`strength` is 0; it must be positive"));
    assert!(message(|data| data.fracture_energy = -1.0).contains("`fracture_energy` is -1"));
}
