//! The numbers around a walk, and how they move: by an infinitesimal along an axis, or along a direction of a variable.

use std::collections::HashMap;
use std::rc::Rc;

use super::evaluator::{Evaluator, Move};
use super::number::Number;
use super::point::{Jet, MEAN};
use crate::check::Content;
use crate::tensor::{FieldRole, Geometry, Side, Tensor, Variable};

pub(super) const SIDES: [Side; 2] = [Side::This, Side::Other];

/// The values of the symbols of a form. Moving them by an infinitesimal is how a
/// derivative is taken.
#[derive(Clone)]
pub(super) struct Environment {
    /// Per side, field and order of derivative.
    pub fields: [Vec<Rc<Vec<Vec<Number>>>>; 2],
    /// From which side the expression at hand is seen.
    pub side: Side,
    pub parameters: Vec<Rc<Vec<Number>>>,
    /// Per side, from which the same point may move elsewhere.
    pub position: [Vec<Number>; 2],
    /// Per side, as this side's outward normal.
    pub normal: [Vec<Number>; 2],
    /// Diameter, cell volume and facet area, per side.
    pub sizes: [[Number; 3]; 2],
    /// Perturbations of intermediate results.
    pub added: Rc<HashMap<Tensor, Vec<Number>>>,
    /// Number of infinitesimals in use.
    pub level: usize,
}

impl Evaluator<'_> {
    pub(super) fn start(&self) -> Environment {
        let numbers = |list: &Vec<f64>| list.iter().map(|value| Number::real(*value)).collect();
        let jet = |jet: &Jet| Rc::new(jet.iter().map(numbers).collect());
        Environment {
            fields: [0, 1].map(|side| self.point.fields[side].iter().map(jet).collect()),
            side: Side::This,
            parameters: self.point.parameters.iter().map(|list| Rc::new(numbers(list))).collect(),
            position: [(); 2].map(|()| numbers(&self.point.position)),
            normal: [(); 2].map(|()| numbers(&self.point.normal)),
            sizes: [0, 1].map(|side| {
                let point = self.point;
                [point.diameter[side], point.cell_volume[side], point.facet_area].map(Number::real)
            }),
            added: Rc::default(),
            level: 0,
        }
    }

    /// A form's test functions are fields of their own; the test function of an energy is a direction.
    pub(super) fn tested<'m>(&self, test: Move<'m>) -> (Environment, Vec<Move<'m>>) {
        let mut around = self.start();
        if let Content::Energy(_) = self.checked.content {
            return (around, vec![test]);
        }
        for (index, field) in self.checked.fields.iter().enumerate() {
            if matches!(field.role, FieldRole::Test(_)) {
                for side in SIDES {
                    let chosen = (index, side) == (test.0, test.1);
                    let orders =
                        Rc::make_mut(&mut around.fields[side as usize][index]).iter_mut().zip(test.2);
                    for (numbers, jet) in orders {
                        for (entry, number) in numbers.iter_mut().enumerate() {
                            *number = Number::real(if chosen { jet[entry] } else { 0.0 });
                        }
                    }
                }
            }
        }
        (around, vec![])
    }

    /// After a step along an axis: fields move by their gradients, the position by a unit vector.
    pub(super) fn shifted(&self, axis: usize, around: &Environment) -> Environment {
        let (dimension, level) = (self.checked.dimension, around.level);
        self.budget.spend_on_environment(around);
        let mut shifted = around.clone();
        let jets = around.fields.iter().flatten().zip(shifted.fields.iter_mut().flatten());
        for (jet, moved) in jets {
            for (order, numbers) in Rc::make_mut(moved).iter_mut().enumerate().take(MEAN) {
                for (entry, number) in numbers.iter_mut().enumerate() {
                    let unknown = Number::real(f64::NAN);
                    let next = jet.get(order + 1).filter(|_| order + 1 < MEAN);
                    let next = next.map_or(&unknown, |next| &next[entry * dimension + axis]);
                    *number = number.moved(next, level);
                }
            }
        }
        for (position, before) in shifted.position.iter_mut().zip(&around.position) {
            position[axis] = before[axis].moved(&Number::real(1.0), level);
        }
        shifted.level += 1;
        shifted
    }

    /// The environment in which fields are what their means are: that of an affine expression is its mean.
    pub(super) fn averaged(&self, around: &Environment) -> Environment {
        self.budget.spend_on_environment(around);
        let mut averaged = around.clone();
        for jet in averaged.fields.iter_mut().flatten() {
            let jet = Rc::make_mut(jet);
            let means = [jet[MEAN].clone(), jet[MEAN + 1].clone()];
            for numbers in &mut jet[means.len()..MEAN] {
                numbers.fill(Number::real(f64::NAN));
            }
            jet[..means.len()].clone_from_slice(&means);
        }
        averaged
    }

    /// The environment after a variable has moved by a direction, given as far as it is needed.
    pub(super) fn moved(
        &self,
        around: &Environment,
        variable: Variable,
        directions: &[Vec<Vec<Number>>; 2],
    ) -> Environment {
        self.budget.spend_on_environment(around);
        let (mut moved, level) = (around.clone(), around.level);
        moved.level += 1;
        let shift = |numbers: &mut Vec<Number>, direction: &[Number]| {
            numbers
                .iter_mut()
                .zip(direction)
                .for_each(|(number, direction)| *number = number.moved(direction, level));
        };
        match variable {
            Variable::Field(field) => {
                for (fields, direction) in moved.fields.iter_mut().zip(directions) {
                    let jet = Rc::make_mut(&mut fields[field]).iter_mut();
                    jet.zip(direction).for_each(|(numbers, direction)| shift(numbers, direction));
                }
            }
            Variable::Parameter(index) => {
                shift(Rc::make_mut(&mut moved.parameters[index]), &directions[around.side as usize][0]);
            }
            Variable::Node(node) => {
                let direction = &directions[around.side as usize][0];
                let zero = vec![Number::real(0.0); direction.len()];
                shift(Rc::make_mut(&mut moved.added).entry(node).or_insert(zero), direction);
            }
            Variable::Size(size) => {
                for (sizes, direction) in moved.sizes.iter_mut().zip(directions) {
                    let number = &mut sizes[index_of_size(size)];
                    *number = number.moved(&direction[0][0], level);
                }
            }
            Variable::Shape(_) => return self.after_points_moved(around, directions),
        }
        moved
    }
}

/// Among [`Environment::sizes`].
pub(super) fn index_of_size(size: Geometry) -> usize {
    match size {
        Geometry::Diameter => 0,
        Geometry::CellVolume => 1,
        _ => 2,
    }
}
