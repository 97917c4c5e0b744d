//! Undamped Newton steps that cycle on a rough flat: the report lists the points, their gap, pressure and slip, and a remedy.

use forms_fem::output::picture::{MeshDrawing, Picture};
use forms_fem::prelude::*;
use forms_fem::solve::{NewtonFailure, Remedy};

type Outcome<T = ()> = Result<T, Box<dyn std::error::Error>>;

#[forms(dimension = 2)]
mod rough {
    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma0: Param,
        friction: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Contact;

    fn stress(w: Vector) -> Tensor {
        lambda * div(w) * I + 2 * mu * eps(w)
    }

    fn gamma() -> Scalar {
        gamma0 / h
    }

    fn force(w: Vector) -> Vector {
        stress(w) * n - gamma() * w
    }

    fn pressure_of(w: Vector) -> Scalar {
        neg_part(dot(force(w), n))
    }

    fn shear(w: Vector) -> Scalar {
        let s = friction * pressure_of(w);
        if pressure_of(w) > 0 { max(-s, min(force(w)[0], s)) } else { 0 }
    }

    /// Nitsche's method with θ = 0 and Coulomb's law on a flat below, whose normal is −e_y.
    pub fn coulomb(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)))
            + integral(Contact, pressure_of(u) * dot(n, v) - shear(u) * v[0])
    }
    pub fn gap(u: Unknown<Vector>) -> Functional {
        integral(Contact, -dot(u, n))
    }
    pub fn pressure(u: Unknown<Vector>) -> Functional {
        integral(Contact, pressure_of(u))
    }
    pub fn slip(u: Unknown<Vector>) -> Functional {
        integral(Contact, u[0])
    }
}

/// A block that is pressed onto the flat and sheared.
fn solve(aside: f64, line_search: LineSearch) -> Outcome<Result<Solved<2>, NewtonError>> {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [16, 8], CellShape::Quadrilateral, 1)?;
    let space = Space::vector(&mesh, 1)?;
    let mut held = Constraints::new(&space);
    held.fix("top", |_| [aside, -0.01])?;
    let data = rough::data().lambda(115.4).mu(76.9).gamma0(4000.0).friction(0.3);
    let contact = rough::Contact::on("bottom");
    let form = rough::coulomb(&data, &rough::Omega::on("all"), &contact);
    let (gap, pressure, slip) =
        (rough::gap(&data, &contact), rough::pressure(&data, &contact), rough::slip(&data, &contact));
    let options = NewtonOptions { line_search, max_iterations: 100, ..NewtonOptions::default() };
    let problem = Problem::new(&form, &space).constrained(&held).options(options);
    Ok(problem.observe(&gap).observe(&pressure).observe(&slip).solve())
}

/// Whether undamped steps cycle, with a report that is right then, and shorter ones converge.
fn cycles(aside: f64) -> Outcome<bool> {
    let Err(error) = solve(aside, LineSearch::Off)? else { return Ok(false) };
    let NewtonFailure::Cycling { first, period } = error.why else { return Ok(false) };
    let found = error.oscillation.as_deref().expect("points");
    assert!(!found.points.is_empty() && found.point_count == 32, "{error:?}");
    for point in &found.points {
        assert_eq!(point.region, "bottom");
        assert!(point.position[1] == 0.0 && (0.0..=2.0).contains(&point.position[0]), "{point:?}");
        assert!(!point.switches.is_empty() && point.changes >= 1, "{point:?}");
        assert!(point.since <= first + period, "{point:?}");
        let names: Vec<&str> = point.values.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["gap", "pressure", "slip"]);
        // No value is lost, and no pressure pulls.
        assert!(point.values[1].1 >= 0.0 && point.values.iter().all(|(_, value)| value.is_finite()));
    }
    assert_eq!(found.remedy, Remedy::ShorterSteps);
    let (short, long) = (error.to_string(), format!("{error:?}"));
    assert!(short.contains("points switch back and forth, as since iteration"), "{short}");
    assert!(long.contains("LineSearch::OnResidual") && long.contains("slip"), "{long}");
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [16, 8], CellShape::Quadrilateral, 1)?;
    let directory = tempfile::tempdir()?;
    let [drawn, plain] = ["points.svg", "plain.svg"].map(|name| directory.path().join(name));
    MeshDrawing::new(&mesh).oscillation(found).write_svg(&drawn)?;
    MeshDrawing::new(&mesh).write_svg(&plain)?;
    let [drawn, plain] = [std::fs::read_to_string(drawn)?, std::fs::read_to_string(plain)?];
    assert!(drawn.len() > plain.len() + 100 * found.points.len());
    // The remedy helps.
    solve(aside, LineSearch::OnResidual)??;
    Ok(true)
}

#[test]
fn points_that_switch_back_and_forth_are_listed_drawn_and_mended() -> Outcome {
    let mut cycled = 0;
    for step in 2..24 {
        cycled += usize::from(cycles(5e-4 * f64::from(step))?);
    }
    assert!(cycled > 0);
    Ok(())
}

#[test]
fn too_few_iterations_without_an_oscillation_list_no_points() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 1)?;
    let mut walls = Constraints::new(&space);
    walls.fix("boundary", |_| 0.0)?;
    let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| {
        integral(cells("all"), (1.0 + 10.0 * u * u) * dot(grad(u), grad(v)) - 50.0 * pos_part(u + 1.0) * v)
    });
    let options = NewtonOptions { max_iterations: 3, ..NewtonOptions::default() };
    let error = Problem::new(&form, &space).constrained(&walls).options(options).solve().unwrap_err();
    assert!(error.oscillation.is_none(), "{error:?}");
    Ok(())
}

/// u + 1 where u is positive, else u − 1: from 1 to −1 and back.
#[test]
fn a_law_with_a_jump_is_named_at_all_of_its_points() -> Outcome {
    let mesh = rectangle([0.0; 2], [1.0; 2], [4, 4], CellShape::Quadrilateral, 1)?;
    let space = Space::scalar(&mesh, 1)?;
    let form = form!(|u: Unknown<Scalar>, v: Test<Scalar>| integral(
        cells("all"),
        (u + 2.0 * heaviside(u) - 1.0) * v
    ));
    let value = form!(|u: Unknown<Scalar>| -> Functional { integral(cells("all"), u) });
    let start = Field::interpolate(&space, |_| 1.0)?;
    let error = Problem::new(&form, &space).start(&start).observe(&value).solve().unwrap_err();
    let found = error.oscillation.as_deref().expect("points that switch");
    assert_eq!(found.points.len(), found.point_count);
    for point in &found.points {
        assert_eq!((point.since, &point.switches[..]), (1, &[0][..]), "{error:?}");
        assert!((point.values[0].1.abs() - 1.0).abs() < 1e-12, "{error:?}");
    }
    Ok(())
}
