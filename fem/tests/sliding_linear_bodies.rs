//! Linear bodies whose surfaces slide: systems condensed to what contact touches, on one factor of the bodies' stiffness, have the
//! solutions of the whole tangents.

use forms_fem::pairs::Approach;
use forms_fem::prelude::*;
use forms_fem::solve::{LineSearch, LuSolver, NewtonOptions, SolverPath};

use crate::sliding_pairs::boxes;

#[forms]
mod elastic {
    use crate::sliding_pairs::rubber::ball;

    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma0: Param,
        kappa: Param,
        old: Given<Vector>,
        weight: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;

    fn stress(u: Vector) -> Tensor {
        lambda * div(u) * I + 2 * mu * eps(u)
    }
    fn contact(u: Vector) -> Vector {
        let t = this(stress(u) * n);
        let gamma = gamma0 / this(h);
        let P = dot(t, toward) + gamma * gap;
        let q = t - gamma * jump(u - old);
        ball(q - dot(q, toward) * toward, kappa * neg_part(P)) - neg_part(P) * toward
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)) - dot(weight, v))
            - integral(Touch(u), dot(contact(u), jump(v)) / 2)
    }
}

fn data<const D: usize>(old: Given<[f64; D], D>, kappa: f64) -> elastic::Data<D> {
    elastic::data().lambda(1.3).mu(0.7).gamma0(20.0).kappa(kappa).old(old).weight([0.0; D])
}

/// The path of the upper body: pressed, then moved sideways over more facets than the pattern of one iterate holds.
fn slide<const D: usize>(
    cells: [usize; 2],
    kappa: f64,
    line_search: LineSearch,
    solver: &mut dyn LinearSolver,
) -> Vec<Solved<D>>
where
    Dim: Dimension<D>,
{
    let mut offset = [0.0; D];
    (offset[0], offset[D - 1]) = (0.03, 0.001);
    let mesh = boxes(cells, offset);
    let space = Space::vector(&mesh, 1).unwrap();
    let touch = elastic::Touch::on(Pairing::between("below", "above"));
    let (mut u, mut states) = (Field::zero(&space), vec![]);
    for step in 0..5 {
        let mut plates = Constraints::new(&space);
        plates.fix("bottom", |_| [0.0; D]).unwrap();
        let moved = |axis: usize| match (axis, axis + 1 == D) {
            (_, true) => -0.03,
            (0, _) => 0.12 * f64::from(step),
            _ => 0.0,
        };
        plates.fix("top", |_| -> [f64; D] { std::array::from_fn(moved) }).unwrap();
        let data = data(Given::field(u.clone()), kappa);
        let form = elastic::balance(&data, &elastic::Omega::on("all"), &touch);
        let options = NewtonOptions { line_search, relative_tolerance: 1e-12, ..NewtonOptions::default() };
        let problem = Problem::new(&form, &space).constrained(&plates).start(&u);
        let solved = problem.solver(&mut *solver).options(options).solve().unwrap();
        u = solved.field().clone();
        states.push(solved);
    }
    states
}

fn both_ways<const D: usize>(cells: [usize; 2], kappa: f64, line_search: LineSearch)
where
    Dim: Dimension<D>,
{
    let plain = slide::<D>(cells, kappa, line_search, &mut LuSolver::default());
    let mut condensing = CondensedSolver::default();
    let condensed = slide::<D>(cells, kappa, line_search, &mut condensing);
    for (one, other) in condensed.iter().zip(&plain) {
        assert_eq!(one.history.len(), other.history.len());
        let (one, other) = (one.field().values(), other.field().values());
        let scale = other.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
        let difference = one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(difference < 1e-12 * scale, "{difference:e} of {scale}");
    }
    let report = condensing.report();
    let steps: usize = condensed.iter().map(|solved| solved.iterations()).sum();
    assert_eq!(report.path, Some(SolverPath::Condensed));
    assert!(report.iterations.iter().all(|krylov| *krylov == 0));
    // The factor is made again where the zone has moved on, not at each step.
    assert!(2 * report.factorisations <= steps, "{} of {steps}", report.factorisations);
    // Contact is there all the time, and points have left the lower surface's end.
    let reports = condensed.iter().map(|solved| &solved.pairs[0].report);
    let open: Vec<usize> = reports.clone().map(|report| report.open).collect();
    assert!(reports.clone().all(|report| report.points > 0) && open[4] > open[0], "{open:?}");
}

#[test]
fn frictionless_in_the_plane() {
    both_ways::<2>([20, 23], 0.0, LineSearch::Off);
}

#[test]
fn friction_in_the_plane() {
    both_ways::<2>([20, 23], 0.3, LineSearch::OnResidual);
}

#[test]
fn friction_in_the_plane_under_a_watchdog() {
    both_ways::<2>([20, 23], 0.3, LineSearch::Watchdog);
    let states = [LineSearch::OnResidual, LineSearch::Watchdog]
        .map(|line_search| slide::<2>([20, 23], 0.3, line_search, &mut LuSolver::default()));
    for (one, other) in states[0].iter().zip(&states[1]) {
        let pairs = one.field().values().iter().zip(other.field().values());
        let difference = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(difference < 1e-11, "{difference:e}");
    }
}

#[test]
fn frictionless_in_space() {
    both_ways::<3>([4, 5], 0.0, LineSearch::Off);
}

/// A body that rests on the other one by its weight, from the first touch: its stiffness has no factor, and what condenses hands
/// over to what takes whole tangents.
#[test]
fn a_body_that_only_contact_holds() {
    let mut mesh = Mesh::clone(&boxes::<2>([4, 5], [0.0, 0.3]));
    mesh.name_cells("upper", |x| x[1] > 1.2).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let mut plates = Constraints::new(&space);
    plates.fix("bottom", |_| [0.0; 2]).unwrap();
    plates.fix_component("top", 0, |_| 0.0).unwrap();
    let weight = 0.02;
    let data = data(Given::constant([0.0; 2]), 0.0).weight([0.0, -weight]);
    let pairing = Pairing::between("below", "above");
    let form = elastic::balance(&data, &elastic::Omega::on("all"), &elastic::Touch::on(pairing.clone()));
    let down = Approach { moving: "upper".to_owned(), direction: [0.0, -1.0], overlap: 1e-3 };
    let touch = Assembler::new(&mesh).first_touch(&pairing, 3, &Field::zero(&space), &down).unwrap();
    assert!((touch.distance - 0.3).abs() < 1e-14);
    let of = |solver: &mut dyn LinearSolver| {
        let problem = Problem::new(&form, &space).constrained(&plates).start(&touch.start);
        problem.solver(solver).solve().unwrap()
    };
    let (one, other) = (of(&mut CondensedSolver::default()), of(&mut LuSolver::default()));
    let values = one.field().values().iter().zip(other.field().values());
    let difference = values.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(difference < 1e-10, "{difference:e}");
    // The floor carries both bodies.
    let carried = one.reaction("bottom").unwrap()[1];
    assert!((carried - 2.0 * weight).abs() < 1e-12, "{carried}");
}

/// Bodies that just touch start at the kink of contact's law, which is no place for a derivative: the number of steps is that of a
/// start with some overlap, not that of bodies apart, and the solution is the same.
#[test]
fn a_start_at_the_kink() {
    let body = |low, high, counts| rectangle(low, high, counts, CellShape::Triangle, 1).unwrap();
    let (lower, upper) = (body([0.0, 0.0], [2.0, 1.0], [16, 8]), body([0.7, 1.0], [1.4, 1.5], [7, 5]));
    let mesh = Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)]).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let mut plates = Constraints::new(&space);
    plates.fix("lower bottom", |_| [0.0; 2]).unwrap();
    plates.fix("upper top", |_| [0.01, -0.02]).unwrap();
    let touch = elastic::Touch::on(Pairing::between("lower top", "upper bottom"));
    // Not zero, so that it is taken as it is: the upper body is lowered.
    let mut lowered = vec![0.0; space.unknowns()];
    for cell in mesh.cell_region("upper").unwrap() {
        for node in space.cell_nodes(*cell as usize) {
            lowered[2 * *node as usize + 1] = -1e-6;
        }
    }
    let lowered = Field::from_values(&space, lowered).unwrap();
    for (kappa, most) in [(0.0, 5), (0.3, 9)] {
        let data = data(Given::constant([0.0; 2]), kappa);
        let form = elastic::balance(&data, &elastic::Omega::on("all"), &touch);
        let from = |start: &Field<2>| {
            let line_search = LineSearch::OnResidual;
            let options =
                NewtonOptions { line_search, relative_tolerance: 1e-12, ..NewtonOptions::default() };
            Problem::new(&form, &space).constrained(&plates).start(start).options(options).solve().unwrap()
        };
        let (touching, overlapping) = (from(&Field::zero(&space)), from(&lowered));
        let (steps, others) = (touching.iterations(), overlapping.iterations());
        assert!(steps <= most && steps <= others + 2, "{kappa}: {steps}, with an overlap {others}");
        let pairs = touching.field().values().iter().zip(overlapping.field().values());
        let difference = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(difference < 1e-12, "{kappa}: {difference:e}");
    }
    // A block that nothing pushes stays where it is.
    let mut held = Constraints::new(&space);
    held.fix("lower bottom", |_| [0.0; 2]).unwrap();
    held.fix("upper top", |_| [0.0; 2]).unwrap();
    let data = data(Given::constant([0.0; 2]), 0.3);
    let form = elastic::balance(&data, &elastic::Omega::on("all"), &touch);
    let still = Problem::new(&form, &space).constrained(&held).solve().unwrap();
    assert_eq!((still.iterations(), still.field().values().iter().any(|u| *u != 0.0)), (0, false));
}

/// Pairs that are lost are named where Newton's method fails.
#[test]
fn lost_points_are_named() {
    let mesh = boxes::<2>([4, 5], [0.5, 0.001]);
    let space = Space::vector(&mesh, 1).unwrap();
    let mut plates = Constraints::new(&space);
    plates.fix("bottom", |_| [0.0; 2]).unwrap();
    plates.fix("top", |_| [0.0, -0.05]).unwrap();
    let data = data(Given::constant([0.0; 2]), 0.0);
    let touch = elastic::Touch::on(Pairing::onto("below", "above"));
    let form = elastic::balance(&data, &elastic::Omega::on("all"), &touch);
    let options = NewtonOptions { max_iterations: 1, ..NewtonOptions::default() };
    let error = Problem::new(&form, &space).constrained(&plates).options(options).solve().unwrap_err();
    // A half of the lower surface faces nothing.
    let message = error.to_string();
    let expected =
        "; 6 of 12 points of `Touch` (below onto above) have no opposite point; the deepest overlap is ";
    assert!(message.contains(expected), "{message}");
    // The other note is of the equation that is off most.
    assert_eq!(error.notes.iter().filter(|note| note.contains("no opposite point")).count(), 1);
}
