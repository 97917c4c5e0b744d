use forms_core::forms;

#[forms(crate = forms_core)]
pub mod elastic {
    pub struct Data {
        mu: Param,
        M: Param<Matrix<2, 4>>,
        E: Param<Tensor4>,
    }
    #[cells]
    pub struct Omega;

    pub fn right(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, mu * inner(eps(u), eps(v)))
    }
    pub fn large(s: Scalar) -> Scalar {
        let a = det([[s, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]);
        let b = inv(transpose(M) * M);
        let c = tr(M);
        let d = dev(M);
        let e = diag(E);
        s
    }
    pub fn identities(s: Scalar) -> Scalar {
        s * tr(identity(0)) + s * tr(identity(s))
    }
}

/// A use of the module: it gives no further errors.
fn main() {
    let data = elastic::Data::<2> { mu: 1.0, M: [[0.0; 4]; 2], E: [[[[0.0; 2]; 2]; 2]; 2] };
    let right = elastic::right(&data, &elastic::Omega::on("all"));
    drop(right);
}
