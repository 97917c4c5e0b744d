//! Pairs of displaced surfaces: unknowns that displace no surface, and quantities without a derivative.

use forms_core::forms;

#[forms(crate = forms_core)]
mod displacements {
    pub struct Data {
        k: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[pairs]
    pub struct Touch;

    pub fn on_cells(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega(u), dot(u, v))
    }
    pub fn by_a_scalar(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(k), gap * dot(jump(v), toward))
    }
    pub fn by_an_expression(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(2 * u), gap * dot(jump(v), toward))
    }
    pub fn by_a_test_function(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(v), gap * dot(jump(v), toward))
    }
    pub fn twice(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(u + u), gap * dot(jump(v), toward))
    }
    pub fn misspelt(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Tuch(u), gap * dot(jump(v), toward))
    }
}

#[forms(crate = forms_core)]
mod derivatives {
    #[pairs]
    pub struct Touch;

    pub fn inside_a_side(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(u), dot(other(gap * u), jump(v)))
    }
    pub fn across(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(u), inner(grad(other(u)), this(grad(v))))
    }
    pub fn one_derivative_more(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(u), gap * inner(jump(hess(u)), jump(hess(v))))
    }
    pub fn normal_twice(u: Unknown<Vector>) -> Energy {
        integral(Touch(u), gap * dot(other(n), toward))
    }
    pub fn without_a_side(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Touch(u), gap * dot(v, toward))
    }
}

fn main() {}
