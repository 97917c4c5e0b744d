use forms_core::forms;

/// Mistakes that have no page of their own: each line draws its message.
#[forms(crate = forms_core)]
pub mod seldom {
    pub struct Data {
        mu: Param,
        f: Given<Vector>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;

    pub fn right(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, mu * dot(u, v))
    }
    fn declared_a_value(u: Vector) -> Scalar {
        integral(Omega, dot(u, f))
    }
    fn derivative_by_a_number(u: Vector) -> Scalar {
        diff(dot(u, u), PI)
    }
    fn integrals_by_choice(u: Vector) -> Functional {
        if mu > 0 { integral(Omega, dot(u, u)) } else { integral(Gamma, dot(u, u)) }
    }
    fn integral_in_a_function(u: Vector) -> Scalar {
        sqrt(integral(Omega, dot(u, u)))
    }
    fn branches_of_two_ranks(u: Vector) -> Vector {
        if mu > 0 { u } else { grad(u) }
    }
    fn lengths_of_two_kinds(u: Vector) -> Scalar {
        dot([1, 2, 3, 4], u)
    }
    fn product_with_a_scalar_sign(u: Vector) -> Vector {
        outer(grad(u), u) * u
    }
    fn large_determinant() -> Scalar {
        det([[1, 2, 3, 4], [1, 2, 3, 4], [1, 2, 3, 4], [1, 2, 3, 4]])
    }
    fn rank_five(u: Vector) -> Vector {
        outer(outer(grad(u), grad(u)), u)
    }
    fn rank_five_by_diff(u: Vector) -> Vector {
        diff(outer(grad(u), grad(u)), u)
    }
    fn type_of_a_name(u: Vector) -> Scalar {
        let a: Matrices = dot(u, u);
        a
    }
    fn pattern_of_a_name(u: Vector) -> Scalar {
        let (a, b) = dot(u, u);
        a
    }
    pub fn gradient_of_the_normal(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Gamma, div(n) * dot(u, v))
    }
}

fn main() {}
