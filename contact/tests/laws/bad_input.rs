//! Bad input of contact between bodies, named: surfaces that overlap, a tool that begins inside a body, a partner that is missing;
//! and faces that are driven so far in one step that cells are turned inside out.

use forms_contact::ContactProblem;
use forms_contact::law::ContactLaw;
use forms_contact::laws::finite_nitsche;
use forms_contact::laws::sliding_bodies as sliding;
use forms_contact::laws::two_bodies as law;
use forms_fem::constraints::RigidMap;
use forms_fem::mesh::RigidSurface;
use forms_fem::prelude::*;

use crate::layer::{Inside, plane_layers};
use crate::setting::{Friction, LAMBDA, MU, YOUNG, close, data};
use crate::two_bodies::{WIDTH, constraints, layers};

fn between(friction: f64) -> law::Data<2> {
    let required = law::data().lambda(LAMBDA).mu(MU).gamma0(20.0 * YOUNG);
    required.friction(friction)
}

/// The error of layers in two bodies that touch as is said, by both laws.
fn errors(touch: &Pairing) -> [String; 2] {
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 4], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let assembler = || Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
    fn error<L: ContactLaw<2>>(assembler: Assembler<2>, space: &Arc<Space<2>>, law: L) -> String {
        let problem = ContactProblem::new(space, law, constraints(space, 0.0, 0.01)).assembler(assembler);
        let error = problem.direct().unwrap().solve().err();
        error.map(|error| error.to_string()).unwrap_or_default()
    }
    let regions = law::Regions::default().touch(touch.clone()).gamma_n("upper top");
    let fixed = law::Model { data: between(0.3), regions };
    let regions = sliding::Regions::default().touch(touch.clone()).gamma_n("upper top");
    let slides = sliding::Model { data: between(0.3), regions };
    [error(assembler(), &space, fixed), error(assembler(), &space, slides)]
}

#[test]
fn surfaces_that_overlap() {
    for told in errors(&Pairing::onto("upper boundary", "upper bottom")) {
        let expected = "form `direct`, pairs `Touch` (upper boundary onto upper bottom): \"upper boundary\" and \"upper bottom\" \
                        have 4 facets in common, one of them at [";
        assert!(told.contains(expected) && told.ends_with("(`Pairing::within`)"), "{told}");
    }
}

#[test]
fn a_partner_that_is_missing() {
    for told in errors(&Pairing::onto("lower top", "lid")) {
        let expected = "pairs `Touch` (lower top onto lid): there is no facet region \"lid\"; the mesh has";
        assert!(told.contains(expected), "{told}");
    }
    // Its outward side is turned away. Surfaces that slide may meet later, and their errors say what they have lost.
    let [fixed, _] = errors(&Pairing::onto("lower top", "upper top"));
    let expected = "no point of \"lower top\" faces \"upper top\" within reach (";
    assert!(fixed.contains(expected), "{fixed}");
}

/// A block with the lower end of a tool at a height; the outward side of the polygon is down.
fn pressed(lowest: f64) -> Result<Mesh<2>, forms_fem::mesh::MeshError> {
    let block = rectangle([0.0; 2], [2.0, 1.0], [8, 4], CellShape::Quadrilateral, 1).unwrap();
    let [low, high] = [lowest, lowest + 0.4];
    let tool = RigidSurface::along(&[[0.6, high], [0.8, low], [1.2, low], [1.4, high]]).unwrap();
    block.with_rigid_surfaces(&[("tool", &tool)])
}

#[test]
fn a_tool_inside_a_body() {
    // Its lower end is 0.3 deep where points see 0.4 deep.
    let mesh = pressed(0.7).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let steps = LoadSteps::uniform(2, 0.02).advance(Field::zero(&space), |step| {
        let mut held = Constraints::new(&space);
        held.fix("bottom", |_| [0.0; 2]).unwrap();
        held.move_rigidly("tool", &RigidMap::translation([0.0, -step.factor])).unwrap();
        let touch = Pairing::onto("top", "tool").within_reach(0.4);
        let regions = sliding::Regions::default().touch(touch).gamma_n("right");
        let model = sliding::Model { data: between(0.3).share(1.0), regions };
        let problem = ContactProblem::new(&space, model, held).quadrature(Quadrature::Degree(4));
        problem.direct().unwrap().increment(step).solve().map(Solved::into_field)
    });
    let told = steps.unwrap_err().to_string();
    assert!(
        told.contains("before the step already the point at [") && told.contains("begins inside"),
        "{told}"
    );
    // No surface of the body can see it.
    let within = pressed(0.3).map(|_| ()).unwrap_err();
    assert_eq!(
        within.to_string(),
        "the rigid surface \"tool\" lies inside a body: all of its points, the first at [0.6, 0.7], are in cells that do not reach \
         the boundary. Put it beside the bodies"
    );
}

#[test]
fn sliding_surfaces_that_face_each_other_nowhere() {
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 4], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let solved_by = |quadrature: Quadrature<2>, touch: Pairing| {
        let regions = sliding::Regions::default().touch(touch).gamma_n("upper top");
        let law = sliding::Model { data: between(0.3), regions };
        let problem = ContactProblem::new(&space, law, constraints(&space, 0.0, 0.01)).quadrature(quadrature);
        problem.direct().unwrap().solve().unwrap()
    };
    let solved = |touch: Pairing| solved_by(Quadrature::Degree(4), touch);
    // The one pressed down passes through the other: its solution says so.
    let turned_away = solved(Pairing::onto("lower top", "upper top")).notes();
    let expected =
        "`Touch`: no point of \"lower top\" faces \"upper top\" within reach, so that nothing touches there";
    assert!(turned_away.len() == 1 && turned_away[0].starts_with(expected), "{turned_away:?}");
    // One of several pairs of surfaces, among which others touch.
    let both = Pairing::between("lower top", "upper bottom").and(Pairing::onto("lower top", "upper top"));
    let one = solved(both).notes();
    assert!(one.len() == 1 && one[0].starts_with(expected), "{one:?}");
    let touching = solved(Pairing::between("lower top", "upper bottom"));
    assert!(touching.notes().is_empty() && touching.pairs[0].report.open == 0);
    // A rule that nobody chose is reported where its degree is high.
    assert_eq!(touching.pairs[0].estimated_degree, None);
    let mut estimated = solved_by(Quadrature::Estimated, Pairing::onto("lower top", "upper bottom")).pairs;
    assert!(estimated[0].estimated_degree.is_some() && estimated[0].note_on_quadrature().is_none());
    estimated[0].estimated_degree = Some(33);
    let note = estimated[0].note_on_quadrature().unwrap();
    assert!(note.starts_with("`Touch`: the rule has degree 33, an estimate"), "{note}");
}

/// A layer of two bodies that touch where a function of position jumps; the upper one is a hundred times as stiff. A value on a surface that
/// belongs to the other body is refused. Otherwise the pressure is that of the closed form, two springs in a row.
#[test]
fn a_modulus_that_jumps_where_bodies_touch() {
    const STIFFER: f64 = 100.0;
    const DOWN: f64 = 0.001;
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 4], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let cells = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let share = |touch: &Pairing| 1.0 / touch.surfaces.len() as f64;
    let loaded = |modulus: &dyn Fn(f64) -> Given<f64, 2>, touch: Pairing, load: Given<[f64; 2], 2>| {
        let required = law::data().lambda(modulus(LAMBDA)).mu(modulus(MU)).gamma0(modulus(20.0 * YOUNG));
        let data = required.share(share(&touch)).body_force(load);
        let regions = law::Regions::default().touch(touch).gamma_n("upper top");
        let (held, model) = (constraints(&space, 0.0, DOWN), law::Model { data, regions });
        let problem = ContactProblem::new(&space, model, held);
        let solved = problem.direct().unwrap().solve().map_err(|error| error.to_string())?;
        Ok::<f64, String>(solved.reaction("lower bottom").unwrap()[1] / WIDTH)
    };
    let pressed = |modulus: &dyn Fn(f64) -> Given<f64, 2>, touch: Pairing| {
        loaded(modulus, touch, Given::constant([0.0; 2]))
    };
    let above = |from: f64| {
        move |value: f64| {
            Given::function(move |x: &[f64; 2]| if x[1] > from { STIFFER * value } else { value })
        }
    };
    let by_cell = |value: f64| {
        let of_cell = |x: &[f64; 2]| if x[1] > 0.5 { STIFFER * value } else { value };
        Given::field(Field::interpolate(&cells, of_cell).unwrap())
    };
    let (onto, both) =
        (Pairing::onto("lower top", "upper bottom"), Pairing::between("lower top", "upper bottom"));
    let expected = DOWN * (LAMBDA + 2.0 * MU) / (0.5 + 0.5 / STIFFER);
    // A load that jumps there is that of the points in the cells. Of that of the upper body, 1 per volume, the lower one bears what
    // it bears of a force in the upper one's middle.
    let weight = |from: f64| {
        let load = Given::function(move |x: &[f64; 2]| [0.0, if x[1] > from { -1.0 } else { 0.0 }]);
        loaded(&by_cell, onto.clone(), load)
    };
    let with_weight = expected + 0.25 / (1.0 + STIFFER);
    close("load", weight(0.5 + 1e-9).unwrap(), with_weight, 1e-10);
    close("load", weight(0.5 - 1e-9).unwrap(), with_weight, 1e-10);
    for pressure in [
        pressed(&by_cell, both.clone()),
        pressed(&by_cell, onto.clone()),
        pressed(&above(0.5 + 1e-9), onto.clone()),
    ] {
        close("pressure", pressure.unwrap(), expected, 1e-10);
    }
    // The lower body's surface counts as the upper one's, and in the other case that of the upper one as the lower one's.
    for (from, touch, surface, values) in
        [(0.5 - 1e-9, onto, "lower top", [STIFFER, 1.0]), (0.5 + 1e-9, both, "upper bottom", [1.0, STIFFER])]
    {
        let told = pressed(&above(from), touch).unwrap_err();
        let [on, inside] = values.map(|factor| factor * LAMBDA);
        assert!(told.contains(&format!("`lambda` jumps at the surface \"{surface}\": at [")), "{told}");
        assert!(told.contains(&format!("it is {on} on it and {inside} in the cell behind it")), "{told}");
    }
}

/// F = diag(1, J): p = μ (1/J − J) − λ ln J/J. With all else at rest the cells next to the top would be turned inside out from
/// J = ½ on; those behind go along by the tangent.
#[test]
fn a_face_that_is_driven_far_in_one_step() {
    for layer in plane_layers(Inside::Distorted) {
        let model = || {
            let regions = finite_nitsche::Regions::default().gamma_n("right").gamma_c("bottom");
            finite_nitsche::Model { data: data(Friction::Coulomb(0.3), 0.0, 20.0 * YOUNG), regions }
        };
        for volume in [0.6_f64, 0.4] {
            let pressure = MU * (1.0 / volume - volume) - LAMBDA * volume.ln() / volume;
            let solved = layer.problem(model(), 0.0, 1.0 - volume).direct().unwrap().solve();
            let found = -solved.unwrap().reaction("top").unwrap()[1] / layer.area();
            close("pressure", found, pressure, 1e-9);
        }
        // Between two sides that pass through each other nothing is left of it.
        let mut problem = layer.problem(model(), 0.0, 0.0);
        problem.constraints = Constraints::new(&layer.space);
        problem.constraints.fix("top", |_| [0.0, -1.2]).unwrap();
        problem.constraints.fix("bottom", |_| [0.0; 2]).unwrap();
        let told = problem.direct().unwrap().solve().unwrap_err().to_string();
        println!("{told}");
        assert!(told.contains("iteration 0: the residual is not finite; the forces on `u` at ["), "{told}");
        assert!(told.contains("are no numbers") && told.contains("`LoadSteps`"), "{told}");
    }
}
