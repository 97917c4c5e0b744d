//! Densities without inertia at the nodes of a boundary: what is kept of mass, centre and moments, where mass matrices vanish, what is
//! refused, and which schemes take them.

use forms_fem::linear_algebra::{CsrMatrix, SymmetricEigen};
use forms_fem::mesh::{MeshError, OctreeMesh};
use forms_fem::prelude::*;
use forms_fem::time::{
    BackwardDifferences, CentralDifferences, GeneralisedAlpha, Mass, RedistributionError, Scheme, State,
    Step, StepFailure, TimeLoop, redistributed_mass,
};

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

/// Inertia of a scalar unknown, and springs.
#[forms]
mod inertia {
    use forms_fem::time::operators::scalar::{second_rate, value};

    #[includes(forms_fem::time::operators::scalar::Data)]
    pub struct Data {
        pub rho: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    pub fn motion(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, rho * second_rate(u) * v + dot(grad(value(u)), grad(v)) + value(u) * v)
    }
    /// The mass matrix alone.
    pub fn mass(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, rho * u * v)
    }
}

fn no_step<const D: usize>() -> forms_fem::time::operators::scalar::Data<D> {
    let none = || Given::constant(0.0);
    forms_fem::time::operators::scalar::data()
        .value_weight(0.0)
        .rate_weight(0.0)
        .second_rate_weight(0.0)
        .known_value(none())
        .known_rate(none())
        .known_second_rate(none())
}

fn density<const D: usize>(mesh: &Mesh<D>, of: impl Fn(&[f64; D]) -> f64) -> Outcome<Field<D>> {
    Ok(Field::interpolate(&Space::discontinuous_scalar(mesh, 0)?, of)?)
}

/// Mass, centre and second moments by the mass matrix of degree one, compared with those of the density as it was: the largest difference over
/// its own size. Rows of nodes on the boundary are zero, and the matrix is positive.
fn check<const D: usize>(label: &str, mesh: Mesh<D>, boundary: &str, rule: Option<usize>) -> Outcome
where
    Dim: Dimension<D>,
{
    let assembler = match rule {
        Some(degree) => Assembler::new(&mesh).with_quadrature(Quadrature::Degree(degree)),
        None => Assembler::new(&mesh),
    };
    let before = density(&mesh, |x| if x[0] < 0.6 { 2.0 } else { 3.0 })?;
    let after = redistributed_mass(&before, boundary, &assembler)?;
    for degree in [1, 2] {
        if degree < mesh.degree() {
            continue;
        }
        let space = Space::scalar(&mesh, degree)?;
        let matrix = |rho: &Field<D>| -> Outcome<_> {
            let data = inertia::data_from(no_step()).rho(rho);
            let form = inertia::Model::new(data).mass();
            Ok(assembler.tangent(&form, &[&Field::zero(&space)], &[&space])?)
        };
        let [old, new] = [matrix(&before)?, matrix(&after)?];
        let mut fields = vec![vec![1.0; space.unknowns()]];
        fields.extend((0..D).map(|axis| space.positions().iter().map(|x| x[axis]).collect()));
        // Bodies have the size one or two, and a centre may be at zero.
        let whole: f64 = old.multiply(&fields[0])?.iter().sum();
        let mut worst = 0.0_f64;
        for (place, a) in fields.iter().enumerate() {
            for b in &fields[place..] {
                let of = |matrix: &CsrMatrix| -> Outcome<f64> {
                    Ok(matrix.multiply(a)?.iter().zip(b).map(|(a, b)| a * b).sum())
                };
                let (old, new) = (of(&old)?, of(&new)?);
                worst = worst.max((new - old).abs() / whole);
            }
        }
        assert!(worst < 1e-12, "{label}, degree {degree}: {worst:e}");
        let on_boundary = space.nodes_on(boundary)?;
        assert!(!on_boundary.is_empty());
        let mut massless = 0;
        for row in 0..space.unknowns() {
            let (from, to) = (new.row_pointers()[row], new.row_pointers()[row + 1]);
            let own = &new.values()[from..to];
            let empty = own.iter().all(|value| *value == 0.0);
            massless += usize::from(empty);
            let held = on_boundary.contains(&(row as u32));
            assert!(!held || empty, "{label}, degree {degree}: node {row} has mass {own:?}");
            // In degree one no other node is without.
            assert!(degree > 1 || held == empty, "{label}: node {row}");
        }
        let size = space.unknowns();
        let mut dense = vec![0.0; size * size];
        for row in 0..size {
            for place in new.row_pointers()[row]..new.row_pointers()[row + 1] {
                dense[row * size + new.column_indices()[place] as usize] = new.values()[place];
            }
        }
        let spectrum = SymmetricEigen::of(size, &dense).ok_or("no eigenvalues")?.values;
        let (largest, zero) = (spectrum[spectrum.len() - 1], spectrum[massless.max(1) - 1]);
        assert!(spectrum[0].abs() < 1e-13 * largest && zero < 1e-13 * largest, "{label}: {spectrum:?}");
        assert!(spectrum[massless] > 1e-6 * largest, "{label}, degree {degree}: {spectrum:?}");
        println!("{label}, degree {degree}: {worst:.1e}, {massless} of {} massless", space.unknowns());
    }
    Ok(())
}

/// A mesh whose inner nodes are moved, and its outer ones along the boundary's planes.
fn distorted<const D: usize>(mesh: Mesh<D>) -> Outcome<Mesh<D>> {
    let moved = mesh.nodes().iter().map(|x| {
        let bumps: f64 = x.iter().map(|x| (std::f64::consts::PI * x).sin()).product();
        std::array::from_fn(|axis| x[axis] + 0.06 * (1.0 + axis as f64) * bumps)
    });
    let moved = moved.collect();
    Ok(mesh.with_nodes(moved)?)
}

#[test]
fn mass_centre_and_moments_are_kept() -> Outcome {
    let square = |shape, degree| rectangle([0.0; 2], [1.0; 2], [8, 10], shape, degree);
    check("triangles", distorted(square(CellShape::Triangle, 1)?)?, "bottom", None)?;
    check("quadrilaterals", square(CellShape::Quadrilateral, 1)?, "bottom", None)?;
    // The rule of the form of inertia, where none is exact.
    check("distorted quadrilaterals", distorted(square(CellShape::Quadrilateral, 1)?)?, "bottom", Some(8))?;
    check("another side", square(CellShape::Quadrilateral, 1)?, "left", None)?;
    let cube = |shape| cuboid([0.0; 3], [1.0; 3], [2, 2, 8], shape, 1);
    check("hexahedra", cube(CellShape::Hexahedron)?, "bottom", None)?;
    check("tetrahedra", distorted(cube(CellShape::Tetrahedron)?)?, "bottom", None)?;
    check("curved", annulus(1.0, 2.0, 5, 12, CellShape::Quadrilateral, 2)?, "inner", Some(8))
}

#[test]
fn what_cannot_be_redistributed_is_refused() -> Outcome {
    let refused = |mesh: Mesh<2>, boundary: &str| -> Outcome<RedistributionError> {
        let even = density(&mesh, |_| 1.0)?;
        Ok(redistributed_mass(&even, boundary, &Assembler::new(&mesh)).err().ok_or("it was done")?)
    };
    let bar = |cells| rectangle([0.0; 2], [2.0, 1.0], cells, CellShape::Quadrilateral, 1);
    let error = refused(bar([4, 1])?, "bottom")?;
    assert_eq!(error.to_string(), "all 4 cells touch \"bottom\": none is left to take their mass");
    // Two layers: of the one that is left no point is as far out as the mass was in the mean.
    let error = refused(annulus(0.5, 1.0, 2, 16, CellShape::Quadrilateral, 2)?, "outer")?;
    assert!(matches!(error, RedistributionError::NotPositive { factor, .. } if factor < 0.0), "{error}");
    // By hand: the quadratic on the upper three quarters of a bar that has its mass, centre and moment of inertia is
    // (1388 − 4288 y + 3200 y²)/81, and its polar form at y = ½ and ¾ is −92/81.
    let error = refused(bar([4, 4])?, "bottom")?;
    let by_hand = |factor: f64| (factor + 92.0 / 81.0).abs() < 1e-10;
    assert!(
        matches!(error, RedistributionError::NotPositive { factor, cell: 8..12, .. } if by_hand(factor)),
        "{error}"
    );
    let error = refused(bar([4, 4])?, "nowhere")?;
    assert!(error.to_string().contains("nowhere"), "{error}");
    let tree = OctreeMesh::new(bar([4, 4])?)?;
    let error = refused(tree.refined(&[5])?.0.mesh().clone(), "bottom")?;
    assert!(matches!(error, RedistributionError::Mesh(MeshError::HangingNode { .. })), "{error}");
    let mesh = bar([4, 4])?;
    for (of, text) in [
        (Space::scalar(&mesh, 1)?, "one number per cell"),
        (Space::discontinuous_scalar(&mesh, 0)?, "no positive number"),
    ] {
        let error = redistributed_mass(&Field::zero(&of), "bottom", &Assembler::new(&mesh)).unwrap_err();
        assert!(error.to_string().contains(text), "{error}");
    }
    Ok(())
}

/// Schemes that read no accelerations except for inertia go on; what reads them elsewhere, or solves for them, is refused by name.
#[test]
fn schemes_that_read_accelerations_are_refused() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0; 2], [4, 7], CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 1)?;
    let rho = redistributed_mass(&density(&mesh, |_| 1.0)?, "bottom", &Assembler::new(&mesh))?;
    let form = |step: &Step<2>| inertia::Model::new(inertia::data_from(step).rho(&rho)).motion();
    let start = || State::at_rest(0.0, Field::interpolate(&space, |_| 1.0).expect("it is one"));
    let schemes: [(Box<dyn Scheme>, bool); 7] = [
        (Box::new(GeneralisedAlpha::trapezoidal()), true),
        (Box::new(GeneralisedAlpha::mid_point()), true),
        (Box::new(BackwardDifferences::new(2)?), true),
        (Box::new(GeneralisedAlpha::hilber_hughes_taylor(0.1)?), false),
        (Box::new(GeneralisedAlpha::with_spectral_radius(0.5)?), false),
        (Box::new(GeneralisedAlpha::newmark(0.3, 0.5)?), false),
        (Box::new(CentralDifferences), false),
    ];
    for (scheme, fits) in schemes {
        let name = format!("{scheme:?}");
        let mut motion = TimeLoop::new(form, scheme, start());
        match motion.take(0.01) {
            // All values are one, and all accelerations minus one: u″ = −u on average.
            Ok(_) => {
                assert!(fits, "{name} took a step");
                let mean = motion.state().value.evaluate(&[0.5, 0.8])?[0];
                assert!((mean - 0.01_f64.cos()).abs() < 1e-4, "{name}: {mean}");
            }
            Err(error) => {
                let massless =
                    matches!(&error.why, StepFailure::Massless { unknowns } if unknowns.len() == 5);
                assert!(massless && !fits, "{name}: {error}");
            }
        }
    }
    let mut motion = TimeLoop::new(form, CentralDifferences, start()).mass(Mass::Lumped);
    let error = motion.take(0.01).unwrap_err();
    assert!(matches!(error.why, StepFailure::NoMass { mass, .. } if mass == 0.0), "{error}");
    Ok(())
}
