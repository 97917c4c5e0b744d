use forms_core::forms;

#[forms(crate = forms_core)]
pub mod poisson {
    pub struct Data {
        gamma: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Wall;
    #[interior_facets]
    pub struct Skeleton;

    pub fn right(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Skeleton, gamma / avg(h) * jump(u) * jump(v))
    }
    fn flux(u: Scalar) -> Scalar {
        dot(avg(grad(u)), n)
    }
    pub fn wrong(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, jump(u) * v) + integral(Wall, flux(u) * this(v))
    }
    /// A direction brings the sides along.
    pub fn wrong_by_direction(u: State<Scalar>) -> Functional {
        derivative(integral(Omega, u * u), u, other(u))
    }
}

/// A use of the module: it gives no further errors.
fn main() {
    let data = poisson::Data::<2> { gamma: 1.0 };
    let (omega, wall, skeleton) = (poisson::Omega::on("all"), poisson::Wall::on("wall"), poisson::Skeleton::on("all"));
    let right = poisson::right(&data, &skeleton);
    let wrong = poisson::wrong(&data, &omega, &wall);
    drop((right, wrong));
}
