//! Elimination of unknowns that are prescribed or given by others.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use crate::constraints::{Constraints, Relation};
use crate::instantiate::instantiate;
use crate::linear_algebra::error::check_size;
use crate::linear_algebra::{
    BlockMatrix, CsrMatrix, Entry, LinearAlgebraError, Restriction, SparsityPattern,
};

/// The free unknowns y of a problem whose other unknowns are prescribed or given by free ones, u = C y + d, and the
/// passage between full and reduced vectors and matrices: Cᵀ r and Cᵀ K C. The map between matrices is computed at the first one.
#[derive(Debug)]
pub struct Elimination {
    size: usize,
    prescribed: BTreeMap<usize, f64>,
    relations: BTreeMap<usize, Relation>,
    free: Vec<usize>,
    restriction: Option<Restriction>,
}

impl Elimination {
    /// Elimination of `prescribed` (unknown → value) from `size` unknowns.
    ///
    /// # Errors
    /// If an unknown lies outside 0..size or a value is not finite.
    pub fn new(size: usize, prescribed: &BTreeMap<usize, f64>) -> Result<Self, LinearAlgebraError> {
        for (&index, &value) in prescribed {
            if index >= size {
                return Err(LinearAlgebraError::IndexOutOfRange { what: "prescribed unknown", index, size });
            }
            if !value.is_finite() {
                let what = "the prescribed values";
                return Err(LinearAlgebraError::VectorNotFinite { what, index, value });
            }
        }
        let mut free = Vec::with_capacity(size.saturating_sub(prescribed.len()));
        let mut from = 0;
        for &unknown in prescribed.keys() {
            free.extend(from..unknown);
            from = unknown + 1;
        }
        free.extend(from..size);
        Ok(Self { size, prescribed: prescribed.clone(), relations: BTreeMap::new(), free, restriction: None })
    }

    /// Elimination of prescribed and related unknowns. Constraints of several spaces are one system, in which the unknowns
    /// of the spaces follow one after the other.
    ///
    /// # Errors
    /// If a prescribed value or a number of a relation is not finite.
    #[inline(never)]
    pub fn of<const D: usize>(constraints: &[&Constraints<D>]) -> Result<Self, LinearAlgebraError> {
        let (mut prescribed, mut relations) = (BTreeMap::new(), BTreeMap::new());
        let mut offset = 0;
        for constraints in constraints {
            prescribed
                .extend(constraints.prescribed().iter().map(|(unknown, value)| (offset + unknown, *value)));
            relations.extend(constraints.relations().iter().map(|(unknown, relation)| {
                let mut relation = relation.clone();
                relation.terms.iter_mut().for_each(|term| term.0 += offset);
                (offset + unknown, relation)
            }));
            offset += constraints.space().unknowns();
        }
        Elimination::new(offset, &prescribed)?.with_relations(relations)
    }

    /// This elimination with relations: unknowns that free ones determine.
    ///
    /// # Errors
    /// If a relation names an unknown outside of all, one that is not free, or a number that is not finite.
    pub fn with_relations(
        mut self,
        relations: BTreeMap<usize, Relation>,
    ) -> Result<Self, LinearAlgebraError> {
        self.free.retain(|unknown| !relations.contains_key(unknown));
        for (&unknown, relation) in &relations {
            let numbers = relation.terms.iter().map(|(_, a)| a).chain([&relation.value]);
            if let Some(&value) = numbers.into_iter().find(|value| !value.is_finite()) {
                let what = "the relations between unknowns";
                return Err(LinearAlgebraError::VectorNotFinite { what, index: unknown, value });
            }
            let wrong = relation.terms.iter().find(|(index, _)| self.free.binary_search(index).is_err());
            if let Some(index) = wrong.map(|term| term.0).or((unknown >= self.size).then_some(unknown)) {
                let what = "unknown of a relation";
                return Err(LinearAlgebraError::IndexOutOfRange { what, index, size: self.size });
            }
        }
        self.relations = relations;
        Ok(self)
    }

    /// The same with the map between matrices of an earlier elimination, if it is the one of these free unknowns.
    pub(crate) fn with_restriction(mut self, earlier: Option<Restriction>) -> Self {
        let only = self.relations.is_empty();
        self.restriction = earlier.filter(|earlier| only && earlier.keeps(&self.free, &self.free));
        self
    }

    /// The map between matrices, where there is one.
    pub(crate) fn into_restriction(self) -> Option<Restriction> {
        self.restriction
    }

    /// Whether reduced matrices are submatrices: no unknown is given by free ones.
    pub fn only_prescribes(&self) -> bool {
        self.relations.is_empty()
    }

    /// Number of all unknowns.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The unknowns on which constraints act: those that are prescribed or given by others, and the free ones that give them.
    #[doc(hidden)]
    pub fn held(&self) -> Vec<usize> {
        let mut held: Vec<usize> = self.prescribed.keys().copied().collect();
        for (unknown, relation) in &self.relations {
            held.extend(relation.terms.iter().map(|(free, _)| *free).chain([*unknown]));
        }
        held.sort_unstable();
        held.dedup();
        held
    }

    /// Free unknowns, ascending.
    pub fn free(&self) -> &[usize] {
        &self.free
    }

    /// The prescribed values, written into a full vector, and then those that its free entries determine.
    ///
    /// # Errors
    /// If the size is wrong.
    pub fn impose(&self, full: &mut [f64]) -> Result<(), LinearAlgebraError> {
        check_size("the vector of all unknowns", self.size, full.len())?;
        for (&unknown, &value) in &self.prescribed {
            full[unknown] = value;
        }
        for (&unknown, relation) in &self.relations {
            full[unknown] =
                relation.terms.iter().fold(relation.value, |sum, (free, a)| sum + a * full[*free]);
        }
        Ok(())
    }

    /// d: the prescribed and given values where free unknowns are zero.
    ///
    /// # Errors
    /// None; as [`Elimination::impose`].
    pub fn lifted(&self) -> Result<Vec<f64>, LinearAlgebraError> {
        let mut lifted = vec![0.0; self.size];
        self.impose(&mut lifted)?;
        Ok(lifted)
    }

    /// Cᵀ times a full vector of residuals or loads: its free entries, with the contributions of related ones.
    ///
    /// # Errors
    /// If the size is wrong.
    pub fn reduce(&self, full: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
        check_size("the vector of all unknowns", self.size, full.len())?;
        if self.relations.is_empty() {
            return Ok(self.free.iter().map(|&unknown| full[unknown]).collect());
        }
        let mut sums = full.to_vec();
        for (&unknown, relation) in &self.relations {
            relation.terms.iter().for_each(|(free, a)| sums[*free] += a * full[unknown]);
        }
        Ok(self.free.iter().map(|&unknown| sums[unknown]).collect())
    }

    /// |C|ᵀ times a full vector of amounts, which are not negative: bounds of the sums in [`Elimination::reduce`].
    ///
    /// # Errors
    /// If the size is wrong.
    pub fn reduce_amounts(&self, full: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
        check_size("the vector of all unknowns", self.size, full.len())?;
        let mut sums = full.to_vec();
        for (&unknown, relation) in &self.relations {
            relation.terms.iter().for_each(|(free, a)| sums[*free] += a.abs() * full[unknown]);
        }
        Ok(self.free.iter().map(|&unknown| sums[unknown]).collect())
    }

    /// C times a vector of free unknowns: an increment, zero where unknowns are prescribed.
    ///
    /// # Errors
    /// If the size is wrong.
    pub fn extend_by_zero(&self, reduced: &[f64]) -> Result<Vec<f64>, LinearAlgebraError> {
        check_size("the vector of free unknowns", self.free.len(), reduced.len())?;
        let mut full = vec![0.0; self.size];
        for (&unknown, &value) in self.free.iter().zip(reduced) {
            full[unknown] = value;
        }
        for (&unknown, relation) in &self.relations {
            full[unknown] = relation.terms.iter().map(|(free, a)| a * full[*free]).sum();
        }
        Ok(full)
    }

    /// Residual of a candidate null vector: its reduced forces on the free unknowns, and on each of the others the violation
    /// of its constraint. Zero for a motion that nothing resists.
    ///
    /// # Errors
    /// If a size is wrong.
    pub fn null_space_residual(
        &self,
        motion: &[f64],
        forces: &[f64],
    ) -> Result<Vec<f64>, LinearAlgebraError> {
        check_size("the vector of all unknowns", self.size, motion.len())?;
        let free: Vec<f64> = self.free.iter().map(|&unknown| motion[unknown]).collect();
        let given = self.extend_by_zero(&free)?;
        let mut residual: Vec<f64> = motion.iter().zip(&given).map(|(value, given)| value - given).collect();
        for (&unknown, force) in self.free.iter().zip(self.reduce(forces)?) {
            residual[unknown] = force;
        }
        Ok(residual)
    }

    /// Cᵀ K C of a full matrix K: its free rows and columns, with the contributions of relations.
    ///
    /// # Errors
    /// If the matrix has the wrong size.
    pub fn reduce_matrix(&mut self, matrix: &BlockMatrix) -> Result<CsrMatrix, LinearAlgebraError> {
        self.reduce_matrix_sharing(matrix, None)
    }

    /// The reduced matrix, as [`Elimination::reduce_matrix`] gives it, sharing a known pattern if it fits, such as that of an earlier matrix.
    ///
    /// # Errors
    /// As [`Elimination::reduce_matrix`].
    pub fn reduce_matrix_sharing(
        &mut self,
        matrix: &BlockMatrix,
        known: Option<&Arc<SparsityPattern>>,
    ) -> Result<CsrMatrix, LinearAlgebraError> {
        if self.relations.is_empty() {
            return self.restriction(matrix, known)?.apply(matrix);
        }
        check_size("the set of rows", self.size, matrix.rows())?;
        check_size("the set of columns", self.size, matrix.columns())?;
        // Of each unknown the free ones that it depends on, and of each free one the unknowns that depend on it, by reduced numbers.
        let mut numbers = vec![usize::MAX; self.size];
        let mut dependent: Vec<Vec<(usize, f64)>> = vec![vec![]; self.free.len()];
        for (number, &unknown) in self.free.iter().enumerate() {
            numbers[unknown] = number;
            dependent[number].push((unknown, 1.0));
        }
        let mut terms: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
        for (&unknown, relation) in &self.relations {
            let own: Vec<_> = relation.terms.iter().map(|(free, a)| (numbers[*free], *a)).collect();
            own.iter().for_each(|(number, a)| dependent[*number].push((unknown, *a)));
            terms.insert(unknown, own);
        }
        let count = self.free.len();
        let (mut pointers, mut indices, mut values) = (vec![0_usize], Vec::<u32>::new(), Vec::<f64>::new());
        // The place of each column in the row, for the row that it was met in last.
        let mut places = vec![(usize::MAX, 0_usize); count];
        let mut entries: Vec<(u32, f64)> = vec![];
        for (row, unknowns) in dependent.iter().enumerate() {
            entries.clear();
            let mut add = |column: usize, value: f64| match places[column] {
                (known, place) if known == row => entries[place].1 += value,
                _ => {
                    places[column] = (row, entries.len());
                    entries.push((column as u32, value));
                }
            };
            for &(unknown, a) in unknowns {
                for (column, value) in matrix.row(unknown) {
                    match numbers[column] {
                        usize::MAX => {
                            let others = terms.get(&column).into_iter().flatten();
                            others.for_each(|(column, b)| add(*column, a * value * b));
                        }
                        number => add(number, a * value),
                    }
                }
            }
            entries.sort_unstable_by_key(|entry| entry.0);
            indices.extend(entries.iter().map(|entry| entry.0));
            values.extend(entries.iter().map(|entry| entry.1));
            pointers.push(indices.len());
        }
        // An unknown that others give represents them.
        let cells = matrix.sparsity().cells().map(|cells| {
            Arc::new(cells.renumbered(|unknown, visit| match numbers[unknown as usize] {
                usize::MAX => {
                    let others = terms.get(&(unknown as usize)).into_iter().flatten();
                    others.for_each(|(number, _)| visit(*number as u32));
                }
                number => visit(number as u32),
            }))
        });
        let pattern = SparsityPattern::new(count, count, pointers, indices)?.with_cells(cells)?;
        CsrMatrix::from_pattern(&Arc::new(pattern), values)
    }

    /// The entries of the reduced matrix whose values are at some places of the full one, as ranges of whole
    /// blocks. It takes a time proportional to their number, once a matrix of these positions has been reduced.
    ///
    /// # Errors
    /// If the matrix has the wrong size, or unknowns are given by free ones.
    pub fn reduce_places(
        &mut self,
        matrix: &BlockMatrix,
        places: &[Range<usize>],
    ) -> Result<Vec<Entry>, LinearAlgebraError> {
        if !self.only_prescribes() {
            return Err(LinearAlgebraError::PatternMismatch {
                what: "taking entries out of related unknowns",
            });
        }
        self.restriction(matrix, None)?.apply_to_places(matrix, places)
    }

    fn restriction(
        &mut self,
        matrix: &BlockMatrix,
        known: Option<&Arc<SparsityPattern>>,
    ) -> Result<&Restriction, LinearAlgebraError> {
        check_size("the set of rows", self.size, matrix.rows())?;
        check_size("the set of columns", self.size, matrix.columns())?;
        let restriction = match self.restriction.take().filter(|restriction| restriction.fits(matrix)) {
            Some(restriction) => restriction,
            None => Restriction::sharing(matrix.sparsity(), &self.free, &self.free, known)?,
        };
        Ok(self.restriction.insert(restriction))
    }
}

instantiate!(elimination: Elimination::of::<D>);

#[cfg(test)]
mod tests;
