//! Words of UFL, of GetFEM's weak form language, of FreeFEM and of scikit-fem, and what they are here: for messages on names
//! that are not known.

/// Words with the help line for each; a star matches the rest of a word (`Grad_u`).
const WORDS: &[(&[&str], &str)] = &[
    // Derivatives.
    (
        &["laplace", "laplacian", "lap", "Delta"],
        "the Laplacian is `div(grad(u))`; after integration by parts, `dot(grad(u), grad(v))`",
    ),
    (
        &["dt", "ddt", "d_t", "dudt", "diff_t", "time_derivative", "Dot_*", "Previous_*"],
        "forms know no time: a step of it is `(u - u_old) / tau`, with an argument `u_old: State<..>` and a member `tau: Param`",
    ),
    (&["nabla", "gradient", "Grad_*"], "write `grad(u)`, `grad(u)[i][j]` being ∂u_i/∂x_j"),
    (&["nabla_grad"], "write `transpose(grad(u))`: here the direction comes last"),
    (&["divergence", "Div_*"], "write `div(u)`"),
    (&["nabla_div"], "write `div(u)`, of a tensor `div(transpose(A))`: here its rows are differentiated"),
    (&["rot", "rotor", "vorticity"], "write `curl(u)`"),
    (&["hessian", "Hess_*"], "write `hess(u)`"),
    (
        &["symgrad", "sym_grad", "symmetric_grad", "epsilon", "strain"],
        "write `eps(u)`, the symmetric part of `grad(u)`",
    ),
    (
        &["dx", "dy", "dz"],
        "an integral over cells is `integral(Omega, density)`, and ∂u/∂x_0 is `grad(u)[0]`",
    ),
    (
        &["ds", "dS", "int1d", "int2d", "int3d", "intalledges", "intallfaces"],
        "write `integral(Gamma, density)`; the region is declared, `#[facets] pub struct Gamma;`, `#[interior_facets]` or `#[cells]`",
    ),
    (&["dn", "ddn", "dnu"], "the derivative along the normal is `dot(grad(u), n)`"),
    (&["gateaux", "gateaux_derivative"], "write `derivative(form, u, v)`"),
    (&["variable"], "`diff` differentiates by a `let` name: `let w = ..; diff(f(w), w)`"),
    // Tensors.
    (&["trace"], "write `tr(A)`"),
    (&["determinant"], "write `det(A)`"),
    (&["inverse"], "write `inv(A)`"),
    (&["cofac", "cofactor"], "write `cof(A)`"),
    (&["adj", "adjugate"], "write `transpose(cof(A))`"),
    (&["deviator", "deviatoric"], "write `dev(A)`"),
    (&["T", "trans", "transposed"], "write `transpose(A)`"),
    (&["symmetrize", "symm"], "write `sym(A)`"),
    (&["asym", "antisym", "antisymmetric"], "write `skew(A)`"),
    (&["otimes", "outer_product", "tensor_product", "dyad", "dyadic", "kron"], "write `outer(a, b)`"),
    (
        &["double_dot", "doubledot", "colon", "frobenius"],
        "write `inner(A, B)`, or `ddot(C, A)` with a tensor of rank 4",
    ),
    (&["mul", "matmul", "mult"], "write `A * a` or `A * B`"),
    (&["elem_mult", "elem_div", "hadamard"], "write the components, `[a[0] * b[0], a[1] * b[1]]`"),
    (&["Cross_product", "vector_product"], "write `cross(a, b)`"),
    (&["diag_vector"], "`diag(A)` is the diagonal of a tensor, `diag(a)` the tensor with this diagonal"),
    (&["Expm", "expm", "exp_tensor"], "write `tensor_exp(A)`"),
    (&["Logm", "logm", "ln_tensor"], "write `tensor_ln(A)`"),
    (&["sqrtm", "Sqrtm"], "write `tensor_sqrt(A)`"),
    (&["normalized", "normalise", "normalised", "unit_vector"], "write `normalize(a)`"),
    (&["Id", "id", "eye"], "write `I`, or `identity(3)` for another size than the dimension's"),
    (
        &["as_vector", "as_matrix", "as_tensor", "vector", "matrix", "tensor"],
        "write `[a, b]` or `[[a, b], [c, d]]`",
    ),
    // Functions of scalars.
    (&["log", "loge"], "the natural logarithm is `ln(a)`, the one to the base 10 `log10(a)`"),
    (&["fabs", "absolute"], "write `abs(a)`"),
    (&["sgn", "signum"], "write `sign(a)`"),
    (&["macaulay", "positive_part", "positive", "ramp", "relu"], "write `pos_part(a)`"),
    (&["negative_part", "negative"], "write `neg_part(a)`, which is max(−a, 0)"),
    (&["max_value", "maximum", "fmax"], "write `max(a, b)`"),
    (&["min_value", "minimum", "fmin"], "write `min(a, b)`"),
    (&["power", "powf", "powi"], "write `pow(base, exponent)`"),
    (&["square"], "write `sqr(a)`"),
    (&["cbrt"], "write `pow(a, 1 / 3)`, for a ≥ 0"),
    (
        &["conditional", "cond", "select", "lt", "gt", "le", "ge", "eq", "ne", "And", "Or", "Not"],
        "write `if a < b { .. } else { .. }`, with `&& || !` between comparisons",
    ),
    (
        &["floor", "ceil", "round", "mod", "fmod", "sinc", "bessel_J", "bessel_Y", "bessel_I", "bessel_K"],
        "write it in Rust and declare it, `extern \"Rust\" { fn f(a: Scalar) -> Scalar; }`",
    ),
    // Geometry.
    (&["FacetNormal"], "the outward normal is `n`"),
    (
        &["CellDiameter", "element_size", "hTriangle", "hK", "h_T", "Circumradius", "MaxCellEdgeLength"],
        "the diameter of a cell is `h`",
    ),
    (&["CellVolume"], "write `cell_volume`"),
    (&["FacetArea", "lenEdge"], "write `facet_area`"),
    (&["SpatialCoordinate"], "the position is `x`, a vector"),
    (&["y"], "the second coordinate is `x[1]`"),
    (&["z"], "the third coordinate is `x[2]`"),
    (&["meshdim", "dim", "gdim"], "the dimension is `D`"),
    (
        &["otherside", "neighbor", "neighbour"],
        "the value in the other cell of an interior facet is `other(u)`",
    ),
    (&["cell_avg"], "the mean over a cell is `mean(u)`"),
    (&["average"], "the mean of the two sides of an interior facet is `avg(u)`"),
    // Fields and data.
    (
        &["interpolate", "interp", "project", "projection"],
        "a field is interpolated in the program, `Field::interpolate`, and comes as an argument `w: State<..>` or a member `w: Given<..>`",
    ),
    (&["TestFunction", "TestFunctions", "Test_*"], "declare an argument `v: Test<..>` and write `v`"),
    (
        &["TrialFunction", "TrialFunctions"],
        "the unknown stands here itself: declare an argument `u: Unknown<..>`",
    ),
    (
        &["Coefficient", "Function"],
        "declare an argument `w: State<..>` or a member `w: Given<..>` of the data struct",
    ),
    (&["Constant"], "declare a member `k: Param` of the data struct"),
    (&["lhs", "rhs", "system"], "the residual is one form, loads included: it is split by the compiler"),
    (&["adjoint"], "write `derivative(form, u, v)` with the adjoint state as an argument of the form"),
];

/// The help line for a word of another language.
pub fn help(word: &str) -> Option<&'static str> {
    let meant = |entry: &str| match entry.strip_suffix('*') {
        Some(start) => word.len() > start.len() && word.starts_with(start),
        None => word == entry,
    };
    WORDS.iter().find(|(words, _)| words.iter().any(|entry| meant(entry))).map(|(_, help)| *help)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::builtins::{constant, is_built_in};

    #[test]
    fn no_word_is_one_of_ours() {
        for word in WORDS.iter().flat_map(|(words, _)| *words) {
            assert!(!is_built_in(word), "{word}");
        }
    }

    #[test]
    fn no_word_has_two_meanings() {
        for (index, (words, _)) in WORDS.iter().enumerate() {
            for word in *words {
                let count = WORDS.iter().flat_map(|(words, _)| *words).filter(|other| *other == word).count();
                assert_eq!(count, 1, "{word} in row {index}");
            }
        }
    }

    /// Names of users, of types and of Rust that the help lines hold.
    const OTHERS: &[&str] = &[
        "u",
        "v",
        "w",
        "f",
        "a",
        "b",
        "c",
        "d",
        "A",
        "B",
        "C",
        "i",
        "j",
        "k",
        "u_old",
        "tau",
        "density",
        "form",
        "base",
        "exponent",
        "Omega",
        "Gamma",
        "State",
        "Param",
        "Given",
        "Test",
        "Unknown",
        "Scalar",
        "Field",
        "pub",
        "struct",
        "fn",
        "extern",
        "Rust",
        "let",
        "if",
        "else",
        "facets",
        "interior_facets",
        "cells",
    ];

    #[test]
    fn what_is_offered_exists() {
        for (_, help) in WORDS {
            for code in help.split('`').skip(1).step_by(2) {
                let words = code.split(|character: char| !character.is_alphanumeric() && character != '_');
                for word in words.filter(|word| word.starts_with(|character: char| character.is_alphabetic()))
                {
                    let known = is_built_in(word) || constant(word).is_some() || OTHERS.contains(&word);
                    assert!(known || code == "Field::interpolate", "`{word}` in {help}");
                }
            }
        }
    }
}
