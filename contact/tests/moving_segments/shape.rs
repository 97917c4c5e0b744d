//! Derivatives by the shape on moving segments: the points move with the mesh. Against differences on meshes that have moved, Taylor tests that start
//! where segments appear, gradients of solved problems by adjoint states.

use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;
use forms_fem::solve::{Elimination, TangentSolver, solve_linear_transposed};
use forms_fem::threads::Threads;

use crate::balance::plates;
use crate::patch::bodies;

#[forms]
pub mod moving {
    use forms_contact::operators::friction::{
        augmented_traction, ball_projection, contact_traction, tangential,
    };
    use forms_contact::operators::linear_elastic::stress;

    #[includes(forms_contact::operators::linear_elastic::Data)]
    pub struct Data {
        gamma: Param,
        theta: Param,
        kappa: Param,
        /// 1 of Nitsche's method, 0 of penalty.
        stressed: Param,
        /// 1 of means over own facets, 0 at points.
        averaged: Param,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;

    fn own(u: Vector) -> Vector {
        this(stressed * stress(u) * n)
    }
    fn augmented(u: Vector) -> Vector {
        augmented_traction(own(u), gap, jump(u), gamma, toward)
    }
    fn traction(u: Vector) -> Vector {
        let P = augmented(u);
        contact_traction(P, kappa * neg_part(dot(P, toward)), toward)
    }
    fn power_of_means(u: Vector, v: Vector) -> Scalar {
        let p = neg_part(mean(dot(augmented(u), toward)));
        let q = ball_projection(mean(tangential(augmented(u), toward)), kappa * p);
        dot(q, mean(tangential(jump(v), toward))) - p * mean(dot(toward, jump(v)))
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let T = traction(u);
        integral(Omega, inner(stress(u), eps(v)))
            - (1 - averaged) / 2
                * integral(Touch(u), dot(T, jump(v)) - theta / gamma * dot(T - own(u), own(v)))
            - averaged / 4
                * (means(Touch(u), 0, power_of_means(u, v)) + means(Touch(u), 1, power_of_means(u, v)))
    }
    pub fn criterion(u: State<Vector>) -> Functional {
        let of_means = means(Touch(u), 0, mean(gap) * mean(this(dot(x, x))));
        integral(Omega, dot(u, u) / 2) + integral(Touch(u), gap * this(dot(x, u))) + averaged * of_means
    }
    pub fn criterion_by(u: State<Vector>, v: Test<Vector>) -> Form {
        derivative(criterion(u), u, v)
    }
    pub fn work(u: State<Vector>, p: State<Vector>) -> Functional {
        balance(u, p) - 2 * criterion(u)
    }
    pub fn by_shape(u: State<Vector>, p: State<Vector>, T: Test<Vector>) -> Form {
        derivative(balance(u, p), shape, T) - 2 * derivative(criterion(u), shape, T)
    }
    pub fn by_state(u: State<Vector>, p: State<Vector>, v: Test<Vector>) -> Form {
        derivative(balance(u, p), u, v)
    }
    pub fn gradient(u: State<Vector>, p: State<Vector>, T: Test<Vector>) -> Form {
        derivative(criterion(u) + balance(u, p), shape, T)
    }
    /// Not available: second derivatives, and the number in a direction.
    pub fn twice(u: State<Vector>, p: State<Vector>, S: State<Vector>, T: Test<Vector>) -> Form {
        derivative(derivative(balance(u, p), shape, S), shape, T)
    }
    pub fn of_an_unknown(u: Unknown<Vector>, T: Test<Vector>) -> Form {
        derivative(integral(Touch(u), gap), shape, T)
    }
    pub fn along(u: State<Vector>, T: State<Vector>) -> Functional {
        derivative(integral(Touch(u), gap), shape, T)
    }
}

/// Nitsche's method with θ and friction κ, or penalty.
#[derive(Clone, Copy, Debug)]
struct Law {
    theta: f64,
    kappa: f64,
    stressed: f64,
    averaged: f64,
}

const LAWS: [Law; 6] = [
    Law { theta: 0.0, kappa: 0.0, stressed: 1.0, averaged: 0.0 },
    Law { theta: 1.0, kappa: 0.0, stressed: 1.0, averaged: 0.0 },
    Law { theta: -1.0, kappa: 0.3, stressed: 1.0, averaged: 0.0 },
    Law { theta: 0.0, kappa: 0.0, stressed: 0.0, averaged: 0.0 },
    Law { theta: 0.0, kappa: 0.3, stressed: 0.0, averaged: 0.0 },
    Law { theta: 0.0, kappa: 0.3, stressed: 1.0, averaged: 1.0 },
];

fn model<const D: usize>(law: Law, pairing: &Pairing) -> moving::Model<D> {
    let Law { theta, kappa, stressed, averaged } = law;
    let data = moving::data().lambda(15.0).mu(10.0).gamma(300.0);
    let data = data.theta(theta).kappa(kappa).stressed(stressed).averaged(averaged);
    moving::Model { data, regions: moving::Regions::default().touch(pairing.clone()) }
}

fn wave<const D: usize>(space: &Arc<Space<D>>, size: f64, phase: f64) -> Field<D> {
    let at = |x: &[f64; D]| -> [f64; D] {
        let angle = 2.0 * x[0] + 1.7 * x[1] + 2.7 * x[D - 1] + phase;
        std::array::from_fn(|k| size * ((1.0 + 0.3 * k as f64) * angle + 1.9 * k as f64).sin())
    };
    Field::interpolate(space, at).unwrap()
}

/// The field with a body moved as a whole, by its cells.
pub fn pressed<const D: usize>(u: Field<D>, body: &str, by: [f64; D]) -> Field<D> {
    let (mut values, space) = (u.values().to_vec(), u.space());
    let cells = space.mesh().cell_region(body).unwrap();
    let mut nodes: Vec<u32> =
        cells.iter().flat_map(|cell| space.cell_nodes(*cell as usize)).copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    for node in nodes {
        (0..D).for_each(|k| values[D * node as usize + k] += by[k]);
    }
    Field::from_values(space, values).unwrap()
}

/// A number on a mesh that has moved by t T, with the fields' nodal values kept.
fn along<const D: usize>(
    motion: &Field<D>,
    fields: &[&Field<D>],
    t: f64,
    value: impl Fn(&Assembler<D>, &[Field<D>]) -> f64,
) -> f64 {
    let mesh = motion.move_mesh(t).unwrap();
    let carried =
        |field: &&Field<D>| field.carried_to(&Space::vector(&mesh, field.space().degree()).unwrap()).unwrap();
    value(&Assembler::new(&mesh), &fields.iter().map(carried).collect::<Vec<_>>())
}

fn difference(h: f64, at: impl Fn(f64) -> f64) -> f64 {
    (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The shape derivatives of a law's work against differences, and those by the state against the transposed tangent.
fn check<const D: usize>(name: &str, u: &Field<D>, law: Law, pairing: &Pairing)
where
    Dim: Dimension<D>,
{
    let (space, mesh) = (u.space(), u.space().mesh());
    let (model, p) = (model::<D>(law, pairing), wave(space, 1.0, 0.9));
    let motion = wave(&Space::of_geometry(mesh).unwrap(), 0.4, 1.7);
    let assembler = Assembler::new(mesh);
    let slope = assembler.residual(&model.by_shape(u, &p), &[], &[motion.space()]).unwrap();
    let size: f64 = slope.iter().zip(motion.values()).map(|(a, b)| (a * b).abs()).sum();
    let slope = dot(&slope, motion.values());
    let at = |t: f64| {
        along(&motion, &[u, &p], t, |assembler, fields| {
            assembler.functional(&model.work(&fields[0], &fields[1])).unwrap()
        })
    };
    // Farther apart, points change between sticking and sliding.
    let off = (difference(1e-5, at) - slope).abs() / size;
    let by_state = assembler.residual(&model.by_state(u, &p), &[], &[space]).unwrap();
    let tangent = assembler.tangent(&model.balance(), &[u], &[space]).unwrap();
    let transposed = tangent.multiply_transposed(p.values()).unwrap();
    let largest = |values: &mut dyn Iterator<Item = f64>| values.map(f64::abs).fold(0.0, f64::max);
    let apart = largest(&mut by_state.iter().zip(&transposed).map(|(a, b)| a - b));
    let apart = apart / largest(&mut transposed.iter().copied());
    println!("{name} {law:?} {pairing}: {slope:.6} off {off:.1e}, by the state {apart:.1e}");
    assert!(off < 1e-9 && apart < 1e-12, "{name} {law:?} {pairing}: {off:e} {apart:e}");
}

#[test]
fn shape_derivatives_are_those_of_differences() {
    for (shape, geometry, degree) in
        [(CellShape::Quadrilateral, 1, 1), (CellShape::Triangle, 1, 2), (CellShape::Quadrilateral, 2, 2)]
    {
        let mesh = plates(shape, geometry, [7, 9]);
        let space = Space::vector(&mesh, degree).unwrap();
        let u = pressed(wave(&space, 0.03, 0.4), "upper", [0.05, -0.12]);
        for pairing in
            [Pairing::between("lower top", "upper bottom"), Pairing::onto("upper bottom", "lower top")]
        {
            for law in LAWS {
                check(
                    &format!("{shape:?} {geometry} {degree}"),
                    &u,
                    law,
                    &pairing.clone().at(PairQuadrature::Pieces),
                );
            }
        }
        // The same on whole facets, whose points do not move.
        check("whole facets", &u, LAWS[2], &Pairing::between("lower top", "upper bottom"));
    }
}

/// In space, on tetrahedra and hexahedra.
#[test]
fn shape_derivatives_in_space_are_those_of_differences() {
    for (shape, degree) in crate::space::CASES {
        let mesh = crate::space::plates([5, 4], shape, degree);
        let space = Space::vector(&mesh, degree).unwrap();
        let u = pressed(wave(&space, 0.03, 0.4), "upper", [0.05, 0.03, -0.08]);
        let pairing = Pairing::between("lower top", "upper bottom").at(PairQuadrature::Pieces);
        for law in [LAWS[1], LAWS[2], LAWS[4], LAWS[5]] {
            check(&format!("{shape:?} {degree}"), &u, law, &pairing);
        }
    }
}

/// Order two where a segment appears: nodes of the block face nodes of the layer, and its ends lie inside of facets.
#[test]
fn taylor_tests_by_the_shape_start_where_segments_appear() {
    for (shape, degree) in [(CellShape::Quadrilateral, 1), (CellShape::Triangle, 2)] {
        let layer = rectangle([0.0, -0.5], [3.0, 0.0], [6, 2], shape, 1).unwrap();
        let block = rectangle([0.3, 0.0], [1.7, 0.5], [4, 2], shape, 1).unwrap();
        let mesh = Mesh::of_bodies(&[("layer", &layer), ("block", &block)]).unwrap();
        let space = Space::vector(&mesh, degree).unwrap();
        let u = pressed(Field::zero(&space), "block", [0.0, -0.03]);
        let (p, pairing) = (wave(&space, 1.0, 0.9), Pairing::between("layer top", "block bottom"));
        for (law, phase) in [(LAWS[0], 0.3), (LAWS[1], 1.7), (LAWS[3], 1.7), (LAWS[5], 1.7)] {
            let model = model::<2>(law, &pairing.clone().at(PairQuadrature::Pieces));
            let motion = wave(&Space::of_geometry(&mesh).unwrap(), 0.3, phase);
            let slope =
                Assembler::new(&mesh).residual(&model.by_shape(&u, &p), &[], &[motion.space()]).unwrap();
            let slope = dot(&slope, motion.values());
            let at = |t: f64| {
                along(&motion, &[&u, &p], t, |assembler, fields| {
                    assembler.functional(&model.work(&fields[0], &fields[1])).unwrap()
                })
            };
            let (start, steps) = (at(0.0), (0..5).map(|k| 1e-2 * 0.5_f64.powi(k)));
            let rests: Vec<f64> = steps.map(|t| (at(t) - start - t * slope).abs()).collect();
            let orders: Vec<f64> = rests.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
            println!("{shape:?} {degree} {law:?}: {orders:.3?}");
            assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.05), "{shape:?} {degree} {orders:?}");
        }
    }
}

/// The gradient of a solved problem with friction by its adjoint state, against differences of problems on meshes that have moved.
#[test]
fn gradients_by_adjoint_states_are_those_of_differences() {
    let mesh = bodies(CellShape::Quadrilateral, [8, 5]);
    let space = Space::vector(&mesh, 1).unwrap();
    let pairing = Pairing::between("layer top", "block bottom").at(PairQuadrature::Pieces);
    for law in [LAWS[0], LAWS[4], LAWS[5]] {
        let model = model::<2>(law, &pairing);
        let held = |space: &Arc<Space<2>>| {
            let mut held = Constraints::new(space);
            held.fix("layer bottom", |_| [0.0; 2]).unwrap();
            held.fix("block top", |_| [0.27, -0.03]).unwrap();
            held
        };
        let start = pressed(Field::zero(&space), "block", [0.27, -0.01]);
        let solved = |start: &Field<2>| {
            let held = held(start.space());
            let options = NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() };
            let form = model.balance();
            let mut problem =
                Problem::new(&form, start.space()).constrained(&held).options(options).start(start);
            problem.solve().unwrap().into_field()
        };
        let (u, assembler) = (solved(&start), Assembler::new(&mesh));
        let load: Vec<f64> = assembler.residual(&model.criterion_by(&u), &[], &[&space]).unwrap();
        let load: Vec<f64> = load.iter().map(|load| -load).collect();
        let mut elimination = Elimination::of(&[&held(&space).homogeneous()]).unwrap();
        let tangent = assembler.tangent(&model.balance(), &[&u], &[&space]).unwrap();
        let adjoint =
            solve_linear_transposed(&tangent.into(), &load, &mut elimination, &mut TangentSolver::default());
        let p = Field::from_values(&space, adjoint.unwrap().solution).unwrap();
        let motion = wave(&Space::of_geometry(&mesh).unwrap(), 0.1, 1.7);
        let gradient = assembler.residual(&model.gradient(&u, &p), &[], &[motion.space()]).unwrap();
        let slope = dot(&gradient, motion.values());
        let at = |t: f64| {
            along(&motion, &[&u], t, |assembler, fields| {
                assembler.functional(&model.criterion(solved(&fields[0]))).unwrap()
            })
        };
        let off = (difference(2e-4, at) - slope).abs() / slope.abs();
        println!("{law:?}: {slope:.6e} off {off:.1e}");
        assert!(off < 1e-7, "{law:?}: {off:e}");
    }
}

/// The same bits on any number of threads; second derivatives, numbers in a direction and derivatives of unknowns' integrals are refused by name.
#[test]
fn bits_and_refusals_of_shape_derivatives() {
    let flat = |cells: [usize; 2], low: f64| {
        structured(cells, CellShape::Quadrilateral, 1, move |[s, t]: [f64; 2]| {
            [3.0 * s, low + 0.2 * t + 0.02 * (9.0 * s).sin()]
        })
        .unwrap()
    };
    let mesh =
        Mesh::of_bodies(&[("lower", &flat([211, 1], -0.2)), ("upper", &flat([173, 1], 0.01))]).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let (u, p) = (pressed(wave(&space, 0.003, 0.4), "upper", [0.01, -0.02]), wave(&space, 1.0, 0.9));
    let pairing = Pairing::between("lower top", "upper bottom").at(PairQuadrature::Pieces);
    for law in [LAWS[2], LAWS[5]] {
        let model = model::<2>(law, &pairing);
        let gradient = |threads: usize| {
            let assembler = Assembler::new(&mesh).with_threads(Threads::new(threads));
            assembler.residual(&model.by_shape(&u, &p), &[], &[&space]).unwrap()
        };
        let one = gradient(1);
        assert!([2, 3, 7].into_iter().all(|threads| gradient(threads) == one));
    }
    let (assembler, model) = (Assembler::new(&mesh), model::<2>(LAWS[2], &pairing));
    let errors = [
        assembler.residual(&model.twice(&u, &p, &p), &[], &[&space]).unwrap_err(),
        assembler.residual(&model.of_an_unknown(), &[&u], &[&space]).unwrap_err(),
        assembler.functional(&model.along(&u, &p)).unwrap_err(),
    ];
    for error in errors {
        assert!(error.to_string().contains("holds them"), "{error}");
    }
}
