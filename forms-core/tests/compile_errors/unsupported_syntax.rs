use forms_core::forms;

#[forms(crate = forms_core)]
pub mod elastic {
    pub struct Data {
        mu: Param,
        gap: Given<Scalar>,
        f: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct GammaC;

    fn sigma(w: Vector) -> Tensor {
        2 * mu * eps(w)
    }

    pub fn right(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(sigma(u), eps(v)))
    }
    fn looped(w: Vector) -> Scalar {
        let mut sum = 0;
        for i in 0..2 {
            sum += w[i];
        }
        sum
    }
    fn generic<T>(w: T) -> Scalar {
        w
    }
    const HALF: f64 = 0.5;
    pub fn wrong(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let a = u.dot(v);
        let b = div(u) ^ 2;
        let c = |w| w;
        let d = match mu { _ => 1 };
        let e = f.x + (1 as f64) + u[i] + f64::EPSILON + 2i32;
        let g = &u;
        integral(Omega, a + b * looped(v) + c + d + e + generic(v))
    }
}

/// A use of the module: it gives no further errors.
fn main() {
    let data = elastic::data::<2>().mu(1.0).gap(0.0).f([0.0; 2]);
    let omega = elastic::Omega::on("all");
    let right = elastic::right(&data, &omega);
    let wrong = elastic::wrong(&data, &omega);
    drop((right, wrong));
}
