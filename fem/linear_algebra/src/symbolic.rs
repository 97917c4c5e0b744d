//! Fill of a Cholesky factor from the pattern alone: column counts and supernodes.

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SymbolicSupernodalParams;
use faer::sparse::linalg::cholesky::simplicial;
use faer::sparse::linalg::cholesky::supernodal::{self, SymbolicSupernodalCholesky};

use super::error::LinearAlgebraError;

const NO_MEMORY: LinearAlgebraError = LinearAlgebraError::OutOfMemory { what: "the symbolic analysis" };
const TOO_LARGE: LinearAlgebraError = LinearAlgebraError::TooLarge { what: "the factor" };

/// Cost of a Cholesky factor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Fill {
    /// Entries of the factor that are not zero by its structure.
    pub entries: f64,
    /// Multiplications of the factorisation.
    pub multiplications: f64,
}

impl Fill {
    /// From the number of entries of each column, the diagonal included.
    pub(super) fn of_counts(counts: impl Iterator<Item = f64>) -> Self {
        counts.fold(Fill::default(), |sum, count| Fill {
            entries: sum.entries + count,
            multiplications: sum.multiplications + 0.5 * count * (count + 3.0),
        })
    }

    /// The same structure with dense blocks of a size for entries.
    pub(super) fn in_blocks_of(self, size: f64) -> Self {
        Fill { entries: self.entries * size.powi(2), multiplications: self.multiplications * size.powi(3) }
    }
}

/// The upper triangle by columns of a matrix whose lower triangle is given by columns: faer reads that.
fn upper_triangle(size: usize, lower_pointers: &[u32], lower_rows: &[u32]) -> (Vec<u32>, Vec<u32>) {
    let mut pointers = vec![0_u32; size + 1];
    for &row in lower_rows {
        pointers[row as usize + 1] += 1;
    }
    for column in 0..size {
        pointers[column + 1] += pointers[column];
    }
    let mut next = pointers.clone();
    let mut rows = vec![0_u32; lower_rows.len()];
    for column in 0..size {
        for &row in &lower_rows[lower_pointers[column] as usize..lower_pointers[column + 1] as usize] {
            let slot = &mut next[row as usize];
            rows[*slot as usize] = column as u32;
            *slot += 1;
        }
    }
    (pointers, rows)
}

/// The number of entries of each column of the factor, for the lower triangle of a matrix by columns.
pub(super) fn column_counts(
    size: usize,
    lower_pointers: &[u32],
    lower_rows: &[u32],
) -> Result<Vec<u32>, LinearAlgebraError> {
    let (pointers, rows) = upper_triangle(size, lower_pointers, lower_rows);
    let upper = SymbolicSparseColMatRef::new_checked(size, size, &pointers, None, &rows);
    let scratch = simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(size, rows.len());
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| NO_MEMORY)?;
    let (mut tree, mut counts) = (vec![0_i32; size], vec![0_u32; size]);
    simplicial::prefactorize_symbolic_cholesky(&mut tree, &mut counts, upper, MemStack::new(&mut memory));
    Ok(counts)
}

/// Supernodes of the factor, and its fill without the zeros inside supernodes.
pub(super) fn find_supernodes(
    size: usize,
    lower_pointers: &[u32],
    lower_rows: &[u32],
) -> Result<(SymbolicSupernodalCholesky<u32>, Fill), LinearAlgebraError> {
    let (pointers, rows) = upper_triangle(size, lower_pointers, lower_rows);
    let upper = SymbolicSparseColMatRef::new_checked(size, size, &pointers, None, &rows);
    let scratch = StackReq::or(
        simplicial::prefactorize_symbolic_cholesky_scratch::<u32>(size, rows.len()),
        supernodal::factorize_supernodal_symbolic_cholesky_scratch::<u32>(size),
    );
    let mut memory = MemBuffer::try_new(scratch).map_err(|_| NO_MEMORY)?;
    let (mut tree, mut counts) = (vec![0_i32; size], vec![0_u32; size]);
    let tree =
        simplicial::prefactorize_symbolic_cholesky(&mut tree, &mut counts, upper, MemStack::new(&mut memory));
    let supernodes = supernodal::factorize_supernodal_symbolic_cholesky(
        upper,
        tree,
        &counts,
        MemStack::new(&mut memory),
        SymbolicSupernodalParams::default(),
    )
    .map_err(|_| TOO_LARGE)?;
    Ok((supernodes, Fill::of_counts(counts.into_iter().map(f64::from))))
}
