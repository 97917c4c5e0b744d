//! The attribute on arbitrary tokens: it never panics, never hangs, and always gives Rust.

mod harness;
mod mutations;
mod odd;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use harness::survives;
use mutations::{Random, mutate, soup};
use proc_macro2::TokenStream;

/// Small modules, which between them use the whole language.
const CORPUS: &[&str] = &[
    "pub mod poisson {
        pub struct Data { k: Param, f: Given<Scalar> }
        #[cells] pub struct Omega;
        #[facets] pub struct Wall;
        fn flux(t: Scalar) -> Vector { -k * grad(t) }
        pub fn balance(t: Unknown<Scalar>, v: Test<Scalar>) -> Form {
            integral(Omega, -dot(flux(t), grad(v)) - f * v) + integral(Wall, 2 * t * v)
        }
    }",
    "mod solid {
        struct Data { a: Param, b: Param<Vector>, C: Param<Tensor> }
        #[cells] struct Omega;
        fn energy(u: Unknown<Vector>) -> Energy {
            let F: Tensor = I + grad(u);
            let J = det(F);
            integral(Omega, a / 2 * (inner(F, F) - D - 2 * ln(J)) + pow(J - 1, 2) * b[0] * C[(0, 1)])
        }
    }",
    "mod contact {
        struct Data { gap: Given<Scalar> }
        #[facets] struct Gamma;
        fn pressure(u: Vector) -> Scalar { neg_part(dot(u, n) - gap) }
        fn work(u: State<Vector>) -> Functional { integral(Gamma, pressure(u) * h) }
        fn contact(u: Unknown<Vector>, v: Test<Vector>) -> Form {
            integral(Gamma, if dot(u, n) > 0 && !(gap == 1) { pressure(u) * dot(v, n) } else { 0 })
                - derivative(work(u), u, v) / 2
        }
        fn slope(u: Vector) -> Vector { let w = u + x; diff(sqrt(1 + dot(w, w)), w) }
    }",
    "mod broken {
        struct Data { gamma: Param }
        #[cells] struct Omega;
        #[interior_facets] struct Skeleton;
        fn consistency(u: Scalar, v: Scalar) -> Scalar { dot(avg(grad(u)), n) * jump(v) }
        fn interior_penalty(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
            integral(Omega, dot(grad(u), grad(v)))
                + integral(Skeleton, gamma / avg(h) * jump(u) * jump(v) - consistency(u, v) - consistency(v, u))
        }
    }",
    "mod mixed {
        #[cells] struct Omega;
        fn stokes(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
            integral(Omega, inner(eps(u), eps(v)) - p * div(v)) - integral(Omega, q * div(u))
        }
        fn vorticity(u: Vector) -> Tensor { [[0, grad(u)[0][1]], [{ let a = 1.5; a * u[1] }, max(u[0], 0)]] }
    }",
];

/// No module of the corpus takes nearly as long, on a machine that does nothing else.
const LONGEST: Duration = Duration::from_secs(20);

fn check(tokens: TokenStream) {
    let text = tokens.to_string();
    check_text(tokens, &text);
}

/// Printing tokens recurses: those that nest very deep come with their text.
fn check_text(tokens: TokenStream, text: &str) {
    let start = Instant::now();
    let result = catch_unwind(AssertUnwindSafe(|| survives(tokens)));
    assert!(result.is_ok(), "the compiler panicked on\n{text}");
    if start.elapsed() > Duration::from_secs(1) {
        eprintln!("{:?} for {} characters: {text:.120}", start.elapsed(), text.len());
    }
    assert!(start.elapsed() < LONGEST, "{:?} for\n{text}", start.elapsed());
}

/// `FORMS_MUTATIONS` gives another number.
fn count(usual: usize) -> usize {
    std::env::var("FORMS_MUTATIONS").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

#[test]
fn the_corpus_compiles() {
    for source in CORPUS {
        let output = forms_compiler::forms(quote::quote! { dimension = 2 }, source.parse().expect("tokens"));
        assert!(!output.to_string().contains("compile_error"), "{output}");
    }
}

#[test]
fn mutated_modules() {
    let corpus: Vec<TokenStream> = CORPUS.iter().map(|source| source.parse().expect("tokens")).collect();
    for seed in 0..count(18_000) {
        let mut random = Random(seed as u64);
        let mut tokens = corpus[random.below(corpus.len())].clone();
        for _ in 0..1 + random.below(3) {
            tokens = mutate(tokens, &mut random);
        }
        check(tokens);
    }
}

#[test]
fn token_soup() {
    for seed in 0..count(2_000) {
        let mut random = Random(seed as u64);
        let inside = soup(&mut random, 20);
        check(match random.below(3) {
            0 => inside,
            1 => quote::quote! { mod m { #inside } },
            _ => quote::quote! { mod m { fn f(u: Vector) -> Scalar { #inside } } },
        });
    }
}

/// A form with this density.
fn density(text: &str) -> TokenStream {
    let source = format!(
        "mod m {{ #[cells] struct Omega; fn f(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {{
            integral(Omega, {text}) }} }}"
    );
    source.parse().expect("tokens")
}

/// The stack of rustc's threads, on which macros run.
const STACK: usize = 8 << 20;

/// Without optimisation, as macros are compiled in anyone's debug builds, this takes four to six megabytes.
#[test]
fn deep_nesting() {
    let deep = std::thread::Builder::new().stack_size(STACK).spawn(nest_deep).expect("a thread");
    assert!(deep.join().is_ok());
}

fn nest_deep() {
    for depth in [100, 10_000] {
        let around = |open: &str, inner: &str, close: &str| {
            format!("{}{inner}{}", open.repeat(depth), close.repeat(depth))
        };
        for text in [
            around("(", "u * v", ")"),
            around("{", "u * v", "}"),
            around("-", "u * v", ""),
            around("!", "u * v", ""),
            around("sin(", "u", ") * v"),
            around("[", "u * v", "]"),
            around("u + ", "v", ""),
            around("u * ", "v", ""),
            around("if u > 0 { 0 } else ", "{ v }", ""),
            around("{ let a = ", "v", "; a }"),
            around("&", "u", ""),
            around("return ", "u", ""),
            around("|a| ", "u", ""),
            around("u = ", "v", ""),
            around("u .. ", "v", ""),
            around("", "u", "[0]"),
            around("", "u", "()"),
            around("", "u", "?"),
            around("", "u", ".a"),
            around("", "u", " as f64"),
        ] {
            check_text(density(&text), &text);
        }
        let boxes = format!("v as {}u{}", "Box<".repeat(depth), ">".repeat(depth));
        check_text(density(&boxes), &boxes);
        // Names that build on one another are not limited: the stages recurse as deep as the chain is long.
        let depth = depth.min(16);
        let lets: String = (0..depth).map(|i| format!("let a{} = a{i} + sin(a{i}); ", i + 1)).collect();
        check(density(&format!("{{ let a0 = u; {lets} a{depth} * v }}")));
    }
}

#[test]
fn calls_that_multiply() {
    // 2⁴⁰ terms, if they were all written out.
    let functions: String =
        (0..40).map(|i| format!("fn f{}(a: Scalar) -> Scalar {{ f{i}(a) + f{i}(a * a) }}", i + 1)).collect();
    let source = format!("mod m {{ fn f0(a: Scalar) -> Scalar {{ a }} {functions} }}");
    check(source.parse().expect("tokens"));
}
