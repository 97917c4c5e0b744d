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

/// By hand. Tangent in D dimensions, accumulated: w ∂_a ψ per trial node (D products), D products summed per pair, D
/// sums times k added up at the end.
#[test]
fn operations_of_poissons_equation() {
    for (dimension, text) in [(2, dump("balance:2")), (3, dump("balance:3"))] {
        let d: usize = dimension;
        let tangent = counts(&text, "Tangent0");
        // Only the diagonal sums; D multiply-adds of two operations each.
        let sums = format!("pair {}", 2 * d);
        assert!(tangent.contains(&sums), "{tangent}");
        assert!(tangent.contains(&format!("trial {d},")), "{tangent}");
        assert!(tangent.contains("test 0,"), "{tangent}");
        assert!(tangent.ends_with(&format!("finish {}", 2 * d - 1)), "{tangent}");
        // Accumulated: 5 points × 8² pairs × D sums, and 8² × D to contract. Dense: 5 × (8 (1 + 1) D + 8² D).
        assert!(text.contains(&format!("accumulated {}", 5 * 64 * d + 64 * d)), "{text}");
        assert!(text.contains(&format!("dense {}", 5 * (8 * 2 * d + 64 * d))), "{text}");
    }
}
