//! Sparse matrices in the Matrix Market exchange format (NIST, coordinate real).

use std::io::{self, Write};
use std::path::Path;

use super::write_whole;
use crate::linear_algebra::CsrMatrix;

/// A Matrix Market file of a matrix with 17 significant digits, which read back to the same numbers. An exactly symmetric matrix
/// is written in the `symmetric` flavour (its lower triangle), any other one in the `general` flavour. Stored
/// zeros are written. The file appears whole or not at all. `scipy.io.mmread`, MATLAB's `mmread` and Julia's `MatrixMarket` read it.
///
/// ```
/// use forms_fem::output::write_matrix_market;
/// use forms_fem::prelude::*;
///
/// let mesh = rectangle([0.0; 2], [1.0; 2], [2, 2], CellShape::Triangle, 1)?;
/// let space = Space::scalar(&mesh, 1)?;
/// let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(cells("all"), dot(grad(u), grad(v))));
///
/// // The tangent at u = 0 on all unknowns, without constraints.
/// let matrix = Assembler::new(&mesh).tangent(&form, &[&Field::zero(&space)], &[&space])?;
/// # let directory = tempfile::tempdir()?;
/// # let path = directory.path().join("stiffness.mtx");
/// write_matrix_market(&path, &matrix)?;
/// let text = std::fs::read_to_string(&path)?;
/// assert!(text.starts_with("%%MatrixMarket matrix coordinate real symmetric\n9 9 "));
///
/// // The reduced matrix that was solved with is that of the linear solver.
/// let mut constraints = Constraints::new(&space);
/// constraints.fix("left", |_| 0.0)?;
/// let mut solver = LuSolver::default();
/// Problem::new(&form, &space).constrained(&constraints).solver(&mut solver).solve()?;
/// if let Some(matrix) = solver.matrix() {
///     write_matrix_market(&path, matrix)?;
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If an entry is not finite (the message names its place) or the file cannot be written.
pub fn write_matrix_market(path: impl AsRef<Path>, matrix: &CsrMatrix) -> io::Result<()> {
    matrix.check_finite().map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
    // A symmetric pattern is asked for too: the flavour must not add or drop stored zeros.
    let symmetric = matrix.pattern().is_symmetric() && matrix.is_symmetric(0.0).is_ok_and(|yes| yes);
    write_whole(path, |writer| write(writer, matrix, symmetric))
}

fn write(writer: &mut impl Write, matrix: &CsrMatrix, symmetric: bool) -> io::Result<()> {
    let entries = || {
        (0..matrix.rows()).flat_map(move |row| {
            let (columns, values) = matrix.row(row);
            columns
                .iter()
                .zip(values)
                .map(move |(&column, &value)| (row, column as usize, value))
                .filter(move |&(row, column, _)| !symmetric || column <= row)
        })
    };
    let flavour = if symmetric { "symmetric" } else { "general" };
    writeln!(writer, "%%MatrixMarket matrix coordinate real {flavour}")?;
    writeln!(writer, "{} {} {}", matrix.rows(), matrix.columns(), entries().count())?;
    for (row, column, value) in entries() {
        writeln!(writer, "{} {} {value:.16e}", row + 1, column + 1)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// Reads what the standard says, independently of the writer.
    fn read(text: &str) -> CsrMatrix {
        let mut lines = text.lines();
        let header: Vec<_> = lines.next().unwrap().split(' ').collect();
        assert_eq!(header[..4], ["%%MatrixMarket", "matrix", "coordinate", "real"]);
        let symmetric = match header[4] {
            "symmetric" => true,
            "general" => false,
            other => panic!("unknown flavour {other}"),
        };
        let size: Vec<usize> = lines.next().unwrap().split(' ').map(|word| word.parse().unwrap()).collect();
        let mut triplets = Vec::new();
        let mut count = 0;
        for line in lines {
            let words: Vec<_> = line.split(' ').collect();
            let (row, column): (usize, usize) = (words[0].parse().unwrap(), words[1].parse().unwrap());
            let value: f64 = words[2].parse().unwrap();
            triplets.push((row - 1, column - 1, value));
            if symmetric && row != column {
                assert!(row > column);
                triplets.push((column - 1, row - 1, value));
            }
            count += 1;
        }
        assert_eq!(count, size[2]);
        CsrMatrix::from_triplets(size[0], size[1], &triplets).unwrap()
    }

    fn round_trip(matrix: &CsrMatrix, flavour: &str) {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("matrix.mtx");
        write_matrix_market(&path, matrix).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.lines().next().unwrap().ends_with(flavour), "{text}");
        assert_eq!(&read(&text), matrix);
    }

    #[test]
    fn both_flavours_read_back_to_the_last_bit() {
        let third = 1.0 / 3.0;
        let general = [(0, 0, third), (0, 2, -1e-300), (1, 1, 0.1 + 0.2), (1, 0, 6.02214076e23)];
        round_trip(&CsrMatrix::from_triplets(2, 3, &general).unwrap(), "general");
        let symmetric =
            [(0, 0, 2.0), (0, 1, third), (1, 0, third), (1, 1, 0.0), (2, 2, std::f64::consts::PI)];
        round_trip(&CsrMatrix::from_triplets(3, 3, &symmetric).unwrap(), "symmetric");
        let pattern_only = [(0, 0, 2.0), (0, 1, 0.0), (1, 1, 1.0), (3, 3, 1.0)];
        round_trip(&CsrMatrix::from_triplets(4, 4, &pattern_only).unwrap(), "general");
    }

    #[test]
    fn a_nan_is_refused_before_any_file_exists() {
        let directory = tempfile::tempdir().unwrap();
        let matrix = CsrMatrix::from_triplets(2, 2, &[(1, 0, f64::NAN)]).unwrap();
        let error = write_matrix_market(directory.path().join("matrix.mtx"), &matrix).unwrap_err();
        assert!(error.to_string().contains("(1, 0)"), "{error}");
        assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
    }
}
