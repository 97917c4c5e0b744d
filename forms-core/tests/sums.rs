//! Sums of forms say what they are: fields, regions, data and formulas of their parts.

use forms_core::contract::{CombinationError, Energy, Form, Functional, Role};
use forms_core::forms;

#[forms(crate = forms_core)]
mod bar {
    pub struct Data {
        k: Param,
        load: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    pub fn tension(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, k * dot(grad(u), grad(v)) - load * v)
    }
    pub fn stored(u: Unknown<Scalar>) -> Energy {
        integral(Omega, k / 2 * dot(grad(u), grad(u)))
    }
    pub fn content(u: State<Scalar>) -> Functional {
        integral(Omega, load * u)
    }
}

#[forms(crate = forms_core)]
mod ground {
    pub struct Data {
        depth: Given<Scalar>,
        k: Param,
        #[default(2)]
        load: Given<Scalar>,
    }
    #[facets]
    pub struct Omega;
    #[cells]
    pub struct Bed;

    pub fn bedding(q: Test<Scalar>, w: Unknown<Scalar>) -> Form {
        integral(Omega, k * pow(depth - w, 3) * q + load * q) + integral(Bed, w * q)
    }
    pub fn weight(q: Test<Scalar>) -> Form {
        integral(Bed, -load * q)
    }
    pub fn drift(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Bed, dot(u, v))
    }
    pub fn coupled(u: Unknown<Scalar>, p: Unknown<Scalar>, v: Test<Scalar>, q: Test<Scalar>) -> Form {
        integral(Bed, u * v + p * q)
    }
}

fn tension() -> Form<2> {
    bar::tension(&bar::data().k(3.0).load(1.0), &bar::Omega::on("all"))
}

fn grounds(depth: f64) -> ground::Model<2> {
    let data = ground::data().depth(depth).k(5.0);
    ground::Model {
        data,
        regions: ground::Regions { omega: ground::Omega::on("sole"), bed: ground::Bed::on("bed") },
    }
}

#[test]
fn unknowns_and_tests_are_shared_and_all_else_is_kept() {
    let sum: Form<2> = tension() + grounds(0.1).bedding() + grounds(0.2).weight();
    assert!(sum.check().is_ok());
    let fields: Vec<_> = sum.fields().iter().map(|field| (field.name, field.role)).collect();
    let unknowns = fields.iter().filter(|(_, role)| matches!(role, Role::Unknown(_)));
    assert_eq!(unknowns.collect::<Vec<_>>(), [&("u", Role::Unknown(0))]);
    let tests = fields.iter().filter(|(_, role)| matches!(role, Role::Test(_)));
    assert_eq!(tests.collect::<Vec<_>>(), [&("v", Role::Test(0))]);
    assert_eq!(sum.fields().len(), sum.inputs().sources.len());
    for (field, source) in sum.fields().iter().zip(&sum.inputs().sources) {
        assert_eq!(source.is_some(), matches!(field.role, Role::Given | Role::State), "{field:?}");
    }
    let regions: Vec<_> =
        sum.inputs().regions.iter().map(|region| (region.symbol, region.name.as_str())).collect();
    assert_eq!(regions[0], ("Omega", "all"));
    assert!(regions.contains(&("Omega", "sole")) && regions.contains(&("Bed", "bed")));
    assert_eq!(sum.inputs().parameters.len(), sum.inputs().parameter_names.len());

    // Each kernel reads the fields of its own part, with their names.
    let parts = [tension(), grounds(0.1).bedding(), grounds(0.2).weight()];
    let names = |form: &Form<2>| -> Vec<(String, Vec<&'static str>)> {
        let read = |term: &forms_core::contract::Term<forms_core::contract::LinearConstants>| {
            let region = &form.inputs().regions[term.integral.region];
            let slots = term.kernel.requirements.fields.iter();
            let names = slots.map(|slot| match form.fields()[slot.field].role {
                Role::Unknown(_) => "unknown",
                _ => form.fields()[slot.field].name,
            });
            (region.name.clone(), names.collect())
        };
        form.residual().iter().map(read).collect()
    };
    assert_eq!(names(&sum), parts.iter().flat_map(names).collect::<Vec<_>>());

    // Degrees of the integrands are those of the parts: w³ q on the facets.
    let degrees = |form: &Form<2>| -> Vec<usize> {
        let of = |role| if matches!(role, Role::Unknown(_)) { 3 } else { 1 };
        let fields: Vec<usize> = form.fields().iter().map(|field| of(field.role)).collect();
        form.residual().iter().map(|term| term.integral.degree.of(&fields, 1, true)).collect()
    };
    assert_eq!(degrees(&sum), parts.iter().flat_map(degrees).collect::<Vec<_>>());
}

/// A program that adds the same forms again and again keeps what it made the first time.
#[test]
fn descriptions_of_the_same_sum_are_made_once() {
    let descriptions = |form: &Form<2>| -> Vec<(usize, usize)> {
        let address = |term: &forms_core::contract::Term<forms_core::contract::LinearConstants>| {
            (std::ptr::from_ref(term.integral).addr(), std::ptr::from_ref(term.kernel.requirements).addr())
        };
        form.residual().iter().map(address).collect()
    };
    let sum = |depth: f64| tension() + 2.0 * grounds(depth).bedding();
    assert_eq!(descriptions(&sum(0.1)), descriptions(&sum(0.7)));
    assert_eq!(descriptions(&(3.0 * tension())), descriptions(&tension()));
    assert_eq!(sum(0.1).name().as_ptr(), sum(0.7).name().as_ptr());
}

#[test]
fn formulas_show_the_sum() {
    let bedding = grounds(0.1).bedding();
    let sum: Form<2> = 2.5 * tension() - &bedding + tension();
    let parts = [tension().formula(), bedding.formula()];
    let expected = format!("2.5 tension − bedding + tension\n\n{}\n\n{}", parts[0].unicode, parts[1].unicode);
    assert_eq!(sum.formula().unicode, expected);
    let latex = format!(
        "\\[ 2.5 \\mathrm{{tension}} - \\mathrm{{bedding}} + \\mathrm{{tension}} \\]\n{}\n{}",
        parts[0].latex, parts[1].latex
    );
    assert_eq!(sum.formula().latex, latex);
    assert!((-tension()).formula().unicode.starts_with("−tension\n\n"));
    assert_eq!([&tension()].into_iter().sum::<Form<2>>().formula(), tension().formula());
}

#[test]
fn mismatches_name_forms_and_fields() {
    let errors = [
        tension() + grounds(0.1).drift(),
        tension() + grounds(0.1).coupled(),
        grounds(0.1).weight() + grounds(0.1).coupled(),
        tension() * f64::NAN,
    ]
    .map(|form| form.check().unwrap_err());
    assert!(
        matches!(errors[0], CombinationError::Shape { fields: ["u", "u"], shapes: [[], [2]], .. }),
        "{errors:?}"
    );
    let messages = errors.map(|error| error.to_string());
    assert_eq!(
        messages,
        [
            "`tension` and `drift` cannot be added: one has `u` of shape [] where the other has `u` of shape [2]",
            "`tension` and `coupled` cannot be added: the unknowns are `u` and `u`, `p`",
            "`weight` and `coupled` cannot be added: the test functions are `q` and `v`, `q`",
            "the factor of `tension` is NaN",
        ]
    );
    assert_eq!(std::iter::empty::<Form<2>>().sum::<Form<2>>().check(), Err(CombinationError::Empty));
}

/// A combination is no longer the function that was compiled; forms have no value, energies have one.
#[test]
fn kinds_are_kept() {
    assert!(tension().has_integrals::<bar::tension::Kernels>());
    assert!(!(2.0 * tension()).has_integrals::<bar::tension::Kernels>());
    let stored: Energy<2> = bar::stored(&bar::data().k(3.0).load(1.0), &bar::Omega::on("all"));
    let energy: Energy<2> = &stored + 2.0 * &stored;
    assert_eq!((energy.densities().len(), energy.residual().len()), (2, 2));
    let form: Form<2> = energy + tension();
    assert_eq!((form.densities().len(), form.is_affine()), (0, true));
    let content: Functional<2> = -Functional::from(&stored);
    assert_eq!(content.densities().len(), 1);
}
