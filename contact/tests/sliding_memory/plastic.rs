//! A plastic body in contact by Nitsche's method at points that slide: its stress at the surface needs the plastic strain there, which own points
//! remember next to the points of cells.

use forms_fem::history::WithoutPartner;
use forms_fem::prelude::*;

use crate::bodies::{APART, LAMBDA, MU, moved, plane, touch};

/// J2 plasticity without hardening in plane strain, small strains, by radial return.
#[forms(dimension = 2)]
mod metal {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
        pub gamma: Param,
        pub yield_stress: Param,
        /// Plastic strain in the cells; its component out of the plane is minus its trace.
        pub plastic: History<Tensor>,
        /// The same at the own points.
        pub plastic_on_surface: History<Tensor>,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;

    fn trial(w: Vector, before: Tensor) -> Tensor {
        2 * mu * (eps(w) - tr(eps(w)) / 3 * I - before)
    }
    fn magnitude(s: Tensor) -> Scalar {
        sqrt(inner(s, s) + tr(s) * tr(s))
    }
    fn flow(w: Vector, before: Tensor) -> Tensor {
        let s = trial(w, before);
        let excess = magnitude(s) - sqrt(2 / 3) * yield_stress;
        if excess > 0 { excess / (2 * mu) * s / magnitude(s) } else { 0 }
    }
    fn stress(w: Vector, before: Tensor) -> Tensor {
        (lambda + 2 / 3 * mu) * tr(eps(w)) * I + trial(w, before) - 2 * mu * flow(w, before)
    }
    pub fn pressure(w: Vector) -> Scalar {
        neg_part(dot(this(stress(w, plastic_on_surface) * n), toward) + gamma * gap)
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u, plastic), eps(v)))
            + integral(Touch(u), pressure(u) * dot(toward, jump(v)))
    }
    pub fn plastic_after(w: Vector) -> Tensor {
        plastic + flow(w, plastic)
    }
    pub fn plastic_on_surface_after(w: Vector) -> Tensor {
        plastic_on_surface + flow(w, plastic_on_surface)
    }
    /// The same from both sides' point of view.
    pub fn plastic_at_pairs_after(w: Vector) -> Tensor {
        this(plastic_on_surface + flow(w, plastic_on_surface))
    }
}

/// A block under uniaxial strain that yields, slides along the slab and is unloaded: σ = K ε − ⅔ σ_Y while it yields, steps of
/// (λ + 2μ) Δε afterwards. The pressures at the surface are those of the cells.
#[test]
fn plastic_surfaces_press_as_their_cells() {
    let (yield_stress, mesh) = (1.0, plane(4));
    let space = Space::vector(&mesh, 1).unwrap();
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(3));
    let data = metal::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma(2e4)
        .yield_stress(yield_stress)
        .plastic(assembler.history(Entity::Cells, "all", 3, [[0.0; 2]; 2]).unwrap())
        .plastic_on_surface(assembler.history_on_sliding_pairs(&touch(), 3, [[0.0; 2]; 2]).unwrap());
    let model = metal::Model { data, regions: metal::Regions::default().touch(touch()) };
    let bulk = LAMBDA + 2.0 / 3.0 * MU;
    let mut u = moved(&space, [0.0, -APART - 1e-4]);
    // The block is 1 high: how far its top comes down after it has touched is its strain.
    let strains = [0.002, 0.008, 0.02, 0.02, 0.019, 0.018];
    let (mut last, mut found) = (0.0, vec![]);
    for (step, strain) in strains.into_iter().enumerate() {
        let aside = 0.31 * step as f64;
        let mut held = Constraints::new(&space);
        held.fix("slab", |_| [0.0; 2]).unwrap();
        held.fix_component("block", 0, |_| aside).unwrap();
        held.fix_component("block top", 1, |_| -APART - strain).unwrap();
        let options = NewtonOptions {
            relative_tolerance: 1e-13,
            line_search: LineSearch::OnResidual,
            ..NewtonOptions::default()
        };
        let form = model.balance();
        let problem = Problem::new(&form, &space).constrained(&held).assembler(&assembler);
        let solved = problem.start(&u).options(options).solve().unwrap().into_field();
        u = solved;
        let pressures = assembler.at_sliding_pairs(&model.pressure(&u), &touch(), 3, &u).unwrap();
        let elastic = (LAMBDA + 2.0 * MU) * strain;
        let expected = match step {
            0..=3 => elastic.min(bulk * strain + 2.0 / 3.0 * yield_stress),
            _ => last - (LAMBDA + 2.0 * MU) * (strains[step - 1] - strain),
        };
        for pressure in &pressures.values {
            let error = (pressure[0] / expected - 1.0).abs();
            assert!(error < 1e-9, "step {step}: {} is not {expected}", pressure[0]);
        }
        last = expected;
        found.push(expected);
        // Functions of the own body give the same as those of pairs.
        let own = model.plastic_on_surface_after(&u);
        let own = assembler.at_quadrature_points(&own, Entity::Facets, "block bottom", 3).unwrap().values;
        let remembered = &model.data.plastic_on_surface;
        let at_pairs = model.plastic_at_pairs_after(&u);
        assembler.update_sliding_history(&at_pairs, remembered, &touch(), &u, WithoutPartner::Keep).unwrap();
        remembered.commit();
        let values = assembler.history_values(remembered).unwrap();
        let pairs = values.iter().flatten().zip(own.iter().flatten());
        assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-15);
        assembler.update_history(&model.plastic_after(&u), &model.data.plastic).unwrap();
        model.data.plastic.commit();
    }
    assert!(found[2] < 0.9 * (LAMBDA + 2.0 * MU) * 0.02, "it yields: {found:?}");
}
