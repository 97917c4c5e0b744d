//! Equations of a branch cut by a plane: the unknowns with the parameter, whose tangent is regular at limit points.

use std::borrow::Cow;
use std::sync::Arc;

use super::family::{Direction, Family, Place};
use super::metric::Metric;
use crate::assemble::{AssemblyError, Terms};
use crate::linear_algebra::{BlockMatrix, BlockSparsity, LinearAlgebraError, SparsityPattern};
use crate::solve::{ActivePoints, FieldUnknowns, NonlinearProblem, Products, Tangent};

/// ⟨normal, x − base⟩ = distance.
#[derive(Clone, Debug)]
pub(super) struct Plane {
    pub normal: Direction,
    pub base: Place,
    pub distance: f64,
}

/// Positions of the entries of [K R_λ; N_u N_λ], for a pattern of K.
#[derive(Default)]
pub(super) struct ArrowPattern {
    known: Option<(Arc<SparsityPattern>, Arc<BlockSparsity>)>,
}

impl ArrowPattern {
    fn of(&mut self, inner: &Arc<SparsityPattern>) -> Result<Arc<BlockSparsity>, LinearAlgebraError> {
        if let Some((known, arrow)) = &self.known
            && Arc::ptr_eq(known, inner)
        {
            return Ok(Arc::clone(arrow));
        }
        let size = inner.rows();
        let mut pointers = Vec::with_capacity(size + 2);
        let mut columns = Vec::with_capacity(inner.entries() + 2 * size + 1);
        pointers.push(0);
        for row in inner.row_pointers().windows(2) {
            columns.extend_from_slice(&inner.column_indices()[row[0]..row[1]]);
            columns.push(size as u32);
            pointers.push(columns.len());
        }
        columns.extend(0..=size as u32);
        pointers.push(columns.len());
        let pattern = Arc::new(SparsityPattern::new(size + 1, size + 1, pointers, columns)?);
        let arrow = Arc::new(BlockSparsity::from(&pattern));
        self.known = Some((Arc::clone(inner), Arc::clone(&arrow)));
        Ok(arrow)
    }
}

/// R(u, λ) = 0 on a plane. The last unknown is ξ = 1 + (λ − λ₀)/Λ with the parameter λ₀ of the plane's base, so that a parameter
/// that passes zero is judged by Λ.
pub(super) struct ArcEquations<'f> {
    pub family: &'f mut dyn Family,
    pub metric: &'f Metric,
    pub plane: &'f Plane,
    pub pattern: &'f mut ArrowPattern,
    /// The family's fields.
    fields: Vec<FieldUnknowns>,
    /// Λ ∂R/∂λ at the last tangent.
    rate: Option<Vec<f64>>,
}

impl<'f> ArcEquations<'f> {
    /// The equations of a family on a plane.
    pub fn new(
        family: &'f mut dyn Family,
        metric: &'f Metric,
        plane: &'f Plane,
        pattern: &'f mut ArrowPattern,
    ) -> Self {
        // Each field is judged as a whole: where a structure is symmetric one component is zero, and next to a bifurcation rounding moves it
        // by more than any other.
        let mut fields = family.equations().fields();
        fields.iter_mut().for_each(|field| field.components = 1);
        ArcEquations { family, metric, plane, pattern, fields, rate: None }
    }

    /// The unknowns of a place.
    pub fn unknowns(&self, place: &Place) -> Vec<f64> {
        let mut x = place.u.clone();
        x.push(1.0 + (place.parameter - self.plane.base.parameter) / self.metric.parameter);
        x
    }

    /// The place of the unknowns.
    pub fn place(&self, mut x: Vec<f64>) -> Place {
        let last = x.pop().unwrap_or(1.0);
        Place { u: x, parameter: self.parameter(last) }
    }

    fn parameter(&self, last: f64) -> f64 {
        self.plane.base.parameter + (last - 1.0) * self.metric.parameter
    }

    /// Takes the parameter of some unknowns. The other unknowns.
    fn at<'x>(&mut self, x: &'x [f64]) -> Result<&'x [f64], AssemblyError> {
        let (last, u) = x.split_last().ok_or_else(|| AssemblyError::other(NoUnknowns))?;
        self.family.set_parameter(self.parameter(*last))?;
        Ok(u)
    }

    fn scaled_rate(&mut self, u: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let mut rate = self.family.rate(u)?;
        rate.iter_mut().for_each(|value| *value *= self.metric.parameter);
        Ok(rate)
    }

    /// The row of the plane: its value at x, and the size of its terms.
    fn plane_at(&self, x: &[f64]) -> (f64, f64) {
        let (by_unknowns, by_parameter) = self.metric.row(&self.plane.normal);
        let terms = by_unknowns.iter().zip(x.iter().zip(&self.plane.base.u)).map(|(n, (u, base))| {
            let value = n * (u - base);
            (value, value.abs())
        });
        let last = by_parameter * (x.last().copied().unwrap_or(1.0) - 1.0);
        terms.fold((last - self.plane.distance, last.abs() + self.plane.distance.abs()), |sums, term| {
            (sums.0 + term.0, sums.1 + term.1)
        })
    }
}

/// A problem without unknowns has no branch.
#[derive(Debug, thiserror::Error)]
#[error("there is no unknown to follow")]
struct NoUnknowns;

impl NonlinearProblem for ArcEquations<'_> {
    fn residual(&mut self, x: &[f64]) -> Result<Vec<f64>, AssemblyError> {
        let u = self.at(x)?;
        let mut residual = self.family.equations().residual(u)?;
        residual.push(self.plane_at(x).0);
        Ok(residual)
    }

    fn tangent(&mut self, x: &[f64]) -> Result<Tangent<'_>, AssemblyError> {
        let u = self.at(x)?;
        let rate = self.scaled_rate(u)?;
        let inner = self.family.equations().tangent(u)?.matrix.to_csr();
        let sparsity = self.pattern.of(inner.pattern()).map_err(AssemblyError::other)?;
        let (by_unknowns, by_parameter) = self.metric.row(&self.plane.normal);
        let mut values = Vec::with_capacity(sparsity.entries());
        for (row, rate) in inner.row_pointers().windows(2).zip(&rate) {
            values.extend_from_slice(&inner.values()[row[0]..row[1]]);
            values.push(*rate);
        }
        values.extend(by_unknowns);
        values.push(by_parameter);
        self.rate = Some(rate);
        let matrix = BlockMatrix::from_values(&sparsity, values).map_err(AssemblyError::other)?;
        Ok(Tangent { matrix: Cow::Owned(matrix), changed: None })
    }

    fn fields(&self) -> Vec<FieldUnknowns> {
        let mut fields = self.fields.clone();
        let named: usize = fields.iter().map(|field| field.unknowns).sum();
        let all = self.plane.base.u.len();
        if named < all {
            fields.push(FieldUnknowns { unknowns: all - named, components: 1 });
        }
        fields.push(FieldUnknowns { unknowns: 1, components: 1 });
        fields
    }

    fn active_points(&mut self, x: &[f64]) -> Result<Option<ActivePoints>, AssemblyError> {
        let u = self.at(x)?;
        self.family.equations().active_points(u)
    }

    fn products(&mut self, x: &[f64], y: &[f64]) -> Result<Products, AssemblyError> {
        let u = self.at(x)?;
        let (last, others) = y.split_last().ok_or_else(|| AssemblyError::other(NoUnknowns))?;
        let rate = match self.rate.take() {
            Some(rate) => rate,
            None => self.scaled_rate(u)?,
        };
        let mut products = self.family.equations().products(u, others)?;
        for ((sum, size), rate) in products.sums.iter_mut().zip(&mut products.sizes).zip(&rate) {
            *sum += rate * last;
            *size += (rate * last).abs();
        }
        self.rate = Some(rate);
        let (by_unknowns, by_parameter) = self.metric.row(&self.plane.normal);
        let terms = by_unknowns.iter().zip(others).map(|(n, y)| n * y);
        let (mut sum, mut size) = (by_parameter * last, (by_parameter * last).abs());
        terms.for_each(|term| {
            sum += term;
            size += term.abs();
        });
        products.sums.push(sum);
        products.sizes.push(size);
        Ok(products)
    }

    fn sizes_of_terms(&mut self, x: &[f64], terms: Terms) -> Result<Option<Vec<f64>>, AssemblyError> {
        let u = self.at(x)?;
        let Some(mut sizes) = self.family.equations().sizes_of_terms(u, terms)? else { return Ok(None) };
        sizes.push(self.plane_at(x).1);
        Ok(Some(sizes))
    }
}
