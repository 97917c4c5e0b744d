//! Polynomials of degree 2 in each direction on the unit segment, square and cube, by their Bernstein coefficients.
//!
//! Coefficients bound the polynomial, and their differences its slopes. The first axis runs fastest. All numbers are generic, so that
//! derivatives by the coefficients come from the same lines.

use crate::cut::number::Number;

/// The coefficients on a segment.
pub(super) type Line<R> = [R; 3];

/// From a coefficient to the next one along each axis.
const STEPS: [usize; 3] = [1, 3, 9];

/// The number of axes of a polynomial with this number of coefficients.
pub(super) fn dimension(count: usize) -> usize {
    match count {
        3 => 1,
        9 => 2,
        _ => 3,
    }
}

/// The first coefficients of all lines along an axis, in the order of a face across it.
#[inline(always)]
fn starts(count: usize, axis: usize) -> impl Iterator<Item = usize> {
    let step = STEPS[axis];
    (0..count).step_by(3 * step).flat_map(move |first| first..first + step)
}

/// The coefficients of the polynomial with values at the nodes of degree 2, in place.
pub(super) fn from_nodes<R: Number>(values: &mut [R]) {
    for (axis, step) in STEPS.into_iter().enumerate().take(dimension(values.len())) {
        for i in starts(values.len(), axis) {
            values[i + step] = values[i + step] * 2.0 - (values[i] + values[i + 2 * step]) * 0.5;
        }
    }
}

/// The coefficients of the polynomial of degree 1 in each direction with values at the vertices, in place; they are its values, too.
pub(super) fn from_vertices<R: Number>(values: &mut [R]) {
    for (axis, step) in STEPS.into_iter().enumerate().take(dimension(values.len())) {
        for i in starts(values.len(), axis) {
            values[i + step] = (values[i] + values[i + 2 * step]) * 0.5;
        }
    }
}

/// The least and the largest of some numbers.
fn range(numbers: impl Iterator<Item = f64>) -> [f64; 2] {
    numbers.fold([f64::MAX, f64::MIN], |[least, most], number| [least.min(number), most.max(number)])
}

/// Bounds of the polynomial.
pub(super) fn bounds<R: Number>(c: &[R]) -> [f64; 2] {
    range(c.iter().map(|entry| entry.value()))
}

/// Bounds of the slope along an axis.
pub(super) fn slope_bounds<R: Number>(c: &[R], axis: usize) -> [f64; 2] {
    let step = STEPS[axis];
    let differences = |i: usize| {
        let [a, b, d] = [0, 1, 2].map(|k| c[i + k * step].value());
        [2.0 * (b - a), 2.0 * (d - b)]
    };
    range(starts(c.len(), axis).flat_map(differences))
}

/// The largest second difference along an axis and any other.
pub(super) fn bending<R: Number>(c: &[R], axis: usize) -> f64 {
    let at = |index: usize, axis: usize| index / STEPS[axis] % 3;
    let mut largest = 0.0_f64;
    for (other, b) in STEPS.into_iter().enumerate().take(dimension(c.len())) {
        let a = STEPS[axis];
        for i in (0..c.len()).filter(|i| at(*i, axis) < 2 && at(*i, other) < 2) {
            if axis != other {
                largest = largest.max((c[i + a + b] - c[i + a] - c[i + b] + c[i]).value().abs());
            } else if at(i, axis) == 0 {
                largest = largest.max((c[i + 2 * a] - c[i + a] * 2.0 + c[i]).value().abs());
            }
        }
    }
    largest
}

/// The polynomial on both parts of its box that is divided at a place along an axis (de Casteljau).
pub(super) fn divided<R: Number, const N: usize>(c: &[R; N], axis: usize, at: f64) -> [[R; N]; 2] {
    let (mut low, mut high, step) = (*c, *c, STEPS[axis]);
    for i in starts(N, axis) {
        let [a, b, d] = [0, 1, 2].map(|k| c[i + k * step]);
        let between = |a: R, b: R| a * (1.0 - at) + b * at;
        let (ab, bd) = (between(a, b), between(b, d));
        let middle = between(ab, bd);
        (low[i + step], low[i + 2 * step]) = (ab, middle);
        (high[i], high[i + step]) = (middle, bd);
    }
    [low, high]
}

/// The polynomial on a face across an axis, the one at 0 or at 1.
pub(super) fn face<R: Number, const M: usize>(c: &[R], axis: usize, end: usize) -> [R; M] {
    let mut face = [R::zero(); M];
    for (entry, start) in face.iter_mut().zip(starts(c.len(), axis)) {
        *entry = c[start + 2 * end * STEPS[axis]];
    }
    face
}

/// The Bernstein polynomials.
fn basis<R: Number>(x: R) -> Line<R> {
    let y = -x + 1.0;
    [y * y, x * y * 2.0, x * x]
}

/// Their slopes.
fn basis_slopes<R: Number>(x: R) -> Line<R> {
    let y = -x + 1.0;
    [y * -2.0, (y - x) * 2.0, x * 2.0]
}

/// The polynomial on a line along an axis; `at` are the other coordinates, in order.
pub(super) fn line<R: Number>(c: &[R], axis: usize, at: &[R; 2]) -> Line<R> {
    let bases = [basis(at[0]), if c.len() == 27 { basis(at[1]) } else { [R::one(); 3] }];
    let (mut line, step) = ([R::zero(); 3], STEPS[axis]);
    for (k, start) in starts(c.len(), axis).enumerate() {
        let weight = bases[0][k % 3] * bases[1][k / 3];
        for (m, entry) in line.iter_mut().enumerate() {
            *entry += weight * c[start + m * step];
        }
    }
    line
}

/// The gradient at a point; of coordinates that are not there it is 0.
pub(super) fn gradient<R: Number>(c: &[R], place: &[R; 3]) -> [R; 3] {
    let dimension = dimension(c.len());
    let (values, slopes) = (place.map(basis), place.map(basis_slopes));
    std::array::from_fn(|axis| {
        if axis >= dimension {
            return R::zero();
        }
        let along = |k: usize| if k == axis { &slopes[k] } else { &values[k] };
        let entry = |(index, entry): (usize, &R)| {
            (0..dimension).fold(*entry, |product, k| product * along(k)[index / STEPS[k] % 3])
        };
        c.iter().enumerate().map(entry).sum()
    })
}

/// The zeros at which some polynomials on the unit segment change their signs, ascending.
#[derive(Clone, Copy)]
pub(super) struct Zeros<R> {
    list: [R; 8],
    count: usize,
}

impl<R: Number> Zeros<R> {
    /// The zeros of four polynomials at most.
    pub fn of(polynomials: &[Line<R>]) -> Self {
        let mut zeros = Zeros { list: [R::zero(); 8], count: 0 };
        polynomials.iter().for_each(|polynomial| zeros.add(polynomial));
        zeros
    }

    pub fn list(&self) -> &[R] {
        &self.list[..self.count]
    }

    fn push(&mut self, zero: R) {
        let mut place = self.count;
        while place > 0 && self.list[place - 1].value() > zero.value() {
            self.list[place] = self.list[place - 1];
            place -= 1;
        }
        self.list[place] = zero;
        self.count += 1;
    }

    /// The zeros of (1 − t)² a + 2 t (1 − t) b + t² c without cancellation. A value of 0 counts as positive.
    fn add(&mut self, &[first, middle, last]: &Line<R>) {
        let is_negative = first.value() < 0.0;
        let [a, b, c] = if is_negative { [-first, -middle, -last] } else { [first, middle, last] };
        if is_negative == (last.value() < 0.0) {
            let square = b * b - a * c;
            if b.value() < 0.0 && square.value() > 0.0 {
                let m = square.sqrt() - b;
                self.push(a / (a + m));
                self.push(m / (m + c));
            }
            return;
        }
        // One change of signs; now c ≤ 0 ≤ a.
        let square = b * b - a * c;
        if square.value() <= 0.0 {
            return self.push(if a.value() > 0.0 { R::one() } else { R::zero() });
        }
        let root = square.sqrt();
        self.push(if b.value() > 0.0 { (root + b) / (root + b - c) } else { a / (a - b + root) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cut::number::Varied;

    #[test]
    fn zeros_are_those_of_quadratics() {
        // (t − 0.25)(t − 0.75) in Bernstein form, and its negative.
        for sign in [1.0, -1.0] {
            let zeros = Zeros::of(&[[0.1875, -0.3125, 0.1875].map(|entry| sign * entry)]);
            let found = zeros.list();
            assert!((found[0] - 0.25_f64).abs() < 1e-15 && (found[1] - 0.75).abs() < 1e-15, "{found:?}");
        }
        // A zero near an end, with a coefficient in the middle that dwarfs it.
        let zeros = Zeros::of(&[[1e-18, -1.0, -3.0], [-2.0, 5.0, 1e-18]]);
        assert!((zeros.list()[0] / 5e-19 - 1.0_f64).abs() < 1e-12, "{:?}", zeros.list());
        // Values of zero are positive: the first never changes, the second does at its start, the third touches.
        assert!(Zeros::of(&[[0.0, 1.0, 0.0], [0.25, -0.25, 0.25]]).list().is_empty());
        assert_eq!(Zeros::of(&[[0.0, -1.0, -1.0]]).list(), [0.0]);
        assert_eq!(Zeros::of(&[[-1.0, -1.0, 0.0]]).list(), [1.0]);
        assert_eq!(Zeros::of(&[[0.0, 0.0, -1.0]]).list(), [0.0]);
    }

    #[test]
    fn parts_lines_and_gradients_are_those_of_the_polynomial() {
        let f = |x: &[f64; 3]| {
            0.3 - x[0] + 2.0 * x[0] * x[1] * x[2] - 1.5 * x[1] * x[1] * x[2] * x[2] + x[0] * x[0] * x[2]
        };
        let slope = |x: &[f64; 3]| {
            [
                -1.0 + 2.0 * x[1] * x[2] + 2.0 * x[0] * x[2],
                2.0 * x[0] * x[2] - 3.0 * x[1] * x[2] * x[2],
                2.0 * x[0] * x[1] - 3.0 * x[1] * x[1] * x[2] + x[0] * x[0],
            ]
        };
        let mut c: [f64; 27] =
            std::array::from_fn(|k| f(&[k % 3, k / 3 % 3, k / 9].map(|place| 0.5 * place as f64)));
        from_nodes(&mut c);
        let place = [0.3, 0.8, 0.45];
        let found = gradient(&c, &place);
        for axis in 0..3 {
            assert!((found[axis] - slope(&place)[axis]).abs() < 1e-14);
            let others: [f64; 2] = match axis {
                0 => [place[1], place[2]],
                1 => [place[0], place[2]],
                _ => [place[0], place[1]],
            };
            let value = |c: &[f64; 27], x: f64| -> f64 {
                line(c, axis, &others).iter().zip(basis(x)).map(|(c, b)| c * b).sum()
            };
            assert!((value(&c, place[axis]) - f(&place)).abs() < 1e-14);
            let [low, high] = divided(&c, axis, 0.3);
            for (half, x) in [(low, 0.3 * place[axis]), (high, 0.3 + 0.7 * place[axis])] {
                let mut at = place;
                at[axis] = x;
                assert!((value(&half, place[axis]) - f(&at)).abs() < 1e-14);
            }
        }
        let mut bilinear = [1.0, 0.0, 3.0, 0.0, 0.0, 0.0, -2.0, 0.0, 5.0];
        from_vertices(&mut bilinear);
        assert_eq!(bilinear, [1.0, 2.0, 3.0, -0.5, 1.75, 4.0, -2.0, 1.5, 5.0]);
    }

    #[test]
    fn zeros_have_derivatives() {
        for c in [[-0.4, 0.9, 0.2], [0.3, -0.7, 0.6], [0.5, -0.1, -0.3]] {
            let seeded = std::array::from_fn(|k| Varied::of_node(c[k], k));
            for by in 0..3 {
                let at = |step: f64| {
                    let mut moved = c;
                    moved[by] += step;
                    Zeros::of(&[moved])
                };
                let (next, last) = (at(1e-6), at(-1e-6));
                for (k, zero) in Zeros::<Varied>::of(&[seeded]).list().iter().enumerate() {
                    let difference = (next.list()[k] - last.list()[k]) / 2e-6;
                    assert!((zero.slopes[by] - difference).abs() < 1e-8);
                }
            }
        }
    }
}
