//! Functions are inlined at each call: what is shared stays shared, whatever the depth of the calls.

use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::mesh::Mesh;
use toy_backend::random::Random;
use toy_backend::{expression, residual, tangent};

/// Forty levels, each calling the next one twice, and a module with the last.
macro_rules! chain {
    ($($name:ident $next:ident)*) => {
        #[forms(crate = toy_backend)]
        pub mod deep {
            pub struct Data { a: Param }
            #[cells]
            pub struct Omega;
            $( fn $name(w: Scalar) -> Scalar { $next(w) + a * $next(w) } )*
            fn last(w: Scalar) -> Scalar { w }

            pub fn value(w: Scalar) -> Scalar { f0(w) }
            pub fn form(w: Unknown<Scalar>, v: Test<Scalar>, z: Test<Scalar>) -> Form {
                integral(Omega, w * f0(v) + f0(w * w) * z)
            }
            pub fn squares(s: Scalar) -> Scalar {
                let s1 = s * s * s; let s2 = s1 * s1; let s3 = s2 * s2; let s4 = s3 * s3; let s5 = s4 * s4;
                let s6 = s5 * s5; let s7 = s6 * s6; let s8 = s7 * s7; let s9 = s8 * s8; let s10 = s9 * s9;
                let t1 = s10 * s10 / s9; let t2 = t1 * t1; let t3 = t2 * t2; let t4 = t3 * t3; let t5 = t4 * t4;
                let t6 = t5 * t5; let t7 = t6 * t6; let t8 = t7 * t7; let t9 = t8 * t8; let t10 = t9 * t9;
                let r1 = t10 * t10 / t9; let r2 = r1 * r1; let r3 = r2 * r2; let r4 = r3 * r3; let r5 = r4 * r4;
                let r6 = r5 * r5; let r7 = r6 * r6; let r8 = r7 * r7; let r9 = r8 * r8; let r10 = r9 * r9;
                r10 * r10 * r10 * r10
            }
        }
    };
}
chain! {
    f0 f1 f1 f2 f2 f3 f3 f4 f4 f5 f5 f6 f6 f7 f7 f8 f8 f9 f9 f10 f10 f11 f11 f12 f12 f13 f13 f14 f14 f15
    f15 f16 f16 f17 f17 f18 f18 f19 f19 f20 f20 f21 f21 f22 f22 f23 f23 f24 f24 f25 f25 f26 f26 f27 f27 f28
    f28 f29 f29 f30 f30 f31 f31 f32 f32 f33 f33 f34 f34 f35 f35 f36 f36 f37 f37 f38 f38 f39 f39 last
}

#[test]
fn forty_levels() {
    let a = -0.5;
    let mesh = Mesh::<2>::cube(&mut Random(5));
    let data = deep::data::<2>().a(a);
    let value = deep::value(&data, Source::Constant(vec![3.0]));
    let expected = 3.0 * (1.0_f64 + a).powi(40);
    assert!((expression(&mesh, &value, (Entity::Cells, "all"))[0][0] / expected - 1.0).abs() < 1e-13);

    let form = deep::form(&data, &deep::Omega::on("all"));
    let w = Random(6).field(mesh.nodes.len(), 1, 0.5, 0.4);
    let found = residual::<f64, 2>(&mesh, &form, std::slice::from_ref(&w));
    let matrix = tangent::<f64, 2>(&mesh, &form, std::slice::from_ref(&w));
    // Linear in the first half, quadratic in the second.
    let nodes = mesh.nodes.len();
    for row in 0..2 * nodes {
        let product: f64 = (0..nodes).map(|column| matrix[row][column] * w.values[column]).sum();
        let factor = if row < nodes { 1.0 } else { 2.0 };
        assert!(
            (product - factor * found[row]).abs() <= 1e-12 * found[row].abs(),
            "{row}: {product} against {factor} x {}",
            found[row]
        );
    }

    // Exponents past the range of an i32 are no mistake.
    let squares = deep::squares(&data, Source::Constant(vec![1.0]));
    assert_eq!(expression(&mesh, &squares, (Entity::Cells, "all"))[0], [1.0]);
}

/// Ogden's energy, twice as stiff where it is stretched: at a point its tangent has more operations than one function takes.
#[forms(crate = toy_backend, dimension = 3)]
pub mod ogden {
    pub struct Data {
        mu: Param,
        a: Param,
        b: Param,
        lambda: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn energy(u: Unknown<Vector>) -> Energy {
        let F = I + grad(u);
        let logarithm = tensor_ln(transpose(F) * F);
        let stiffness = if det(F) > 1 { 2 * mu } else { mu };
        let first = tr(tensor_exp(a / 2 * logarithm)) / a;
        let second = tr(tensor_exp(b / 2 * logarithm)) / b;
        integral(Omega, stiffness * (first + second) + lambda * pow(ln(det(F)), 2))
    }
}

/// The tangent is the derivative of the residual, for one cell at a time and for four.
#[test]
fn functions_in_parts() {
    let mut random = Random(11);
    let mesh = Mesh::<3>::cube(&mut random);
    let nodes = mesh.nodes.len();
    let (u, direction) = (random.field(nodes, 3, 0.1, 0.2), random.field(nodes, 3, 0.0, 1.0));
    let form = ogden::energy(&ogden::data().mu(0.7).a(1.3).b(-2.0).lambda(1.9), &ogden::Omega::on("all"));
    let matrix = tangent::<f64, 3>(&mesh, &form, std::slice::from_ref(&u));
    let by_four = tangent::<toy_backend::lanes::Four, 3>(&mesh, &form, std::slice::from_ref(&u));
    let largest = matrix.concat().iter().fold(0.0_f64, |most, entry| most.max(entry.abs()));
    for (one, four) in matrix.concat().iter().zip(by_four.concat()) {
        assert!((one - four).abs() <= 1e-13 * largest, "{one} and {four}");
    }
    let at = |step: f64| {
        let mut moved = u.clone();
        moved.values.iter_mut().zip(&direction.values).for_each(|(u, d)| *u += step * d);
        residual::<f64, 3>(&mesh, &form, &[moved])
    };
    let step = 1e-5;
    let (after, before) = (at(step), at(-step));
    for (row, (after, before)) in matrix.iter().zip(after.iter().zip(&before)) {
        let product: f64 = row.iter().zip(&direction.values).map(|(k, d)| k * d).sum();
        let difference = (after - before) / (2.0 * step);
        assert!((product - difference).abs() <= 1e-7 * largest, "{product} and {difference}");
    }
}
