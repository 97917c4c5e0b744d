//! Forms of surfaces that touch or part: contact with obstacles, friction, cohesion.

use forms_fem::forms;

/// A rigid obstacle whose normal is known.
#[forms]
pub mod flat_obstacle {
    /// The place of the obstacle.
    pub struct Data {
        /// n_y, unit normal pointing into the obstacle.
        #[doc(alias = "n_y")]
        pub obstacle_normal: Given<Vector>,
        /// g, the initial gap \[length\].
        #[doc(alias = "g")]
        pub gap: Given<Scalar>,
    }
}

/// A rigid obstacle whose normal is known, with the parameter of Nitsche's method and of penalties.
#[forms]
pub mod rigid_flat {
    /// The parameter, and the place of the obstacle.
    #[includes(super::super::penalty::Data, super::flat_obstacle::Data)]
    pub struct Data {}
}

/// Frictionless contact with a rigid obstacle, for any material: what Nitsche's method needs is the material's normal
/// stress σ_n, which the operators take as an argument. Equation numbers are those of Bretin et al. (2023), hal-03936245.
///
/// Signs: n_y points into the obstacle; the gap is positive when apart; σ_n ≤ 0 presses.
#[forms]
pub mod obstacle {
    pub use super::super::penalty::gamma;

    /// The obstacle, and the parameters of the method.
    #[includes(super::super::rigid_flat::Data)]
    pub struct Data {
        /// θ: −1 skew-symmetric, 0 incomplete, 1 symmetric variant.
        pub theta: Param,
    }

    /// u_n = w·n_y.
    #[doc(alias = "·_n")]
    pub fn normal_displacement(w: Vector) -> Scalar {
        dot(w, obstacle_normal)
    }

    /// σ_n = (σ n)·n_y of a stress σ.
    pub fn normal_component(sigma: Tensor) -> Scalar {
        dot(sigma * n, obstacle_normal)
    }

    /// u_n − g: positive where the body would enter the obstacle.
    pub fn penetration(w: Vector) -> Scalar {
        normal_displacement(w) - gap
    }

    /// g − u_n: the gap of the deformed body.
    pub fn current_gap(w: Vector) -> Scalar {
        gap - normal_displacement(w)
    }

    /// P_γ = σ_n − γ (w_n − g), whose negative part in (15) is the pressure; −β_h of the paper.
    #[doc(alias = "P_γ")]
    pub fn augmented_stress(sigma_n: Scalar, w: Vector) -> Scalar {
        sigma_n - gamma() * penetration(w)
    }

    /// (\[P_γ\]₋² − σ_n²)/2γ: the energy per area of Nitsche's contact term without friction, whose variation is that of θ = 1, for
    /// any material.
    pub fn nitsche_energy(sigma_n: Scalar, w: Vector) -> Scalar {
        (sqr(nitsche_pressure(sigma_n, w)) - sqr(sigma_n)) / (2 * gamma())
    }

    /// \[σ_n − γ (w_n − g)\]₋: the contact pressure of Nitsche's method.
    pub fn nitsche_pressure(sigma_n: Scalar, w: Vector) -> Scalar {
        neg_part(augmented_stress(sigma_n, w))
    }

    /// θ σ_n − γ w_n, with which (15) tests the pressure.
    #[doc(alias = "P_θ")]
    pub fn nitsche_test(sigma_n: Scalar, w: Vector) -> Scalar {
        theta * sigma_n - gamma() * normal_displacement(w)
    }

    /// Density on Γ_C of Nitsche's two contact terms in (15): −θ/γ σ_n(u) σ_n(v) − 1/γ \[P_γ(u)\]₋ (θ σ_n(v) − γ v_n).
    /// For a nonlinear material pass the normal stress's derivative in the direction v as `sigma_n_v`.
    pub fn nitsche_density(sigma_n: Scalar, u: Vector, sigma_n_v: Scalar, v: Vector) -> Scalar {
        -theta / gamma() * sigma_n * sigma_n_v
            - nitsche_pressure(sigma_n, u) / gamma() * nitsche_test(sigma_n_v, v)
    }

    /// γ/2 \[u_n − g\]₊²: the energy per area of the penalty method.
    pub fn penalty_density(u: Vector) -> Scalar {
        gamma() / 2 * pow(pos_part(penetration(u)), 2)
    }
}

/// Friction with an obstacle of any kind, for any material: the operators read nothing from the module's data. n_y is the unit normal
/// into the obstacle; P = σn − γ (slip + (u_n − g) n_y) is the augmented traction.
#[forms]
pub mod friction {
    /// The bound of friction, and where the slip is counted from: for laws that import these operators.
    pub struct Data {
        /// s₀, the bound of Tresca's law \[stress\].
        #[doc(alias = "s₀")]
        #[default(0)]
        pub slip_stress: Param,
        /// κ, the coefficient of Coulomb's law.
        #[doc(alias = "κ")]
        #[default(0)]
        pub friction: Param,
        /// u₀, the displacement from which the slip is counted: that of the last step that converged \[length\].
        #[doc(alias = "u₀")]
        #[default(0)]
        pub displacement_before: Given<Vector>,
    }

    /// s = s₀ + κ p, the bound of friction at the pressure p.
    pub fn slip_limit(pressure: Scalar) -> Scalar {
        slip_stress + friction * pressure
    }

    /// Π_s(q), the vector of length s or less that is nearest to q: zero where s ≤ 0, q inside the ball of radius s, else
    /// s q/|q|. In this order: what does not press sticks nowhere, not even at q = 0.
    #[doc(alias = "Π_s")]
    pub fn ball_projection(q: Vector, s: Scalar) -> Vector {
        if s <= 0 {
            0 * q
        } else if norm(q) <= s {
            q
        } else {
            s * normalize(q)
        }
    }

    /// η_s(q): the potential of Π_s, |q|²/2 inside the ball of radius s and s |q| − s²/2 outside.
    #[doc(alias = "η_s")]
    pub fn ball_potential(q: Vector, s: Scalar) -> Scalar {
        if s <= 0 {
            0
        } else if norm(q) <= s {
            dot(q, q) / 2
        } else {
            s * norm(q) - s * s / 2
        }
    }

    /// q_t = q − (q·n_y) n_y.
    #[doc(alias = "·_t")]
    pub fn tangential(q: Vector, obstacle_normal: Vector) -> Vector {
        q - dot(q, obstacle_normal) * obstacle_normal
    }

    /// P_n n_y + P_t with P_n = σ_n + γ g and P_t = (σn − γ slip)_t: the augmented traction for the traction σn, the present
    /// gap g and the slip since the last step; its normal part does not count.
    #[doc(alias = "P")]
    pub fn augmented_traction(
        traction: Vector,
        gap: Scalar,
        slip: Vector,
        gamma: Scalar,
        obstacle_normal: Vector,
    ) -> Vector {
        let P_n = dot(traction, obstacle_normal) + gamma * gap;
        P_n * obstacle_normal + tangential(traction - gamma * slip, obstacle_normal)
    }

    /// T = −\[P_n\]₋ n_y + Π_s(P_t): the traction of contact and friction on the body, with the bound s of friction.
    #[doc(alias = "T")]
    pub fn contact_traction(P: Vector, s: Scalar, obstacle_normal: Vector) -> Vector {
        ball_projection(tangential(P, obstacle_normal), s)
            - neg_part(dot(P, obstacle_normal)) * obstacle_normal
    }

    /// F⁻ᵀn/|F⁻ᵀn|: the outward unit normal of the deformed surface.
    #[doc(alias = "n_x")]
    pub fn deformed_normal(u: Vector) -> Vector {
        normalize(cof(I + grad(u)) * n)
    }
}

/// Contact with friction with an obstacle given by its signed distance φ, positive outside, |∇φ| = 1: the gap is φ(x + u), the
/// normal into the obstacle −∇φ(x + u). Nothing is read from the module's data; φ is a function of a point y of the
/// module's own, or of the shapes here, and ∇φ is `diff(distance(y), y)`.
#[forms]
pub mod signed_distance {
    use super::friction::{augmented_traction, contact_traction};

    /// Distance from the half-space below a plane through `point` with the unit normal `outward`.
    pub fn half_space_distance(y: Vector, point: Vector, outward: Vector) -> Scalar {
        dot(y - point, outward)
    }

    /// Distance from a disk or a ball.
    pub fn ball_distance(y: Vector, centre: Vector, radius: Scalar) -> Scalar {
        norm(y - centre) - radius
    }

    /// Distance from all points within `radius` of a box around the origin with the half edges `half_sizes`: a box with round
    /// edges; balls, capsules and flat punches are cases.
    pub fn rounded_box_distance(y: Vector, half_sizes: Vector, radius: Scalar) -> Scalar {
        // In the plane the last axis is the second one, and counts once.
        let first = abs(y[0]) - half_sizes[0];
        let second = abs(y[1]) - half_sizes[1];
        let last = abs(y[D - 1]) - half_sizes[D - 1];
        let beyond = [pos_part(first), pos_part(second), (D - 2) * pos_part(last)];
        norm(beyond) + min(max(first, max(second, last)), 0) - radius
    }

    /// φ/|∇φ| of a level-set function φ and its slope ∇φ: the distance on the surface and to first order next to it. The normal
    /// into the obstacle is then −∇φ/|∇φ|.
    pub fn level_set_distance(level: Scalar, slope: Vector) -> Scalar {
        level / norm(slope)
    }

    /// T, the traction of the obstacle on the body where the body has the traction σn: φ, ∇φ and the slip since the last step
    /// are those at the displaced point; s₀ and κ bound the friction. Without σn it is the penalty method's.
    #[doc(alias = "T")]
    pub fn obstacle_traction(
        own_traction: Vector,
        distance: Scalar,
        outward: Vector,
        slip: Vector,
        gamma: Scalar,
        slip_stress: Scalar,
        friction: Scalar,
    ) -> Vector {
        let P = augmented_traction(own_traction, distance, slip, gamma, -outward);
        contact_traction(P, slip_stress + friction * neg_part(-dot(P, outward)), -outward)
    }

    /// (\[σ_n + γ φ\]₋² − σ_n²)/2γ: the energy per area of Nitsche's contact term without friction, θ = 1, where the body has the
    /// traction σn.
    pub fn nitsche_energy(own_traction: Vector, distance: Scalar, outward: Vector, gamma: Scalar) -> Scalar {
        let sigma_n = -dot(own_traction, outward);
        (sqr(neg_part(sigma_n + gamma * distance)) - sqr(sigma_n)) / (2 * gamma)
    }

    /// Nitsche's density −(θ/γ) σ(u)n·σ(v)n + (1/γ) T·(θ σ(v)n − γ v).
    pub fn nitsche_density(
        own_traction: Vector,
        obstacle_traction: Vector,
        traction_of_test: Vector,
        v: Vector,
        theta: Scalar,
        gamma: Scalar,
    ) -> Scalar {
        theta / gamma * dot(obstacle_traction - own_traction, traction_of_test) - dot(obstacle_traction, v)
    }
}

/// Separation of bodies that are glued together: Δ is the opposite side's displacement minus the own one's, n_y the unit
/// normal toward the opposite side. Nothing is read from the module's data.
#[forms]
pub mod cohesion {
    /// δ = √(\[Δ_n\]₊² + β² |Δ_t|²), the effective opening.
    #[doc(alias = "δ")]
    pub fn opening(separation: Vector, toward: Vector, shear_weight: Scalar) -> Scalar {
        let parting = dot(separation, toward);
        norm(pos_part(parting) * toward + shear_weight * (separation - parting * toward))
    }

    /// k (\[Δ_n\]₊ n_y + β² Δ_t), the traction on the own side for the secant stiffness k.
    pub fn separation_traction(
        separation: Vector,
        toward: Vector,
        shear_weight: Scalar,
        secant: Scalar,
    ) -> Vector {
        let parting = dot(separation, toward);
        secant * (pos_part(parting) * toward + sqr(shear_weight) * (separation - parting * toward))
    }

    /// k(κ), the secant stiffness of the bilinear law at the largest effective opening κ: K up to δ₀ = σ_c/K, then a straight
    /// line of tractions k κ down to zero at δ_f = 2 G_c/σ_c.
    pub fn bilinear_stiffness(
        largest: Scalar,
        stiffness: Scalar,
        strength: Scalar,
        energy: Scalar,
    ) -> Scalar {
        let begin = strength / stiffness;
        let end = 2 * energy / strength;
        if largest <= begin {
            stiffness
        } else if largest < end {
            strength * (end - largest) / ((end - begin) * largest)
        } else {
            0
        }
    }

    /// The energy per area that the bilinear law has lost at the largest effective opening κ: G_c (κ − δ₀)/(δ_f − δ₀) between
    /// δ₀ and δ_f.
    pub fn bilinear_dissipation(
        largest: Scalar,
        stiffness: Scalar,
        strength: Scalar,
        energy: Scalar,
    ) -> Scalar {
        let begin = strength / stiffness;
        let end = 2 * energy / strength;
        energy * min(pos_part(largest - begin) / (end - begin), 1)
    }
}
