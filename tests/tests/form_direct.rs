//! (14), the direct problem: residual and tangent against closed forms and plain loops, a Taylor test, symmetry.

use forms_contact::forms;
use forms_fem::prelude::*;
use forms_fem::verification::{self, Sample};
use forms_tests::bodies::{Body, data, plane_bodies, solid_bodies, wave};
use forms_tests::contact_by_loops::ByLoops;
use forms_tests::dense::{assert_close, assert_same_matrix, dense, deviation};
use nalgebra::DMatrix;

const THETAS: [f64; 4] = [-1.0, 0.0, 1.0, 0.4];

fn against_loops<const D: usize>(body: &Body<D>)
where
    Dim: Dimension<D>,
{
    for theta in THETAS {
        let label = format!("{}, theta = {theta}", body.name);
        let (form, u, space) = (body.direct(theta), &body.u, &body.space);
        let loops = ByLoops::new(body, theta);
        let [active, _, all] = loops.points;
        assert!(0 < active && active < all, "{label}: {active} of {all} points in contact");
        let residual = body.assembler.residual(&form, &[u], &[space]).unwrap();
        let r = assert_close(&label, &residual, loops.residual.as_slice(), 1e-13);
        let tangent = dense(&body.assembler.tangent(&form, &[u], &[space]).unwrap());
        let k = assert_same_matrix(&label, &tangent, &loops.tangent, 1e-13);
        println!("{label}: residual {r:.1e}, tangent {k:.1e}, {active} of {all} points in contact");
        let switches = body.assembler.active_set(&form, &[u]).unwrap().unwrap();
        assert_eq!(switches.len(), all, "{label}");
        assert_eq!(switches.iter().filter(|bits| **bits != 0).count(), active, "{label}");
        // Symmetric for θ = 1 only.
        let asymmetry = deviation(tangent.transpose().as_slice(), tangent.as_slice());
        if theta == 1.0 {
            assert!(asymmetry < 1e-14, "{label}: asymmetry {asymmetry:.1e}");
        } else {
            assert!(asymmetry > 1e-3, "{label}: asymmetry {asymmetry:.1e}");
        }
    }
}

#[test]
fn residual_and_tangent_are_those_of_plain_loops_in_the_plane() {
    plane_bodies().iter().for_each(against_loops);
}

#[test]
fn residual_and_tangent_are_those_of_plain_loops_in_space() {
    solid_bodies().iter().for_each(against_loops);
}

/// R(u; u) is quadratic where no point changes its state, and R(u; v) affine.
fn taylor<const D: usize>(body: &Body<D>)
where
    Dim: Dimension<D>,
{
    for theta in THETAS {
        let label = format!("{}, theta = {theta}", body.name);
        let (form, assembler, space) = (body.direct(theta), &body.assembler, &body.space);
        let direction = wave(space, 1.0, 0.8);
        let first = body.step_without_switch(theta, &direction);
        let residual = |u: &Field<D>| assembler.residual(&form, &[u], &[space]).unwrap();
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let tangent = assembler.tangent(&form, &[&body.u], &[space]).unwrap();
        let change = tangent.multiply(direction.values()).unwrap();
        let work = |step: f64| {
            let u = body.moved(step, &direction);
            let active_set = assembler.active_set(&form, &[&u])?;
            Ok::<_, AssemblyError>(Sample { value: vec![product(&residual(&u), u.values())], active_set })
        };
        let slope = product(&change, body.u.values()) + product(&residual(&body.u), direction.values());
        // From steps on which points switch down to steps on which none does.
        let report = verification::taylor(8.0 * first, &[slope], work).unwrap();
        let order = report.second_order().unwrap();
        assert!(!report.steps[0].same_active_set, "{label}: {report}");
        let moved = residual(&body.moved(first, &direction));
        let expected: Vec<f64> =
            residual(&body.u).iter().zip(&change).map(|(r, change)| r + first * change).collect();
        assert_close(&label, &moved, &expected, 1e-13);
        println!("{label}: order {order:.4}");
        // Far away other points are in contact, and the tangent is another one.
        let far = body.moved(0.5, &direction);
        let set = |u: &Field<D>| assembler.active_set(&form, &[u]).unwrap();
        assert_ne!(set(&far), set(&body.u), "{label}");
        let other = assembler.tangent(&form, &[&far], &[space]).unwrap();
        assert!(deviation(other.values(), tangent.values()) > 1e-3, "{label}");
    }
}

#[test]
fn taylor_remainders_are_of_second_order() {
    plane_bodies().iter().for_each(taylor);
    solid_bodies().iter().for_each(taylor);
}

/// On a P1 simplex with one contact facet on x_last = 0 everything is constant or linear: the tangent is
/// |T| BᵀCB − θ|F|/γ s sᵀ + H/γ ∫(s − γ φ_n)(θ s − γ φ_n), with ∫φ_i = |F|/d and ∫φ_i φ_j = |F|(1 + δ)/(d(d+1)).
fn single_simplex<const D: usize>(shape: CellShape)
where
    Dim: Dimension<D>,
{
    // The unit simplex: facet F with the vertices 0, …, D − 1 on x_last = 0, vertex D above.
    let mut nodes = vec![[0.0; D]; D + 1];
    for k in 0..D {
        nodes[k + 1][k] = 1.0;
    }
    let mut mesh = Mesh::from_parts(shape, 1, nodes, (0..=D as u32).collect()).unwrap();
    mesh.name_facets("contact", "boundary", |centre| centre[D - 1] == 0.0).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let gradients: Vec<[f64; D]> = (0..=D)
        .map(|node| {
            std::array::from_fn(|k| if node == 0 { -1.0 } else { f64::from(u8::from(k + 1 == node)) })
        })
        .collect();
    let volume = if D == 2 { 1.0 / 2.0 } else { 1.0 / 6.0 };
    let area = if D == 2 { 1.0 } else { 0.5 };
    let h = 2f64.sqrt();
    let (lambda, mu, gamma0, theta) = (3.0, 2.0, 40.0, -0.3);
    let gamma = gamma0 / h;
    let size = D * (D + 1);
    // σ_n of each basis function: n = n_y = −e_last.
    let stresses: Vec<f64> = (0..size)
        .map(|j| {
            let (slope, k) = (gradients[j / D], j % D);
            lambda * slope[k] + if k == D - 1 { 2.0 * mu * slope[k] } else { 0.0 }
        })
        .collect();
    // ∫_F of φ_n and of φ_n φ_n; φ_n = −φ in the last component, vertices of F only.
    let on_facet = |j: usize| j % D == D - 1 && j / D < D;
    let d = D as f64;
    let mean: Vec<f64> = (0..size).map(|j| if on_facet(j) { -area / d } else { 0.0 }).collect();
    let product = |i: usize, j: usize| match on_facet(i) && on_facet(j) {
        true => area * (1.0 + f64::from(u8::from(i == j))) / (d * (d + 1.0)),
        false => 0.0,
    };
    for (gap, active) in [(-0.1, 1.0), (0.1, 0.0)] {
        let exact = DMatrix::from_fn(size, size, |i, j| {
            let ((gi, a), (gj, b)) = ((gradients[i / D], i % D), (gradients[j / D], j % D));
            let same = if a == b { (0..D).map(|k| gi[k] * gj[k]).sum::<f64>() } else { 0.0 };
            let bulk = volume * (lambda * gi[a] * gj[b] + mu * (gi[b] * gj[a] + same));
            let (s, t) = (stresses[i], stresses[j]);
            let contact = theta * s * t * area - gamma * t * mean[i] - gamma * theta * s * mean[j]
                + gamma * gamma * product(i, j);
            bulk - theta / gamma * area * s * t + active / gamma * contact
        });
        let mut down = [0.0; D];
        down[D - 1] = -1.0;
        let data = data(theta).lambda(lambda).mu(mu).gamma0(gamma0).obstacle_normal(down).gap(gap);
        let contact = forms::GammaC::on("contact");
        let form = forms::direct(&data, &forms::Omega::on("all"), &forms::GammaN::on("boundary"), &contact);
        let zero = Field::zero(&space);
        let assembler = Assembler::new(&mesh).with_quadrature(Quadrature::Degree(4));
        let found = dense(&assembler.tangent(&form, &[&zero], &[&space]).unwrap());
        // The space numbers the nodes of the only cell in their order.
        assert_eq!(space.cell_nodes(0), (0..=D as u32).collect::<Vec<_>>());
        let error = assert_same_matrix("one simplex", &found, &exact, 1e-14);
        println!("{shape:?}, gap {gap}: {error:.1e}");
    }
}

#[test]
fn tangent_of_one_simplex_is_the_closed_form() {
    single_simplex::<2>(CellShape::Triangle);
    single_simplex::<3>(CellShape::Tetrahedron);
}

/// A triangle pushed down as a whole by 1/10 at gap 0 feels the
/// pressure γ/10 at every point, and nothing else.
#[test]
fn a_rigid_push_is_answered_by_gamma_times_the_penetration() {
    let nodes = vec![[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]];
    let mesh = Mesh::from_parts(CellShape::Triangle, 1, nodes, vec![0, 1, 2]).unwrap();
    let mut mesh = mesh;
    mesh.name_facets("contact", "boundary", |centre| centre[1] == 0.0).unwrap();
    let space = Space::vector(&mesh, 1).unwrap();
    let push = Field::interpolate(&space, |_| [0.0, -0.1]).unwrap();
    for theta in [-1.0, 0.0, 1.0] {
        let data = data(theta)
            .lambda(0.0)
            .mu(1.0)
            .gamma0(10.0 * 5f64.sqrt())
            .obstacle_normal([0.0, -1.0])
            .gap(0.0)
            .body_force([0.0; 2])
            .traction([0.0; 2]);
        let (omega, contact) = (forms::Omega::on("all"), forms::GammaC::on("contact"));
        let form = forms::direct(&data, &omega, &forms::GammaN::on("boundary"), &contact);
        let residual = Assembler::new(&mesh).residual(&form, &[&push], &[&space]).unwrap();
        // h = √5, γ = 10, pressure 1 on a length of 2. −∫(1/γ)·1·(θ σ_n(v) − γ v_n): v_n = −v_y gives −∫v_y;
        // σ_n(v) = 2 ∂_y v_y with the gradients (−1, 0, 1) of the three nodes gives −θ·2/10·2·(−1, 0, 1).
        let stress = 2.0 / 10.0 * theta * 2.0;
        let expected = [0.0, -1.0 + stress, 0.0, -1.0, 0.0, -stress];
        assert_close("a rigid push", &residual, &expected, 1e-14);
    }
}
