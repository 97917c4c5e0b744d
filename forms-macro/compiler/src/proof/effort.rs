//! The cost of compiling a form grows as the form does: counted as the work of planning ([`Source::work`]), which does not
//! depend on the machine.

use super::growth::emitted;
use super::source::Source;

/// The determinant of a product of n + 1 matrices, as an energy.
fn determinant(n: usize) -> String {
    let product = vec!["F"; n + 1].join(" * ");
    format!(
        "mod m {{ #[cells] struct Omega;
        fn f(u: Unknown<Vector>) -> Energy {{ let F = I + grad(u); integral(Omega, det({product})) }} }}"
    )
}

/// The product of n unknowns, as an energy: its tangent has n² blocks of products.
fn unknowns(n: usize) -> String {
    let list = |one: fn(usize) -> String, sign: &str| (0..n).map(one).collect::<Vec<_>>().join(sign);
    let (arguments, product) =
        (list(|k| format!("u{k}: Unknown<Scalar>"), ", "), list(|k| format!("u{k}"), " * "));
    format!("mod m {{ #[cells] struct Omega; fn f({arguments}) -> Energy {{ integral(Omega, {product}) }} }}")
}

/// The product of n + 1 tensors of rank four, which are the unknown, as an energy.
fn rank_four(n: usize) -> String {
    let product = (0..n).fold("C".to_string(), |inner, _| format!("ddot({inner}, C)"));
    format!(
        "mod m {{ #[cells] struct Omega;
        fn f(C: Unknown<Tensor4>) -> Energy {{ integral(Omega, inner({product}, C)) }} }}"
    )
}

/// A sum of n different integrals.
fn integrals(n: usize) -> String {
    let list: Vec<String> = (0..n).map(|k| format!("integral(Omega, {k} * pow(u, {k}) * v)")).collect();
    let sum = list.join(" + ");
    format!(
        "mod m {{ #[cells] struct Omega; fn f(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {{ {sum} }} }}"
    )
}

/// From one depth to the next the work grows by less than a power of the depth, and is never more than is given to a form.
fn grows_as(name: &str, form: fn(usize) -> String, dimension: usize, depths: &[usize], power: i32) {
    let mut before: Option<(usize, usize)> = None;
    for &depth in depths {
        let work = Source::new(dimension, &form(depth)).work();
        println!("{name} {depth} in {dimension}D: work {work}");
        assert!(0 < work && work < 25_000_000, "{name} of depth {depth} in {dimension}D: work {work}");
        if let Some((shallower, less)) = before {
            let most = 1.5 * less as f64 * (depth as f64 / shallower as f64).powi(power);
            assert!(
                (work as f64) < most,
                "{name}: from depth {shallower} to {depth} work grows from {less} to {work}"
            );
        }
        before = Some((depth, work));
    }
}

#[test]
fn determinants_of_products() {
    grows_as("a determinant", determinant, 2, &[2, 4, 7, 10, 14, 28], 3);
    grows_as("a determinant", determinant, 3, &[4, 7, 10, 14], 3);
}

#[test]
fn products_of_unknowns() {
    grows_as("unknowns", unknowns, 2, &[4, 8, 16, 32], 4);
}

#[test]
fn sums_of_integrals() {
    grows_as("a sum", integrals, 2, &[50, 100, 200, 400], 2);
    let [characters, _] = emitted("400 integrals", 2, &integrals(400));
    assert!(characters < 2_000_000, "{characters} characters");
    // A longer one is refused by its length, and compiled in parts.
    let text = Source::new(2, &integrals(600)).emitted().to_string();
    assert!(text.contains("too long or nests too deep"), "{}", &text[..300]);
    let halves = integrals(600)
        .replace("-> Form { ", "-> Form { let first = ")
        .replace("+ integral(Omega, 300 ", "; first + integral(Omega, 300 ");
    emitted("600 integrals in two parts", 2, &halves);
}

/// A form that is too large is refused soon: all that is done for it counts.
#[test]
fn tensors_of_rank_four() {
    grows_as("rank four", rank_four, 2, &[1, 2, 3, 4], 4);
    for depth in [3, 4, 8] {
        let form = Source::new(3, &rank_four(depth));
        let text = form.emitted().to_string();
        assert!(text.contains("more than 1.5 million scalar operations"), "{}", &text[..300]);
        let work = form.work();
        println!("rank four {depth} in 3D: refused after work {work}");
        assert!((1..15_000_000).contains(&work), "refused after work {work}");
    }
}
