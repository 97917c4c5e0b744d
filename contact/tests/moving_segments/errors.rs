//! Refusals of moving segments, by name: derivatives that hold their points, functions with too few derivatives at them, energies in space,
//! facets of degree three.

use forms_contact::ContactProblem;
use forms_contact::laws::sliding_bodies as sliding;
use forms_contact::laws::two_bodies as fixed;
use forms_fem::contract::PairQuadrature;
use forms_fem::prelude::*;

use crate::balance::plates;

#[forms(dimension = 2)]
mod energies {
    pub struct Data {
        stiffness: Given<Scalar>,
    }
    #[pairs]
    pub struct Touch;

    pub fn energy(u: Unknown<Vector>) -> Energy {
        integral(Touch(u), this(stiffness) / 2 * sqr(gap))
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(energy(u), u, v)
    }
    /// The gradient at a state.
    pub fn slope(u: State<Vector>, v: Test<Vector>) -> Form {
        derivative(energy(u), u, v)
    }
    pub fn energy_of_means(u: Unknown<Vector>) -> Energy {
        means(Touch(u), 0, sqr(mean(this(stiffness) / 2 * gap)))
    }
    pub fn balance_of_means(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        derivative(energy_of_means(u), u, v)
    }
    /// By what displaces nothing.
    pub fn by_stiffness(u: State<Vector>, v: Test<Scalar>) -> Form {
        derivative(energy(u), stiffness, v)
    }
}

fn energies(stiffness: Given<f64, 2>) -> energies::Model<2> {
    let touch = Pairing::between("lower top", "upper bottom").at(PairQuadrature::Pieces);
    energies::Model {
        data: energies::data().stiffness(stiffness),
        regions: energies::Regions::default().touch(touch),
    }
}

#[test]
fn derivatives_that_hold_points_are_refused() {
    let mesh = plates(CellShape::Quadrilateral, 1, [7, 9]);
    let space = Space::vector(&mesh, 1).unwrap();
    let u = Field::zero(&space);
    let assembler = Assembler::new(&mesh);
    let law = energies(Given::constant(7.0));
    assert!(assembler.energy(&law.energy(), &[&u]).is_ok());
    let said = "moving segments move with the surfaces, and this derivative";
    let error = assembler.residual(&law.energy_of_means().into(), &[&u], &[&space]).unwrap_err();
    assert!(error.to_string().contains(said), "{error}");
    assert!(assembler.residual(&law.energy().into(), &[&u], &[&space]).is_ok());
    // By a state the points move.
    let (bent, w) = (crate::balance::bent(&space, 0.2), crate::tangent::wave(&space, 1.0, 0.3));
    let gradient = assembler.residual(&law.slope(&bent), &[], &[&space]).unwrap();
    let slope: f64 = gradient.iter().zip(w.values()).map(|(a, b)| a * b).sum();
    let at = |t: f64| {
        let values = bent.values().iter().zip(w.values()).map(|(u, w)| u + t * w).collect();
        assembler.energy(&law.energy(), &[&Field::from_values(&space, values).unwrap()]).unwrap()
    };
    let h = 2e-4;
    let difference = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
    assert!((slope - difference).abs() < 1e-9 * slope.abs(), "{slope} is not {difference}");
    let scalars = Space::scalar(&mesh, 1).unwrap();
    assert!(assembler.residual(&law.by_stiffness(&u), &[], &[&scalars]).is_ok());
    // The residual of an unknown at held points is one like others.
    let off = crate::tangent::off_differences(&assembler, &law.balance(), (&bent, &w), 2e-4);
    assert!(off < 1e-9, "{off:e}");

    let data = fixed::data().lambda(15.0).mu(10.0).gamma0(300.0).share(0.5);
    let pairing = Pairing::between("lower top", "upper bottom");
    let of = |pairing: Pairing| {
        let regions = sliding::Regions::default().touch(pairing).gamma_n("lower left");
        let held = Constraints::new(&space);
        let problem = ContactProblem::new(&space, sliding::Model { data: data.clone(), regions }, held);
        let adjoint = problem.law.discrete_adjoint(&u);
        problem.assembler.tangent(&adjoint, &[&u], &[&space]).map(|_| ())
    };
    assert_eq!(of(pairing.clone()), Ok(()));
    let error = of(pairing.at(PairQuadrature::Pieces)).unwrap_err();
    assert!(error.to_string().contains(said), "{error}");
}

#[test]
fn functions_need_a_gradient() {
    let mesh = plates(CellShape::Quadrilateral, 1, [7, 9]);
    let space = Space::vector(&mesh, 1).unwrap();
    let (u, w) = (crate::balance::bent(&space, 0.2), crate::tangent::wave(&space, 1.0, 0.3));
    let assembler = Assembler::new(&mesh);
    let stiffness = |x: &[f64; 2]| 2.0 + x[0].sin() * x[1];
    let law = energies(Given::function(stiffness));
    for form in [law.balance(), law.balance_of_means()] {
        assert!(assembler.residual(&form, &[&u], &[&space]).is_ok());
        let error = assembler.tangent(&form, &[&u], &[&space]).unwrap_err();
        assert!(error.to_string().contains("`stiffness` has no derivative along their motion"), "{error}");
    }
    let slope = |x: &[f64; 2]| [x[0].cos() * x[1], x[0].sin()];
    let law = energies(Given::function_with_gradient(stiffness, slope));
    for form in [law.balance(), law.balance_of_means()] {
        let off = crate::tangent::off_differences(&assembler, &form, (&u, &w), 2e-4);
        assert!(off < 1e-9, "{off:e}");
    }
}

/// The tangent of an energy needs two derivatives of a function: constants and fields have them.
#[test]
fn energies_need_second_derivatives() {
    let mesh = plates(CellShape::Quadrilateral, 1, [7, 9]);
    let space = Space::vector(&mesh, 1).unwrap();
    let (u, w) = (crate::balance::bent(&space, 0.2), crate::tangent::wave(&space, 1.0, 0.3));
    let assembler = Assembler::new(&mesh);
    let stiffness = |x: &[f64; 2]| 2.0 + x[0].sin() * x[1];
    let slope = |x: &[f64; 2]| [x[0].cos() * x[1], x[0].sin()];
    let energy: Form<2> = energies(Given::function_with_gradient(stiffness, slope)).energy().into();
    assert!(assembler.residual(&energy, &[&u], &[&space]).is_ok());
    let error = assembler.tangent(&energy, &[&u], &[&space]).unwrap_err();
    assert!(error.to_string().contains("`stiffness` has none: give a field"), "{error}");
    let energy: Form<2> = energies(Given::function(stiffness)).energy().into();
    let error = assembler.residual(&energy, &[&u], &[&space]).unwrap_err();
    assert!(error.to_string().contains("`stiffness` has no derivative along their motion"), "{error}");
    let field = Field::interpolate(&Space::scalar(&mesh, 2).unwrap(), stiffness).unwrap();
    for stiffness in [Given::constant(7.0), Given::field(&field)] {
        let energy: Form<2> = energies(stiffness).energy().into();
        let off = crate::tangent::off_differences(&assembler, &energy, (&u, &w), 2e-4);
        assert!(off < 1e-9, "{off:e}");
    }
}

#[test]
fn energies_in_space_are_refused() {
    let lower = cuboid([0.0; 3], [1.0, 1.0, 0.5], [2, 2, 1], CellShape::Tetrahedron, 1).unwrap();
    let upper = cuboid([0.1, 0.1, 0.5], [0.9, 0.9, 1.0], [2, 2, 1], CellShape::Tetrahedron, 1).unwrap();
    let mesh = Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)]).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let energy = crate::balance::model::<3>(&Pairing::onto("upper bottom", "lower top")).energy();
    let (assembler, u) = (Assembler::new(&mesh), Field::zero(&space));
    assert!(assembler.energy(&energy, &[&u]).is_ok());
    let error = assembler.residual(&energy.into(), &[&u], &[&space]).unwrap_err();
    assert!(error.to_string().contains("a residual and a tangent in the plane only"), "{error}");
}

#[test]
fn high_degrees_are_refused() {
    let mesh = plates(CellShape::Quadrilateral, 1, [7, 9]);
    let pairing = Pairing::between("lower top", "upper bottom").at(PairQuadrature::Pieces);
    let cubic = Field::zero(&Space::vector(&mesh, 3).unwrap());
    let error = Assembler::new(&mesh).pairs_at(&pairing, 4, &cubic).unwrap_err();
    assert!(error.to_string().starts_with("the facets of \"lower top\" have a degree above two"), "{error}");
}
