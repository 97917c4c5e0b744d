use forms_core::forms;

#[forms(crate = forms_core)]
pub mod elastic {
    pub struct Data {
        mu: Param,
        gap: Given<Scalar>,
        f: Given<Vector>,
        a: Param<Vector<0>>,
        b: Param<Vector<N>>,
        c: Given<Matrix<3>>,
    }
    #[cells]
    pub struct Omega;

    pub fn right(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, mu * inner(eps(u), eps(v)))
    }
    pub fn wrong(u: State<Vector<2, 3>>, w: Scalar) -> Tensor<3> {
        w * u
    }
    pub fn let_wrong(w: Scalar) -> Scalar {
        let a: Matrix<2, -1> = w;
        w
    }
}

/// A use of the module: it gives no further errors.
fn main() {
    let data = elastic::data::<2>().mu(1.0).gap(0.0).f([0.0; 2]).a([0.0; 2]).b([0.0; 2]).c([[0.0; 2]; 2]);
    let omega = elastic::Omega::on("all");
    let right = elastic::right(&data, &omega);
    drop(right);
}
