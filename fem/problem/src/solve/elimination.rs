//! Elimination of unknowns that are prescribed or given by others.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use crate::constraints::{Constraints, Relation};
use crate::instantiate::instantiate;
use crate::linear_algebra::error::check_size;
use crate::linear_algebra::{
    BlockMatrix, CsrMatrix, Entry, LinearAlgebraError, Restriction, SparsityPattern, WeightedRestriction,
    Weights,
};
use crate::threads::Threads;

/// The free unknowns y of a problem whose other unknowns are prescribed or given by free ones, u = C y + d, and the
/// passage between full and reduced vectors and matrices: Cᵀ r and Cᵀ K C. The map between matrices is computed at the first one.
#[derive(Debug)]
pub struct Elimination {
    size: usize,
    prescribed: BTreeMap<usize, f64>,
    relations: BTreeMap<usize, Relation>,
    /// Values for hanging unknowns of a piece of a mesh, which hold where those that give them are prescribed by no process.
    at_hanging: BTreeMap<usize, f64>,
    free: Vec<usize>,
    /// Free unknowns of other processes that give unknowns which this process does not have: their rows are zero here.
    rows_elsewhere: Vec<usize>,
    /// Threads on which matrices are reduced.
    threads: Threads,
    restriction: Option<Restriction>,
    /// In its place where free unknowns give others.
    weighted: Option<WeightedRestriction>,
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
        Ok(Self {
            size,
            prescribed: prescribed.clone(),
            relations: BTreeMap::new(),
            at_hanging: BTreeMap::new(),
            free,
            rows_elsewhere: vec![],
            threads: Threads::default(),
            restriction: None,
            weighted: None,
        })
    }

    /// This elimination on another number of threads than all, which take submatrices out.
    pub fn on(mut self, threads: Threads) -> Self {
        self.threads = threads;
        self
    }

    /// Elimination of prescribed and related unknowns. Constraints of several spaces are one system, in which the unknowns
    /// of the spaces follow one after the other.
    ///
    /// # Errors
    /// If a prescribed value or a number of a relation is not finite.
    #[inline(never)]
    pub fn of<const D: usize>(constraints: &[&Constraints<D>]) -> Result<Self, LinearAlgebraError> {
        let (mut prescribed, mut relations) = (BTreeMap::new(), BTreeMap::new());
        let (mut at_hanging, mut offset) = (BTreeMap::new(), 0);
        for constraints in constraints {
            prescribed
                .extend(constraints.prescribed().iter().map(|(unknown, value)| (offset + unknown, *value)));
            relations.extend(constraints.relations().iter().map(|(unknown, relation)| {
                let mut relation = relation.clone();
                relation.terms.iter_mut().for_each(|term| term.0 += offset);
                (offset + unknown, relation)
            }));
            let hanging = constraints.prescribed_at_hanging().iter();
            at_hanging.extend(hanging.map(|(unknown, value)| (offset + unknown, *value)));
            offset += constraints.space().unknowns();
        }
        let made = Elimination::new(offset, &prescribed)?.with_relations(relations)?;
        Ok(Elimination { at_hanging, ..made })
    }

    /// This elimination on a piece of a mesh. Some free unknowns give others that only other processes have: those reduce the rows.
    #[doc(hidden)]
    #[must_use]
    pub fn with_rows_elsewhere(self, rows_elsewhere: Vec<usize>) -> Self {
        Elimination { rows_elsewhere, ..self }
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

    /// This elimination once more, without its map between matrices.
    pub(in crate::solve) fn again(&self) -> Self {
        Elimination {
            size: self.size,
            prescribed: self.prescribed.clone(),
            relations: self.relations.clone(),
            at_hanging: self.at_hanging.clone(),
            free: self.free.clone(),
            rows_elsewhere: self.rows_elsewhere.clone(),
            threads: self.threads,
            restriction: None,
            weighted: None,
        }
    }

    /// This elimination with one more unknown after the others, which is free.
    pub(in crate::solve) fn with_one_more(&self) -> Self {
        let mut more = self.again();
        more.free.push(more.size);
        more.size += 1;
        more
    }

    /// The same with the map between matrices of an earlier elimination, if it is the one of these free unknowns.
    pub(crate) fn with_restriction(mut self, earlier: Option<Restriction>) -> Self {
        let only = self.relations.is_empty();
        self.restriction = earlier.filter(|earlier| only && earlier.keeps(&self.free, &self.free));
        self
    }

    /// The map between matrices once more, where there is one.
    pub(crate) fn known_restriction(&self) -> Option<Restriction> {
        self.restriction.clone()
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

    /// Prescribed values, by unknown, and unknowns that free ones give.
    #[doc(hidden)]
    pub fn conditions(&self) -> (&BTreeMap<usize, f64>, &BTreeMap<usize, Relation>) {
        (&self.prescribed, &self.relations)
    }

    /// Values for hanging unknowns of a piece of a mesh.
    pub(super) fn at_hanging(&self) -> &BTreeMap<usize, f64> {
        &self.at_hanging
    }

    /// Prescribed values, by unknown.
    pub(crate) fn prescribed(&self) -> &BTreeMap<usize, f64> {
        &self.prescribed
    }

    /// Unknowns that free ones give.
    pub(crate) fn relations(&self) -> &BTreeMap<usize, Relation> {
        &self.relations
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
        self.impose_relations(full);
        Ok(())
    }

    /// Writes what free entries give into a full vector.
    pub(crate) fn impose_relations(&self, full: &mut [f64]) {
        for (&unknown, relation) in &self.relations {
            full[unknown] =
                relation.terms.iter().fold(relation.value, |sum, (free, a)| sum + a * full[*free]);
        }
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
        if self.relations.is_empty() && self.rows_elsewhere.is_empty() {
            return Ok(self.free.iter().map(|&unknown| full[unknown]).collect());
        }
        let mut sums = full.to_vec();
        for (&unknown, relation) in &self.relations {
            relation.terms.iter().for_each(|(free, a)| sums[*free] += a * full[unknown]);
        }
        self.rows_elsewhere.iter().for_each(|unknown| sums[*unknown] = 0.0);
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
        self.rows_elsewhere.iter().for_each(|unknown| sums[*unknown] = 0.0);
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
            let threads = self.threads;
            return self.restriction(matrix, known)?.apply(threads, matrix);
        }
        self.weighted(matrix, known)?.apply(matrix)
    }

    /// The entries by which the reduced matrix differs from another one: what is added to them there. None if there are more than `most`, or
    /// the patterns differ. Nothing of the reduced matrix is stored.
    ///
    /// # Errors
    /// If the matrix has the wrong size, an entry that differs is not finite, or unknowns are given by free ones.
    pub(crate) fn reduce_difference_from(
        &mut self,
        threads: Threads,
        matrix: &BlockMatrix,
        base: &CsrMatrix,
        most: usize,
    ) -> Result<Option<Vec<Entry>>, LinearAlgebraError> {
        self.check_only_prescribes()?;
        let restriction = self.restriction(matrix, Some(base.pattern()))?;
        if !Arc::ptr_eq(restriction.pattern(), base.pattern()) && **restriction.pattern() != **base.pattern()
        {
            return Ok(None);
        }
        restriction.differences(threads, matrix, base, most)
    }

    fn check_only_prescribes(&self) -> Result<(), LinearAlgebraError> {
        match self.only_prescribes() {
            true => Ok(()),
            false => {
                Err(LinearAlgebraError::PatternMismatch { what: "taking entries out of related unknowns" })
            }
        }
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
        self.check_only_prescribes()?;
        self.restriction(matrix, None)?.apply_to_places(matrix, places)
    }

    /// Difference of two matrices on reduced unknowns, Cᵀ (K − K₀) C, where they differ at some places only, given as ranges of whole
    /// blocks: each entry once. It is made for unknowns that are given by free ones.
    ///
    /// # Errors
    /// If a matrix has the wrong size, or they have different structures.
    pub(crate) fn reduce_differences(
        &mut self,
        matrix: &BlockMatrix,
        base: &BlockMatrix,
        places: &[Range<usize>],
    ) -> Result<Vec<Entry>, LinearAlgebraError> {
        self.weighted(matrix, None)?.differences(matrix, base, places)
    }

    /// C, by the numbers of the free unknowns.
    pub(crate) fn weights(&self) -> Weights {
        let mut numbers = vec![u32::MAX; self.size];
        (0..).zip(&self.free).for_each(|(number, unknown)| numbers[*unknown] = number);
        let mut weights = Weights::default();
        for unknown in 0..self.size {
            match (numbers[unknown], self.relations.get(&unknown)) {
                (u32::MAX, Some(relation)) => {
                    weights.add(relation.terms.iter().map(|(free, a)| (numbers[*free], *a)));
                }
                (u32::MAX, None) => weights.add([]),
                (number, _) => weights.add([(number, 1.0)]),
            }
        }
        weights
    }

    fn weighted(
        &mut self,
        matrix: &BlockMatrix,
        known: Option<&Arc<SparsityPattern>>,
    ) -> Result<&WeightedRestriction, LinearAlgebraError> {
        check_size("the set of rows", self.size, matrix.rows())?;
        check_size("the set of columns", self.size, matrix.columns())?;
        let weighted = match self.weighted.take().filter(|weighted| weighted.fits(matrix)) {
            Some(weighted) => weighted,
            None => WeightedRestriction::new(matrix.sparsity(), self.weights(), &self.free, known)?,
        };
        Ok(self.weighted.insert(weighted))
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
            None => Restriction::sharing(self.threads, matrix.sparsity(), &self.free, &self.free, known)?,
        };
        Ok(self.restriction.insert(restriction))
    }
}

instantiate!(elimination: Elimination::of::<D>);

#[cfg(test)]
mod tests;
