use forms_core::contract::{Given, History};
use forms_core::forms;

/// Means over own facets where there are none, of what has none, and densities that are not one number per facet.
#[forms(crate = forms_core, dimension = 2)]
pub mod averaged {
    pub struct Data {
        gamma: Param,
        load: Given<Scalar>,
        past: History<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;
    #[pairs]
    pub struct Touch;

    pub fn right(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let p = neg_part(mean(this(load) + gamma / this(h) * gap));
        means(Touch(u), 0, facet_area / this(h) * p * mean(dot(toward, jump(v))))
            + means(Touch(u), 1, dot(mean(jump(mean(grad(u)) * n)), mean(jump(v))))
    }
    pub fn outside_of_means(u: Unknown<Vector>) -> Energy {
        integral(Touch(u), sqr(neg_part(mean(gap))))
    }
    pub fn nested(u: Unknown<Vector>) -> Energy {
        means(Touch(u), 0, sqr(mean(gap - mean(gap))))
    }
    pub fn test_outside(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        means(Touch(u), 0, mean(gap) * dot(mean(toward), jump(v)))
    }
    pub fn twice_in_the_test(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        means(Touch(u), 0, sqr(mean(dot(toward, jump(v)))))
    }
    pub fn varies(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        means(Touch(u), 0, gap * mean(dot(toward, jump(v))) + this(load) * mean(dot(toward, jump(v))))
    }
    pub fn opposite_size(u: Unknown<Vector>) -> Energy {
        means(Touch(u), 0, sqr(mean(gap)) / other(h))
    }
    pub fn of_a_history(u: Unknown<Vector>) -> Energy {
        means(Touch, 0, sqr(mean(this(past) + jump(u[0]))))
    }
    pub fn of_cells(u: Unknown<Vector>) -> Energy {
        means(Omega, 0, sqr(mean(u[0])))
    }
    pub fn of_facets(u: Unknown<Vector>) -> Energy {
        means(Gamma, 0, sqr(mean(u[0])))
    }
    pub fn of_degree_two(u: Unknown<Vector>) -> Energy {
        means(Touch(u), 2, sqr(mean(gap)))
    }
    pub fn without_a_degree(u: Unknown<Vector>) -> Energy {
        means(Touch(u), sqr(mean(gap)))
    }
    pub fn without_a_side(u: Unknown<Vector>) -> Energy {
        means(Touch(u), 0, sqr(mean(u[0])))
    }
}

/// Means have no products without a matrix.
#[forms(crate = forms_core, dimension = 2, matrix_free)]
pub mod products {
    #[pairs]
    pub struct Touch;

    pub fn without_a_matrix(u: Unknown<Vector>) -> Energy {
        means(Touch(u), 0, sqr(mean(gap)))
    }
}

/// A use of the modules: it gives no further errors.
pub fn form(load: Given<f64, 2>, past: History<f64, 2>) -> forms_core::contract::Form<2> {
    averaged::right(&averaged::Data::<2> { gamma: 1.0, load, past }, &averaged::Touch::on("touch"))
}

fn main() {}
