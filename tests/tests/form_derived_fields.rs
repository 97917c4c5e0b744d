//! Derived fields (stress, von Mises stress, pressure, penetration, gap) and the contact measures: closed forms
//! on affine displacements, plain loops on others.

use forms_contact::forms;
use forms_fem::prelude::*;
use forms_tests::bodies::{Body, CONTACT, GAMMA0, LAMBDA, MU, data, plane_bodies, solid_bodies};
use forms_tests::contact_by_loops::ByLoops;
use forms_tests::dense::assert_close;

/// u = G x.
const SLOPE: [[f64; 3]; 3] = [[0.03, 0.01, -0.02], [0.02, -0.04, 0.05], [0.01, -0.03, 0.02]];

fn affine<const D: usize>(space: &Arc<Space<D>>) -> Field<D> {
    let value =
        |x: &[f64; D]| -> [f64; D] { std::array::from_fn(|i| (0..D).map(|j| SLOPE[i][j] * x[j]).sum()) };
    Field::interpolate(space, value).unwrap()
}

/// σ = μ (G + Gᵀ) + λ tr G I.
fn exact_stress<const D: usize>() -> [[f64; D]; D] {
    let trace: f64 = (0..D).map(|k| SLOPE[k][k]).sum();
    std::array::from_fn(|i| {
        std::array::from_fn(|j| MU * (SLOPE[i][j] + SLOPE[j][i]) + if i == j { LAMBDA * trace } else { 0.0 })
    })
}

/// √(½((σ_xx−σ_yy)² + (σ_yy−σ_zz)² + (σ_zz−σ_xx)²) + 3(σ_xy² + σ_yz² + σ_zx²)), σ_zz = λ tr ε in the plane.
fn exact_von_mises<const D: usize>() -> f64 {
    let (stress, mut s) = (exact_stress::<D>(), [[0.0; 3]; 3]);
    for i in 0..D {
        s[i][..D].copy_from_slice(&stress[i]);
    }
    if D == 2 {
        s[2][2] = LAMBDA * (SLOPE[0][0] + SLOPE[1][1]);
    }
    let square = |x: f64| x * x;
    let normal = square(s[0][0] - s[1][1]) + square(s[1][1] - s[2][2]) + square(s[2][2] - s[0][0]);
    let shear = square(s[0][1]) + square(s[1][2]) + square(s[2][0]);
    (normal / 2.0 + 3.0 * shear).sqrt()
}

fn inside<const D: usize>(body: &Body<D>)
where
    Dim: Dimension<D>,
{
    let (u, data) = (affine(&body.space), data(0.0));
    let mesh = body.space.mesh();
    let points: Vec<[f64; D]> = (0..mesh.cell_count()).map(|cell| mesh.cell_centre(cell)).collect();
    let stress = body.assembler.at_points(&forms::stress(&data, &u), &points).unwrap();
    let von_mises = body.assembler.at_points(&forms::von_mises(&data, &u), &points).unwrap();
    assert_eq!(stress.values.len(), points.len());
    for (stress, von_mises) in stress.values.iter().zip(&von_mises.values) {
        assert_close(body.name, stress, exact_stress::<D>().as_flattened(), 1e-13);
        assert_close(body.name, von_mises, &[exact_von_mises::<D>()], 1e-13);
    }
}

#[test]
fn stresses_of_a_uniform_strain() {
    plane_bodies().iter().for_each(inside);
    solid_bodies().iter().for_each(inside);
}

/// On the straight bottom of a block with n = n_y = −e_last.
fn along_the_bottom<const D: usize>(mesh: Mesh<D>)
where
    Dim: Dimension<D>,
{
    let space = Space::vector(&mesh, 1).unwrap();
    let u = affine(&space);
    let mut down = [0.0; D];
    down[D - 1] = -1.0;
    let gap = |x: &[f64; D]| 0.02 * (x[0] - 0.5);
    let data = data::<D>(0.0).obstacle_normal(down).gap(gap);
    let assembler = Assembler::new(&mesh);
    let parameters = [[0.2, 0.0], [0.7, 0.0]];
    macro_rules! sample {
        ($name:ident) => {
            assembler.along_facets(&forms::$name(&data, &u), CONTACT, &parameters).unwrap()
        };
    }
    let displacement = sample!(normal_displacement);
    let (stress, penetration, current) = (sample!(normal_stress), sample!(penetration), sample!(current_gap));
    let (indicator, pressure) = (sample!(contact_indicator), sample!(contact_pressure));
    let mut states = [0, 0];
    for k in 0..displacement.len() {
        let x = displacement[k].position;
        assert!(x[D - 1].abs() < 1e-15);
        let normal = -(0..D).map(|j| SLOPE[D - 1][j] * x[j]).sum::<f64>();
        let gamma = GAMMA0 / mesh.diameter(displacement[k].facet.cell as usize);
        let sigma = exact_stress::<D>()[D - 1][D - 1];
        let beta = gamma * (normal - gap(&x)) - sigma;
        let found = [
            displacement[k].value[0],
            stress[k].value[0],
            penetration[k].value[0],
            current[k].value[0],
            indicator[k].value[0],
            pressure[k].value[0],
        ];
        let exact = [normal, sigma, normal - gap(&x), gap(&x) - normal, beta, beta.max(0.0)];
        for (found, exact) in found.iter().zip(exact) {
            assert!((found - exact).abs() < 1e-13, "at {x:?}: {found} instead of {exact}");
        }
        states[usize::from(beta > 0.0)] += 1;
    }
    assert!(states[0] > 0 && states[1] > 0, "with contact and without: {states:?}");
}

#[test]
fn contact_quantities_of_a_uniform_strain() {
    along_the_bottom(rectangle([0.0; 2], [1.0; 2], [4, 1], CellShape::Quadrilateral, 1).unwrap());
    along_the_bottom(rectangle([0.0; 2], [1.0; 2], [4, 1], CellShape::Triangle, 1).unwrap());
    along_the_bottom(cuboid([0.0; 3], [1.0; 3], [4, 1, 1], CellShape::Tetrahedron, 1).unwrap());
    along_the_bottom(cuboid([0.0; 3], [1.0; 3], [4, 1, 1], CellShape::Hexahedron, 1).unwrap());
}

fn measures<const D: usize>(body: &Body<D>)
where
    Dim: Dimension<D>,
{
    let (data, gamma_c) = (data(0.0), forms::GammaC::on(CONTACT));
    let loops = ByLoops::new(body, 0.0);
    let force = forms::contact_force(&data, &gamma_c, &body.u);
    let length = forms::contact_length(&data, &gamma_c, &body.u);
    assert!(loops.force > 0.0 && loops.length > 0.0, "{}", body.name);
    assert_close(body.name, &[body.assembler.functional(&force).unwrap()], &[loops.force], 1e-13);
    assert_close(body.name, &[body.assembler.functional(&length).unwrap()], &[loops.length], 1e-13);
}

#[test]
fn force_and_length_are_those_of_plain_loops() {
    plane_bodies().iter().for_each(measures);
    solid_bodies().iter().for_each(measures);
}

#[test]
fn force_and_length_are_the_closed_form() {
    // u = 0 and g = x − 1/4 on the bottom of the unit square of four columns: β = −γ g > 0 for x < 1/4,
    // exactly the first facet: γ ∫(1/4 − x) = γ/32 with h = √(1 + 1/16).
    let mesh = rectangle([0.0; 2], [1.0; 2], [4, 1], CellShape::Quadrilateral, 1).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let data = data::<2>(0.0).obstacle_normal([0.0, -1.0]).gap(|x: &[f64; 2]| x[0] - 0.25);
    let (gamma_c, u) = (forms::GammaC::on(CONTACT), Field::zero(&space));
    let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(3));
    let force = assembler.functional(&forms::contact_force(&data, &gamma_c, &u)).unwrap();
    let length = assembler.functional(&forms::contact_length(&data, &gamma_c, &u)).unwrap();
    let gamma = GAMMA0 / (17.0_f64 / 16.0).sqrt();
    assert_close("force and length", &[force, length], &[gamma / 32.0, 0.25], 1e-14);
}
