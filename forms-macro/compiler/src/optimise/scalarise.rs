//! Tensor expressions → their components in a [`Graph`].

mod determinant;
mod linear_map;
mod truth;

use super::hashing::Map;
use super::scalar::{Derivative, Graph, Node, Scalar};
use crate::differentiate::multi_indices;
use crate::parse::syntax::Entity;
use crate::tensor::{Arena, External, Function, Geometry, NEARLY_ZERO, Operator, Selection, Side, Tensor};

/// Components of tensors, each computed once.
pub struct Scalariser<'a> {
    pub arena: &'a Arena,
    pub graph: &'a mut Graph,
    /// Start of each parameter in the flattened list.
    pub parameter_offsets: &'a [usize],
    pub dimension: usize,
    /// The side from which the expression at hand is seen.
    pub side: Side,
    /// Is the other side a pair's opposite point? Else it is across an interior facet.
    pub opposite: OppositeSide,
    pub known: Map<(Tensor, Side, OppositeSide), Vec<Scalar>>,
}

/// The place that is seen on [`Side::Other`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum OppositeSide {
    /// The same point, in the cell across an interior facet.
    SamePoint,
    /// Another point, opposite to this one in a contact pair.
    PairedPoint,
}

impl OppositeSide {
    /// On the entities of a region.
    pub fn on(entity: Entity) -> Self {
        if entity == Entity::Pairs { OppositeSide::PairedPoint } else { OppositeSide::SamePoint }
    }
}

impl Scalariser<'_> {
    /// Row-major components.
    pub fn components(&mut self, tensor: Tensor) -> Vec<Scalar> {
        let key = (tensor, self.side, self.opposite);
        if let Some(known) = self.known.get(&key) {
            return known.clone();
        }
        let components = self.expand(tensor);
        self.known.insert(key, components.clone());
        components
    }

    /// The components seen from a side.
    fn components_on(&mut self, side: Side, tensor: Tensor) -> Vec<Scalar> {
        let outside = std::mem::replace(&mut self.side, side);
        let components = self.components(tensor);
        self.side = outside;
        components
    }

    /// The only component of a scalar.
    pub fn scalar(&mut self, tensor: Tensor) -> Scalar {
        self.components(tensor)[0]
    }

    /// A field's derivatives of an order, or what is made of each.
    fn field(
        &mut self,
        field: usize,
        order: usize,
        count: usize,
        made: fn(Derivative) -> Derivative,
    ) -> Vec<Scalar> {
        let axes = multi_indices(&vec![self.dimension; order]);
        let side = self.side;
        (0..count)
            .map(|entry| {
                let component = entry / axes.len();
                let derivative = made(Derivative::along(&axes[entry % axes.len()]));
                self.graph.intern(Node::Field { field, side, component, derivative })
            })
            .collect()
    }

    fn expand(&mut self, tensor: Tensor) -> Vec<Scalar> {
        use Operator::*;
        let arena = self.arena;
        let node = arena.node(tensor);
        let shape = &node.shape;
        let count: usize = shape.iter().product();
        match &node.operator {
            Number(value) => vec![self.graph.number(*value)],
            Zero => vec![self.graph.number(0.0); count],
            // Of rank 4, as a matrix from tensors to tensors.
            Identity => self.identity(shape[..shape.len() / 2].iter().product()),
            SymmetricIdentity => {
                let delta = |a: usize, b: usize| if a == b { 0.5 } else { 0.0 };
                multi_indices(shape)
                    .iter()
                    .map(|ijkl| {
                        let (straight, crossed) = ([ijkl[2], ijkl[3]], [ijkl[3], ijkl[2]]);
                        let one = |kl: [usize; 2]| 2.0 * delta(ijkl[0], kl[0]) * delta(ijkl[1], kl[1]);
                        self.graph.number(one(straight) + one(crossed))
                    })
                    .collect()
            }
            Parameter(index) => {
                let offset = self.parameter_offsets[*index];
                (0..count).map(|component| self.graph.intern(Node::Parameter(offset + component))).collect()
            }
            Field { field, order } => self.field(*field, *order, count, |derivative| derivative),
            CellMean(a) => match arena.node(*a).operator {
                Field { field, order } => self.field(field, order, count, Derivative::mean),
                // What is no mean of a field has been reported.
                _ => self.components(*a),
            },
            // Fields are in its place wherever there is a kernel.
            FacetMean(a) => self.components(*a),
            Geometry(geometry) => (0..count).map(|component| self.geometry(*geometry, component)).collect(),
            Restrict(side, a) => self.components_on(*side, *a),
            Opposite(a, _) => self.components_on(Side::Other, *a),
            Sliding(geometry, _) => (0..count).map(|component| self.geometry(*geometry, component)).collect(),
            Add(a, b) => self.zip(*a, *b, Graph::add),
            Negate(a) => self.map(*a, Graph::negate),
            Scale(factor, a) => {
                // The zeros of an identity, of an array and of derivatives are nothing, whatever they are multiplied by; a zero
                // that is written as a factor makes a NaN of what is infinite.
                let written = [*factor, *a].map(|one| arena.shape(one).is_empty() && self.is_written(one));
                let factor = self.scalar(*factor);
                self.map(*a, |graph, a| match (graph.is_zero(factor), graph.is_zero(a)) {
                    (true, false) if written[0] => graph.scale(0.0, a),
                    (false, true) if written[1] => graph.scale(0.0, factor),
                    _ => graph.multiply(factor, a),
                })
            }
            Divide(a, divisor) => {
                let written = shape.is_empty() && self.is_written(*a);
                let divisor = self.scalar(*divisor);
                self.map(*a, |graph, a| {
                    if written && graph.is_zero(a) {
                        let one = graph.number(1.0);
                        let inverse = graph.divide(one, divisor);
                        return graph.scale(0.0, inverse);
                    }
                    graph.divide(a, divisor)
                })
            }
            // Below the divisor's bound the factor is zero; a NaN is not below and stays visible.
            DivideOrZero(a, divisor) => {
                let divisor = self.scalar(*divisor);
                let (zero, one) = (self.graph.number(0.0), self.graph.number(1.0));
                let bound = self.graph.number(NEARLY_ZERO);
                let (off, inverse) =
                    (self.graph.intern(Node::LessEqual(divisor, bound)), self.graph.divide(one, divisor));
                let factor = self.graph.select(off, zero, inverse);
                self.map(*a, |graph, a| graph.multiply(factor, a))
            }
            Contract(a, b) | DoubleContract(a, b) => {
                let axes = if matches!(node.operator, Contract(..)) { 1 } else { 2 };
                let (first, second) = (self.components(*a), self.components(*b));
                let inner: usize = self.arena.shape(*b)[..axes].iter().product();
                let columns = second.len() / inner;
                let rows = first.len() / inner;
                let mut result = Vec::new();
                for row in 0..rows {
                    for column in 0..columns {
                        let pairs: Vec<_> = (0..inner)
                            .map(|k| (first[row * inner + k], second[k * columns + column]))
                            .collect();
                        result.push(self.sum_of_products(&pairs));
                    }
                }
                result
            }
            Inner(a, b) => {
                let pairs: Vec<_> = self.components(*a).into_iter().zip(self.components(*b)).collect();
                vec![self.sum_of_products(&pairs)]
            }
            Outer(a, b) => {
                let (first, second) = (self.components(*a), self.components(*b));
                first
                    .iter()
                    .flat_map(|a| second.iter().map(|b| (*a, *b)))
                    .map(|(a, b)| self.graph.multiply(a, b))
                    .collect()
            }
            Cross(a, b) => self.cross(*a, *b),
            Norm(a) => {
                let components = self.components(*a);
                if let [one] = components[..] {
                    return vec![self.graph.apply(Function::Abs, one)];
                }
                let squares: Vec<_> = components.iter().map(|a| (*a, *a)).collect();
                let sum = self.sum_of_products(&squares);
                vec![self.graph.apply(Function::Sqrt, sum)]
            }
            Map(map, a) => self.linear_map(*map, *a),
            Determinant(a) => {
                let (a, size) = (self.components(*a), self.arena.shape(*a)[0]);
                vec![self.determinant(&a, size)]
            }
            Cofactor(a) => {
                let (a, size) = (self.components(*a), self.arena.shape(*a)[0]);
                self.cofactors(&a, size)
            }
            MixedCofactor(a, b) => {
                let (a, b) = (self.components(*a), self.components(*b));
                self.mixed_cofactors(&a, &b)
            }
            Inverse(a) => {
                let (a, size) = (self.components(*a), self.arena.shape(*a)[0]);
                self.inverse(&a, size)
            }
            Component(a, indices) => {
                let (components, whole) = (self.components(*a), self.arena.shape(*a));
                let start =
                    indices.iter().zip(whole).fold(0, |start, (index, extent)| start * extent + index)
                        * count;
                components[start..start + count].to_vec()
            }
            Slice(a, selections) => {
                let components = self.components(*a);
                slice(self.arena.shape(*a), selections).into_iter().map(|entry| components[entry]).collect()
            }
            Stack(entries) => entries.iter().flat_map(|entry| self.components(*entry)).collect(),
            Apply(function, a) => {
                let a = self.scalar(*a);
                vec![self.graph.apply(*function, a)]
            }
            Power(a, b) => {
                let (a, b) = (self.scalar(*a), self.scalar(*b));
                vec![self.graph.power(a, b)]
            }
            Atan2(a, b) => {
                let (a, b) = (self.scalar(*a), self.scalar(*b));
                vec![self.graph.intern(Node::Atan2(a, b))]
            }
            Minimum(a, b) => {
                let (a, b) = (self.scalar(*a), self.scalar(*b));
                vec![self.graph.intern(Node::Minimum(a, b))]
            }
            Maximum(a, b) => {
                let (a, b) = (self.scalar(*a), self.scalar(*b));
                vec![self.graph.intern(Node::Maximum(a, b))]
            }
            Select(truth, a, b) => {
                let truth = self.truth(truth);
                self.zip(*a, *b, |graph, a, b| graph.select(truth, a, b))
            }
            Operator::External { function, arguments, order } => {
                let inputs: Vec<Scalar> =
                    arguments.iter().flat_map(|argument| self.components(*argument)).collect();
                let outputs = count / inputs.len().pow(*order as u32);
                let entries = multi_indices(&[&[outputs][..], &vec![inputs.len(); *order]].concat());
                let entries = entries.into_iter().map(|entry| match function.is_of_symmetric_tensors() {
                    true => self.of_symmetric_tensor(*function, &inputs, &entry),
                    false => {
                        let mut derivative = entry[1..].to_vec();
                        // The order of differentiation does not matter.
                        derivative.sort_unstable();
                        let (function, inputs, output) = (*function, inputs.clone(), entry[0]);
                        self.graph.intern(Node::External { function, inputs, outputs, output, derivative })
                    }
                });
                entries.collect()
            }
            // `differentiate` has removed these.
            Gradient(_) | Partial(..) | Gateaux { .. } | Named(_) => vec![self.graph.number(f64::NAN); count],
        }
    }

    /// An entry of a function of symmetric tensors, differentiated by entries. By an entry off the diagonal that is half of the
    /// derivative by the variable that this and its mirror image are (`External::variable` of the contract), and the value
    /// is symmetric, too: of 9 × 9 × 9 second derivatives in space there are 6 × 21.
    fn of_symmetric_tensor(&mut self, function: External, inputs: &[Scalar], entry: &[usize]) -> Scalar {
        let (outputs, size) = (inputs.len(), inputs.len().isqrt());
        let upper = |entry: usize| (entry / size).min(entry % size) * size + (entry / size).max(entry % size);
        let mut derivative: Vec<usize> = entry[1..].iter().map(|one| upper(*one)).collect();
        derivative.sort_unstable();
        let off_diagonal = derivative.iter().filter(|one| **one / size != **one % size).count();
        let (inputs, output) = (inputs.to_vec(), upper(entry[0]));
        let whole = self.graph.intern(Node::External { function, inputs, outputs, output, derivative });
        self.graph.scale(0.5_f64.powi(off_diagonal as i32), whole)
    }

    /// Is a scalar computed of numbers alone that the author wrote? Others that are zero come from identities, arrays and
    /// derivatives, or cancel.
    fn is_written(&self, tensor: Tensor) -> bool {
        use Operator::{Add, Apply, Divide, Negate, Number, Power, Scale};
        match self.arena.node(tensor).operator {
            Number(_) => true,
            Negate(a) | Apply(_, a) => self.is_written(a),
            Add(a, b) | Scale(a, b) | Divide(a, b) | Power(a, b) => self.is_written(a) && self.is_written(b),
            _ => false,
        }
    }

    /// Geometry seen from a side: what belongs to a cell is that cell's; across an interior facet the outward normal turns,
    /// and a pair's opposite point has a place and a normal of its own.
    fn geometry(&mut self, geometry: Geometry, component: usize) -> Scalar {
        use Geometry::*;
        let mut intern = |geometry| self.graph.intern(Node::Geometry(geometry, component));
        match (self.side, geometry, self.opposite) {
            (Side::Other, Diameter | CellVolume, _) => self.graph.intern(Node::Opposite(geometry)),
            (Side::Other, Position, OppositeSide::PairedPoint) => intern(OppositePosition),
            (Side::Other, Normal, OppositeSide::PairedPoint) => intern(OppositeNormal),
            (Side::Other, Normal | Curvature, _) => {
                let this = intern(geometry);
                self.graph.negate(this)
            }
            _ => intern(geometry),
        }
    }

    fn map(&mut self, a: Tensor, mut change: impl FnMut(&mut Graph, Scalar) -> Scalar) -> Vec<Scalar> {
        self.components(a).into_iter().map(|a| change(self.graph, a)).collect()
    }

    fn zip(
        &mut self,
        a: Tensor,
        b: Tensor,
        mut join: impl FnMut(&mut Graph, Scalar, Scalar) -> Scalar,
    ) -> Vec<Scalar> {
        let (first, second) = (self.components(a), self.components(b));
        first.into_iter().zip(second).map(|(a, b)| join(self.graph, a, b)).collect()
    }

    fn sum_of_products(&mut self, pairs: &[(Scalar, Scalar)]) -> Scalar {
        let products: Vec<_> = pairs.iter().map(|(a, b)| self.graph.multiply(*a, *b)).collect();
        self.graph.sum(&products)
    }

    fn identity(&mut self, size: usize) -> Vec<Scalar> {
        (0..size * size)
            .map(|entry| self.graph.number(if entry / size == entry % size { 1.0 } else { 0.0 }))
            .collect()
    }

    fn cross(&mut self, a: Tensor, b: Tensor) -> Vec<Scalar> {
        let (first, second) = (self.components(a), self.components(b));
        let mut difference = |i: usize, j: usize| {
            let (plus, minus) =
                (self.graph.multiply(first[i], second[j]), self.graph.multiply(first[j], second[i]));
            let minus = self.graph.negate(minus);
            self.graph.add(plus, minus)
        };
        match first.len() {
            2 => vec![difference(0, 1)],
            _ => vec![difference(1, 2), difference(2, 0), difference(0, 1)],
        }
    }
}

/// Row-major indices of the selected entries.
fn slice(shape: &[usize], selections: &[Selection]) -> Vec<usize> {
    shape.iter().zip(selections).fold(vec![0], |places, (extent, selection)| {
        let taken = match *selection {
            Selection::One(index) => index..index + 1,
            Selection::Range { start, end } => start..end,
        };
        places.iter().flat_map(|place| taken.clone().map(move |index| place * extent + index)).collect()
    })
}
