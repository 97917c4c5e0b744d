use forms_core::forms;

/// Expressions that cannot be differentiated by the shape of the domain, and what the shape is not.
#[forms(crate = forms_core)]
pub mod moving {
    pub struct Data {
        mu: Param,
        f: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;

    pub fn right(u: State<Scalar>, T: State<Vector>) -> Functional {
        derivative(integral(Omega, f * u), shape, T) + derivative(integral(Gamma, h * u), h, mu)
    }
    pub fn no_value(u: State<Scalar>) -> Functional {
        integral(Omega, shape * u)
    }
    pub fn along_a_scalar(u: State<Scalar>) -> Functional {
        derivative(integral(Omega, u), shape, u)
    }
    pub fn of_the_curvature(T: State<Vector>) -> Functional {
        derivative(integral(Gamma, curvature), shape, T)
    }
    pub fn of_second_derivatives(T: State<Vector>) -> Functional {
        derivative(integral(Omega, div(grad(f))), shape, T)
    }
    pub fn by_the_normal(T: State<Vector>) -> Functional {
        derivative(integral(Gamma, dot(n, x)), n, T)
    }
    pub fn by_a_size_that_is_absent(u: State<Scalar>) -> Functional {
        derivative(integral(Omega, u), h, u)
    }
    pub fn declared_again(shape: State<Scalar>) -> Functional {
        integral(Omega, mu)
    }
}

fn main() {}
