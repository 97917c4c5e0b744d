//! Operators on other operands.

use crate::tensor::{Operator, Tensor};

/// The same operator on other operands.
pub fn map_operands(operator: &Operator, change: &mut impl FnMut(Tensor) -> Tensor) -> Operator {
    use Operator::*;
    match operator {
        Number(_) | Zero | Identity | SymmetricIdentity | Parameter(_) | Field { .. } | Geometry(_) => {
            operator.clone()
        }
        Restrict(side, a) => Restrict(*side, change(*a)),
        Opposite(a, displacement) => Opposite(change(*a), change(*displacement)),
        Sliding(geometry, displacement) => Sliding(*geometry, change(*displacement)),
        CellMean(a) => CellMean(change(*a)),
        FacetMean(a) => FacetMean(change(*a)),
        Negate(a) => Negate(change(*a)),
        Map(map, a) => Map(*map, change(*a)),
        Determinant(a) => Determinant(change(*a)),
        Inverse(a) => Inverse(change(*a)),
        Cofactor(a) => Cofactor(change(*a)),
        Component(a, index) => Component(change(*a), index.clone()),
        Slice(a, selections) => Slice(change(*a), selections.clone()),
        Norm(a) => Norm(change(*a)),
        Apply(function, a) => Apply(*function, change(*a)),
        Gradient(a) => Gradient(change(*a)),
        Partial(a, variable) => Partial(change(*a), *variable),
        Add(a, b) => Add(change(*a), change(*b)),
        Scale(a, b) => Scale(change(*a), change(*b)),
        Divide(a, b) => Divide(change(*a), change(*b)),
        DivideOrZero(a, b) => DivideOrZero(change(*a), change(*b)),
        Contract(a, b) => Contract(change(*a), change(*b)),
        DoubleContract(a, b) => DoubleContract(change(*a), change(*b)),
        Cross(a, b) => Cross(change(*a), change(*b)),
        MixedCofactor(a, b) => MixedCofactor(change(*a), change(*b)),
        Inner(a, b) => Inner(change(*a), change(*b)),
        Outer(a, b) => Outer(change(*a), change(*b)),
        Power(a, b) => Power(change(*a), change(*b)),
        Atan2(a, b) => Atan2(change(*a), change(*b)),
        Minimum(a, b) => Minimum(change(*a), change(*b)),
        Maximum(a, b) => Maximum(change(*a), change(*b)),
        Stack(entries) => Stack(entries.iter().map(|entry| change(*entry)).collect()),
        External { function, arguments, order } => {
            let arguments = arguments.iter().map(|argument| change(*argument)).collect();
            External { function: *function, arguments, order: *order }
        }
        Select(truth, a, b) => {
            let truth = truth.map(change);
            Select(truth, change(*a), change(*b))
        }
        Gateaux { expression, variable, direction } => {
            Gateaux { expression: change(*expression), variable: *variable, direction: change(*direction) }
        }
        Named(named) => Named(named.map(change)),
    }
}
