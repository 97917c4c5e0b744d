//! Formulas of forms that matter, line by line.

mod computed;

use super::equations::variations;
use super::formula::{Formula, Infix};
use super::latex::Latex;
use super::notation::Notation;
use super::outlines::Outlines;
use super::unicode::Unicode;
use super::{Shown, formulas};
use crate::check::{CheckedFunction, Content, Term, check, is_building_block};
use crate::diagnostics::Diagnostics;
use crate::differentiate::differentiate;
use crate::optimise::scalar::Graph;
use crate::optimise::scalarise::{OppositeSide, Scalariser};
use crate::optimise::{equal_scalars, parameter_offsets};
use crate::parse::parse;
use crate::parse::syntax::Module;
use crate::reuse::flatten::nitsche;
use crate::tensor::{Arena, FieldRole, Side, Tensor};

fn module(source: &str) -> Module {
    let item = syn::parse_str(source).unwrap_or_else(|error| panic!("{error}"));
    parse(item, &mut Diagnostics::default())
}

fn shown(source: &str, name: &str) -> Shown {
    let module = module(source);
    let index = module.functions.iter().position(|function| function.name == name);
    let index = index.unwrap_or_else(|| panic!("no function {name}"));
    let found = formulas(&module, 2).swap_remove(index);
    found.unwrap_or_else(|| panic!("{name} has no formula"))
}

const MATERIALS: &str = r#"mod materials {
    struct Data { mu: Param, lambda: Param, p: Param, q: Param, f: Given<Scalar>, b: Given<Vector>, k: Param<Tensor> }
    #[cells] struct Omega;
    #[facets] struct GammaN;

    fn psi(F: Tensor) -> Scalar {
        let J = det(F);
        mu / 2 * (inner(F, F) - D - 2 * ln(J)) + lambda / 2 * pow(ln(J), 2)
    }
    fn deformation(u: Vector) -> Tensor { I + grad(u) }
    fn cauchy_green(u: Vector) -> Tensor { transpose(deformation(u)) * deformation(u) }
    fn quadratic(C: Tensor) -> Scalar { mu / 4 * inner(C - I, C - I) + lambda / 8 * pow(tr(C - I), 2) }
    fn flux(w: Scalar) -> Vector { pow(q + dot(grad(w), grad(w)), (p - 2) / 2) * grad(w) }
    fn mixed(a: Vector, s: Scalar) -> Vector { s * a + dot(b, a) * a }

    fn neo_hookean(u: Unknown<Vector>) -> Energy {
        integral(Omega, psi(deformation(u)) - dot(b, u)) - integral(GammaN, f * dot(u, n))
    }
    fn first_piola(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let F = deformation(u);
        integral(Omega, inner(diff(psi(F), F), grad(v)) - dot(b, v))
    }
    fn saint_venant(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let F = deformation(u);
        let C = transpose(F) * F;
        integral(Omega, inner(F * (2 * diff(quadratic(C), C)), grad(v)))
    }
    fn p_laplace(t: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(flux(t), grad(v)) - f * v)
    }
    fn coupled(u: Unknown<Vector>, s: Unknown<Scalar>, v: Test<Vector>, r: Test<Scalar>) -> Form {
        integral(Omega, dot(mixed(u, s), v) + inner(grad(mixed(u, s)), grad(v)) + s * s * r)
            + integral(GammaN, max(s, u[0]) * r + min(exp(s), 1) * r * tanh(s))
    }
    fn coupled_energy(u: Unknown<Vector>, s: Unknown<Scalar>) -> Energy {
        integral(Omega, pow(1 - s, 2) * quadratic(cauchy_green(u)) + f * (s * s + dot(grad(s), k * grad(s))))
    }
    fn sensitivity(u: State<Vector>, w: State<Vector>) -> Functional {
        derivative(integral(Omega, psi(deformation(u))), mu, lambda)
            + derivative(derivative(integral(Omega, psi(deformation(u))), u, w), u, w)
    }
    fn kinks(t: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let s = t - f;
        let limited = if s > 1 && s * s < q { sqrt(q) * s } else { abs(s) / 2 };
        integral(Omega, (pos_part(s) - (neg_part(2 * s) - sign(s) * s) + limited) * v / (q * mu))
            - integral(GammaN, -(s + 1) * (-2) * v)
    }
}"#;

const INTERIOR_PENALTY: &str = r#"mod interior_penalty {
    struct Data { gamma: Param, f: Given<Scalar> }
    #[cells] struct Omega;
    #[interior_facets] struct Skeleton;

    fn flux(u: Scalar) -> Vector { (1 + u * u) * grad(u) }
    fn consistency(u: Scalar, v: Scalar) -> Scalar { dot(avg(grad(u)), this(n)) * jump(v) }

    fn poisson(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(grad(u), grad(v)) - f * v)
            + integral(Skeleton, gamma / avg(h) * jump(u) * jump(v) - consistency(u, v) - consistency(v, u))
    }
    fn nonlinear(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, dot(flux(u), grad(v)))
            + integral(Skeleton, inner(avg(flux(u)), jump(v, n)) + other(u) * tr(this(hess(v))) + inner(jump(hess(u)), avg(hess(v))))
    }
}"#;

/// The first lines of a form's text, and those that define a name of it.
fn assert_shown(source: &str, name: &str, lines: &[&str]) {
    let text = shown(source, name).unicode();
    for line in lines {
        assert!(text.lines().any(|one| one.trim() == *line), "{line}\nis not a line of\n{text}");
    }
}

#[test]
fn the_direct_problem_reads_as_in_the_paper() {
    assert_eq!(
        shown(&nitsche(), "direct").unicode(),
        "\
direct(u, v) = ∫_Ω σ(u):ε(v) dx − ∫_Ω f·v dx − ∫_Γ_N g_N·v ds − ∫_Γ_C (θ/γ) σ_n(u) σ_n(v) ds − ∫_Γ_C ([P(u)]₋/γ) P_θ(σ_n(v), v) ds
D direct(u, v)[δu] = ∫_Ω σ(δu):ε(v) dx − ∫_Γ_C (θ/γ) σ_n(δu) σ_n(v) ds + ∫_Γ_C (H(−P(u)) DP(u)[δu]/γ) P_θ(σ_n(v), v) ds
where
  σ(w) = 2 μ ε(w) + λ tr(ε(w)) I
  γ = γ₀/h
  σ_n(w) = σ(w) n·n_y
  P(w) = σ_n(w) − γ penetration(w)
  penetration(w) = w_n − g
  w_n = w·n_y
  P_θ(σ_n, w) = θ σ_n − γ w_n
  DP(w)[δw] = σ_n(δw) − γ δw_n"
    );
}

#[test]
fn derivatives_inside_a_form_are_carried_out() {
    let lines = [
        "discrete_adjoint(u, p, q) = ∫_Ω σ(q):ε(p) dx − ∫_Γ_C (θ/γ) σ_n(q) σ_n(p) ds + ∫_Γ_C (H(−P(u)) DP(u)[q]/γ) P_θ(σ_n(p), p) ds + ∫_Ω M(q) dx + ∫_∂Ω DN(u)[q] ds",
        "DN(w)[δw] = c δw·w",
        "N(w) = (c/2) w·w",
    ];
    assert_shown(&nitsche(), "discrete_adjoint", &lines);
}

#[test]
fn lets_and_conditions_stay_as_written() {
    let lines = [
        "σ_vM(w) = √(1.5 (in_plane:in_plane + rest))",
        "out_of_plane = { λ tr(ε(w)) if D < 3; 0 otherwise",
        "mean = (tr(σ(w)) + out_of_plane)/3",
    ];
    assert_shown(&nitsche(), "von_mises", &lines);
}

#[test]
fn an_energy_shows_its_variations() {
    let lines = [
        "neo_hookean(u) = ∫_Ω (ψ(deformation(u)) − b·u) dx − ∫_Γ_N f u·n ds",
        "D neo_hookean(u)[δu] = ∫_Ω (Dψ(deformation(u))[∇δu] − b·δu) dx − ∫_Γ_N f δu·n ds",
        "D² neo_hookean(u)[δu, Δu] = ∫_Ω D²ψ(deformation(u))[∇δu, ∇Δu] dx",
        "ψ(F) = (μ/2) (F:F − D − 2 ln(J)) + (λ/2) ln(J)²",
        "Dψ(F)[δF] = (μ/2) (2 δF:F − 2 ((cof(F):δF)/J)) + λ ln(J) ((cof(F):δF)/J)",
    ];
    assert_shown(MATERIALS, "neo_hookean", &lines);
    let lines = [
        "first_piola(u, v) = ∫_Ω ((∂ψ(F)/∂F):∇v − b·v) dx",
        "D first_piola(u, v)[δu] = ∫_Ω D²ψ(F)[∇v, ∇δu] dx",
    ];
    assert_shown(MATERIALS, "first_piola", &lines);
    let lines = [
        "D coupled_energy(u, s)[(δu, δs)] = ∫_Ω (1 − s)² D quadratic(cauchy_green(u))[D cauchy_green(u)[δu]] dx + ∫_Ω (−2 (1 − s) δs quadratic(cauchy_green(u)) + f (2 δs s + ∇δs·k ∇s + ∇s·k ∇δs)) dx",
        "D cauchy_green(u)[δu] = (∇δu)ᵀ deformation(u) + deformation(u)ᵀ ∇δu",
    ];
    assert_shown(MATERIALS, "coupled_energy", &lines);
}

#[test]
fn a_p_laplacian_shows_its_tangent() {
    let lines = [
        "p_laplace(t, v) = ∫_Ω (flux(t)·∇v − f v) dx",
        "D p_laplace(t, v)[δt] = ∫_Ω D flux(t)[δt]·∇v dx",
        "flux(w) = (q + ∇w·∇w)^((p − 2)/2) ∇w",
        "D flux(w)[δw] = 2 (((p − 2)/2) (q + ∇w·∇w)^((p − 2)/2 − 1) ∇δw·∇w) ∇w + (q + ∇w·∇w)^((p − 2)/2) ∇δw",
    ];
    assert_shown(MATERIALS, "p_laplace", &lines);
}

#[test]
fn both_sides_of_a_facet_are_shown() {
    let lines = [
        "D poisson(u, v)[δu] = ∫_Ω ∇δu·∇v dx + ∫_Skeleton ((γ/{h}) ⟦δu⟧ ⟦v⟧ − consistency(δu, v) − consistency(v, δu)) dS",
        "consistency(u, v) = ({∇u}·n⁺) ⟦v⟧",
    ];
    assert_shown(INTERIOR_PENALTY, "poisson", &lines);
}

#[test]
fn means_over_cells_are_shown() {
    let source = r#"mod averaged {
        struct Data { k: Param }
        #[cells] struct Omega;
        fn damped(s: Unknown<Scalar>, r: Test<Scalar>) -> Form { integral(Omega, pow(mean(k * s), 3) * mean(r)) }
    }"#;
    let lines = ["damped(s, r) = ∫_Ω ⟨k s⟩³ ⟨r⟩ dx", "D damped(s, r)[δs] = ∫_Ω 3 ⟨k s⟩² k ⟨δs⟩ ⟨r⟩ dx"];
    assert_shown(source, "damped", &lines);
    assert!(
        shown(source, "damped").latex().contains("\\langle r\\rangle"),
        "{}",
        shown(source, "damped").latex()
    );
}

/// Parentheses are where they must be, and only there; signs are those of the source.
#[test]
fn precedence_and_signs() {
    let cases = [
        ("a - (b - c)", "a − (b − c)", "a-(b - c)"),
        ("a - b - c", "a − b − c", ""),
        ("a + (b - c)", "a + b − c", ""),
        ("a - -b", "a − (−b)", "a - (-b)"),
        ("-(a + b)", "−(a + b)", "-(a + b)"),
        ("-a + b", "−a + b", "-a + b"),
        ("-pow(a + b, 2)", "−(a + b)²", "-{(a + b)}^{2}"),
        ("pow(-a, 2)", "(−a)²", "{(-a)}^{2}"),
        ("pow(pow(a, b), c)", "(a^b)^c", ""),
        ("pow(a, b + c)", "a^(b + c)", "{a}^{b + c}"),
        ("a / (b * c)", "a/(b c)", "\\frac{a}{b\\, c}"),
        ("a / b * c", "(a/b) c", "\\frac{a}{b}\\, c"),
        ("a / (b / c)", "a/(b/c)", "\\frac{a}{\\frac{b}{c}}"),
        ("a / b / c", "(a/b)/c", ""),
        ("(a + b) / (c - a)", "(a + b)/(c − a)", "\\frac{a + b}{c - a}"),
        ("-a / b", "(−a)/b", "\\frac{-a}{b}"),
        ("-(a / b)", "−a/b", "-\\frac{a}{b}"),
        ("a * (b + c)", "a (b + c)", "a\\, (b + c)"),
        ("a * -b", "a (−b)", "a\\, (-b)"),
        ("a * 2 * 3", "2 × 3 a", ""),
        ("2 * (-3)", "2 (−3)", ""),
        ("dot(v, w) * a", "(v·w) a", "(v \\cdot w)\\, a"),
        ("a * dot(v, w)", "a v·w", ""),
        ("dot(v + w, v)", "(v + w)·v", ""),
        ("dot(v, w) * dot(v, v)", "(v·w) v·v", ""),
        ("a - dot(v, w)", "a − v·w", ""),
        ("dot(A * B * v, w)", "A B v·w", ""),
        ("dot(dot(v, w) * v, w)", "(v·w) v·w", ""),
        ("inner(outer(v, w), A)", "(v⊗w):A", "(v \\otimes w):A"),
        ("tr(transpose(A) * B)", "tr(Aᵀ B)", ""),
        ("tr(transpose(A * B))", "tr((A B)ᵀ)", ""),
        ("tr(transpose(inv(A)))", "tr(A⁻ᵀ)", ""),
        ("tr(inv(A + B) * A)", "tr((A + B)⁻¹ A)", ""),
        ("abs(a - b) * sqrt(a + b)", "|a − b| √(a + b)", "|a - b|\\, \\sqrt{a + b}"),
        ("neg_part(-a) - pos_part(a)", "[−a]₋ − [a]₊", "{[-a]}_{-} - {[a]}_{+}"),
        ("tr(grad(v)) + tr(grad(v) * A)", "div(v) + tr(∇v A)", ""),
        ("inner(transpose(grad(v)), A)", "(∇v)ᵀ:A", "{(\\nabla v)}^{\\mathsf{T}}:A"),
        ("v[0] * A[(0, 1)] - grad(v)[1][0]", "v_x A_xy − (∇v)_yx", ""),
        ("min(a, b - 1) / max(a, 0)", "min(a, b − 1)/max(a, 0)", ""),
        (
            "a * if a > b || !(a == c && b <= c) { b } else if a < 0 { 1 } else { c + 1 }",
            "a ({ b if a > b ∨ ¬(a = c ∧ b ≤ c); 1 if a < 0; c + 1 otherwise)",
            "",
        ),
        ("dot([a, -b], [c, 0])", "[a; −b]·[c; 0]", ""),
        ("1.5 * gamma0 * sigma_n * 0.000001", "1.5 × 1×10⁻⁶ γ₀ σ_n", ""),
        ("dot(v, n) * h / PI", "(v·n) h/π", ""),
    ];
    for (source, unicode, latex) in cases {
        let module = format!(
            "mod precedence {{ struct Data {{ a: Given<Scalar>, b: Given<Scalar>, c: Given<Scalar>, gamma0: Param, sigma_n: Param }}
            pub fn value(v: Vector, w: Vector, A: Tensor, B: Tensor) -> Scalar {{ {source} }} }}"
        );
        let right = shown(&module, "value").content.right;
        assert_eq!(Unicode.print(&right), unicode, "{source}");
        if !latex.is_empty() {
            assert_eq!(Latex.print(&right).replace(' ', ""), latex.replace(' ', ""), "{source}");
        }
    }
}

#[test]
fn names_are_signs() {
    let signs = [
        ("gamma0", "γ₀", "\\gamma _{0}"),
        ("sigma_n", "σ_n", "\\sigma _{n}"),
        ("GammaC", "Γ_C", "\\Gamma _{C}"),
        ("Gamma_C", "Γ_C", "\\Gamma _{C}"),
        ("Omega", "Ω", "\\Omega "),
        ("u_hat", "u\u{302}", "\\hat{u}"),
        ("u_h_1", "u_h,1", "u_{h,1}"),
        ("δu_n", "δu_n", "\\delta u_{n}"),
        ("∂Ω", "∂Ω", "\\partial \\Omega "),
        ("body_force", "body_force", "\\text{body\\_force}"),
        ("N_prime", "N′", "N^{\\prime}"),
        ("x12", "x₁₂", "x_{12}"),
        ("σ_vM", "σ_vM", "\\sigma _{\\text{vM}}"),
        ("alphabet", "alphabet", "\\text{alphabet}"),
    ];
    for (name, unicode, latex) in signs {
        let symbol = Formula::name(name);
        assert_eq!(
            (Unicode.print(&symbol).as_str(), Latex.print(&symbol).as_str()),
            (unicode, latex),
            "{name}"
        );
    }
}

/// Opening tags and their ends match; returns the names of all elements.
fn elements(markup: &str) -> Vec<String> {
    let (mut open, mut all) = (Vec::new(), Vec::new());
    let mut rest = markup;
    while let Some(start) = rest.find('<') {
        assert!(!rest[..start].contains('>'), "a bare > in {markup}");
        let end = start + rest[start..].find('>').unwrap_or_else(|| panic!("a tag does not end: {markup}"));
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        match tag.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop().as_deref(), Some(name), "{markup}"),
            None => {
                let name = tag.split_whitespace().next().unwrap_or_default().to_string();
                assert!(tag[name.len()..].matches('"').count().is_multiple_of(2), "{tag}");
                all.push(name.clone());
                open.push(name);
            }
        }
    }
    assert!(open.is_empty(), "{open:?} stay open in {markup}");
    for (at, _) in markup.match_indices('&') {
        assert!(["&lt;", "&gt;", "&amp;"].iter().any(|entity| markup[at..].starts_with(entity)), "{markup}");
    }
    all
}

#[test]
fn markup_is_well_formed() {
    let sources = [nitsche(), MATERIALS.to_string()];
    let mut count = 0;
    for source in &sources {
        let module = module(source);
        for (function, shown) in module.functions.iter().zip(formulas(&module, 3)) {
            if is_building_block(function) {
                continue;
            }
            let shown = shown.unwrap_or_else(|| panic!("{} has no formula", function.name));
            let elements = elements(&shown.mathml());
            assert_eq!(elements[0], "math");
            // Scripts and fractions have exactly as many children as they need: none is empty.
            assert!(!shown.mathml().contains("<msub></"), "{}", function.name);
            let latex = shown.latex();
            let count_of = |sign: &str| latex.matches(sign).count();
            let braces = |sign| count_of(sign) - count_of(&format!("\\{sign}"));
            assert_eq!(braces("{"), braces("}"), "{latex}");
            assert_eq!(count_of("\\left"), count_of("\\right"), "{latex}");
            assert_eq!(count_of("\\begin"), count_of("\\end"), "{latex}");
            assert!(latex.is_ascii(), "{latex}");
            // A blank line would end the block of HTML.
            let page = shown.page(&module, function);
            let html = page.split("<div").nth(1).and_then(|rest| rest.split("</div>").next());
            let html = html.unwrap_or_else(|| panic!("no formula on the page of {}", function.name));
            assert!(!html.contains("\n\n"), "{html}");
            count += 1;
        }
    }
    assert!(count > 30);
}

#[test]
fn an_infix_takes_its_operands_apart() {
    let letter = Formula::name;
    let nested =
        Formula::infix(Infix::Dot, letter("a"), Formula::infix(Infix::Outer, letter("b"), letter("c")));
    assert_eq!(Unicode.print(&nested), "a·(b⊗c)");
}
