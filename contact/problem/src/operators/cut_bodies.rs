//! Forms of bodies that are cut from a mesh: ghost penalties, conditions on the boundary by Nitsche's method, and the gain of new holes.

use forms_fem::forms;

/// Ghost penalties: with them bounds do not depend on how a mesh is cut. The stiffness of the material is the caller's factor, 2μ + λ in
/// elasticity. Degrees 1 and 2.
///
/// ```
/// # use forms_fem::prelude::*;
/// #[forms]
/// mod membrane {
///     use forms_contact::operators::ghost_penalty::scalar_ghost;
///
///     #[includes(forms_contact::operators::ghost_penalty::Data)]
///     pub struct Data {}
///     #[cells]
///     pub struct Omega;
///     #[interior_facets]
///     pub struct Ghost;
///     pub fn stiffness(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
///         integral(Omega, dot(grad(u), grad(v))) + integral(Ghost, scalar_ghost(u, v))
///     }
/// }
/// let mesh = rectangle([-1.0; 2], [1.0; 2], [8, 8], CellShape::Triangle, 1)?;
/// let phi = Field::interpolate(&Space::scalar(&mesh, 1)?, |x| x[0].hypot(x[1]) - 0.7)?;
/// let (disc, space) = (Assembler::new(&mesh).cut_by(&phi)?, Space::scalar(&mesh, 2)?);
/// let regions = membrane::Regions::default().ghost("ghost");
/// let form = membrane::Model { data: membrane::data(), regions }.stiffness();
/// let u = Field::interpolate(&space, |x| x[0] * x[1])?;
/// let matrix = disc.tangent(&form, &[&u], &[&space])?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[forms]
pub mod ghost_penalty {
    /// The weights.
    pub struct Data {
        /// g₁, of jumps of the first derivatives.
        #[doc(alias = "g₁")]
        #[default(0.1)]
        pub ghost_slopes: Param,
        /// g₂, of jumps of the second ones; elements of degree 1 have none.
        #[doc(alias = "g₂")]
        #[default(0.01)]
        pub ghost_bends: Param,
    }

    /// g₁ h ⟦∂u/∂n⟧⟦∂v/∂n⟧, for degree 1.
    pub fn scalar_ghost_of_slopes(u: Scalar, v: Scalar) -> Scalar {
        ghost_slopes * avg(h) * dot(jump(grad(u)), n) * dot(jump(grad(v)), n)
    }

    /// g₁ h ⟦∂u/∂n⟧⟦∂v/∂n⟧ + g₂ h³ ⟦∂²u/∂n²⟧⟦∂²v/∂n²⟧.
    pub fn scalar_ghost(u: Scalar, v: Scalar) -> Scalar {
        scalar_ghost_of_slopes(u, v)
            + ghost_bends * pow(avg(h), 3) * dot(jump(hess(u)) * n, n) * dot(jump(hess(v)) * n, n)
    }

    /// g₁ h ⟦∂u/∂n⟧·⟦∂v/∂n⟧, for degree 1.
    pub fn vector_ghost_of_slopes(u: Vector, v: Vector) -> Scalar {
        ghost_slopes * avg(h) * dot(jump(grad(u)) * n, jump(grad(v)) * n)
    }

    /// ∂²w/∂n² of the jump of the second derivatives.
    fn bend(w: Vector) -> Vector {
        dot(jump(hess(w)), n) * n
    }

    /// g₁ h ⟦∂u/∂n⟧·⟦∂v/∂n⟧ + g₂ h³ ⟦∂²u/∂n²⟧·⟦∂²v/∂n²⟧.
    pub fn vector_ghost(u: Vector, v: Vector) -> Scalar {
        vector_ghost_of_slopes(u, v) + ghost_bends * pow(avg(h), 3) * dot(bend(u), bend(v))
    }
}

/// Prescribed displacements by Nitsche's method, for any material whose traction is linear in the displacement.
#[forms]
pub mod weak_dirichlet {
    pub use super::super::penalty::gamma;

    /// The parameters of the method, and the displacement.
    #[includes(super::super::penalty::Data, super::super::variant::Data)]
    pub struct Data {
        /// u_D, the displacement of the boundary \[length\].
        #[doc(alias = "u_D")]
        #[default(0)]
        pub prescribed: Given<Vector>,
    }

    /// −σ(u)n·v − θ σ(v)n·(u − u_D) + γ (u − u_D)·v, with the tractions σ(u)n and σ(v)n.
    pub fn dirichlet_density(traction_u: Vector, u: Vector, traction_v: Vector, v: Vector) -> Scalar {
        let miss = u - prescribed;
        -dot(traction_u, v) - theta * dot(traction_v, miss) + gamma() * dot(miss, v)
    }
}

/// The change of a criterion by a small round hole in a body of linear elasticity: the topological derivative of S. Garreau,
/// P. Guillaume, M. Masmoudi, SIAM J. Control Optim. 39 (2001).
///
/// With a hole of radius r inside the body, free of load, the criterion J = ∫ M(u) + … becomes J + r^D `of_hole` + o(r^D).
/// The adjoint state p has the sign of `discrete_adjoint`: J + R(u; p) is stationary, a(p, q) = −J′(u)q without contact, and p = −u for
/// the work of the loads. M does not depend on ∇u.
///
/// In two dimensions λ is that of plane strain, or 2λμ/(λ + 2μ) for plane stress. With it the work of the loads grows by 3πS²r²/E in
/// plane stress under a stress S along one axis.
#[forms]
pub mod topological_derivative {
    pub use super::super::linear_elastic::Data;
    use super::super::linear_elastic::stress;

    /// −|B| m − (work of the stresses around a hole), per r^D, with the unit ball B and `m` = M(u) − f·p for the load f per volume.
    pub fn of_hole(m: Scalar, u: Vector, p: Vector) -> Scalar {
        let work = inner(stress(u), eps(p));
        let traces = tr(stress(u)) * tr(eps(p));
        if D < 3 {
            -PI * m
                - PI * (lambda + 2 * mu) / (2 * mu * (lambda + mu)) * (4 * mu * work + (lambda - mu) * traces)
        } else {
            -4 / 3 * PI * m
                - PI * (lambda + 2 * mu) / (mu * (9 * lambda + 14 * mu))
                    * (20 * mu * work + (3 * lambda - 2 * mu) * traces)
        }
    }
}
