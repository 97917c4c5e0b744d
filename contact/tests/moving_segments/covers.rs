//! The cover of moving segments in space: areas, between bent edges too, facets that hide each other, surfaces that fold.

use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::structured;
use forms_fem::pairs::PairError;
use forms_fem::prelude::*;

use crate::balance::{model as springs_between, springs};
use crate::space::{CASES, layer_and_block, moved, plates, two_bodies};

/// The weights add up to what is covered, and so do second moments, wherever the block is; a part of it leaves the layer in the end.
#[test]
fn weights_add_up_to_the_covered_area() {
    for (shape, degree) in CASES {
        let mesh = layer_and_block([0.2, 0.15], shape);
        let space = Space::vector(&mesh, degree).unwrap();
        let assembler = Assembler::new(&mesh);
        let (lower, upper) = ("lower top", "upper bottom");
        for pairing in [Pairing::onto(lower, upper), Pairing::onto(upper, lower)] {
            let law = springs_between(&pairing);
            for step in 0..16 {
                let aside = [0.08 * f64::from(step), 0.031 * f64::from(step)];
                let u = moved(&Field::zero(&space), "upper", [aside[0], aside[1], 0.0]);
                let covered = assembler.functional(&law.covered(&u)).unwrap();
                let low = [0.2 + aside[0], 0.15 + aside[1]];
                let high = [(low[0] + 0.9).min(2.0), (low[1] + 0.9).min(1.5)];
                let exact = (high[0] - low[0]) * (high[1] - low[1]);
                let name = format!("{shape:?} {degree} {pairing} {aside:?}");
                assert!((covered - exact).abs() < 1e-14, "{name}: {covered} is not {exact}");
                if pairing.surfaces[0].own == lower {
                    let third = |k: usize| (high[k].powi(3) - low[k].powi(3)) / 3.0;
                    let exact = third(0) * (high[1] - low[1]) + third(1) * (high[0] - low[0]);
                    let moment = assembler.functional(&law.moment(&u)).unwrap();
                    assert!((moment - exact).abs() < 1e-13, "{name}: {moment} is not {exact}");
                }
            }
        }
    }
}

/// A bent block on a flat layer covers the polygon through the nodes of its rim; own facets of the block that are covered have their whole area, however
/// bent they are.
#[test]
fn bent_edges_are_chords_between_nodes() {
    for (shape, degree) in CASES.into_iter().filter(|(_, degree)| *degree == 2) {
        let mesh = layer_and_block([0.2, 0.15], shape);
        let space = Space::vector(&mesh, degree).unwrap();
        let assembler = Assembler::new(&mesh);
        let bend = |x: f64, y: f64| [0.2 * (y - 0.3) * (y - 0.3), 0.15 * (x - 0.1) * (x + y), 0.1 * x * x];
        for step in 0..6 {
            let aside = [0.07 * f64::from(step), 0.011 * f64::from(step), 0.02];
            let bent = Field::interpolate(&space, |x: &[f64; 3]| bend(x[0], x[1])).unwrap();
            // The layer stays.
            let mut values = moved(&bent, "upper", aside).values().to_vec();
            for cell in mesh.cell_region("lower").unwrap() {
                for node in space.cell_nodes(*cell as usize) {
                    values[3 * *node as usize..][..3].fill(0.0);
                }
            }
            let u = Field::from_values(&space, values).unwrap();
            // Each side has nodes at the corners and in the middle of its 3 or 2 edges.
            let along = (0..6).map(|k| [f64::from(k) / 6.0, 0.0]);
            let up = (0..4).map(|k| [1.0, f64::from(k) / 4.0]);
            let back = (0..6).map(|k| [1.0 - f64::from(k) / 6.0, 1.0]);
            let down = (0..4).map(|k| [0.0, 1.0 - f64::from(k) / 4.0]);
            let place = |[s, t]: [f64; 2]| {
                let (x, y) = (0.2 + 0.9 * s, 0.15 + 0.9 * t);
                let [u, v, _] = bend(x, y);
                [x + u + aside[0], y + v + aside[1]]
            };
            let rim: Vec<[f64; 2]> = along.chain(up).chain(back).chain(down).map(place).collect();
            let next = rim.iter().cycle().skip(1);
            let exact: f64 = rim.iter().zip(next).map(|(a, b)| 0.5 * (a[0] * b[1] - a[1] * b[0])).sum();
            let covered = |own: &str, opposite: &str| {
                let pairing = Pairing::onto(own, opposite);
                let report = assembler.pairs_at(&pairing.clone().at(PairQuadrature::Pieces), 0, &u).unwrap();
                assert_eq!(report.open, 0, "{shape:?} {aside:?}");
                assembler.functional(&springs_between(&pairing).covered(&u)).unwrap()
            };
            let [of_layer, of_block] =
                [covered("lower top", "upper bottom"), covered("upper bottom", "lower top")];
            println!("{shape:?} {aside:?}: {:.1e} {:.1e}", of_layer - exact, of_block - 0.81);
            assert!((of_layer - exact).abs() < 1e-13, "{shape:?} {aside:?}: {of_layer} is not {exact}");
            assert!((of_block - 0.81).abs() < 1e-13, "{shape:?} {aside:?}: {of_block}");
        }
    }
}

/// The force of a bent plate that is moved along another one, in 60 steps over nodes and edges of both: its second differences, as parts of the force. Points of
/// whole facets jump where the rim passes them.
#[test]
fn forces_do_not_jump_where_nodes_pass_nodes() {
    for (shape, degree) in CASES {
        let mesh = plates([5, 4], shape, degree);
        let space = Space::vector(&mesh, degree).unwrap();
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(2 * degree));
        let lower: Vec<usize> = {
            let cells = mesh.cell_region("lower").unwrap();
            let mut nodes: Vec<u32> =
                cells.iter().flat_map(|cell| space.cell_nodes(*cell as usize)).copied().collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes.into_iter().map(|node| node as usize).collect()
        };
        let jump = |places: PairQuadrature| {
            let pairing = Pairing::onto("lower top", "upper bottom").at(places);
            let regions = springs::Regions::default().touch(pairing);
            let form = springs::Model { data: springs::data().gamma(7.0), regions }.forces();
            let force = |step: usize| {
                let aside = 5e-3 * step as f64;
                let u = moved(&Field::zero(&space), "upper", [aside, 0.7 * aside, 0.0]);
                let forces = assembler.residual(&form, &[&u], &[&space]).unwrap();
                lower.iter().map(|node| forces[3 * node + 2]).sum::<f64>()
            };
            let forces: Vec<f64> = (0..=60).map(force).collect();
            let second = forces.windows(3).map(|at| (at[0] - 2.0 * at[1] + at[2]).abs());
            second.fold(0.0, f64::max) / forces[0].abs()
        };
        let [points, segments] = [PairQuadrature::WholeFacets, PairQuadrature::Pieces].map(jump);
        println!("{shape:?} {degree}: {points:.1e} on points, {segments:.1e} on segments");
        assert!(segments < 2e-3 && points > 20.0 * segments, "{shape:?} {degree}: {points:e} {segments:e}");
    }
}

/// What is behind another facet has no points; what is behind it in part is refused.
#[test]
fn hidden_facets_are_dropped_or_refused() {
    for degree in [1, 2] {
        check_hidden(degree);
    }
}

fn check_hidden(degree: usize) {
    let body = |low: [f64; 3], high: [f64; 3], cells: [usize; 3]| {
        cuboid(low, high, cells, CellShape::Tetrahedron, 1).unwrap()
    };
    let own = body([0.0, 0.0, -0.5], [2.0, 2.0, 0.0], [3, 3, 1]);
    let far = body([0.2, 0.2, 0.4], [1.8, 1.8, 0.7], [2, 2, 1]);
    let report = |near: Mesh<3>| {
        let mut mesh =
            Mesh::clone(&Mesh::of_bodies(&[("own", &own), ("far", &far), ("near", &near)]).unwrap());
        mesh.name_facets("lids", "boundary", |x| x[2] == 0.4 || x[2] == 0.1).unwrap();
        let pairing = Pairing::onto("own top", "lids").within_reach(0.6).at(PairQuadrature::Pieces);
        Assembler::new(&mesh).pairs_at(&pairing, 3, &Field::zero(&Space::vector(&mesh, degree).unwrap()))
    };
    let whole = report(body([0.1, 0.1, 0.1], [1.9, 1.9, 0.2], [1, 1, 1])).unwrap();
    assert!((whole.paired_measure - 3.24).abs() < 1e-14 && whole.largest_gap < 0.11, "{whole:?}");
    assert!(whole.dropped_parts > 0);
    let error = report(body([0.3, 0.4, 0.1], [1.0, 1.1, 0.2], [1, 1, 1])).unwrap_err();
    assert!(error.to_string().starts_with("an opposite facet hides a part of another one"), "{error}");
}

/// A valley under a plate that lies above its centres of curvature: facets of the plate are cut or left out. One quadrilateral that
/// reaches from there to the rim, which is near, is refused. Facets of degree three are not cut.
#[test]
fn facets_above_a_valley_are_left_out_and_high_degrees_refused() {
    for shape in [CellShape::Tetrahedron, CellShape::Hexahedron] {
        let valley = structured([1, 1, 1], shape, 2, |[s, t, r]: [f64; 3]| {
            [s, t, 0.6 * r - 0.6 - 1.2 * s * (1.0 - s)]
        });
        let valley = valley.unwrap();
        let report = |cells: usize, degree: usize| {
            let plate = cuboid([0.1, 0.1, 0.2], [0.9, 0.9, 0.4], [cells, cells, 1], shape, 2).unwrap();
            let mesh = two_bodies(&valley, &plate);
            let still = Field::zero(&Space::vector(&mesh, degree).unwrap());
            let pairing = Pairing::onto("lower top", "upper bottom").at(PairQuadrature::Pieces);
            Assembler::new(&mesh).pairs_at(&pairing, 0, &still)
        };
        let fine = report(8, 2).unwrap();
        assert!(fine.dropped_parts > 0 && fine.segments > 0, "{fine:?}");
        if shape == CellShape::Hexahedron {
            let error = report(1, 2).unwrap_err();
            assert!(matches!(error, PairError::SegmentsFolded { .. }), "{error}");
        }
        let error = report(1, 3).unwrap_err();
        assert!(
            matches!(&error, PairError::SegmentsOfDegree { surface } if surface == "lower top"),
            "{error}"
        );
    }
}
