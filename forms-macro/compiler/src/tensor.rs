//! The tensor expressions that stages 2 and 3 share: nodes in an arena, each with a shape and a span.
//!
//! `check` builds them, still with the three operators of differentiation ([`Operator::Gradient`],
//! [`Operator::Partial`], [`Operator::Gateaux`]); `differentiate` removes those.

mod arena;
mod geometry;
mod truth;

use crate::parse::syntax::Entity;
pub use arena::Arena;
pub use geometry::Geometry;
pub use truth::Truth;

/// A node of an [`Arena`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Tensor(pub u32);

/// Extents of the axes: `[]` scalar, `[D]` vector, `[D, D]` tensor; up to rank 4 inside.
pub type Shape = Vec<usize>;

/// A cell of a facet. Inside cells and on exterior facets there is only `This`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Side {
    /// The cell that owns the facet.
    This,
    /// The cell across it, or that of a pair's opposite point.
    Other,
}

/// Linear maps of tensors, all with the derivative rule d(L a) = L da.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LinearMap {
    Transpose,
    Trace,
    Symmetric,
    Skew,
    Deviator,
    /// Of a gradient G: ε_ijk G_kj in three dimensions, G_10 − G_01 in two.
    Curl,
    /// (a_0, a_1) → (−a_1, a_0), a quarter turn to the left.
    Perpendicular,
    /// The diagonal of a square tensor, as a vector.
    Diagonal,
    /// The tensor with a vector on its diagonal and zeros elsewhere.
    DiagonalTensor,
}

/// Scalar functions of one scalar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Function {
    Sqrt,
    Exp,
    Ln,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
    /// To the base 10.
    Log10,
    /// 2/√π ∫₀ᵃ exp(−t²) dt
    Erf,
    /// 1 − erf a
    Erfc,
    Abs,
    Sign,
    Heaviside,
    PositivePart,
    NegativePart,
}

/// A function whose inside the compiler does not see. Its derivatives exist at run time, by dual numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum External {
    /// Written in Rust, by index in [`crate::parse::syntax::Module::externals`].
    Function(usize),
    /// A tabulated law, by index of the data member.
    Table(usize),
    TensorExponential,
    TensorLogarithm,
    TensorSquareRoot,
}

impl External {
    /// Is it a function of a symmetric tensor, which gives one?
    pub fn is_of_symmetric_tensors(self) -> bool {
        matches!(self, External::TensorExponential | External::TensorLogarithm | External::TensorSquareRoot)
    }
}

/// With respect to what a derivative is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Variable {
    /// A field of the form, by index.
    Field(usize),
    /// A parameter, by index of the data member.
    Parameter(usize),
    /// An intermediate result: an argument or a `let` name.
    Node(Tensor),
    /// The shape of the domain: points move along a vector field, at fixed reference coordinates. With the entity that is
    /// integrated over its measure moves, too, and is divided out again: (density × measure)′ / measure.
    Shape(Option<Entity>),
    /// A length, area or volume of the cell or facet; nothing else moves.
    Size(Geometry),
}

/// The divisor of [`Operator::DivideOrZero`] that counts as zero: its inverse, to the third power,
/// is still a number.
pub const NEARLY_ZERO: f64 = 1e-100;

/// The part of one axis that [`Operator::Slice`] takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Selection {
    /// One entry; the axis vanishes.
    One(usize),
    /// `start..end`; the axis stays, with the extent `end - start`.
    Range { start: usize, end: usize },
}

#[derive(Clone, Debug)]
pub enum Operator {
    Number(f64),
    Zero,
    /// Of shape `[n, n]` δ_ij; of shape `[n, n, n, n]` δ_ik δ_jl, which maps each tensor to itself.
    Identity,
    /// Of shape `[n, n, n, n]`: (δ_ik δ_jl + δ_il δ_jk) / 2, which maps each tensor to its symmetric part.
    SymmetricIdentity,
    /// A parameter, by index of the data member.
    Parameter(usize),
    /// A field's derivative of an order: 0 the value, 1 the gradient, 2 the second derivatives (the
    /// component, then one direction per order).
    Field {
        field: usize,
        order: usize,
    },
    Geometry(Geometry),
    Add(Tensor, Tensor),
    Negate(Tensor),
    /// Scalar times tensor.
    Scale(Tensor, Tensor),
    /// Tensor divided by scalar.
    Divide(Tensor, Tensor),
    /// Tensor divided by a scalar s that is not negative; zero where s ≤ [`NEARLY_ZERO`].
    DivideOrZero(Tensor, Tensor),
    /// Last axis of the first with first axis of the second.
    Contract(Tensor, Tensor),
    /// Last two axes of the first with first two axes of the second, in their order: C_ijkl E_kl.
    DoubleContract(Tensor, Tensor),
    /// a × b of vectors: ε_ijk a_j b_k of three components, the scalar a_0 b_1 − a_1 b_0 of two.
    Cross(Tensor, Tensor),
    /// All axes of two tensors of one shape.
    Inner(Tensor, Tensor),
    Outer(Tensor, Tensor),
    /// √(a : a), all axes contracted. Its derivative is (a : da) / |a| by [`Operator::DivideOrZero`].
    Norm(Tensor),
    Map(LinearMap, Tensor),
    Determinant(Tensor),
    Inverse(Tensor),
    /// det(A) A⁻ᵀ, which is polynomial.
    Cofactor(Tensor),
    /// cof A of 3×3 matrices as a bilinear map, cof(A, A) = 2 cof A: the derivative of cof A along B is cof(A, B).
    MixedCofactor(Tensor, Tensor),
    /// Fixes the leading axes.
    Component(Tensor, Vec<usize>),
    /// Picks from every axis.
    Slice(Tensor, Vec<Selection>),
    /// A new leading axis.
    Stack(Vec<Tensor>),
    Apply(Function, Tensor),
    Power(Tensor, Tensor),
    /// The angle of the point (second, first) with the first axis, in (−π, π].
    Atan2(Tensor, Tensor),
    Minimum(Tensor, Tensor),
    Maximum(Tensor, Tensor),
    Select(Truth, Tensor, Tensor),
    /// The `order`-th derivative of a function: the axes of its value, then `order` axes as long as the list of
    /// all scalar inputs (the arguments one after the other, each row-major).
    External {
        function: External,
        arguments: Vec<Tensor>,
        order: usize,
    },
    /// The mean over the cell. After differentiation only of a field or its gradient.
    CellMean(Tensor),
    /// The mean over the covered part of a pair's own facet, inside of `means`. Kernels do not hold it: `differentiate` puts fields in its
    /// place.
    FacetMean(Tensor),
    /// The limit of an expression at an interior facet, from one of its two cells; on a pair, its value at X or at Y.
    Restrict(Side, Tensor),
    /// The value of the first at the opposite point Y of a sliding pair, whose surfaces are displaced by the second.
    Opposite(Tensor, Tensor),
    /// Gap or direction of a sliding pair, whose surfaces are displaced by a vector.
    Sliding(Geometry, Tensor),

    /// ∇ of an expression: a new trailing axis.
    Gradient(Tensor),
    /// ∂e/∂w: the axes of e, then those of w.
    Partial(Tensor, Variable),
    /// Directional derivative of e with respect to a variable.
    Gateaux {
        expression: Tensor,
        variable: Variable,
        direction: Tensor,
    },

    /// A name with its meaning: only where a formula is to be shown, never in a kernel.
    Named(Named),
}

/// A named part of a formula.
#[derive(Clone, Debug)]
pub enum Named {
    /// A call of a function of the module, or its derivative of order `directions.len()`: each direction has
    /// one entry per argument, [`Operator::Zero`] for an argument that does not vary.
    Call { function: usize, arguments: Vec<Tensor>, directions: Vec<Vec<Tensor>> },
    /// `let name = value;`, or a built-in number such as π.
    Value { name: String, value: Tensor },
}

impl Named {
    /// The nodes that this one is made of.
    pub fn operands(&self) -> Vec<Tensor> {
        match self {
            Named::Call { arguments, directions, .. } => {
                arguments.iter().chain(directions.iter().flatten()).copied().collect()
            }
            Named::Value { value, .. } => vec![*value],
        }
    }

    /// The same name with other operands.
    pub fn map(&self, change: &mut impl FnMut(Tensor) -> Tensor) -> Named {
        let mut all = |list: &[Tensor]| list.iter().map(|operand| change(*operand)).collect::<Vec<_>>();
        match self {
            Named::Call { function, arguments, directions } => Named::Call {
                function: *function,
                arguments: all(arguments),
                directions: directions.iter().map(|row| all(row)).collect(),
            },
            Named::Value { name, value } => Named::Value { name: name.clone(), value: change(*value) },
        }
    }
}

impl Operator {
    /// The nodes that this one is made of.
    pub fn operands(&self) -> Vec<Tensor> {
        use Operator::*;
        match self {
            Number(_) | Zero | Identity | SymmetricIdentity | Parameter(_) | Field { .. } | Geometry(_) => {
                vec![]
            }
            Negate(a)
            | Map(_, a)
            | Determinant(a)
            | Inverse(a)
            | Cofactor(a)
            | Component(a, _)
            | Slice(a, _)
            | Norm(a)
            | Apply(_, a)
            | CellMean(a)
            | FacetMean(a)
            | Restrict(_, a)
            | Sliding(_, a)
            | Gradient(a)
            | Partial(a, _) => vec![*a],
            Opposite(a, b)
            | Add(a, b)
            | Scale(a, b)
            | Divide(a, b)
            | DivideOrZero(a, b)
            | Contract(a, b)
            | DoubleContract(a, b)
            | Cross(a, b)
            | MixedCofactor(a, b)
            | Inner(a, b)
            | Outer(a, b)
            | Power(a, b)
            | Atan2(a, b)
            | Minimum(a, b)
            | Maximum(a, b) => vec![*a, *b],
            Gateaux { expression, direction, .. } => vec![*expression, *direction],
            Stack(entries) | External { arguments: entries, .. } => entries.clone(),
            Named(named) => named.operands(),
            Select(truth, a, b) => {
                let mut all = truth.operands();
                all.extend([*a, *b]);
                all
            }
        }
    }
}

/// The role of a field in a form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldRole {
    Unknown(usize),
    Test(usize),
    State,
    /// Data that are fixed in space.
    Given,
    /// Data that move with the body.
    Carried,
    /// Known at quadrature points only: it has no gradient.
    History,
    /// The direction in which the tangent differentiates the k-th unknown.
    Trial(usize),
    /// Means over own facets, the k-th list: numbers where they are read.
    Mean(usize),
    /// The function with which they are integrated.
    MeanTest(usize),
    /// The direction in which a residual is differentiated by them.
    MeanTrial(usize),
}

impl FieldRole {
    /// A member of the data struct.
    pub fn is_data(self) -> bool {
        matches!(self, FieldRole::Given | FieldRole::Carried | FieldRole::History)
    }
}

/// A field of a form.
#[derive(Clone, Debug)]
pub struct FieldInfo {
    pub name: String,
    pub role: FieldRole,
    pub shape: Shape,
}
