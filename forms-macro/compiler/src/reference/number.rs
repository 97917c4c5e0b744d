//! Nested dual numbers: real numbers with any number of infinitesimals ε₀, ε₁, …, each with ε² = 0.

/// Coefficients of the products of infinitesimals: entry `i` belongs to Π ε_k over the bits k of `i`.
/// The length is a power of two; missing entries are zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Number(Vec<f64>);

impl Number {
    pub fn real(value: f64) -> Self {
        Number(vec![value])
    }

    /// The coefficient without infinitesimals.
    pub fn value(&self) -> f64 {
        self.0[0]
    }

    /// `self + direction ε_level`; neither holds ε_level or a later one.
    pub fn moved(&self, direction: &Number, level: usize) -> Self {
        let (mut first, mut second) = (self.0.clone(), direction.0.clone());
        assert!(first.len() <= 1 << level && second.len() <= 1 << level, "ε_{level} is taken");
        first.resize(1 << level, 0.0);
        second.resize(1 << level, 0.0);
        first.extend(second);
        Number(first)
    }

    /// The coefficient of ε_level, the last infinitesimal in use.
    pub fn slope(&self, level: usize) -> Self {
        assert!(self.0.len() <= 2 << level, "an infinitesimal after ε_{level} is in use");
        match self.0.len() > 1 << level {
            true => Number(self.0[1 << level..].to_vec()),
            false => Number::real(0.0),
        }
    }

    /// `p + q ε` with the last infinitesimal; `None` for a real number.
    fn split(&self) -> Option<(Number, Number)> {
        let half = self.0.len() / 2;
        (half > 0).then(|| (Number(self.0[..half].to_vec()), Number(self.0[half..].to_vec())))
    }

    fn join(mut value: Number, slope: Number, half: usize) -> Self {
        value.0.resize(half, 0.0);
        value.0.extend(slope.0);
        value.0.resize(2 * half, 0.0);
        value
    }

    /// Of the products of infinitesimals, how many are held.
    pub fn length(&self) -> usize {
        self.0.len()
    }

    fn is_zero(&self) -> bool {
        self.0.iter().all(|entry| *entry == 0.0)
    }

    /// No infinitesimal takes part.
    pub fn is_real(&self) -> bool {
        self.0[1..].iter().all(|entry| *entry == 0.0)
    }

    /// The largest coefficient.
    pub fn magnitude(&self) -> f64 {
        self.0.iter().fold(0.0, |largest, entry| f64::max(largest, entry.abs()))
    }

    pub fn is_finite(&self) -> bool {
        self.0.iter().all(|entry| entry.is_finite())
    }

    pub fn plus(&self, other: &Number) -> Self {
        let (long, short) = if self.0.len() < other.0.len() { (other, self) } else { (self, other) };
        let mut sum = long.0.clone();
        sum.iter_mut().zip(&short.0).for_each(|(entry, addend)| *entry += addend);
        Number(sum)
    }

    pub fn scaled(&self, factor: f64) -> Self {
        Number(self.0.iter().map(|entry| factor * entry).collect())
    }

    pub fn minus(&self, other: &Number) -> Self {
        self.plus(&other.scaled(-1.0))
    }

    /// Products of disjoint sets of infinitesimals; ε² = 0.
    pub fn times(&self, other: &Number) -> Self {
        let mut product = vec![0.0; self.0.len().max(other.0.len())];
        for (i, a) in self.0.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            // All subsets of the infinitesimals that `i` does not hold, the largest first.
            let others = !i & (other.0.len() - 1);
            let mut j = others;
            loop {
                // A derivative that is not known is NaN; times zero it does not matter.
                if other.0[j] != 0.0 {
                    product[i | j] += a * other.0[j];
                }
                if j == 0 {
                    break;
                }
                j = (j - 1) & others;
            }
        }
        // A value that is not finite must stay visible where it is multiplied by zero.
        if !(self.is_finite() && other.is_finite()) {
            product[0] = self.0[0] * other.0[0];
        }
        Number(product)
    }

    /// f(p + q ε) = f(p) + f′(p) q ε, one infinitesimal at a time. Where q is zero, f′ is not asked.
    pub fn apply(&self, f: &dyn Fn(f64) -> f64, slope: &dyn Fn(&Number) -> Number) -> Self {
        let Some((p, q)) = self.split() else { return Number::real(f(self.0[0])) };
        let half = p.0.len();
        let value = p.apply(f, slope);
        let change = if q.is_zero() { Number::real(0.0) } else { slope(&p).times(&q) };
        Number::join(value, change, half)
    }

    /// 1 / a, with (1/a)′ = −(1/a)².
    pub fn reciprocal(&self) -> Self {
        self.apply(&|a| 1.0 / a, &|a| {
            let inverse = a.reciprocal();
            inverse.times(&inverse).scaled(-1.0)
        })
    }

    pub fn over(&self, divisor: &Number) -> Self {
        self.times(&divisor.reciprocal())
    }
}
