//! Elastic bodies, loads and gaps, to which a formulation adds its contact terms.

use forms_fem::forms;

#[doc(inline)]
pub use self::body::*;

/// Linear elasticity, in plane strain or with axial symmetry in (r, z), and what contact terms are written in. A formulation imports functions,
/// data and regions, and adds its form to [`balance`](fn@balance).
#[forms(dimension = 2)]
pub mod body {
    /// Data of the bodies, the loads and the obstacle.
    pub struct Data {
        /// λ \[stress\].
        pub lambda: Given<Scalar>,
        /// μ \[stress\].
        pub mu: Given<Scalar>,
        /// E, the scale of a formulation's parameters \[stress\].
        pub young: Given<Scalar>,
        /// 1 for bodies of revolution with x = (r, z), 0 in the plane.
        #[default(0)]
        pub axial: Param,
        /// Force per area on the loaded boundary.
        #[default(0)]
        pub traction: Given<Vector>,
        /// Pressure on the loaded boundary.
        #[default(0)]
        pub wall_pressure: Param,
        /// Force per volume.
        #[default(0)]
        pub body_force: Given<Vector>,
        /// The factor of the inertia in a step of time, density over time².
        #[default(0)]
        pub inertia: Given<Scalar>,
        /// The displacement at which a step has no inertia \[length\].
        #[default(0)]
        pub coasted: Given<Vector>,
        /// n_y, unit vector into a rigid obstacle.
        #[default(0)]
        pub obstacle_normal: Given<Vector>,
        /// Distance to a rigid obstacle along n_y \[length\].
        #[default(0)]
        pub obstacle_gap: Given<Scalar>,
    }

    /// All bodies.
    #[cells]
    pub struct Omega;
    /// The loaded boundary.
    #[facets]
    pub struct Loaded;
    /// The boundary that may touch a rigid obstacle.
    #[facets]
    pub struct Surface;
    /// Surfaces of two bodies that may touch.
    #[pairs]
    pub struct Touch;

    /// 1 in the plane, 2π r with axial symmetry.
    pub fn weight() -> Scalar {
        1 + axial * (6.283185307179586 * x[0] - 1)
    }

    /// The strain around the axis; 0 in the plane.
    fn hoop(w: Vector) -> Scalar {
        axial * w[0] / sqrt(x[0] * x[0] + (1 - axial))
    }

    /// σ(w) in the plane of the mesh.
    pub fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * (div(w) + hoop(w)) * I
    }

    fn hoop_stress(w: Vector) -> Scalar {
        2 * mu * hoop(w) + lambda * (div(w) + hoop(w))
    }

    fn work(u: Vector, v: Vector) -> Scalar {
        weight() * (inner(stress(u), eps(v)) + hoop_stress(u) * hoop(v))
    }

    /// a(u,v) − ℓ(v), in a step of time with the inertia.
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, work(u, v) + weight() * dot(inertia * (u - coasted) - body_force, v))
            - integral(Loaded, weight() * dot(traction - wall_pressure * n, v))
    }

    /// ½ ∫ ρ |w|² of velocities w, with ρ for the inertia.
    pub fn kinetic(w: State<Vector>) -> Functional {
        integral(Omega, weight() * inertia * dot(w, w) / 2)
    }

    /// The work of the forces per volume.
    pub fn work_of_body_force(u: State<Vector>) -> Functional {
        integral(Omega, weight() * dot(body_force, u))
    }

    /// ½ a(u,u).
    pub fn energy(u: State<Vector>) -> Functional {
        integral(Omega, work(u, u) / 2)
    }

    /// The gap to the obstacle.
    pub fn obstacle_distance(w: Vector) -> Scalar {
        obstacle_gap - dot(w, obstacle_normal)
    }

    /// n_y where the surface is, for any displacement.
    pub fn normal_at(w: Vector) -> Vector {
        obstacle_normal + 0 * w
    }

    /// E/h on the boundary that faces the obstacle: the scale of a stiffness per area.
    pub fn stiffness() -> Scalar {
        young / h
    }

    /// σ_n on the boundary that faces the obstacle.
    pub fn obstacle_stress(w: Vector) -> Scalar {
        dot(stress(w) * n, obstacle_normal)
    }

    /// The gap between bodies.
    pub fn distance(w: Vector) -> Scalar {
        gap - dot(jump(w), toward)
    }

    /// Gaps to the obstacle, which are printed at points that switch back and forth.
    pub fn gap_to_obstacle(u: Unknown<Vector>) -> Functional {
        integral(Surface, obstacle_distance(u))
    }

    /// Gaps between bodies, as [`gap_to_obstacle`](fn@gap_to_obstacle).
    pub fn gap_of_bodies(u: Unknown<Vector>) -> Functional {
        integral(Touch, distance(u))
    }

    /// σ_n of the own body at a pair.
    pub fn own_stress(w: Vector) -> Scalar {
        dot(this(stress(w) * n), toward)
    }

    /// E/h on the boundary of the own body: the scale of a stiffness per area.
    pub fn own_stiffness() -> Scalar {
        this(young) / this(h)
    }

    /// The weight at the own side of a pair.
    pub fn own_weight() -> Scalar {
        this(weight())
    }

    /// ∫ v·n over a surface.
    pub fn pushed(v: Test<Vector>) -> Form {
        integral(Surface, weight() * dot(v, n))
    }

    /// A number on a surface, given by a field.
    pub fn known(l: State<Scalar>) -> Scalar {
        l
    }
}
