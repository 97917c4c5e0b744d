//! Two rings, one in the other, whose meshes do not match: the pressure between them by Lamé, whatever the angle between the meshes.

use std::f64::consts::TAU;

use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod pressed {
    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma0: Param,
        pressure: Param,
        /// Springs that hold what nothing else holds \[stress per length\].
        soft: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Inside;
    #[pairs]
    pub struct Touch;

    fn stress(u: Vector) -> Tensor {
        lambda * div(u) * I + 2 * mu * eps(u)
    }
    fn contact_pressure(u: Vector) -> Scalar {
        neg_part(dot(this(stress(u) * n), toward) + gamma0 / this(h) * gap)
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)) + soft * dot(u, v))
            + integral(Inside, pressure * dot(n, v))
            + integral(Touch(u), contact_pressure(u) * dot(toward, jump(v)) / 2)
    }
    pub fn force(u: State<Vector>) -> Functional {
        integral(Touch(u), contact_pressure(u) / 2)
    }
    /// The moment of the forces on the own sides; both cancel on pairs along the normal.
    pub fn torque(u: State<Vector>) -> Functional {
        integral(Touch(u), contact_pressure(u) / 2 * across(this(x + u), toward))
    }
    pub fn length(u: State<Vector>) -> Functional {
        integral(Touch(u), 1 / 2)
    }
    fn across(a: Vector, b: Vector) -> Scalar {
        a[0] * b[1] - a[1] * b[0]
    }
}

/// Rings of radii 1 to 2 and 2 to 3 with these numbers of cells around, the inner one turned by a part of its cell; closed by periodic cells.
pub fn rings(degree: usize, cells: [usize; 2], turn: f64) -> Mesh<2> {
    let ring = |count: usize, inner: f64, turn: f64| {
        annulus([inner, inner + 1.0], [4, count], degree, turn / count as f64)
    };
    let (inner, outer) = (ring(cells[0], 1.0, turn), ring(cells[1], 2.0, 0.0));
    Mesh::of_bodies(&[("inner", &inner), ("outer", &outer)]).unwrap()
}

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

/// Mean pressure, and torque by force and radius, with γ₀ in E.
fn pressed(
    (degree, cells): (usize, [usize; 2]),
    gamma0: f64,
    turn: f64,
    quadrature: Option<PairQuadrature>,
) -> [f64; 2] {
    let mesh = rings(degree, cells, turn);
    let space = Space::vector(&mesh, degree).unwrap();
    let touch = Pairing::between("inner rim", "outer hole");
    let touch = quadrature.into_iter().fold(touch, |touch, quadrature| touch.at(quadrature));
    let (young, poisson) = (100.0, 0.3);
    let data = pressed::data()
        .lambda(young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)))
        .mu(young / (2.0 * (1.0 + poisson)))
        .gamma0(gamma0 * young)
        .pressure(1.0)
        .soft(1e-6);
    let regions = pressed::Regions::default().inside("inner hole").touch(touch);
    let law = pressed::Model { data, regions };
    let rule = Quadrature::Degree(2 * degree + 1);
    let assembler = Assembler::new(&mesh).with_quadrature(rule);
    let form = law.balance();
    let options = NewtonOptions {
        relative_tolerance: 1e-10,
        line_search: LineSearch::OnResidual,
        ..NewtonOptions::default()
    };
    let mut problem = Problem::new(&form, &space).assembler(&assembler).options(options);
    let u = problem.solve().unwrap().into_field();
    let of = |functional| assembler.functional(&functional).unwrap();
    let force = of(law.force(&u));
    [force / of(law.length(&u)), of(law.torque(&u)).abs() / (2.0 * force)]
}

/// Lamé's pressure less what the gap between the arcs takes. An arc of degree 2 over the angle 2θ lies inside its circle by R (1 − cos θ)²/15 on
/// average, and an interference δ presses by p = 0.1171875 E/(1 − ν²) δ.
fn pressure_of_arcs([inner, outer]: [usize; 2]) -> f64 {
    let inside = |cells: usize| 2.0 * (1.0 - (0.5 * TAU / cells as f64).cos()).powi(2) / 15.0;
    0.15625 - 0.1171875 * 100.0 / (1.0 - 0.09) * (inside(inner) - inside(outer))
}

/// Of 16 and 22 cells, with 32 and 44 nodes around, the arcs' gap is 16 times that of 32 and 44 cells: the pressure is not 0.15619 but 0.15575. With
/// γ₀ of 20 E, as with other lengths h in γ₀/h, it is 0.15577.
#[test]
fn the_pressure_between_rings_does_not_depend_on_their_angle() {
    println!("| elements | rule | mean pressure | with the arcs' gap | spread | torque |");
    for (degree, cells) in [(1, [32, 44]), (2, [16, 22]), (2, [32, 44])] {
        for rule in [None, Some(PairQuadrature::Pieces)] {
            let at = |turn: f64| pressed((degree, cells), 10.0, turn, rule);
            let all = [0.0, 0.21, 0.5, 0.83].map(at);
            let mean = all.iter().map(|found| found[0]).sum::<f64>() / all.len() as f64;
            let spread = all.iter().map(|found| (found[0] - mean).abs() / mean).fold(0.0, f64::max);
            let torque = all.iter().map(|found| found[1]).fold(0.0, f64::max);
            let arcs = pressure_of_arcs(cells);
            println!(
                "| Q{degree} {cells:?} | {rule:?} | {mean:.6} | {arcs:.6} | {spread:.1e} | {torque:.1e} |"
            );
            if degree == 2 && rule.is_some() {
                let most = if cells[0] < 32 { 1e-7 } else { 1e-8 };
                assert!(
                    (mean - arcs).abs() < 5e-5 && spread < most && torque < most,
                    "{cells:?} {mean} {arcs} {spread:e} {torque:e}"
                );
                let [stiffer, _] = pressed((degree, cells), 20.0, 0.0, rule);
                println!("with twice the γ₀: {stiffer:.6}");
                // Another program has 0.155762, which fits 16 and 22 cells only.
                assert_eq!(mean < 0.155762 && 0.155762 < stiffer, cells[0] == 16, "{mean} {stiffer}");
            }
        }
    }
}
