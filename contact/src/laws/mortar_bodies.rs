//! Contact of bodies at large sliding and finite strains by mortar methods: multipliers on the own facets, as pressure and friction.

use forms_fem::contract::Region;
use forms_fem::forms;
use forms_fem::prelude::*;

use crate::multiplier_nodes::{MultiplierError, check_multipliers};
use crate::parameter_ranges;
use crate::parameter_ranges::ParameterRanges;

#[doc(inline)]
pub use self::mortar_bodies::*;

/// ∫ P:∇v + ∫ p n_x·⟦v⟧ = ℓ(v), ∫ gap r = Σ_i D_i g_i r_i, ∫ gap q = Σ_i D_i \[g_i − p_i/γ\]₊ q_i, without friction: the pressure p is a field of degree 1 on
/// the own facets (`Space::on_facets(&mesh, "block bottom", 1)`, for displacements of degree 1 and 2), and g_i is the gap's mean against the function of node i,
/// whose area is D_i. So each node has one condition, p_i ≥ 0, g_i ≥ 0, p_i g_i = 0, and γ enters no solution.
///
/// Take moving segments, `Pairing::onto(own, opposite).at(PairQuadrature::Pieces)`: a uniform pressure is then
/// reproduced, and forces of bodies that are drawn along each other oscillate least (docs/mortar.md). The own surface is one region, that of
/// the multipliers; parts of it without an opposite surface have no pressure. [`mortar_problem`] refuses nodes where p would be free.
#[forms]
pub mod mortar_bodies {
    pub use super::super::two_bodies::{GammaN, Omega, Touch, criterion, loads};
    use crate::operators::multipliers::allowed_gap;
    pub use crate::operators::neo_hookean::{cauchy_stress, first_piola};

    /// Data of the bodies and of the method.
    #[includes(crate::laws::two_bodies::Data, crate::operators::multipliers::Data)]
    pub struct Data {}

    /// The own surface, where the multipliers are; integrals over it are sums over its nodes.
    #[facets(vertices)]
    pub struct Own;

    /// The direct problem: displacement, pressure, mean gap, and what they are tested with.
    pub fn direct(
        u: Unknown<Vector>,
        p: Unknown<Scalar>,
        g: Unknown<Scalar>,
        v: Test<Vector>,
        q: Test<Scalar>,
        r: Test<Scalar>,
    ) -> Form {
        integral(Omega, inner(first_piola(u), grad(v))) - loads(v)
            + integral(Touch(u), this(p) * dot(toward, jump(v)) + gap * this(r - q))
            - integral(Own, g * r - allowed_gap(p, g, gamma0 / h) * q)
    }

    /// ∫ p e·(−n_x): the force of the opposite body along e.
    pub fn contact_force(u: State<Vector>, p: State<Scalar>) -> Functional {
        -integral(Touch(u), this(p) * dot(toward, this(force_direction)))
    }
}

/// The law of [`mortar_bodies`](mod@mortar_bodies) with friction, in the plane: the multiplier m has the pressure m₀ and the traction m₁ of
/// friction along the tangent τ, n_x turned by a right angle, so that T = −m₀ n_x + m₁ τ, and d has the means of the gap and of the slip along τ since the
/// last step. Their spaces are `Space::vector_on_facets(&mesh, "block bottom", 1)`.
///
/// |m₁| is bounded by s₀ + κ p at each node, and where it is less, the slip of the step has the mean 0: there is no creep.
#[forms(dimension = 2)]
pub mod mortar_bodies_with_friction {
    pub use super::mortar_bodies::{
        Data, GammaN, Omega, Own, Touch, cauchy_stress, criterion, first_piola, loads,
    };
    use crate::operators::friction::slip_limit;
    use crate::operators::multipliers::{allowed_gap, allowed_pressure, allowed_slip};
    use crate::operators::sliding::slip;

    /// τ, the tangent of the own surface: n_x turned by a right angle.
    pub fn tangent() -> Vector {
        [-toward[1], toward[0]]
    }

    /// T, the traction of the opposite body on this one, per reference area.
    pub fn traction_of(m: Vector) -> Vector {
        this(m[1]) * tangent() - this(m[0]) * toward
    }

    /// Mean gap and slip that contact and friction allow at a node with the multipliers m and the means d.
    pub fn allowed(m: Vector, d: Vector) -> Vector {
        let gamma = gamma0 / h;
        let pressure = allowed_pressure(m[0], d[0], gamma);
        let bound = if pressure > 0 { slip_limit(pressure) } else { 0 };
        [allowed_gap(m[0], d[0], gamma), allowed_slip(m[1], d[1], bound, gamma)]
    }

    /// The direct problem of a step: displacement, multipliers, means, and what they are tested with.
    pub fn direct(
        u: Unknown<Vector>,
        m: Unknown<Vector>,
        d: Unknown<Vector>,
        v: Test<Vector>,
        q: Test<Vector>,
        r: Test<Vector>,
    ) -> Form {
        let moved = [gap, dot(slip(u), tangent())];
        integral(Omega, inner(first_piola(u), grad(v)))
            - loads(v)
            - integral(Touch(u), dot(traction_of(m), jump(v)) - dot(moved, this(r - q)))
            - integral(Own, dot(d, r) - dot(allowed(m, d), q))
    }

    /// ∫ e·T: the force of the opposite body along e.
    pub fn contact_force(u: State<Vector>, m: State<Vector>) -> Functional {
        integral(Touch(u), dot(traction_of(m), this(force_direction)))
    }
}

parameter_ranges!(mortar_bodies { positive: mu, positive: gamma0, positive: uncovered });

impl ParameterRanges for mortar_bodies_with_friction::Model<2> {
    fn check(&self, form: &'static str) -> Result<(), AssemblyError> {
        use crate::parameter_ranges::Range;
        let data = &self.data;
        Range::Positive.check(form, "mu", &data.mu)?;
        Range::Positive.check(form, "gamma0", &data.gamma0)?;
        Range::Positive.check(form, "uncovered", &data.uncovered)?;
        Range::NonNegative.check(form, "slip_stress", &data.slip_stress)?;
        Range::NonNegative.check(form, "friction", &data.friction)
    }
}

/// The check of the multipliers of a law's pairs.
fn check_pairs<const D: usize>(
    pairs: &Region,
    space: &Arc<Space<D>>,
    held: &Constraints<D>,
) -> Result<(), MultiplierError> {
    match &pairs.pairing {
        Some(pairing) => check_multipliers(&[(pairing, space)], held),
        None => Ok(()),
    }
}

/// The direct problem without friction on the spaces of displacement and pressure, which is also that of the mean gap, with its conditions. Newton's method
/// takes whole steps, as it finds the nodes that touch in fewer of them than with a line search.
///
/// # Errors
/// [`MultiplierError`]: a parameter out of its range; multipliers that are not those of the own surface, or at a node whose displacement is
/// prescribed.
pub fn mortar_problem<'a, const D: usize>(
    model: &mortar_bodies::Model<D>,
    spaces: [&Arc<Space<D>>; 2],
    held: &'a Constraints<D>,
) -> Result<Problem<'a, D, 3>, MultiplierError>
where
    Dim: Dimension<D>,
{
    let form = model.direct();
    model.check(form.name())?;
    check_pairs(&model.regions.touch.0, spaces[1], held)?;
    Ok(Problem::new(&form, [spaces[0], spaces[1], spaces[1]]).constrained(held))
}

/// The direct problem of a step with friction in the plane, as [`mortar_problem`], with a line search on the residual unless it is given other
/// options: whole steps may repeat themselves where nodes begin to stick.
///
/// # Errors
/// As [`mortar_problem`].
pub fn frictional_mortar_problem<'a>(
    model: &mortar_bodies_with_friction::Model<2>,
    spaces: [&Arc<Space<2>>; 2],
    held: &'a Constraints<2>,
) -> Result<Problem<'a, 2, 3>, MultiplierError> {
    let form = model.direct();
    model.check(form.name())?;
    check_pairs(&model.regions.touch.0, spaces[1], held)?;
    let options = NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
    Ok(Problem::new(&form, [spaces[0], spaces[1], spaces[1]]).constrained(held).options(options))
}
