//! The walk: [`CheckedFunction`] → numbers at a [`Point`].

use std::cell::Cell;
use std::collections::HashMap;
use std::rc::Rc;

use super::budget::Budget;
use super::environment::{Environment, SIDES, index_of_size};
use super::functions;
use super::matrices::*;
use super::number::Number;
use super::point::{Jet, MEAN, Point};
use crate::check::{CheckedFunction, Content, Term};
use crate::parse::syntax::Comparison;
use crate::tensor::{Function, Geometry, NEARLY_ZERO, Operator, Side, Tensor, Truth, Variable};

/// Condition of the numbers of a walk.
#[derive(Clone, Copy, Debug)]
pub struct Condition {
    /// The smallest distance of an argument from a kink, a jump or a singularity.
    pub distance: f64,
    /// The largest number that occurred; infinite where the walk was given up.
    pub magnitude: f64,
}

/// A field moves on one side of a facet: its index, the side, where to.
pub type Move<'a> = (usize, Side, &'a Jet);

/// Known results, per node and side.
type Known = HashMap<(Tensor, Side), Rc<Vec<Number>>>;

/// Evaluates one function at one point.
pub struct Evaluator<'a> {
    pub(super) checked: &'a CheckedFunction,
    pub(super) point: &'a Point,
    condition: Cell<Condition>,
    pub(super) budget: &'a Budget,
}

impl<'a> Evaluator<'a> {
    /// Gives up when its budget is exhausted: what it finds then means nothing, and its condition has an infinite magnitude.
    pub fn new(checked: &'a CheckedFunction, point: &'a Point, budget: &'a Budget) -> Self {
        let condition = Cell::new(Condition { distance: f64::INFINITY, magnitude: 0.0 });
        Evaluator { checked, point, condition, budget }
    }

    /// Of everything evaluated so far.
    pub fn condition(&self) -> Condition {
        self.condition.get()
    }

    /// Components of a derived field.
    pub fn components(&self) -> Vec<f64> {
        match self.checked.content {
            Content::Value(value) => {
                self.walk(value, &self.start()).iter().map(|entry| entry.value()).collect()
            }
            _ => vec![],
        }
    }

    /// The density of an energy or functional on a region.
    pub fn density(&self, region: usize) -> f64 {
        self.sum(region, &self.start(), &[])
    }

    /// The residual's density on a region, for a test function (by field index for a form, by the
    /// unknown that is varied for an energy) with this jet on this side and all others zero.
    pub fn residual(&self, region: usize, test: Move) -> f64 {
        let (around, moves) = self.tested(test);
        self.sum(region, &around, &moves)
    }

    /// The derivative of [`Evaluator::residual`] as an unknown (by field index) moves along a jet.
    pub fn tangent(&self, region: usize, test: Move, trial: Move) -> f64 {
        let (around, mut moves) = self.tested(test);
        moves.push(trial);
        self.sum(region, &around, &moves)
    }

    /// Is there a second side to this function?
    pub fn reads_other_side(checked: &CheckedFunction) -> bool {
        let terms = match &checked.content {
            Content::Form(terms) | Content::Energy(terms) | Content::Functional(terms) => &terms[..],
            Content::Value(_) => &[],
        };
        let roots: Vec<Tensor> = terms.iter().map(|term| term.density).collect();
        let is_other =
            |node: &Tensor| matches!(checked.arena.node(*node).operator, Operator::Restrict(Side::Other, _));
        checked.arena.reachable(&roots).iter().any(is_other)
    }

    /// Σ of a region's densities, differentiated once along each of the moves.
    fn sum(&self, region: usize, around: &Environment, moves: &[Move]) -> f64 {
        let mut around = around.clone();
        for (field, side, jet) in moves {
            let moving = Rc::make_mut(&mut around.fields[*side as usize][*field]);
            for (numbers, direction) in moving.iter_mut().zip(*jet) {
                for (number, direction) in numbers.iter_mut().zip(direction) {
                    *number = number.moved(&Number::real(*direction), around.level);
                }
            }
            around.level += 1;
        }
        let terms = match &self.checked.content {
            Content::Form(terms) | Content::Energy(terms) | Content::Functional(terms) => &terms[..],
            Content::Value(_) => &[],
        };
        let mut sum = 0.0;
        let mut known = Known::new();
        for Term { density, .. } in terms.iter().filter(|term| term.region == region) {
            let mut density = self.walk_known(*density, &around, &mut known)[0].clone();
            for level in (0..moves.len()).rev() {
                density = density.slope(level);
            }
            sum += density.value();
        }
        sum
    }

    /// Row-major components of a node.
    pub(super) fn walk(&self, tensor: Tensor, around: &Environment) -> Rc<Vec<Number>> {
        self.walk_known(tensor, around, &mut Known::new())
    }

    fn walk_known(&self, tensor: Tensor, around: &Environment, known: &mut Known) -> Rc<Vec<Number>> {
        if let Some(known) = known.get(&(tensor, around.side)) {
            return known.clone();
        }
        if self.budget.is_exhausted() {
            self.condition.set(Condition { magnitude: f64::INFINITY, ..self.condition.get() });
            let count = self.checked.arena.shape(tensor).iter().product();
            return Rc::new(vec![Number::real(f64::NAN); count]);
        }
        let mut numbers = self.rule(tensor, around, known);
        self.budget.spend(&numbers);
        if let Some(added) = around.added.get(&tensor) {
            numbers.iter_mut().zip(added).for_each(|(number, added)| *number = number.plus(added));
        }
        let mut condition = self.condition.get();
        for number in &numbers {
            let magnitude = if number.is_finite() { number.magnitude() } else { f64::INFINITY };
            condition.magnitude = condition.magnitude.max(magnitude);
        }
        self.condition.set(condition);
        let numbers = Rc::new(numbers);
        known.insert((tensor, around.side), Rc::clone(&numbers));
        numbers
    }

    /// Notes how far an argument is from a kink. An argument that nothing can change has none.
    fn note(&self, distance: f64, arguments: &[Tensor]) {
        let varies = |node: &Tensor| {
            use Operator::{Field, Geometry, Parameter};
            matches!(self.checked.arena.node(*node).operator, Field { .. } | Geometry(_) | Parameter(_))
        };
        let mut condition = self.condition.get();
        if distance < condition.distance && self.checked.arena.reachable(arguments).iter().any(varies) {
            condition.distance = distance;
            self.condition.set(condition);
        }
    }

    fn rule(&self, tensor: Tensor, around: &Environment, known: &mut Known) -> Vec<Number> {
        use Operator::*;
        let (arena, dimension) = (&self.checked.arena, self.checked.dimension);
        let shape = arena.shape(tensor).to_vec();
        let count: usize = shape.iter().product();
        let mut walk = |operand: Tensor| self.walk_known(operand, around, known);
        #[allow(unreachable_patterns)]
        match &arena.node(tensor).operator {
            Number(value) => vec![self::Number::real(*value)],
            Zero => vec![self::Number::real(0.0); count],
            Identity if shape.len() == 4 => identity_of_tensors(shape[0], 1.0, 0.0),
            Identity => identity(shape[0]),
            SymmetricIdentity => identity_of_tensors(shape[0], 0.5, 0.5),
            Parameter(index) => around.parameters[*index].to_vec(),
            Field { field, order } => around.fields[around.side as usize][*field][*order].clone(),
            Restrict(side, a) => {
                self.walk_known(*a, &Environment { side: *side, ..around.clone() }, known).to_vec()
            }
            CellMean(a) => self.walk(*a, &self.averaged(around)).to_vec(),
            // On a facet with one point.
            FacetMean(a) => walk(*a).to_vec(),
            Geometry(geometry) => self.geometry(*geometry, around),
            Add(a, b) => pairs(&walk(*a), &walk(*b), self::Number::plus),
            Negate(a) => walk(*a).iter().map(|a| a.scaled(-1.0)).collect(),
            Scale(factor, a) => {
                let factor = walk(*factor)[0].clone();
                walk(*a).iter().map(|a| a.times(&factor)).collect()
            }
            Divide(a, divisor) => {
                let number = walk(*divisor)[0].clone();
                self.note(number.value().abs(), &[*divisor]);
                walk(*a).iter().map(|a| a.over(&number)).collect()
            }
            DivideOrZero(a, divisor) => {
                let number = walk(*divisor)[0].clone();
                self.note(number.value().abs(), &[*divisor]);
                if number.value() <= NEARLY_ZERO {
                    return vec![self::Number::real(0.0); count];
                }
                walk(*a).iter().map(|a| a.over(&number)).collect()
            }
            DoubleContract(a, b) => {
                let inner = arena.shape(*b)[..2].iter().product();
                matrix_product(&walk(*a), &walk(*b), inner)
            }
            Cross(a, b) => cross(&walk(*a), &walk(*b)),
            Norm(a) => {
                let numbers = walk(*a);
                let square = total(&pairs(&numbers, &numbers, self::Number::times));
                self.note(square.value().sqrt(), &[*a]);
                vec![functions::function(Function::Sqrt, &square)]
            }
            Slice(a, selections) => {
                let entries = chosen(arena.shape(*a), selections);
                let numbers = walk(*a);
                entries.into_iter().map(|entry| numbers[entry].clone()).collect()
            }
            Contract(a, b) => matrix_product(&walk(*a), &walk(*b), arena.shape(*b)[0]),
            Inner(a, b) => vec![total(&pairs(&walk(*a), &walk(*b), self::Number::times))],
            Outer(a, b) => {
                let (first, second) = (walk(*a), walk(*b));
                first.iter().flat_map(|a| second.iter().map(|b| a.times(b))).collect()
            }
            Map(map, a) => linear_map(*map, &walk(*a), arena.shape(*a)),
            Determinant(a) => vec![determinant(&walk(*a), arena.shape(*a)[0])],
            Cofactor(a) => cofactor(&walk(*a), shape[0]),
            Inverse(a) => {
                let numbers = walk(*a);
                let determinant = determinant(&numbers, shape[0]);
                self.note(determinant.value().abs(), &[*a]);
                let cofactor = transposed(&cofactor(&numbers, shape[0]), &shape);
                cofactor.iter().map(|entry| entry.over(&determinant)).collect()
            }
            Component(a, indices) => {
                let start =
                    indices.iter().zip(arena.shape(*a)).fold(0, |start, (i, extent)| start * extent + i);
                walk(*a)[start * count..(start + 1) * count].to_vec()
            }
            Stack(entries) => entries.iter().flat_map(|entry| walk(*entry).to_vec()).collect(),
            Apply(function, a) => {
                let number = walk(*a)[0].clone();
                self.note(functions::distance_from_kink(*function, number.value()), &[*a]);
                vec![functions::function(*function, &number)]
            }
            Power(a, b) => {
                let (base, exponent) = (walk(*a)[0].clone(), walk(*b)[0].clone());
                let whole = exponent.is_real() && exponent.value().fract() == 0.0 && exponent.value() >= 0.0;
                self.note(if whole { f64::INFINITY } else { base.value().abs() }, &[*a]);
                vec![functions::power(&base, &exponent)]
            }
            Atan2(a, b) => {
                let (first, second) = (walk(*a)[0].clone(), walk(*b)[0].clone());
                self.note(functions::distance_from_cut(first.value(), second.value()), &[*a, *b]);
                vec![functions::angle(&first, &second)]
            }
            Minimum(a, b) | Maximum(a, b) => {
                let (first, second) = (walk(*a)[0].clone(), walk(*b)[0].clone());
                self.note((first.value() - second.value()).abs(), &[*a, *b]);
                let greater = first.value() > second.value();
                let maximum = matches!(arena.node(tensor).operator, Maximum(..));
                vec![if greater == maximum { first } else { second }]
            }
            Select(truth, a, b) => {
                if self.truth(truth, &mut walk) {
                    walk(*a).to_vec()
                } else {
                    walk(*b).to_vec()
                }
            }
            Gradient(a) => {
                let along: Vec<Vec<self::Number>> =
                    (0..dimension).map(|axis| self.along(*a, axis, around)).collect();
                (0..count).map(|entry| along[entry % dimension][entry / dimension].clone()).collect()
            }
            Partial(a, variable) => {
                let variables = count / arena.shape(*a).iter().product::<usize>();
                let by: Vec<Vec<self::Number>> = (0..variables)
                    .map(|moved| {
                        let mut direction = vec![self::Number::real(0.0); variables];
                        direction[moved] = self::Number::real(1.0);
                        let direction = [vec![direction.clone()], vec![direction]];
                        self.slope(*a, &self.moved(around, *variable, &direction), around.level)
                    })
                    .collect();
                (0..count).map(|entry| by[entry % variables][entry / variables].clone()).collect()
            }
            Gateaux { expression, variable, direction } => {
                let orders = match variable {
                    Variable::Field(field) => self.order(*expression, *field).unwrap_or(0),
                    Variable::Shape(_) => self.orders_of_shape(*expression),
                    _ => 0,
                };
                let reads_means = self.reads_means(*expression);
                let direction = SIDES.map(|side| {
                    let around = Environment { side, ..around.clone() };
                    let mut jet = self.jet(*direction, orders, &around);
                    if reads_means {
                        // Entries between do not move.
                        jet.resize(MEAN, vec![]);
                        jet.extend(self.jet(*direction, 1, &self.averaged(&around)));
                    }
                    jet
                });
                let moved = self.moved(around, *variable, &direction);
                let Variable::Shape(Some(entity)) = variable else {
                    return self.slope(*expression, &moved, around.level);
                };
                let measure = self.measure(*entity, around, &direction);
                let integrand = self.walk(*expression, &moved);
                integrand.iter().map(|entry| entry.times(&measure).slope(around.level)).collect()
            }
            // An operator that is new: add its meaning here.
            other => panic!("the reference evaluator has no rule for {other:?}"),
        }
    }

    fn reads_means(&self, expression: Tensor) -> bool {
        let arena = &self.checked.arena;
        let is_mean = |node: Tensor| matches!(arena.node(node).operator, Operator::CellMean(_));
        arena.reachable(&[expression]).into_iter().any(is_mean)
    }

    fn geometry(&self, geometry: Geometry, around: &Environment) -> Vec<Number> {
        // The outward normal of the other cell is the opposite one.
        let (side, sign) = match around.side {
            Side::This => (0, 1.0),
            Side::Other => (1, -1.0),
        };
        match geometry {
            Geometry::Diameter | Geometry::CellVolume | Geometry::FacetArea => {
                vec![around.sizes[side][index_of_size(geometry)].clone()]
            }
            // Random forms have no contact pairs.
            Geometry::Gap
            | Geometry::Toward
            | Geometry::OppositePosition
            | Geometry::OppositeNormal
            | Geometry::ShapeOperator => {
                panic!("the reference evaluator has no contact pairs")
            }
            Geometry::Curvature => vec![Number::real(sign * self.point.curvature)],
            Geometry::Normal => around.normal[side].iter().map(|entry| entry.scaled(sign)).collect(),
            Geometry::Position => around.position[side].clone(),
        }
    }

    fn truth(&self, truth: &Truth, walk: &mut dyn FnMut(Tensor) -> Rc<Vec<Number>>) -> bool {
        match truth {
            Truth::Compare(comparison, a, b) => {
                let (left, right) = (walk(*a)[0].value(), walk(*b)[0].value());
                self.note((left - right).abs(), &[*a, *b]);
                match comparison {
                    Comparison::Less => left < right,
                    Comparison::LessEqual => left <= right,
                    Comparison::Greater => left > right,
                    Comparison::GreaterEqual => left >= right,
                    Comparison::Equal => left == right,
                    Comparison::NotEqual => left != right,
                }
            }
            Truth::And(first, second) => {
                let (first, second) = (self.truth(first, walk), self.truth(second, walk));
                first && second
            }
            Truth::Or(first, second) => {
                let (first, second) = (self.truth(first, walk), self.truth(second, walk));
                first || second
            }
            Truth::Not(inner) => !self.truth(inner, walk),
        }
    }
}
