//! Nearly incompressible bodies with a field for the mean stress on a flat: tangents, symmetry, adjoints, the patch test, both mixed
//! forms, and the displacement form.

use forms_contact::laws::mixed_nitsche::{mixed_nitsche as law, mixed_problem, three_field_problem};
use forms_fem::prelude::*;

use crate::rubber_block::{BULK, MU, Pair, data, layer_pressure, plane_pairs, solid_pair};
use crate::setting::{check_tangent, close, difference, wave};

fn model<const D: usize>(data: law::Data<D>) -> law::Model<D> {
    law::Model { data, regions: law::Regions::default().gamma_n("right").gamma_c("bottom") }
}

fn scalar_wave<const D: usize>(space: &Arc<Space<D>>, size: f64, phase: f64) -> Field<D> {
    let value = |x: &[f64; D]| size * (2.0 * x[0] - 1.3 * x[D - 1] + phase).sin();
    Field::interpolate(space, value).unwrap()
}

fn check_derivatives<const D: usize>(pair: &Pair<D>)
where
    Dim: Dimension<D>,
{
    let (us, ps) = (&pair.displacements, &pair.pressures);
    let [u, v] = [wave(us, 0.05, 0.4), wave(us, 0.05, 2.3)];
    let [p, q] = [scalar_wave(ps, 20.0, 0.3), scalar_wave(ps, 20.0, 1.7)];
    let [j, r] = [scalar_wave(ps, 0.05, 0.9), scalar_wave(ps, 0.05, 2.1)];
    let assembler = Assembler::new(&pair.mesh).with_quadrature(Quadrature::Degree(4));
    for data in [data(BULK, 0.6, 0.0), data(BULK, 0.0, 20.0)] {
        let law = model(data);
        let label = |form: &str| format!("{} {form}", pair.name);
        check_tangent(&label("u, p"), &assembler, &law.direct(), &[&u, &p], &[&v, &q]);
        check_tangent(&label("u, p, j"), &assembler, &law.three_fields(), &[&u, &p, &j], &[&v, &q, &r]);
        check_tangent(&label("energy"), &assembler, &law.energy().into(), &[&u, &p], &[&v, &q]);
        let three: Form<D> = law.three_field_energy().into();
        check_tangent(&label("energy, j"), &assembler, &three, &[&u, &p, &j], &[&v, &q, &r]);
        let tangent = assembler.tangent(&law.energy(), &[&u, &p], &[us, ps]).unwrap();
        assert!(tangent.is_symmetric(1e-13).unwrap(), "{}", pair.name);
        let tangent = assembler.tangent(&three, &[&u, &p, &j], &[us, ps, ps]).unwrap();
        assert!(tangent.is_symmetric(1e-13).unwrap(), "{}", pair.name);
    }
}

#[test]
fn tangents_are_exact_and_those_of_energies_symmetric() {
    plane_pairs(3).iter().for_each(check_derivatives);
    check_derivatives(&solid_pair());
}

/// dJ/dκ where parts stick, slip and lift off.
fn check_adjoint<const D: usize>(pair: &Pair<D>, aside: f64)
where
    Dim: Dimension<D>,
{
    let held = pair.pressed(aside, 0.02);
    let assembler = Assembler::new(&pair.mesh).with_quadrature(Quadrature::Degree(4));
    let options = NewtonOptions {
        relative_tolerance: 1e-12,
        line_search: LineSearch::OnResidual,
        ..NewtonOptions::default()
    };
    let solve = |friction: f64| {
        let law = model(data(BULK, friction, 0.0));
        let problem =
            mixed_problem(&law, pair.spaces()).unwrap().assembler(&assembler).options(options.clone());
        let solved = problem.constrained(&held).solve().unwrap();
        (law, solved.fields)
    };
    let (law, [u, p]) = solve(0.3);
    let adjoint = law.discrete_adjoint(&u, &p);
    let [z, s] = Problem::new(&adjoint, pair.spaces())
        .assembler(&assembler)
        .homogeneous(&held)
        .solve()
        .unwrap()
        .fields;
    let gradient = assembler.functional(&law.by_friction(&u, &p, &z, &s)).unwrap();
    let found = difference(1e-4, |change| {
        let (law, [u, p]) = solve(0.3 + change);
        Ok((assembler.functional(&law.criterion(&u))?, assembler.active_set(&law.direct(), &[&u, &p])?))
    });
    close(pair.name, gradient, found, 1e-7);
}

#[test]
fn adjoint_gradients_are_those_of_differences() {
    plane_pairs(4).iter().for_each(|pair| check_adjoint(pair, 0.03));
    check_adjoint(&solid_pair(), 0.03);
}

/// F = diag(1, J): one pressure and one p on bent cells, for every element, also where K/μ is large.
#[test]
fn a_layer_has_one_pressure() {
    let volume: f64 = 0.9;
    for bulk in [BULK, 1000.0 * MU] {
        let down = if bulk > BULK { 1e-2 } else { 1.0 - volume };
        let pressure = layer_pressure(bulk, 1.0 - down);
        for pair in plane_pairs(3) {
            let mut held = Constraints::new(&pair.displacements);
            held.fix_component("top", 1, |_| -down).unwrap();
            held.fix_component("left", 0, |_| 0.0).unwrap();
            held.fix_component("right", 0, |_| 0.0).unwrap();
            let law = model(data(bulk, 0.0, 0.0));
            let start = Field::interpolate(&pair.displacements, |x| [0.0, -down * x[1]]).unwrap();
            let level = Field::interpolate(&pair.pressures, |_| -0.9 * bulk * down).unwrap();
            let solved = mixed_problem(&law, pair.spaces())
                .unwrap()
                .constrained(&held)
                .start([&start, &level])
                .solve()
                .unwrap();
            let per_length = solved.reaction_of(0, "top").unwrap()[1] / 2.0;
            close(pair.name, -per_length, pressure, 1e-9);
            for p in solved.fields[1].values() {
                assert!((p + bulk * down).abs() < 1e-8 * bulk * down, "{}: {p}", pair.name);
            }
        }
    }
}

/// With j and p in one discontinuous space both mixed forms are one method; both are eliminated cell by cell.
#[test]
fn two_and_three_fields_are_the_same() {
    let [pair, ..] = plane_pairs(4);
    let held = pair.pressed(0.01, 0.02);
    for bulk in [BULK, 1e4 * MU] {
        let law = model(data(bulk, 0.3, 0.0));
        let two = mixed_problem(&law, pair.spaces()).unwrap().constrained(&held).solve().unwrap();
        let spaces = [&pair.displacements, &pair.pressures, &pair.pressures];
        let three = three_field_problem(&law, spaces).unwrap().constrained(&held).solve().unwrap();
        for (two, three) in two.fields.iter().zip(&three.fields) {
            let size = two.values().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
            for (a, b) in two.values().iter().zip(three.values()) {
                assert!((a - b).abs() < 1e-8 * size, "K = {bulk}: {a} and {b}");
            }
        }
        let of_cells = 3 * pair.mesh.cell_count();
        for (report, count) in [(&two.report, of_cells), (&three.report, 2 * of_cells)] {
            let counts = report.as_ref().unwrap().local_unknowns.as_ref().unwrap();
            assert_eq!(counts.eliminated, count, "{counts:?}");
        }
    }
}

/// The same body and contact in displacements.
#[forms(dimension = 2)]
mod displacement {
    use forms_contact::laws::frictional_nitsche::{augmented, law};
    pub use forms_contact::laws::mixed_nitsche::{Data, GammaC, Omega};
    use forms_contact::operators::rubber::{energy_density, first_piola};

    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, derivative(energy_density(u), u, v))
            - integral(GammaC, dot(law(augmented(first_piola(u) * n, u)), v))
    }
}

/// Forces of the displacement form of degree 2 where ν is 0.3, on finer and finer meshes.
#[test]
fn the_displacement_form_is_approached() {
    let bulk = 13.0 / 6.0 * MU;
    let differences: Vec<[f64; 3]> = [4, 8]
        .map(|cells| {
            plane_pairs(cells).map(|pair| {
                let held = pair.pressed(0.02, 0.1);
                let law = model(data(bulk, 0.3, 0.0));
                let mixed = mixed_problem(&law, pair.spaces()).unwrap().constrained(&held).solve().unwrap();
                let space = Space::vector(&pair.mesh, 2).unwrap();
                let mut top = Constraints::new(&space);
                top.fix("top", |_| [0.02, -0.1]).unwrap();
                let mut of_displacements = displacement::Model::new(law.data.clone());
                of_displacements.regions.gamma_c = law.regions.gamma_c.clone();
                let form = of_displacements.balance();
                let options =
                    NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
                let plain = Problem::new(&form, &space).constrained(&top).options(options).solve().unwrap();
                let [mixed, plain] = [mixed.reaction_of(0, "top").unwrap(), plain.reaction("top").unwrap()];
                println!("{} {cells}: {mixed:?} {plain:?}", pair.name);
                (mixed[1] / plain[1] - 1.0).abs()
            })
        })
        .into();
    for (k, name) in ["Q2/P-1", "P2/P1", "MINI"].iter().enumerate() {
        let [coarse, fine] = [differences[0][k], differences[1][k]];
        println!("{name}: {coarse:.1e}, {fine:.1e}");
        assert!(fine < 0.7 * coarse && fine < 0.01, "{name}: {coarse:e}, {fine:e}");
    }
}
