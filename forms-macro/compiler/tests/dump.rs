//! The dump of a form whose figures are known by hand: Poisson's equation, −k Δu = f.

use quote::quote;

fn dump(request: &str) -> String {
    let item = quote! {
        mod poisson {
            struct Data { k: Param, f: Given<Scalar> }
            #[cells] struct Omega;
            pub fn balance(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
                integral(Omega, k * dot(grad(u), grad(v)) - f * v)
            }
            pub fn other(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
                integral(Omega, u * v)
            }
        }
    };
    forms_compiler::dump(quote! {}, item, request).unwrap()
}

/// The line of a kernel in the table of operations.
fn counts<'a>(text: &'a str, kernel: &str) -> &'a str {
    text.lines().find(|line| line.trim_start().starts_with(&format!("{kernel}:"))).unwrap().trim()
}

#[test]
fn what_is_not_asked_for_is_not_printed() {
    assert_eq!(dump(""), "");
    assert_eq!(dump("nothing"), "");
    let text = dump("other:3");
    assert!(text.contains("=== other in 3D: checked ==="));
    assert!(!text.contains("2D") && !text.contains("balance"));
    assert_eq!(dump("balance, other"), dump("all"));
}

#[test]
fn every_stage_is_printed_once_per_dimension() {
    let text = dump("balance");
    for dimension in [2, 3] {
        for stage in ["checked", "differentiated", "optimised", "operations per call", "emitted"] {
            assert_eq!(text.matches(&format!("=== balance in {dimension}D: {stage} ===")).count(), 1);
        }
    }
    assert!(text.contains("integral(Omega, t"), "{text}");
    assert!(text.contains("tangent by du: t"), "{text}");
    assert!(text.contains("impl contract::BilinearKernel<2> for Tangent0 {"), "{text}");
}

/// By hand, in D dimensions. One sum for the block: k w once per point, k w ∂_a ψ per trial node (D products), D products
/// summed per pair. Accumulated: w ∂_a ψ per trial node, D sums per pair, their sum (D − 1 additions) times k at the end.
#[test]
fn operations_of_poissons_equation() {
    for (d, text) in [(2, dump("balance:2")), (3, dump("balance:3"))] {
        let tangent = counts(&text, "Tangent0");
        let expected =
            format!("point 1, test 0, trial {d}, zero_factors 0, zero 0, pair {}, finish 0", 2 * d);
        assert!(tangent.ends_with(&expected), "{tangent}");
        // Per element, linear simplex: D + 1 nodes, one point, the pairs of one half.
        let (nodes, pairs) = (d + 1, (d + 1) * (d + 2) / 2);
        let rows = [
            ("dense", [1, 0, d, d, 0], 1 + nodes * d + pairs * d),
            ("accumulated", [0, 0, d, d, d], nodes * d + 2 * pairs * d),
        ];
        for (plan, operations, linear) in rows {
            let line = text.lines().find(|line| line.trim_start().starts_with(plan)).unwrap();
            let numbers: Vec<usize> =
                line.split_whitespace().skip(1).map(|word| word.parse().unwrap()).collect();
            assert_eq!(numbers[..5], operations, "{line}");
            assert_eq!(numbers[5], linear, "{line}");
        }
    }
}

/// By hand, for the plan of Poisson's equation in two dimensions: point 1, trial 2, pair 2.
#[test]
fn ways_to_run_a_plan() {
    let text = dump("balance:2");
    let tangent = text.split("tangent on").nth(1).unwrap();
    let numbers = |name: &str| -> Vec<String> {
        let line = tangent.lines().find(|line| line.trim_start().starts_with(name)).unwrap();
        line.split_whitespace().skip(2).map(ToString::to_string).collect()
    };
    // Four pairs of derivatives, each of pair 2, with 1 for the point and 2 per trial derivative; 6 pairs of nodes × 4. With
    // six nodes 21 × 4.
    let cell = 1 + 2 * 2 + 4 * 2;
    let expected = ["-", "-", "-", "-", "-", &(cell + 24).to_string(), &(cell + 84).to_string(), "-", "-"];
    assert_eq!(numbers("reference tensor"), expected);
    // n nodes and q points along an axis: 2 × 2 kinds, n² q², and 2 × 2 kinds, n⁴ q.
    let quadrilateral =
        |n: usize, q: usize| (q * q * cell + 4 * n.pow(2) * q.pow(2) + 4 * n.pow(4) * q).to_string();
    let expected = ["-", "-", "-", "-", "-", "-", "-", &quadrilateral(2, 2), &quadrilateral(3, 3)];
    assert_eq!(numbers("sum factorisation"), expected);
}
