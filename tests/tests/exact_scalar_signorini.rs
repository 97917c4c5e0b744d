//! The scalar Signorini problem −Δu = 0, u ≥ 0, ∂_n u ≥ 0, u ∂_n u = 0 on y = 0, with the solution
//! u = r^{3/2} cos(3φ/2): contact for x < 0. Nitsche's method is stated here, in a form of the test's own.

use crate::convergence::{digits, order};
use forms_fem::norms::errors;
use forms_fem::prelude::*;

#[forms]
mod membrane {
    pub struct Data {
        pub theta: Param,
        pub gamma0: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Obstacle;

    fn gamma() -> Scalar {
        gamma0 / h
    }

    fn slope(w: Scalar) -> Scalar {
        dot(grad(w), n)
    }

    /// ∂_n u − γ u: contact where positive.
    pub fn indicator(w: Scalar) -> Scalar {
        slope(w) - gamma() * w
    }

    /// \[∂_n u − γ u\]₊: the obstacle's reaction.
    pub fn reaction(w: Scalar) -> Scalar {
        pos_part(indicator(w))
    }

    pub fn signorini(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v))) - integral(Obstacle, theta / gamma() * slope(u) * slope(v))
            + integral(Obstacle, reaction(u) / gamma() * (theta * slope(v) - gamma() * v))
    }
}

fn exact(x: &[f64; 2]) -> f64 {
    let angle = x[1].max(0.0).atan2(x[0]);
    x[0].hypot(x[1]).powf(1.5) * (1.5 * angle).cos()
}

/// ∇ Re z^{3/2} = 3/2 (Re √z, −Im √z).
fn gradient(x: &[f64; 2]) -> [f64; 2] {
    let angle = x[1].max(0.0).atan2(x[0]);
    let root = 1.5 * x[0].hypot(x[1]).sqrt();
    [root * (0.5 * angle).cos(), -root * (0.5 * angle).sin()]
}

/// A domain with a curved top, \[−1,1\] on the axis.
fn domain(shape: CellShape, divisions: usize) -> Mesh<2> {
    let map = |[s, t]: [f64; 2]| {
        let x = 2.0 * s - 1.0;
        [x * (1.0 - 0.25 * t), t * (1.0 - 0.3 * x * x)]
    };
    forms_fem::mesh::structured([divisions, divisions / 2], shape, 1, map).unwrap()
}

fn h1_order(shape: CellShape, degree: usize, theta: f64) -> f64 {
    let divisions = [8, 16, 32, 64];
    let (mut h1, mut reactions) = (vec![], vec![]);
    for divisions in divisions {
        let mesh = domain(shape, divisions);
        let space = Space::scalar(&mesh, degree).unwrap();
        let mut constraints = Constraints::new(&space);
        for side in ["left", "right", "top"] {
            constraints.fix(side, exact).unwrap();
        }
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(8));
        // k(k+1)/2 · |F| h/|T| of a right triangle with equal legs, with a margin for the skewed cells.
        let gamma0 = 3.0 * (degree * (degree + 1)) as f64 * 2.0_f64.sqrt();
        let data = membrane::data().theta(theta).gamma0(gamma0);
        let form = membrane::signorini(&data, &membrane::Omega::on("all"), &membrane::Obstacle::on("bottom"));
        let problem = Problem::new(&form, &space).assembler(&assembler);
        let (mut solver, options) = (TangentSolver::default(), NewtonOptions::default());
        let start = Field::zero(&space);
        let u = problem
            .start(&start)
            .constrained(&constraints)
            .solver(&mut solver)
            .options(options.clone())
            .solve()
            .unwrap()
            .into_field();
        let value = |x: &[f64; 2], out: &mut [f64]| out[0] = exact(x);
        let slope = |x: &[f64; 2], out: &mut [f64]| out.copy_from_slice(&gradient(x));
        h1.push(errors(&assembler, &u, value, slope).unwrap().h1);
        // The reaction is 3/2 √r for x < 0.
        let found = membrane::reaction(&data, &u);
        let found = assembler.at_quadrature_points(&found, Entity::Facets, "bottom", 8).unwrap();
        let points = found.positions.iter().zip(&found.weights).zip(&found.values);
        let squares = points.map(|((x, w), value)| w * (value[0] - 1.5 * (-x[0]).max(0.0).sqrt()).powi(2));
        reactions.push(squares.sum::<f64>().sqrt());
    }
    let (h1_order, reaction_order) = (order(&divisions, &h1), order(&divisions, &reactions));
    println!(
        "{shape:?} k={degree} θ={theta}: H¹ {} order {h1_order:.3}; reaction {} order {reaction_order:.3}",
        digits(&h1),
        digits(&reactions)
    );
    // Q1 comes to order 1 from above.
    assert!((0.9..1.2).contains(&reaction_order), "reaction: order {reaction_order}");
    h1_order
}

/// Degree 2 on triangles; FORMS_SWEEPS=1: on quadrilaterals, too.
fn check(degree: usize, band: std::ops::Range<f64>) {
    let all = degree == 1 || std::env::var_os("FORMS_SWEEPS").is_some();
    let shapes = [CellShape::Triangle, CellShape::Quadrilateral];
    for &shape in if all { &shapes[..] } else { &shapes[..1] } {
        for theta in [-1.0, 0.0, 1.0] {
            let order = h1_order(shape, degree, theta);
            assert!(band.contains(&order), "{shape:?} k={degree} θ={theta}: H¹ order {order}");
        }
    }
}

#[test]
fn degree_1() {
    check(1, 0.95..1.05);
}

#[test]
fn degree_2() {
    check(2, 1.42..1.58);
}

/// Odd divisions: the transition at x = 0 lies in the middle of a facet.
#[test]
fn split_facets_follow_the_transition_inside_a_facet() {
    let divisions = [9, 17, 33, 65];
    let mut h1 = [vec![], vec![]];
    for divisions in divisions {
        let mesh = domain(CellShape::Triangle, divisions);
        let space = Space::scalar(&mesh, 2).unwrap();
        let mut constraints = Constraints::new(&space);
        for side in ["left", "right", "top"] {
            constraints.fix(side, exact).unwrap();
        }
        let whole = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(8));
        let data = membrane::data().theta(-1.0).gamma0(30.0);
        let form = membrane::signorini(&data, &membrane::Omega::on("all"), &membrane::Obstacle::on("bottom"));
        let split = |u: &Field<2>| whole.split_at_zeros(&membrane::indicator(&data, u), "bottom", 2);
        for (errors_of, splits) in h1.iter_mut().zip([false, true]) {
            let mut problem = Problem::new(&form, &space).assembler(&whole);
            if splits {
                problem = problem.assembler_at(|u| split(&u[0]));
            }
            let found = problem.constrained(&constraints).solve().unwrap();
            let u = found.field().clone();
            let value = |x: &[f64; 2], out: &mut [f64]| out[0] = exact(x);
            let slope = |x: &[f64; 2], out: &mut [f64]| out.copy_from_slice(&gradient(x));
            errors_of.push(errors(&whole, &u, value, slope).unwrap().h1);
            if !splits {
                continue;
            }
            assert!(found.history.iter().all(|step| step.active_points.is_none()));
            assert!(found.history.len() < 15, "{:?}", found.history);
            // One zero, in the facet about x = 0. A rule whose pieces meet there gives the same on every facet.
            let parts = whole.positive_parts(&membrane::indicator(&data, &u), "bottom", 2).unwrap();
            let inside = |s: &&f64| **s > 0.0 && **s < 1.0;
            let zeros: Vec<f64> = parts
                .iter()
                .flat_map(|part| part.parameters.iter().filter(inside).copied().collect::<Vec<_>>())
                .collect();
            assert_eq!(zeros.len(), 1, "{parts:?}");
            let gauss = forms_fem::quadrature::facet_reference_rule(CellShape::Triangle, 8).unwrap();
            let pieces = [[0.0, zeros[0]], [zeros[0], 1.0]];
            let facet: Vec<(f64, f64)> = pieces
                .iter()
                .flat_map(|[a, b]| {
                    let points = gauss.points.iter().zip(&gauss.weights);
                    points.map(move |(point, weight)| (a + (b - a) * point[0], (b - a) * weight))
                })
                .collect();
            let cell = forms_fem::quadrature::cell_rule(CellShape::Triangle, 8).unwrap();
            let facet = QuadratureRule::on_segment(&facet);
            let explicit = whole.clone().with_quadrature(Quadrature::Explicit { cell, facet });
            let residual = |assembler: &Assembler<2>| assembler.residual(&form, &[&u], &[&space]).unwrap();
            let (by_split, by_explicit) = (residual(&split(&u).unwrap()), residual(&explicit));
            let difference =
                |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(difference(&by_split, &by_explicit) < 1e-13, "{}", difference(&by_split, &by_explicit));
            assert!(difference(&by_split, &residual(&whole)) > 1e-9);
        }
    }
    for (errors, splits) in h1.iter().zip([false, true]) {
        let order = order(&divisions, errors);
        println!("split = {splits}: H¹ {} order {order:.3}", digits(errors));
        assert!((1.4..1.6).contains(&order), "split = {splits}: {order}");
    }
}
