//! Kinds of random problems.

use forms_fem::constraints::RigidMap;
use forms_fem::prelude::*;
use forms_fem::solve::Elimination;

use super::laws::{coupled, scalar, solid};
use super::random::Numbers;
use super::reference::{Outcome, halves, judge};
use super::solvers::{COUNT, solver};

/// Makes a problem and judges what becomes of it, with a description.
pub type Kind = fn(&mut Numbers) -> (String, Outcome);

/// All of them, by name.
pub const ALL: [(&str, Kind); 10] = [
    ("apart", apart),
    ("kinked", kinked),
    ("hardening", hardening),
    ("conduction", conduction),
    ("walled", walled),
    ("p-laplace", p_laplace),
    ("membrane", membrane),
    ("components", components),
    ("three fields", three_fields),
    ("contact", contact),
];

fn mesh(numbers: &mut Numbers) -> (Mesh<2>, CellShape) {
    let shape = [CellShape::Quadrilateral, CellShape::Triangle][numbers.choice(2)];
    let cells = [2 + 2 * numbers.choice(3), 1 + numbers.choice(3)];
    (rectangle([0.0; 2], [1.0; 2], cells, shape, 1).unwrap(), shape)
}

/// A contrast between the left half and the right one.
fn contrast(numbers: &mut Numbers) -> (f64, f64) {
    match numbers.choice(3) {
        0 => (numbers.power(-16.0, 16.0), 1.0),
        1 => (1.0, numbers.power(-16.0, 16.0)),
        _ => (1.0, 1.0),
    }
}

fn by_half((left, right): (f64, f64)) -> Given<f64, 2> {
    Given::function(move |x: &[f64; 2]| if x[0] < 0.5 { left } else { right })
}

/// The mesh, the data, the start, the constraints and the solution of a scalar problem.
struct ScalarCase<'a> {
    space: &'a Arc<Space<2>>,
    constraints: Constraints<2>,
    start: Field<2>,
    exact: Option<Vec<f64>>,
}

macro_rules! solve_and_judge {
    ($case:expr, $form:expr, $numbers:expr) => {{
        let ScalarCase { space, constraints, start, exact } = $case;
        let form = $form;
        let (name, mut linear) = solver($numbers.choice(COUNT));
        let options = NewtonOptions { max_iterations: 100, ..NewtonOptions::default() };
        let problem = Problem::new(&form, space).constrained(&constraints).start(&start);
        let found = problem.solver(&mut *linear).options(options).solve();
        let found = found.map(|solved| solved.field().values().to_vec()).map_err(|error| error.to_string());
        let mut equations = Problem::new(&form, space);
        let elimination = Elimination::of(&[&constraints]).unwrap();
        let ends = (start.values().to_vec(), exact);
        (name, judge(found, &mut equations, elimination, ends, &halves(space, 0)))
    }};
}

fn plain_data() -> scalar::Data<2> {
    let one = || Given::constant(1.0);
    scalar::data().k(one()).c(one()).f(one()).wall(one()).penalty(1.0).power(0.0)
}

fn apart(numbers: &mut Numbers) -> (String, Outcome) {
    let mesh = rectangle([0.0; 2], [1.0; 2], [2, 1], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let (k, c) = ((numbers.power(-16.0, 16.0), 0.0), (0.0, numbers.power(-3.0, 3.0)));
    let far = if numbers.choice(2) == 0 { 0.0 } else { numbers.power(0.0, 12.0) };
    let data = plain_data().k(by_half(k)).c(by_half(c));
    let form = scalar::Model { data, regions: scalar::Regions::default() }.apart();
    let (constraints, start) = (Constraints::new(&space), Field::interpolate(&space, |_| far).unwrap());
    let exact = Some(vec![1.0; space.unknowns()]);
    let (name, outcome) =
        solve_and_judge!(ScalarCase { space: &space, constraints, start, exact }, form, numbers);
    (format!("{k:?} {c:?} from {far:e}, {name}"), outcome)
}

/// A root of an increasing function of one number.
fn root(f: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (-1e3, 1e3);
    for _ in 0..2000 {
        let middle = 0.5 * (low + high);
        if f(middle) < 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

fn kinked(numbers: &mut Numbers) -> (String, Outcome) {
    let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let (k, at, c) = (numbers.power(0.0, 12.0), numbers.power(1.0, 8.0), numbers.within(0.1, 0.9));
    let far = at * numbers.power(0.0, 6.0);
    let data = plain_data().k(k).f(at).c(c);
    let form = scalar::Model { data, regions: scalar::Regions::default() }.kinked();
    let (constraints, start) = (Constraints::new(&space), Field::interpolate(&space, |_| far).unwrap());
    let exact = Some(vec![root(|u| u + k * (u - at).max(0.0) + 0.1 * u.tanh() - c)]);
    let (name, outcome) =
        solve_and_judge!(ScalarCase { space: &space, constraints, start, exact }, form, numbers);
    (format!("k {k:e} at {at:e}, c {c} from {far:e}, {name}"), outcome)
}

fn hardening(numbers: &mut Numbers) -> (String, Outcome) {
    let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let (k, c) = (numbers.power(-24.0, 0.0), numbers.within(0.1, 0.9));
    let far = numbers.power(0.0, 12.0) * if numbers.choice(2) == 0 { 1.0 } else { -1.0 };
    let data = plain_data().k(k).c(c);
    let form = scalar::Model { data, regions: scalar::Regions::default() }.hardening();
    let (constraints, start) = (Constraints::new(&space), Field::interpolate(&space, |_| far).unwrap());
    let exact = Some(vec![root(|u| u + k * u.powi(3) + 0.1 * u.tanh() - c)]);
    let (name, outcome) =
        solve_and_judge!(ScalarCase { space: &space, constraints, start, exact }, form, numbers);
    (format!("k {k:e}, c {c} from {far:e}, {name}"), outcome)
}

/// A start that is zero or far off, and a unit.
fn start_and_unit(numbers: &mut Numbers) -> (f64, f64) {
    let far = if numbers.choice(3) == 0 { numbers.power(0.0, 4.0) } else { 0.0 };
    let unit = match numbers.choice(6) {
        0 => numbers.power(-60.0, 60.0),
        1 => 1e-302,
        _ => 1.0,
    };
    (far, unit)
}

fn conduction(numbers: &mut Numbers) -> (String, Outcome) {
    let (mesh, _) = mesh(numbers);
    let space = Space::scalar(&mesh, 1 + numbers.choice(2)).unwrap();
    let (k, (far, unit)) = (contrast(numbers), start_and_unit(numbers));
    let soft = if numbers.choice(2) == 0 { (0.0, 1.0) } else { (1.0, 1.0) };
    let offset = if numbers.choice(3) == 0 { numbers.power(0.0, 8.0) } else { 0.0 };
    let with = |(left, right): (f64, f64)| by_half((unit * left, unit * right));
    let data = plain_data().k(with(k)).c(with(soft)).f(unit);
    let form = scalar::Model { data, regions: scalar::Regions::default() }.conduction();
    let mut constraints = Constraints::new(&space);
    constraints.fix("left", |_| offset).unwrap();
    let both = numbers.choice(2) == 0;
    if both {
        constraints.fix("right", |_| offset + 1.0).unwrap();
    }
    let periodic = numbers.choice(3) == 0;
    if periodic {
        constraints.periodic("bottom", "top", &RigidMap::translation([0.0, 1.0])).unwrap();
    }
    let start = Field::interpolate(&space, |x| far * (1.0 + x[0])).unwrap();
    let case = ScalarCase { space: &space, constraints, start, exact: None };
    let (name, outcome) = solve_and_judge!(case, form, numbers);
    (
        format!(
            "k {k:?} c {soft:?} unit {unit:e} offset {offset:e} far {far:e} both {both} {periodic}, {name}"
        ),
        outcome,
    )
}

fn walled(numbers: &mut Numbers) -> (String, Outcome) {
    let (mesh, _) = mesh(numbers);
    let space = Space::scalar(&mesh, 1 + numbers.choice(2)).unwrap();
    let (far, unit) = start_and_unit(numbers);
    let penalty = numbers.power(2.0, 30.0);
    let offset = if numbers.choice(3) == 0 { numbers.power(0.0, 8.0) } else { 0.0 };
    let data =
        plain_data().k(unit).c(unit).f(unit).wall(move |x: &[f64; 2]| offset + x[0]).penalty(unit * penalty);
    let form = scalar::Model { data, regions: scalar::Regions::default().wall("boundary") }.walled();
    let (constraints, start) =
        (Constraints::new(&space), Field::interpolate(&space, |x| far * x[1]).unwrap());
    let case = ScalarCase { space: &space, constraints, start, exact: None };
    let (name, outcome) = solve_and_judge!(case, form, numbers);
    (format!("penalty {penalty:e} unit {unit:e} offset {offset:e} far {far:e}, {name}"), outcome)
}

fn p_laplace(numbers: &mut Numbers) -> (String, Outcome) {
    let (mesh, _) = mesh(numbers);
    let space = Space::scalar(&mesh, 1).unwrap();
    let (penalty, power) = (numbers.power(2.0, 16.0), numbers.within(0.0, 1.0));
    let offset = if numbers.choice(2) == 0 { numbers.power(0.0, 8.0) } else { 0.0 };
    let data = plain_data().f(1.0).wall(offset).penalty(penalty).power(power);
    let form = scalar::Model { data, regions: scalar::Regions::default().wall("boundary") }.p_laplace();
    let (constraints, start) = (Constraints::new(&space), Field::interpolate(&space, |_| offset).unwrap());
    let case = ScalarCase { space: &space, constraints, start, exact: None };
    let (name, outcome) = solve_and_judge!(case, form, numbers);
    (format!("penalty {penalty:e} power {power} offset {offset:e}, {name}"), outcome)
}

fn membrane(numbers: &mut Numbers) -> (String, Outcome) {
    let (mesh, _) = mesh(numbers);
    let space = Space::scalar(&mesh, 1 + numbers.choice(2)).unwrap();
    let (k, unit) = (contrast(numbers), numbers.power(-30.0, 30.0));
    // Where a switch cuts a cell its penalty has a low rank, and what holds the rest of the cell must not vanish next to it.
    let weakest = k.0.min(k.1) / k.0.max(k.1);
    let penalty = numbers.power(1.0, 14.0).min(1e15 * weakest).max(1.0);
    let data = plain_data().k(by_half((unit * k.0, unit * k.1))).f(-unit).wall(-0.01).penalty(unit * penalty);
    let form = scalar::Model { data, regions: scalar::Regions::default() }.membrane();
    let mut constraints = Constraints::new(&space);
    constraints.fix("boundary", |_| 0.0).unwrap();
    let start = Field::zero(&space);
    let case = ScalarCase { space: &space, constraints, start, exact: None };
    let (name, outcome) = solve_and_judge!(case, form, numbers);
    (format!("k {k:?} penalty {penalty:e} unit {unit:e}, {name}"), outcome)
}

fn components(numbers: &mut Numbers) -> (String, Outcome) {
    let (mesh, _) = mesh(numbers);
    let space = Space::vector(&mesh, 1).unwrap();
    let (first, second) = (numbers.power(-16.0, 16.0), numbers.power(-16.0, 16.0));
    let coupling = numbers.within(-1.0, 1.0);
    let far = if numbers.choice(3) == 0 { numbers.power(0.0, 8.0) } else { 0.0 };
    let load = Given::function(|x: &[f64; 2]| 1.0 + x[0]);
    let data = coupled::data().first(first).second(second).third(1.0).coupling(coupling).load(load);
    let form = coupled::Model { data, regions: coupled::Regions::default() }.components();
    let mut constraints = Constraints::new(&space);
    constraints.fix("left", |_| [0.0; 2]).unwrap();
    let start = Field::interpolate(&space, |x| [far * x[0], far]).unwrap();
    let case = ScalarCase { space: &space, constraints, start, exact: None };
    let (name, outcome) = solve_and_judge!(case, form, numbers);
    (format!("{first:e} {second:e} coupling {coupling} far {far:e}, {name}"), outcome)
}

fn three_fields(numbers: &mut Numbers) -> (String, Outcome) {
    let (mesh, _) = mesh(numbers);
    let (bodies, scalars) = (Space::vector(&mesh, 1).unwrap(), Space::scalar(&mesh, 1).unwrap());
    let [first, second, third] = [(); 3].map(|()| numbers.power(-16.0, 16.0));
    let coupling = numbers.within(-1.0, 1.0);
    let load = Given::function(|x: &[f64; 2]| 1.0 + x[0]);
    let data = coupled::data().first(first).second(second).third(third).coupling(coupling).load(load);
    let form = coupled::Model { data, regions: coupled::Regions::default() }.three();
    let mut held = Constraints::new(&bodies);
    held.fix("bottom", |_| [0.0; 2]).unwrap();
    let mut given = [Constraints::new(&scalars), Constraints::new(&scalars)];
    given[0].fix("left", |_| 0.5).unwrap();
    given[1].fix("right", |x| x[1]).unwrap();
    let (name, mut linear) = solver(numbers.choice(COUNT));
    let spaces = [&bodies, &scalars, &scalars];
    let problem =
        Problem::new(&form, spaces).constrained(&held).constrained(&given[0]).constrained(&given[1]);
    let found = problem.solver(&mut *linear).solve().map_err(|error| error.to_string());
    let found = found
        .map(|solved| solved.fields.iter().flat_map(|field| field.values().to_vec()).collect::<Vec<_>>());
    let mut groups = halves(&bodies, 0);
    groups.extend(halves(&scalars, bodies.unknowns()));
    groups.extend(halves(&scalars, bodies.unknowns() + scalars.unknowns()));
    let elimination = Elimination::of(&[&held, &given[0], &given[1]]).unwrap();
    let start = vec![0.0; bodies.unknowns() + 2 * scalars.unknowns()];
    let outcome = judge(found, &mut Problem::new(&form, spaces), elimination, (start, None), &groups);
    (format!("{first:e} {second:e} {third:e} coupling {coupling}, {name}"), outcome)
}

fn contact(numbers: &mut Numbers) -> (String, Outcome) {
    // A block on a pad: the lower cells are the pad.
    let rows = 2 + 2 * numbers.choice(2);
    let mesh = rectangle([0.0; 2], [1.0; 2], [3, rows], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let stiff = match numbers.choice(3) {
        0 => 1.0,
        1 => numbers.power(0.0, 12.0),
        _ => numbers.power(-6.0, 0.0),
    };
    let of = move |x: &[f64; 2]| if x[1] > 0.5 { stiff } else { 1.0 };
    let (press, rubber) = (numbers.power(-3.0, -0.8), numbers.choice(2) == 0);
    let penalty = numbers.power(2.0, 12.0);
    let theta = [-1.0, 0.0, 1.0][numbers.choice(3)];
    let data = solid::data().mu(of).gap(0.0).penalty(penalty).theta(theta).gamma0(100.0);
    let model = solid::Model { data, regions: solid::Regions::default().contact("bottom") };
    let mut constraints = Constraints::new(&space);
    constraints.fix("top", |_| [0.0, -press]).unwrap();
    let start = Field::zero(&space);
    let case = ScalarCase { space: &space, constraints, start, exact: None };
    let (name, outcome) = match rubber {
        true => solve_and_judge!(case, model.rubber(), numbers),
        false => solve_and_judge!(case, model.nitsche(), numbers),
    };
    (
        format!("stiff {stiff:e} press {press:e} penalty {penalty:e} θ {theta} rubber {rubber}, {name}"),
        outcome,
    )
}
