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
    pub fn crossed(u: Vector, s: Scalar) -> Scalar {
        let a = cross(grad(u), u);
        let b = cross([s, 1, 2], [s, 1]);
        let c = perp([s, s, s]);
        s
    }
}

/// A use of the module: it gives no further errors.
fn main() {
    let data = elastic::Data::<2> { mu: 1.0, M: [[0.0; 4]; 2], E: [[[[0.0; 2]; 2]; 2]; 2] };
    let right = elastic::right(&data, &elastic::Omega::on("all"));
    drop(right);
}
