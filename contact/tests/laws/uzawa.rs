//! Uzawa's iteration: layers with known answers and a known rate, a block against the augmented Lagrangian that has the same
//! discrete solution, and why it ends.

use forms_contact::ContactProblem;
use forms_contact::laws::augmented_lagrangian;
use forms_contact::laws::frictional_nitsche as flat;
use forms_contact::laws::uzawa as law;
use forms_contact::uzawa::{UzawaError, UzawaOptions, solve_by_uzawa};
use forms_fem::prelude::*;

use crate::layer::{Answer, Inside, Layer, plane_layers, solid_layers};
use crate::setting::{Friction, LAMBDA, MU, YOUNG, close, data};

fn model<const D: usize>(base: flat::Data<D>, multiplier: History<[f64; D], D>) -> law::Model<D> {
    let data = law::data_from(base).multiplier(multiplier);
    law::Model { data, regions: law::Regions::default().gamma_n("right").gamma_c("bottom") }
}

/// From λ = 0: exact in the limit, and the pressure's error falls by M/(M + γ H) each time, that of stick by μ/(μ + γ H).
fn layers<const D: usize>(layer: &Layer<D>)
where
    Dim: Dimension<D>,
{
    let stiffness = LAMBDA + 2.0 * MU;
    let pressure = stiffness * 0.01;
    // All cells have one diameter.
    let gamma0 = 5.0 * YOUNG;
    let gamma = gamma0 / layer.mesh.diameter(0);
    for (friction, aside) in [(0.0, 0.0), (0.3, 0.01), (0.3, 0.02)] {
        let bound: f64 = friction * pressure;
        let shear = bound.min(MU * aside);
        let answer = Answer { pressure, shear, slip: if friction > 0.0 { aside - shear / MU } else { 0.0 } };
        let assembler = Assembler::new(&layer.mesh).with_quadrature(Quadrature::Degree(4));
        let multiplier = assembler.history(Entity::Facets, "bottom", 4, [0.0; D]).unwrap();
        let problem =
            layer.problem(model(data(Friction::Coulomb(friction), 0.0, gamma0), multiplier), aside, 0.01);
        let options = UzawaOptions { tolerance: 1e-13, ..UzawaOptions::default() };
        let mut rates = vec![];
        let start = Field::zero(&layer.space);
        let found =
            solve_by_uzawa(&problem, &start, options, |history| rates.extend(history.rate())).unwrap();
        println!("{D}D, {friction}, {aside}: {}; rates {:.4?}", found.history, &rates[..rates.len().min(6)]);
        let reaction = found.solved.reaction("top").unwrap();
        let traction: Vec<f64> = reaction.iter().map(|force| force / layer.area()).collect();
        let label = format!("{D}D, {friction}, {aside}");
        answer.check(&label, &traction, layer.slips(found.solved.field()), 1e-11);
        // λ itself: the pressure up, friction against the motion.
        for value in problem.assembler.history_values(&problem.law.data.multiplier).unwrap() {
            assert!((value[D - 1] - pressure).abs() < 1e-11 * pressure, "{value:?}");
            assert!((value[0] + shear).abs() < 1e-11 * pressure, "{value:?}");
        }
        if friction == 0.0 {
            // The change is measured relative to λ, which grows at first; with λ known the rate is that of the layer.
            close("rate", rates[6], stiffness / (stiffness + gamma), 1e-3);
        }
    }
}

#[test]
fn layers_come_out_exactly() {
    plane_layers(Inside::Alike).iter().for_each(layers);
    layers(&solid_layers(Inside::Alike)[0]);
}

/// With one point per facet the multiplier of each facet is that of Alart and Curnier's method of degree 0, integrated by the
/// same rule: one discrete solution, in which parts stick, slip and lift off.
#[test]
fn a_block_comes_to_the_augmented_lagrangian() {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [12, 6], CellShape::Triangle, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(1));
    let mut constraints = Constraints::new(&space);
    constraints.fix("top", |x| [0.003, -0.02 + 0.012 * x[0]]).unwrap();
    let base = || data::<2>(Friction::Coulomb(0.3), 0.0, 20.0 * YOUNG);

    let multiplier = assembler.history(Entity::Facets, "bottom", 1, [0.0; 2]).unwrap();
    let law = model(base(), multiplier);
    let problem = ContactProblem::new(&space, law, constraints.clone()).assembler(assembler.clone());
    let start = Field::zero(&space);
    let options = UzawaOptions { tolerance: 1e-12, ..UzawaOptions::default() };
    let found = solve_by_uzawa(&problem, &start, options, |_| ()).unwrap();
    println!("block: {}", found.history);
    let u = found.solved.field();

    // The multipliers as a field of degree 0: the nodes are the points of the facets.
    let multipliers = Space::discontinuous_vector_on_facets(&mesh, "bottom", 0).unwrap();
    let known =
        assembler.at_quadrature_points(&problem.law.obstacle_traction(u), Entity::Facets, "bottom", 1);
    let known = known.unwrap();
    let at = |x: &[f64; 2]| -> [f64; 2] {
        let near = |y: &[f64; 2]| (x[0] - y[0]).abs() < 1e-12;
        let point = known.positions.iter().position(near).unwrap();
        [known.values[point][0], known.values[point][1]]
    };
    let values = multipliers.positions().iter().flat_map(at).collect();
    let multiplier = Field::from_values(&multipliers, values).unwrap();
    let regions = augmented_lagrangian::Regions::default().gamma_n("right").gamma_c("bottom");
    let form = augmented_lagrangian::Model { data: base(), regions }.direct();
    let residual = assembler.residual(&form, &[u, &multiplier], &[&space, &multipliers]).unwrap();
    let (forces, conditions) = residual.split_at(space.unknowns());
    let most = |values: &[f64]| values.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    // The reactions of the top stay, all else is in balance.
    let held = space.nodes_on("top").unwrap();
    let free = |index: usize| !held.contains(&((index / 2) as u32));
    let rest: Vec<f64> = (0..forces.len()).filter(|index| free(*index)).map(|index| forces[index]).collect();
    let gamma = 20.0 * YOUNG / mesh.diameter(0);
    let conditions = most(conditions) * gamma / (most(multiplier.values()) * 2.0 / 12.0);
    println!("the augmented Lagrangian's residual: {:.1e}, {conditions:.1e}", most(&rest) / most(forces));
    assert!(most(&rest) < 1e-10 * most(forces) && conditions < 1e-10);
    // All kinds of points are there.
    let values = problem.assembler.history_values(&problem.law.data.multiplier).unwrap();
    let kinds = values.iter().fold([0; 3], |mut kinds, value| {
        let bound = 0.3 * value[1];
        kinds[if value[1] == 0.0 {
            0
        } else if value[0].abs() < (1.0 - 1e-6) * bound {
            1
        } else {
            2
        }] += 1;
        kinds
    });
    println!("open, stick, slip: {kinds:?}");
    assert!(kinds.iter().all(|count| *count > 0), "{kinds:?}");
    // Linear convergence.
    let changes: Vec<f64> = found.history.steps.iter().map(|step| step.change).collect();
    let (last, early) = (changes[changes.len() - 1], changes[changes.len() / 2]);
    let rate = (last / early).powf(1.0 / (changes.len() - 1 - changes.len() / 2) as f64);
    assert!(rate < 0.95, "{rate}");
}

#[test]
fn it_says_why_it_ends() {
    let layer = &plane_layers(Inside::Alike)[0];
    let assembler = Assembler::new(&layer.mesh).with_quadrature(Quadrature::Degree(4));
    let multiplier = || assembler.history(Entity::Facets, "bottom", 4, [0.0; 2]).unwrap();
    let soft = model(data(Friction::Coulomb(0.0), 0.0, 1e-2 * YOUNG), multiplier());
    let problem = layer.problem(soft, 0.0, 0.01);
    let options = UzawaOptions { max_iterations: 5, ..UzawaOptions::default() };
    let start = Field::zero(&layer.space);
    let error = solve_by_uzawa(&problem, &start, options, |_| ()).unwrap_err();
    assert!(
        matches!(&error, UzawaError::NotConverged { history, .. } if history.steps.len() == 5),
        "{error}"
    );
    let message = error.to_string();
    assert!(message.contains("5 iterations") && message.contains("a larger γ₀"), "{message}");
    // Nothing touches: one iteration.
    let free = layer.problem(model(data(Friction::Coulomb(0.0), 0.0, YOUNG), multiplier()), 0.0, -0.01);
    let found = solve_by_uzawa(&free, &start, UzawaOptions::default(), |_| ()).unwrap();
    assert_eq!((found.history.steps.len(), found.history.steps[0].change), (1, 0.0));
    // A parameter out of its range.
    let wrong = layer.problem(model(data(Friction::Coulomb(-0.1), 0.0, YOUNG), multiplier()), 0.0, 0.01);
    let error = solve_by_uzawa(&wrong, &start, UzawaOptions::default(), |_| ()).unwrap_err().to_string();
    assert!(error.contains("the parameter `friction`"), "{error}");
}
