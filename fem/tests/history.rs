//! Histories: reading, writing several from one state, committing, reverting, regions, rules, and what does not
//! fit.

use forms_fem::prelude::*;

#[forms(dimension = 2)]
mod memory {
    pub struct Data {
        pub load: Param,
        pub a: History<Scalar>,
        pub b: History<Vector>,
        pub c: History<Tensor>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;

    pub fn total(u: State<Scalar>) -> Functional {
        integral(Omega, a * u + b[0] + tr(c))
    }
    pub fn mass(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (u - a) * v)
    }
    pub fn cubic(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, (u + u * u * u - a) * v)
    }
    /// Of degree 9 without a history.
    pub fn high(u: State<Scalar>) -> Functional {
        integral(Omega, pow(u, 7) * (1 + a) + b[0])
    }
    pub fn new_a(u: Scalar) -> Scalar {
        a + load * u
    }
    /// Reads the old a, whatever was written.
    pub fn new_b(u: Scalar) -> Vector {
        a * grad(u) + [1, 2]
    }
    pub fn new_c(u: Scalar) -> Tensor {
        c + outer(b, b)
    }
    pub fn root(u: Scalar) -> Scalar {
        sqrt(u)
    }
    pub fn on_facets() -> Functional {
        integral(Gamma, a)
    }
    pub fn slip(u: Scalar) -> Scalar {
        a + dot(n, [0, 1]) * u
    }
    pub fn vector() -> Vector {
        b
    }
    /// A direction that is a history: its gradient is asked for.
    pub fn gradient(u: State<Scalar>) -> Scalar {
        derivative(dot(grad(u), grad(u)), u, a)
    }
}

type Outcome = Result<(), Box<dyn std::error::Error>>;

struct Setting {
    assembler: Assembler<2>,
    space: Arc<Space<2>>,
    data: memory::Data<2>,
}

fn setting(degree: usize) -> Result<Setting, Box<dyn std::error::Error>> {
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 3], CellShape::Quadrilateral, 1)?;
    let assembler = Assembler::new(&mesh);
    let data = memory::data()
        .load(3.0)
        .a(assembler.history(Entity::Cells, "all", degree, 0.5)?)
        .b(assembler.history(Entity::Cells, "all", degree, [1.0, 0.0])?)
        .c(assembler.history(Entity::Cells, "all", degree, [[1.0, 2.0], [3.0, 4.0]])?);
    Ok(Setting { assembler, space: Space::scalar(&mesh, 2)?, data })
}

#[test]
fn several_histories_are_written_from_one_state_and_committed_together() -> Outcome {
    let Setting { assembler, space, data } = setting(4)?;
    let omega = memory::Omega::on("all");
    // A form keeps a handle: it reads what is committed when it is assembled.
    let u = Field::interpolate(&space, |x| x[0])?;
    let total = memory::total(&data, &omega, &u);
    let value = || assembler.functional(&total);
    // ∫ x/2 + 1 + 5 over [0, 2] × [0, 1].
    assert!((value()? - 13.0).abs() < 1e-13);

    let write = |data: &memory::Data<2>| -> Result<(), AssemblyError> {
        assembler.update_history(&memory::new_a(data, &u), &data.a)?;
        assembler.update_history(&memory::new_b(data, &u), &data.b)?;
        assembler.update_history(&memory::new_c(data, &u), &data.c)
    };
    write(&data)?;
    assert!((value()? - 13.0).abs() < 1e-13, "nothing is committed yet");
    let commit = |data: &memory::Data<2>| {
        data.a.commit();
        data.b.commit();
        data.c.commit();
    };
    commit(&data);
    // a = 1/2 + 3x, b = (1/2, 0) + (1, 2), c = c + e₁⊗e₁: all from the old a and b.
    let expected = 1.0 + 8.0 + 3.0 + 12.0;
    assert!((value()? - expected).abs() < 1e-12);

    write(&data)?;
    data.a.revert();
    data.b.revert();
    data.c.revert();
    commit(&data);
    assert!((value()? - expected).abs() < 1e-12, "what was reverted cannot be committed");

    let values = assembler.history_values(&data.b)?;
    assert_eq!(values.len(), 12 * 9);
    assert!(values.iter().all(|b| (b[0] - 1.5).abs() < 1e-13 && (b[1] - 2.0).abs() < 1e-13));
    assert_eq!(format!("{:?}", data.c), "History(4 components)");
    Ok(())
}

#[test]
fn a_problem_that_outlives_a_commit_sees_the_new_values() -> Outcome {
    let Setting { assembler, space, data } = setting(4)?;
    let omega = memory::Omega::on("all");
    let free = Constraints::new(&space);
    let form = memory::mass(&data, &omega);
    let mut problem = Problem::new(&form, &space).assembler(&assembler);
    let first = problem.solve()?.into_field();
    assert!(first.values().iter().all(|value| (value - 0.5).abs() < 1e-12));
    assembler.update_history(&memory::new_a(&data, &first), &data.a)?;
    data.a.commit();
    let second = problem.solve()?.into_field();
    assert!(second.values().iter().all(|value| (value - 2.0).abs() < 1e-12));

    // Linear, constant and nonlinear integrals in one form: u + u³ = 2.
    let form = memory::cubic(&data, &omega);
    let problem = Problem::new(&form, &space).assembler(&assembler);
    let options = NewtonOptions::default();
    let found =
        problem.start(&second).constrained(&free).options(options.clone()).each_step(|_| {}).solve()?;
    assert!(found.field().values().iter().all(|value| (value - 1.0).abs() < 1e-10));
    Ok(())
}

#[test]
fn an_integral_with_a_history_takes_its_rule() -> Outcome {
    let Setting { assembler, space, data } = setting(1)?;
    let u = Field::interpolate(&space, |x| x[0])?;
    // One point per cell: the midpoint rule.
    let high = memory::high(&data, &memory::Omega::on("all"), &u);
    let cells = [0.25_f64, 0.75, 1.25, 1.75].map(|x| 0.5 * (x.powi(7) * 1.5 + 1.0));
    let found = assembler.functional(&high)?;
    assert!((found - cells.iter().sum::<f64>()).abs() < 1e-12, "{found}");
    // A projection takes its values there, too: here of a constant.
    let vectors = Space::vector(assembler.mesh(), 1)?;
    let shown = assembler.project(&memory::vector(&data), &vectors)?;
    assert!((shown.evaluate(&[0.3, 0.4])?[0] - 1.0).abs() < 1e-12);
    Ok(())
}

#[test]
fn facets_have_histories() -> Outcome {
    let Setting { assembler, space, mut data } = setting(2)?;
    data.a = assembler.history(Entity::Facets, "boundary", 3, 2.0)?;
    let sum = |name: &str| {
        let functional = memory::on_facets(&data, &memory::Gamma::on(name));
        assembler.functional(&functional)
    };
    assert!((sum("boundary")? - 12.0).abs() < 1e-12);
    let u = Field::interpolate(&space, |x| 1.0 + x[0])?;
    assembler.update_history(&memory::slip(&data, &u), &data.a)?;
    data.a.commit();
    // + (1 + x) above, − (1 + x) below, and a region that is a part of the history's.
    assert!((sum("top")? - 8.0).abs() < 1e-12);
    assert!((sum("bottom")? - 0.0).abs() < 1e-12);
    assert!((sum("left")? - 2.0).abs() < 1e-12);
    Ok(())
}

#[test]
fn what_does_not_fit_is_named() -> Outcome {
    let Setting { assembler, space, mut data } = setting(4)?;
    let omega = memory::Omega::on("all");
    let u = Field::interpolate(&space, |x| x[0] - 1.0)?;
    let text = |error: Option<AssemblyError>| error.map(|error| error.to_string()).unwrap_or_default();
    let total = |data: &memory::Data<2>| text(assembler.functional(&memory::total(data, &omega, &u)).err());
    assert_eq!(total(&data), "");

    // A value that is not finite, and what was written before stays.
    let before = assembler.history_values(&data.a)?;
    let error = text(assembler.update_history(&memory::root(&data, &u), &data.a).err());
    assert!(error.starts_with("`root` is not finite at x = ["), "{error}");
    data.a.commit();
    assert_eq!(assembler.history_values(&data.a)?, before);
    let error = text(assembler.update_history(&memory::new_b(&data, &u), &data.a).err());
    assert_eq!(error, "form `new_b`: `the history` has 2 components, the field given has 1");

    // Points of its own only.
    let error = text(assembler.at_points(&memory::new_a(&data, &u), &[[0.3, 0.3]]).err());
    assert_eq!(
        error,
        "form `new_a`, history `a`: it is known at its quadrature points only; evaluate this there (`at_quadrature_points`), or `project` it"
    );
    assert!(assembler.at_quadrature_points(&memory::new_a(&data, &u), Entity::Cells, "all", 9).is_ok());
    let error = text(assembler.along_facets_uniformly(&memory::vector(&data), "top", 3).err());
    assert!(error.contains("history `b`: it is known at its quadrature points only"), "{error}");
    let gradient = memory::gradient(&data, &u);
    let error = text(assembler.at_quadrature_points(&gradient, Entity::Cells, "all", 4).err());
    assert!(error.contains("history `a`: it has no gradient"), "{error}");

    // Another rule, another degree, another region, another mesh.
    let other = assembler.clone().with_quadrature(Quadrature::Degree(2));
    let error = text(other.functional(&memory::total(&data, &omega, &u)).err());
    assert!(error.contains("history `a`: it was made with another quadrature rule"), "{error}");
    let same = assembler.clone().with_quadrature(Quadrature::Degree(4));
    assert!(same.functional(&memory::total(&data, &omega, &u)).is_ok());
    let kept = data.b.clone();
    data.b = assembler.history(Entity::Cells, "all", 2, [0.0; 2])?;
    assert!(
        total(&data).contains(
            "history `b`: its rule has degree 2, that of `a`, read at the same points, has degree 4"
        )
    );
    data.b = kept;
    let kept = data.a.clone();
    data.a = assembler.history(Entity::Facets, "boundary", 4, 0.0)?;
    let error = total(&data);
    assert!(
        error.contains(
            "it was made for the facets of \"boundary\", and cell 0 is read, which is none of them"
        ),
        "{error}"
    );
    let error = text(assembler.functional(&memory::on_facets(&data, &memory::Gamma::on("top"))).err());
    assert_eq!(error, "");
    data.a = kept;
    let error = text(assembler.functional(&memory::on_facets(&data, &memory::Gamma::on("top"))).err());
    assert!(error.contains("it was made for the cells of \"all\", and facet "), "{error}");
    let mesh = rectangle([0.0; 2], [2.0, 1.0], [4, 3], CellShape::Quadrilateral, 1)?;
    data.a = Assembler::new(&mesh).history(Entity::Cells, "all", 4, 0.0)?;
    assert!(total(&data).contains("form `total`, history `a`: it was made on another mesh"));

    let error = text(assembler.history(Entity::Cells, "nowhere", 2, 0.0).err());
    assert!(error.contains("nowhere"), "{error}");
    let error = text(assembler.history(Entity::Cells, "all", 2, f64::NAN).err());
    assert!(error.contains("the initial value"), "{error}");
    Ok(())
}
