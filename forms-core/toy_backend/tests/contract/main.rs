//! The contract, through a backend that knows nothing else: closed forms, both plans, lane types.

mod plans;

use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::lanes::Four;
use toy_backend::mesh::Mesh;
use toy_backend::random::Random;
use toy_backend::{Nodal, functional, residual, switches, tangent};

#[forms(crate = toy_backend)]
pub mod signorini {
    pub struct Data {
        lambda: Param,
        mu: Param,
        theta: Param,
        gamma0: Param,
        n_y: Param<Vector>,
        gap: Given<Scalar>,
        f: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct GammaC;

    fn sigma(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }
    fn sigma_n(w: Vector) -> Scalar {
        dot(sigma(w) * n, n_y)
    }
    fn gamma() -> Scalar {
        gamma0 / h
    }
    fn pressure(w: Vector) -> Scalar {
        sigma_n(w) - gamma() * (dot(w, n_y) - gap)
    }

    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(sigma(u), eps(v)) - dot(f, v))
    }
    pub fn contact(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(GammaC, neg_part(pressure(u)) / gamma() * (theta * sigma_n(v) - gamma() * dot(v, n_y)))
    }
    pub fn neo_hooke(u: Unknown<Vector>) -> Energy {
        let F = I + grad(u);
        let J = det(F);
        integral(Omega, mu / 2 * (inner(F, F) - D) - mu * ln(J) + lambda / 2 * pow(ln(J), 2))
    }
    /// Velocity and pressure: two unknowns, two test functions, two spaces.
    pub fn stokes(u: Unknown<Vector>, p: Unknown<Scalar>, v: Test<Vector>, q: Test<Scalar>) -> Form {
        integral(Omega, 2 * mu * inner(eps(u), eps(v)) - p * div(v) - q * div(u) - dot(f, v))
    }
    pub fn volume() -> Functional {
        integral(Omega, 1)
    }
    pub fn area() -> Functional {
        integral(GammaC, 1)
    }
    /// ∫ x·n ds = D |Ω|.
    pub fn flux_of_position() -> Functional {
        integral(GammaC, dot(x, n))
    }
    pub fn mean_geometry() -> Functional {
        integral(Omega, h / cell_volume) + integral(GammaC, h / facet_area)
    }
}

fn data<const D: usize>() -> signorini::Data<D> {
    let mut n_y = [0.0; D];
    n_y[1] = -1.0;
    let gap = Given::function(|x: &[f64; D]| 0.1 * x[0] - 0.05);
    signorini::data().lambda(1.3).mu(0.7).theta(-0.4).gamma0(9.0).n_y(n_y).gap(gap).f([0.2; D])
}

fn omega() -> signorini::Omega {
    signorini::Omega::on("all")
}

fn gamma_c() -> signorini::GammaC {
    signorini::GammaC::on("boundary")
}

fn assert_near(a: f64, b: f64, scale: f64) {
    assert!((a - b).abs() <= 1e-13 * scale.max(1.0), "{a} is not {b}");
}

fn assert_matrix(found: &[Vec<f64>], expected: &[Vec<f64>]) {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().flatten().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    for (row, (a, b)) in found.iter().zip(expected).enumerate() {
        for (column, (a, b)) in a.iter().zip(b).enumerate() {
            assert!((a - b).abs() <= 1e-12 * scale, "entry ({row}, {column}): {a} is not {b}");
        }
    }
}

/// K_ij = |T| (λ ∇φ_i ⊗ ∇φ_j + μ ∇φ_j ⊗ ∇φ_i + μ ∇φ_i·∇φ_j I).
fn elasticity_in_closed_form<const D: usize>(mesh: &Mesh<D>, lambda: f64, mu: f64) -> Vec<Vec<f64>> {
    let size = mesh.nodes.len() * D;
    let mut matrix = vec![vec![0.0; size]; size];
    for cell in mesh.elements(Entity::Cells, "all") {
        let gradient = |i: usize| cell.points[0].basis[i].gradient;
        for (i, first) in cell.nodes.iter().enumerate() {
            for (j, second) in cell.nodes.iter().enumerate() {
                let (g, k) = (gradient(i), gradient(j));
                let product: f64 = g.iter().zip(&k).map(|(a, b)| a * b).sum();
                for a in 0..D {
                    for b in 0..D {
                        let delta = if a == b { mu * product } else { 0.0 };
                        let entry = lambda * g[a] * k[b] + mu * g[b] * k[a] + delta;
                        matrix[first * D + a][second * D + b] += cell.cell.cell_volume * entry;
                    }
                }
            }
        }
    }
    matrix
}

fn elasticity<const D: usize>()
where
    Dim: Dimension<D>,
{
    let mut random = Random(1);
    let mesh = Mesh::<D>::cube(&mut random);
    let data = data::<D>();
    let form = signorini::elasticity(&data, &omega());
    let expected = elasticity_in_closed_form(&mesh, data.lambda, data.mu);
    let u = random.field(mesh.nodes.len(), D, 0.0, 1.0);
    assert_matrix(&tangent::<f64, D>(&mesh, &form, std::slice::from_ref(&u)), &expected);
    // The residual is K u − load; ∫ φ_i = |T| / (D + 1).
    let mut expected: Vec<f64> =
        expected.iter().map(|row| row.iter().zip(&u.values).map(|(k, u)| k * u).sum()).collect();
    for cell in mesh.elements(Entity::Cells, "all") {
        for node in &cell.nodes {
            for a in 0..D {
                expected[node * D + a] -= 0.2 * cell.cell.cell_volume / (D + 1) as f64;
            }
        }
    }
    for (found, expected) in residual::<f64, D>(&mesh, &form, &[u]).iter().zip(&expected) {
        assert_near(*found, *expected, 10.0);
    }
}

#[test]
fn elasticity_equals_its_closed_form_in_2d() {
    elasticity::<2>();
}

#[test]
fn elasticity_equals_its_closed_form_in_3d() {
    elasticity::<3>();
}

/// The contact term and its derivative, evaluated point by point and entry by entry, without the compiler.
#[allow(clippy::needless_range_loop)]
fn contact_by_hand<const D: usize>(
    mesh: &Mesh<D>,
    data: &signorini::Data<D>,
    u: &Nodal,
) -> (Vec<f64>, Vec<Vec<f64>>, Vec<f64>) {
    let size = mesh.nodes.len() * D;
    let (mut vector, mut matrix, mut pressures) = (vec![0.0; size], vec![vec![0.0; size]; size], vec![]);
    for facet in mesh.elements(Entity::Facets, "boundary") {
        let gamma = data.gamma0 / facet.cell.diameter;
        for point in &facet.points {
            let (x, n) = (point.geometry.position, point.geometry.normal);
            let gap = 0.1 * x[0] - 0.05;
            // σ_n and the normal trace of φ_i e_a, with n_y = −e_y.
            let columns: Vec<(usize, f64, f64)> = (0..facet.nodes.len() * D)
                .map(|column| {
                    let (node, a) = (column / D, column % D);
                    let g = point.basis[node].gradient;
                    let mut sigma_y = data.lambda * g[a] * n[1];
                    for k in 0..D {
                        let strain =
                            0.5 * (if a == 1 { g[k] } else { 0.0 } + if a == k { g[1] } else { 0.0 });
                        sigma_y += 2.0 * data.mu * strain * n[k];
                    }
                    let trace = if a == 1 { -point.basis[node].value } else { 0.0 };
                    (facet.nodes[node] * D + a, -sigma_y, trace)
                })
                .collect();
            let of_u = |part: fn(&(usize, f64, f64)) -> f64| -> f64 {
                columns.iter().map(|column| part(column) * u.values[column.0]).sum()
            };
            let pressure = of_u(|column| column.1) - gamma * (of_u(|column| column.2) - gap);
            pressures.push(pressure);
            let negative = (-pressure).max(0.0);
            let slope = if pressure < 0.0 { -1.0 } else { 0.0 };
            let weight = point.geometry.weight;
            for (row, stress, trace) in &columns {
                let test = data.theta * stress - gamma * trace;
                vector[*row] += weight * negative / gamma * test;
                for (column, stress, trace) in &columns {
                    matrix[*row][*column] += weight * slope / gamma * (stress - gamma * trace) * test;
                }
            }
        }
    }
    (vector, matrix, pressures)
}

fn contact<const D: usize>()
where
    Dim: Dimension<D>,
{
    let mut random = Random(2);
    let mesh = Mesh::<D>::cube(&mut random);
    let data = data::<D>();
    let u = random.field(mesh.nodes.len(), D, 0.0, 0.3);
    let form = signorini::contact(&data, &gamma_c());
    let (vector, matrix, pressures) = contact_by_hand(&mesh, &data, &u);
    let active = pressures.iter().filter(|pressure| **pressure < 0.0).count();
    assert!(0 < active && active < pressures.len(), "the state must have points of both kinds");
    let scale = vector.iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    let unknowns = [u];
    for (found, expected) in residual::<f64, D>(&mesh, &form, &unknowns).iter().zip(&vector) {
        assert_near(*found, *expected, scale);
    }
    assert_matrix(&tangent::<f64, D>(&mesh, &form, &unknowns), &matrix);
    // One switch, positive where the contact is active.
    let switches = switches(&mesh, &form, &unknowns);
    assert_eq!(switches.len(), pressures.len());
    for (switch, pressure) in switches.iter().zip(&pressures) {
        assert_eq!(switch.len(), 1);
        assert_near(switch[0], -pressure, scale);
    }
}

#[test]
fn contact_equals_a_dense_evaluation_in_2d() {
    contact::<2>();
}

#[test]
fn contact_equals_a_dense_evaluation_in_3d() {
    contact::<3>();
}

fn four_lanes_give_the_same<const D: usize>()
where
    Dim: Dimension<D>,
{
    fn compare<const D: usize>(mesh: &Mesh<D>, form: &Form<D>, u: &Nodal) {
        let unknowns = std::slice::from_ref(u);
        let (one, four) =
            (residual::<f64, D>(mesh, form, unknowns), residual::<Four, D>(mesh, form, unknowns));
        assert!(one.iter().any(|entry| *entry != 0.0));
        assert_matrix(&[four], &[one]);
        let (one, four) = (tangent::<f64, D>(mesh, form, unknowns), tangent::<Four, D>(mesh, form, unknowns));
        assert!(one.iter().flatten().any(|entry| *entry != 0.0));
        assert_matrix(&four, &one);
    }
    let mut random = Random(3);
    let mesh = Mesh::<D>::cube(&mut random);
    let u = random.field(mesh.nodes.len(), D, 0.0, 0.1);
    compare(&mesh, &signorini::elasticity(&data(), &omega()), &u);
    compare(&mesh, &signorini::contact(&data(), &gamma_c()), &u);
    compare(&mesh, &signorini::neo_hooke(&data(), &omega()), &u);
}

#[test]
fn a_lane_type_of_width_four_gives_the_same_numbers() {
    four_lanes_give_the_same::<2>();
    four_lanes_give_the_same::<3>();
}

#[test]
fn lanes_do_not_mix() {
    // Two triangles in one batch of four: the sums of each are those of a mesh of its own.
    let mut random = Random(4);
    let mesh = Mesh::<2>::cube(&mut random);
    let u = random.field(4, 2, 0.0, 0.1);
    let form = signorini::neo_hooke(&data(), &omega());
    let whole = residual::<Four, 2>(&mesh, &form, std::slice::from_ref(&u));
    let mut sum = vec![0.0; 8];
    for cell in mesh.elements(Entity::Cells, "all") {
        let alone = Mesh::simplex(cell.nodes.iter().map(|node| mesh.nodes[*node]).collect());
        let values =
            cell.nodes.iter().flat_map(|node| [u.values[2 * node], u.values[2 * node + 1]]).collect();
        let part = residual::<f64, 2>(&alone, &form, &[Nodal { components: 2, values }]);
        for (local, node) in cell.nodes.iter().enumerate() {
            sum[2 * node] += part[2 * local];
            sum[2 * node + 1] += part[2 * local + 1];
        }
    }
    assert_matrix(&[whole], &[sum]);
}

#[test]
fn two_unknowns_have_blocks_of_their_own() {
    let mut random = Random(5);
    let mesh = Mesh::<2>::cube(&mut random);
    let data = data::<2>();
    let form = signorini::stokes(&data, &omega());
    let unknowns = [random.field(4, 2, 0.0, 1.0), random.field(4, 1, 0.0, 1.0)];
    let matrix = tangent::<f64, 2>(&mesh, &form, &unknowns);
    // 2μ ε : ε is elasticity with λ = 0; −∫ q ∂_a φ_i and its transpose; nothing for p, q.
    let strain = elasticity_in_closed_form(&mesh, 0.0, data.mu);
    let mut expected = vec![vec![0.0; 12]; 12];
    for (row, entries) in strain.iter().enumerate() {
        expected[row][..8].copy_from_slice(entries);
    }
    for cell in mesh.elements(Entity::Cells, "all") {
        for (i, first) in cell.nodes.iter().enumerate() {
            for second in &cell.nodes {
                for a in 0..2 {
                    let entry = -cell.points[0].basis[i].gradient[a] * cell.cell.cell_volume / 3.0;
                    expected[first * 2 + a][8 + second] += entry;
                    expected[8 + second][first * 2 + a] += entry;
                }
            }
        }
    }
    assert_matrix(&matrix, &expected);
    let flat: Vec<f64> = unknowns.iter().flat_map(|unknown| unknown.values.clone()).collect();
    let found = residual::<f64, 2>(&mesh, &form, &unknowns);
    for (row, entries) in expected.iter().enumerate() {
        let product: f64 = entries.iter().zip(&flat).map(|(k, u)| k * u).sum();
        let load: f64 = match row < 8 {
            true => {
                let owns = |cell: &&&toy_backend::mesh::Element<2>| cell.nodes.contains(&(row / 2));
                let cells = mesh.elements(Entity::Cells, "all");
                cells.iter().filter(owns).map(|cell| 0.2 * cell.cell.cell_volume / 3.0).sum()
            }
            false => 0.0,
        };
        assert_near(found[row], product - load, 10.0);
    }
}

#[test]
fn functionals_without_arguments_measure_regions() {
    let mut random = Random(6);
    let mesh = Mesh::<3>::cube(&mut random);
    let volume: f64 = mesh.elements(Entity::Cells, "all").iter().map(|cell| cell.cell.cell_volume).sum();
    let area: f64 = mesh.elements(Entity::Facets, "boundary").iter().map(|facet| facet.cell.facet_area).sum();
    let data = data::<3>();
    assert_near(functional(&mesh, &signorini::volume(&data, &omega())), volume, 1.0);
    assert_near(functional(&mesh, &signorini::area(&data, &gamma_c())), area, 1.0);
    // By the divergence theorem: this ties the facets' normals and areas to the cells' volumes.
    let flux = functional(&mesh, &signorini::flux_of_position(&data, &gamma_c()));
    assert_near(flux, 3.0 * volume, 10.0);
    let expected: f64 =
        mesh.elements(Entity::Cells, "all").iter().map(|cell| cell.cell.diameter).sum::<f64>()
            + mesh.elements(Entity::Facets, "boundary").iter().map(|facet| facet.cell.diameter).sum::<f64>();
    let found = functional(&mesh, &signorini::mean_geometry(&data, &omega(), &gamma_c()));
    assert_near(found, expected, 100.0);
}

#[test]
fn a_form_tells_what_it_was_given() {
    let data = data::<2>();
    let form = signorini::contact(&data, &gamma_c());
    assert_eq!(form.name(), "contact");
    let inputs = form.inputs();
    // In this workspace's profiles the crate of this test is either not optimised, with assertions, or a release build.
    assert_eq!(inputs.optimised, !cfg!(debug_assertions));
    assert_eq!(inputs.regions, [Region::named(Entity::Facets, "GammaC", "boundary")]);
    assert_eq!(inputs.parameters, [1.3, 0.7, -0.4, 9.0, 0.0, -1.0]);
    assert_eq!(inputs.parameter_names, ["lambda", "mu", "theta", "gamma0", "n_y[0]", "n_y[1]"]);
    let roles: Vec<_> = form.fields().iter().map(|field| (field.name, field.role)).collect();
    assert_eq!(
        roles,
        [
            ("u", Role::Unknown(0)),
            ("v", Role::Test(0)),
            ("gap", Role::Given),
            ("f", Role::Given),
            ("du", Role::Direction(0))
        ]
    );
}
