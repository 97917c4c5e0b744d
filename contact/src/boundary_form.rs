//! The paper's shape derivative (11) and its discrete counterpart (20), integrals over the boundary that moves, with what
//! they lack where this is not a Neumann boundary. They are derivatives of the continuous problem: with discrete states
//! they approach the derivative of J_h ([`crate::shape_gradient`]) as the mesh is refined.

use forms_fem::forms;

/// Θ moves the boundary; only Θ·n counts. κ is div n. u and p are the displacement and an adjoint state.
#[forms]
pub mod boundary_form {
    use crate::nitsche::{
        boundary_criterion, boundary_slope, cell_criterion, contact_indicator, contact_pressure,
        normal_stress,
    };
    use crate::operators::linear_elastic::stress;
    use crate::operators::obstacle::{gamma, normal_displacement, penetration};

    /// u_D, in addition to the data of [`crate::forms`].
    #[includes(crate::nitsche::Data)]
    pub struct Data {
        /// u_D, as a function of position near the clamped boundary.
        #[doc(alias = "u_D")]
        pub imposed: Given<Vector>,
    }

    /// The part of Γ_m without load.
    #[facets]
    pub struct Free;
    /// The part of Γ_m with a traction g_N.
    #[facets]
    pub struct Loaded;
    /// The part of Γ_m where u = u_D.
    #[facets]
    pub struct Clamped;
    /// The part of Γ_m that may touch the obstacle.
    #[facets]
    pub struct Contact;

    /// M(u) + κ N(u) + ∇N(u)·n: what the criterion contributes at fixed u.
    fn explicit(u: Vector) -> Scalar {
        cell_criterion(u) + curvature * boundary_criterion(u) + dot(grad(boundary_criterion(u)), n)
    }

    /// σ(u):ε(p) − f·p.
    fn energy(u: Vector, p: Vector) -> Scalar {
        inner(stress(u), eps(p)) - dot(body_force, p)
    }

    /// (11) on a free boundary, with continuous states: ∫ Θ·n (M(u) + κ N(u) + ∂_n N(u) + σ(u):ε(p) − f·p). The same integral
    /// with the discrete u_h and p_h is (20).
    #[doc(alias = "(20)")]
    pub fn on_free(u: State<Vector>, p: State<Vector>, Theta: State<Vector>) -> Functional {
        integral(Free, dot(Theta, n) * (explicit(u) + energy(u, p)))
    }

    /// `on_free` as a linear form in Θ: its vector is the gradient by nodes.
    pub fn gradient_on_free(u: State<Vector>, p: State<Vector>, Theta: Test<Vector>) -> Form {
        integral(Free, dot(Theta, n) * (explicit(u) + energy(u, p)))
    }

    /// (11) on a loaded boundary.
    pub fn on_loaded(u: State<Vector>, p: State<Vector>, Theta: State<Vector>) -> Functional {
        integral(
            Loaded,
            dot(Theta, n)
                * (explicit(u) + energy(u, p)
                    - curvature * dot(p, traction)
                    - dot(grad(dot(p, traction)), n)),
        )
    }

    /// On a clamped boundary, u_D fixed in space: −σ(p)n·∂_n(u − u_D) for σ(u):ε(p), less N′·∂_n(u − u_D).
    pub fn on_clamped(u: State<Vector>, p: State<Vector>, Theta: State<Vector>) -> Functional {
        let slope = grad(u - imposed) * n;
        integral(
            Clamped,
            dot(Theta, n) * (explicit(u) - dot(stress(p) * n, slope) - dot(boundary_slope(u), slope)),
        )
    }

    /// On the contact boundary: (11) with −σ_n(u) ∂_n(p_n) − (σ_n(p) + N′_n) ∂_n(u_n − g) where the body touches. For the two
    /// stresses Nitsche's method has −\[·\]₋ and σ_n(p) + N′_n − γ p_n.
    pub fn on_contact(u: State<Vector>, p: State<Vector>, Theta: State<Vector>) -> Functional {
        let pulled =
            normal_stress(p) + dot(boundary_slope(u), obstacle_normal) - gamma() * normal_displacement(p);
        integral(
            Contact,
            dot(Theta, n)
                * (explicit(u) + energy(u, p) + contact_pressure(u) * dot(grad(normal_displacement(p)), n)
                    - heaviside(contact_indicator(u)) * pulled * dot(grad(penetration(u)), n)),
        )
    }

    /// ∫(Θ·n)(M + κ N + ∂_n N) on a free boundary: the part of its derivative without the adjoint state.
    pub fn explicit_on_free(u: State<Vector>, Theta: State<Vector>) -> Functional {
        integral(Free, dot(Theta, n) * explicit(u))
    }
}
