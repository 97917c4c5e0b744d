//! The names that every forms module knows: operators, functions, geometry.

use crate::tensor::{External, Function, Geometry, LinearMap, Side};

/// A name that is called with arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Builtin {
    Dot,
    DoubleDot,
    Cross,
    Inner,
    Outer,
    Norm,
    Normalize,
    Diagonal,
    Perpendicular,
    Identity,
    Map(LinearMap),
    Determinant,
    Inverse,
    Cofactor,
    Gradient,
    Hessian,
    Divergence,
    Strain,
    Curl,
    Apply(Function),
    Power,
    Square,
    Hypotenuse,
    Atan2,
    Minimum,
    Maximum,
    Restrict(Side),
    Jump,
    Average,
    CellMean,
    Integral,
    Means,
    Derivative,
    Partial,
    /// A function of a square tensor.
    External(External),
}

/// A name of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constant {
    Geometry(Geometry),
    Identity,
    /// The identity of tensors, of rank 4.
    TensorIdentity,
    /// The tensor that maps each tensor to its symmetric part.
    SymmetricIdentity,
    Dimension,
    Pi,
    /// The shape of the domain: no value, but `derivative` differentiates by it.
    Shape,
}

/// Called names, with the number of their arguments and how they are written.
pub const BUILTINS: &[(&str, Builtin, usize, &str)] = &[
    ("dot", Builtin::Dot, 2, "dot(a, b)"),
    ("ddot", Builtin::DoubleDot, 2, "ddot(C, A)"),
    ("inner", Builtin::Inner, 2, "inner(a, b)"),
    ("outer", Builtin::Outer, 2, "outer(a, b)"),
    ("cross", Builtin::Cross, 2, "cross(a, b)"),
    ("norm", Builtin::Norm, 1, "norm(a)"),
    ("normalize", Builtin::Normalize, 1, "normalize(a)"),
    ("perp", Builtin::Perpendicular, 1, "perp(a)"),
    ("diag", Builtin::Diagonal, 1, "diag(A)"),
    ("identity", Builtin::Identity, 1, "identity(3)"),
    ("transpose", Builtin::Map(LinearMap::Transpose), 1, "transpose(A)"),
    ("tr", Builtin::Map(LinearMap::Trace), 1, "tr(A)"),
    ("sym", Builtin::Map(LinearMap::Symmetric), 1, "sym(A)"),
    ("skew", Builtin::Map(LinearMap::Skew), 1, "skew(A)"),
    ("dev", Builtin::Map(LinearMap::Deviator), 1, "dev(A)"),
    ("det", Builtin::Determinant, 1, "det(A)"),
    ("inv", Builtin::Inverse, 1, "inv(A)"),
    ("cof", Builtin::Cofactor, 1, "cof(A)"),
    ("grad", Builtin::Gradient, 1, "grad(u)"),
    ("hess", Builtin::Hessian, 1, "hess(u)"),
    ("div", Builtin::Divergence, 1, "div(u)"),
    ("eps", Builtin::Strain, 1, "eps(u)"),
    ("curl", Builtin::Curl, 1, "curl(u)"),
    ("sqrt", Builtin::Apply(Function::Sqrt), 1, "sqrt(a)"),
    ("exp", Builtin::Apply(Function::Exp), 1, "exp(a)"),
    ("ln", Builtin::Apply(Function::Ln), 1, "ln(a)"),
    ("sin", Builtin::Apply(Function::Sin), 1, "sin(a)"),
    ("cos", Builtin::Apply(Function::Cos), 1, "cos(a)"),
    ("tan", Builtin::Apply(Function::Tan), 1, "tan(a)"),
    ("asin", Builtin::Apply(Function::Asin), 1, "asin(a)"),
    ("acos", Builtin::Apply(Function::Acos), 1, "acos(a)"),
    ("atan", Builtin::Apply(Function::Atan), 1, "atan(a)"),
    ("atan2", Builtin::Atan2, 2, "atan2(y, x)"),
    ("sinh", Builtin::Apply(Function::Sinh), 1, "sinh(a)"),
    ("cosh", Builtin::Apply(Function::Cosh), 1, "cosh(a)"),
    ("tanh", Builtin::Apply(Function::Tanh), 1, "tanh(a)"),
    ("asinh", Builtin::Apply(Function::Asinh), 1, "asinh(a)"),
    ("acosh", Builtin::Apply(Function::Acosh), 1, "acosh(a)"),
    ("atanh", Builtin::Apply(Function::Atanh), 1, "atanh(a)"),
    ("log10", Builtin::Apply(Function::Log10), 1, "log10(a)"),
    ("erf", Builtin::Apply(Function::Erf), 1, "erf(a)"),
    ("erfc", Builtin::Apply(Function::Erfc), 1, "erfc(a)"),
    ("abs", Builtin::Apply(Function::Abs), 1, "abs(a)"),
    ("sign", Builtin::Apply(Function::Sign), 1, "sign(a)"),
    ("heaviside", Builtin::Apply(Function::Heaviside), 1, "heaviside(a)"),
    ("pos_part", Builtin::Apply(Function::PositivePart), 1, "pos_part(a)"),
    ("neg_part", Builtin::Apply(Function::NegativePart), 1, "neg_part(a)"),
    ("tensor_exp", Builtin::External(External::TensorExponential), 1, "tensor_exp(A)"),
    ("tensor_ln", Builtin::External(External::TensorLogarithm), 1, "tensor_ln(A)"),
    ("tensor_sqrt", Builtin::External(External::TensorSquareRoot), 1, "tensor_sqrt(A)"),
    ("pow", Builtin::Power, 2, "pow(base, exponent)"),
    ("sqr", Builtin::Square, 1, "sqr(a)"),
    ("hypot", Builtin::Hypotenuse, 2, "hypot(a, b)"),
    ("min", Builtin::Minimum, 2, "min(a, b)"),
    ("max", Builtin::Maximum, 2, "max(a, b)"),
    ("this", Builtin::Restrict(Side::This), 1, "this(e)"),
    ("other", Builtin::Restrict(Side::Other), 1, "other(e)"),
    ("jump", Builtin::Jump, 1, "jump(e)` or `jump(e, n)"),
    ("avg", Builtin::Average, 1, "avg(e)"),
    ("mean", Builtin::CellMean, 1, "mean(e)"),
    ("integral", Builtin::Integral, 2, "integral(Region, density)"),
    ("means", Builtin::Means, 3, "means(Region(u), degree, density)"),
    ("derivative", Builtin::Derivative, 3, "derivative(form, field, direction)"),
    ("diff", Builtin::Partial, 2, "diff(expression, name)"),
];

/// Names of values, with their long and short form.
pub const CONSTANTS: &[(&str, Constant)] = &[
    ("diameter", Constant::Geometry(Geometry::Diameter)),
    ("h", Constant::Geometry(Geometry::Diameter)),
    ("normal", Constant::Geometry(Geometry::Normal)),
    ("n", Constant::Geometry(Geometry::Normal)),
    ("position", Constant::Geometry(Geometry::Position)),
    ("x", Constant::Geometry(Geometry::Position)),
    ("cell_volume", Constant::Geometry(Geometry::CellVolume)),
    ("facet_area", Constant::Geometry(Geometry::FacetArea)),
    ("curvature", Constant::Geometry(Geometry::Curvature)),
    ("identity", Constant::Identity),
    ("I", Constant::Identity),
    ("identity4", Constant::TensorIdentity),
    ("sym_identity4", Constant::SymmetricIdentity),
    ("dimension", Constant::Dimension),
    ("D", Constant::Dimension),
    ("PI", Constant::Pi),
    ("shape", Constant::Shape),
];

/// Names of quantities of a contact pair, used where the module's data have no member of that name.
pub const OF_PAIRS: &[(&str, Geometry)] = &[("gap", Geometry::Gap), ("toward", Geometry::Toward)];

/// The called name, if it is built in: what it is, its number of arguments, how it is written.
pub fn builtin(name: &str) -> Option<(Builtin, usize, &'static str)> {
    BUILTINS.iter().find(|entry| entry.0 == name).map(|entry| (entry.1, entry.2, entry.3))
}

/// The value's name, if it is built in.
pub fn constant(name: &str) -> Option<Constant> {
    CONSTANTS.iter().find(|entry| entry.0 == name).map(|entry| entry.1)
}

/// The quantity of a contact pair that has this name.
pub fn of_pairs(name: &str) -> Option<Geometry> {
    OF_PAIRS.iter().find(|entry| entry.0 == name).map(|entry| entry.1)
}

/// Is the name taken?
pub fn is_built_in(name: &str) -> bool {
    builtin(name).is_some() || constant(name).is_some()
}

/// The known name nearest to an unknown one, if it is near enough to be meant.
pub fn nearest<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let allowed = (name.chars().count() / 3).max(1);
    known
        .map(|candidate| (edit_distance(name, candidate), candidate))
        .filter(|(distance, candidate)| *distance <= allowed && *distance < candidate.chars().count())
        .min()
        .map(|(_, candidate)| candidate)
}

/// Edits that turn one word into the other: insert, delete, replace, swap neighbours.
fn edit_distance(first: &str, second: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (first.chars().collect(), second.chars().collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            rows[i][j] = if i == 0 || j == 0 {
                i + j
            } else {
                let replace = rows[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
                let mut best = replace.min(rows[i - 1][j] + 1).min(rows[i][j - 1] + 1);
                if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                    best = best.min(rows[i - 2][j - 2] + 1);
                }
                best
            };
        }
    }
    rows[a.len()][b.len()]
}
