//! The topological derivative, compared with closed values of cavities and with bodies that have a small hole.

use std::f64::consts::PI;

use forms_fem::mesh::{Grid, disc};
use forms_fem::prelude::*;

#[forms]
mod cavity {
    use forms_contact::operators::linear_elastic::stress;
    use forms_contact::operators::topological_derivative::of_hole;

    #[includes(forms_contact::operators::linear_elastic::Data)]
    pub struct Data {
        #[default(0)]
        pub force: Given<Vector>,
        /// The weight of the displacement in the criterion.
        #[default(0)]
        pub weight: Given<Vector>,
    }
    #[cells]
    pub struct Omega;

    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), eps(v)) - dot(force, v))
    }
    pub fn criterion(u: State<Vector>) -> Functional {
        integral(Omega, dot(weight, u))
    }
    pub fn adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(balance(u, p), u, q) + derivative(criterion(u), u, q)
    }
    pub fn by_hole(u: State<Vector>, p: State<Vector>) -> Scalar {
        of_hole(dot(weight, u) - dot(force, p), u, p)
    }
}

const YOUNG: f64 = 70.0;
const POISSON: f64 = 0.3;
const MU: f64 = YOUNG / (2.0 * (1.0 + POISSON));
const LAMBDA: f64 = YOUNG * POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON));

/// The growth of the work of the loads by a hole, per r^D, under a constant displacement gradient.
fn growth<const D: usize>(mesh: &Mesh<D>, lambda: f64, gradient: [[f64; D]; D]) -> f64
where
    Dim: Dimension<D>,
{
    let space = Space::vector(mesh, 1).unwrap();
    let linear = |x: &[f64; D]| gradient.map(|row| row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>());
    let u = Field::interpolate(&space, linear).unwrap();
    let p = Field::from_values(&space, u.values().iter().map(|value| -value).collect()).unwrap();
    let model = cavity::Model::new(cavity::data().lambda(lambda).mu(MU));
    let values = Assembler::new(mesh).at_points(&model.by_hole(&u, &p), &[[0.3; D]]).unwrap();
    values.values[0][0]
}

/// The strains of stresses σ along the axes and τ across them, by 1/E, ν and 1/μ.
fn strains([first, second]: [f64; 2], across: f64, young: f64, poisson: f64) -> [[f64; 2]; 2] {
    let shear = across / (2.0 * MU);
    [[(first - poisson * second) / young, shear], [shear, (second - poisson * first) / young]]
}

/// Circular holes in plates: J grows by π r²/E (3(σ₁² + σ₂²) − 2σ₁σ₂ + 8τ²), with E/(1 − ν²) for E in plane strain.
#[test]
fn plates_with_a_hole() {
    let mesh = rectangle([0.0; 2], [1.0; 2], [1, 1], CellShape::Triangle, 1).unwrap();
    let plane_stress = 2.0 * LAMBDA * MU / (LAMBDA + 2.0 * MU);
    let cases =
        [([2.0, 0.0], 0.0, 12.0), ([2.0, 2.0], 0.0, 16.0), ([0.0; 2], 2.0, 32.0), ([1.0, -3.0], 0.5, 38.0)];
    for (along, across, expected) in cases {
        for (lambda, young, poisson) in [
            (plane_stress, YOUNG, POISSON),
            (LAMBDA, YOUNG / (1.0 - POISSON * POISSON), POISSON / (1.0 - POISSON)),
        ] {
            let found = growth(&mesh, lambda, strains(along, across, young, poisson));
            let exact = PI * expected / young;
            assert!((found / exact - 1.0).abs() < 1e-13, "{along:?} {across}: {found} is not {exact}");
        }
    }
}

/// Spherical cavities: few of them, of a part f of the volume, lower K by 3(1 − ν)/(2(1 − 2ν)) f and μ by 15(1 − ν)/(7 − 5ν) f (J. K. Mackenzie,
/// Proc. Phys. Soc. B 63, 1950). Under the pressure S this is 6π(1 − ν)S²r³/E.
#[test]
fn cavities_in_space() {
    let mesh = cuboid([0.0; 3], [1.0; 3], [1; 3], CellShape::Tetrahedron, 1).unwrap();
    let all_round = 2.0 * (1.0 - 2.0 * POISSON) / YOUNG;
    let pressed = growth(
        &mesh,
        LAMBDA,
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { all_round } else { 0.0 })),
    );
    let exact = 6.0 * PI * (1.0 - POISSON) * 4.0 / YOUNG;
    assert!((pressed / exact - 1.0).abs() < 1e-13, "{pressed} is not {exact}");

    let gradient = [[0.3, 0.5, -0.2], [0.1, -0.4, 0.7], [0.6, -0.3, 0.25]];
    let trace = gradient[0][0] + gradient[1][1] + gradient[2][2];
    let strain = |k: usize| 0.5 * (gradient[k / 3][k % 3] + gradient[k % 3][k / 3]);
    let deviator = (0..9).map(|k| strain(k).powi(2)).sum::<f64>() - trace * trace / 3.0;
    let bulk = LAMBDA + 2.0 / 3.0 * MU;
    let change = bulk * trace * trace * 3.0 * (1.0 - POISSON) / (2.0 * (1.0 - 2.0 * POISSON))
        + 2.0 * MU * deviator * 15.0 * (1.0 - POISSON) / (7.0 - 5.0 * POISSON);
    let (found, exact) = (growth(&mesh, LAMBDA, gradient), 4.0 / 3.0 * PI * change);
    assert!((found / exact - 1.0).abs() < 1e-13, "{found} is not {exact}");
}

/// A disc that is held at its circle, with forces, and a criterion whose adjoint state is something else.
fn solved(mesh: &Mesh<2>, circle: &str) -> (f64, Assembler<2>, cavity::Model<2>, [Field<2>; 2]) {
    let space = Space::vector(mesh, 3).unwrap();
    let data = cavity::data()
        .lambda(LAMBDA)
        .mu(MU)
        .force(|x: &[f64; 2]| [1.0 + 2.0 * x[0] - x[1], 0.5 - 3.0 * x[1] + x[0]])
        .weight(|x: &[f64; 2]| [3.0 * x[1] - 0.7, 1.0 + x[0] * x[0] + 2.0 * x[1]]);
    let model = cavity::Model::new(data);
    let mut held = Constraints::new(&space);
    held.fix(circle, |_| [0.0; 2]).unwrap();
    let body = Assembler::new(mesh);
    let balance = model.balance();
    let u = Problem::new(&balance, &space).constrained(&held).solve().unwrap().into_field();
    let adjoint = model.adjoint(&u);
    let p = Problem::new(&adjoint, &space).constrained(&held).solve().unwrap().into_field();
    let value = body.functional(&model.criterion(&u)).unwrap();
    (value, body, model, [u, p])
}

/// (J(r) − J(0))/r² comes to the formula with order 2, on meshes that fit the hole.
#[test]
fn a_criterion_with_a_hole_that_shrinks() {
    let around = 48;
    let whole = disc(1.0, [false; 2], around / 8, 4, CellShape::Quadrilateral, 2).unwrap();
    let (without, body, model, [u, p]) = solved(&whole, "circle");
    let promised = body.at_points(&model.by_hole(&u, &p), &[[0.0; 2]]).unwrap().values[0][0];
    let changes = [0.2, 0.1, 0.05].map(|radius: f64| {
        let grid = Grid {
            divisions: [(-radius.ln() * around as f64 / (2.0 * PI)).ceil() as usize, around],
            periodic: [false, true],
            sides: [["hole", "circle"], [""; 2]],
            shape: CellShape::Quadrilateral,
            degree: 2,
        };
        let place = |t: [f64; 2]| {
            let (size, (sine, cosine)) = (radius.powf(1.0 - t[0]), (2.0 * PI * t[1]).sin_cos());
            [size * cosine, size * sine]
        };
        let (with, ..) = solved(&grid.mesh(place).unwrap(), "circle");
        let change = (with - without) / (radius * radius);
        println!("r = {radius}: {change:.6}, the formula has {promised:.6}");
        change
    });
    let errors = changes.map(|change| (change / promised - 1.0).abs());
    let order = crate::order(&errors);
    assert!((order - 2.0).abs() < 0.1, "order {order:.2} of {errors:?}");
    let limit = (4.0 * changes[2] - changes[1]) / 3.0;
    assert!((limit / promised - 1.0).abs() < 2e-3, "{limit} is not {promised}");
}
