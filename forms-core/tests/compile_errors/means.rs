use forms_core::contract::History;
use forms_core::forms;

/// Expressions without a mean over a cell, and derivatives of means that are not available.
#[forms(crate = forms_core)]
pub mod averaged {
    pub struct Data {
        mu: Param,
        strain: History<Tensor>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;
    #[interior_facets]
    pub struct Skeleton;

    fn jacobian(u: Vector) -> Scalar {
        det(I + grad(u))
    }

    pub fn right(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let F = mean(I + mu * grad(u) / h);
        integral(Omega, inner(diff(pow(det(F), 2), F), mean(grad(v))))
    }
    pub fn of_a_determinant(u: State<Vector>) -> Functional {
        integral(Omega, mean(jacobian(u)))
    }
    pub fn of_a_product(u: State<Scalar>) -> Functional {
        integral(Omega, mean(u * u) + mean(2 / u))
    }
    pub fn of_positions(u: State<Scalar>) -> Functional {
        integral(Gamma, mean(x[0]) + mean(u + n[0]) + mean(facet_area * u))
    }
    pub fn of_second_derivatives(u: State<Scalar>) -> Functional {
        integral(Omega, tr(mean(hess(u))))
    }
    pub fn of_a_history() -> Functional {
        integral(Omega, tr(mean(strain)))
    }
    pub fn along_a_product(u: State<Scalar>) -> Functional {
        derivative(integral(Omega, pow(mean(u), 2)), u, u * u)
    }
    pub fn by_the_shape(u: State<Scalar>, T: State<Vector>) -> Functional {
        derivative(integral(Omega, mean(u)), shape, T)
    }
    pub fn by_a_name(u: State<Vector>) -> Functional {
        let F = I + grad(u);
        integral(Omega, tr(diff(det(F) * det(mean(F)), F)))
    }
    pub fn by_a_field(u: State<Scalar>) -> Functional {
        integral(Omega, diff(u * mean(u), u))
    }
    pub fn without_a_side(u: State<Scalar>) -> Functional {
        integral(Skeleton, mean(u))
    }
}

/// A use of the module: it gives no further errors.
pub fn form(strain: History<[[f64; 2]; 2], 2>) -> forms_core::contract::Form<2> {
    averaged::right(&averaged::Data::<2> { mu: 1.0, strain }, &averaged::Omega::on("all"))
}

fn main() {}
