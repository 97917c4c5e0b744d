//! Residuals, tangents, energies and functionals of sums.

use forms_fem::prelude::*;
use forms_fem::verification;

use super::*;
use crate::sliding_pairs::{boxes, rubber};

/// Residuals, tangents, actions and active sets, of all integrals and of some, on several numbers of threads.
#[test]
fn sums_are_assembled_as_their_parts() -> Outcome {
    let (assembler, space) = setting()?;
    let parts = [
        solid().elasticity(),
        touch("bottom", 0.01),
        touch("right", -0.02),
        load(Side::Top, 0.7),
        solid().stored().into(),
    ];
    for factors in [[1.0; 5], [2.5, -1.0, 0.0, 1.0, -0.3], [0.0, 1.0, 1.0, -2.0, 1.0]] {
        let list = || factors.iter().zip(&parts);
        let sum: Form<2> = list().map(|(factor, part)| *factor * part).sum();
        let (u, w) = (wave(&space, 0.37, 0.03), wave(&space, 0.91, 1.0));
        for threads in [1, 3] {
            let assembler = assembler.clone().with_threads(Threads::new(threads));
            for (some, name) in
                [(Parts::ALL, "all"), (Parts::NONLINEAR, "nonlinear"), (Parts::LINEAR_AND_CONSTANT, "linear")]
            {
                let residual = |form: &Form<2>| {
                    let unknowns: &[&Field<2>] = if form.name() == "form" { &[] } else { &[&u] };
                    assembler.residual_parts(form, unknowns, &[&space], some)
                };
                println!("{name}: {}", sum.name());
                let found: Vec<_> = list()
                    .map(|(k, part)| Ok((*k, residual(part)?)))
                    .collect::<Result<_, AssemblyError>>()?;
                assert_near(&residual(&sum)?, combined(&found));
                if some == Parts::LINEAR_AND_CONSTANT && factors[0] == 0.0 {
                    continue;
                }
                let action = |form: &Form<2>| assembler.action_parts(form, &[&u], &[&w], &[&space], some);
                let of_unknowns = || list().filter(|(_, part)| part.name() != "form");
                let found: Vec<_> =
                    of_unknowns()
                        .map(|(k, part)| Ok((*k, action(part)?)))
                        .collect::<Result<_, AssemblyError>>()?;
                assert_near(&action(&sum)?, combined(&found));
            }
            let tangent = |form: &Form<2>| assembler.tangent(form, &[&u], &[&space]);
            let matrix = tangent(&sum)?;
            let matrices =
                list().filter(|(_, part)| part.name() != "form").map(|(k, part)| Ok((*k, tangent(part)?)));
            let matrices: Vec<_> = matrices.collect::<Result<_, AssemblyError>>()?;
            let row = |row: usize, matrix: &forms_fem::linear_algebra::CsrMatrix| -> Vec<f64> {
                (0..space.unknowns()).map(|column| matrix.get(row, column)).collect()
            };
            let whole = |matrix: &forms_fem::linear_algebra::CsrMatrix| {
                (0..space.unknowns()).flat_map(|k| row(k, matrix)).collect::<Vec<_>>()
            };
            let found: Vec<_> = matrices.iter().map(|(k, matrix)| (*k, whole(matrix))).collect();
            assert_near(&whole(&matrix), combined(&found));
        }
        let active = |form: &Form<2>| assembler.active_set(form, &[&u]);
        let expected: Vec<u32> = parts[1..3]
            .iter()
            .map(|part| Ok(active(part)?.unwrap()))
            .collect::<Result<Vec<_>, AssemblyError>>()?
            .concat();
        assert!(expected.contains(&1) && expected.contains(&0));
        assert_eq!(active(&sum)?, Some(expected), "whatever the factors");
    }
    Ok(())
}

/// Products without a matrix: a sum has kernels for them if all its parts do, and names the missing one otherwise.
#[test]
fn sums_act_without_a_matrix_if_their_parts_do() -> Outcome {
    let (assembler, space) = setting()?;
    let (u, w) = (wave(&space, 0.37, 0.03), wave(&space, 0.91, 1.0));
    let product = |form: &Form<2>| {
        let mut product = vec![0.0; space.unknowns()];
        TangentAction::new(&assembler, form, &[&u]).apply(w.values(), &mut product).map(|()| product)
    };
    let (elasticity, stored): (Form<2>, Form<2>) = (solid().elasticity(), solid().stored().into());
    let sum = &elasticity - 2.5 * &stored + load(Side::Top, 1.0);
    assert_near(&product(&sum)?, combined(&[(1.0, product(&elasticity)?), (-2.5, product(&stored)?)]));
    let message = product(&(sum + touch("bottom", 0.1))).unwrap_err().to_string();
    assert!(message.contains("no kernels for products without a matrix"), "{message}");
    Ok(())
}

/// Powers of two scale without rounding, and zero adds nothing.
#[test]
fn simple_multiples_have_the_same_bits() -> Outcome {
    let (assembler, space) = setting()?;
    let u = wave(&space, 0.37, 0.03);
    let residual = |form: &Form<2>| assembler.residual(form, &[&u], &[&space]);
    let tangent =
        |form: &Form<2>| assembler.tangent(form, &[&u], &[&space]).map(|matrix| matrix.into_values());
    for form in [solid().elasticity(), touch("bottom", 0.01), solid().stored().into()] {
        for factor in [1.0, -1.0, 2.0, 0.5, 0.0] {
            let multiple = factor * &form;
            assert_eq!(multiple.name(), form.name());
            assert_same(&residual(&multiple)?, residual(&form)?.into_iter().map(|value| factor * value));
            assert_same(&tangent(&multiple)?, tangent(&form)?.into_iter().map(|value| factor * value));
        }
        for same in
            [[&form].into_iter().sum::<Form<2>>(), -(-&form), 0.5 * (&form * 2.0), &form + 0.0 * &form]
        {
            assert_same(&residual(&same)?, residual(&form)?);
            assert_same(&tangent(&same)?, tangent(&form)?);
        }
    }
    let (a, b) = (solid().elasticity(), touch("bottom", 0.01));
    let difference = residual(&(&a - &b))?;
    assert_same(&difference, residual(&(&a + &-&b))?);
    let mut changed = a.clone();
    changed -= &b;
    assert_same(&difference, residual(&changed)?);
    changed += b;
    assert_near(&residual(&changed)?, (residual(&a)?, 1.0));
    Ok(())
}

#[test]
fn tangents_of_sums_are_derivatives() -> Outcome {
    let (assembler, space) = setting()?;
    let (u, w) = (wave(&space, 0.37, 0.02), wave(&space, 0.91, 1.0));
    let sum = solid().stored() + 1.7 * touch("bottom", 0.05) + load(Side::Top, 1.0);
    verification::tangent(&assembler, &sum, &[&u], &[&w], 1e-3)?.second_order()?;

    let mesh = boxes::<2>([3, 2], [0.05, 0.02]);
    let (assembler, space) = (Assembler::new(&mesh), Space::vector(&mesh, 1)?);
    let u = Field::interpolate(&space, |x| {
        [0.02 * (3.0 * x[1]).sin(), if x[1] > 1.01 { -0.05 } else { 0.02 * x[0] }]
    })?;
    let data = rubber::data().lambda(1.3).mu(0.7).gamma0(10.0).kappa(0.3).old([0.0; 2]);
    let pairs = rubber::Touch::on(Pairing::between("below", "above"));
    let sum = solid().elasticity() + 0.4 * rubber::balance(&data, &rubber::Omega::on("all"), &pairs);
    let w = wave(&space, 0.91, 1.0);
    assert!(sum.slides());
    verification::tangent(&assembler, &sum, &[&u], &[&w], 1e-4)?.second_order()?;
    // Two sums that have their pairs at other numbers of regions.
    let other = 0.4 * rubber::balance(&data, &rubber::Omega::on("all"), &pairs) + solid().elasticity();
    let residual = |form: &Form<2>| assembler.residual(form, &[&u], &[&space]);
    assert_near(&residual(&sum)?, (residual(&other)?, 1.0));
    let product = |form: &Form<2>| assembler.action(form, &[&u], &[&w], &[&space]);
    assert_near(&product(&sum)?, (product(&other)?, 10.0));
    Ok(())
}

#[test]
fn energies_and_functionals_add_up() -> Outcome {
    let (assembler, space) = setting()?;
    let u = wave(&space, 0.37, 0.03);
    let springs = touching::springs(&at(0.1), &touching::Contact::on("bottom"));
    let sum: Energy<2> = solid().stored() + 2.5 * &springs - 0.5 * solid().stored();
    let value = |energy: &Energy<2>| assembler.energy(energy, &[&u]);
    let expected = 0.5 * value(&solid().stored())? + 2.5 * value(&springs)?;
    assert!(expected > 1e-3 && (value(&sum)? - expected).abs() < 1e-14 * expected);
    assert_same(&[value(&(-&sum))?], [-value(&sum)?]);

    // Its variation is its derivative, and its tangent is symmetric, as the compiler has proved of each part.
    let matrix = assembler.tangent(&sum, &[&u], &[&space])?;
    assert!(matrix.is_symmetric(1e-15)?);
    let w = wave(&space, 0.91, 1.0);
    let slope: f64 =
        assembler.residual(&sum, &[&u], &[&space])?.iter().zip(w.values()).map(|(r, w)| r * w).sum();
    let moved = |step: f64| value_at(&assembler, &sum, &Field::combination(&[(1.0, &u), (step, &w)])?);
    let taylor = verification::taylor(1e-3, &[slope], |step| moved(step).map(verification::Sample::from))?;
    taylor.second_order()?;

    // With a form an energy is its variation.
    let form: Form<2> = &sum + load(Side::Top, 1.0);
    let parts =
        [assembler.residual(&sum, &[&u], &[&space])?, assembler.linear_form(&load(Side::Top, 1.0), &space)?];
    assert_near(&assembler.residual(&form, &[&u], &[&space])?, combined(&parts.map(|part| (1.0, part))));

    let (weighed, worn) =
        (solid().weighed(&u), touching::worn(&at(0.3), &touching::Contact::on("right"), &u));
    let values = [assembler.functional(&weighed)?, assembler.functional(&worn)?];
    let found = assembler.functional(&(2.0 * &weighed - 3.0 * &worn))?;
    assert!((found - (2.0 * values[0] - 3.0 * values[1])).abs() < 1e-15);
    assert_eq!(assembler.functional(&[&weighed, &worn].into_iter().sum())?, values[0] + values[1]);
    assert_eq!(assembler.functional(&std::iter::empty::<&Functional<2>>().sum())?, 0.0);
    Ok(())
}

fn value_at(
    assembler: &Assembler<2>,
    energy: &Energy<2>,
    u: &Field<2>,
) -> Result<f64, Box<dyn std::error::Error>> {
    Ok(assembler.energy(energy, &[u])?)
}
