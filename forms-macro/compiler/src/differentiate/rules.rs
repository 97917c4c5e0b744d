//! The rules of differentiation, one per operator.
//!
//! Kinks: the derivative of `neg_part`, `pos_part` and `abs` at 0 is 0, that of `heaviside` and `sign`
//! is 0 everywhere; `max(a, b)` differentiates as `if a > b { a } else { b }`, `min(a, b)` as
//! `if a > b { b } else { a }`; that of `norm(a)` at a = 0 is 0, as is that of `atan2` at the origin.
//!
//! The scalar functions are in the child module `functions`, the shape of the domain in `shape`, opposite points in
//! `opposite`, what only formulas hold in `formulas`.

mod formulas;
mod functions;
mod opposite;
mod shape;

use std::collections::HashMap;

use super::cell_mean::CellMeans;
use crate::diagnostics::Diagnostics;
use crate::parse::syntax::Comparison;
use crate::tensor::{Arena, FieldInfo, Geometry, Operator, Tensor, Truth, Variable};

/// The variable and its direction.
#[derive(Clone, Copy, Debug)]
pub enum Seed {
    /// A variable moves in a direction; a field's gradient moves with it if `with_gradient`
    /// (else the gradient is held fixed, as in ∂L/∂u of a Lagrangian density).
    Toward { variable: Variable, direction: Tensor, with_gradient: bool },
    /// The point moves along an axis: ∂/∂x_k.
    Along(usize),
}

/// One directional derivative, shared nodes differentiated once.
pub struct Differentiation<'a> {
    arena: &'a mut Arena,
    dimension: usize,
    seed: Seed,
    /// The direction of [`Seed::Toward`] and its derivatives, by order, as far as the expression reads.
    directions: Vec<Tensor>,
    fields: &'a [FieldInfo],
    diagnostics: &'a mut Diagnostics,
    /// The node at hand is inside a limit from one side of a facet.
    restricted: bool,
    /// Per node, and whether it is inside such a limit.
    known: Known,
    /// Only derivatives along a surface are wanted: there the normal has one.
    along_surface: bool,
    /// Derivatives along the axes of what is seen at opposite points.
    slopes: Vec<Known>,
    /// By displacement, how the opposite point moves.
    moved_pairs: HashMap<Tensor, Option<opposite::MovedPair>>,
}

/// Derivatives by node, and whether it is inside a limit from one side.
type Known = HashMap<(Tensor, bool), Option<Tensor>>;

impl<'a> Differentiation<'a> {
    pub fn new(
        arena: &'a mut Arena,
        dimension: usize,
        seed: Seed,
        directions: Vec<Tensor>,
        fields: &'a [FieldInfo],
        diagnostics: &'a mut Diagnostics,
    ) -> Self {
        Differentiation {
            arena,
            dimension,
            seed,
            directions,
            fields,
            diagnostics,
            restricted: false,
            known: HashMap::new(),
            along_surface: false,
            slopes: vec![HashMap::new(); dimension],
            moved_pairs: HashMap::new(),
        }
    }

    /// The derivative; `None` if it is zero.
    pub fn derive(&mut self, tensor: Tensor) -> Option<Tensor> {
        let key = (tensor, self.restricted);
        if let Some(known) = self.known.get(&key) {
            return *known;
        }
        let derivative = self.rule(tensor);
        self.known.insert(key, derivative);
        derivative
    }

    fn rule(&mut self, tensor: Tensor) -> Option<Tensor> {
        use Operator::*;
        if let Seed::Toward { variable: Variable::Node(node), direction, .. } = self.seed
            && node == tensor
        {
            return Some(direction);
        }
        let shape = self.arena.shape(tensor).to_vec();
        match self.arena.node(tensor).operator.clone() {
            Number(_) | Zero | Identity | SymmetricIdentity => None,
            Parameter(index) => match self.seed {
                Seed::Toward { variable: Variable::Parameter(varied), direction, .. } if varied == index => {
                    Some(direction)
                }
                _ => None,
            },
            Field { field, order } => self.field(tensor, field, order),
            Geometry(geometry) => self.geometry(tensor, geometry),
            Add(a, b) => {
                let (da, db) = (self.derive(a), self.derive(b));
                self.sum(da, db)
            }
            Negate(a) => {
                let da = self.derive(a)?;
                Some(self.push(Negate(da), shape, tensor))
            }
            Scale(a, b) => self.product(tensor, a, b, Scale),
            Contract(a, b) => self.product(tensor, a, b, Contract),
            Inner(a, b) => self.product(tensor, a, b, Inner),
            Outer(a, b) => self.product(tensor, a, b, Outer),
            DoubleContract(a, b) => self.product(tensor, a, b, DoubleContract),
            Cross(a, b) => self.product(tensor, a, b, Cross),
            MixedCofactor(a, b) => self.product(tensor, a, b, MixedCofactor),
            Divide(a, b) => self.quotient(tensor, a, b, Divide),
            DivideOrZero(a, b) => self.quotient(tensor, a, b, DivideOrZero),
            // d|a| = (a : da) / |a|, and 0 at a = 0
            Norm(a) => {
                let da = self.derive(a)?;
                let product = self.push(Inner(a, da), vec![], tensor);
                Some(self.push(DivideOrZero(product, tensor), vec![], tensor))
            }
            Map(map, a) => {
                let da = self.derive(a)?;
                Some(self.push(Map(map, da), shape, tensor))
            }
            // d det A = cof A : dA
            Determinant(a) => {
                let da = self.derive(a)?;
                let matrix = self.arena.shape(a).to_vec();
                let cofactor = self.push(Cofactor(a), matrix, tensor);
                Some(self.push(Inner(cofactor, da), vec![], tensor))
            }
            // d A⁻¹ = −A⁻¹ dA A⁻¹
            Inverse(a) => {
                let da = self.derive(a)?;
                let left = self.push(Contract(tensor, da), shape.clone(), tensor);
                let both = self.push(Contract(left, tensor), shape.clone(), tensor);
                Some(self.push(Negate(both), shape, tensor))
            }
            Cofactor(a) => self.cofactor(tensor, a),
            Component(a, index) => {
                let da = self.derive(a)?;
                Some(self.push(Component(da, index), shape, tensor))
            }
            Slice(a, selections) => {
                let da = self.derive(a)?;
                Some(self.push(Slice(da, selections), shape, tensor))
            }
            Stack(entries) => {
                let derived: Vec<_> = entries.iter().map(|entry| self.derive(*entry)).collect();
                if derived.iter().all(Option::is_none) {
                    return None;
                }
                let row = shape[1..].to_vec();
                let derived = derived
                    .into_iter()
                    .map(|entry| entry.unwrap_or_else(|| self.push(Zero, row.clone(), tensor)))
                    .collect();
                Some(self.push(Stack(derived), shape, tensor))
            }
            Apply(function, a) => {
                let da = self.derive(a)?;
                let slope = self.slope(function, a, tensor)?;
                Some(self.push(Scale(slope, da), shape, tensor))
            }
            Power(a, b) => self.power(tensor, a, b),
            Atan2(a, b) => self.angle(tensor, a, b),
            Minimum(a, b) => self.extremum(tensor, a, b, false),
            Maximum(a, b) => self.extremum(tensor, a, b, true),
            Select(truth, a, b) => {
                let (da, db) = (self.derive(a), self.derive(b));
                self.choose(truth, da, db, tensor)
            }
            External { function, arguments, order } => self.external(tensor, function, arguments, order),
            // A limit from one side commutes with every derivative.
            Restrict(side, a) => {
                let outside = std::mem::replace(&mut self.restricted, true);
                let da = self.derive(a);
                self.restricted = outside;
                let da = da?;
                Some(self.push(Restrict(side, da), shape, tensor))
            }
            CellMean(a) => self.cell_mean(tensor, a),
            FacetMean(a) => self.facet_mean(tensor, a),
            Opposite(a, displacement) => self.at_opposite_point(tensor, a, displacement),
            Sliding(geometry, displacement) => self.sliding(tensor, geometry, displacement),
            // Below: only in formulas. For kernels they are removed before a derivative is taken of what holds them.
            // d ∇e = ∇de
            Gradient(a) => {
                let da = self.derive(a);
                if self.by_shape() {
                    return self.gradient_as_points_move(tensor, da);
                }
                let da = da?;
                Some(self.push(Gradient(da), shape, tensor))
            }
            Partial(expression, variable) => self.partial(tensor, expression, variable),
            Gateaux { .. } => self.postponed(tensor),
            Operator::Named(named) => self.named(tensor, named),
        }
    }

    fn field(&mut self, tensor: Tensor, field: usize, order: usize) -> Option<Tensor> {
        match self.seed {
            // Without their gradients, only values move: the list of directions ends.
            Seed::Toward { variable: Variable::Field(varied), .. } if varied == field => {
                self.directions.get(order).copied()
            }
            Seed::Toward { variable: Variable::Shape(_), .. } => {
                self.field_as_points_move(tensor, field, order)
            }
            Seed::Toward { .. } => None,
            Seed::Along(axis) if order < 2 => {
                let shape = self.arena.shape(tensor).to_vec();
                let full = [&shape[..], &[self.dimension]].concat();
                let gradient = self.push(Operator::Field { field, order: order + 1 }, full, tensor);
                Some(self.column(gradient, &shape, axis, tensor))
            }
            Seed::Along(_) => {
                self.no_third_derivative(tensor);
                None
            }
        }
    }

    /// d mean(e) = mean(de) at fixed points; by the shape also mean(e ϑ) − mean(e) mean(ϑ), with the rate ϑ of the facet's measure.
    fn facet_mean(&mut self, tensor: Tensor, a: Tensor) -> Option<Tensor> {
        let shape = self.arena.shape(tensor).to_vec();
        let change = match self.seed {
            Seed::Along(_) => return None,
            Seed::Toward { variable: Variable::Shape(Some(_)), .. } => self.derive_with_measure(a),
            Seed::Toward { .. } => self.derive(a),
        };
        let change = change.map(|change| self.push(Operator::FacetMean(change), shape.clone(), tensor));
        let Seed::Toward { variable: Variable::Shape(Some(entity)), .. } = self.seed else { return change };
        let rate = self.mean_rate_of_measure(entity, tensor);
        let less = self.push(Operator::Scale(rate, tensor), shape.clone(), tensor);
        let less = self.push(Operator::Negate(less), shape, tensor);
        self.sum(change, Some(less))
    }

    /// d mean(e) = mean(de): a constant in space.
    fn cell_mean(&mut self, tensor: Tensor, a: Tensor) -> Option<Tensor> {
        if matches!(self.seed, Seed::Along(_)) {
            return None;
        }
        if self.by_shape() {
            self.diagnostics.error_with_help(
                self.arena.span(tensor),
                "the derivative of a mean over a cell by the shape is not available",
                "give the mean a field of degree 0: an unknown `J`, or `J` and a multiplier `p` in an energy",
            );
            return None;
        }
        let change = self.derive(a)?;
        CellMeans::new(self.arena, self.fields, self.diagnostics).of(change)
    }

    fn no_third_derivative(&mut self, tensor: Tensor) {
        let (message, help) = match self.along_surface {
            // What is written is a second derivative: the third one comes from the motion of the pair.
            true => (
                "where pairs slide, what is read at the opposite point is differentiated once more, and third derivatives of a field are not available",
                "read second derivatives at the own point, `this(hess(u))`, or take pairs of fixed points, `integral(Touch, ..)`; or make a derivative an unknown of its own",
            ),
            false => (
                "third derivatives of a field are not available",
                "second derivatives are the highest, `hess(u)`: for more, make a derivative an unknown of its own",
            ),
        };
        self.diagnostics.error_with_help(self.arena.span(tensor), message, help);
    }

    fn by_shape(&self) -> bool {
        matches!(self.seed, Seed::Toward { variable: Variable::Shape(_), .. })
    }

    /// Fixes the last axis.
    fn column(&mut self, full: Tensor, shape: &[usize], axis: usize, origin: Tensor) -> Tensor {
        let Some((first, rest)) = shape.split_first() else {
            return self.push(Operator::Component(full, vec![axis]), vec![], origin);
        };
        let inner = [rest, &[self.dimension]].concat();
        let mut rows = Vec::new();
        for row in 0..*first {
            let slice = self.push(Operator::Component(full, vec![row]), inner.clone(), origin);
            rows.push(self.column(slice, rest, axis, origin));
        }
        self.push(Operator::Stack(rows), shape.to_vec(), origin)
    }

    fn geometry(&mut self, tensor: Tensor, geometry: Geometry) -> Option<Tensor> {
        let axis = match self.seed {
            Seed::Along(axis) => axis,
            Seed::Toward { variable: Variable::Shape(_), .. } => {
                return self.geometry_as_points_move(tensor, geometry);
            }
            Seed::Toward { variable: Variable::Size(varied), direction, .. } => {
                return (varied == geometry).then_some(direction);
            }
            Seed::Toward { .. } => return None,
        };
        match geometry {
            // Constant on the cell.
            Geometry::Diameter | Geometry::CellVolume | Geometry::FacetArea => None,
            Geometry::Position => {
                let mut entries = Vec::new();
                for entry in 0..self.dimension {
                    let value = if entry == axis { 1.0 } else { 0.0 };
                    entries.push(self.push(Operator::Number(value), vec![], tensor));
                }
                Some(self.push(Operator::Stack(entries), vec![self.dimension], tensor))
            }
            Geometry::Gap | Geometry::Toward | Geometry::OppositePosition | Geometry::OppositeNormal => {
                self.no_gradient_across(tensor);
                None
            }
            Geometry::Normal if self.along_surface => {
                let matrix = vec![self.dimension; 2];
                let turning = self.push(Operator::Geometry(Geometry::ShapeOperator), matrix, tensor);
                Some(self.column(turning, &[self.dimension], axis, tensor))
            }
            Geometry::ShapeOperator => {
                self.diagnostics.error_with_help(
                    self.arena.span(tensor),
                    "where pairs slide, the normal at the opposite point is differentiated once only",
                    "a form that is tested by a test function needs one derivative of it, an energy two",
                );
                None
            }
            Geometry::Normal | Geometry::Curvature => {
                let message = "the gradient of the normal is not available";
                self.diagnostics.error_with_help(
                    self.arena.span(tensor),
                    message,
                    "its trace is the built-in `curvature`",
                );
                None
            }
        }
    }

    /// d(a ∘ b) = da ∘ b + a ∘ db for the bilinear operators.
    fn product(
        &mut self,
        tensor: Tensor,
        a: Tensor,
        b: Tensor,
        make: fn(Tensor, Tensor) -> Operator,
    ) -> Option<Tensor> {
        let shape = self.arena.shape(tensor).to_vec();
        let (da, db) = (self.derive(a), self.derive(b));
        let first = da.map(|da| self.push(make(da, b), shape.clone(), tensor));
        let second = db.map(|db| self.push(make(a, db), shape.clone(), tensor));
        self.sum(first, second)
    }

    /// d(a/b) = (da − (a/b) db) / b
    fn quotient(
        &mut self,
        tensor: Tensor,
        a: Tensor,
        b: Tensor,
        make: fn(Tensor, Tensor) -> Operator,
    ) -> Option<Tensor> {
        let shape = self.arena.shape(tensor).to_vec();
        let (da, db) = (self.derive(a), self.derive(b));
        let second = db.map(|db| {
            let scaled = self.push(Operator::Scale(db, tensor), shape.clone(), tensor);
            self.push(Operator::Negate(scaled), shape.clone(), tensor)
        });
        let numerator = self.sum(da, second)?;
        Some(self.push(make(numerator, b), shape, tensor))
    }

    /// 1×1: d 1 = 0. 2×2: cof A = tr A I − Aᵀ is linear. 3×3: cof A is quadratic.
    fn cofactor(&mut self, tensor: Tensor, a: Tensor) -> Option<Tensor> {
        let da = self.derive(a)?;
        let shape = self.arena.shape(a).to_vec();
        match shape[0] {
            1 => None,
            2 => Some(self.push(Operator::Cofactor(da), shape, tensor)),
            _ => Some(self.push(Operator::MixedCofactor(a, da), shape, tensor)),
        }
    }

    fn extremum(&mut self, tensor: Tensor, a: Tensor, b: Tensor, maximum: bool) -> Option<Tensor> {
        let (da, db) = (self.derive(a), self.derive(b));
        let truth = Truth::Compare(Comparison::Greater, a, b);
        if maximum { self.choose(truth, da, db, tensor) } else { self.choose(truth, db, da, tensor) }
    }

    fn choose(
        &mut self,
        truth: Truth,
        a: Option<Tensor>,
        b: Option<Tensor>,
        tensor: Tensor,
    ) -> Option<Tensor> {
        if a.is_none() && b.is_none() {
            return None;
        }
        let shape = self.arena.shape(tensor).to_vec();
        let mut or_zero = |branch: Option<Tensor>| {
            branch.unwrap_or_else(|| self.push(Operator::Zero, shape.clone(), tensor))
        };
        let (a, b) = (or_zero(a), or_zero(b));
        Some(self.push(Operator::Select(truth, a, b), shape, tensor))
    }

    fn sum(&mut self, a: Option<Tensor>, b: Option<Tensor>) -> Option<Tensor> {
        match (a, b) {
            (Some(a), Some(b)) => {
                let shape = self.arena.shape(a).to_vec();
                Some(self.push(Operator::Add(a, b), shape, a))
            }
            (one, None) | (None, one) => one,
        }
    }

    fn push(&mut self, operator: Operator, shape: Vec<usize>, origin: Tensor) -> Tensor {
        let span = self.arena.span(origin);
        self.arena.share(operator, shape, span)
    }
}
