//! Contact between bodies by multipliers on the own facets: conditions that hold against every function of the multipliers' space.

use forms_fem::forms;

/// Terms that multipliers add to the balance of two bodies, without friction with the pressure p and the mean gap g, with friction with vectors m and d.
/// Conditions hold for each function of the multipliers' space and its coefficient, at nodes with degree 1, for any γ, which decides only how Newton's
/// method tells what touches and what slides.
///
/// At its pairs a law adds p n_x·⟦v⟧ + gap (r − q), or with friction [`moved`](fn@multipliers::moved) tested with r − q and the work of the
/// [`multiplier_traction`](fn@multipliers::multiplier_traction). A vector m has the pressure along an axis a and the traction of friction across it: m = p a + t. At each point the
/// smallest rotation that takes a to the normal n_x takes t to the tangent plane. The means d = g a + s are those of the gap and of the slip.
#[forms]
pub mod multipliers {
    use super::super::friction::slip_limit;

    /// Friction, the axis, and what holds multipliers that nothing faces.
    #[includes(super::super::friction::Data)]
    pub struct Data {
        /// δ, the part with which the equation p = 0 counts at each node, so that what is not covered has no pressure. A mean gap is off by δ p/γ,
        /// with friction by 10⁻¹⁵ p/γ more.
        #[doc(alias = "δ")]
        #[default(0.000000000000000001)]
        pub uncovered: Param,
        /// a, a unit vector along which m has the pressure; the first axis unless it is given. In space the own surface's outward normal
        /// must nowhere be near −a.
        #[doc(alias = "a")]
        #[default(0)]
        pub axis: Param<Vector>,
    }

    /// The own surface, where the multipliers are; integrals over it are sums over the multipliers' nodes, and read coefficients.
    #[facets(vertices)]
    pub struct Own;

    /// The unit vector a.
    fn pressure_axis() -> Vector {
        if dot(axis, axis) > 0 { axis } else { I[0] }
    }

    /// t, which is normal to a, turned into the plane that is normal to n_x.
    fn turned(t: Vector, n_x: Vector) -> Vector {
        let a = pressure_axis();
        let cosine = dot(a, n_x);
        // In the plane the rotation exists for opposite directions, too.
        if D > 2 { t - dot(n_x, t) / (1 + cosine) * (a + n_x) } else { cosine * t - dot(n_x, t) * a }
    }

    /// a·n, the cosine of the angle between the axis and the outward normal.
    pub fn axis_cosine() -> Scalar {
        dot(pressure_axis(), n)
    }

    /// p, the pressure of the multiplier m.
    pub fn pressure_of(m: Vector) -> Scalar {
        dot(m, pressure_axis())
    }

    /// t, the part of m that is normal to the axis.
    fn across(m: Vector) -> Vector {
        m - pressure_of(m) * pressure_axis()
    }

    /// T = −p n_x + t, the traction of the opposite body on this one, per reference area.
    pub fn multiplier_traction(m: Vector, n_x: Vector) -> Vector {
        turned(across(m), n_x) - pressure_of(m) * n_x
    }

    /// Gap and slip along the directions of a multiplier q: g (q·a) + s·t(q).
    pub fn moved(distance: Scalar, slip: Vector, q: Vector, n_x: Vector) -> Scalar {
        distance * pressure_of(q) + dot(slip, turned(across(q), n_x))
    }

    /// Σ_i D_i {\[g_i − p_i/γ\]₊ q_i − g_i r_i}: p_i ≥ 0, g_i ≥ 0 and p_i g_i = 0 for each function, and g_i is the mean gap.
    pub fn conditions(p: Scalar, g: Scalar, q: Scalar, r: Scalar, gamma: Scalar) -> Form {
        integral(Own, allowed_gap(p, g, gamma) * q - g * r)
    }

    /// The conditions with friction: also |t_i| ≤ s₀ + κ p_i at each node, with no mean slip where it is less, else one against t_i.
    pub fn frictional_conditions(m: Vector, d: Vector, q: Vector, r: Vector, gamma: Scalar) -> Form {
        integral(Own, dot(allowed_means(m, d, gamma), q) - dot(d, r))
    }

    /// (\[p − γ g\]₊ − p)/γ + g = \[g − p/γ\]₊, less δ p/γ: the mean gap that contact allows, 0 where the surfaces press. If it is the mean gap g, then p ≥ 0,
    /// g ≥ 0 and p g = 0.
    pub fn allowed_gap(p: Scalar, g: Scalar, gamma: Scalar) -> Scalar {
        pos_part(g - p / gamma) - uncovered * p / gamma
    }

    /// The means that contact and friction allow, gap and slip in one vector: d − m/γ where the surfaces do not press, 0 where they stick, and
    /// (Π_b(t − γ s) − (t − γ s))/γ where they slip, with the bound b of |t|; the last two less what δ adds. Without tractions they stick.
    pub fn allowed_means(m: Vector, d: Vector, gamma: Scalar) -> Vector {
        let pressure = pressure_of(m) - gamma * pressure_of(d);
        let trial = across(m) - gamma * across(d);
        let bound = slip_limit(pressure);
        if pressure < 0 {
            d - m / gamma
        } else if norm(trial) <= bound {
            -held(m) / gamma
        } else {
            (bound * normalize(trial) - trial - held(m)) / gamma
        }
    }

    /// (δ + 10⁻¹⁵)(Σ_k m_k − m_i), which vanishes only with m, so that nothing is borne where nothing is faced. Solvers know a saddle point by zeros on the
    /// diagonal of its matrix, hence the other components. Where nodes slip, parts of m along the axis and across it add up to rounding that
    /// would hide δ, hence 10⁻¹⁵.
    fn held(m: Vector) -> Vector {
        (uncovered + 1e-15) * (dot([1; D], m) * [1; D] - m)
    }
}
