//! Tresca friction on a rigid flat by Nitsche's method (Chouly 2014), written by the steps of docs/new_contact_law.md.

use forms_contact::contact_law;
use forms_fem::forms;

/// a(u, v) − ∫ (θ/γ) σ(u)n·σ(v)n + ∫ (1/γ) T(u)·(θ σ(v)n − γ v), T(u) = −[P_n]₋ n_y + Π_s(P_t), P = σ(u)n − γ (u − g n_y).
#[forms]
pub mod tresca {
    use forms_contact::operators::friction::{augmented_traction, contact_traction};
    use forms_contact::operators::linear_elastic::stress;
    use forms_contact::operators::obstacle::{current_gap, gamma};

    #[includes(forms_contact::operators::linear_elastic::Data, forms_contact::operators::obstacle::Data)]
    pub struct Data { pub slip_stress: Param }
    #[cells] pub struct Omega;
    #[facets] pub struct GammaC;

    fn traction(w: Vector) -> Vector {
        let P = augmented_traction(stress(w) * n, current_gap(w), w, gamma(), obstacle_normal);
        contact_traction(P, slip_stress, obstacle_normal)
    }
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let tested = theta * (stress(v) * n) - gamma() * v;
        integral(Omega, inner(stress(u), eps(v)))
            - integral(
                GammaC,
                theta / gamma() * dot(stress(u) * n, stress(v) * n) - dot(traction(u), tested) / gamma(),
            )
    }
    pub fn slip(u: State<Vector>) -> Functional {
        integral(GammaC, dot(u, u) / 2)
    }
    pub fn adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(slip(u), u, q)
    }
    pub fn by_slip_stress(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p), slip_stress, 1)
    }
}

contact_law!(tresca {
    direct: direct,
    region: gamma_c,
    criterion: slip,
    adjoint: adjoint,
    positive: gamma0,
    non_negative: slip_stress,
    line_search: OnResidual
});
