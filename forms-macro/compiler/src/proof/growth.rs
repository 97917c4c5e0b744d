//! The growth of emitted code: as the form grows, not with a power of its depth. Characters, tokens and the work of planning
//! are counted; no limit is in seconds, which depend on the machine.

use proc_macro2::{Delimiter, TokenStream, TokenTree};

use super::source::Source;

/// A form of scalars over one region, as a module.
fn scalar_form(lets: &str, density: &str) -> String {
    format!(
        "mod m {{ #[cells] struct Omega;
        fn f(u: Unknown<Scalar>, q: State<Scalar>, v: Test<Scalar>) -> Form {{ {lets} integral(Omega, ({density}) * v) }} }}"
    )
}

/// Each `let` uses the one before it twice.
fn lets(depth: usize) -> String {
    let list = (1..depth).map(|k| format!("let a{k} = a{0} * (a{0} + 1); ", k - 1));
    scalar_form(&format!("let a0 = u * (u + 1); {}", list.collect::<String>()), &format!("a{}", depth - 1))
}

/// Each `let` asks the one before it three times.
fn conditions(depth: usize) -> String {
    let one = |k: usize| format!("let a{k} = if a{0} > 0 {{ a{0} * 2 }} else {{ a{0} + 1 }}; ", k - 1);
    let list: String = (1..depth).map(one).collect();
    scalar_form(&format!("let a0 = u * (u + 1); {list}"), &format!("a{}", depth - 1))
}

/// Private functions, each calling the next.
fn chain(depth: usize) -> String {
    let one = |k: usize| format!("fn g{k}(w: Scalar) -> Scalar {{ g{}(w) * a + w }} ", k + 1);
    let list: String = (0..depth).map(one).collect();
    format!(
        "mod m {{ #[cells] struct Omega; struct Data {{ a: Param }} {list} fn g{depth}(w: Scalar) -> Scalar {{ w }}
        fn f(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {{ integral(Omega, g0(u) * v) }} }}"
    )
}

/// Derivatives of derivatives, whose terms are as many as the square of the order.
fn derivatives(depth: usize) -> String {
    let expression = (0..depth)
        .fold("u * u / (1 + exp(u) * u)".to_string(), |inner, _| format!("derivative({inner}, u, q)"));
    scalar_form("", &expression)
}

/// Products of `let`s and of their derivatives.
fn derivatives_of_lets(depth: usize) -> String {
    let one = |k: usize| format!("let a{k} = derivative(a{0}, u, q) * a{0}; ", k - 1);
    let list: String = (1..=depth).map(one).collect();
    scalar_form(&format!("let a0 = sin(u) * exp(u); {list}"), &format!("a{depth}"))
}

fn solid(density: &str) -> String {
    format!(
        "mod m {{ #[cells] struct Omega; struct Data {{ mu: Param, lambda: Param, a: Param, b: Param }}
        fn f(u: Unknown<Vector>) -> Energy {{ let F = I + grad(u); let C = transpose(F) * F; integral(Omega, {density}) }} }}"
    )
}

fn hencky() -> String {
    solid("{ let E = tensor_ln(C) / 2; mu * inner(E, E) + lambda / 2 * pow(tr(E), 2) }")
}

fn ogden() -> String {
    solid(
        "mu / a * tr(tensor_exp(a / 2 * tensor_ln(C))) + mu / b * tr(tensor_exp(b / 2 * tensor_ln(C))) + lambda * pow(ln(det(F)), 2)",
    )
}

fn tokens(stream: TokenStream) -> usize {
    let one = |token| match token {
        TokenTree::Group(group) => 1 + tokens(group.stream()),
        _ => 1,
    };
    stream.into_iter().map(one).sum()
}

/// The largest number of statements in a function and in a block; long functions have several.
fn longest(stream: TokenStream) -> [usize; 2] {
    let mut is_function = false;
    let mut longest = [0; 2];
    for token in stream {
        match token {
            TokenTree::Ident(ident) if ident == "fn" => is_function = true,
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
                let inner =
                    if is_function { statements(group.stream()) } else { self::longest(group.stream()) };
                longest = [longest[0].max(inner[0]), longest[1].max(inner[1])];
                is_function = false;
            }
            _ => {}
        }
    }
    longest
}

/// The statements of a function's body, and those of its longest block.
fn statements(body: TokenStream) -> [usize; 2] {
    let (mut own, mut all, mut longest) = (0, 0, 0);
    for token in body {
        match token {
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
                let [inner, block] = statements(group.stream());
                (all, longest) = (all + inner, longest.max(block));
            }
            TokenTree::Punct(punct) if punct.as_char() == ';' => own += 1,
            _ => {}
        }
    }
    [all + own, longest.max(own)]
}

/// Characters and tokens of what is emitted for a form.
pub fn emitted(what: &str, dimension: usize, text: &str) -> [usize; 2] {
    let emitted = Source::new(dimension, text).emitted();
    let characters = emitted.to_string();
    assert!(!characters.contains("compile_error"), "{what}: {}", &characters[..300]);
    [characters.len(), tokens(emitted)]
}

/// Tokens of a module without functions: regions, data, the model of both.
fn module() -> usize {
    emitted("a module", 2, "mod m { #[cells] struct Omega; struct Data { a: Param } }")[1]
}

/// A form has at most this number of tokens for a depth, besides its module, and at most 300 000 characters of formulas more.
fn grows_slowly(name: &str, form: fn(usize) -> String, depths: &[usize], most: fn(usize) -> usize) {
    let module = module();
    for &depth in depths {
        let what = format!("{name} of depth {depth}");
        let text = form(depth);
        let [characters, tokens] = emitted(&what, 2, &text);
        assert!(tokens <= module + most(depth), "{what}: {tokens} tokens");
        // The module's text travels with it, for imports.
        let most = 8 * tokens + 300_000 + 4 * text.len();
        assert!(characters <= most, "{what}: {characters} characters");
    }
}

#[test]
fn lets_that_use_each_other() {
    grows_slowly("lets", lets, &[14, 18, 40], |depth| 4000 + 120 * depth);
    grows_slowly("conditions", conditions, &[14, 40], |depth| 4000 + 320 * depth);
}

#[test]
fn functions_that_call_each_other() {
    grows_slowly("a chain", chain, &[50, 200, 500], |depth| 4000 + 100 * depth);
}

#[test]
fn derivatives_inside_derivatives() {
    grows_slowly("derivatives", derivatives, &[4, 6, 9], |depth| 4000 + 80 * depth * depth);
    grows_slowly("derivatives of lets", derivatives_of_lets, &[3, 6, 9], |depth| 4000 + 30 * depth.pow(3));
}

/// 3D, where the second derivatives of a function of a tensor have 729 entries, where 126 are computed.
#[test]
fn functions_of_tensors() {
    for (name, text, most) in [("Hencky", hencky(), 110_000), ("Ogden", ogden(), 150_000)] {
        let [characters, tokens] = emitted(name, 3, &text);
        assert!(tokens <= most, "{name}: {tokens} tokens");
        assert!(characters <= 8 * tokens + 300_000, "{name}: {characters} characters");
        let work = Source::new(3, &text).work();
        assert!((1_000_000..25_000_000).contains(&work), "{name}: {work} nodes were looked at");
    }
}

/// Ogden's tangent has 4,551 operations at a point: each function has some 1,000 of them, for machine code is made in more than
/// linear time, in blocks that rustc's stack holds.
#[test]
fn long_functions_come_in_parts() {
    let [function, block] = longest(Source::new(3, &ogden()).emitted());
    assert!((900..1_900).contains(&function), "{function} statements");
    assert!((400..510).contains(&block), "{block} statements");
}

/// A form too deep for a compiler's stack is refused by name.
#[test]
fn too_deep() {
    let steps: String = (1..3000).map(|k| format!("let a{k} = sin(a{}) + 1; ", k - 1)).collect();
    for text in [chain(1000), scalar_form(&format!("let a0 = u; {steps}"), "a2999")] {
        let compile = move || Source::new(2, &text).emitted().to_string();
        // As much as rustc's threads have.
        let thread = std::thread::Builder::new().stack_size(8 << 20).spawn(compile).expect("a thread");
        let emitted = thread.join().expect("no overflow");
        assert!(emitted.contains("stand one inside the other"), "{}", &emitted[..300]);
    }
}
