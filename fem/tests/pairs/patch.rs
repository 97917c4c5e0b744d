//! The patch test: two blocks with meshes that do not match, pressed onto each other by Nitsche's method, have a constant
//! pressure.

use forms_fem::contract::{PairQuadrature, Projection};
use forms_fem::prelude::*;

use super::{cubes, squares};

#[forms]
mod blocks {
    pub struct Data {
        lambda: Given<Scalar>,
        mu: Given<Scalar>,
        gamma0: Param,
        theta: Param,
        /// 1 over one surface, 1/2 over both.
        share: Param,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;

    pub fn stress(w: Vector) -> Tensor {
        lambda * div(w) * I + 2 * mu * eps(w)
    }

    fn gamma() -> Scalar {
        gamma0 * this(mu) / this(h)
    }

    fn normal_stress(w: Vector) -> Scalar {
        dot(this(stress(w) * n), toward)
    }

    fn pressure(w: Vector) -> Scalar {
        neg_part(normal_stress(w) - gamma() * (dot(jump(w), toward) - gap))
    }

    /// Frictionless: −(θ/γ) σ_n(u) σ_n(v) − (1/γ) [P_n]₋ n_y·(θ σ(v)n − γ [v]), σ_n with n_y.
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let T = -pressure(u);
        integral(Omega, inner(stress(u), eps(v)))
            + integral(
                Touch,
                share
                    * (-(theta / gamma()) * normal_stress(u) * normal_stress(v)
                        + T / gamma() * (theta * normal_stress(v) - gamma() * dot(jump(v), toward))),
            )
    }
}

const POISSON: f64 = 0.3;
const YOUNG: f64 = 200.0;
const RISING: f64 = 0.01;

/// Solves the test: the bottom rises by 0.01, the top stays. The largest error of the stress, over the pressure. The upper block, which
/// may be the stiffer one, stays nearly where it is: to move it would cost as many digits as it is stiffer.
macro_rules! patch {
    ($mesh:expr, $dim:expr, $degree:expr, $moved:expr, $fixed:expr, $planes:expr, $case:expr) => {{
        let (mesh, case) = (&$mesh, $case);
        let assembler = Assembler::new(mesh);
        let space = Space::vector(mesh, $degree).unwrap();
        let constants = Space::discontinuous_scalar(mesh, 0).unwrap();
        let upper = mesh.cell_region("second").unwrap();
        let mut young = vec![YOUNG; constants.unknowns()];
        for cell in upper {
            young[constants.cell_nodes(*cell as usize)[0] as usize] = YOUNG * case.ratio;
        }
        let scaled = |factor: f64| {
            let values = young.iter().map(|young| factor * young).collect();
            Given::field(&Field::from_values(&constants, values).unwrap())
        };
        let (lambda, mu) =
            (POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)), 1.0 / (2.0 * (1.0 + POISSON)));
        let data = blocks::data()
            .lambda(scaled(lambda))
            .mu(scaled(mu))
            .gamma0(20.0)
            .theta(case.theta)
            .share(if case.pairing.surfaces.len() == 2 { 0.5 } else { 1.0 });
        let form =
            blocks::balance(&data, &blocks::Omega::on("all"), &blocks::Touch::on(case.pairing.clone()));
        let mut constraints = Constraints::new(&space);
        constraints.fix_component($moved, $dim - 1, |_| RISING).unwrap();
        constraints.fix_component($fixed, $dim - 1, |_| 0.0).unwrap();
        for (plane, component) in $planes {
            constraints.fix_component(plane, component, |_| 0.0).unwrap();
        }
        let mut solver = LuSolver::default();
        let solved = Problem::new(&form, &space)
            .assembler(&assembler)
            .constrained(&constraints)
            .solver(&mut solver)
            .options(NewtonOptions { relative_tolerance: 1e-14, ..NewtonOptions::default() })
            .solve()
            .unwrap_or_else(|error| panic!("{case:?}: {error}"));
        // Plane strain, the sides free: σ_yy = E/(1 − ν²) ε_yy; in space E ε_zz.
        let effective = if $dim == 2 { YOUNG / (1.0 - POISSON * POISSON) } else { YOUNG };
        let pressure = RISING * effective / (1.0 + 1.0 / case.ratio);
        let stress = assembler
            .at_quadrature_points(&blocks::stress(&data, &solved.into_field()), Entity::Cells, "all", 2)
            .unwrap();
        let mut worst = 0.0_f64;
        for value in &stress.values {
            for (place, entry) in value.iter().enumerate() {
                let normal = place == $dim * $dim - 1;
                // Plane strain has a stress across the plane, which is no entry.
                worst = worst.max((entry + if normal { pressure } else { 0.0 }).abs());
            }
        }
        worst / pressure
    }};
}

#[derive(Clone, Debug)]
struct Case {
    theta: f64,
    ratio: f64,
    pairing: Pairing,
}

fn cases(quadrature: PairQuadrature) -> Vec<Case> {
    let mut cases = vec![];
    for theta in [-1.0, 0.0, 1.0] {
        for ratio in [1.0, 1e3] {
            for pairing in [
                Pairing::between("below", "above"),
                Pairing::onto("below", "above"),
                Pairing::onto("above", "below"),
            ] {
                cases.push(Case { theta, ratio, pairing: pairing.at(quadrature) });
            }
        }
    }
    cases
}

const PLANES: [(&str, usize); 2] = [("first left", 0), ("second left", 0)];

#[test]
fn pressure_is_constant_in_the_plane() {
    for (shape, degree) in [(CellShape::Quadrilateral, 1), (CellShape::Triangle, 2)] {
        // The interface at y = 0: the gap is a difference of positions, and γ times their rounding is an error of the pressure.
        let mesh = squares([shape; 2], 1, [&|[x, y]| [x, y - 1.0], &|[x, y]| [x, y - 1.0]]);
        for case in cases(PairQuadrature::Pieces) {
            let error = patch!(mesh, 2, degree, "first bottom", "second top", PLANES, &case);
            assert!(error < 1e-11, "{shape:?} {case:?}: {error:e}");
        }
    }
    // Points of whole facets see kinks at the other side's nodes: good to the order of the rule alone.
    let mesh = squares([CellShape::Quadrilateral; 2], 1, [&|x| x, &|x| x]);
    let case = &cases(PairQuadrature::WholeFacets)[0];
    let error = patch!(mesh, 2, 1, "first bottom", "second top", PLANES, case);
    assert!((1e-6..5e-2).contains(&error), "{error:e}");
    // Nearest points are those of rays here.
    let case = Case { pairing: Pairing::between("below", "above").by(Projection::Nearest), ..case.clone() };
    let error = patch!(mesh, 2, 1, "first bottom", "second top", PLANES, &case);
    assert!(error < 1e-11, "{error:e}");
}

#[test]
fn pressure_is_constant_in_space() {
    let planes = [("first left", 0), ("second left", 0), ("first front", 1), ("second front", 1)];
    for shape in [CellShape::Hexahedron, CellShape::Tetrahedron] {
        let mesh = cubes(shape, 1, [&|x| x, &|x| x]);
        for case in cases(PairQuadrature::Pieces) {
            let error = patch!(mesh, 3, 1, "first bottom", "second top", planes, &case);
            assert!(error < 1e-11, "{shape:?} {case:?}: {error:e}");
        }
    }
}
