//! Shallow ironing, the problem of tutorial 12, by conditions at points and by means: the forces while the block moves by two cells of the
//! foundation, and how much they oscillate.

use forms_contact::ContactProblem;
use forms_contact::law::ContactLaw;
use forms_contact::laws::mortar_bodies as by_multipliers;
use forms_contact::laws::mortar_bodies::mortar_bodies_with_friction as with_friction;
use forms_contact::laws::{mean_sliding_bodies as of_facets, sliding_bodies as at_points};
use forms_fem::contract::PairQuadrature;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;
use forms_fem::solve::LoadSteps;

const YOUNG: f64 = 689.6;
const POISSON: f64 = 0.32;

fn mesh(fineness: usize) -> Mesh<2> {
    let cells = [30 * fineness, 15 * fineness / 2];
    let foundation = rectangle([0.0; 2], [12.0, 4.0], cells, CellShape::Quadrilateral, 1).unwrap();
    let block = structured([3 * fineness, 3 * fineness / 2], CellShape::Quadrilateral, 1, |[s, t]| {
        let x = 0.2 + 1.2 * s;
        let bottom = 4.95 - (0.75_f64.powi(2) - (x - 0.8).powi(2)).sqrt();
        [x, bottom + t * (5.4 - bottom)]
    })
    .unwrap();
    let mut mesh = Mesh::of_bodies(&[("foundation", &foundation), ("block", &block)]).unwrap();
    mesh.name_facets("skin", "block boundary", |x| x[1] < 5.4 - 1e-9).unwrap();
    // The round lower side, without the walls: the mean gap of a node at a corner would count the open gap of its wall.
    mesh.name_facets("sole", "block boundary", |x| x[1] < 4.5).unwrap();
    mesh.name_facets("sole and walls", "block boundary", |x| x[1] < 5.1).unwrap();
    mesh
}

fn modulus(x: &[f64; 2]) -> f64 {
    if x[1] > 4.0 + 1e-9 { 10.0 * YOUNG } else { YOUNG }
}

/// Forces (down, along) at each step of sliding, Newton's steps in all, and the last displacement.
fn forces<L: ContactLaw<2>>(
    mesh: &Mesh<2>,
    (steps, points): (usize, PairQuadrature),
    law: impl Fn(at_points::Data<2>, Pairing) -> L,
) -> (Vec<[f64; 2]>, usize, Field<2>) {
    let space = Space::vector(mesh, 1).unwrap();
    // Points of segments move: what is read there is a field, which says how it varies.
    let moduli = Space::discontinuous_scalar(mesh, 0).unwrap();
    let field = |of: fn(&[f64; 2]) -> f64| Field::interpolate(&moduli, of).unwrap();
    let lambda = field(|x| modulus(x) * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)));
    let (mu, gamma0) = (field(|x| modulus(x) / (2.0 * (1.0 + POISSON))), field(|x| 10.0 * modulus(x)));
    let (mut found, mut iterations) = (vec![], 0);
    let solve = |step: &Increment<'_, Field<2>>| -> Result<Field<2>, Failure> {
        let way = step.factor;
        let data = at_points::data()
            .lambda(&lambda)
            .mu(&mu)
            .gamma0(&gamma0)
            .friction(0.3)
            .displacement_before(step.before);
        let touch = Pairing::between("foundation top", "skin").within_reach(0.4).at(points);
        let mut held = Constraints::new(&space);
        held.fix("foundation bottom", |_| [0.0, 0.0])?;
        held.fix("block top", |_| [10.0 * (way - 1.0).max(0.0), -way.min(1.0)])?;
        let problem = ContactProblem::new(&space, law(data, touch), held).quadrature(Quadrature::Degree(3));
        let solved = problem.direct()?.increment(step).solve()?;
        let force = solved.reaction("foundation bottom")?;
        if way > 1.0 {
            found.push([force[1], -force[0]]);
            iterations += solved.history.len() - 1;
        }
        Ok(solved.into_field())
    };
    let pressing = (1..=8).map(|step| f64::from(step) / 8.0);
    let sliding = (1..=steps).map(|step| 1.0 + 0.002 * step as f64);
    let path = LoadSteps::through(pressing.chain(sliding)).advance(Field::zero(&space), solve).unwrap();
    (found, iterations, path.state)
}

/// The same with multipliers on an own surface, from a state that was pressed with means, and the last pressure at the block's front corner.
fn forces_by_multipliers(
    mesh: &Mesh<2>,
    own: &str,
    steps: usize,
    pressed: &Field<2>,
) -> (Vec<[f64; 2]>, usize, f64) {
    let space = Space::vector(mesh, 1).unwrap();
    let traces = Space::vector_on_facets(mesh, own, 1).unwrap();
    let moduli = Space::discontinuous_scalar(mesh, 0).unwrap();
    let field = |of: fn(&[f64; 2]) -> f64| Field::interpolate(&moduli, of).unwrap();
    let lambda = field(|x| modulus(x) * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)));
    let (mu, gamma0) = (field(|x| modulus(x) / (2.0 * (1.0 + POISSON))), field(|x| 10.0 * modulus(x)));
    let assembler = Assembler::new(mesh).with_quadrature(Quadrature::Degree(3));
    let (mut found, mut iterations) = (vec![], 0);
    let highest = if own == "sole" { 4.5 } else { 4.35 };
    let bears = |x: &[f64; 2]| [if x[1] < highest { 300.0 } else { 0.0 }, 0.0];
    let pressures = traces.positions().iter().flat_map(bears).collect();
    let u = Field::from_values(&space, pressed.values().to_vec()).unwrap();
    let mut fields = [u, Field::from_values(&traces, pressures).unwrap(), Field::zero(&traces)];
    for way in (0..=steps).map(|step| 1.0 + 0.002 * step as f64) {
        let mut held = Constraints::new(&space);
        held.fix("foundation bottom", |_| [0.0, 0.0]).unwrap();
        held.fix("block top", |_| [10.0 * (way - 1.0).max(0.0), -way.min(1.0)]).unwrap();
        let data = by_multipliers::data().lambda(&lambda).mu(&mu).gamma0(&gamma0).friction(0.3);
        let data = data.displacement_before(Given::field(&fields[0]));
        let touch = Pairing::onto(own, "foundation top").within_reach(0.4).at(PairQuadrature::Pieces);
        let regions = with_friction::Regions::default().touch(touch).own(own).gamma_n("block top");
        let model = with_friction::Model { data, regions };
        let problem = by_multipliers::frictional_mortar_problem(&model, [&space, &traces], &held).unwrap();
        let solved = problem.assembler(&assembler).start(fields.each_ref()).solve();
        let solved = solved.unwrap_or_else(|error| panic!("{way}: {error}"));
        if way > 1.0 {
            let force = solved.reaction_of(0, "foundation bottom").unwrap();
            found.push([force[1], -force[0]]);
            iterations += solved.iterations();
        }
        fields = solved.fields;
    }
    let is_corner = |x: &[f64; 2]| (x[0] - 1.4).hypot(x[1] - 4.5) < 1e-9;
    let corner = traces.positions().iter().position(is_corner).unwrap();
    (found, iterations, fields[1].values()[2 * corner])
}

/// Forces with means on segments of the sole, Newton's steps in all, and the last displacement.
fn forces_by_means_of_the_sole(mesh: &Mesh<2>, steps: usize) -> (Vec<[f64; 2]>, usize, Field<2>) {
    let pieces = PairQuadrature::Pieces;
    forces(mesh, (steps, pieces), |data, _| {
        let touch = Pairing::onto("sole", "foundation top").within_reach(0.4).at(pieces);
        let regions = of_facets::Regions::default().touch(touch).gamma_n("block top");
        of_facets::Model { data: data.share(1.0), regions }
    })
}

/// The root mean square of second differences, as a part of the mean.
fn roughness(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares = values.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2)).sum::<f64>();
    (squares / (values.len() - 2) as f64).sqrt() / mean.abs()
}

/// A step is a tenth of a cell of the foundation. The first steps, in which the block goes over from stick to slip, do not count.
#[test]
fn ironing_at_points_on_segments_with_means_and_multipliers() {
    let mesh = mesh(2);
    let steps = 40;
    let regions = |touch: Pairing| at_points::Regions::default().touch(touch).gamma_n("block top");
    let at_points = |points| {
        forces(&mesh, (steps, points), |data, touch| at_points::Model { data, regions: regions(touch) })
    };
    let of_facets = |points| {
        forces(&mesh, (steps, points), |data, touch| {
            let regions = of_facets::Regions::default().touch(touch).gamma_n("block top");
            of_facets::Model { data, regions }
        })
    };
    let (whole, pieces) = (PairQuadrature::WholeFacets, PairQuadrature::Pieces);
    let mut all = vec![];
    for (points, of_points, of_means) in
        [(whole, "points", "means at points"), (pieces, "segments", "means on segments")]
    {
        let (found, iterations, _) = at_points(points);
        all.push((of_points, found, iterations));
        let (found, iterations, _) = of_facets(points);
        all.push((of_means, found, iterations));
    }
    let (found, iterations, _) = forces_by_means_of_the_sole(&mesh, steps);
    all.push(("means on segments of the sole", found, iterations));
    let (_, _, pressed) = forces_by_means_of_the_sole(&mesh, 0);
    let (found, iterations, borne) = forces_by_multipliers(&mesh, "sole", steps, &pressed);
    all.push(("multipliers on the sole", found, iterations));
    let (found, iterations, lost) = forces_by_multipliers(&mesh, "sole and walls", steps, &pressed);
    all.push(("multipliers on the sole and the walls", found, iterations));
    println!("| law | down | along | roughness down | along | Newton steps |");
    println!("| --- | --: | --: | --: | --: | --: |");
    let mut rough = vec![];
    let mut lasts = vec![];
    for (name, forces, iterations) in &all {
        let settled = &forces[20..];
        let [down, along] = [0, 1].map(|k| settled.iter().map(|force| force[k]).collect::<Vec<f64>>());
        let last = forces[forces.len() - 1];
        let [a, b] = [roughness(&down), roughness(&along)];
        println!("| {name} | {:.1} | {:.1} | {a:.1e} | {b:.1e} | {iterations} |", last[0], last[1]);
        rough.push([a, b]);
        lasts.push(last[0]);
    }
    // Those with means, and multipliers.
    for k in [1, 3, 4, 5] {
        assert!(rough[k][0] < 0.3 * rough[0][0] && rough[k][1] < 0.3 * rough[0][1], "{rough:?}");
        assert!((lasts[0] / lasts[k] - 1.0).abs() < 0.05, "{lasts:?}");
    }
    // The mean gap of the front corner's node is open with the wall's part, and what it bore is missing in the force along.
    let last = |k: usize| all[k].1[steps - 1][1];
    assert!(borne > 200.0 && lost.abs() < 1e-9, "{borne} {lost}");
    assert!(
        (last(5) / last(4) - 1.0).abs() < 0.03 && last(6) < 0.96 * last(5),
        "{} {} {}",
        last(4),
        last(5),
        last(6)
    );
}

/// On finer meshes means and multipliers over the sole come to one force; with FORMS_SWEEPS=1 also on cells of half the size.
#[test]
fn means_and_multipliers_have_one_limit() {
    let finest = if std::env::var_os("FORMS_SWEEPS").is_some() { 4 } else { 3 };
    let apart: Vec<f64> = (2..=finest)
        .map(|fineness| {
            let mesh = mesh(fineness);
            let (by_means, _, _) = forces_by_means_of_the_sole(&mesh, 40);
            let (_, _, pressed) = forces_by_means_of_the_sole(&mesh, 0);
            let (by_multipliers, _, _) = forces_by_multipliers(&mesh, "sole", 40, &pressed);
            let [means, multipliers] = [&by_means, &by_multipliers].map(|forces| forces[39]);
            println!("fineness {fineness}: means {means:.2?}, multipliers {multipliers:.2?}");
            (0..2).map(|k| (means[k] / multipliers[k] - 1.0).abs()).fold(0.0, f64::max)
        })
        .collect();
    assert!(apart[0] < 0.02 && apart[1] < 0.6 * apart[0], "{apart:?}");
    assert!(apart.last() <= Some(&apart[1]), "{apart:?}");
}
