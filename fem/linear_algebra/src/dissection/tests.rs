//! Dissections of cells: permutations, separators, couplings of no cell, fill compared with minimum degree's.

use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::sync::Arc;

use super::*;
use crate::cells::Cells;
use crate::ordering::inverse;
use crate::vector::norm;
use crate::{Analysis, CsrMatrix, Ordering, SparsityPattern, SymmetricFactor};

/// Cells of 3 × 3 nodes, one unknown each: `around` and `across` cells of a ring, or of a rectangle.
fn biquadratic(around: usize, across: usize, is_ring: bool) -> (Cells, usize) {
    let width = if is_ring { 2 * around } else { 2 * around + 1 };
    let mut cells = Cells::default();
    for cell in 0..around * across {
        let (i, j) = (cell % around, cell / around);
        let (x, y) = (i as f64 + 0.5, j as f64 + 0.5);
        let (angle, radius) = (2.0 * PI * x / around as f64, 2.0 + y / across as f64);
        let centre = if is_ring { [radius * angle.cos(), radius * angle.sin(), 0.0] } else { [x, y, 0.0] };
        let node = |k: usize| ((2 * j + k / 3) * width + (2 * i + k % 3) % width) as u32;
        cells.add(centre, (0..9).map(node));
    }
    (cells, width * (2 * across + 1))
}

/// Cells of the eight vertices of unit cubes, three unknowns each.
fn cubes(n: usize) -> (Cells, usize) {
    let mut cells = Cells::default();
    for cell in 0..n * n * n {
        let at = [cell % n, cell / n % n, cell / (n * n)];
        let unknowns = (0..8).flat_map(|corner| {
            let [x, y, z] = [0, 1, 2].map(|axis| at[axis] + (corner >> axis & 1));
            let node = (z * (n + 1) + y) * (n + 1) + x;
            (3 * node..3 * node + 3).map(|unknown| unknown as u32)
        });
        cells.add(at.map(|place| place as f64), unknowns);
    }
    (cells, 3 * (n + 1_usize).pow(3))
}

/// The pattern of the cells' couplings and of some others.
fn pattern(cells: &Cells, size: usize, others: &[(usize, usize)]) -> Arc<SparsityPattern> {
    let mut rows: Vec<BTreeSet<u32>> = (0..size as u32).map(|row| BTreeSet::from([row])).collect();
    for cell in 0..cells.count() {
        for &row in cells.unknowns(cell) {
            rows[row as usize].extend(cells.unknowns(cell));
        }
    }
    for &(row, column) in others {
        rows[row].insert(column as u32);
        rows[column].insert(row as u32);
    }
    let mut pointers = vec![0];
    let mut columns = vec![];
    for row in rows {
        columns.extend(row);
        pointers.push(columns.len());
    }
    let pattern = SparsityPattern::new(size, size, pointers, columns).unwrap();
    Arc::new(pattern.with_cells(Some(Arc::new(cells.clone()))).unwrap())
}

/// The graph Laplacian of a pattern plus the identity: positive definite.
fn laplacian(pattern: &Arc<SparsityPattern>) -> CsrMatrix {
    let mut matrix = CsrMatrix::zero(pattern);
    for row in 0..pattern.rows() {
        for place in pattern.row_range(row) {
            let is_diagonal = pattern.column_indices()[place] as usize == row;
            matrix.values_mut()[place] = if is_diagonal { pattern.row(row).len() as f64 } else { -1.0 };
        }
    }
    matrix
}

fn parts(pattern: &SparsityPattern) -> (BlockGraph, Vec<Part>) {
    let graph = BlockGraph::new(Threads::ONE, pattern).unwrap();
    let numbers: Vec<u32> = (0..graph.blocks() as u32).collect();
    let blocks = CellBlocks::new(pattern.cells().unwrap(), &graph, &numbers);
    let parts = parts_of_blocks(&graph, &blocks, Threads::ONE);
    (graph, parts)
}

/// Whether each coupling ties parts that lie one in the other.
fn is_dissected(graph: &BlockGraph, parts: &[Part]) -> bool {
    let along = |block: usize, other: &u32| parts[block].is_along(parts[*other as usize]);
    (0..graph.blocks()).all(|block| graph.row(block).iter().all(|other| along(block, other)))
}

#[test]
fn parts_lie_in_each_other_as_halves_do() {
    let [lower, upper] = Part::ALL.halves();
    let [first, second] = lower.halves();
    assert_eq!((first.with(second), first.with(upper), lower.with(first)), (lower, Part::ALL, lower));
    assert!(first.is_along(lower) && Part::ALL.is_along(first) && !first.is_along(upper));
    let mut ranked = [Part::ALL, upper, second, lower, first];
    ranked.sort_by_key(|part| part.rank());
    assert_eq!(ranked, [first, second, lower, upper, Part::ALL]);
    let deepest = Part(u32::MAX >> 1);
    assert_eq!((deepest.depth(), deepest.with(first)), (Part::DEEPEST, Part::ALL));
}

/// A rectangle of 12 × 8 cells, cut at a jagged line and at a straight one.
#[test]
fn jagged_cuts_are_smoothed() {
    let (cells, size) = biquadratic(12, 8, false);
    let graph = BlockGraph::new(Threads::ONE, &pattern(&cells, size, &[])).unwrap();
    let numbers: Vec<u32> = (0..graph.blocks() as u32).collect();
    let blocks = CellBlocks::new(&cells, &graph, &numbers);
    let in_common = |part: &[u32], lower: usize| {
        let of = |cells: &[u32]| -> BTreeSet<u32> {
            cells.iter().flat_map(|cell| blocks.of(*cell)).copied().collect()
        };
        of(&part[..lower]).intersection(&of(&part[lower..])).count()
    };
    let mut smoothing = smoothing::Smoothing::new(graph.blocks());
    for (teeth, before) in [([6; 8], 17), ([6, 6, 7, 6, 6, 6, 7, 6], 25), ([5, 6, 6, 6, 7, 6, 6, 6], 23)] {
        let is_lower = |cell: &u32| *cell as usize % 12 < teeth[*cell as usize / 12];
        let (mut part, upper): (Vec<u32>, Vec<u32>) = (0..96).partition(is_lower);
        let lower = part.len();
        part.extend(upper);
        part[..lower].sort_by_key(|cell| cell % 12);
        part[lower..].sort_by_key(|cell| cell % 12);
        assert_eq!(in_common(&part, lower), before);
        let lower = smoothing.smooth(&blocks, &vec![false; graph.blocks()], &mut part, lower);
        assert_eq!(in_common(&part, lower), 17);
        part.sort_unstable();
        assert!(part.iter().zip(0..96).all(|(cell, place)| *cell == place));
    }
}

/// A square of triangles, whose diagonal has as few nodes as a line across its middle: halves are rectangles, and no triangles.
#[test]
fn halves_of_a_square_are_no_wedges() {
    let n = 8;
    let mut cells = Cells::default();
    for cell in 0..2 * n * n {
        let (i, j, upper) = (cell / 2 % n, cell / 2 / n, cell % 2);
        let (x, y) = ((i + 1) as f64 - (1 + upper) as f64 / 3.0, j as f64 + (1 + upper) as f64 / 3.0);
        let corner = j * (n + 1) + i;
        let third = if upper == 1 { corner + n + 1 } else { corner + 1 };
        cells.add([x, y, 0.0], [corner, third, corner + n + 2].map(|node| node as u32));
    }
    let graph = BlockGraph::new(Threads::ONE, &pattern(&cells, (n + 1) * (n + 1), &[])).unwrap();
    let numbers: Vec<u32> = (0..graph.blocks() as u32).collect();
    let parts = Halves::of_all(&CellBlocks::new(&cells, &graph, &numbers), graph.blocks(), Threads::ONE);
    let is_between = |k: usize| {
        let of_half = |half: Part| {
            let own = parts.iter().zip(cells.centres()).filter(move |(part, _)| part.with(half) == half);
            own.map(move |(_, centre)| centre[k])
        };
        let [lower, upper] = Part::ALL.halves();
        of_half(lower).fold(f64::NEG_INFINITY, f64::max) < of_half(upper).fold(f64::INFINITY, f64::min)
    };
    assert!((0..2).any(is_between));
}

/// Enough cells that the first parts are halved on several threads.
#[test]
fn parts_are_the_same_on_any_number_of_threads() {
    for (name, (cells, size)) in [("ring", biquadratic(320, 40, true)), ("cube", cubes(24))] {
        let graph = BlockGraph::new(Threads::ONE, &pattern(&cells, size, &[])).unwrap();
        let numbers: Vec<u32> = (0..graph.blocks() as u32).collect();
        let blocks = CellBlocks::new(&cells, &graph, &numbers);
        let on_threads = |count| parts_of_blocks(&graph, &blocks, Threads::new(count));
        let parts = on_threads(1);
        assert!(is_dissected(&graph, &parts), "{name}");
        for count in [2, 3, 7, 16] {
            assert!(on_threads(count) == parts, "{name}, {count} threads");
        }
    }
}

#[test]
fn the_longest_axis_comes_first() {
    let (cosine, sine) = (0.3_f64.cos(), 0.3_f64.sin());
    let points: Vec<[f64; 3]> = (0..200)
        .map(|k| ((k % 20) as f64, 0.5 * (k / 20) as f64))
        .map(|(x, y)| [5.0 + cosine * x - sine * y, cosine * y + sine * x, 1.0])
        .collect();
    let found = axes::axes_of(points.iter());
    // The other is a sixteenth as long, as squares.
    assert_eq!(found.len(), 1);
    let [x, y, z] = found[0];
    assert!((x * cosine + y * sine).abs() > 1.0 - 1e-12 && z == 0.0, "{found:?}");
    assert!(axes::axes_of([[f64::NAN; 3]; 2].iter()).is_empty() && axes::axes_of([].iter()).is_empty());
}

#[test]
fn a_ring_is_cut_through_its_walls() {
    for (around, across) in [(64, 4), (80, 5), (112, 7)] {
        let (cells, size) = biquadratic(around, across, true);
        let (graph, parts) = parts(&pattern(&cells, size, &[]));
        assert!(is_dissected(&graph, &parts));
        // Two walls, of one line of nodes each; then one more in each half.
        let count = |part: Part| parts.iter().filter(|own| **own == part).count();
        let wall = 2 * across + 1;
        assert_eq!(count(Part::ALL), 2 * wall);
        assert_eq!(Part::ALL.halves().map(count), [wall; 2]);
    }
}

#[test]
fn fill_is_less_than_that_of_minimum_degree() {
    let rectangle = biquadratic(60, 60, false);
    let ring = biquadratic(320, 20, true);
    for ((cells, size), most) in [(rectangle, 0.8), (ring, 0.95), (cubes(14), 0.7)] {
        let pattern = pattern(&cells, size, &[]);
        let of = |ordering: Ordering| Analysis::new(&pattern, &ordering).unwrap();
        let (cells, degree) = (of(Ordering::CellDissection), of(Ordering::MinimumDegree));
        inverse(cells.elimination_order()).unwrap();
        let ratio = cells.multiplications() / degree.multiplications();
        println!("multiplications by cells / by minimum degree: {ratio}");
        assert!(ratio < most, "{ratio}");
        assert!(cells.factor_entries() < degree.factor_entries());
        let chosen = of(Ordering::LeastFill);
        assert_eq!(chosen.elimination_order(), cells.elimination_order());
        assert_eq!(chosen.candidates()[0].name, "dissection of cells");
    }
}

/// Couplings across the whole mesh, a row coupled to all others, rows in no cell at all, cells without unknowns.
#[test]
fn couplings_of_no_cell_are_kept() {
    let (mut cells, size) = biquadratic(24, 6, true);
    cells.add([0.0, 50.0, 0.0], []);
    let far: Vec<(usize, usize)> = (0..40).map(|k| (7 * k, size - 1 - 5 * k)).collect();
    let everything: Vec<_> = (0..size).map(|unknown| (size, unknown)).collect();
    let alone = [(size + 1, 0), (size + 1, 2), (size + 2, 3), (size + 2, size - 4), (size + 3, size + 1)];
    for others in [&far[..], &everything, &alone, &[far.clone(), everything.clone(), alone.to_vec()].concat()]
    {
        let pattern = pattern(&cells, size + 5, others);
        let (graph, parts) = parts(&pattern);
        assert!(is_dissected(&graph, &parts));
        let matrix = laplacian(&pattern);
        let b: Vec<f64> = (0..size + 5).map(|k| (k as f64 * 0.37).sin()).collect();
        let solve = |ordering: Ordering| {
            let analysis = Arc::new(Analysis::new(&pattern, &ordering).unwrap());
            inverse(analysis.elimination_order()).unwrap();
            let mut x = b.clone();
            SymmetricFactor::cholesky(&analysis, &matrix, vec![]).unwrap().solve_in_place(&mut x).unwrap();
            x
        };
        let (found, expected) = (solve(Ordering::CellDissection), solve(Ordering::MinimumDegree));
        let difference: Vec<f64> = found.iter().zip(&expected).map(|(a, b)| a - b).collect();
        assert!(norm(&difference) < 1e-14 * norm(&expected), "{:e}", norm(&difference) / norm(&expected));
    }
}

#[test]
fn a_row_in_no_cell_goes_where_its_neighbours_are() {
    let (cells, size) = biquadratic(16, 16, false);
    // Coupled only with the nodes of the first cell, like the multiplier of a facet.
    let others: Vec<_> = cells.unknowns(0).iter().map(|unknown| (size, *unknown as usize)).collect();
    let (graph, parts) = parts(&pattern(&cells, size + 1, &others));
    assert!(is_dissected(&graph, &parts));
    let own = parts[graph.blocks() - 1];
    assert!(own.depth() >= 7 && parts.iter().filter(|part| **part == own).count() <= 4, "{own:?}");
}

#[test]
fn some_unknowns_come_last_whatever_the_cells_are() {
    let (cells, size) = biquadratic(20, 20, false);
    let pattern = pattern(&cells, size, &[]);
    let last: Vec<u32> = (0..41).collect();
    let order = Ordering::CellDissection.choose_with_last(&pattern, &last).unwrap().order;
    inverse(&order).unwrap();
    assert_eq!(order[size - 41..], last);
}

#[test]
fn cells_must_have_unknowns_of_the_pattern() {
    let mut cells = Cells::default();
    cells.add([0.0; 3], [0, 3]);
    let matrix = CsrMatrix::from_triplets(3, 3, &[(0, 0, 1.0)]).unwrap();
    assert!((**matrix.pattern()).clone().with_cells(Some(Arc::new(cells.clone()))).is_err());
    // Not a number, or all in one place: some order all the same.
    let mut odd = Cells::default();
    for unknown in 0..40 {
        odd.add(
            [[f64::NAN, f64::INFINITY, 0.0], [0.0; 3]][unknown as usize % 2],
            [unknown, (unknown + 1) % 40],
        );
    }
    let pattern = pattern(&odd, 40, &[]);
    inverse(&Ordering::CellDissection.elimination_order(&pattern).unwrap()).unwrap();
    assert!(*pattern == SparsityPattern::clone(&pattern).with_cells(None).unwrap());
}
