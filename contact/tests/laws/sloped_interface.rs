//! Two bodies that stick to each other along a sloped interface, of like or of very unlike stiffness, on meshes that do not match: the
//! piecewise affine displacement, with one stress in each body, is reproduced by pieces in the plane and in space.

use forms_contact::ContactProblem;
use forms_contact::laws::two_bodies as law;
use forms_fem::mesh::structured;
use forms_fem::prelude::*;

use crate::setting::{LAMBDA, MU, THETAS, YOUNG};
use crate::two_bodies::{WIDTH, pairings};

type Matrix<const D: usize> = [[f64; D]; D];

fn times<const D: usize>(a: &Matrix<D>, v: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|i| (0..D).map(|j| a[i][j] * v[j]).sum())
}

fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The stress of a displacement gradient, of a body that is stiffer by the given factor.
fn stress<const D: usize>(gradient: &Matrix<D>, stiffness: f64) -> Matrix<D> {
    let trace: f64 = (0..D).map(|k| gradient[k][k]).sum();
    let volume = |i: usize, j: usize| if i == j { LAMBDA * trace } else { 0.0 };
    std::array::from_fn(|i| {
        std::array::from_fn(|j| stiffness * (volume(i, j) + MU * (gradient[i][j] + gradient[j][i])))
    })
}

/// The slopes of the interface along the first axes.
const SLOPES: [f64; 2] = [0.25, -0.1];

/// A displacement gradient below the interface, pressing and shearing it, and strained along it.
fn below<const D: usize>() -> Matrix<D> {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| match (i, j) {
            _ if i + 1 == D && j + 1 == D => -0.02,
            (0, 0) => 0.001,
            (0, _) if j + 1 == D => 0.003,
            _ => 0.0,
        })
    })
}

/// That above it: G + a ⊗ n is continuous along the interface, and a balances the tractions there, (C₂ : a ⊗ n) n = (C₁ : G − C₂ : G) n.
fn above<const D: usize>(normal: &[f64; D], ratio: f64) -> Matrix<D> {
    let g = below::<D>();
    let tractions = [1.0, ratio].map(|stiffness| times(&stress(&g, stiffness), normal));
    let jump: [f64; D] = std::array::from_fn(|k| tractions[0][k] - tractions[1][k]);
    let part = (LAMBDA + MU) / (LAMBDA + 2.0 * MU) * dot(&jump, normal);
    let a: [f64; D] = std::array::from_fn(|k| (jump[k] - part * normal[k]) / (ratio * MU));
    std::array::from_fn(|i| std::array::from_fn(|j| g[i][j] + a[i] * normal[j]))
}

/// The height of the interface over a point.
fn interface<const D: usize>(x: &[f64; D]) -> f64 {
    SLOPES.iter().zip(&x[..D - 1]).map(|(slope, x)| slope * (x - 0.5 * WIDTH)).sum()
}

fn one_stress_in_each_body<const D: usize>(cells: [usize; 2], ratio: f64)
where
    Dim: Dimension<D>,
{
    let body = |count: usize, [low, high]: [fn(&[f64; D]) -> f64; 2]| {
        let mut divisions = [count; D];
        divisions[D - 1] = 2;
        let place = |s: [f64; D]| {
            let mut x = s.map(|s| WIDTH * s);
            x[D - 1] = low(&x) * (1.0 - s[D - 1]) + high(&x) * s[D - 1];
            x
        };
        let shape = if D == 2 { CellShape::Quadrilateral } else { CellShape::Hexahedron };
        structured(divisions, shape, 1, place).unwrap()
    };
    let (lower, upper) = (body(cells[0], [|_| -0.5, interface]), body(cells[1], [interface, |_| 0.5]));
    let mesh = Mesh::of_bodies(&[("lower", &lower), ("upper", &upper)]).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let normal: [f64; D] = {
        let across: [f64; D] = std::array::from_fn(|k| if k + 1 == D { 1.0 } else { -SLOPES[k] });
        across.map(|component| component / dot(&across, &across).sqrt())
    };
    let gradients = [below(), above(&normal, ratio)];
    // Both are zero in the middle of the interface, and agree on all of it.
    let exact = move |x: &[f64; D], body: usize| {
        let from_middle: [f64; D] =
            std::array::from_fn(|k| if k + 1 == D { x[k] } else { x[k] - 0.5 * WIDTH });
        times(&gradients[body], &from_middle)
    };
    let mut held = Constraints::new(&space);
    for (body, (name, end)) in [("lower", "bottom"), ("upper", "top")].into_iter().enumerate() {
        for side in [end, "left", "right", "front", "back"].iter().take(2 * D - 1) {
            held.fix(&format!("{name} {side}"), |x| exact(x, body)).unwrap();
        }
    }
    let cells = Space::discontinuous_scalar(&mesh, 0).unwrap();
    let modulus = |of_lower: f64| -> Given<f64, D> {
        let stiffness = |x: &[f64; D]| if x[D - 1] < interface(x) { of_lower } else { ratio * of_lower };
        Given::field(Field::interpolate(&cells, stiffness).unwrap())
    };
    for (pairing, share) in pairings() {
        for theta in THETAS {
            let required = law::data().lambda(modulus(LAMBDA)).mu(modulus(MU)).gamma0(modulus(20.0 * YOUNG));
            let data = required.theta(theta).share(share).slip_stress(1e6 * ratio);
            let regions = law::Regions::default().touch(pairing.clone()).gamma_n("upper right");
            let model = law::Model { data, regions };
            let problem = ContactProblem::new(&space, model, held.clone());
            let u = problem.direct().unwrap().solve().unwrap().into_field();
            for (body, (name, stiffness)) in [("lower", 1.0), ("upper", ratio)].into_iter().enumerate() {
                let expected = stress(&gradients[body], stiffness);
                let expected = expected.as_flattened();
                let size = expected.iter().fold(0.0_f64, |size, entry| size.max(entry.abs()));
                let form = problem.law.stress(&u);
                let found = problem.assembler.at_quadrature_points(&form, Entity::Cells, name, 2).unwrap();
                let errors = found
                    .values
                    .iter()
                    .flat_map(|value| value.iter().zip(expected).map(|(found, exact)| (found - exact).abs()));
                let worst = errors.fold(0.0, f64::max);
                let case = format!("{D}D, ratio {ratio}, theta {theta}, {pairing}, {name}");
                println!("{case}: {:.1e}", worst / size);
                assert!(worst < 1e-11 * size, "{case}: {worst:e} of {size}");
            }
        }
    }
}

#[test]
fn bodies_of_like_and_unlike_stiffness() {
    for ratio in [1.0, 1e3, 1e-3] {
        one_stress_in_each_body::<2>([3, 4], ratio);
    }
    for ratio in [1.0, 1e3] {
        one_stress_in_each_body::<3>([2, 3], ratio);
    }
}
