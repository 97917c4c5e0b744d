//! The Krylov space of a shifted pencil from several vectors, orthonormal in the positive matrix.

use super::EigenError;
use super::pencil::{Pencil, Shifted};
use crate::error::LinearAlgebraError;
use crate::symmetric_eigen::SymmetricEigen;
use crate::vector::add_scaled;

/// A Ritz value ν = 1/(λ − σ) of the space, with its residual.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ritz {
    pub value: f64,
    /// ‖(A − σ B)⁻¹ B y − ν y‖ of its vector y, whose length is one.
    pub residual: f64,
    /// Bound of its rounding.
    pub rounding: f64,
    /// Its place among all Ritz vectors.
    place: usize,
}

/// Vectors v₀, v₁, …; the first ones have been sent through the operator.
pub(super) struct KrylovSpace<'a, P: Pencil> {
    pencil: &'a P,
    shifted: &'a Shifted<P>,
    basis: Vec<Vec<f64>>,
    /// Of each vector that was sent through the operator the coefficients of its image.
    images: Vec<Vec<f64>>,
    /// The coefficients of the Ritz vectors in ascending order of their values.
    ritz_vectors: Vec<Vec<f64>>,
    seed: u64,
    exhausted: bool,
}

/// A vector is a combination of the others if projections leave this part of it.
const NEGLIGIBLE: f64 = 1e-11;
/// Ritz values below this part of the largest belong to no eigenvalue.
const ZERO: f64 = 1e-13;

impl<'a, P: Pencil> KrylovSpace<'a, P> {
    pub fn new(pencil: &'a P, shifted: &'a Shifted<P>) -> Self {
        KrylovSpace {
            pencil,
            shifted,
            basis: vec![],
            images: vec![],
            ritz_vectors: vec![],
            seed: 0x9e37_79b9_7f4a_7c15,
            exhausted: false,
        }
    }

    /// Whether the space holds all eigenvectors.
    pub fn is_exhausted(&self) -> bool {
        self.exhausted
    }

    /// The first vector; none has no entries.
    pub fn first(&self) -> &[f64] {
        self.basis.first().map_or(&[], |vector| vector)
    }

    /// More vectors, without a pattern.
    ///
    /// # Errors
    /// Those of the solution with the shifted matrix.
    pub fn add_irregular(&mut self, count: usize) -> Result<(), P::Error> {
        for _ in 0..count {
            let vector = self.pencil.irregular(self.seed)?;
            self.seed = self.seed.rotate_left(17) ^ 0x2545_f491_4f6c_dd1d;
            // In the range of the operator, which is all that eigenvectors are made of.
            let image = self.shifted.apply(self.pencil, &vector)?;
            self.append(image)?;
        }
        Ok(())
    }

    /// Growth of the space until the operator was applied to the given number of vectors, or the space is exhausted.
    ///
    /// # Errors
    /// Those of the solution with the shifted matrix.
    pub fn grow_to(&mut self, count: usize) -> Result<(), P::Error> {
        while self.images.len() < count {
            if self.images.len() == self.basis.len() {
                self.add_irregular(1)?;
                if self.images.len() == self.basis.len() {
                    self.exhausted = true;
                    break;
                }
            }
            let image = self.shifted.apply(self.pencil, &self.basis[self.images.len()])?;
            let coefficients = self.append(image)?;
            self.images.push(coefficients);
        }
        Ok(())
    }

    /// The coefficients of a vector; what is left of it joins the basis.
    fn append(&mut self, mut vector: Vec<f64>) -> Result<Vec<f64>, P::Error> {
        let mut coefficients = vec![0.0; self.basis.len()];
        let mut measured = self.pencil.measured(&vector)?;
        let whole = self.pencil.length_of(&vector, &measured)?;
        let mut length = whole;
        // Twice is enough (Kahan), unless all of the vector goes.
        for _ in 0..4 {
            let parts = self.pencil.dots(&self.basis, &measured)?;
            for ((coefficient, own), part) in coefficients.iter_mut().zip(&self.basis).zip(parts) {
                *coefficient += part;
                add_scaled(&mut vector, -part, own);
            }
            measured = self.pencil.measured(&vector)?;
            let before = length;
            length = self.pencil.length_of(&vector, &measured)?;
            if length <= NEGLIGIBLE * whole || length > 0.7 * before {
                break;
            }
        }
        if length > NEGLIGIBLE * whole {
            vector.iter_mut().for_each(|entry| *entry /= length);
            self.basis.push(vector);
            coefficients.push(length);
        }
        Ok(coefficients)
    }

    /// The positive Ritz values, in descending order: eigenvalues above the shift in ascending order.
    ///
    /// # Errors
    /// A projected problem that is not finite.
    pub fn ritz_values(&mut self) -> Result<Vec<Ritz>, P::Error> {
        let size = self.images.len();
        let coefficient = |image: usize, row: usize| self.images[image].get(row).copied().unwrap_or(0.0);
        let entry = |place: usize| {
            let (i, j) = (place / size, place % size);
            coefficient(i.max(j), i.min(j))
        };
        let matrix: Vec<f64> = (0..size * size).map(entry).collect();
        let what = "a projected eigenproblem";
        let found = SymmetricEigen::of(size, &matrix);
        let found = found.ok_or_else(|| {
            EigenError::from(LinearAlgebraError::VectorNotFinite { what, index: 0, value: f64::NAN })
        })?;
        let largest = found.values.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let ritz = |place: usize| {
            let of_row = |row: usize| -> f64 {
                found.vectors[place].iter().enumerate().map(|(j, y)| coefficient(j, row) * y).sum()
            };
            let residual = (size..self.basis.len()).map(|row| of_row(row).powi(2)).sum::<f64>().sqrt();
            Ritz { value: found.values[place], residual, rounding: 1e-15 * largest, place }
        };
        let places = (0..size).rev().filter(|place| found.values[*place] > ZERO * largest);
        let positive = places.map(ritz).collect();
        self.ritz_vectors = found.vectors;
        Ok(positive)
    }

    fn combination(&self, place: usize) -> Vec<f64> {
        let mut sum = vec![0.0; self.pencil.size()];
        for (own, factor) in self.basis.iter().zip(&self.ritz_vectors[place]) {
            add_scaled(&mut sum, *factor, own);
        }
        sum
    }

    /// The vectors of Ritz values.
    pub fn vectors(&self, ritz: &[Ritz]) -> Vec<Vec<f64>> {
        ritz.iter().map(|pair| self.combination(pair.place)).collect()
    }

    /// Thick restart: the Ritz vectors of the first values stay, some more than are wanted, and the vectors that were not multiplied yet.
    pub fn restart(&mut self, ritz: &[Ritz], wanted: usize) {
        let size = self.images.len();
        let keep = (wanted + size.saturating_sub(wanted) / 2).min(ritz.len()).min(size);
        let kept = &ritz[..keep];
        let mut basis = self.vectors(kept);
        let beyond = size..self.basis.len();
        let images = kept.iter().enumerate().map(|(number, pair)| {
            let mut image = vec![0.0; keep];
            image[number] = pair.value;
            image.extend(beyond.clone().map(|row| -> f64 {
                let weights = &self.ritz_vectors[pair.place];
                let images = self.images.iter().zip(weights);
                images.map(|(image, y)| image.get(row).copied().unwrap_or(0.0) * y).sum()
            }));
            image
        });
        self.images = images.collect();
        basis.extend(self.basis.drain(beyond));
        self.basis = basis;
        self.exhausted = false;
    }
}
