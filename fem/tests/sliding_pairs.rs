//! Pairs of displaced surfaces: tangents with points that slide, rigid motions, two bodies pressed together, one surface that
//! touches itself.

use forms_fem::linear_algebra::BlockMatrix;
use forms_fem::prelude::*;
use forms_fem::solve::{LineSearch, NewtonOptions};
use forms_fem::verification;

#[forms]
pub(crate) mod rubber {
    pub struct Data {
        lambda: Param,
        mu: Param,
        gamma0: Param,
        kappa: Param,
        old: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;

    fn first_piola(u: Vector) -> Tensor {
        let F = I + grad(u);
        diff(mu / 2 * (inner(F, F) - D - 2 * ln(det(F))) + lambda / 2 * pow(ln(det(F)), 2), F)
    }
    fn turned(w: Vector) -> Vector {
        normalize(cof(I + grad(w)) * n)
    }
    /// The nearest vector that is no longer than s; zero for s ≤ 0.
    pub fn ball(q: Vector, s: Scalar) -> Vector {
        if s <= 0 {
            0 * q
        } else if dot(q, q) <= s * s {
            q
        } else {
            s / norm(q) * q
        }
    }
    /// Contact traction on this body.
    pub fn contact(u: Vector) -> Vector {
        let t = this(first_piola(u) * n);
        let gamma = gamma0 / this(h);
        let P = dot(t, toward) + gamma * gap;
        let slip = jump(u - old) + gap * (toward - this(turned(old)));
        let q = t - gamma * slip;
        ball(q - dot(q, toward) * toward, kappa * neg_part(P)) - neg_part(P) * toward
    }
    pub fn balance(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(first_piola(u), grad(v))) - integral(Touch(u), dot(contact(u), jump(v)) / 2)
    }
    pub fn force(u: State<Vector>, axis: State<Vector>) -> Functional {
        integral(Touch(u), dot(contact(u), this(axis)))
    }
    pub fn distance(u: State<Vector>) -> Functional {
        integral(Touch(u), gap)
    }
}

/// Two boxes [0, 1]^D, the second one on top of the first and shifted by `offset`, with the given number of cells along each axis; the sides
/// that meet are "below" and "above", both together "touch", the lowest side "bottom", the highest "top".
pub(crate) fn boxes<const D: usize>(cells: [usize; 2], offset: [f64; D]) -> Mesh<D> {
    let (mut nodes, mut corners) = (Vec::new(), Vec::new());
    for (body, count) in cells.into_iter().enumerate() {
        let start = nodes.len();
        let side = count + 1;
        let at = |index: usize, axis: usize| index / side.pow(axis as u32) % side;
        for index in 0..side.pow(D as u32) {
            nodes.push(std::array::from_fn(|axis| {
                let base = if body == 1 { offset[axis] + f64::from(axis + 1 == D) } else { 0.0 };
                base + at(index, axis) as f64 / count as f64
            }));
        }
        for index in 0..side.pow(D as u32) {
            if (0..D).any(|axis| at(index, axis) == count) {
                continue;
            }
            let loops: &[usize] = if D == 2 { &[0, 1, 3, 2] } else { &[0, 1, 3, 2, 4, 5, 7, 6] };
            let place = |corner: &usize| {
                let shift: usize = (0..D).map(|axis| (corner >> axis & 1) * side.pow(axis as u32)).sum();
                (start + index + shift) as u32
            };
            corners.extend(loops.iter().map(place));
        }
    }
    let shape = if D == 2 { CellShape::Quadrilateral } else { CellShape::Hexahedron };
    let mut mesh = Mesh::from_parts(shape, 1, nodes, corners).expect("two boxes");
    let (last, gap) = (D - 1, offset[D - 1]);
    let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
    mesh.name_facets("below", "boundary", |x| near(x[last], 1.0)).expect("there");
    mesh.name_facets("above", "boundary", |x| near(x[last], 1.0 + gap)).expect("there");
    mesh.name_facets("touch", "boundary", |x| near(x[last], 1.0) || near(x[last], 1.0 + gap)).expect("there");
    mesh.name_facets("bottom", "boundary", |x| near(x[last], 0.0)).expect("there");
    mesh.name_facets("top", "boundary", |x| near(x[last], 2.0 + gap)).expect("there");
    for axis in 0..D - 1 {
        let side = |x: &[f64; D]| near(x[axis], 0.0) || near(x[axis], 1.0);
        mesh.name_facets(&format!("sides {axis}"), "boundary", side).expect("there");
    }
    mesh
}

fn data<const D: usize>(kappa: f64) -> rubber::Data<D> {
    rubber::data().lambda(1.3).mu(0.7).gamma0(10.0).kappa(kappa).old([0.0; D])
}

fn all() -> rubber::Omega {
    rubber::Omega::on("all")
}

fn both() -> rubber::Touch {
    rubber::Touch::on(Pairing::between("below", "above"))
}

/// Smooth displacements that press the bodies together, shear and bend them.
fn bent<const D: usize>(space: &Arc<Space<D>>) -> Field<D> {
    Field::interpolate(space, |x: &[f64; D]| -> [f64; D] {
        let up = if x[D - 1] > 1.01 { 1.0 } else { 0.0 };
        std::array::from_fn(|axis| match axis + 1 == D {
            true => -0.06 * up + 0.02 * (3.0 * x[0] + x[D - 1]).sin(),
            false => 0.11 * up + 0.03 * (2.0 * x[D - 1] + axis as f64).cos(),
        })
    })
    .expect("finite")
}

/// The tangent against the residual while points slide over the other body's facets and edges.
fn tangents<const D: usize>(degree: usize, cells: [usize; 2])
where
    Dim: Dimension<D>,
{
    let mut offset = [0.03; D];
    offset[D - 1] = 0.02;
    let mesh = boxes(cells, offset);
    let space = Space::vector(&mesh, degree).unwrap();
    let u = bent(&space);
    let form = rubber::balance(&data(0.3), &all(), &both());
    let direction = Field::interpolate(&space, |x: &[f64; D]| -> [f64; D] {
        std::array::from_fn(|axis| (1.7 * x[0] - 2.3 * x[D - 1] + axis as f64).sin())
    })
    .unwrap();
    for threads in [1, 3] {
        let assembler = Assembler::new(&mesh).with_threads(Threads::new(threads));
        let taylor = verification::tangent(&assembler, &form, &[&u], &[&direction], 1e-3).unwrap();
        let order = taylor.second_order().unwrap();
        assert!(order > 1.95, "order {order}: {taylor:?}");
    }
}

#[test]
fn tangents_with_points_that_slide() {
    tangents::<2>(1, [3, 4]);
    tangents::<2>(2, [3, 4]);
    tangents::<3>(1, [2, 3]);
}

#[test]
fn the_same_on_any_number_of_threads() {
    let mesh = boxes([40, 57], [0.03, 0.02]);
    let space = Space::vector(&mesh, 1).unwrap();
    let (u, form) = (bent(&space), rubber::balance(&data(0.3), &all(), &both()));
    let of = |threads: usize| {
        let assembler = Assembler::new(&mesh).with_threads(Threads::new(threads));
        let residual = assembler.residual(&form, &[&u], &[&space]).unwrap();
        let tangent = assembler.tangent(&form, &[&u], &[&space]).unwrap();
        (residual, tangent.values().to_vec())
    };
    let one = of(1);
    assert!([2, 3, 7, 16].into_iter().all(|threads| of(threads) == one));
}

/// A tangent has the same bits in a new matrix, in one that held the tangent of other pairs, and in one that somebody wrote to.
fn replaced<const D: usize>(cells: [usize; 2])
where
    Dim: Dimension<D>,
{
    let mut offset = [0.03; D];
    offset[D - 1] = 0.02;
    let mesh = boxes(cells, offset);
    let space = Space::vector(&mesh, 2).unwrap();
    let (u, form) = (bent(&space), rubber::balance(&data(0.3), &all(), &both()));
    // Half of the second body is far away: fewer points have partners.
    let torn = Field::interpolate(&space, |x: &[f64; D]| -> [f64; D] {
        let up = if x[D - 1] > 1.01 && x[0] > 0.5 { 4.0 } else { 0.0 };
        std::array::from_fn(|axis| if axis + 1 == D { up - 0.01 } else { 0.11 })
    })
    .unwrap();
    for threads in [1, 3] {
        let rule = Quadrature::Degree(4);
        let assembler = Assembler::new(&mesh).with_threads(Threads::new(threads)).with_quadrature(rule);
        let points =
            [&u, &torn].map(|u| assembler.pairs_at(&Pairing::between("below", "above"), 4, u).unwrap());
        assert!(points[1].points < points[0].points && points[1].points > 0, "{points:?}");
        let problem = Problem::new(&form, &space).assembler(&assembler).start(&u);
        let pattern = Arc::clone(problem.pattern().unwrap());
        let assemble = |u: &Field<D>, matrix: &mut BlockMatrix| {
            let spaces = [&space];
            assembler.assemble_tangent(&form, &[u], &spaces, Parts::ALL, &pattern, matrix)
        };
        let mut new = BlockMatrix::zero(pattern.sparsity());
        assemble(&u, &mut new).unwrap();
        let mut matrix = new.clone();
        for _ in 0..2 {
            match assemble(&torn, &mut matrix) {
                Ok(()) => assert!(matrix != new),
                // Points that came to other facets.
                Err(error) => assert!(matches!(error, AssemblyError::Pattern { .. }), "{error}"),
            }
            assemble(&u, &mut matrix).unwrap();
            assert!(matrix == new);
            matrix.values_mut().fill(7.0);
        }
        assemble(&u, &mut matrix).unwrap();
        assert!(matrix == new);
    }
}

#[test]
fn tangents_replace_what_was_there() {
    replaced::<2>([7, 9]);
    replaced::<3>([3, 4]);
}

/// Both bodies turned and moved: tractions turn along, forces sum to nothing, and nothing slips.
#[test]
fn rigid_motions() {
    let mesh = boxes([3, 4], [0.003, -0.01]);
    let space = Space::vector(&mesh, 1).unwrap();
    let (sine, cosine) = 30.0_f64.to_radians().sin_cos();
    let turn = |x: &[f64; 2]| [cosine * x[0] - sine * x[1], sine * x[0] + cosine * x[1]];
    let moved = Field::interpolate(&space, |x: &[f64; 2]| {
        let y = turn(x);
        [y[0] - x[0] + 2.0, y[1] - x[1] - 1.0]
    })
    .unwrap();
    let assembler = Assembler::new(&mesh);
    let data = data(0.3);
    let force = |u: &Field<2>, axis: [f64; 2]| {
        assembler.functional(&rubber::force(
            &data,
            &rubber::Touch::on(Pairing::onto("below", "above")),
            u,
            axis,
        ))
    };
    let rest = Field::zero(&space);
    let [before, across] = [force(&rest, [0.0, 1.0]).unwrap(), force(&rest, [1.0, 0.0]).unwrap()];
    assert!(before < -0.1 && across.abs() < 1e-14, "{before} {across}");
    let found = [force(&moved, [1.0, 0.0]).unwrap(), force(&moved, [0.0, 1.0]).unwrap()];
    let expected = turn(&[across, before]);
    for axis in 0..2 {
        assert!((found[axis] - expected[axis]).abs() < 1e-13, "{found:?} {expected:?}");
    }
    let form = rubber::balance(&data, &all(), &both());
    for u in [&rest, &moved] {
        let residual = assembler.residual(&form, &[u], &[&space]).unwrap();
        let scale: f64 = residual.iter().map(|entry| entry.abs()).sum();
        for axis in 0..2 {
            let sum: f64 = residual.iter().skip(axis).step_by(2).sum();
            assert!(sum.abs() < 1e-13 * scale, "{sum} of {scale}");
        }
    }
}

/// Bodies that are pressed together between rigid plates, held sideways: a layer under uniform strain, in two bodies. F = diag(1, J)
/// in both, p = μ (1/J − J) − λ ln J / J.
fn pressed<const D: usize>(pairing: Pairing) -> (f64, usize, Field<D>)
where
    Dim: Dimension<D>,
{
    let (young, poisson, stretch) = (200.0, 0.3, 0.8_f64);
    let mut offset = [0.0; D];
    offset[D - 1] = 0.01;
    let lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
    let mu = young / (2.0 * (1.0 + poisson));
    let mesh = boxes([3, 3], offset);
    let space = Space::vector(&mesh, 1).unwrap();
    let data = rubber::data().lambda(lambda).mu(mu).gamma0(20.0 * young).kappa(0.3).old([0.0; D]);
    let form = rubber::balance(&data, &all(), &rubber::Touch::on(pairing.clone()));
    let mut plates = Constraints::new(&space);
    plates.fix("bottom", |_| [0.0; D]).unwrap();
    plates
        .fix("top", |_| -> [f64; D] {
            std::array::from_fn(|axis| if axis + 1 == D { 2.0 * (stretch - 1.0) - 0.01 } else { 0.0 })
        })
        .unwrap();
    for axis in 0..D - 1 {
        plates.fix_component(&format!("sides {axis}"), axis, |_| 0.0).unwrap();
    }
    let options = NewtonOptions { line_search: LineSearch::OnResidual, ..NewtonOptions::default() };
    // Near the solution, for bodies must not be turned inside out.
    let near = Field::interpolate(&space, |x: &[f64; D]| -> [f64; D] {
        let rise = x[D - 1] - if x[D - 1] > 1.005 { offset[D - 1] } else { 0.0 };
        let moved = 0.97 * ((stretch - 1.0) * rise - (x[D - 1] - rise));
        std::array::from_fn(|axis| if axis + 1 == D { moved } else { 0.01 * x[axis] * (1.0 - x[axis]) })
    });
    let near = near.unwrap();
    let problem = Problem::new(&form, &space).constrained(&plates).start(&near);
    let solved = problem.options(options).solve().unwrap();
    let up = std::array::from_fn(|axis| f64::from(u8::from(axis + 1 == D)));
    let one_side = rubber::Touch::on(Pairing::onto("below", "above"));
    let force = rubber::force(&data, &one_side, &solved.fields[0], up as [f64; D]);
    let pressure = -solved.functional(&force).unwrap();
    let exact = mu * (1.0 / stretch - stretch) - lambda * stretch.ln() / stretch;
    assert!((pressure - exact).abs() < 1e-10 * exact, "{pressure} is not {exact}");
    let steps = solved.history.len();
    let [u] = solved.fields;
    (pressure, steps, u)
}

#[test]
fn two_bodies_pressed_together_and_one_surface_with_itself() {
    let (_, steps, u) = pressed::<2>(Pairing::between("below", "above"));
    assert!(steps < 12, "{steps}");
    let (_, _, own) = pressed::<2>(Pairing::within("touch"));
    let difference = u.values().iter().zip(own.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(difference < 1e-10, "{difference}");
    pressed::<3>(Pairing::onto("above", "below").and(Pairing::onto("below", "above")));
}

#[test]
fn what_displaces_nothing_is_refused() {
    #[forms]
    mod fixed {
        pub struct Data {
            w: Given<Vector>,
        }
        #[pairs]
        pub struct Touch;
        pub fn distance() -> Functional {
            integral(Touch(w), gap)
        }
    }
    let mesh = boxes([2, 2], [0.0, 0.1]);
    let touch = fixed::Touch::on(Pairing::between("below", "above"));
    let constant = fixed::data().w([0.0, 0.1]);
    let error = Assembler::new(&mesh).functional(&fixed::distance(&constant, &touch)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "form `distance`, pairs `Touch` (below onto above, above onto below): `w` displaces surfaces and must be a field on a \
         space of cells with the traces of Lagrange elements"
    );
    let space = Space::vector(&mesh, 1).unwrap();
    let data = fixed::data().w(Field::zero(&space));
    let gap = Assembler::new(&mesh).functional(&fixed::distance(&data, &touch)).unwrap();
    assert!((gap - 0.2).abs() < 1e-14, "{gap}");
}
