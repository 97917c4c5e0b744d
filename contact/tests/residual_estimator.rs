//! The residual estimator of contact on fields whose residuals have closed forms: what is in equilibrium with the obstacle has none,
//! and each violation has its own amount.

use forms_contact::forms;
use forms_contact::laws::frictional_nitsche::frictional_nitsche;
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
fn block() -> Arc<Mesh<2>> {
    Arc::new(
        rectangle([0.0; 2], [2.0, 1.0], [2 * DIVISIONS, DIVISIONS], CellShape::Triangle, 1)
            .expect("a rectangle"),
    )
}

fn data() -> forms::Data<2> {
    forms::Data {
        lambda: LAMBDA,
        mu: MU,
        theta: -1.0,
        gamma0: 50.0,
        extension: 0.0,
        obstacle_normal: Given::constant([0.0, -1.0]),
        gap: Given::constant(0.0),
        body_force: Given::constant([0.0; 2]),
        traction: Given::constant([0.0; 2]),
        criterion_force: Given::constant([0.0; 2]),
        criterion_weight: Given::constant(0.0),
    }
}

fn with_friction(base: forms::Data<2>, slip_stress: f64, friction: f64) -> frictional_nitsche::Data<2> {
    frictional_nitsche::Data {
        base,
        slip_stress,
        friction,
        displacement_before: Given::constant([0.0; 2]),
        force_direction: Given::constant([0.0; 2]),
    }
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
fn sheared(mesh: &Arc<Mesh<2>>) -> Field<2> {
    let space = Space::vector(mesh, 1).expect("a space");
    Field::interpolate(&space, |x| [SHEAR * x[1], -PRESS * x[1]]).expect("finite values")
}

/// The data with the traction that the top has in `sheared`.
fn balanced() -> forms::Data<2> {
    let traction = Given::constant([MU * SHEAR, -(2.0 * MU + LAMBDA) * PRESS]);
    forms::Data { traction, ..data() }
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

/// What is wrong in the load at the top, and in the volume.
#[test]
fn loads_that_are_not_balanced() -> Outcome {
    let u = sheared(&block());
    let shear = H * (MU * SHEAR).powi(2) * 2.0;
    let without = forms::Data { traction: Given::constant([0.0; 2]), ..balanced() };
    let top = (MU * SHEAR).powi(2) + ((2.0 * MU + LAMBDA) * PRESS).powi(2);
    close(squares(without, &u)?.iter().sum(), shear + H * top * 2.0);
    let pulled = forms::Data { body_force: Given::constant([0.3, -0.4]), ..balanced() };
    close(squares(pulled, &u)?.iter().sum(), shear + H * H * 0.25 * 2.0);
    Ok(())
}

/// u = (0, c|x − 1|) stands above the table: a kink along x = 1, and shear stresses ±μc on the free top and bottom.
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
    let loaded = forms::Data { traction: traction.clone(), ..data() };
    close(squares(loaded, &u)?.iter().sum(), H * H * rate * rate * 2.0);
    let balanced = forms::Data { traction, body_force: Given::constant([0.0, -rate]), ..data() };
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
    let data = forms::Data { criterion_force: Given::constant([0.3, -0.4]), ..data() };
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
    let mesh = Arc::new(cuboid([0.0; 3], [1.0; 3], [2, 2, 2], CellShape::Hexahedron, 1)?);
    let space = Space::vector(&mesh, 1)?;
    let u = Field::interpolate(&space, |x| [SHEAR * x[2], 0.0, -PRESS * x[2]])?;
    let data = forms::Data {
        lambda: LAMBDA,
        mu: MU,
        theta: -1.0,
        gamma0: 50.0,
        extension: 0.0,
        obstacle_normal: Given::constant([0.0, 0.0, -1.0]),
        gap: Given::constant(0.0),
        body_force: Given::constant([0.0; 3]),
        traction: Given::constant([MU * SHEAR, 0.0, -(2.0 * MU + LAMBDA) * PRESS]),
        criterion_force: Given::constant([0.0; 3]),
        criterion_weight: Given::constant(0.0),
    };
    let regions = frictionless::Regions::default().gamma_n("top").gamma_c("bottom");
    let model = frictionless::Model { data, regions };
    let found = ErrorEstimate::residual(&Assembler::new(&mesh), &model.squared(&u))?;
    close(found.indicators().iter().sum(), 3.0_f64.sqrt() / 2.0 * (MU * SHEAR).powi(2));
    Ok(())
}
