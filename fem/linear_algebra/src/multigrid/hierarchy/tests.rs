//! Convergence that does not depend on the mesh, symmetry, and errors.

use super::*;
use crate::vector::dot;
use crate::{CsrMatrix, KrylovError, KrylovOptions, OnThreads, cg};

/// The seven-point Laplacian on m × m × m inner points of a cube.
fn laplacian(m: usize) -> Arc<BlockMatrix> {
    let mut triplets = Vec::new();
    for node in 0..m * m * m {
        triplets.push((node, node, 6.0));
        for step in [1, m, m * m] {
            if (node / step) % m + 1 < m {
                triplets.extend([(node, node + step, -1.0), (node + step, node, -1.0)]);
            }
        }
    }
    Arc::new(CsrMatrix::from_triplets(m * m * m, m * m * m, &triplets).unwrap().into())
}

fn options(threads: usize) -> MultigridOptions {
    MultigridOptions { direct_size: 50, threads: Threads::new(threads), ..MultigridOptions::default() }
}

fn of_laplacian(m: usize, threads: usize) -> Multigrid {
    let constant = vec![vec![1.0; m * m * m]];
    Multigrid::new(laplacian(m), Vec::new(), constant, &options(threads)).unwrap()
}

#[test]
fn the_convergence_factor_does_not_depend_on_the_mesh() {
    for m in [10, 20, 40] {
        let (matrix, mut multigrid) = (laplacian(m), of_laplacian(m, 2));
        // Seven entries a row become 27 and more, on an eighth of the nodes and fewer.
        let complexity = multigrid.operator_complexity();
        assert!(multigrid.levels().len() >= 2 && complexity < 2.0, "m = {m}: {complexity}");
        let b: Vec<f64> = (0..m * m * m).map(|i| ((i * 37 % 101) as f64) - 50.0).collect();
        let mut x = vec![0.0; b.len()];
        let stop = KrylovOptions { tolerance: 1e-10, ..KrylovOptions::default() };
        let report = cg(&OnThreads(&*matrix, Threads::new(2)), &mut multigrid, &b, &mut x, &stop).unwrap();
        let factor = report.relative_residual.powf(1.0 / report.iterations as f64);
        assert!(factor < 0.25, "m = {m}: {factor} in {} iterations", report.iterations);
    }
}

#[test]
fn the_cycle_is_symmetric_positive_and_the_same_on_all_threads() {
    let m = 12;
    let (mut one, mut three) = (of_laplacian(m, 1), of_laplacian(m, 3));
    let u: Vec<f64> = (0..m * m * m).map(|i| (i as f64).sin()).collect();
    let v: Vec<f64> = (0..m * m * m).map(|i| (0.3 * i as f64).cos()).collect();
    let mut apply = |r: &[f64]| {
        let (mut z, mut same) = (vec![0.0; r.len()], vec![0.0; r.len()]);
        one.precondition(r, &mut z).unwrap();
        three.precondition(r, &mut same).unwrap();
        assert_eq!(z, same);
        z
    };
    let (mu, mv) = (apply(&u), apply(&v));
    assert!((dot(&mu, &v) - dot(&u, &mv)).abs() < 1e-12 * dot(&mu, &u).abs().max(dot(&mv, &v).abs()));
    assert!(dot(&mu, &u) > 0.0 && dot(&mv, &v) > 0.0);
}

#[test]
fn set_up_and_cycles_are_the_same_on_all_threads_and_their_work_is_shared() {
    let m = 40;
    let mut one = of_laplacian(m, 1);
    let b: Vec<f64> = (0..m * m * m).map(|i| (0.7 * i as f64).sin()).collect();
    let (mut expected, mut found) = (vec![0.0; b.len()], vec![0.0; b.len()]);
    one.precondition(&b, &mut expected).unwrap();
    for threads in [2, 3, 7, 16] {
        let mut other = of_laplacian(m, threads);
        assert_eq!(other.levels(), one.levels());
        other.precondition(&b, &mut found).unwrap();
        assert_eq!(found, expected, "{threads}");
    }
    for (what, work) in [("set-up", one.setup_work()), ("cycle", one.cycle_work())] {
        let speed_ups = SharedWork::THREADS.map(|threads| work.speed_up(threads).unwrap());
        println!("{what}: {:.2e} operations, {speed_ups:.1?}", work.work);
        assert!(speed_ups[0] > 1.6 && speed_ups.is_sorted(), "{what}: {speed_ups:?}");
        assert!(work.critical_path > 0.0 && work.critical_path < work.work);
    }
}

#[test]
fn a_given_transfer_is_used() {
    // A chain of 63 points and its interpolation from every second point.
    let n = 63;
    let mut triplets = vec![(0, 0, 2.0)];
    for i in 1..n {
        triplets.extend([(i, i, 2.0), (i, i - 1, -1.0), (i - 1, i, -1.0)]);
    }
    let matrix: Arc<BlockMatrix> = Arc::new(CsrMatrix::from_triplets(n, n, &triplets).unwrap().into());
    let mut entries = Vec::new();
    for column in 0..n / 2 {
        let middle = 2 * column + 1;
        entries.extend([(middle - 1, column, 0.5), (middle, column, 1.0), (middle + 1, column, 0.5)]);
    }
    let transfer = CsrMatrix::from_triplets(n, n / 2, &entries).unwrap().into();
    let mut multigrid = Multigrid::new(matrix.clone(), vec![transfer], Vec::new(), &options(1)).unwrap();
    assert_eq!(multigrid.levels().iter().map(|level| level.unknowns).collect::<Vec<_>>(), [63, 31]);
    let mut x = vec![0.0; n];
    let report = cg(&*matrix, &mut multigrid, &vec![1.0; n], &mut x, &KrylovOptions::default()).unwrap();
    assert!(report.iterations <= 10, "{}", report.iterations);
    assert!(x.iter().enumerate().all(|(i, x)| (x - 0.5 * ((i + 1) * (n - i)) as f64).abs() < 1e-6));
}

#[test]
fn unfit_matrices_are_errors() {
    let zero_row =
        CsrMatrix::from_triplets(60, 60, &(1..60).map(|i| (i, i, 1.0)).collect::<Vec<_>>()).unwrap();
    let found = Multigrid::new(Arc::new(zero_row.into()), vec![], vec![vec![1.0; 60]], &options(1));
    assert!(matches!(found, Err(LinearAlgebraError::Singular { unknown: 0, .. })), "{found:?}");
    let mut nan = (*laplacian(5)).clone();
    nan.values_mut()[1] = f64::NAN;
    let found = Multigrid::new(Arc::new(nan), vec![], vec![vec![1.0; 125]], &options(1));
    assert!(matches!(found, Err(LinearAlgebraError::EntryNotFinite { .. })), "{found:?}");
    let found = Multigrid::new(laplacian(5), vec![], vec![vec![1.0; 3]], &options(1));
    assert!(matches!(found, Err(LinearAlgebraError::SizeMismatch { .. })), "{found:?}");
    let found = cg(&*laplacian(1), &mut of_laplacian(5, 1), &[1.0], &mut [0.0], &KrylovOptions::default());
    assert!(matches!(found, Err(KrylovError::Operator(_))), "{found:?}");
}
