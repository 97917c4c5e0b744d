//! The residual estimator of contact on fields whose residuals have closed forms: what is in equilibrium with the obstacle has none,
//! and each violation has its own amount.

use forms_contact::forms;
use forms_contact::laws::frictional_nitsche;
use forms_contact::residual_estimator::{consistent_adjoint, frictional, frictionless};
use forms_fem::adaptivity::{ErrorEstimate, EstimateError};
use forms_fem::prelude::*;

const LAMBDA: f64 = 1.5;
const MU: f64 = 2.0;
/// Squares along each unit of length.
const DIVISIONS: usize = 2;
/// The diameter of the cells.
const H: f64 = std::f64::consts::SQRT_2 / DIVISIONS as f64;

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// (0, 2) × (0, 1) on a table; the top is loaded, the sides belong to no term.
fn block() -> Mesh<2> {
    rectangle([0.0; 2], [2.0, 1.0], [2 * DIVISIONS, DIVISIONS], CellShape::Triangle, 1).expect("a rectangle")
}

fn data() -> forms::Data<2> {
    forms::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(50.0)
        .obstacle_normal([0.0, -1.0])
        .gap(0.0)
        .theta(-1.0)
        .extension(0.0)
        .body_force([0.0; 2])
        .traction([0.0; 2])
        .criterion_force([0.0; 2])
        .criterion_weight(0.0)
}

fn with_friction(base: forms::Data<2>, slip_stress: f64, friction: f64) -> frictional_nitsche::Data<2> {
    frictional_nitsche::data_from(base).slip_stress(slip_stress).friction(friction)
}

/// η_T² of all cells without friction.
fn squares(data: forms::Data<2>, u: &Field<2>) -> Result<Vec<f64>, EstimateError> {
    let regions = frictionless::Regions::default().gamma_n("top").gamma_c("bottom");
    let model = frictionless::Model { data, regions };
    let assembler = Assembler::new(u.space().mesh());
    Ok(ErrorEstimate::residual(&assembler, &model.squared(u))?.indicators().to_vec())
}

/// η² with friction.
fn total_with_friction(data: frictional_nitsche::Data<2>, u: &Field<2>) -> Result<f64, EstimateError> {
    let regions = frictional::Regions::default().gamma_n("top").gamma_c("bottom");
    let model = frictional::Model { data, regions };
    let assembler = Assembler::new(u.space().mesh());
    Ok(ErrorEstimate::residual(&assembler, &model.squared(u))?.value().powi(2))
}

fn close(found: f64, wanted: f64) {
    assert!((found - wanted).abs() < 1e-12 * (1.0 + wanted), "{found}, {wanted}");
}

const SHEAR: f64 = 0.03;
const PRESS: f64 = 0.05;

/// u = (α y, −β y): the stress is uniform, the bottom touches the table with the pressure (2μ+λ)β and the shear stress μα.
fn sheared(mesh: &Mesh<2>) -> Field<2> {
    let space = Space::vector(mesh, 1).expect("a space");
    Field::interpolate(&space, |x| [SHEAR * x[1], -PRESS * x[1]]).expect("finite values")
}

/// The data with the traction that the top has in `sheared`.
fn balanced() -> forms::Data<2> {
    let traction = Given::constant([MU * SHEAR, -(2.0 * MU + LAMBDA) * PRESS]);
    data().traction(traction)
}

/// Without friction the shear stress alone is left, in the cells at the bottom.
#[test]
fn shear_on_a_smooth_table() -> Outcome {
    let mesh = block();
    let found = squares(balanced(), &sheared(&mesh))?;
    close(found.iter().sum(), H * (MU * SHEAR).powi(2) * 2.0);
    let bottom: Vec<u32> = mesh.facet_region("bottom")?.iter().map(|facet| facet.cell).collect();
    for (cell, square) in found.into_iter().enumerate() {
        let length = if bottom.contains(&(cell as u32)) { 1.0 / DIVISIONS as f64 } else { 0.0 };
        close(square, H * (MU * SHEAR).powi(2) * length);
    }
    Ok(())
}

/// A body that sticks is in equilibrium; one that ought to slip at a lower shear stress is not, by the difference.
#[test]
fn friction_carries_the_shear_that_it_can() -> Outcome {
    let u = sheared(&block());
    let (shear, pressure) = (MU * SHEAR, (2.0 * MU + LAMBDA) * PRESS);
    for (slip_stress, friction, carried) in [
        (1.1 * shear, 0.0, shear),
        (0.4 * shear, 0.0, 0.4 * shear),
        (0.0, 1.1 * shear / pressure, shear),
        (0.0, 0.1, 0.1 * pressure),
        (0.2 * shear, 0.05, 0.2 * shear + 0.05 * pressure),
        (0.0, 0.0, 0.0),
    ] {
        let found = total_with_friction(with_friction(balanced(), slip_stress, friction), &u)?;
        close(found, H * (shear - carried).powi(2) * 2.0);
    }
    Ok(())
}

/// Residuals of the load at the top, and in the volume.
#[test]
fn loads_that_are_not_balanced() -> Outcome {
    let u = sheared(&block());
    let shear = H * (MU * SHEAR).powi(2) * 2.0;
    let without = balanced().traction([0.0; 2]);
    let top = (MU * SHEAR).powi(2) + ((2.0 * MU + LAMBDA) * PRESS).powi(2);
    close(squares(without, &u)?.iter().sum(), shear + H * top * 2.0);
    let pulled = balanced().body_force([0.3, -0.4]);
    close(squares(pulled, &u)?.iter().sum(), shear + H * H * 0.25 * 2.0);
    Ok(())
}

/// u = (0, c|x − 1|) is above the table: a kink along x = 1, and shear stresses ±μc on the free top and bottom.
#[test]
fn a_kink_between_cells() -> Outcome {
    let space = Space::vector(&block(), 1)?;
    let slope = 0.02;
    let u = Field::interpolate(&space, |x| [0.0, slope * (x[0] - 1.0).abs()])?;
    // The jump is 2μc on a line of length 1, half of it counts for each side.
    let (jump, free) = (2.0 * MU * slope, MU * slope);
    close(squares(data(), &u)?.iter().sum(), H * (2.0 * (jump / 2.0).powi(2) + free.powi(2) * (2.0 + 2.0)));
    Ok(())
}

/// u = (0, c y²) of degree 2 has div σ = (0, 2c(2μ+λ)), which a force in the volume balances.
#[test]
fn the_divergence_of_the_stress() -> Outcome {
    let space = Space::vector(&block(), 2)?;
    let curvature = 0.01;
    let u = Field::interpolate(&space, |x| [0.0, curvature * x[1] * x[1]])?;
    let rate = 2.0 * curvature * (2.0 * MU + LAMBDA);
    // The traction at the top, y = 1; at the bottom there is none.
    let traction = Given::constant([0.0, rate]);
    let loaded = data().traction(traction.clone());
    close(squares(loaded, &u)?.iter().sum(), H * H * rate * rate * 2.0);
    let balanced = data().traction(traction).body_force([0.0, -rate]);
    close(squares(balanced, &u)?.iter().sum(), 0.0);
    Ok(())
}

/// A body that has entered the table by δ: the method's pressure γδ is not the stress, which is zero.
#[test]
fn penetration_counts() -> Outcome {
    let space = Space::vector(&block(), 1)?;
    let depth = 1e-3;
    let u = Field::interpolate(&space, |_| [0.0, -depth])?;
    close(squares(data(), &u)?.iter().sum(), H * (50.0 / H * depth).powi(2) * 2.0);
    Ok(())
}

/// An adjoint state with a uniform stress: F and the top's traction are not balanced, and at the bottom the shear stress, or all
/// of the traction where u does not touch.
#[test]
fn an_adjoint_state() -> Outcome {
    let mesh = block();
    let p = sheared(&mesh);
    let touching = sheared(&mesh);
    let apart = Field::interpolate(touching.space(), |_| [0.0, 0.1])?;
    let data = data().criterion_force([0.3, -0.4]);
    let regions = consistent_adjoint::Regions::default().gamma_n("top").gamma_c("bottom");
    let model = consistent_adjoint::Model { data, regions };
    let (shear, traction) = ((MU * SHEAR).powi(2), ((2.0 * MU + LAMBDA) * PRESS).powi(2));
    for (u, below) in [(touching, shear), (apart, shear + traction)] {
        let found = ErrorEstimate::residual(&Assembler::new(&mesh), &model.squared(&u, &p))?;
        let expected = H * H * 0.25 * 2.0 + H * (shear + traction) * 2.0 + H * below * 2.0;
        close(found.indicators().iter().sum(), expected);
    }
    Ok(())
}

/// In space: u = (α z, 0, −β z).
#[test]
fn shear_in_space() -> Outcome {
    let mesh = cuboid([0.0; 3], [1.0; 3], [2, 2, 2], CellShape::Hexahedron, 1)?;
    let space = Space::vector(&mesh, 1)?;
    let u = Field::interpolate(&space, |x| [SHEAR * x[2], 0.0, -PRESS * x[2]])?;
    let data = forms::data()
        .lambda(LAMBDA)
        .mu(MU)
        .gamma0(50.0)
        .obstacle_normal([0.0, 0.0, -1.0])
        .gap(0.0)
        .theta(-1.0)
        .extension(0.0)
        .body_force([0.0; 3])
        .traction([MU * SHEAR, 0.0, -(2.0 * MU + LAMBDA) * PRESS])
        .criterion_force([0.0; 3])
        .criterion_weight(0.0);
    let regions = frictionless::Regions::default().gamma_n("top").gamma_c("bottom");
    let model = frictionless::Model { data, regions };
    let found = ErrorEstimate::residual(&Assembler::new(&mesh), &model.squared(&u))?;
    close(found.indicators().iter().sum(), 3.0_f64.sqrt() / 2.0 * (MU * SHEAR).powi(2));
    Ok(())
}

/// Two blocks that are pressed together and slide on each other, or the upper one on a table: u = (D y w, −B y w) with w = 1 + cos(πx)/2,
/// in the upper one with the way s along x besides. On y = 0 the pressure is (2μ+λ)B w and the friction κ times it.
mod sliding {
    use std::f64::consts::PI;

    use forms_contact::ContactProblem;
    use forms_contact::law::ContactLaw;
    use forms_contact::laws::two_bodies as bodies;
    use forms_contact::residual_estimator::two_bodies;
    use forms_fem::norms::errors;

    use super::*;

    const FRICTION: f64 = 0.3;
    /// B.
    const PRESSED: f64 = 0.05;
    /// s.
    const WAY: f64 = 0.1;

    /// w, w′ and w″.
    fn wave(x: f64) -> [f64; 3] {
        [1.0 + (PI * x).cos() / 2.0, -PI * (PI * x).sin() / 2.0, -PI * PI * (PI * x).cos() / 2.0]
    }

    /// D.
    fn shear() -> f64 {
        FRICTION * (LAMBDA + 2.0 * MU) * PRESSED / MU
    }

    fn displacement([x, y]: &[f64; 2], way: f64) -> [f64; 2] {
        let [w, ..] = wave(*x);
        [way + shear() * y * w, -PRESSED * y * w]
    }

    fn gradient([x, y]: &[f64; 2]) -> [f64; 4] {
        let ([w, slope, _], d) = (wave(*x), shear());
        [d * y * slope, d * w, -PRESSED * y * slope, -PRESSED * w]
    }

    /// (σ_xy, σ_yy), the traction on a boundary that looks upwards.
    fn upwards(x: &[f64; 2]) -> [f64; 2] {
        let [xx, xy, yx, yy] = gradient(x);
        [MU * (xy + yx), LAMBDA * (xx + yy) + 2.0 * MU * yy]
    }

    /// −div σ.
    fn body_force([x, y]: &[f64; 2]) -> [f64; 2] {
        let ([_, slope, bend], d, b) = (wave(*x), shear(), PRESSED);
        let along = (LAMBDA + 2.0 * MU) * d * y * bend - (LAMBDA + MU) * b * slope;
        let across = (LAMBDA + MU) * d * slope - MU * b * y * bend;
        [-along, -across]
    }

    fn block([low, high]: [f64; 2], divisions: usize) -> Mesh<2> {
        rectangle([0.0, low], [1.0, high], [divisions; 2], CellShape::Triangle, 1).expect("a rectangle")
    }

    /// η/(2μ |u − u_h|₁) of a law on a mesh whose `sides` are held, each with its way.
    fn effectivity<L: ContactLaw<2>>(
        mesh: &Mesh<2>,
        degree: usize,
        sides: &[(&str, f64)],
        law: L,
        estimate: impl Fn(&Assembler<2>, &Field<2>) -> Result<ErrorEstimate, EstimateError>,
    ) -> Result<f64, Box<dyn std::error::Error>> {
        let space = Space::vector(mesh, degree)?;
        let mut held = Constraints::new(&space);
        for (side, way) in sides {
            held.fix(side, |x| displacement(x, *way))?;
        }
        let problem = ContactProblem::new(&space, law, held).quadrature(Quadrature::Degree(6));
        let u = problem.direct()?.solve()?.into_field();
        // The way is no gradient.
        let values = |_: &[f64; 2], found: &mut [f64]| found.fill(0.0);
        let error = errors(&problem.assembler, &u, values, |x, found| found.copy_from_slice(&gradient(x)))?;
        Ok(estimate(&problem.assembler, &u)?.value() / (2.0 * MU * error.seminorm))
    }

    /// The quotient is of the order of one, and the same on meshes of all sizes.
    fn known(label: &str, quotients: &[f64]) {
        println!("{label}: {quotients:?}");
        let (least, most) = quotients.iter().fold((f64::MAX, 0.0_f64), |(l, m), q| (l.min(*q), m.max(*q)));
        assert!(least > 1.0 && most < 12.0 && most < 1.2 * least, "{label}: {quotients:?}");
    }

    #[test]
    fn a_block_on_a_table() -> Outcome {
        for degree in [1, 2] {
            let on = |divisions| {
                let mesh = block([0.0, 1.0], divisions);
                let base = data().gamma0(100.0).body_force(body_force).traction(upwards);
                let data = with_friction(base, 0.0, FRICTION);
                let regions = frictional_nitsche::Regions::default().gamma_n("top").gamma_c("bottom");
                let law = frictional_nitsche::Model { data: data.clone(), regions };
                let regions = frictional::Regions::default().gamma_n("top").gamma_c("bottom");
                let model = frictional::Model { data, regions };
                effectivity(&mesh, degree, &[("left", WAY), ("right", WAY)], law, |assembler, u| {
                    ErrorEstimate::residual(assembler, &model.squared(u))
                })
            };
            known(&format!("degree {degree}"), &[on(4)?, on(8)?, on(16)?]);
        }
        Ok(())
    }

    /// Cells of the two do not match; one surface is integrated over, or both.
    #[test]
    fn a_block_on_another() -> Outcome {
        let [lower, upper] = ["lower top", "upper bottom"];
        for (pairing, share) in [(Pairing::between(lower, upper), 0.5), (Pairing::onto(upper, lower), 1.0)] {
            let on = |divisions| {
                let [below, above] = [block([-1.0, 0.0], divisions), block([0.0, 1.0], 3 * divisions / 2)];
                let mut mesh = Mesh::of_bodies(&[("lower", &below), ("upper", &above)])?;
                let mut loaded = mesh.facet_region("lower bottom")?.to_vec();
                loaded.extend_from_slice(mesh.facet_region("upper top")?);
                mesh.name_listed_facets("loaded", &loaded)?;
                let required = bodies::data().lambda(LAMBDA).mu(MU).gamma0(100.0);
                let data = required
                    .share(share)
                    .friction(FRICTION)
                    .body_force(body_force)
                    .traction(|x: &[f64; 2]| upwards(x).map(|t| t * x[1].signum()));
                let regions = bodies::Regions::default().touch(pairing.clone()).gamma_n("loaded");
                let law = bodies::Model { data: data.clone(), regions };
                let regions = two_bodies::Regions::default().touch(pairing.clone()).gamma_n("loaded");
                let model = two_bodies::Model { data, regions };
                let sides =
                    [("lower left", 0.0), ("lower right", 0.0), ("upper left", WAY), ("upper right", WAY)];
                effectivity(&mesh, 2, &sides, law, |assembler, u| {
                    ErrorEstimate::residual(assembler, &model.squared(u))
                })
            };
            known(&format!("share {share}"), &[on(4)?, on(8)?, on(16)?]);
        }
        Ok(())
    }
}
