//! Pairs at meshes that do not match, and at points without a partner: the patch test by surfaces that slide, and the variants of
//! Nitsche's method with and without the stresses of open points.

use forms_contact::ContactProblem;
use forms_contact::laws::sliding_bodies as sliding;
use forms_contact::laws::two_bodies as fixed;
use forms_fem::prelude::*;

use crate::setting::{LAMBDA, MU};
use crate::two_bodies::{WIDTH, constraints, pairings};

/// The shortening of the layer of height 1.
const DOWN: f64 = 0.01;

/// Two layers of height ½ with these numbers of cells sideways, and a third of them upwards.
fn layers(cells: [usize; 2]) -> Mesh<2> {
    let body = |count: usize, low: f64| {
        let divisions = [count, count.div_ceil(3)];
        rectangle([0.0, low], [WIDTH, low + 0.5], divisions, CellShape::Quadrilateral, 1).unwrap()
    };
    let (lower, upper) = (body(cells[0], 0.0), body(cells[1], 0.5));
    Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)]).unwrap()
}

/// The largest error of the stress, as a part of the uniform pressure, of layers with these numbers of cells sideways.
fn off(cells: [usize; 2], degree: usize, rule: usize, (pairing, share): &(Pairing, f64)) -> f64 {
    let mesh = layers(cells);
    let space = Space::vector(&mesh, degree).unwrap();
    let gamma0 = forms_contact::threshold::usual_gamma0(LAMBDA, MU);
    let required = fixed::data().lambda(LAMBDA).mu(MU).gamma0(gamma0);
    let data = required.share(*share);
    let regions = sliding::Regions::default().touch(pairing.clone()).gamma_n("upper top");
    let law = sliding::Model { data, regions };
    let problem =
        ContactProblem::new(&space, law, constraints(&space, 0.0, DOWN)).quadrature(Quadrature::Degree(rule));
    // No friction: the layers are held sideways by their ends.
    let u = problem.direct().unwrap().solve().unwrap().into_field();
    let stretch = 1.0 - DOWN;
    let pressure = MU * (1.0 / stretch - stretch) - LAMBDA * stretch.ln() / stretch;
    let stress = problem.law.first_piola(&u);
    let found = problem.assembler.at_quadrature_points(&stress, Entity::Cells, "all", 4).unwrap();
    found.values.iter().fold(0.0, |worst: f64, value| worst.max((value[3] + pressure).abs() / pressure))
}

/// On meshes that match, and with matched points, one pressure; otherwise errors of the pressure that no mesh makes smaller, as
/// docs/contact_between_bodies.md tells.
#[test]
fn sliding_pairs_break_the_patch_test_on_meshes_that_do_not_match() {
    let both = &pairings()[0];
    assert!(off([4, 4], 1, 4, both) < 1e-9);
    println!(
        "| degree | surfaces | rule | 3 on 4 cells | 6 on 8 | 12 on 16 |\n| --: | --- | --: | --: | --: | --: |"
    );
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for degree in [1, 2] {
        for (name, pairing) in [("both", 0), ("the coarse one", 1), ("the fine one", 2)] {
            for rule in [2, 4, 8, 16] {
                let errors = [1, 2, 4].map(|k| off([3 * k, 4 * k], degree, rule, &pairings()[pairing]));
                let [a, b, c] = errors.map(|error| format!("{:.2} %", 100.0 * error));
                println!("| {degree} | {name} | {rule} | {a} | {b} | {c} |");
                assert!(errors[2] > 0.5 * errors[0], "the error vanishes with the mesh: {errors:?}");
                if rule > 2 {
                    (least, most) = errors.iter().fold((least, most), |(l, m), e| (l.min(*e), m.max(*e)));
                }
            }
        }
    }
    println!("from degree 4 on {:.2} % to {:.2} %", 100.0 * least, 100.0 * most);
    assert!(least > 1e-3 && most < 0.12, "{least} {most}");
}

/// The law of two bodies with −(θ/γ) σ(u)n·σ(v)n on all of the own surfaces, and not only where points have a partner.
#[forms(dimension = 2)]
mod keeping {
    pub use forms_contact::laws::two_bodies::{Data, GammaN, Omega, Touch};
    use forms_contact::laws::two_bodies::{direct, stress};
    use forms_contact::operators::bodies::{own_gamma, own_traction};

    /// The surfaces that are integrated over.
    #[facets]
    pub struct Own;

    pub fn kept(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let paired = dot(own_traction(u), own_traction(v)) / own_gamma();
        direct(u, v) + integral(Touch, share * theta * paired)
            - integral(Own, share * theta * h / gamma0 * dot(stress(u) * n, stress(v) * n))
    }
}

/// A block on a slab that is longer: beyond its ends the slab's points have no partner. Both variants are consistent, and differ less on finer
/// meshes.
#[test]
fn points_without_a_partner_and_the_stresses_there() {
    let difference = |cells: usize, theta: f64| {
        let slab =
            rectangle([0.0, 0.0], [3.0, 1.0], [3 * cells, cells], CellShape::Quadrilateral, 1).unwrap();
        let block = rectangle([1.0, 1.0], [2.0, 2.0], [cells + 1; 2], CellShape::Quadrilateral, 1).unwrap();
        let mesh = Mesh::of_bodies(&[("slab", &slab), ("block", &block)]).unwrap();
        let space = Space::vector(&mesh, 1).unwrap();
        let mut held = Constraints::new(&space);
        held.fix("slab bottom", |_| [0.0; 2]).unwrap();
        held.fix("block top", |_| [0.0, -0.01]).unwrap();
        let gamma0 = forms_contact::threshold::usual_gamma0(LAMBDA, MU);
        let required = fixed::data().lambda(LAMBDA).mu(MU).gamma0(gamma0);
        let data = required.share(1.0).theta(theta);
        let touch = Pairing::onto("slab top", "block bottom");
        let regions = keeping::Regions::default().touch(touch.clone()).gamma_n("slab left").own("slab top");
        let kept = keeping::Model { data: data.clone(), regions }.kept();
        let options = NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
        let kept = Problem::new(&kept, &space).constrained(&held).options(options).solve().unwrap();
        let regions = fixed::Regions::default().touch(touch).gamma_n("slab left");
        let law = fixed::Model { data, regions };
        let problem = ContactProblem::new(&space, law, held);
        let dropped = problem.direct().unwrap().solve().unwrap();
        let values = |solved: &Solved<2>| solved.field().values().to_vec();
        let both = values(&kept).into_iter().zip(values(&dropped));
        both.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / 0.01
    };
    for theta in [-1.0, 1.0] {
        let [coarse, fine] = [difference(4, theta), difference(16, theta)];
        println!("theta {theta}: {coarse:.1e} and {fine:.1e} of the largest displacement");
        assert!(coarse < 1e-2 && fine < 0.5 * coarse, "{coarse:e} {fine:e}");
    }
    assert!(difference(4, 0.0) < 1e-12);
}
