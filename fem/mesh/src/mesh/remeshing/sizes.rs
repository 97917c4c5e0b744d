//! Sizes of cells: small where a body is thin, growing from there.

use super::outline::{Arc, Outline};

/// Places per arc at which the thickness is measured.
const SAMPLES: usize = 3;
/// The cosine of normals beyond which two sides face each other.
const FACING: f64 = -0.5;

/// A length by place \[length\].
type SizeFunction<'a> = dyn Fn(&[f64; 2]) -> f64 + 'a;

/// The requested lengths of edges.
#[derive(Clone, Copy)]
pub struct Sizes<'a> {
    pub(super) largest: f64,
    pub(super) smallest: f64,
    across: f64,
    growth: f64,
    field: Option<&'a SizeFunction<'a>>,
}

impl<'a> Sizes<'a> {
    /// Edges of at most and at least these lengths; two of them across where a body is thin.
    pub fn between(smallest: f64, largest: f64) -> Self {
        Sizes { largest, smallest, across: 2.0, growth: 0.3, field: None }
    }

    /// Number of edges across where a body is thin \[1\].
    pub fn across(self, edges: f64) -> Self {
        Sizes { across: edges, ..self }
    }

    /// The change of the size per length \[1\].
    pub fn growing(self, growth: f64) -> Self {
        Sizes { growth, ..self }
    }

    /// No longer than a function of the place says \[length\]: where an estimate asks for small cells, say.
    pub fn no_longer_than(self, field: &'a dyn Fn(&[f64; 2]) -> f64) -> Self {
        Sizes { field: Some(field), ..self }
    }

    /// All sizes times a factor.
    pub fn scaled(self, factor: f64) -> Self {
        let Sizes { largest, smallest, across, .. } = self;
        Sizes { largest: factor * largest, smallest: factor * smallest, across: across / factor, ..self }
    }

    /// The first value without a meaning: its name, the value, and the requirement.
    pub(super) fn wrong(&self) -> Option<(&'static str, f64, &'static str)> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if !positive(self.smallest) {
            return Some(("the smallest size", self.smallest, "it must be positive"));
        }
        if !(self.largest >= self.smallest && self.largest.is_finite()) {
            return Some(("the largest size", self.largest, "it must be no less than the smallest"));
        }
        if !positive(self.across) {
            return Some(("the number of edges across", self.across, "it must be positive"));
        }
        (!positive(self.growth)).then_some(("the growth", self.growth, "it must be positive"))
    }

    /// The sizes inside an outline, as they are asked for along some of its arcs.
    pub(super) fn inside(self, outline: &Outline, along: &[&Arc]) -> SizeField<'a> {
        let sample = |arc: &Arc, k: usize| {
            let t = (k as f64 + 0.5) / SAMPLES as f64;
            let [x, y] = arc.direction(t);
            (arc.point(t), [-y, x])
        };
        let all: Vec<([f64; 2], [f64; 2])> =
            outline.arcs().flat_map(|arc| (0..SAMPLES).map(move |k| sample(arc, k))).collect();
        let thickness = |x: [f64; 2], inward: [f64; 2]| {
            let mut least = f64::INFINITY;
            for (y, other) in &all {
                let by = [y[0] - x[0], y[1] - x[1]];
                let depth = by[0] * inward[0] + by[1] * inward[1];
                if depth > 0.0 && inward[0] * other[0] + inward[1] * other[1] < FACING {
                    // The diameter of the circle that touches here and goes through there.
                    least = least.min((by[0] * by[0] + by[1] * by[1]) / depth);
                }
            }
            least
        };
        let mut small = vec![];
        for arc in along {
            for (x, inward) in (0..SAMPLES).map(|k| sample(arc, k)) {
                let size = thickness(x, inward) / self.across;
                if size < self.largest {
                    small.push((x, size.max(self.smallest)));
                }
            }
        }
        SizeField { sizes: self, small }
    }
}

/// Sizes that are known everywhere.
pub(super) struct SizeField<'a> {
    sizes: Sizes<'a>,
    /// Places of small sizes.
    small: Vec<([f64; 2], f64)>,
}

impl SizeField<'_> {
    /// The size at a place \[length\].
    pub fn at(&self, x: &[f64; 2]) -> f64 {
        let mut size = self.sizes.largest;
        for (place, own) in &self.small {
            size = size.min(own + self.sizes.growth * (x[0] - place[0]).hypot(x[1] - place[1]));
        }
        if let Some(field) = self.sizes.field {
            // What is no number asks for nothing.
            size = size.min(field(x));
        }
        size.max(self.sizes.smallest)
    }
}
