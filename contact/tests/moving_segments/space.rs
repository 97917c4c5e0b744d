//! Moving segments in space, of degrees one and two: the patch test, balance, tangents by differences and Taylor tests, the same bits on any number of
//! threads.

use std::f64::consts::PI;

use forms_contact::laws::sliding_bodies as sliding;
use forms_contact::laws::two_bodies as fixed;
use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::{RigidSurface, structured};
use forms_fem::prelude::*;
use forms_fem::threads::Threads;

use crate::balance::model as springs_between;
use crate::patch::{DOWN, Method, data_of, layers, methods, pressure_of};
use crate::tangent::{off_differences, taylor_order};

/// Cells, and the degree of displacements and, where surfaces bend, of the mesh.
pub const CASES: [(CellShape, usize); 4] = [
    (CellShape::Tetrahedron, 1),
    (CellShape::Hexahedron, 1),
    (CellShape::Tetrahedron, 2),
    (CellShape::Hexahedron, 2),
];

fn law(method: Method, pairing: &Pairing) -> layers::Model<3> {
    let cover = Pairing::onto("lower top", "upper bottom");
    let regions = layers::Regions::default()
        .surface("lower top")
        .touch(pairing.clone().at(PairQuadrature::Pieces))
        .cover(cover.at(PairQuadrature::Pieces));
    layers::Model { data: data_of(method, pairing), regions }
}

fn pairings(lower: &str, upper: &str) -> [Pairing; 3] {
    [Pairing::between(lower, upper), Pairing::onto(lower, upper), Pairing::onto(upper, lower)]
}

pub fn two_bodies(lower: &Mesh<3>, upper: &Mesh<3>) -> Mesh<3> {
    Mesh::clone(&Mesh::of_bodies(&[("lower", lower), ("upper", upper)]).unwrap())
}

/// A layer with a block on a part of it; their nodes do not match.
pub fn layer_and_block(corner: [f64; 2], shape: CellShape) -> Mesh<3> {
    let layer = cuboid([0.0, 0.0, -0.5], [2.0, 1.5, 0.0], [4, 3, 1], shape, 1).unwrap();
    let ends = corner.map(|x| x + 0.9);
    let block = cuboid([corner[0], corner[1], 0.0], [ends[0], ends[1], 0.5], [3, 2, 1], shape, 1).unwrap();
    two_bodies(&layer, &block)
}

/// Bent plates of a degree, the upper one smaller.
pub fn plates(cells: [usize; 2], shape: CellShape, degree: usize) -> Mesh<3> {
    let wave = |x: f64, y: f64| 0.12 * (1.7 * x).sin() + 0.07 * (2.3 * y + x).sin();
    let plate = |count: usize, low: f64, side: f64, rise: f64| {
        structured([count, count - 1, 1], shape, degree, |[s, t, r]: [f64; 3]| {
            let (x, y) = (low + side * s, 0.8 * low + side * t);
            [x, y, rise + 0.3 * r + wave(x, y)]
        })
        .unwrap()
    };
    two_bodies(&plate(cells[0], 0.0, 2.0, -0.3), &plate(cells[1], 0.33, 1.3, 0.02))
}

fn wave(space: &Arc<Space<3>>, size: f64, phase: f64) -> Field<3> {
    Field::interpolate(space, |x| {
        let angle = 2.0 * x[0] + 1.7 * x[1] + 2.7 * x[2] + phase;
        [0.0, 1.0, 2.0].map(|k| size * ((1.0 + 0.3 * k) * angle + 1.9 * k).sin())
    })
    .unwrap()
}

/// A field with a body moved as a whole.
pub fn moved(u: &Field<3>, body: &str, by: [f64; 3]) -> Field<3> {
    let space = u.space();
    let mut values = u.values().to_vec();
    let cells = space.mesh().cell_region(body).unwrap();
    let mut nodes: Vec<u32> =
        cells.iter().flat_map(|cell| space.cell_nodes(*cell as usize)).copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    for node in nodes {
        (0..3).for_each(|k| values[3 * node as usize + k] += by[k]);
    }
    Field::from_values(space, values).unwrap()
}

/// The largest error of the stress, as a part of the pressure, with the block moved aside.
fn error_of_stress(
    (mesh, degree): (&Mesh<3>, usize),
    method: Method,
    pairing: &Pairing,
    aside: [f64; 2],
) -> f64 {
    let (law, pressure) = (law(method, pairing), pressure_of(method));
    let space = Space::vector(mesh, degree).unwrap();
    let mut held = Constraints::new(&space);
    let [x, y] = aside;
    held.fix("lower bottom", |_| [0.0; 3]).unwrap();
    held.fix("upper top", |_| [x, y, -DOWN]).unwrap();
    for (side, axis) in [("left", 0), ("right", 0), ("front", 1), ("back", 1)] {
        held.fix_component(&format!("lower {side}"), axis, |_| 0.0).unwrap();
        held.fix_component(&format!("upper {side}"), axis, |_| aside[axis]).unwrap();
    }
    let start = moved(&Field::zero(&space), "upper", [x, y, -1e-3]);
    let options = NewtonOptions { relative_tolerance: 1e-13, ..NewtonOptions::default() };
    let u = if method == Method::Multiplier {
        let traces = Space::on_facets(mesh, "upper bottom", degree).unwrap();
        let none = Field::interpolate(&traces, |_| -0.1).unwrap();
        let problem = Problem::new(&law.multiplier(), [&space, &traces]);
        let mut problem = problem.constrained(&held).options(options).start([&start, &none]);
        problem.solve().unwrap_or_else(|error| panic!("{aside:?}: {error}")).fields[0].clone()
    } else {
        let form = method.form(&law);
        let mut problem = Problem::new(&form, &space).constrained(&held).options(options).start(&start);
        problem.solve().unwrap_or_else(|error| panic!("{aside:?}: {error}")).into_field()
    };
    let stress = law.stress(&u);
    let stress = Assembler::new(mesh).at_quadrature_points(&stress, Entity::Cells, "all", degree).unwrap();
    let off =
        |value: &Vec<f64>| (value[8] + pressure).abs().max(value[2].abs()).max(value[5].abs()) / pressure;
    stress.values.iter().map(off).fold(0.0, f64::max)
}

/// All laws over one surface and both, triangles and squares: one pressure everywhere while the block slides.
#[test]
fn pressure_is_constant_in_space() {
    for (shape, degree) in CASES {
        let mesh = layer_and_block([0.15, 0.1], shape);
        for method in methods(degree) {
            for pairing in pairings("lower top", "upper bottom") {
                // Multipliers of what is not covered would be free.
                if method == Method::Multiplier && pairing.surfaces[0].own != "upper bottom" {
                    continue;
                }
                // Of degree two, three in a sweep only.
                let places = [[0.137, 0.221], [0.0, 0.0], [0.35, -0.1], [0.6, 0.4]];
                let some = degree == 2 && std::env::var_os("FORMS_SWEEPS").is_none();
                let places = &places[..if some { 1 } else { 4 }];
                let worst =
                    places.iter().map(|aside| error_of_stress((&mesh, degree), method, &pairing, *aside));
                let worst = worst.fold(0.0, f64::max);
                println!("{shape:?} {degree} {method:?}, {pairing}: {worst:.1e}");
                assert!(worst < 1e-11, "{shape:?} {degree} {method:?} {pairing}: {worst:e}");
            }
        }
    }
}

/// Forces and moments of bent plates vanish to rounding.
#[test]
fn forces_and_moments_balance_in_space() {
    for (shape, degree) in CASES {
        let mesh = plates([5, 4], shape, degree);
        let space = Space::vector(&mesh, degree).unwrap();
        let places = Field::interpolate(&space, |x| *x).unwrap();
        for pairing in pairings("lower top", "upper bottom") {
            let law = springs_between(&pairing);
            for (phase, form) in
                [(0.0, law.forces()), (1.9, law.forces_of_facets()), (3.1, law.forces_of_vertices())]
            {
                let u = wave(&space, 0.04, phase);
                let forces = Assembler::new(&mesh).residual(&form, &[&u], &[&space]).unwrap();
                let (mut sums, mut size) = ([0.0; 6], 0.0);
                for (node, f) in forces.chunks_exact(3).enumerate() {
                    let at = |k: usize| places.values()[3 * node + k % 3] + u.values()[3 * node + k % 3];
                    for k in 0..3 {
                        sums[k] += f[k];
                        sums[3 + k] += at(k + 1) * f[(k + 2) % 3] - at(k + 2) * f[(k + 1) % 3];
                        size += f[k].abs();
                    }
                }
                let off = sums.iter().map(|sum| sum.abs() / size).fold(0.0, f64::max);
                println!("{pairing} {phase}: {off:.1e} of {size:.2}");
                assert!(size > 0.1 && off < 1e-13, "{pairing} {phase}: {sums:?}");
            }
        }
    }
}

/// Springs between bent plates, Nitsche's method with three θ, friction on rubber: tangents against differences.
#[test]
fn tangents_in_space_are_those_of_differences() {
    for (shape, degree) in CASES {
        let mesh = plates([5, 4], shape, degree);
        let space = Space::vector(&mesh, degree).unwrap();
        let assembler = Assembler::new(&mesh);
        let (u, w) = (wave(&space, 0.03, 0.4), wave(&space, 1.0, 1.7));
        let check = |name: &str, form: &Form<3>, u: &Field<3>| {
            let off = off_differences(&assembler, form, (u, &w), 1e-5);
            println!("{shape:?} {degree} {name}: {off:.1e}");
            assert!(off < 1e-9, "{shape:?} {degree} {name}: {off:e}");
        };
        for pairing in pairings("lower top", "upper bottom") {
            let pressed = moved(&u, "upper", [0.05, 0.03, -0.08]);
            let springs = springs_between(&pairing);
            check("springs", &springs.forces(), &u);
            check("springs of facets", &springs.forces_of_facets(), &u);
            check("springs of vertices", &springs.forces_of_vertices(), &u);
            for method in
                [-1.0, 0.0, 1.0].map(Method::Nitsche).into_iter().chain([Method::of_means(1.0, degree)])
            {
                check(&format!("{method:?}"), &method.form(&law(method, &pairing)), &pressed);
            }
            let data = fixed::data().lambda(15.0).mu(10.0).gamma0(300.0).friction(0.3).share(0.5);
            let data = data.displacement_before(wave(&space, 0.01, 0.9));
            let touch = pairing.at(PairQuadrature::Pieces);
            let regions = sliding::Regions::default().touch(touch).gamma_n("lower left");
            check("friction", &sliding::Model { data, regions }.direct(), &pressed);
        }
    }
}

/// Order two where edges and nodes lie on each other at the start, so that segments appear, with free edges inside of facets.
#[test]
fn taylor_tests_in_space_start_where_segments_appear() {
    for (shape, degree) in CASES {
        let layer = cuboid([0.0, 0.0, -0.5], [2.0, 2.0, 0.0], [4, 4, 1], shape, 1).unwrap();
        // Its inner nodes lie on those of the layer.
        let block = structured([4, 4, 1], shape, 1, |[s, t, r]: [f64; 3]| {
            let place = |s: f64| (0.5 + s).clamp(0.57, 1.43);
            [place(s), place(t), 0.5 * r]
        });
        let mesh = two_bodies(&layer, &block.unwrap());
        let space = Space::vector(&mesh, degree).unwrap();
        let assembler = Assembler::new(&mesh);
        let u = moved(&Field::zero(&space), "upper", [0.0, 0.0, -0.03]);
        for pairing in pairings("lower top", "upper bottom") {
            for (method, phase) in [(Method::Nitsche(0.0), 0.3), (Method::of_means(0.0, degree), 1.7)] {
                let form = method.form(&law(method, &pairing));
                let [least, most] = taylor_order(&assembler, &form, &u, &wave(&space, 0.3, phase));
                println!("{shape:?} {degree} {pairing} {phase}: {least:.3} to {most:.3}");
                assert!(least > 1.95 && most < 2.05, "{shape:?} {degree} {pairing} {phase}: {least} {most}");
            }
        }
    }
}

/// A hairpin whose arms face each other, and a rigid tool with kinks.
#[test]
fn self_contact_and_rigid_tools_in_space() {
    let hairpin = |[s, y, t]: [f64; 3]| {
        let (along, inner) = (4.0 * s - 2.0, 0.45 - 0.3 * t);
        match along {
            a if a < -0.5 => [a + 0.5, y, -inner],
            a if a > 0.5 => [0.5 - a, y, inner],
            a => [inner * (PI * a).cos(), y, inner * (PI * a).sin()],
        }
    };
    let bumps = structured([5, 3, 1], CellShape::Tetrahedron, 1, |[s, t, r]: [f64; 3]| {
        [0.3 + 2.1 * s, 1.3 * t - 0.4, 0.62 + 0.2 * r + 0.05 * (9.0 * s).sin() * (7.0 * t).cos()]
    });
    let tool = RigidSurface::of_boundary(&bumps.unwrap(), "bottom").unwrap();
    for degree in [1, 2] {
        let pin = structured([13, 2, 1], CellShape::Tetrahedron, degree, hairpin).unwrap();
        let space = Space::vector(&pin, degree).unwrap();
        let pairing = Pairing::within("top").within_reach(0.5);
        let assembler = Assembler::new(&pin);
        let u = wave(&space, 0.02, 0.4);
        let report = assembler.pairs_at(&pairing.clone().at(PairQuadrature::Pieces), 3, &u).unwrap();
        assert!(report.segments > 20 && report.paired_measure > 2.0, "{report:?}");
        let form = springs_between(&pairing).forces();
        let off = off_differences(&assembler, &form, (&u, &wave(&space, 1.0, 1.7)), 1e-5);
        println!("hairpin, degree {degree}: {off:.1e}");
        assert!(off < 1e-9, "{degree}: {off:e}");

        let block = cuboid([0.0; 3], [2.0, 1.0, 0.6], [4, 3, 1], CellShape::Tetrahedron, 1).unwrap();
        let mesh = block.with_rigid_surfaces(&[("tool", &tool)]).unwrap();
        let space = Space::vector(&mesh, degree).unwrap();
        let affine =
            |x: &[f64; 3]| [0.3 + 0.2 * x[1] - 0.1 * x[0], 0.7 - 0.5 * x[2] + 0.2 * x[1], x[0] - 0.3 * x[2]];
        let rigid = Field::interpolate(&space, affine).unwrap();
        let mut values = wave(&space, 1.0, 1.7).values().to_vec();
        for node in space.cell_nodes(mesh.cell_region("tool").unwrap()[0] as usize) {
            let range = 3 * *node as usize..3 * *node as usize + 3;
            values[range.clone()].copy_from_slice(&rigid.values()[range]);
        }
        let w = Field::from_values(&space, values).unwrap();
        // Any affine field moves the tool's cell as one piece.
        let u = Field::interpolate(&space, |x| [0.01 * x[1], 0.02 * x[0] - 0.01, 0.01 * x[1]]).unwrap();
        let pairing = Pairing::onto("top", "tool");
        let form = springs_between(&pairing).forces();
        let off = off_differences(&Assembler::new(&mesh), &form, (&u, &w), 1e-5);
        println!("tool, degree {degree}: {off:.1e}");
        assert!(off < 1e-9, "{degree}: {off:e}");
    }
}

#[test]
fn bits_in_space_do_not_depend_on_threads() {
    for (degree, cells) in [(1, [17, 14]), (2, [13, 11])] {
        let mesh = plates(cells, CellShape::Tetrahedron, degree);
        let space = Space::vector(&mesh, degree).unwrap();
        let pairing = Pairing::between("lower top", "upper bottom");
        let form = law(Method::FacetMeans(0.0), &pairing).facet_means();
        let kept = [1, 2, 3, 7].map(|threads| Assembler::new(&mesh).with_threads(Threads::new(threads)));
        for phase in [0.3, 0.31] {
            let u = moved(&wave(&space, 0.02, phase), "upper", [0.0, 0.0, -0.05]);
            let fresh = Assembler::new(&mesh);
            let [forces, tangent] = [
                fresh.residual(&form, &[&u], &[&space]).unwrap(),
                fresh.tangent(&form, &[&u], &[&space]).unwrap().values().to_vec(),
            ];
            for assembler in &kept {
                assert!(assembler.residual(&form, &[&u], &[&space]).unwrap() == forces);
                assert!(assembler.tangent(&form, &[&u], &[&space]).unwrap().values() == tangent);
            }
        }
    }
}
