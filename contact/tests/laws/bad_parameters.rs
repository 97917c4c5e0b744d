//! Parameters out of their ranges: each of each law is named, before anything is solved.

use forms_contact::ContactProblem;
use forms_contact::law::ContactLaw;
use forms_contact::laws::analytic_obstacle;
use forms_contact::laws::augmented_lagrangian::{augmented_lagrangian, multiplier_problem};
use forms_contact::laws::capsule;
use forms_contact::laws::cohesive;
use forms_contact::laws::contact_heat::{contact_heat, heat_problem};
use forms_contact::laws::finite_nitsche;
use forms_contact::laws::frictional_nitsche;
use forms_contact::laws::frictional_penalty;
use forms_contact::laws::moving_obstacle;
use forms_contact::laws::sliding_bodies;
use forms_contact::laws::two_bodies;
use forms_contact::laws::uzawa;
use forms_contact::laws::wear;
use forms_contact::parameter_ranges::ParameterRanges;
use forms_fem::prelude::*;

use crate::layer::{Inside, plane_layers};
use crate::setting::{Friction, LAMBDA, MU, YOUNG, along, data};
use crate::two_bodies::layers;

/// The least change that takes a parameter out of its range, and the words of the error.
struct Wrong<M> {
    change: fn(&mut M),
    told: &'static str,
}

fn wrong<M>(told: &'static str, change: fn(&mut M)) -> Wrong<M> {
    Wrong { change, told }
}

fn each_is_named<M: ParameterRanges + Clone>(law: &str, right: &M, all: &[Wrong<M>]) {
    right.check("direct").unwrap_or_else(|error| panic!("{law}: {error}"));
    for Wrong { change, told } in all {
        let mut model = right.clone();
        change(&mut model);
        let found = model.check("direct").map_or_else(|error| error.to_string(), |()| "nothing".to_owned());
        assert_eq!(found, format!("form `direct`: the parameter {told}"), "{law}");
    }
}

#[test]
fn laws_on_a_flat() {
    let layer = plane_layers(Inside::Alike).remove(0);
    let flat = || data::<2>(Friction::Coulomb(0.3), 0.0, YOUNG);
    macro_rules! on_a_flat {
        ($law:ident) => {
            let right = $law::Model { data: flat(), regions: $law::Regions::default() };
            each_is_named(
                stringify!($law),
                &right,
                &[
                    wrong("`mu` is 0; it must be positive", |m: &mut $law::Model<2>| m.data.mu = 0.0),
                    wrong("`gamma0` is 0; it must be positive", |m| m.data.gamma0 = 0.0),
                    wrong("`slip_stress` is -1; it must be zero or positive", |m| m.data.slip_stress = -1.0),
                    wrong("`friction` is -0.1; it must be zero or positive", |m| m.data.friction = -0.1),
                    wrong("`obstacle_normal` has the length 2; it must be 1", |m| {
                        m.data.obstacle_normal = Given::constant([0.0, -2.0])
                    }),
                ],
            );
        };
    }
    on_a_flat!(frictional_nitsche);
    on_a_flat!(frictional_penalty);
    on_a_flat!(finite_nitsche);
    on_a_flat!(augmented_lagrangian);

    let assembler = Assembler::new(&layer.mesh).with_quadrature(Quadrature::Degree(4));
    let worn = assembler.history(Entity::Facets, "bottom", 4, 0.0).unwrap();
    let data = wear::data_from(flat()).wear_rate(1e-3).worn(worn);
    each_is_named(
        "wear",
        &wear::Model::<2> { data, regions: wear::Regions::default() },
        &[
            wrong("`mu` is -1; it must be positive", |m| m.data.mu = -1.0),
            wrong("`gamma0` is -1; it must be positive", |m| m.data.gamma0 = -1.0),
            wrong("`slip_stress` is -1; it must be zero or positive", |m| m.data.slip_stress = -1.0),
            wrong("`friction` is -0.1; it must be zero or positive", |m| m.data.friction = -0.1),
            wrong("`obstacle_normal` has the length 2; it must be 1", |m| {
                m.data.obstacle_normal = Given::constant([0.0, -2.0])
            }),
            wrong("`wear_rate` is -1; it must be zero or positive", |m| m.data.wear_rate = -1.0),
        ],
    );
    let multiplier = assembler.history(Entity::Facets, "bottom", 4, [0.0; 2]).unwrap();
    each_is_named(
        "uzawa",
        &uzawa::Model::<2> {
            data: uzawa::data_from(flat()).multiplier(multiplier),
            regions: uzawa::Regions::default(),
        },
        &[
            wrong("`mu` is -1; it must be positive", |m| m.data.mu = -1.0),
            wrong("`gamma0` is -1; it must be positive", |m| m.data.gamma0 = -1.0),
            wrong("`slip_stress` is -1; it must be zero or positive", |m| m.data.slip_stress = -1.0),
            wrong("`friction` is -0.1; it must be zero or positive", |m| m.data.friction = -0.1),
            wrong("`obstacle_normal` has the length 2; it must be 1", |m| {
                m.data.obstacle_normal = Given::constant([0.0, -2.0])
            }),
        ],
    );
}

#[test]
fn laws_with_a_moving_obstacle() {
    let still = [along(0, 1.0), along(1, 1.0)];
    let moving = || {
        moving_obstacle::data()
            .lambda(LAMBDA)
            .mu(MU)
            .gamma0(YOUNG)
            .centre([0.0; 2])
            .rotation(still)
            .centre_before([0.0; 2])
            .rotation_before(still)
    };
    each_is_named(
        "capsule",
        &capsule::Model::<2> {
            data: capsule::data_from(moving()).radius(1.0).half_length(0.1),
            regions: capsule::Regions::default(),
        },
        &[
            wrong("`mu` is 0; it must be positive", |m| m.data.mu = 0.0),
            wrong("`gamma0` is 0; it must be positive", |m| m.data.gamma0 = 0.0),
            wrong("`radius` is 0; it must be positive", |m| m.data.radius = 0.0),
            wrong("`slip_stress` is -1; it must be zero or positive", |m| m.data.slip_stress = -1.0),
            wrong("`friction` is -0.1; it must be zero or positive", |m| m.data.friction = -0.1),
            wrong("`half_length` is -1; it must be zero or positive", |m| m.data.half_length = -1.0),
            wrong(
                "`rotation` is no rotation: an entry of QᵀQ differs by 0.210 from that of the identity",
                |m| m.data.rotation[0][0] = 1.1,
            ),
            wrong("`rotation_before` is no rotation: it mirrors", |m| m.data.rotation_before[1][1] = -1.0),
        ],
    );
    each_is_named(
        "analytic_obstacle",
        &analytic_obstacle::Model::<2> {
            data: analytic_obstacle::data_from(moving()).radius(1.0),
            regions: analytic_obstacle::Regions::default(),
        },
        &[
            wrong("`mu` is 0; it must be positive", |m| m.data.mu = 0.0),
            wrong("`gamma0` is 0; it must be positive", |m| m.data.gamma0 = 0.0),
            wrong("`half_sizes` is -2; it must be zero or positive", |m| m.data.half_sizes = [1.0, -2.0]),
            wrong("`radius` is -1; it must be zero or positive", |m| m.data.radius = -1.0),
            wrong(
                "`rotation` is no rotation: an entry of QᵀQ differs by 0.210 from that of the identity",
                |m| m.data.rotation[0][0] = 1.1,
            ),
            wrong("`rotation_before` is no rotation: it mirrors", |m| m.data.rotation_before[1][1] = -1.0),
            wrong("`slip_stress` is -1; it must be zero or positive", |m| m.data.slip_stress = -1.0),
            wrong("`friction` is -0.1; it must be zero or positive", |m| m.data.friction = -0.1),
        ],
    );
}

fn between() -> two_bodies::Data<2> {
    two_bodies::data().lambda(LAMBDA).mu(MU).gamma0(YOUNG)
}

#[test]
fn laws_between_bodies() {
    macro_rules! between_bodies {
        ($law:ident) => {
            let right = $law::Model { data: between(), regions: $law::Regions::default() };
            each_is_named(
                stringify!($law),
                &right,
                &[
                    wrong("`mu` is -1; it must be positive", |m: &mut $law::Model<2>| {
                        m.data.mu = Given::constant(-1.0)
                    }),
                    wrong("`gamma0` is 0; it must be positive", |m| m.data.gamma0 = Given::constant(0.0)),
                    wrong("`share` is 0; it must be positive", |m| m.data.share = 0.0),
                    wrong("`slip_stress` is -1; it must be zero or positive", |m| m.data.slip_stress = -1.0),
                    wrong("`friction` is -0.1; it must be zero or positive", |m| m.data.friction = -0.1),
                ],
            );
        };
    }
    between_bodies!(two_bodies);
    between_bodies!(sliding_bodies);

    let mesh = layers::<2>(CellShape::Quadrilateral, [3, 4], 0.0);
    let touch = Pairing::between("lower top", "upper bottom");
    let largest_opening = Assembler::new(&mesh).history_on_pairs(&touch, 4, 0.0).unwrap();
    let glued = cohesive::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(YOUNG)
        .stiffness(1000.0)
        .strength(2.0)
        .fracture_energy(0.1)
        .largest_opening(largest_opening);
    each_is_named(
        "cohesive",
        &cohesive::Model::<2> { data: glued, regions: cohesive::Regions::default().touch(touch) },
        &[
            wrong("`mu` is -1; it must be positive", |m| m.data.mu = Given::constant(-1.0)),
            wrong("`gamma0` is 0; it must be positive", |m| m.data.gamma0 = Given::constant(0.0)),
            wrong("`share` is 0; it must be positive", |m| m.data.share = 0.0),
            wrong("`strength` is 0; it must be positive", |m| m.data.strength = 0.0),
            wrong("`fracture_energy` is 0; it must be positive", |m| m.data.fracture_energy = 0.0),
            wrong("`shear_weight` is -1; it must be zero or positive", |m| m.data.shear_weight = -1.0),
            wrong("`stiffness` is 20; it must be above strength²/(2 fracture_energy)", |m| {
                m.data.stiffness = 20.0;
            }),
        ],
    );
}

fn heated() -> contact_heat::Model<2> {
    let data = contact_heat::data_from(between()).conductivity(2.0).conductance(8.0).hardness(40.0);
    contact_heat::Model { data, regions: contact_heat::Regions::default() }
}

#[test]
fn heat_across_a_contact() {
    each_is_named(
        "contact_heat",
        &heated(),
        &[
            wrong("`mu` is -1; it must be positive", |m| m.data.mu = Given::constant(-1.0)),
            wrong("`gamma0` is 0; it must be positive", |m| m.data.gamma0 = Given::constant(0.0)),
            wrong("`share` is 0; it must be positive", |m| m.data.share = 0.0),
            wrong("`conductivity` is 0; it must be positive", |m| m.data.conductivity = Given::constant(0.0)),
            wrong("`effusivity` is 0; it must be positive", |m| m.data.effusivity = Given::constant(0.0)),
            wrong("`hardness` is 0; it must be positive", |m| m.data.hardness = 0.0),
            wrong("`duration` is 0; it must be positive", |m| m.data.duration = 0.0),
            wrong("`slip_stress` is -1; it must be zero or positive", |m| m.data.slip_stress = -1.0),
            wrong("`friction` is -0.1; it must be zero or positive", |m| m.data.friction = -0.1),
            wrong("`conductance` is -1; it must be zero or positive", |m| m.data.conductance = -1.0),
            wrong("`exponent` is -1; it must be zero or positive", |m| m.data.exponent = -1.0),
        ],
    );
}

/// Every way to a solution checks the parameters by itself.
#[test]
fn nothing_is_solved_with_a_bad_parameter() {
    let negative = "`friction` is -0.1; it must be zero or positive";
    let flat = data::<2>(Friction::Coulomb(-0.1), 0.0, YOUNG);
    let layer = plane_layers(Inside::Alike).remove(0);
    let multipliers = Space::discontinuous_vector_on_facets(&layer.mesh, "bottom", 0).unwrap();
    let regions = augmented_lagrangian::Regions::default().gamma_n("right").gamma_c("bottom");
    let model = augmented_lagrangian::Model { data: flat.clone(), regions };
    let told = multiplier_problem(&model, [&layer.space, &multipliers]).err().unwrap().to_string();
    assert!(told.ends_with(negative), "{told}");

    fn driven<L: ContactLaw<2>>(space: &Arc<Space<2>>, law: L) -> String {
        let problem = ContactProblem::new(space, law, Constraints::new(space));
        problem.direct().err().unwrap().to_string()
    }
    let regions = frictional_nitsche::Regions::default().gamma_n("right").gamma_c("bottom");
    let told = driven(&layer.space, frictional_nitsche::Model { data: flat, regions });
    assert!(told.ends_with(negative), "{told}");

    let temperatures = Space::scalar(&layer.mesh, 1).unwrap();
    let mut model = heated();
    model.data.hardness = -40.0;
    let told = heat_problem(&model, &temperatures, &Field::zero(&layer.space)).err().unwrap().to_string();
    assert_eq!(told, "form `heat`: the parameter `hardness` is -40; it must be positive");
}
