//! Contact of bodies at large sliding and finite strains by mortar methods: multipliers on the own facets, as pressure and friction.

use forms_fem::contract::Region;
use forms_fem::forms;
use forms_fem::prelude::*;

use crate::multiplier_nodes::{MultiplierError, check_axis, check_multipliers, note_on_sharp_edges};
use crate::parameter_ranges;
use crate::parameter_ranges::{ParameterRanges, check_unit};

#[doc(inline)]
pub use self::mortar_bodies::*;

/// ∫ P:∇v + ∫ p n_x·⟦v⟧ = ℓ(v), ∫ gap r = Σ_i D_i g_i r_i, ∫ gap q = Σ_i D_i \[g_i − p_i/γ\]₊ q_i, without friction: the pressure p is a field on
/// the own facets, of degree 1 (`Space::on_facets(&mesh, "block bottom", 1)`, for displacements of degree 1 and 2) or of degree 2 in `Elements::Bernstein(2)`,
/// whose functions are nowhere negative, and g_i is the gap's mean against the function of node i, whose area is D_i. So each function has one condition, p_i ≥ 0, g_i ≥ 0, p_i g_i = 0, and γ enters no solution.
///
/// Take moving segments, `Pairing::onto(own, opposite).at(PairQuadrature::Pieces)`: a uniform pressure is then
/// reproduced, and forces of bodies that are drawn along each other oscillate least (docs/mortar.md). The own surface is one region, that of
/// the multipliers; parts of it without an opposite surface have no pressure. [`mortar_problem`] refuses nodes where p would be free.
#[forms]
pub mod mortar_bodies {
    pub use super::super::two_bodies::{GammaN, Omega, Touch, criterion, loads};
    pub use crate::operators::multipliers::Own;
    use crate::operators::multipliers::conditions;
    pub use crate::operators::neo_hookean::{cauchy_stress, first_piola};

    /// Data of the bodies and of the method.
    #[includes(crate::laws::two_bodies::Data, crate::operators::multipliers::Data)]
    pub struct Data {}

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
            + conditions(p, g, q, r, gamma0 / h)
    }

    /// ∫ p e·(−n_x): the force of the opposite body along e.
    pub fn contact_force(u: State<Vector>, p: State<Scalar>) -> Functional {
        -integral(Touch(u), this(p) * dot(toward, this(force_direction)))
    }
}

/// The law of [`mortar_bodies`](mod@mortar_bodies) with friction. The multiplier m = p a + t has the pressure p along an axis a and the traction of
/// friction t across it, and d = g a + s the means of the gap and of the slip since the last step. The smallest rotation that takes a to n_x
/// takes t to the tangent plane: T = −p n_x + t. In the plane with a along the first axis, the default, m₁ acts along n_x turned by a right
/// angle. The space of m and d is `Space::vector_on_facets(&mesh, "block bottom", 1)`,
/// or one of `Elements::Bernstein(2)`.
///
/// |t| is bounded by s₀ + κ p for each function's coefficients, so at each point, and where it is less, the slip of the step has the mean 0: there is no creep. In space choose `axis` such
/// that the own surface's normal is nowhere near −a.
#[forms]
pub mod mortar_bodies_with_friction {
    pub use super::mortar_bodies::{
        Data, GammaN, Omega, Own, Touch, cauchy_stress, criterion, first_piola, loads,
    };
    pub use crate::operators::multipliers::axis_cosine;
    use crate::operators::multipliers::{frictional_conditions, moved, multiplier_traction};
    use crate::operators::sliding::slip;

    /// T, the traction of the opposite body on this one, per reference area.
    pub fn traction_of(m: Vector) -> Vector {
        multiplier_traction(this(m), toward)
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
        integral(Omega, inner(first_piola(u), grad(v))) - loads(v)
            + integral(Touch(u), moved(gap, slip(u), this(r - q), toward) - dot(traction_of(m), jump(v)))
            + frictional_conditions(m, d, q, r, gamma0 / h)
    }

    /// ∫ e·T: the force of the opposite body along e.
    pub fn contact_force(u: State<Vector>, m: State<Vector>) -> Functional {
        integral(Touch(u), dot(traction_of(m), this(force_direction)))
    }
}

parameter_ranges!(mortar_bodies { positive: mu, positive: gamma0, positive: uncovered });
parameter_ranges!(mortar_bodies_with_friction {
    positive: mu,
    positive: gamma0,
    positive: uncovered,
    non_negative: slip_stress,
    non_negative: friction,
});

/// The check of the multipliers of a law's pairs, and a note on sharp edges.
fn check_pairs<const D: usize>(
    pairs: &Region,
    space: &Arc<Space<D>>,
    held: &Constraints<D>,
) -> Result<Option<String>, MultiplierError> {
    let Some(pairing) = &pairs.pairing else { return Ok(None) };
    check_multipliers(&[(pairing, space)], held)?;
    Ok(note_on_sharp_edges(pairing, space.mesh())?)
}

/// The direct problem without friction on the spaces of displacement and pressure, which is also that of the mean gap, with its conditions. Newton's method
/// takes whole steps; a line search on the residual leaves them whole. Where the own surface goes round a sharp edge the solution has a note.
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
    let note = check_pairs(&model.regions.touch.0, spaces[1], held)?;
    Ok(Problem::new(&form, [spaces[0], spaces[1], spaces[1]]).constrained(held).with_notes(note))
}

/// The direct problem of a step with friction, as [`mortar_problem`], with a line search on the residual unless it is given other
/// options: whole steps may repeat themselves where nodes begin to stick.
///
/// # Errors
/// As [`mortar_problem`]; an axis whose length is not 1; in space an own surface whose normal is near −a.
pub fn frictional_mortar_problem<'a, const D: usize>(
    model: &mortar_bodies_with_friction::Model<D>,
    spaces: [&Arc<Space<D>>; 2],
    held: &'a Constraints<D>,
) -> Result<Problem<'a, D, 3>, MultiplierError>
where
    Dim: Dimension<D>,
{
    let form = model.direct();
    model.check(form.name())?;
    // Zero is the first axis.
    if model.data.axis != [0.0; D] {
        check_unit(form.name(), "axis", &Given::constant(model.data.axis))?;
    }
    let note = check_pairs(&model.regions.touch.0, spaces[1], held)?;
    if D > 2 {
        check_axis(&model.axis_cosine(), spaces[1])?;
    }
    let options = NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
    let problem = Problem::new(&form, [spaces[0], spaces[1], spaces[1]]).constrained(held);
    Ok(problem.options(options).with_notes(note))
}
