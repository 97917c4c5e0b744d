//! The quadratic model of a criterion that its last changes give, and the minimum of that model between bounds.

use std::collections::VecDeque;

use super::bounds::Bounds;
use super::control_vectors::ControlVectors;
use crate::linear_algebra::vector::add_scaled;

/// A change is remembered if s·y is above this part of |s| |y|.
const CURVED: f64 = 1e-12;
/// Most faces of the bounds that are tried.
const FACES: usize = 50;
/// The slope of the model has to fall to this part of what it was on all controls between their bounds.
const FALLEN: f64 = 1e-8;
/// Armijo's part of the expected decrease.
const DECREASE: f64 = 1e-4;
/// Halvings of a step between bounds.
const HALVINGS: usize = 30;

/// g·d + ½ d·B d, with the matrix B of the method of Broyden, Fletcher, Goldfarb and Shanno from the last changes.
pub(super) struct Model {
    vectors: ControlVectors,
    most: usize,
    /// θ of B₀ = θ I.
    scale: f64,
    /// Changes s of the controls and y of the gradient, oldest first.
    changes: VecDeque<[Vec<f64>; 2]>,
    /// Of each change y and B s, with B as the earlier ones made it, divided by the roots of y·s and s·B s.
    terms: Vec<[Vec<f64>; 2]>,
}

impl Model {
    /// A model with nothing known except a scale.
    pub fn new(vectors: &ControlVectors, most: usize, scale: f64) -> Self {
        let vectors = vectors.clone();
        Model { vectors, most: most.max(1), scale, changes: VecDeque::new(), terms: vec![] }
    }

    /// Whether it knows no change.
    pub fn is_empty(&self) -> bool {
        self.changes.is_empty()
    }

    /// The model without any changes.
    pub fn restart(&mut self, scale: f64) {
        *self = Model::new(&self.vectors, self.most, scale);
    }

    /// A change for the model, which is kept if the gradient has grown along it.
    pub fn remember(&mut self, s: Vec<f64>, y: Vec<f64>) {
        let products = self.vectors.dots(&[(&s, &y), (&s, &s), (&y, &y)]);
        let (curvature, of_y) = (products[0], products[2]);
        if curvature.is_nan() || curvature <= CURVED * products[1].sqrt() * of_y.sqrt() {
            return;
        }
        self.scale = of_y / curvature;
        self.changes.push_back([s, y]);
        if self.changes.len() > self.most {
            self.changes.pop_front();
        }
        self.terms.clear();
        for [s, y] in &self.changes {
            let product = self.product(s);
            let squares = self.vectors.dots(&[(s, y), (s, &product)]);
            let (by_y, by_s) = (1.0 / squares[0].sqrt(), 1.0 / squares[1].sqrt());
            let scaled = |vector: &[f64], factor: f64| vector.iter().map(|value| factor * value).collect();
            let term = [scaled(y, by_y), scaled(&product, by_s)];
            self.terms.push(term);
        }
    }

    /// B v.
    fn product(&self, v: &[f64]) -> Vec<f64> {
        let mut product: Vec<f64> = v.iter().map(|value| self.scale * value).collect();
        let pairs = self.terms.iter().flatten().map(|term| (&term[..], v));
        let factors = self.vectors.dots(&pairs.collect::<Vec<_>>());
        for ([y, product_of_s], factors) in self.terms.iter().zip(factors.chunks(2)) {
            add_scaled(&mut product, factors[0], y);
            add_scaled(&mut product, -factors[1], product_of_s);
        }
        product
    }

    /// The change d of controls m that makes the model least between the bounds: on one face after the other by conjugate
    /// gradients, whose step the bounds cut off.
    pub fn minimum(&self, m: &[f64], gradient: &[f64], bounds: &Bounds) -> Vec<f64> {
        let (mut d, mut product) = (vec![0.0; m.len()], vec![0.0; m.len()]);
        let mut first = None;
        for _ in 0..FACES {
            let slope: Vec<f64> = gradient.iter().zip(&product).map(|(g, product)| g + product).collect();
            let at: Vec<f64> = m.iter().zip(&d).map(|(m, d)| m + d).collect();
            let held: Vec<bool> = (0..m.len()).map(|k| bounds.hold(k, at[k], slope[k])).collect();
            let size = self.vectors.norm(&free(&slope, &held));
            if size == 0.0 || size <= FALLEN * *first.get_or_insert(size) {
                break;
            }
            let direction = self.newton_step(&slope, &held);
            let vectors = &self.vectors;
            // The value, and the slope along a step.
            let value = |d: &[f64], product: &[f64], step: &[f64]| {
                let products = vectors.dots(&[(gradient, d), (d, product), (&slope, step)]);
                (products[0] + 0.5 * products[1], products[2])
            };
            let (before, _) = value(&d, &product, &d);
            let mut length = 1.0;
            let found = (0..HALVINGS).find_map(|_| {
                let mut moved = at.clone();
                add_scaled(&mut moved, length, &direction);
                length *= 0.5;
                bounds.project(&mut moved);
                let change: Vec<f64> = moved.iter().zip(m).map(|(moved, m)| moved - m).collect();
                let product = self.product(&change);
                let step: Vec<f64> = change.iter().zip(&d).map(|(new, old)| new - old).collect();
                let (value, along) = value(&change, &product, &step);
                (value <= before + DECREASE * along).then_some((change, product))
            });
            match found {
                Some(found) => (d, product) = found,
                None => break,
            }
        }
        d
    }

    /// p with B p = −slope on the controls that are not held, zero on the others, by conjugate gradients.
    fn newton_step(&self, slope: &[f64], held: &[bool]) -> Vec<f64> {
        let mut rest: Vec<f64> = free(slope, held).iter().map(|slope| -slope).collect();
        let mut step = vec![0.0; slope.len()];
        let mut direction = rest.clone();
        let mut square = self.vectors.dot(&rest, &rest);
        let enough = 1e-20 * square;
        // B has twice as many eigenvalues other than θ as changes.
        for _ in 0..3 * self.changes.len() + 5 {
            let product = free(&self.product(&direction), held);
            let length = square / self.vectors.dot(&direction, &product);
            if !length.is_finite() || length <= 0.0 {
                break;
            }
            add_scaled(&mut step, length, &direction);
            add_scaled(&mut rest, -length, &product);
            let next = self.vectors.dot(&rest, &rest);
            if next <= enough {
                break;
            }
            let factor = next / square;
            direction.iter_mut().zip(&rest).for_each(|(along, rest)| *along = rest + factor * *along);
            square = next;
        }
        step
    }
}

/// A vector with zeros where controls are held.
fn free(vector: &[f64], held: &[bool]) -> Vec<f64> {
    vector.iter().zip(held).map(|(value, held)| if *held { 0.0 } else { *value }).collect()
}
