//! Snapshots of what the attribute emits for the forms that matter, printed as Rust: a change of the emitted
//! code shows in a review. `INSTA_UPDATE=always cargo test -p forms-compiler emitted_code` writes them again.

use std::collections::BTreeMap;

use quote::{ToTokens, quote};

use crate::reuse::flatten;

/// The kernels of a function in two dimensions, each by its name.
fn kernels(source: &str, function: &str) -> BTreeMap<String, String> {
    let output = crate::forms(quote! { dimension = 2, matrix_free }, source.parse().expect("tokens"));
    let file: syn::File = syn::parse2(output).expect("emitted code is Rust");
    let inside = |items: &[syn::Item], name: &str| {
        let found = items.iter().find_map(|item| match item {
            syn::Item::Mod(module) if module.ident == name => module.content.clone(),
            _ => None,
        });
        found.unwrap_or_else(|| panic!("no module `{name}` was emitted")).1
    };
    let module = match &file.items[0] {
        syn::Item::Mod(module) => module.ident.to_string(),
        _ => panic!("the attribute gives a module"),
    };
    let items = inside(&inside(&inside(&file.items, &module), function), "kernels_2");
    let mut kernels: BTreeMap<String, Vec<syn::Item>> = BTreeMap::new();
    for item in items {
        let name = match &item {
            syn::Item::Struct(structure) => structure.ident.to_string(),
            syn::Item::Impl(implementation) => implementation.self_ty.to_token_stream().to_string(),
            _ => continue,
        };
        kernels.entry(name).or_default().push(item);
    }
    let print =
        |items| prettyplease::unparse(&syn::File { shebang: None, frontmatter: None, attrs: vec![], items });
    kernels.into_iter().map(|(name, items)| (name, print(items))).collect()
}

fn check(source: &str, function: &str) {
    for (kernel, text) in kernels(source, function) {
        insta::assert_snapshot!(format!("{function}_{kernel}"), text);
    }
}

const CLASSICS: &str = "mod classics {
    struct Data { k: Param, mu: Param, lambda: Param, gamma: Param, f: Given<Scalar> }
    #[cells] struct Omega;
    #[interior_facets] struct Skeleton;
    fn stress(w: Vector) -> Tensor { 2 * mu * eps(w) + lambda * div(w) * I }
    fn poisson(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, k * dot(grad(u), grad(v)) - f * v)
    }
    fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
    }
    fn neo_hookean(u: Unknown<Vector>) -> Energy {
        let F = I + grad(u);
        let J = det(F);
        integral(Omega, mu / 2 * (inner(F, F) - D - 2 * ln(J)) + lambda / 2 * pow(ln(J), 2))
    }
    fn stokes(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * mu * inner(eps(u), eps(v)) - p * div(v) - q * div(u))
    }
    fn consistency(u: Scalar, v: Scalar) -> Scalar { dot(avg(grad(u)), n) * jump(v) }
    fn interior_penalty(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Skeleton, gamma / avg(h) * jump(u) * jump(v) - consistency(u, v) - consistency(v, u))
    }
}";

#[test]
fn classics() {
    for function in ["poisson", "elasticity", "neo_hookean", "stokes", "interior_penalty"] {
        check(CLASSICS, function);
    }
}

#[test]
fn nitsche() {
    let module = flatten::nitsche();
    for function in ["direct", "discrete_adjoint", "consistent_adjoint"] {
        check(&module, function);
    }
}
