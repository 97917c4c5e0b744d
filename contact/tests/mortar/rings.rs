//! Two rings, one in the other, whose meshes do not match: the pressure between them by Lamé, whatever the angle between the meshes.

use std::f64::consts::TAU;

use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

use crate::exact::multipliers;
use crate::wobble::elastic;

fn annulus([from, to]: [f64; 2], [radial, around]: [usize; 2], degree: usize, turn: f64) -> Mesh<2> {
    let flat = structured([radial, around], CellShape::Quadrilateral, degree, |t: [f64; 2]| t).unwrap();
    let steps = degree * around;
    let place = |t: &[f64; 2]| {
        let (radius, angle) = (from + (to - from) * t[0], TAU * (t[1] + turn));
        [radius * angle.cos(), radius * angle.sin()]
    };
    // The last row of nodes is the first one.
    let first = |node: usize| {
        let t = flat.nodes()[node];
        let same = |other: &[f64; 2]| other[1] == 0.0 && (other[0] - t[0]).abs() < 1e-12;
        if (t[1] - 1.0).abs() < 0.25 / steps as f64 {
            flat.nodes().iter().position(same).unwrap()
        } else {
            node
        }
    };
    let kept: Vec<usize> = (0..flat.nodes().len()).filter(|node| first(*node) == *node).collect();
    let number = |node: usize| kept.binary_search(&first(node)).unwrap() as u32;
    let nodes = kept.iter().map(|node| place(&flat.nodes()[*node])).collect();
    let cells = (0..flat.cell_count()).flat_map(|cell| flat.cell(cell).iter().map(|n| number(*n as usize)));
    let mut mesh = Mesh::from_parts(CellShape::Quadrilateral, degree, nodes, cells.collect()).unwrap();
    let middle = 0.5 * (from + to);
    mesh.name_facets("hole", "boundary", |x| x[0].hypot(x[1]) < middle).unwrap();
    mesh.name_facets("rim", "boundary", |x| x[0].hypot(x[1]) > middle).unwrap();
    mesh
}

/// Mean pressure, the largest difference of a multiplier from Lamé's pressure, and torque by force and radius.
fn pressed(own: &str, of_multipliers: usize, turn: f64) -> [f64; 3] {
    let inner = annulus([1.0, 2.0], [4, 32], 2, turn / 32.0);
    let outer = annulus([2.0, 3.0], [4, 44], 2, 0.0);
    let mesh = Mesh::of_bodies(&[("inner", &inner), ("outer", &outer)]).unwrap();
    let space = Space::vector(&mesh, 2).unwrap();
    let traces = multipliers(&mesh, own, of_multipliers, &[]);
    let opposite = if own == "inner rim" { "outer hole" } else { "inner rim" };
    let data = elastic::data().gamma0(1000.0).young(100.0).inner_pressure(1.0).soft(1e-6);
    let touch = Pairing::onto(own, opposite).at(PairQuadrature::Pieces);
    let regions = elastic::Regions::default().touch(touch).own(own).inside("inner hole");
    let law = elastic::Model { data, regions };
    let form = law.balance();
    let start = Field::interpolate(&traces, |_| 0.1).unwrap();
    let (none, touching) = (Field::zero(&space), Field::zero(&traces));
    // Only soft springs keep the inner ring from turning, so that its angle has the rounding of the forces over them.
    let options = NewtonOptions { absolute_tolerance: 1e-12, ..NewtonOptions::default() };
    let mut problem = Problem::new(&form, [&space, &traces, &traces]).options(options);
    problem = problem.start([&none, &start, &touching]);
    let [u, p, _] = problem.solve().unwrap().fields;
    let assembler = Assembler::new(&mesh);
    let of = |functional| assembler.functional(&functional).unwrap();
    let force = of(law.force(&u, &p));
    let off = p.values().iter().map(|p| (p / 0.15625 - 1.0).abs()).fold(0.0, f64::max);
    [force / of(law.length(&u)), off, of(law.torque(&u, &p)).abs() / (2.0 * force)]
}

/// The arcs leave a gap that takes 0.00003 of Lamé's pressure, as `moving_segments/rings.rs` says, and 4 cells across a ring 0.00001.
#[test]
fn the_pressure_between_rings_is_that_of_lame() {
    println!("| own surface | degree | mean pressure | spread | largest error of a multiplier | torque |");
    for (own, of_multipliers) in [("inner rim", 1), ("inner rim", 2), ("outer hole", 1), ("outer hole", 2)] {
        let all = [0.0, 0.21, 0.5, 0.83].map(|turn| pressed(own, of_multipliers, turn));
        let mean = all.iter().map(|found| found[0]).sum::<f64>() / 4.0;
        let spread = all.iter().map(|found| (found[0] - mean).abs() / mean).fold(0.0, f64::max);
        let [off, torque] = [1, 2].map(|k| all.iter().map(|found| found[k]).fold(0.0, f64::max));
        println!("| {own} | {of_multipliers} | {mean:.6} | {spread:.1e} | {off:.1e} | {torque:.1e} |");
        assert!(
            (mean - 0.15625).abs() < 1e-4 && spread < 1e-10 && torque < 1e-12,
            "{mean} {spread:e} {torque:e}"
        );
        // Each coefficient of degree 2 follows the distance of the two curves around its own function.
        assert!(off < if of_multipliers == 1 { 2e-3 } else { 0.1 }, "{off:e}");
    }
}
