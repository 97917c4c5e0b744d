//! Symbolic analysis of a symmetric pattern: ordering, elimination tree, supernodes.

use std::sync::{Arc, OnceLock};
use std::time::Instant;

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;

use super::block_graph::BlockGraph;
use super::csr::CsrMatrix;
use super::elimination::Elimination;
use super::error::{LinearAlgebraError, check_size};
use super::ordering::{Candidate, Chosen, Ordering, inverse};
use super::pattern::SparsityPattern;
use super::symbolic::{Fill, Runs};
use super::task_graph::SharedWork;
use super::threads::Threads;

/// The lower triangle of the reordered matrix by columns, and where each of its values comes from.
#[derive(Debug)]
pub(super) struct LowerTriangle {
    pub(super) pointers: Vec<u32>,
    /// Unsorted in a column.
    pub(super) rows: Vec<u32>,
    /// Position of each value in the matrix.
    pub(super) source: Vec<u32>,
}

/// The symbolic part of a factorisation, which needs only the pattern. It is computed once and serves every matrix
/// with that pattern.
#[derive(Debug)]
pub struct Analysis {
    pattern: Arc<SparsityPattern>,
    /// Unknown at each place of the elimination order.
    pub(super) order: Vec<u32>,
    candidates: Vec<Candidate>,
    /// Place of each unknown in the elimination order; none where no further matrix is to be factored.
    places: Option<Vec<u32>>,
    /// Whether the row of each unknown has the pattern of the row before it.
    pub(super) is_like_last: Vec<bool>,
    /// For LBLᵀ, from the first one on.
    lower: OnceLock<LowerTriangle>,
    /// Position of (j, i) for each entry (i, j), for LU, from the first one on.
    partners: OnceLock<Vec<u32>>,
    pub(super) supernodes: SymbolicSupernodalCholesky<u32>,
    /// The tasks of factorisations and solves, from the first one on.
    elimination: OnceLock<Elimination>,
    fill: Fill,
    seconds: f64,
}

impl Analysis {
    /// Analysis of the pattern of a symmetric matrix. If entries that are zero are stored on only one side of the diagonal, the analysed pattern has
    /// both sides, and the matrix on that pattern is returned, too.
    ///
    /// # Errors
    /// As [`Analysis::new`], except for a pattern that is not symmetric.
    pub fn of_symmetric(
        matrix: &CsrMatrix,
        ordering: &Ordering,
    ) -> Result<(Self, Option<CsrMatrix>), LinearAlgebraError> {
        Self::of_symmetric_on(Threads::all(), matrix, ordering, &[])
    }

    /// The analysis on some threads, the same for any number of them, with an order that ends with some unknowns, as
    /// [`Ordering::choose_with_last`] has it.
    ///
    /// # Errors
    /// As there, and as [`Analysis::of_symmetric`].
    pub fn of_symmetric_on(
        threads: Threads,
        matrix: &CsrMatrix,
        ordering: &Ordering,
        last: &[u32],
    ) -> Result<(Self, Option<CsrMatrix>), LinearAlgebraError> {
        match Self::with_last(threads, matrix.pattern(), ordering, last) {
            Err(LinearAlgebraError::PatternMismatch { .. }) => {
                let completed = matrix.symmetric_part()?;
                Ok((Self::with_last(threads, completed.pattern(), ordering, last)?, Some(completed)))
            }
            found => Ok((found?, None)),
        }
    }

    /// Analysis of a symmetric pattern.
    ///
    /// # Errors
    /// If the pattern is not square or not symmetric, the order is not a permutation, the factor passes 32-bit indices, or
    /// memory is too small.
    pub fn new(pattern: &Arc<SparsityPattern>, ordering: &Ordering) -> Result<Self, LinearAlgebraError> {
        Self::with_last(Threads::all(), pattern, ordering, &[])
    }

    fn with_last(
        threads: Threads,
        pattern: &Arc<SparsityPattern>,
        ordering: &Ordering,
        last: &[u32],
    ) -> Result<Self, LinearAlgebraError> {
        let start = Instant::now();
        let size = pattern.rows();
        check_size("the set of columns of a square matrix", size, pattern.columns())?;
        if u32::try_from(pattern.entries()).is_err() {
            return Err(LinearAlgebraError::TooLarge { what: "the matrix" });
        }
        let graph = BlockGraph::new(threads, pattern)?;
        if !graph.is_of_symmetric(pattern) {
            return Err(LinearAlgebraError::PatternMismatch { what: "a symmetric analysis" });
        }
        let (Chosen { order, candidates }, runs) = ordering.choose_on(threads, &graph, pattern, last)?;
        let places = Some(inverse(&order)?);
        let (runs, is_like_last) = (Runs::of_unknowns(&graph, &order, runs), graph.likeness());
        drop(graph);
        let (supernodes, fill) = runs.supernodes()?;
        Ok(Self {
            pattern: pattern.clone(),
            order,
            candidates,
            places,
            is_like_last,
            lower: OnceLock::new(),
            partners: OnceLock::new(),
            supernodes,
            elimination: OnceLock::new(),
            fill,
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// Number of unknowns.
    pub fn size(&self) -> usize {
        self.order.len()
    }

    /// The pattern that was analysed.
    pub fn pattern(&self) -> &Arc<SparsityPattern> {
        &self.pattern
    }

    /// Unknowns in the order of their elimination.
    pub fn elimination_order(&self) -> &[u32] {
        &self.order
    }

    /// The orderings that were compared, the one that was taken first.
    pub fn candidates(&self) -> &[Candidate] {
        &self.candidates
    }

    /// Numbers stored in a factor, with the zeros inside supernodes.
    pub fn factor_entries(&self) -> usize {
        self.supernodes.len_val()
    }

    /// Entries and multiplications of a Cholesky factorisation without the zeros inside supernodes.
    pub fn fill(&self) -> Fill {
        self.fill
    }

    /// Multiplications of a Cholesky factorisation without the zeros inside supernodes. Two orderings are
    /// compared by it before anything is factored.
    pub fn multiplications(&self) -> f64 {
        self.fill.multiplications
    }

    /// Seconds that the analysis took.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Whether a matrix has the analysed pattern.
    pub fn fits(&self, matrix: &CsrMatrix) -> bool {
        Arc::ptr_eq(matrix.pattern(), &self.pattern) || **matrix.pattern() == *self.pattern
    }

    /// The part that solves with a factor need, in less memory: no further matrix can be factored on it.
    pub(super) fn for_solves(mut self) -> Self {
        let elimination = OnceLock::new();
        if let Some(known) = self.elimination.take() {
            let _ = elimination.set(known.for_solves());
        }
        Self { places: None, lower: OnceLock::new(), partners: OnceLock::new(), elimination, ..self }
    }

    /// The tasks of factorisations and solves.
    pub(super) fn elimination(&self) -> &Elimination {
        self.elimination.get_or_init(|| Elimination::new(&self.supernodes))
    }

    /// Counted work of a factorisation LLᵀ or LSLᵀ, in multiplications with what moves their results, and how far threads can share it. Of an
    /// [`UnpivotedLu`](crate::UnpivotedLu) each task has twice the work: the speed-ups are the same.
    pub fn factorisation_work(&self) -> SharedWork {
        self.elimination().factorisation.shared_work()
    }

    /// Counted work of a solve with L and one right-hand side, in entries of L, and how far threads can share it. Several right-hand sides
    /// at once multiply each task's work by their number: the speed-ups are the same.
    pub fn solve_work(&self) -> SharedWork {
        self.elimination().forward.shared_work()
    }

    /// The place of each unknown of a matrix to factor.
    pub(super) fn places(&self, matrix: &CsrMatrix) -> Result<&[u32], LinearAlgebraError> {
        let fitting = self.places.as_deref().filter(|_| self.fits(matrix));
        fitting.ok_or(LinearAlgebraError::PatternMismatch { what: "factoring on an earlier analysis" })
    }

    /// The position of (j, i) for each entry (i, j) of the pattern.
    pub(super) fn partners(&self) -> &[u32] {
        self.partners.get_or_init(|| {
            // Rows come in ascending order, and so do the entries of each column.
            let mut next: Vec<u32> = self.pattern.row_pointers().iter().map(|start| *start as u32).collect();
            let mut partner = |column: &u32| {
                let next = &mut next[*column as usize];
                *next += 1;
                *next - 1
            };
            self.pattern.column_indices().iter().map(&mut partner).collect()
        })
    }

    /// The lower triangle of the reordered matrix.
    pub(super) fn lower(&self, matrix: &CsrMatrix) -> Result<&LowerTriangle, LinearAlgebraError> {
        let places = self.places(matrix)?;
        Ok(self.lower.get_or_init(|| LowerTriangle::new(&self.pattern, places)))
    }
}

impl LowerTriangle {
    /// That of the matrix whose row `place[i]` is row i of the pattern; the upper triangle is read.
    fn new(pattern: &SparsityPattern, place: &[u32]) -> Self {
        let size = pattern.rows();
        let mut pointers = vec![0_u32; size + 1];
        let upper =
            |row: usize| pattern.row_range(row).filter(move |&k| pattern.column_indices()[k] as usize >= row);
        for row in 0..size {
            for position in upper(row) {
                let column = pattern.column_indices()[position] as usize;
                pointers[place[row].min(place[column]) as usize + 1] += 1;
            }
        }
        for column in 0..size {
            pointers[column + 1] += pointers[column];
        }
        let mut next = pointers.clone();
        let mut rows = vec![0_u32; pointers[size] as usize];
        let mut source = rows.clone();
        for row in 0..size {
            for position in upper(row) {
                let column = pattern.column_indices()[position] as usize;
                let (a, b) = (place[row], place[column]);
                let slot = &mut next[a.min(b) as usize];
                rows[*slot as usize] = a.max(b);
                source[*slot as usize] = position as u32;
                *slot += 1;
            }
        }
        LowerTriangle { pointers, rows, source }
    }

    /// The values of a matrix in its order.
    pub(super) fn values(&self, matrix: &[f64]) -> Vec<f64> {
        self.source.iter().map(|&source| matrix[source as usize]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tridiagonal matrix of order n.
    fn chain(n: usize) -> CsrMatrix {
        let mut triplets = vec![(0, 0, 2.0)];
        for i in 1..n {
            triplets.extend([(i, i, 2.0), (i, i - 1, -1.0), (i - 1, i, -1.0)]);
        }
        CsrMatrix::from_triplets(n, n, &triplets).unwrap()
    }

    #[test]
    fn a_chain_has_no_fill_and_the_worst_order_of_a_star_fills_it() {
        let chain = chain(100);
        let analysis = Analysis::new(chain.pattern(), &Ordering::MinimumDegree).unwrap();
        // Each column but the last has one entry below the diagonal: at most c (c + 3) / 2 with c = 2.
        assert!(analysis.multiplications() <= 5.0 * 100.0);
        let mut triplets = Vec::new();
        for i in 1..30 {
            triplets.extend([(i, i, 1.0), (0, i, 1.0), (i, 0, 1.0)]);
        }
        triplets.push((0, 0, 1.0));
        let star = CsrMatrix::from_triplets(30, 30, &triplets).unwrap();
        let natural = Analysis::new(star.pattern(), &Ordering::Given((0..30).collect())).unwrap();
        let ordered = Analysis::new(star.pattern(), &Ordering::MinimumDegree).unwrap();
        assert_eq!(natural.factor_entries(), 900);
        assert!(ordered.multiplications() < 0.1 * natural.multiplications());
    }

    #[test]
    fn what_is_for_solves_alone_factors_nothing() {
        let chain = chain(20);
        let analysis = Analysis::new(chain.pattern(), &Ordering::MinimumDegree).unwrap();
        assert!(analysis.places(&chain).is_ok() && analysis.for_solves().places(&chain).is_err());
    }

    #[test]
    fn a_rectangular_pattern_is_refused() {
        let matrix = CsrMatrix::from_triplets(2, 3, &[(0, 0, 1.0)]).unwrap();
        assert!(matches!(
            Analysis::new(matrix.pattern(), &Ordering::MinimumDegree),
            Err(LinearAlgebraError::SizeMismatch { expected: 2, found: 3, .. })
        ));
    }

    #[test]
    fn a_pattern_that_is_not_symmetric_is_refused() {
        let diagonal = [0, 1, 2, 3].map(|i| (i, i, 1.0));
        // A triangle alone; (2, 1) without (1, 2), in blocks that are coupled in both directions.
        let upper = [(0, 1, 1.0)];
        let in_blocks = [(0, 1, 1.0), (1, 0, 1.0), (2, 3, 1.0), (3, 2, 1.0), (0, 2, 1.0), (1, 2, 1.0)];
        let turned = [(2, 0, 1.0), (2, 1, 1.0), (3, 0, 1.0), (3, 1, 1.0)];
        for others in [&upper[..], &[&in_blocks[..], &turned].concat()] {
            let matrix = CsrMatrix::from_triplets(4, 4, &[&diagonal, others].concat()).unwrap();
            let found = Analysis::new(matrix.pattern(), &Ordering::MinimumDegree);
            assert!(matches!(found, Err(LinearAlgebraError::PatternMismatch { .. })), "{others:?}");
            let (analysis, completed) = Analysis::of_symmetric(&matrix, &Ordering::MinimumDegree).unwrap();
            let completed = completed.expect("the other entries");
            assert!(analysis.fits(&completed) && completed.get(1, 0) == completed.get(0, 1));
        }
    }
}
