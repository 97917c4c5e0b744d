//! Damage of the kind AT1 (Pham, Amor, Marigo and Maurini 2011) by bounds: a bar with its closed form, and the profile of a crack.
//!
//! ```text
//! ∫ ½ (1 − d)² E u′² + (3 G/8) (d/ℓ + ℓ |∇d|²),   ḋ ≥ 0, d ≤ 1
//! ```
//!
//! While d is uniform: d = 0 up to ε_c = √(3G/(8ℓE)), then 1 − d = (ε_c/ε)² and σ = E ε_c⁴/ε³.

use forms_fem::prelude::*;

use crate::Outcome;

#[forms(dimension = 2)]
mod bar {
    pub struct Data {
        pub young: Param,
        pub toughness: Param,
        pub length: Param,
    }
    #[cells]
    pub struct Omega;

    fn dissipated(d: Scalar) -> Scalar {
        3 * toughness / 8 * (d / length + length * dot(grad(d), grad(d)))
    }
    fn stored(u: Scalar, d: Scalar) -> Scalar {
        sqr(1 - d) * young * dot(grad(u), grad(u)) / 2
    }
    pub fn both(u: Unknown<Scalar>, d: Unknown<Scalar>) -> Energy {
        integral(Omega, stored(u, d) + dissipated(d))
    }
    pub fn elastic_energy(u: State<Scalar>, d: State<Scalar>) -> Functional {
        integral(Omega, stored(u, d))
    }
    pub fn crack_energy(d: State<Scalar>) -> Functional {
        integral(Omega, dissipated(d))
    }
    pub fn of_damage(d: Unknown<Scalar>) -> Energy {
        integral(Omega, dissipated(d))
    }
}

const YOUNG: f64 = 2.0;
const TOUGHNESS: f64 = 0.75;

fn model(length: f64) -> bar::Model<2> {
    bar::Model::new(bar::data().young(YOUNG).toughness(TOUGHNESS).length(length))
}

#[test]
fn a_bar_softens_as_its_closed_form_and_keeps_its_damage() -> Outcome {
    // The bar is shorter than the length over which damage would localise.
    const LENGTH: f64 = 2.0;
    let mesh = rectangle([0.0; 2], [1.0, 0.25], [8, 2], CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 1)?;
    let critical = (3.0 * TOUGHNESS / (8.0 * LENGTH * YOUNG)).sqrt();
    let form = model(LENGTH).both();
    let (mut u, mut damage) = (Field::zero(&space), Field::zero(&space));
    let (mut worst, mut work, mut last) = ([0.0_f64; 3], 0.0, (0.0, 0.0));
    let up = (1..=40).map(|k| f64::from(k) * 0.05);
    let down = (1..=20).map(|k| 2.0 - f64::from(k) * 0.05);
    let (mut largest, mut done) = (0.0_f64, 0.0);
    for factor in up.chain(down) {
        let strain = critical * factor;
        let mut ends = Constraints::new(&space);
        ends.fix("left", |_| 0.0)?;
        ends.fix("right", |_| strain)?;
        let free = Constraints::new(&space);
        // The first set of bounds on a space is of the first unknown on it: none for u.
        let none = Bounds::new(&space);
        let mut bounds = Bounds::new(&space);
        bounds.at_least_field(&damage)?.at_most("all", |_| 1.0)?;
        let before = [u, damage];
        let solved = Problem::new(&form, [&space, &space])
            .constrained(&ends)
            .constrained(&free)
            .bounded(&none)
            .bounded(&bounds)
            .start(&before)
            .solve()?;
        let force = solved.reaction_of(0, "right")?[0] / 0.25;
        let assembler = solved.assembler().clone();
        [u, damage] = solved.fields;
        let [_, earlier] = &before;
        assert!(damage.values().iter().zip(earlier.values()).all(|(d, earlier)| d >= earlier));
        largest = largest.max(factor);
        let d = if largest > 1.0 { 1.0 - 1.0 / (largest * largest) } else { 0.0 };
        let stress = (1.0 - d) * (1.0 - d) * YOUNG * strain;
        worst[0] = worst[0].max((force - stress).abs());
        worst[1] = damage.values().iter().fold(worst[1], |most, found| most.max((found - d).abs()));
        // Work by the closed form between the factors, compared with what is stored and dissipated.
        work += 0.5 * (force + last.1) * (strain - last.0);
        last = (strain, force);
        let spent = (assembler.functional(&model(LENGTH).elastic_energy(&u, &damage))?
            + assembler.functional(&model(LENGTH).crack_energy(&damage))?)
            / 0.25;
        done = if largest <= 1.0 {
            0.5 * YOUNG * strain * strain
        } else {
            let peak = critical * largest;
            let top = YOUNG * critical.powi(2) - 0.5 * YOUNG * critical.powi(4) / peak.powi(2);
            top - 0.5 * (1.0 - d).powi(2) * YOUNG * (peak.powi(2) - strain.powi(2))
        };
        worst[2] = worst[2].max((spent - done).abs());
    }
    println!(
        "stress {:.1e}, damage {:.1e}, energy {:.1e}; work by trapezoids {work:.6}, {done:.6}",
        worst[0], worst[1], worst[2]
    );
    assert!(worst.iter().all(|worst| *worst < 1e-9), "{worst:?}");
    assert!((work - done).abs() < 2e-3 * done);
    Ok(())
}

#[test]
fn a_crack_has_the_profile_and_the_energy_of_its_closed_form() -> Outcome {
    // d = 1 on a line: d = (1 − |x|/2ℓ)² up to 2ℓ, and 0 beyond, where the bound holds; one half costs G/2.
    const LENGTH: f64 = 0.5;
    let mut errors = vec![];
    for count in [20, 40, 80] {
        let mesh = rectangle([0.0; 2], [2.0, 0.1], [count, 1], CellShape::Quadrilateral, 1)?;
        let space = Space::scalar(&mesh, 1)?;
        let mut broken = Constraints::new(&space);
        broken.fix("left", |_| 1.0)?;
        let mut bounds = Bounds::new(&space);
        bounds.at_least("all", |_| 0.0)?.at_most("all", |_| 1.0)?;
        let form = model(LENGTH).of_damage();
        let solved = Problem::new(&form, &space).constrained(&broken).bounded(&bounds).solve()?;
        let energy = solved.functional(&model(LENGTH).crack_energy(solved.field()))? / 0.1;
        errors.push((energy - TOUGHNESS / 2.0).abs());
        for (d, x) in solved.field().values().iter().zip(space.positions()) {
            let exact = (1.0 - x[0] / (2.0 * LENGTH)).max(0.0).powi(2);
            assert!((d - exact).abs() < 0.02, "{d} {exact}");
        }
    }
    println!("errors of the energy {errors:?}");
    assert!(errors.windows(2).all(|pair| pair[1] < 0.3 * pair[0]), "{errors:?}");
    Ok(())
}
