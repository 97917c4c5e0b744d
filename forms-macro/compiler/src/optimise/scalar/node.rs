//! The nodes of a [`Graph`](super::Graph): numbers, what a form reads, and operations on them.

use crate::tensor::{External, Function, Geometry, Side};

/// A node of a [`Graph`](super::Graph), by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Scalar(pub u32);

/// Which basis function a [`Node::Basis`] belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Argument {
    Test,
    Trial,
}

/// A derivative of a scalar component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Derivative {
    /// None: the value.
    Value,
    /// Along an axis.
    First(usize),
    /// Along two axes, the smaller one first: second derivatives are symmetric.
    Second(usize, usize),
    /// Mean of the value over the cell.
    MeanValue,
    /// Mean over the cell of the derivative along an axis.
    MeanFirst(usize),
}

/// The derivatives of a component that are read together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    Value,
    Gradient,
    Hessian,
    MeanValue,
    MeanGradient,
}

impl Kind {
    /// Number of axes along which a component is differentiated.
    pub fn order(self) -> usize {
        match self {
            Kind::Value | Kind::MeanValue => 0,
            Kind::Gradient | Kind::MeanGradient => 1,
            Kind::Hessian => 2,
        }
    }
}

impl Derivative {
    /// Along axes in any order.
    pub fn along(axes: &[usize]) -> Self {
        match *axes {
            [] => Derivative::Value,
            [axis] => Derivative::First(axis),
            [first, second, ..] => Derivative::Second(first.min(second), first.max(second)),
        }
    }

    /// The mean over the cell of a value or first derivative.
    pub fn mean(self) -> Self {
        match self {
            Derivative::Value => Derivative::MeanValue,
            Derivative::First(axis) => Derivative::MeanFirst(axis),
            other => other,
        }
    }

    /// Is it a mean over the cell?
    pub fn is_mean(self) -> bool {
        matches!(self, Derivative::MeanValue | Derivative::MeanFirst(_))
    }

    /// Quantity by which it is read.
    pub fn kind(self) -> Kind {
        match self {
            Derivative::Value => Kind::Value,
            Derivative::First(_) => Kind::Gradient,
            Derivative::Second(..) => Kind::Hessian,
            Derivative::MeanValue => Kind::MeanValue,
            Derivative::MeanFirst(_) => Kind::MeanGradient,
        }
    }
}

/// A scalar expression whose operands are nodes.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Node {
    /// Bits of an `f64`.
    Number(u64),
    /// Entry of the flattened parameters.
    Parameter(usize),
    /// A derivative of a field's component, in the cell on one side.
    Field {
        field: usize,
        side: Side,
        component: usize,
        derivative: Derivative,
    },
    Geometry(Geometry, usize),
    /// The diameter or volume of the cell across an interior facet.
    Opposite(Geometry),
    /// Quadrature weight times measure.
    Weight,
    /// A derivative of the basis function.
    Basis(Argument, Derivative),
    /// Σ over the points of weight × derivative of the test × derivative of the trial basis function.
    Accumulated(usize),
    /// constant + Σ coefficient × term; terms sorted, no Number, no Sum with coefficient one.
    Sum {
        constant: u64,
        terms: Vec<(u64, Scalar)>,
    },
    /// Π factor^exponent; factors sorted, no Number, no Product.
    Product(Vec<(Scalar, i32)>),
    Apply(Function, Scalar),
    Power(Scalar, Scalar),
    Atan2(Scalar, Scalar),
    Minimum(Scalar, Scalar),
    Maximum(Scalar, Scalar),
    Select(Scalar, Scalar, Scalar),
    /// The `output`-th of the `outputs` components of a function, differentiated by some of its inputs (sorted).
    External {
        function: External,
        inputs: Vec<Scalar>,
        outputs: usize,
        output: usize,
        derivative: Vec<usize>,
    },
    /// Truth values.
    Less(Scalar, Scalar),
    LessEqual(Scalar, Scalar),
    Equal(Scalar, Scalar),
    And(Scalar, Scalar),
    Or(Scalar, Scalar),
    Not(Scalar),
}

impl Node {
    /// Itself and its operands, where these are many.
    pub(super) fn size(&self) -> usize {
        match self {
            Node::Sum { terms, .. } => 1 + terms.len(),
            Node::Product(factors) => 1 + factors.len(),
            _ => 1,
        }
    }
}
