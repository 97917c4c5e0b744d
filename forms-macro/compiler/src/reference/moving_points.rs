//! Inputs of a form at a point after all points have moved by ε Θ, at fixed reference coordinates. Nothing is
//! linearised by hand: the map's gradient F = I + ε ∇Θ is inverted, and normals and measures are pulled through it.

use std::rc::Rc;

use super::environment::{Environment, SIDES};
use super::evaluator::Evaluator;
use super::matrices::{cofactor, determinant, identity, matrix_product, pairs, total, transposed};
use super::number::Number;
use super::point::MEAN;
use crate::parse::syntax::Entity;
use crate::tensor::{FieldRole, Function, Tensor};

/// A vector field and its derivatives at the two sides of a point.
pub type Directions = [Vec<Vec<Number>>; 2];

impl Evaluator<'_> {
    /// The number of derivatives of Θ that a derivative by the shape reads.
    pub(super) fn orders_of_shape(&self, expression: Tensor) -> usize {
        let carried = |field: usize| self.checked.fields[field].role != FieldRole::Given;
        self.order_of(expression, &carried).unwrap_or(0).max(1)
    }

    /// The environment after the points have moved.
    pub(super) fn after_points_moved(&self, around: &Environment, directions: &Directions) -> Environment {
        let (dimension, level) = (self.checked.dimension, around.level);
        let mut moved = around.clone();
        moved.level += 1;
        for side in SIDES {
            let (index, direction) = (side as usize, &directions[side as usize]);
            let gradient = self.gradient_of_map(direction, level);
            let inverse = inverse(&gradient, dimension);
            for (position, by) in moved.position[index].iter_mut().zip(&direction[0]) {
                *position = position.moved(by, level);
            }
            let turned = matrix_product(&cofactor(&gradient, dimension), &around.normal[index], dimension);
            let length = length(&turned);
            moved.normal[index] = turned.iter().map(|entry| entry.over(&length)).collect();
            let jets = around.fields[index].iter().zip(&mut moved.fields[index]);
            for ((jet, target), field) in jets.zip(&self.checked.fields) {
                *target = Rc::new(match field.role {
                    FieldRole::Given => seen_from_moved_point(jet, &direction[0], level),
                    _ => self.carried_along(jet, direction, &inverse, level),
                });
            }
        }
        moved
    }

    /// The measure after the points have moved, divided by what it was.
    pub(super) fn measure(&self, entity: Entity, around: &Environment, directions: &Directions) -> Number {
        let dimension = self.checked.dimension;
        let gradient = self.gradient_of_map(&directions[0], around.level);
        match entity {
            Entity::Cells => determinant(&gradient, dimension),
            // Nanson's formula.
            Entity::Facets | Entity::InteriorFacets | Entity::Pairs | Entity::Interface => {
                length(&matrix_product(&cofactor(&gradient, dimension), &around.normal[0], dimension))
            }
        }
    }

    /// I + ε ∇Θ
    fn gradient_of_map(&self, direction: &[Vec<Number>], level: usize) -> Vec<Number> {
        let unit = identity(self.checked.dimension);
        unit.iter().zip(&direction[1]).map(|(entry, by)| entry.moved(by, level)).collect()
    }

    /// A field with fixed nodal values: ∇ → ∇ F⁻¹, once per order.
    fn carried_along(
        &self,
        jet: &[Vec<Number>],
        direction: &[Vec<Number>],
        inverse: &[Number],
        level: usize,
    ) -> Vec<Vec<Number>> {
        let dimension = self.checked.dimension;
        let mut moved: Vec<Vec<Number>> =
            jet.iter().map(|numbers| vec![Number::real(f64::NAN); numbers.len()]).collect();
        moved[0] = jet[0].clone();
        moved[1] = matrix_product(&jet[1], inverse, dimension);
        let Some(bent) = direction.get(2) else { return moved };
        let components = jet[0].len();
        // ∂_m of the reference point, of ∇w F⁻¹.
        let mut along = vec![Number::real(0.0); components * dimension * dimension];
        for m in 0..dimension {
            let slope: Vec<Number> = (0..dimension * dimension)
                .map(|entry| Number::real(0.0).moved(&bent[entry * dimension + m], level))
                .collect();
            let change = matrix_product(&matrix_product(inverse, &slope, dimension), inverse, dimension);
            let change: Vec<Number> = change.iter().map(|entry| entry.scaled(-1.0)).collect();
            let second: Vec<Number> =
                (0..components * dimension).map(|entry| jet[2][entry * dimension + m].clone()).collect();
            let whole = pairs(
                &matrix_product(&second, inverse, dimension),
                &matrix_product(&jet[1], &change, dimension),
                Number::plus,
            );
            for (entry, number) in whole.into_iter().enumerate() {
                along[entry * dimension + m] = number;
            }
        }
        moved[2] = matrix_product(&along, inverse, dimension);
        moved
    }
}

/// Data fixed in space, seen from a point that has moved by ε Θ.
fn seen_from_moved_point(jet: &[Vec<Number>], direction: &[Number], level: usize) -> Vec<Vec<Number>> {
    let dimension = direction.len();
    let moved = jet.iter().enumerate().map(|(order, numbers)| {
        let entry = |(entry, number): (usize, &Number)| match jet.get(order + 1).filter(|_| order + 1 < MEAN)
        {
            Some(next) => {
                let slopes = &next[entry * dimension..(entry + 1) * dimension];
                number.moved(&total(&pairs(slopes, direction, Number::times)), level)
            }
            None => Number::real(f64::NAN),
        };
        numbers.iter().enumerate().map(entry).collect()
    });
    moved.collect()
}

fn inverse(matrix: &[Number], size: usize) -> Vec<Number> {
    let whole = determinant(matrix, size);
    let adjugate = transposed(&cofactor(matrix, size), &[size, size]);
    adjugate.iter().map(|entry| entry.over(&whole)).collect()
}

fn length(vector: &[Number]) -> Number {
    super::functions::function(Function::Sqrt, &total(&pairs(vector, vector, Number::times)))
}
