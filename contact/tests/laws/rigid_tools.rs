//! Rigid tools compared with what is known: meshed bodies whose nodes are all prescribed, resultants, an exact disk, tools that a given force
//! presses.

use forms_contact::ContactProblem;
use forms_contact::laws::capsule as round;
use forms_contact::laws::moving_obstacle;
use forms_contact::laws::sliding_bodies as sliding;
use forms_contact::laws::two_bodies as law;
use forms_fem::constraints::RigidMap;
use forms_fem::mesh::{RigidSurface, structured};
use forms_fem::prelude::*;
use forms_fem::solve::RigidLoads;

use crate::setting::{LAMBDA, MU, YOUNG, along, check_tangent, wave};

/// Data of both laws, with the whole of the contact integral on the body.
pub fn data<const D: usize>(friction: f64, direction: usize) -> law::Data<D> {
    law::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(20.0 * YOUNG)
        .share(1.0)
        .friction(friction)
        .force_direction(along(direction, 1.0))
}

/// A block whose base is held, and an indenter above it.
fn block<const D: usize>() -> Mesh<D> {
    let (cells, shape) =
        if D == 2 { ([8; D], CellShape::Quadrilateral) } else { ([4; D], CellShape::Hexahedron) };
    let mut cells = cells;
    cells[D - 1] = if D == 2 { 4 } else { 2 };
    let place =
        |t: [f64; D]| -> [f64; D] { std::array::from_fn(|k| if k == D - 1 { t[k] } else { 2.0 * t[k] }) };
    structured(cells, shape, 1, place).unwrap()
}

/// Narrower than the block, with an end that is not parallel to it.
fn indenter<const D: usize>() -> Mesh<D> {
    let shape = if D == 2 { CellShape::Quadrilateral } else { CellShape::Hexahedron };
    let place = |t: [f64; D]| -> [f64; D] {
        std::array::from_fn(|k| if k == D - 1 { 1.0 + 0.6 * t[k] + 0.05 * t[0] } else { 0.3 + 1.1 * t[k] })
    };
    structured([2; D], shape, 1, place).unwrap()
}

/// Down, aside and turned.
fn motion<const D: usize>() -> RigidMap<D> {
    let mut turned: [[f64; D]; D] = std::array::from_fn(|k| along(k, 1.0));
    let (sin, cos) = 0.02_f64.sin_cos();
    (turned[0][0], turned[0][D - 1]) = (cos, -sin);
    (turned[D - 1][0], turned[D - 1][D - 1]) = (sin, cos);
    let mut by = along::<D>(0, 0.03);
    by[D - 1] = -0.06;
    RigidMap::rotation(turned, [0.8; D]).then(&RigidMap::translation(by))
}

/// Options for answers that are compared digit by digit.
fn tight() -> NewtonOptions {
    NewtonOptions {
        relative_tolerance: 1e-12,
        line_search: LineSearch::OnResidual,
        ..NewtonOptions::default()
    }
}

fn pressed<const D: usize>(
    mesh: &Mesh<D>,
    names: [&str; 3],
    tool: &str,
    degree: usize,
    threads: usize,
) -> (ContactProblem<D, sliding::Model<D>>, Solved<D>)
where
    Dim: Dimension<D>,
{
    let [body, base, top] = names;
    let space = Space::vector(mesh, degree).unwrap();
    let mut constraints = Constraints::new(&space);
    constraints.fix(base, |_| [0.0; D]).unwrap();
    constraints.move_rigidly(tool, &motion()).unwrap();
    let opposite = if tool == "indenter" { "indenter bottom" } else { tool };
    let touch = Pairing::onto(top, opposite).within_reach(0.3);
    let regions = sliding::Regions::default().omega(body).touch(touch).gamma_n(base);
    let model = sliding::Model { data: data::<D>(0.3, 0), regions };
    let problem = ContactProblem::new(&space, model, constraints)
        .quadrature(Quadrature::Degree(4))
        .threads(Threads::new(threads));
    let solved = problem.direct().unwrap().options(tight()).solve().unwrap();
    (problem, solved)
}

fn with_tool<const D: usize>() -> Mesh<D> {
    let surface = RigidSurface::of_boundary(&indenter::<D>(), "bottom").unwrap();
    block::<D>().with_rigid_surfaces(&[("tool", &surface)]).unwrap()
}

/// A tool is the same obstacle as a body of cells whose nodes all follow its motion, turned and pressed with friction.
fn as_a_meshed_body<const D: usize>(degree: usize)
where
    Dim: Dimension<D>,
{
    let bodies = Mesh::of_bodies(&[("block", &block::<D>()), ("indenter", &indenter::<D>())]).unwrap();
    let names = ["block", "block bottom", "block top"];
    let (_, meshed) = pressed(&bodies, names, "indenter", degree, 2);
    let (_, rigid) = pressed(&with_tool::<D>(), ["all", "bottom", "top"], "tool", degree, 2);
    let (found, expected) = (rigid.reaction("tool").unwrap(), meshed.reaction("indenter").unwrap());
    let scale = expected[D - 1].abs();
    assert!(scale > 1.0, "{expected:?}");
    for (found, expected) in found.iter().zip(&expected) {
        assert!((found - expected).abs() < 1e-10 * scale, "{found} is not {expected}");
    }
    let moments = [&rigid, &meshed].map(|solved| {
        let name =
            if solved.field().space().mesh().cell_region("tool").is_ok() { "tool" } else { "indenter" };
        solved.reaction_moment(name, [0.0; D]).unwrap()
    });
    for (found, expected) in moments[0].iter().zip(&moments[1]) {
        assert!((found - expected).abs() < 1e-10 * scale, "{moments:?}");
    }
    for x in [[0.5; D], [0.35; D], [0.9; D]] {
        let (found, expected) = (rigid.field().evaluate(&x).unwrap(), meshed.field().evaluate(&x).unwrap());
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-10 * 0.06, "at {x:?}: {found} is not {expected}");
        }
    }
}

#[test]
fn a_tool_is_a_body_of_which_all_nodes_are_prescribed() {
    as_a_meshed_body::<2>(1);
    as_a_meshed_body::<2>(2);
    as_a_meshed_body::<3>(1);
}

#[forms]
mod moment {
    use forms_contact::laws::sliding_bodies::opposite_traction;

    #[includes(forms_contact::laws::two_bodies::Data)]
    pub struct Data {
        /// A quarter turn.
        pub turn: Param<Tensor>,
    }
    #[pairs]
    pub struct Touch;

    /// ∫ y × T about the origin, at the points of the tool.
    pub fn of_contact(u: State<Vector>) -> Functional {
        integral(Touch(u), dot(opposite_traction(u), other(turn * (x + u))))
    }
}

/// ∫ y × T over the points of the tool, about the origin, turning from one axis to another.
fn moment_of_contact<const D: usize>(
    problem: &ContactProblem<D, sliding::Model<D>>,
    u: &Field<D>,
    [from, to]: [usize; 2],
) -> f64
where
    Dim: Dimension<D>,
{
    let mut turn = [[0.0; D]; D];
    (turn[from][to], turn[to][from]) = (-1.0, 1.0);
    let data = moment::data_from(problem.law.data.clone()).turn(turn);
    let touch = moment::Touch::on(Pairing::onto("top", "tool").within_reach(0.3));
    problem.assembler.functional(&moment::of_contact(&data, &touch, u)).unwrap()
}

/// Balance of a tool: what holds it is the sum of the tractions on it, and its moment is theirs.
#[test]
fn reactions_are_the_resultant_of_the_tractions() {
    let mesh = with_tool::<2>();
    let (problem, solved) = pressed(&mesh, ["all", "bottom", "top"], "tool", 2, 2);
    let held = solved.reaction("tool").unwrap();
    let floor = solved.reaction("bottom").unwrap();
    for axis in 0..2 {
        let mut model = problem.law.clone();
        model.data.force_direction = Given::constant(along(axis, 1.0));
        let force = problem.assembler.functional(&model.contact_force(solved.field())).unwrap();
        assert!((held[axis] - force).abs() < 1e-12 * held[1].abs(), "{} is not {force}", held[axis]);
        assert!((held[axis] + floor[axis]).abs() < 1e-10 * held[1].abs(), "{held:?} and {floor:?}");
    }
    let expected = moment_of_contact(&problem, solved.field(), [0, 1]);
    let found = solved.reaction_moment("tool", [0.0; 2]).unwrap()[0];
    assert!((found - expected).abs() < 1e-12 * expected.abs(), "{found} is not {expected}");
}

/// The state and the direction: no symmetry in the body, affine on the tool's cell.
fn affine_on_tool<const D: usize>(space: &Arc<Space<D>>, size: f64, phase: f64) -> Field<D> {
    let mut values = wave(space, size, phase).values().to_vec();
    let nodes = space.nodes_on("tool").unwrap();
    for node in nodes {
        let x = space.positions()[node as usize];
        for k in 0..D {
            let slope: f64 = (0..D).map(|j| x[j] * (1.3 * (D * k + j) as f64 + phase).cos()).sum();
            values[node as usize * D + k] = 0.3 * size * ((phase + k as f64).sin() + slope);
        }
    }
    Field::from_values(space, values).unwrap()
}

/// The tangent, with respect to the tool's unknowns too: also where the tool is turned and stretched.
fn taylor<const D: usize>(degree: usize)
where
    Dim: Dimension<D>,
{
    let (problem, solved) = pressed(&with_tool::<D>(), ["all", "bottom", "top"], "tool", degree, 2);
    let u = solved.field();
    let space = u.space();
    let off = affine_on_tool(space, 3e-3, 0.7);
    let u = Field::combination(&[(1.0, u), (1.0, &off)]).unwrap();
    let direction = affine_on_tool(space, 2e-3, 2.1);
    let mut still = direction.values().to_vec();
    for node in space.nodes_on("tool").unwrap() {
        still[node as usize * D..][..D].fill(0.0);
    }
    let tool =
        Field::combination(&[(1.0, &direction), (-1.0, &Field::from_values(space, still).unwrap())]).unwrap();
    for direction in [&direction, &tool] {
        check_tangent(&format!("{D}D"), &problem.assembler, &problem.law.direct(), &[&u], &[direction]);
    }
}

#[test]
fn tangents_with_the_unknowns_of_the_tool() {
    taylor::<2>(2);
    taylor::<3>(1);
}

#[test]
fn threads_do_not_change_a_bit() {
    let mesh = with_tool::<3>();
    let names = ["all", "bottom", "top"];
    let (_, one) = pressed(&mesh, names, "tool", 1, 1);
    let (_, three) = pressed(&mesh, names, "tool", 1, 3);
    assert_eq!(one.field().values(), three.field().values());
    assert_eq!(one.residual, three.residual);
}

/// A tool with a motion that is unknown, on which a force acts out of its middle: contact holds it, by force and moment, and it stays rigid.
fn pressed_by_a_force<const D: usize>(couple: &[f64])
where
    Dim: Dimension<D>,
{
    let mesh = with_tool::<D>();
    let space = Space::vector(&mesh, 1).unwrap();
    let touch = Pairing::onto("top", "tool").within_reach(0.3);
    let mut point = [0.8; D];
    point[D - 1] = 1.5;
    let mut force = along::<D>(0, 0.4);
    force[D - 1] = -6.0;
    // In contact, the end of the tool along the block: a tool that touches nothing is held by nothing.
    let mut turn: [[f64; D]; D] = std::array::from_fn(|k| along(k, 1.0));
    let (sin, cos) = (-0.045_f64).sin_cos();
    (turn[0][0], turn[0][D - 1], turn[D - 1][0], turn[D - 1][D - 1]) = (cos, -sin, sin, cos);
    let mut centre = [0.8; D];
    centre[D - 1] = 1.02;
    let mut motion = RigidMap::rotation(turn, centre).then(&RigidMap::translation(along(D - 1, -0.03)));
    let mut start: Option<Field<D>> = None;
    let mut last = None;
    // Moments balance where the solution began to turn from: what is left to turn falls by a factor from one to the next.
    for round in 0.. {
        assert!(round < 16, "the motion does not settle");
        let mut constraints = Constraints::new(&space);
        constraints.fix("bottom", |_| [0.0; D]).unwrap();
        constraints.rigid_body_from("tool", &motion).unwrap();
        let mut loads = RigidLoads::new(&space);
        loads.force("tool", point, force).unwrap();
        loads.couple("tool", couple, &motion).unwrap();
        let regions = sliding::Regions::default().touch(touch.clone()).gamma_n("bottom");
        let model = sliding::Model { data: data::<D>(0.5, 0), regions };
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
        let begin = start.take().unwrap_or_else(|| {
            let mut down = Constraints::new(&space);
            down.move_rigidly("tool", &motion).unwrap();
            let mut values = vec![0.0; space.unknowns()];
            down.apply(&mut values);
            Field::from_values(&space, values).unwrap()
        });
        let problem = ContactProblem::new(&space, model, constraints).assembler(assembler);
        let solved = problem.direct().unwrap().loaded(&loads).start(&begin).options(tight()).solve().unwrap();
        let (nearest, away) = RigidMap::nearest(solved.field(), "tool").unwrap();
        let entries = nearest.rotation.as_flattened().iter().zip(motion.rotation.as_flattened());
        let turned = entries.map(|(now, before)| (now - before).abs()).fold(0.0, f64::max);
        println!("{D}D round {round}: {} steps, turned by {turned:.1e}", solved.iterations());
        motion = nearest;
        start = Some(solved.field().clone());
        if turned < 1e-11 {
            assert!(away < 1e-13, "{away:e} from rigid");
            last = Some((problem, solved));
            break;
        }
    }
    let (problem, solved) = last.unwrap();
    let angle = motion.rotation[D - 1][0];
    assert!(angle.abs() > 0.02, "{angle}");
    for (axis, force) in force.iter().enumerate() {
        let mut model = problem.law.clone();
        model.data.force_direction = Given::constant(along(axis, 1.0));
        let found = problem.assembler.functional(&model.contact_force(solved.field())).unwrap();
        assert!((found - force).abs() < 1e-10 * 6.0, "along {axis}: {found} is not {force}");
    }
    // The moment of the tractions on the tool about the point of the force. On the body it is another by what friction makes of a gap.
    let at = motion.apply(&point);
    for (axis, couple) in couple.iter().enumerate() {
        let [i, j] = if D == 2 { [0, 1] } else { [[1, 2], [2, 0], [0, 1]][axis] };
        let about = at[i] * force[j] - at[j] * force[i];
        let found = moment_of_contact(&problem, solved.field(), [i, j]) - about;
        assert!((found - couple).abs() < 1e-10 * 6.0, "about {axis}: {found} is not {couple}");
    }
    let floor = solved.reaction("bottom").unwrap();
    assert!((0..D).all(|k| (floor[k] + force[k]).abs() < 1e-9), "{floor:?}");
}

#[test]
fn a_force_presses_a_tool_until_contact_holds_it() {
    pressed_by_a_force::<2>(&[0.1]);
    pressed_by_a_force::<3>(&[0.05, -0.1, 0.02]);
}

/// The depth to which the disk goes, in the given number of steps.
const DEPTH: f64 = 0.05;
const DEPTHS: usize = 5;

/// The force on the disk of the same place and depth by its exact distance.
fn exact_disk() -> f64 {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [40, 20], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let mut u = Field::zero(&space);
    let mut force = 0.0;
    for step in 1..=DEPTHS {
        let centre = [1.0, 1.8 - DEPTH * step as f64 / DEPTHS as f64];
        let still = RigidMap::translation([0.0; 2]).rotation;
        let obstacle = moving_obstacle::data()
            .lambda(LAMBDA)
            .mu(MU)
            .gamma0(20.0 * YOUNG)
            .centre(centre)
            .rotation(still)
            .centre_before(centre)
            .rotation_before(still);
        let data = round::data_from(obstacle).radius(0.8);
        let mut constraints = Constraints::new(&space);
        constraints.fix("bottom", |_| [0.0; 2]).unwrap();
        let model = round::Model { data, regions: round::Regions::default().gamma_c("top") };
        let problem = ContactProblem::new(&space, model, constraints).quadrature(Quadrature::Degree(12));
        let solved = problem.direct().unwrap().options(tight()).start(&u).solve().unwrap();
        force = -solved.reaction("bottom").unwrap()[1];
        u = solved.into_field();
    }
    force
}

/// A disk as a polygon, pressed into the block's top: the force comes nearer to its limit by the square of the length of a side.
#[test]
fn a_polygon_comes_to_be_a_disk() {
    let force = |sides: usize| {
        let at = |k: usize| {
            let angle = std::f64::consts::PI * (1.0 + k as f64 / sides as f64);
            [1.0 + 0.8 * angle.cos(), 1.8 + 0.8 * angle.sin()]
        };
        let disk = RigidSurface::along(&(0..=sides).map(at).collect::<Vec<_>>()).unwrap();
        let body = rectangle([0.0; 2], [2.0, 1.0], [40, 20], CellShape::Quadrilateral, 1).unwrap();
        let mesh = body.with_rigid_surfaces(&[("tool", &disk)]).unwrap();
        let space = Space::vector(&mesh, 1).unwrap();
        let mut u = Field::zero(&space);
        let mut force = 0.0;
        for step in 1..=DEPTHS {
            let mut constraints = Constraints::new(&space);
            constraints.fix("bottom", |_| [0.0; 2]).unwrap();
            let down = RigidMap::translation([0.0, -DEPTH * step as f64 / DEPTHS as f64]);
            constraints.move_rigidly("tool", &down).unwrap();
            let touch = Pairing::onto("top", "tool").within_reach(0.3);
            let regions = sliding::Regions::default().touch(touch).gamma_n("bottom");
            let model = sliding::Model { data: data::<2>(0.0, 1), regions };
            let problem = ContactProblem::new(&space, model, constraints).quadrature(Quadrature::Degree(12));
            let solved = problem.direct().unwrap().options(tight()).start(&u).solve().unwrap();
            force = solved.reaction("tool").unwrap()[1];
            u = solved.into_field();
        }
        force
    };
    let forces = [24, 48, 96, 768].map(force);
    let errors = [0, 1, 2].map(|k| (forces[k] / forces[3] - 1.0).abs());
    let exact = exact_disk();
    println!("{forces:?}, {errors:?}, exact disk {exact}");
    assert!(errors[2] < 2e-3 && errors[0] / errors[2] > 8.0, "{errors:?}");
    assert!((forces[3] / exact - 1.0).abs() < 2e-4, "{} and {exact}", forces[3]);
}
