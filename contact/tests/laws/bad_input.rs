//! Bad input of contact between bodies, named: surfaces that overlap, a tool that begins inside a body, a partner that is missing, a
//! coefficient out of its range; and faces that are driven so far in one step that cells are turned inside out.

use forms_contact::ContactProblem;
use forms_contact::law::ContactLaw;
use forms_contact::laws::analytic_obstacle::analytic_obstacle;
use forms_contact::laws::capsule::capsule;
use forms_contact::laws::finite_nitsche::finite_nitsche;
use forms_contact::laws::frictional_penalty::frictional_penalty;
use forms_contact::laws::moving_obstacle::moving_obstacle;
use forms_contact::laws::sliding_bodies::sliding_bodies as sliding;
use forms_contact::laws::two_bodies::two_bodies as law;
use forms_contact::laws::uzawa::uzawa;
use forms_contact::laws::wear::wear;
use forms_fem::constraints::RigidMap;
use forms_fem::mesh::RigidSurface;
use forms_fem::prelude::*;

use crate::layer::{Inside, plane_layers};
use crate::setting::{Friction, LAMBDA, MU, YOUNG, along, close, data};
use crate::two_bodies::{constraints, layers};

fn between(friction: f64) -> law::Data<2> {
    let required = law::Required { lambda: LAMBDA.into(), mu: MU.into(), gamma0: (20.0 * YOUNG).into() };
    law::Data { friction, ..required.into() }
}

/// The error of layers in two bodies that touch as is said, by both laws.
fn errors(touch: &Pairing) -> [String; 2] {
    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 4], 0.0);
    let space = Space::vector(&mesh, 1).unwrap();
    let assembler = || Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
    fn error<L: ContactLaw<2>>(assembler: Assembler<2>, space: &Arc<Space<2>>, law: L) -> String {
        let problem = ContactProblem::new(assembler, space, law, constraints(space, 0.0, 0.01)).unwrap();
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
    let mesh = Arc::new(pressed(0.7).unwrap());
    let space = Space::vector(&mesh, 1).unwrap();
    let steps = LoadSteps::uniform(2, 0.02).advance(Field::zero(&space), |step| {
        let mut held = Constraints::new(&space);
        held.fix("bottom", |_| [0.0; 2]).unwrap();
        held.move_rigidly("tool", &RigidMap::translation([0.0, -step.factor])).unwrap();
        let touch = Pairing::onto("top", "tool").within_reach(0.4);
        let regions = sliding::Regions::default().touch(touch).gamma_n("right");
        let model = sliding::Model { data: law::Data { share: 1.0, ..between(0.3) }, regions };
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
        let problem = ContactProblem::new(assembler, &space, model, held).unwrap();
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
fn a_negative_coefficient_by_each_law() {
    fn told<L: ContactLaw<2>>(law: &L) -> String {
        law.check("direct").unwrap_err().to_string()
    }
    let layer = plane_layers(Inside::Alike).remove(0);
    let assembler = Assembler::new(&layer.mesh).with_quadrature(Quadrature::Degree(4));
    let flat = || data::<2>(Friction::Coulomb(-0.1), 0.0, YOUNG);
    let still = [along(0, 1.0), along(1, 1.0)];
    let moving = || moving_obstacle::Data {
        friction: -0.1,
        ..moving_obstacle::Required {
            lambda: LAMBDA,
            mu: MU,
            gamma0: YOUNG,
            centre: [0.0; 2],
            rotation: still,
            centre_before: [0.0; 2],
            rotation_before: still,
        }
        .into()
    };
    let worn = assembler.history(Entity::Facets, "bottom", 4, 0.0).unwrap();
    let multiplier = assembler.history(Entity::Facets, "bottom", 4, [0.0; 2]).unwrap();
    let wear_data = wear::Required { base: flat(), wear_rate: 1e-3, worn }.into();
    let errors = [
        told(&law::Model { data: between(-0.1), regions: law::Regions::default() }),
        told(&sliding::Model { data: between(-0.1), regions: sliding::Regions::default() }),
        told(&frictional_penalty::Model { data: flat(), regions: frictional_penalty::Regions::default() }),
        told(&finite_nitsche::Model { data: flat(), regions: finite_nitsche::Regions::default() }),
        told(&wear::Model { data: wear_data, regions: wear::Regions::default() }),
        told(&uzawa::Model {
            data: uzawa::Data { base: flat(), multiplier },
            regions: uzawa::Regions::default(),
        }),
        told(&capsule::Model {
            data: capsule::Data { base: moving(), half_length: 0.1, radius: 1.0 },
            regions: capsule::Regions::default(),
        }),
        told(&analytic_obstacle::Model {
            data: analytic_obstacle::Required { base: moving(), radius: 1.0 }.into(),
            regions: analytic_obstacle::Regions::default(),
        }),
    ];
    for told in errors {
        let ends = "friction` is -0.1; it must be zero or positive";
        assert!(told.starts_with("form `direct`: the parameter `") && told.ends_with(ends), "{told}");
    }
}

/// F = diag(1, J): p = μ (1/J − J) − λ ln J/J. With all else at rest the cells beside the top would be turned inside out from
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
