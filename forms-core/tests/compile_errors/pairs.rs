//! Contact pairs where there are none, and what a pair does not have.

use forms_core::forms;

#[forms(crate = forms_core)]
mod on_facets {
    #[facets]
    pub struct Gamma;

    pub fn opening(u: State<Vector>) -> Functional {
        integral(Gamma, gap - dot(u, toward))
    }
}

#[forms(crate = forms_core)]
mod without_a_side {
    #[pairs]
    pub struct Touch;

    pub fn opening(u: State<Vector>) -> Functional {
        integral(Touch, gap - dot(u, toward) + h)
    }

    pub fn bent() -> Functional {
        integral(Touch, jump(curvature) + other(facet_area))
    }

    pub fn slope(u: State<Vector>) -> Functional {
        integral(Touch, dot(grad(gap), toward))
    }
}

#[forms(crate = forms_core)]
mod twice {
    pub struct Data {
        gap: Given<Scalar>,
    }
    #[pairs]
    pub struct Touch;

    pub fn opening() -> Functional {
        integral(Touch, gap)
    }
}

#[forms(crate = forms_core)]
mod moved {
    #[pairs]
    pub struct Touch;

    pub fn energy(u: State<Vector>) -> Functional {
        integral(Touch, gap)
    }
    pub fn gradient(u: State<Vector>, Theta: Test<Vector>) -> Form {
        derivative(energy(u), shape, Theta)
    }
    pub fn rate(Theta: State<Vector>) -> Functional {
        integral(Touch, derivative(gap, shape, this(Theta)))
    }
}

fn main() {}
