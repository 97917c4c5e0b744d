//! The attribute on arbitrary tokens: it never panics, never hangs, and always gives Rust.

mod harness;
mod mutations;
mod odd;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex};
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
    "mod material {
        struct Data { C: Param<Tensor4>, old: History<Matrix<3, 3>>, law: Table, moved: Carried<Vector>, k: Param }
        #[cells] struct Omega;
        extern \"Rust\" { #[at(crate::laws::flow)] fn flow(s: Matrix<3, 3>, k: Scalar) -> Scalar; }
        fn solid(A: Tensor) -> Matrix<3, 3> { [[A[0][0], A[0][1], 0], [A[1][0], A[1][1], 0], [0; 3]] }
        fn stress(w: Vector) -> Tensor { ddot(C, eps(w)) + law(tr(eps(w))) * I }
        fn work(u: Unknown<Vector>, v: Test<Vector>) -> Form {
            integral(Omega, inner(solid(stress(u)), solid(eps(v))) + flow(solid(eps(u)) - old, k) * dot(moved, v)
                + if u[D - 1] > 0 { [0, 0] } else { v }[0] * inner(old, old))
        }
        fn exponential(u: State<Vector>) -> Tensor { tensor_exp(grad(u)) * tensor_sqrt(I + eps(u)) }
    }",
    "mod forms {
        //! Documentation.
        #[derive(PartialEq)] pub struct Data { #[doc = \"k\"] pub k: Param, r#type: Given<Scalar> }
        #[cells] #[allow(dead_code)] pub struct Some;
        #[facets] pub struct Ok;
        /// Twice.
        #[must_use] pub fn Box(u: State<Scalar>) -> Scalar { #![allow(unused)] { #[allow(unused)] let a = u; a + r#type } }
        pub fn None(u: Unknown<Scalar>) -> Energy { integral(Some, sqr(Box(u)) / 2) + k * integral(Ok, u) }
        pub fn adjoint(u: State<Scalar>, p: Unknown<Scalar>, q: Test<Scalar>) -> Form {
            derivative(derivative(None(u), u, p), u, q) + derivative(None(u), u, q)
        }
        pub fn moved(u: State<Scalar>, T: State<Vector>) -> Functional { derivative(None(u), shape, T) }
    }",
    // What doubles with each call, and again with each derivative.
    "mod towers {
        #[cells] struct Omega;
        fn f0(a: Scalar) -> Scalar { a * exp(a) + 1 / (1 + a * a) }
        fn f1(a: Scalar) -> Scalar { f0(f0(a)) + f0(a) }
        fn form(u: Unknown<Scalar>, v: Test<Scalar>) -> Form { integral(Omega, f1(u) * v + dot(grad(f0(u)), grad(v))) }
        fn product(u: Unknown<Vector>) -> Energy {
            let F = I + grad(u);
            let G = F * transpose(F);
            integral(Omega, det(G) + inner(G, F))
        }
    }",
    "mod defaults {
        struct Data { #[default(0)] f: Given<Vector>, #[default(-1.5)] k: Param, #[default(0)] B: Carried<Matrix<3, D>>, g: Param }
        #[cells] struct Omega;
        fn work(u: Unknown<Vector>) -> Energy { integral(Omega, k * g * dot(f, u) + inner(B, B)) }
    }",
    "mod mixed {
        #[cells] struct Omega;
        fn stokes(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
            integral(Omega, inner(eps(u), eps(v)) - p * div(v)) - integral(Omega, q * div(u))
        }
        fn vorticity(u: Vector) -> Tensor { [[0, grad(u)[0][1]], [{ let a = 1.5; a * u[1] }, max(u[0], 0)]] }
    }",
];

/// The processor time after which a module counts as one that does not end. The corpus takes less than a second on any machine;
/// slow modules are found by counted work (`proof/effort.rs`).
const LONGEST: Duration = Duration::from_secs(60);

fn check(tokens: TokenStream) {
    let text = tokens.to_string();
    check_text(tokens, &text);
}

/// Printing tokens recurses: those that nest very deep come with their text.
fn check_text(tokens: TokenStream, text: &str) {
    if let Err(fault) = fault("dimension = 2", tokens, text) {
        panic!("{fault}");
    }
}

/// Compiles a module; `Err` if it panics, gives no Rust, too much of it, or takes too long.
fn fault(options: &str, tokens: TokenStream, text: &str) -> Result<(), String> {
    let (start, before) = (Instant::now(), processor_time());
    let result = catch_unwind(AssertUnwindSafe(|| survives(options, tokens)));
    if result.is_err() {
        return Err(format!("the compiler panicked on\n{text}"));
    }
    // No processor time is longer than the clock's.
    if start.elapsed() < Duration::from_secs(1) {
        return Ok(());
    }
    let spent = match (before, processor_time()) {
        (Some(before), Some(after)) => after - before,
        _ => start.elapsed(),
    };
    if spent > Duration::from_secs(1) {
        eprintln!("{spent:?} for {} characters: {text:.120}", text.len());
    }
    if spent > LONGEST { Err(format!("{spent:?} for\n{text}")) } else { Ok(()) }
}

/// Processor time that this thread has spent; `None` where the system does not tell.
fn processor_time() -> Option<Duration> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split(' ').next()?.parse().ok().map(Duration::from_nanos)
}

/// `FORMS_MUTATIONS` gives another number.
fn count(usual: usize) -> usize {
    std::env::var("FORMS_MUTATIONS").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// The first of the modules that are made; `FORMS_FIRST_MUTATION` gives another one.
fn first() -> usize {
    std::env::var("FORMS_FIRST_MUTATION").ok().and_then(|text| text.parse().ok()).unwrap_or(0)
}

#[test]
fn the_corpus_compiles() {
    for source in CORPUS {
        let output = forms_compiler::forms(quote::quote! { dimension = 2 }, source.parse().expect("tokens"));
        assert!(!output.to_string().contains("compile_error"), "{output}");
    }
}

/// All faults are reported, each with the seed of its module; one that hangs is named before the process ends.
#[test]
fn mutated_modules() {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let seeds = first()..first() + count(18_000);
    let mut faults: Vec<usize> = std::thread::scope(|scope| {
        let parts: Vec<_> = (0..threads)
            .map(|part| {
                let seeds = seeds.clone().skip(part).step_by(threads);
                std::thread::Builder::new()
                    .stack_size(STACK)
                    .spawn_scoped(scope, || faults_of(seeds))
                    .expect("a thread")
            })
            .collect();
        parts.into_iter().flat_map(|part| part.join().expect("no part panics")).collect()
    });
    faults.sort_unstable();
    assert!(faults.is_empty(), "{} modules: {faults:?}", faults.len());
}

/// The seeds whose modules have a fault.
fn faults_of(seeds: impl Iterator<Item = usize>) -> Vec<usize> {
    let corpus: Vec<TokenStream> = CORPUS.iter().map(|source| source.parse().expect("tokens")).collect();
    let current: Arc<Mutex<(usize, Instant)>> = Arc::new(Mutex::new((0, Instant::now())));
    let watched = Arc::downgrade(&current);
    std::thread::spawn(move || {
        while let Some(current) = watched.upgrade() {
            let (seed, start) = *current.lock().expect("no one panics with it");
            if start.elapsed() > 5 * LONGEST {
                eprintln!("the module of seed {seed} does not end");
                std::process::abort();
            }
            drop(current);
            std::thread::sleep(Duration::from_millis(200));
        }
    });
    let mut faults = Vec::new();
    for seed in seeds {
        let mut random = Random(seed as u64);
        let mut tokens = corpus[random.below(corpus.len())].clone();
        for _ in 0..1 + random.below(3) {
            tokens = mutate(tokens, &mut random);
        }
        let options = if random.below(8) == 0 { "dimension = 3" } else { "dimension = 2" };
        *current.lock().expect("no one panics with it") = (seed, Instant::now());
        let text = tokens.to_string();
        if let Err(fault) = fault(options, tokens, &text) {
            eprintln!("seed {seed}: {fault}");
            faults.push(seed);
        }
    }
    faults
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

/// A module whose data include those of a text that arrives, both of them changed.
#[test]
fn mutated_inclusions() {
    let included = "#[identity(\"a\", \"1\")] mod a { pub struct Data { #[included] k: Param, law: Table, f: Given<Vector> }
        #[facets] struct Wall; #[origin(\"`g` in a\")] pub fn g(s: Scalar) -> Scalar { k * s } }";
    let module =
        "mod b { #[includes(super::a::Data)] pub struct Data { #[default(0)] m: Param, g: Given<Vector> }
        #[cells] struct Omega;
        fn work(u: Unknown<Vector>) -> Energy { integral(Omega, k * m * law(dot(f, u)) * dot(u, g)) } }";
    let resume = |included: TokenStream, module: TokenStream| {
        let text = included.to_string();
        let state = quote::quote! { #text (dimension = 2) module { #module } [] };
        let mut file = quote::quote! { struct Before; };
        file.extend(forms_compiler::resume_forms(state));
        file
    };
    let [included, module] = [included, module].map(|text| text.parse::<TokenStream>().expect("tokens"));
    let output = resume(included.clone(), module.clone()).to_string();
    assert!(output.contains("fn data_from") && !output.contains("compile_error"), "{output}");
    for seed in 0..count(3_000) {
        let mut random = Random(seed as u64);
        let changed = random.below(2) == 0;
        let included = if changed { mutate(included.clone(), &mut random) } else { included.clone() };
        let module = mutate(mutate(module.clone(), &mut random), &mut random);
        let text = format!("seed {seed}: {included}\n{module}");
        let output = catch_unwind(AssertUnwindSafe(|| resume(included, module)));
        let output = output.unwrap_or_else(|_| panic!("the compiler panicked on {text}"));
        assert!(syn::parse2::<syn::File>(output).is_ok(), "the output is not Rust, {text}");
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
        // The longest sums that are compiled, of calls.
        let sums = format!("{}v", "f(u, 2) * v + ".repeat(depth.min(480)));
        check_text(density(&sums), &sums);
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
