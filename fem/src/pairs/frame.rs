//! Points of surfaces with tangents and normals, and flat facets.

/// The flat facet that has three of a facet's corners, in the plane both, and how far the facet is from it.
#[derive(Clone, Debug)]
pub(super) struct FlatFacet<const D: usize> {
    pub origin: [f64; D],
    pub frame: Frame<D>,
    /// The most that a point of the facet is away from the flat one's of the same coordinates; none where it is not known.
    pub away: Option<f64>,
    /// The lengths of the dual tangents.
    pub slopes: [f64; 2],
}

/// The normal of a surface and the vectors dual to its tangents.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<const D: usize> {
    /// Of the length of the surface element.
    pub normal: [f64; D],
    pub dual: [[f64; D]; 2],
}

/// A point of a facet with the derivatives of its position.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePoint<const D: usize> {
    pub position: [f64; D],
    /// Derivatives along the facet's own coordinates; the second is zero in the plane.
    pub tangents: [[f64; D]; 2],
}

pub(super) fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|k| a[k] * b[k]).sum()
}

pub(super) fn minus<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|k| a[k] - b[k])
}

pub(super) fn unit<const D: usize>(a: &[f64; D]) -> [f64; D] {
    let length = dot(a, a).sqrt();
    a.map(|a| a / length)
}

fn cross<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|i| a[(i + 1) % D] * b[(i + 2) % D] - a[(i + 2) % D] * b[(i + 1) % D])
}

impl<const D: usize> SurfacePoint<D> {
    /// The outward normal, of the length of the surface element.
    pub fn long_normal(&self) -> [f64; D] {
        let [s, t] = &self.tangents;
        match D {
            2 => std::array::from_fn(|i| if i == 0 { s[1] } else { -s[0] }),
            _ => cross(s, t),
        }
    }

    /// The outward unit normal.
    pub fn normal(&self) -> [f64; D] {
        unit(&self.long_normal())
    }

    pub fn frame(&self) -> Frame<D> {
        let normal = self.long_normal();
        let square = dot(&normal, &normal);
        let [s, t] = &self.tangents;
        let dual = match D {
            2 => [s.map(|s| s / square), [0.0; D]],
            _ => [cross(t, &normal).map(|s| s / square), cross(&normal, s).map(|t| t / square)],
        };
        Frame { normal, dual }
    }

    /// The surface element.
    pub fn element(&self) -> f64 {
        let [s, t] = &self.tangents;
        if D == 2 {
            return dot(s, s).sqrt();
        }
        let (first, mixed, last) = (dot(s, s), dot(s, t), dot(t, t));
        (first * last - mixed * mixed).max(0.0).sqrt()
    }
}

impl<const D: usize> Frame<D> {
    /// The coordinates along the tangents at which a line through a point along n meets the tangent plane; `off` is the vector
    /// from where the frame stands to the point. No numbers where the line runs along the plane.
    pub fn met_by(&self, off: &[f64; D], n: &[f64; D]) -> [f64; 2] {
        let gap = -dot(&self.normal, off) / dot(&self.normal, n);
        let foot: [f64; D] = std::array::from_fn(|k| off[k] + gap * n[k]);
        self.dual.each_ref().map(|dual| dot(dual, &foot))
    }
}

impl<const D: usize> FlatFacet<D> {
    /// The intersection with a line through x along n, in coordinates of the facet.
    pub fn met_by(&self, x: &[f64; D], n: &[f64; D]) -> [f64; 2] {
        self.frame.met_by(&minus(x, &self.origin), n)
    }

    /// The most by which coordinates at which a line along n meets the facet differ from those at which it meets the flat one.
    pub fn doubt(&self, n: &[f64; D]) -> [f64; 2] {
        let Some(away) = self.away else { return [f64::INFINITY; 2] };
        if away == 0.0 {
            return [0.0; 2];
        }
        let normal = &self.frame.normal;
        let slant = (dot(normal, normal).sqrt() / dot(normal, n)).abs();
        self.slopes.map(|slope| away * slope * (1.0 + slant))
    }
}
