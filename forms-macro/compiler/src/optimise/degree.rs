//! Polynomial degree of a density, for the choice of a quadrature rule: the largest of several sums of
//! field degrees. What is not a polynomial is estimated as in UFL.

use std::collections::HashMap;

use crate::differentiate::Source;
use crate::sorted::SortedMap;
use crate::tensor::{Arena, Geometry, Operator, Tensor};

/// Contributions to a degree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// A field's derivative of an order.
    Field {
        field: usize,
        order: usize,
    },
    Position,
    Normal,
}

/// One sum: a constant and multiples of parts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DegreeSum {
    pub constant: usize,
    pub parts: SortedMap<Part, usize>,
}

/// The largest of these.
#[derive(Clone, Debug)]
pub struct Degree(pub Vec<DegreeSum>);

/// Largest number of sums that are kept; the others are replaced by the constant 2, a guess.
const MOST: usize = 12;

/// No rule has more than this degree, and no sum of degrees runs over.
const LARGEST: usize = 1000;

impl Degree {
    pub fn constant(value: usize) -> Self {
        Degree(vec![DegreeSum { constant: value, parts: SortedMap::new() }])
    }

    fn part(part: Part) -> Self {
        Degree(vec![DegreeSum { constant: 0, parts: SortedMap::from([(part, 1)]) }])
    }

    pub fn largest(mut self, other: Self) -> Self {
        for sum in other.0 {
            if !self.0.iter().any(|known| dominates(known, &sum)) {
                self.0.retain(|known| !dominates(&sum, known));
                self.0.push(sum);
            }
        }
        self.0.truncate(MOST);
        self
    }

    /// With a factor of some degree.
    pub fn raised(self, by: usize) -> Self {
        self.plus(Degree::constant(by))
    }

    fn plus(self, other: Self) -> Self {
        let mut result = Degree(vec![]);
        for a in &self.0 {
            for b in &other.0 {
                let mut sum = a.clone();
                sum.constant = (sum.constant + b.constant).min(LARGEST);
                for (part, count) in &b.parts {
                    let total = sum.parts.get_or_default(*part);
                    *total = (*total + count).min(LARGEST);
                }
                result = result.largest(Degree(vec![sum]));
            }
        }
        result
    }

    /// With one factor of a field replaced by the direction in which the field varies: no more than before except for a
    /// direction of a richer space.
    fn toward(self, varied: usize, direction: usize) -> Self {
        let sums = self.0.iter().flat_map(|sum| {
            let orders = sum.parts.keys().filter_map(move |part| match part {
                Part::Field { field, order } if *field == varied => Some(*order),
                _ => None,
            });
            orders.map(move |order| {
                let mut moved = sum.clone();
                let from = Part::Field { field: varied, order };
                match moved.parts.get_mut(&from) {
                    Some(count) if *count > 1 => *count -= 1,
                    _ => {
                        moved.parts.remove(&from);
                    }
                }
                *moved.parts.get_or_default(Part::Field { field: direction, order }) += 1;
                Degree(vec![moved])
            })
        });
        sums.fold(Degree(vec![]), Degree::largest)
    }

    fn times(self, factor: usize) -> Self {
        (1..factor).fold(self.clone(), |sum, _| sum.plus(self.clone()))
    }
}

fn dominates(a: &DegreeSum, b: &DegreeSum) -> bool {
    a.constant >= b.constant
        && b.parts.iter().all(|(part, count)| a.parts.get(part).is_some_and(|other| other >= count))
}

/// Degrees of the nodes of an arena, each computed once.
pub struct Degrees<'a> {
    arena: &'a Arena,
    /// See [`crate::differentiate::Derived::sources`].
    sources: &'a HashMap<Tensor, Vec<Source>>,
    known: SortedMap<Tensor, Degree>,
}

impl<'a> Degrees<'a> {
    pub fn new(arena: &'a Arena, sources: &'a HashMap<Tensor, Vec<Source>>) -> Self {
        Degrees { arena, sources, known: SortedMap::new() }
    }

    /// Of a density that is integrated: where it is a derivative, that of what was differentiated, so that both have the same
    /// points.
    pub fn of_integrand(&mut self, density: Tensor) -> Degree {
        let sources = self.sources;
        let Some(sources) = sources.get(&density) else { return self.of(density) };
        sources.iter().fold(Degree::constant(0), |all, source| {
            let degree = self.of(source.density);
            all.largest(source.directions.iter().fold(degree, |degree, (varied, direction)| {
                let moved = degree.clone().toward(*varied, *direction);
                degree.largest(moved)
            }))
        })
    }

    /// Whether a density is a derivative of an integral over contact pairs by the fields that displace them, or by the shape, without the
    /// motion of their points.
    pub fn is_by_displacement(&self, density: Tensor, displacement: &[usize]) -> bool {
        let sources = self.sources.get(&density).into_iter().flatten();
        let by = |source: &Source| source.directions.iter().any(|(varied, _)| displacement.contains(varied));
        sources.into_iter().any(|source| !source.moves && (source.by_shape || by(source)))
    }

    pub fn of(&mut self, tensor: Tensor) -> Degree {
        if let Some(known) = self.known.get(&tensor) {
            return known.clone();
        }
        let degree = self.estimate(tensor);
        self.known.insert(tensor, degree.clone());
        degree
    }

    fn estimate(&mut self, tensor: Tensor) -> Degree {
        use Operator::*;
        let arena = self.arena;
        let zero = Degree::constant(0);
        match &arena.node(tensor).operator {
            Number(_) | Zero | Identity | SymmetricIdentity | Parameter(_) => zero,
            Field { field, order } => Degree::part(Part::Field { field: *field, order: *order }),
            Geometry(geometry) | Sliding(geometry, _) => match geometry {
                self::Geometry::Position | self::Geometry::OppositePosition | self::Geometry::Gap => {
                    Degree::part(Part::Position)
                }
                _ if geometry.varies() => Degree::part(Part::Normal),
                _ => zero,
            },
            Negate(a) | Map(_, a) | Component(a, _) | Slice(a, _) | Restrict(_, a) | Opposite(a, _) => {
                self.of(*a)
            }
            // The same number at all points.
            CellMean(_) => zero,
            // What is integrated is the operand.
            FacetMean(a) => self.of(*a),
            // As |a| is where a is one number.
            Norm(a) => self.of(*a),
            Add(a, b) | Minimum(a, b) | Maximum(a, b) | Select(_, a, b) => self.of(*a).largest(self.of(*b)),
            Scale(a, b)
            | Contract(a, b)
            | DoubleContract(a, b)
            | Cross(a, b)
            | MixedCofactor(a, b)
            | Inner(a, b)
            | Outer(a, b)
            | Divide(a, b)
            | DivideOrZero(a, b) => self.of(*a).plus(self.of(*b)),
            Atan2(a, b) => self.of(*a).largest(self.of(*b)).plus(Degree::constant(2)),
            Stack(entries) => entries.iter().fold(zero, |all, entry| all.largest(self.of(*entry))),
            Determinant(a) | Inverse(a) => self.of(*a).times(arena.shape(*a)[0]),
            Cofactor(a) => self.of(*a).times(arena.shape(*a)[0].max(2) - 1),
            Apply(function, a) => {
                use crate::tensor::Function::*;
                match function {
                    Abs | PositivePart | NegativePart => self.of(*a),
                    Sign | Heaviside => zero,
                    _ => self.of(*a).plus(Degree::constant(2)),
                }
            }
            Power(a, b) => match arena.node(*b).operator {
                Number(exponent) if exponent >= 1.0 && exponent == exponent.trunc() && exponent < 8.0 => {
                    self.of(*a).times(exponent as usize)
                }
                _ => self.of(*a).plus(Degree::constant(2)),
            },
            External { arguments, .. } => {
                let largest = arguments.iter().fold(zero, |all, argument| all.largest(self.of(*argument)));
                largest.plus(Degree::constant(2))
            }
            Gradient(_) | Partial(..) | Gateaux { .. } | Named(_) => zero,
        }
    }
}
