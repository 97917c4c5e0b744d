//! Sums and multiples of forms, energies and functionals: compared with what is assembled from their parts, and with the same
//! integrals in one module.

use forms_fem::assemble::BlockPattern;
use forms_fem::prelude::*;
use forms_fem::time::{GeneralisedAlpha, State, Step, TimeLoop};
use forms_fem::verification;

use super::sliding_pairs::{boxes, rubber};
use super::time_schemes::{OSCILLATOR, Oscillator, cell, same};

#[forms(dimension = 2, matrix_free)]
mod body {
    pub struct Data {
        lambda: Param,
        mu: Param,
        /// Weight of an area.
        weight: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    fn stress(w: Vector) -> Tensor {
        lambda * div(w) * I + 2 * mu * eps(w)
    }
    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }
    pub fn stored(u: Unknown<Vector>) -> Energy {
        let F = I + grad(u);
        let J = det(F);
        integral(Omega, mu / 2 * (inner(F, F) - D - 2 * ln(J)) + lambda / 2 * sqr(ln(J)))
    }
    pub fn weighed(u: State<Vector>) -> Functional {
        integral(Omega, weight * u[0])
    }
}

/// Nitsche's method on a flat obstacle, with another order of its fields and a region that several parts bind to other places.
#[forms(dimension = 2)]
mod touching {
    pub struct Data {
        gap: Given<Scalar>,
        lambda: Param,
        mu: Param,
        theta: Param,
        gamma0: Param,
        stiffness: Param,
    }
    #[facets]
    pub struct Contact;

    fn stress(w: Vector) -> Tensor {
        lambda * div(w) * I + 2 * mu * eps(w)
    }
    fn pressed(w: Vector) -> Scalar {
        dot(stress(w) * n, n)
    }
    pub fn nitsche(v: Test<Vector>, u: Unknown<Vector>) -> Form {
        let gamma = gamma0 / h;
        let P = neg_part(pressed(u) - gamma * (dot(u, n) - gap));
        integral(
            Contact,
            -theta / gamma * pressed(u) * pressed(v) - P / gamma * (theta * pressed(v) - gamma * dot(v, n)),
        )
    }
    pub fn springs(u: Unknown<Vector>) -> Energy {
        integral(Contact, stiffness / 2 * dot(u, u) + stiffness * pow(dot(u, u), 2))
    }
    pub fn worn(u: State<Vector>) -> Functional {
        integral(Contact, gap * u[1])
    }
}

/// The same integrals in one module.
#[forms(dimension = 2)]
mod whole {
    pub struct Data {
        lambda: Param,
        mu: Param,
        theta: Param,
        gamma0: Param,
        gap: Given<Scalar>,
        pull: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Contact;
    #[facets]
    pub struct Loaded;

    fn stress(w: Vector) -> Tensor {
        lambda * div(w) * I + 2 * mu * eps(w)
    }
    fn pressed(w: Vector) -> Scalar {
        dot(stress(w) * n, n)
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let gamma = gamma0 / h;
        let P = neg_part(pressed(u) - gamma * (dot(u, n) - gap));
        integral(Omega, inner(stress(u), eps(v)))
            + integral(
                Contact,
                -theta / gamma * pressed(u) * pressed(v)
                    - P / gamma * (theta * pressed(v) - gamma * dot(v, n)),
            )
            - integral(Loaded, dot(pull, v))
    }
}

type Outcome = Result<(), Box<dyn std::error::Error>>;

const LAMBDA: f64 = 1.2;
const MU: f64 = 0.8;
const GAMMA0: f64 = 200.0;

fn solid() -> body::Model<2> {
    body::Model::new(body::data().lambda(LAMBDA).mu(MU).weight(|x: &[f64; 2]| 1.0 + x[0]))
}

/// Contact on a side of the body, at a distance that varies.
fn touch(side: &str, gap: f64) -> Form<2> {
    touching::nitsche(&at(gap), &touching::Contact::on(side))
}

fn at(gap: f64) -> touching::Data<2> {
    let gap = move |x: &[f64; 2]| gap * (1.0 + x[0]);
    touching::data().gap(gap).lambda(LAMBDA).mu(MU).theta(1.0).gamma0(GAMMA0).stiffness(0.6)
}

/// A load on a side, without an unknown.
fn load(side: Side, size: f64) -> Form<2> {
    match side {
        Side::Right => form!(
            |v: Test<Vector>| -> Form { -integral(facets("right"), dot(pull, v)) },
            pull: Given<Vector> = move |x: &[f64; 2]| [size * x[1], -size],
        ),
        Side::Top => form!(
            |v: Test<Vector>| -> Form { -integral(facets("top"), dot(pull, v)) },
            pull: Given<Vector> = move |x: &[f64; 2]| [size * x[1], -size],
        ),
    }
}

#[derive(Clone, Copy)]
enum Side {
    Right,
    Top,
}

fn setting() -> Result<(Assembler<2>, Arc<Space<2>>), Box<dyn std::error::Error>> {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [6, 4], CellShape::Triangle, 1)?;
    Ok((Assembler::new(&mesh), Space::vector(&mesh, 2)?))
}

/// Values that are no polynomial's.
fn wave<const D: usize>(space: &Arc<Space<D>>, frequency: f64, size: f64) -> Field<D> {
    let values = (0..space.unknowns()).map(|k| size * (frequency * k as f64).sin()).collect();
    Field::from_values(space, values).unwrap()
}

/// Σ factor × vector, and the size of what was summed.
fn combined(parts: &[(f64, Vec<f64>)]) -> (Vec<f64>, f64) {
    let mut sum = vec![0.0; parts[0].1.len()];
    let mut size = 0.0_f64;
    for (factor, part) in parts {
        for (sum, value) in sum.iter_mut().zip(part) {
            *sum += factor * value;
            size = size.max((factor * value).abs());
        }
    }
    (sum, size)
}

#[track_caller]
fn assert_near(found: &[f64], (expected, size): (Vec<f64>, f64)) {
    assert_eq!(found.len(), expected.len());
    assert!(size > 1e-3, "the test says nothing: {size}");
    for (row, (found, expected)) in found.iter().zip(&expected).enumerate() {
        assert!((found - expected).abs() <= 4e-15 * size, "row {row}: {found} for {expected}, of {size}");
    }
}

#[track_caller]
fn assert_same(found: &[f64], expected: impl IntoIterator<Item = f64>) {
    let expected: Vec<f64> = expected.into_iter().collect();
    assert!(found == expected, "not the same bits");
}

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

/// Where all parts have kernels for products without a matrix, their sum has; otherwise it says what is missing.
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

/// Elasticity, contact and a load of three modules give the solution of one module, in as many steps of Newton's method.
#[test]
fn parts_of_several_modules_are_one_problem() -> Outcome {
    let (assembler, space) = setting()?;
    let mut held = Constraints::new(&space);
    held.fix("left", |_| [0.0; 2])?;
    let sum = solid().elasticity() + touch("bottom", 0.01) + load(Side::Top, 0.1);
    let pull = |x: &[f64; 2]| [0.1 * x[1], -0.1];
    let gap = |x: &[f64; 2]| 0.01 * (1.0 + x[0]);
    let data = whole::data().lambda(LAMBDA).mu(MU).theta(1.0).gamma0(GAMMA0).gap(gap).pull(pull);
    let one = whole::balance(
        &data,
        &whole::Omega::on("all"),
        &whole::Contact::on("bottom"),
        &whole::Loaded::on("top"),
    );
    let solve = |form: &Form<2>| Problem::new(form, &space).constrained(&held).assembler(&assembler).solve();
    let (found, expected) = (solve(&sum)?, solve(&one)?);
    assert!(expected.history.len() > 2);
    assert_eq!(found.history.len(), expected.history.len());
    let (found, expected) = (found.into_field(), expected.into_field());
    let size = expected.values().iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let difference =
        found.values().iter().zip(expected.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("solutions of size {size} differ by {difference:e}");
    assert!(size > 0.05 && difference < 1e-12 * size);

    // The same with a factor on everything, as weights of energies are.
    let scaled = solve(&(3.0 * &sum))?.into_field();
    let difference =
        scaled.values().iter().zip(expected.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(difference < 1e-12 * size);

    // On paths: the load grows.
    let path = forms_fem::solve::LoadSteps::uniform(3, 1.0).advance(Field::zero(&space), |step| {
        let form = solid().elasticity() + touch("bottom", 0.01) + step.factor * load(Side::Top, 0.1);
        let solved =
            Problem::new(&form, &space).constrained(&held).assembler(&assembler).increment(step).solve()?;
        Ok::<_, SolveError>(solved.into_field())
    });
    let reached = path.map_err(|error| error.to_string())?.state;
    let difference =
        reached.values().iter().zip(expected.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(difference < 1e-11 * size, "{difference:e}");
    Ok(())
}

/// A list of loads that is made at run time, from none to many.
#[test]
fn loads_are_chosen_at_run_time() -> Outcome {
    let (assembler, space) = setting()?;
    let u = wave(&space, 0.37, 0.03);
    let residual = |form: &Form<2>| assembler.residual(form, &[&u], &[&space]);
    let elasticity = solid().elasticity();
    for count in [0, 1, 3, 200] {
        let sides = [Side::Top, Side::Right];
        let loads: Vec<Form<2>> = (0..count).map(|k| load(sides[k % 2], 0.01 * k as f64)).collect();
        let sum = &elasticity + loads.iter().sum::<Form<2>>();
        let mut expected = vec![(1.0, residual(&elasticity)?)];
        for load in &loads {
            expected.push((1.0, assembler.linear_form(load, &space)?));
        }
        let (expected, size) = combined(&expected);
        assert_near(&residual(&sum)?, (expected, size * (1.0 + count as f64)));
        assert!(sum.is_affine());
        let found = residual(&loads.into_iter().fold(elasticity.clone(), |sum, load| sum + load))?;
        assert_same(&found, residual(&sum)?);
    }
    let name = |count: usize| {
        let loads = (0..count).map(|_| load(Side::Top, 1.0));
        (&elasticity + loads.sum::<Form<2>>()).name()
    };
    assert_eq!(
        [name(0), name(2), name(8)],
        ["elasticity", "elasticity + form + form", "elasticity + form + form + form + 5 more"]
    );
    assert_eq!((&elasticity - touch("bottom", 0.0)).name(), "elasticity - nitsche");

    // Loads that only tests read, and their sum, without a body.
    let loads = load(Side::Top, 1.0) - 2.0 * load(Side::Right, 0.5);
    let vectors =
        [load(Side::Top, 1.0), load(Side::Right, 0.5)].map(|load| assembler.linear_form(&load, &space));
    let [top, right] = vectors;
    assert_near(&assembler.linear_form(&loads, &space)?, combined(&[(1.0, top?), (-2.0, right?)]));
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

#[forms]
mod viscous {
    pub struct Data {
        viscosity: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn flow(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * viscosity * inner(eps(u), eps(v)) - p * div(v) - q * div(u))
    }
}

/// The arguments in another order: pressure and velocity are matched by their numbers among unknowns and tests.
#[forms]
mod moving {
    pub struct Data {
        force: Given<Vector>,
        inertia: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn convection(v: Test<Vector>, w: Unknown<Vector>, q: Test<Scalar>, p: Unknown<Scalar>) -> Form {
        integral(Omega, inertia * dot(grad(w) * w, v) + 0 * p * q)
    }
    pub fn gravity(v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, -dot(force, v) + 0 * q)
    }
}

#[test]
fn mixed_problems_match_fields_by_their_numbers() -> Outcome {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 3], CellShape::Triangle, 1)?;
    let (velocities, pressures) = (Space::vector(&mesh, 2)?, Space::scalar(&mesh, 1)?);
    let spaces = [&velocities, &pressures];
    let flow = viscous::flow(&viscous::data().viscosity(0.7), &viscous::Omega::on("all"));
    let data = moving::data().force(|x: &[f64; 2]| [x[1], -x[0]]).inertia(3.0);
    let (convection, gravity) = (
        moving::convection(&data, &moving::Omega::on("all")),
        moving::gravity(&data, &moving::Omega::on("all")),
    );
    let assembler = Assembler::new(&mesh);
    let (u, p) = (wave(&velocities, 0.37, 0.4), wave(&pressures, 0.51, 0.3));
    for sum in
        [&flow + &convection + &gravity, &gravity + &convection + &flow, (&gravity + &flow) + &convection]
    {
        let residual = |form: &Form<2>| assembler.residual(form, &[&u, &p], &spaces);
        let parts = [residual(&flow)?, residual(&convection)?, assembler.residual(&gravity, &[], &spaces)?];
        assert_near(&residual(&sum)?, combined(&parts.map(|part| (1.0, part))));
        let directions = [&wave(&velocities, 0.91, 1.0), &wave(&pressures, 0.77, 1.0)];
        verification::tangent(&assembler, &sum, &[&u, &p], &directions, 1e-3)?.second_order()?;
        let mut walls = Constraints::new(&velocities);
        walls.fix("boundary", |x| [x[1] * (1.0 - x[1]), 0.0])?;
        let mut level = Constraints::new(&pressures);
        level.fix_nearest(&[0.0, 0.0], 0.0)?;
        let solved =
            Problem::new(&sum, spaces).start([&u, &p]).constrained(&walls).constrained(&level).solve()?;
        let at = [&solved.fields[0], &solved.fields[1]];
        let mut rest = assembler.residual(&sum, &at, &spaces)?;
        walls.homogeneous().apply(&mut rest[..velocities.unknowns()]);
        level.homogeneous().apply(&mut rest[velocities.unknowns()..]);
        assert!(rest.iter().all(|value| value.abs() < 1e-12));
    }
    Ok(())
}

#[test]
fn what_does_not_fit_is_an_error_with_both_names() -> Outcome {
    let (assembler, space) = setting()?;
    let scalars = Space::scalar(assembler.mesh(), 1)?;
    let heat = form!(|t: Unknown<Scalar>, s: Test<Scalar>| integral(cells("all"), dot(grad(t), grad(s))));
    let flow = viscous::flow(&viscous::data().viscosity(0.7), &viscous::Omega::on("all"));
    let elasticity = solid().elasticity();
    let (u, t) = (Field::zero(&space), Field::zero(&scalars));
    let shape = "`elasticity` and `form` cannot be added: one has `u` of shape [2] where the other has `t` of shape []";
    let count = "`flow` and `elasticity` cannot be added: the unknowns are `u`, `p` and `u`";
    let scalar_load = form!(|s: Test<Scalar>| -> Form { integral(cells("all"), s) });
    let tests = "`elasticity` and `form` cannot be added: one has `v` of shape [2] where the other has `s` of shape []";
    for (sum, expected) in [
        (&elasticity + &heat, shape),
        (2.0 * (&elasticity - &heat), shape),
        (load(Side::Top, 1.0) + (&elasticity + &heat), shape),
        (&flow + &elasticity, count),
        (&elasticity + &scalar_load, tests),
        (f64::NAN * &elasticity + &elasticity, "the factor of `elasticity` is NaN"),
        (&elasticity * f64::INFINITY, "the factor of `elasticity` is inf"),
        (
            std::iter::empty::<Form<2>>().sum(),
            "a sum of no forms has no unknowns and test functions; add it to a form",
        ),
    ] {
        let mut messages = vec![
            assembler.residual(&sum, &[&u], &[&space]).unwrap_err().to_string(),
            assembler.tangent(&sum, &[&u], &[&space]).unwrap_err().to_string(),
            assembler.action(&sum, &[&u], &[&u], &[&space]).unwrap_err().to_string(),
            assembler.active_set(&sum, &[&u]).unwrap_err().to_string(),
            BlockPattern::for_form(&sum, &[&space], &[&space]).unwrap_err().to_string(),
            assembler.residual(&sum, &[&u, &t], &[&space, &scalars]).unwrap_err().to_string(),
        ];
        messages.push(Problem::new(&sum, &space).solve().unwrap_err().to_string());
        messages.push(Problem::new(&sum, [&space, &scalars]).solve().unwrap_err().to_string());
        for message in messages {
            assert!(message.contains(expected), "{message}\n{expected}");
        }
    }
    // An empty list of loads adds nothing.
    let sum = std::iter::empty::<Form<2>>().sum::<Form<2>>() + &elasticity;
    assert_eq!(sum.name(), "elasticity");
    assembler.residual(&sum, &[&u], &[&space])?;
    // Errors of data name the sum and the field.
    let sum = &elasticity + touch("nowhere", 0.1);
    let message = assembler.residual(&sum, &[&u], &[&space]).unwrap_err().to_string();
    assert!(message.contains("`elasticity + nitsche`") && message.contains("nowhere"), "{message}");
    Ok(())
}

#[forms(dimension = 2)]
mod creeping {
    pub struct Data {
        rate: Param,
        strain: History<Scalar>,
    }
    #[cells]
    pub struct Omega;

    pub fn creep(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, -rate * strain * v)
    }
    pub fn new_strain(u: Scalar) -> Scalar {
        strain + u
    }
}

/// Each part keeps its history: what is committed is read by the sum.
#[test]
fn histories_in_parts_are_read_and_committed() -> Outcome {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 3], CellShape::Quadrilateral, 1)?;
    let (assembler, space) = (Assembler::new(&mesh), Space::scalar(&mesh, 1)?);
    let history = |value: f64| assembler.history(Entity::Cells, "all", 4, value);
    let parts =
        [creeping::data().rate(2.0).strain(history(1.0)?), creeping::data().rate(3.0).strain(history(0.5)?)];
    let omega = creeping::Omega::on("all");
    let mass = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), u * v));
    let sum = &mass + parts.iter().map(|data| creeping::creep(data, &omega)).sum::<Form<2>>();
    let mut problem = Problem::new(&sum, &space).assembler(&assembler);
    let first = problem.solve()?.into_field();
    assert!(first.values().iter().all(|value| (value - 3.5).abs() < 1e-12));
    for data in &parts {
        assembler.update_history(&creeping::new_strain(data, &first), &data.strain)?;
        data.strain.commit();
    }
    // 2 (1 + 3.5) + 3 (0.5 + 3.5).
    let second = problem.solve()?.into_field();
    assert!(second.values().iter().all(|value| (value - 21.0).abs() < 1e-11));
    Ok(())
}

/// Oscillators of half the mass move as the whole one does; a shift of the stiffness by the mass shifts the eigenvalues.
#[test]
fn motions_and_eigenproblems_take_sums() -> Outcome {
    let space = cell()?;
    let run = |form: &dyn Fn(&Step<2>) -> Form<2>| -> Result<Vec<f64>, Box<dyn std::error::Error>> {
        let start = State::at_rest(0.0, same(&space, 1.0));
        let mut motion = TimeLoop::new(form, GeneralisedAlpha::trapezoidal(), start);
        for _ in 0..20 {
            motion.take(0.1)?;
        }
        Ok(motion.state().value.values().to_vec())
    };
    let Oscillator { mass, damping, stiffness, force } = OSCILLATOR;
    let halves = |share: f64| {
        let part = |value: f64| share * value;
        Oscillator {
            mass: part(mass),
            damping: part(damping),
            stiffness: part(stiffness),
            force: part(force),
        }
    };
    let whole = run(&|step| OSCILLATOR.form(0.8)(step).hardening())?;
    let sum = run(&|step| halves(0.25).form(0.8)(step).hardening() + halves(0.75).form(0.0)(step).motion())?;
    let scaled = run(&|step| 4.0 * halves(0.25).form(0.2)(step).hardening())?;
    for found in [sum, scaled] {
        assert!(
            found.iter().zip(&whole).all(|(found, whole)| (found - whole).abs() < 1e-12),
            "{found:?} {whole:?}"
        );
    }

    let mesh = rectangle([0.0; 2], [1.0; 2], [6; 2], CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 2)?;
    let mut rim = Constraints::new(&space);
    rim.fix("boundary", |_| 0.0)?;
    let tension = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v))));
    let mass = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), u * v));
    let values = |stiffness: &Form<2>| -> Result<Vec<f64>, Box<dyn std::error::Error>> {
        let modes = Eigenproblem::vibration(stiffness, &mass, &space).constrained(&rim).smallest(3)?;
        Ok(modes.iter().map(|mode| mode.value).collect())
    };
    let (plain, shifted) = (values(&tension)?, values(&(2.0 * &tension + 3.0 * &mass))?);
    for (plain, shifted) in plain.iter().zip(shifted) {
        assert!((2.0 * plain + 3.0 - shifted).abs() < 1e-9 * shifted, "{plain} {shifted}");
    }
    Ok(())
}
