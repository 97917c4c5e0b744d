//! A tree of boxes around flat pieces, segments in the plane or triangles in space: the distance of a point, and its winding number.

use std::f64::consts::PI;

use super::{Corners, distance};

/// Pieces of a leaf.
const LEAF: usize = 4;

/// Pieces this many times farther away than they reach from their centre count as one.
const FAR: f64 = 3.0;

/// Flat pieces by their corners, sorted into boxes in boxes.
#[derive(Clone, Debug)]
pub struct PieceTree<const D: usize> {
    pieces: Vec<[[f64; D]; D]>,
    branches: Vec<Branch<D>>,
}

/// Some of the pieces, one after the other.
#[derive(Clone, Debug)]
struct Branch<const D: usize> {
    corners: Corners<D>,
    start: usize,
    end: usize,
    /// The number of the second half; the first half comes next. None for a leaf.
    second: Option<usize>,
    /// The sum of normals of the pieces' sizes, the centre, and how far corners are from it.
    normal: [f64; D],
    centre: [f64; D],
    reach: f64,
}

impl<const D: usize> PieceTree<D> {
    /// A tree of pieces; their outward side is that of a [`RigidSurface`](crate::mesh::RigidSurface).
    pub fn new(mut pieces: Vec<[[f64; D]; D]>) -> Self {
        let mut branches = Vec::new();
        if !pieces.is_empty() {
            grow(&mut pieces, 0, &mut branches);
        }
        PieceTree { pieces, branches }
    }

    /// The distance of a point to the nearest piece \[length\]: infinite without pieces.
    pub fn distance(&self, x: &[f64; D]) -> f64 {
        let mut best = f64::INFINITY;
        if !self.branches.is_empty() {
            self.search(0, x, &mut best);
        }
        best
    }

    fn search(&self, number: usize, x: &[f64; D], best: &mut f64) {
        let Branch { start, end, second, .. } = self.branches[number];
        let Some(second) = second else {
            for piece in &self.pieces[start..end] {
                *best = best.min(to_piece(x, piece));
            }
            return;
        };
        let mut halves = [number + 1, second].map(|half| (to_box(x, &self.branches[half].corners), half));
        if halves[1].0 < halves[0].0 {
            halves.swap(0, 1);
        }
        for (least, half) in halves {
            if least < *best {
                self.search(half, x, best);
            }
        }
    }

    /// Number of times that the pieces, if they are closed, go around a point: 1 inside of a surface with its outward side outside, 0 outside.
    /// Points on the pieces have either number.
    pub fn winding(&self, x: &[f64; D]) -> f64 {
        if self.branches.is_empty() {
            return 0.0;
        }
        let whole = if D == 2 { 2.0 * PI } else { 4.0 * PI };
        let near = self.angle(0, x, FAR) / whole;
        // Far pieces that are taken together have an error, which cannot matter next to a whole number.
        if (near - near.round()).abs() < 0.25 {
            return near.round();
        }
        (self.angle(0, x, f64::INFINITY) / whole).round()
    }

    /// The signed angle at which some pieces are seen from a point.
    fn angle(&self, number: usize, x: &[f64; D], far: f64) -> f64 {
        let Branch { start, end, second, normal, centre, reach, .. } = &self.branches[number];
        let off = minus(centre, x);
        let away = inner(&off, &off).sqrt();
        if away > far * reach {
            return inner(&off, normal) / away.powi(D as i32);
        }
        match second {
            Some(second) => self.angle(number + 1, x, far) + self.angle(*second, x, far),
            None => self.pieces[*start..*end].iter().map(|piece| angle_of(x, piece)).sum(),
        }
    }
}

/// Adds the branches of pieces that begin at `start`, and sorts these.
fn grow<const D: usize>(pieces: &mut [[[f64; D]; D]], start: usize, branches: &mut Vec<Branch<D>>) {
    let (mut lower, mut upper) = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
    let (mut normal, mut centre, mut size) = ([0.0; D], [0.0; D], 0.0);
    for piece in pieces.iter() {
        let own = long_normal(piece).map(|n| if D == 2 { n } else { 0.5 * n });
        let own_size = inner(&own, &own).sqrt();
        size += own_size;
        for k in 0..D {
            normal[k] += own[k];
            for x in piece {
                (lower[k], upper[k]) = (lower[k].min(x[k]), upper[k].max(x[k]));
                centre[k] += own_size * x[k] / D as f64;
            }
        }
    }
    centre = std::array::from_fn(|k| if size > 0.0 { centre[k] / size } else { lower[k] });
    let corners = pieces.iter().flatten();
    let reach = corners.map(|x| distance(x, &centre)).fold(0.0, f64::max);
    let (number, end) = (branches.len(), start + pieces.len());
    branches.push(Branch { corners: (lower, upper), start, end, second: None, normal, centre, reach });
    if pieces.len() > LEAF {
        let wide = |k: &usize| upper[*k] - lower[*k];
        let axis = (0..D).max_by(|a, b| wide(a).total_cmp(&wide(b))).unwrap_or(0);
        let place = |piece: &[[f64; D]; D]| piece.iter().map(|x| x[axis]).sum::<f64>();
        let middle = pieces.len() / 2;
        pieces.select_nth_unstable_by(middle, |a, b| place(a).total_cmp(&place(b)));
        let (first, second) = pieces.split_at_mut(middle);
        grow(first, start, branches);
        branches[number].second = Some(branches.len());
        grow(second, start + middle, branches);
    }
}

fn minus<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn inner<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The outward normal of the length of a segment, or of twice a triangle's area.
pub fn long_normal<const D: usize>(corners: &[[f64; D]; D]) -> [f64; D] {
    let along = minus(&corners[1], &corners[0]);
    if D == 2 {
        return std::array::from_fn(|i| if i == 0 { along[1] } else { -along[0] });
    }
    let across = minus(&corners[D - 1], &corners[0]);
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % D, (i + 2) % D);
        along[j] * across[k] - along[k] * across[j]
    })
}

/// The angle at which a point sees a piece, positive from behind. In space it is that of A. Van Oosterom and J. Strackee (1983).
fn angle_of<const D: usize>(x: &[f64; D], piece: &[[f64; D]; D]) -> f64 {
    let seen = piece.map(|corner| minus(&corner, x));
    // The normal of a piece times any of its points is the determinant of its corners.
    let determinant = inner(&seen[0], &long_normal(&seen));
    let (a, b, c) = (&seen[0], &seen[1], &seen[D - 1]);
    if D == 2 {
        return determinant.atan2(inner(a, b));
    }
    let [la, lb, lc] = [a, b, c].map(|seen| inner(seen, seen).sqrt());
    2.0 * determinant.atan2(la * lb * lc + inner(a, b) * lc + inner(b, c) * la + inner(c, a) * lb)
}

/// The distance of a point to a box, zero inside.
fn to_box<const D: usize>(x: &[f64; D], (lower, upper): &Corners<D>) -> f64 {
    (0..D).map(|k| (lower[k] - x[k]).max(x[k] - upper[k]).max(0.0).powi(2)).sum::<f64>().sqrt()
}

/// The distance of a point to a segment in the plane or a triangle in space.
fn to_piece<const D: usize>(x: &[f64; D], piece: &[[f64; D]; D]) -> f64 {
    let edges = (0..D).map(|k| to_segment(x, &piece[k], &piece[(k + 1) % D]));
    let on_edges = edges.fold(f64::INFINITY, f64::min);
    if D == 2 {
        return on_edges;
    }
    // Inside the triangle the foot on its plane is the nearest.
    let (e, f, r) = (minus(&piece[1], &piece[0]), minus(&piece[2], &piece[0]), minus(x, &piece[0]));
    let (ee, ef, ff, er, fr) = (inner(&e, &e), inner(&e, &f), inner(&f, &f), inner(&e, &r), inner(&f, &r));
    let determinant = ee * ff - ef * ef;
    let (s, t) = ((er * ff - fr * ef) / determinant, (fr * ee - er * ef) / determinant);
    if determinant > 0.0 && s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
        let foot: [f64; D] = std::array::from_fn(|k| r[k] - s * e[k] - t * f[k]);
        return inner(&foot, &foot).sqrt();
    }
    on_edges
}

fn to_segment<const D: usize>(x: &[f64; D], a: &[f64; D], b: &[f64; D]) -> f64 {
    let (mut square, mut product) = (0.0, 0.0);
    for k in 0..D {
        square += (b[k] - a[k]) * (b[k] - a[k]);
        product += (x[k] - a[k]) * (b[k] - a[k]);
    }
    let t = if square > 0.0 { (product / square).clamp(0.0, 1.0) } else { 0.0 };
    (0..D).map(|k| (x[k] - a[k] - t * (b[k] - a[k])).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_a_triangle() {
        let piece = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let cases = [
            ([0.2, 0.2, 0.5], 0.5),
            ([-3.0, 0.0, 4.0], 5.0),
            ([1.0, 1.0, 0.0], 0.5_f64.sqrt()),
            ([0.5, -2.0, 0.0], 2.0),
        ];
        for (x, expected) in cases {
            assert!((to_piece(&x, &piece) - expected).abs() < 1e-14, "{x:?}");
        }
        assert_eq!(PieceTree::<3>::new(vec![]).distance(&[0.0; 3]), f64::INFINITY);
    }

    /// Random triangles: the tree finds the nearest one, and far ones seen together have nearly their angle.
    #[test]
    fn tree_agrees_with_a_loop() {
        let mut state = 7_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let pieces: Vec<[[f64; 3]; 3]> = (0..500)
            .map(|_| {
                let at = [next(), next(), next()];
                [(); 3].map(|()| at.map(|x| x + 0.1 * next()))
            })
            .collect();
        let tree = PieceTree::new(pieces.clone());
        for _ in 0..300 {
            let x = [(); 3].map(|()| 3.0 * next() - 1.0);
            let nearest = pieces.iter().map(|piece| to_piece(&x, piece)).fold(f64::INFINITY, f64::min);
            assert_eq!(tree.distance(&x), nearest);
            let angle: f64 = pieces.iter().map(|piece| angle_of(&x, piece)).sum();
            assert!((tree.angle(0, &x, f64::INFINITY) - angle).abs() < 1e-12);
            assert!((tree.angle(0, &x, FAR) - angle).abs() < 0.05, "{} {angle}", tree.angle(0, &x, FAR));
        }
    }
}
