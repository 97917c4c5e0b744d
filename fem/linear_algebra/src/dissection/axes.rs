//! Principal axes of points.

/// A direction, of unit length.
pub(super) type Axis = [f64; 3];

/// An axis counts if the spread along it is at least this part of the largest \[both as squares\].
const NEARLY_AS_LONG: f64 = 0.1;
/// Sweeps of Jacobi's method; it converges quadratically.
const SWEEPS: usize = 8;
/// A moment of two axes below this part of their own is none: a ring has no longest axis.
const NONE: f64 = 1e-9;
/// The ratio of the second axis to the first \[both as squares\] from which on they say little, and coordinates may cut along
/// layers of cells: a cube's axes are whatever the diagonals of its cells make them.
const ROUND: f64 = 0.5;

/// An axis lies along a coordinate if one of its components is at least so large.
const ALONG: f64 = 1.0 - 1e-6;

/// Whether an axis lies along a coordinate.
pub(super) fn is_coordinate(axis: &Axis) -> bool {
    axis.iter().any(|component| component.abs() >= ALONG)
}

/// Axes across which to cut a set of points: that along which they spread most, those along which they spread nearly as much, and
/// coordinate axes where that is no clear choice. None if there are no points, or their coordinates are not finite.
pub(super) fn axes_of<'p>(points: impl Iterator<Item = &'p [f64; 3]> + Clone) -> Vec<Axis> {
    let count = points.clone().count().max(1) as f64;
    let mut centre = [0.0; 3];
    for point in points.clone() {
        (0..3).for_each(|i| centre[i] += point[i] / count);
    }
    let mut moments = [[0.0; 3]; 3];
    for point in points {
        for i in 0..3 {
            for j in 0..3 {
                moments[i][j] += (point[i] - centre[i]) * (point[j] - centre[j]);
            }
        }
    }
    let extents = [moments[0][0], moments[1][1], moments[2][2]];
    let axes = diagonalise(&mut moments);
    let mut found: Vec<(f64, Axis)> = (0..3).map(|k| (moments[k][k], axes[k])).collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let longest = found[0].0;
    found.retain(|(spread, _)| *spread > NEARLY_AS_LONG * longest);
    let is_round = found.get(1).is_some_and(|(spread, _)| *spread > ROUND * longest);
    let mut axes: Vec<Axis> = found.into_iter().map(|(_, axis)| axis).collect();
    for k in (0..3).filter(|k| is_round && extents[*k] > NEARLY_AS_LONG * longest) {
        if axes.iter().all(|axis| axis[k].abs() < ALONG) {
            axes.push(std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 }));
        }
    }
    axes
}

/// Makes a symmetric matrix diagonal by Jacobi's rotations; the eigenvectors, in the order of the diagonal.
fn diagonalise(matrix: &mut [[f64; 3]; 3]) -> [Axis; 3] {
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = matrix[p][q];
            if off.abs() <= NONE * (matrix[p][p].abs() + matrix[q][q].abs()) {
                continue;
            }
            let theta = (matrix[q][q] - matrix[p][p]) / (2.0 * off);
            let tangent = theta.signum() / (theta.abs() + theta.hypot(1.0));
            let cosine = 1.0 / tangent.hypot(1.0);
            let sine = tangent * cosine;
            let turned = |a: f64, b: f64| (cosine * a - sine * b, sine * a + cosine * b);
            for row in matrix.iter_mut() {
                (row[p], row[q]) = turned(row[p], row[q]);
            }
            for rows in [&mut *matrix, &mut axes] {
                let pairs: [(f64, f64); 3] = std::array::from_fn(|k| turned(rows[p][k], rows[q][k]));
                (rows[p], rows[q]) = (pairs.map(|(a, _)| a), pairs.map(|(_, b)| b));
            }
        }
    }
    axes
}
