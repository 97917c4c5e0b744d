//! The threshold of γ₀. For θ > −1 Nitsche's method is monotone only if, on every contact cell,
//! γ ≥ s (1+θ)²/4 λ_T with s > 1, where λ_T is the largest eigenvalue of ∫_F σ_n(v)² = λ ∫_T σ(v):ε(v)
//! modulo rigid motions (F runs over the contact facets of T). With friction the whole traction counts: ∫_F |σ(v)n|².
//!
//! λ_T has the scale of the normal stress, λ + 2μ, and not that of Young's modulus: for ν near ½ the two are far apart, and
//! [`usual_gamma0`] is the one to take. [`ContactProblem::direct`](crate::ContactProblem::direct) looks at the threshold of each law that has one, and
//! [`Solved::notes`](forms_fem::solve::Solved::notes), or the error of a solve that failed, names it where γ₀ is smaller.

mod eigenvalue;
mod of_laws;

pub use self::of_laws::{largest_eigenvalues, of_law, on_cells_of_facets, required_gamma0, threshold};

/// γ₀ = 10 (λ + 2μ) \[stress\] of an isotropic material with Lamé's parameters λ and μ: above the threshold on cells of usual shapes up
/// to degree 2, for any θ of −1, 0, 1 and any Poisson's ratio. For ν = 0.3 it is 13.5 E, for ν = 0.4995 it is 3340 E.
///
/// Stretched cells and higher degrees may ask for more; a solution's notes say so ([`Threshold`]).
pub fn usual_gamma0(lambda: f64, mu: f64) -> f64 {
    10.0 * (lambda + 2.0 * mu)
}

/// The threshold of γ₀ for Nitsche's method on a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Threshold {
    /// The γ₀ \[stress\] at which s = 1 on the worst contact cell; zero for θ = −1, which has no threshold.
    pub required: f64,
    /// The problem's γ₀.
    pub gamma0: f64,
    /// The problem's θ.
    pub theta: f64,
    /// The mean of the worst cell's vertices; none for θ = −1.
    pub worst: Option<Vec<f64>>,
}

impl Threshold {
    /// A warning that names both values and the worst cell, where γ₀ is not above the threshold.
    pub fn warning(&self) -> Option<String> {
        let Threshold { required, gamma0, theta, worst } = self;
        (gamma0 <= required).then(|| {
            format!(
                "gamma0 = {gamma0} is below the threshold of Nitsche's method: at theta = {theta} the contact cell at \
                 {:?} asks for more than {required:.6}; the results cannot be relied on. The scale of gamma0 is that of \
                 the normal stress, lambda + 2 mu: 10 times that is enough as a rule",
                worst.as_deref().unwrap_or_default()
            )
        })
    }
}
