//! Heat across the contact of a layer in two bodies: steady temperatures and flows compared with the closed form for given pressure,
//! heat of friction and its parts, balances, surfaces that are apart.

use forms_contact::ContactProblem;
use forms_contact::laws::contact_heat::{contact_heat as law, heat_problem};
use forms_contact::laws::two_bodies as mechanics;
use forms_fem::prelude::*;

use crate::setting::{LAMBDA, MU, YOUNG};
use crate::two_bodies::{WIDTH, constraints, layers};

/// Of the lower and the upper body.
const CONDUCTIVITIES: [f64; 2] = [2.0, 5.0];
const EFFUSIVITIES: [f64; 2] = [1.0, 3.0];
const CONDUCTANCE: f64 = 8.0;
const HARDNESS: f64 = 40.0;
const FRICTION: f64 = 0.3;
const DURATION: f64 = 0.25;

fn pairings() -> [(Pairing, f64); 3] {
    let (lower, upper) = ("lower top", "upper bottom");
    [
        (Pairing::between(lower, upper), 0.5),
        (Pairing::onto(lower, upper), 1.0),
        (Pairing::onto(upper, lower), 1.0),
    ]
}

/// A number per body.
fn of_bodies<const D: usize>(mesh: &Mesh<D>, values: [f64; 2]) -> Given<f64, D> {
    let space = Space::discontinuous_scalar(mesh, 0).unwrap();
    let mut numbers = vec![0.0; space.unknowns()];
    for cell in 0..mesh.cell_count() {
        let lower = mesh.cell_region("lower").unwrap().contains(&(cell as u32));
        for node in space.cell_nodes(cell) {
            numbers[*node as usize] = values[usize::from(!lower)];
        }
    }
    Given::field(Field::from_values(&space, numbers).unwrap())
}

/// The bodies pressed by δ and sheared by U, and the heat of that step, with the given temperatures at the ends: the flows of
/// heat into the bodies there, per area, the temperatures on both sides of the contact, and the power of friction.
struct Heated {
    flows: [f64; 2],
    sides: [f64; 2],
    power: f64,
    across: f64,
}

fn heated<const D: usize>(
    mesh: &Mesh<D>,
    (pairing, share): &(Pairing, f64),
    aside: f64,
    down: f64,
    ends: [f64; 2],
) -> Heated
where
    Dim: Dimension<D>,
{
    let displacements = Space::vector(mesh, 1).unwrap();
    let base = mechanics::data().lambda(LAMBDA).mu(MU).gamma0(20.0 * YOUNG).share(*share).friction(FRICTION);
    let regions = mechanics::Regions::default().touch(pairing.clone()).gamma_n("upper top");
    let model = mechanics::Model { data: base.clone(), regions };
    let held = constraints(&displacements, aside, down);
    let assembler = Assembler::new(mesh);
    let problem = ContactProblem::new(&displacements, model, held).assembler(assembler.clone());
    let u = match down > 0.0 {
        true => problem.direct().unwrap().solve().unwrap().into_field(),
        // Apart: the upper body is moved as a whole.
        false => Field::interpolate(&displacements, |x| match x[D - 1] > 0.505 {
            true => std::array::from_fn(|k| if k == D - 1 { -down } else { 0.0 }),
            false => [0.0; D],
        })
        .unwrap(),
    };

    let data = law::data_from(base)
        .conductivity(of_bodies(mesh, CONDUCTIVITIES))
        .conductance(CONDUCTANCE)
        .hardness(HARDNESS)
        .effusivity(of_bodies(mesh, EFFUSIVITIES))
        .duration(DURATION);
    let model =
        law::Model { data, regions: law::Regions::default().touch(pairing.clone()).gamma_n("upper top") };
    let temperatures = Space::scalar(mesh, 1).unwrap();
    let mut held = Constraints::new(&temperatures);
    held.fix("lower bottom", |_| ends[0]).unwrap();
    held.fix("upper top", |_| ends[1]).unwrap();
    let problem = heat_problem(&model, &temperatures, &u).unwrap();
    let solved = problem.assembler(&assembler).constrained(&held).solve().unwrap();
    let area = WIDTH.powi(D as i32 - 1);
    let flow = |region| solved.reaction(region).unwrap()[0] / area;
    let side = |region| {
        let values: Vec<f64> = temperatures
            .nodes_on(region)
            .unwrap()
            .iter()
            .map(|node| solved.field().at_node(*node as usize)[0])
            .collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        assert!(
            values.iter().all(|value| (value - mean).abs() < 1e-11 * ends[1].abs().max(1.0)),
            "{values:?}"
        );
        mean
    };
    Heated {
        flows: [flow("lower bottom"), flow("upper top")],
        sides: [side("lower top"), side("upper bottom")],
        power: assembler.functional(&model.total_friction_power(&u)).unwrap() / area,
        across: assembler.functional(&model.flow_across(solved.field(), &u)).unwrap() / area,
    }
}

/// Heights ½: k₁ (a − A)/½ = h (b − a) + r₁ D and k₂ (b − B)/½ = −h (b − a) + r₂ D for the temperatures a and b on both sides.
fn expected(conductance: f64, power: f64, ends: [f64; 2]) -> [f64; 2] {
    let [first, second] = CONDUCTIVITIES.map(|k| 2.0 * k);
    let part = EFFUSIVITIES[0] / (EFFUSIVITIES[0] + EFFUSIVITIES[1]);
    let right = [first * ends[0] + part * power, second * ends[1] + (1.0 - part) * power];
    let (a, b) = (first + conductance, second + conductance);
    let determinant = a * b - conductance * conductance;
    [
        (right[0] * b + conductance * right[1]) / determinant,
        (a * right[1] + conductance * right[0]) / determinant,
    ]
}

fn check<const D: usize>(shape: CellShape, cells: [usize; 2], pairings: &[(Pairing, f64)])
where
    Dim: Dimension<D>,
{
    let mesh = layers::<D>(shape, cells, 0.0);
    let (down, ends) = (0.01, [20.0, 100.0]);
    let pressure = (LAMBDA + 2.0 * MU) * down;
    let conductance = CONDUCTANCE * (pressure / HARDNESS).powf(0.95);
    for pairing in pairings {
        // At rest, and slid by U − κ p H/μ.
        for aside in [0.0, 0.02] {
            let slid = if aside > 0.0 { aside - FRICTION * pressure / MU } else { 0.0 };
            let power = FRICTION * pressure * slid / DURATION;
            let sides = expected(conductance, power, ends);
            let found = heated(&mesh, pairing, aside, down, ends);
            let errors = [
                found.sides[0] - sides[0],
                found.sides[1] - sides[1],
                found.flows[0] - 2.0 * CONDUCTIVITIES[0] * (ends[0] - sides[0]),
                found.flows[1] - 2.0 * CONDUCTIVITIES[1] * (ends[1] - sides[1]),
            ];
            println!("{D}D {}, {aside}: {errors:.1?}", pairing.0);
            assert!(errors.iter().all(|error| error.abs() < 1e-11 * 100.0), "{}: {errors:?}", pairing.0);
            assert!((found.power - power).abs() < 1e-11 * pressure, "{} is not {power}", found.power);
            // What friction makes leaves at the ends.
            let balance = found.flows[0] + found.flows[1] + found.power;
            assert!(balance.abs() < 1e-11 * 100.0, "{balance:.1e}");
            if pairing.1 == 1.0 {
                let flow = conductance * (found.sides[0] - found.sides[1]);
                let sign = if pairing.0 == Pairing::onto("lower top", "upper bottom") { 1.0 } else { -1.0 };
                assert!((found.across - sign * flow).abs() < 1e-11 * 100.0, "{} {flow}", found.across);
            }
        }
    }
}

#[test]
fn steady_heat_across_layers() {
    check::<2>(CellShape::Quadrilateral, [3, 4], &pairings());
    check::<2>(CellShape::Triangle, [3, 2], &pairings()[..1]);
    check::<3>(CellShape::Hexahedron, [2, 3], &pairings()[..1]);
}

/// Apart nothing flows: each body has the temperature of its end.
#[test]
fn bodies_apart_exchange_nothing() {
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 4], 0.02);
    let found = heated(&mesh, &pairings()[0], 0.0, -0.01, [20.0, 100.0]);
    assert!(
        (found.sides[0] - 20.0).abs() < 1e-11 && (found.sides[1] - 100.0).abs() < 1e-11,
        "{:?}",
        found.sides
    );
    assert_eq!(found.power, 0.0);
}
