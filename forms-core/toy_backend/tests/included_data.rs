//! Data that include other modules' data: the members are the struct's own, in one flat literal, with their defaults.

use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::mesh::Mesh;
use toy_backend::random::Random;
use toy_backend::{expression, functional};

#[forms(crate = toy_backend)]
pub mod elasticity {
    pub struct Data {
        #[doc(alias = "λ")]
        pub lambda: Given<Scalar>,
        pub mu: Param,
    }
    pub fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }
}

#[forms(crate = toy_backend)]
pub mod friction {
    #[includes(crate::elasticity::Data)]
    pub struct Data {
        pub gap: Given<Scalar>,
        #[default(0.25)]
        pub coefficient: Given<Scalar>,
        #[default(0)]
        pub drift: Param<Vector>,
    }
    pub fn bound(pressure: Scalar) -> Scalar {
        coefficient * pressure
    }
}

/// Members of two structs, with an own declaration of `gap`, which wins; `lambda` and `mu` come twice and are one.
#[forms(crate = toy_backend)]
pub mod flat {
    use crate::elasticity::stress;
    use crate::friction::bound;

    #[includes(crate::friction::Data, crate::elasticity::Data)]
    pub struct Data {
        pub gap: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn work(u: State<Vector>) -> Functional {
        integral(Omega, gap * bound(inner(stress(u), eps(u))) + dot(drift, u))
    }
    pub fn slope(u: State<Vector>) -> Scalar {
        diff(gap * bound(mu * dot(u, u)), mu)
    }
}

/// The same, typed out.
#[forms(crate = toy_backend)]
pub mod typed_out {
    use crate::elasticity::stress;

    pub struct Data {
        pub lambda: Given<Scalar>,
        pub mu: Param,
        pub gap: Param,
        pub coefficient: Given<Scalar>,
        pub drift: Param<Vector>,
    }
    #[cells]
    pub struct Omega;

    pub fn work(u: State<Vector>) -> Functional {
        integral(Omega, gap * (coefficient * inner(stress(u), eps(u))) + dot(drift, u))
    }
}

/// Includes what includes.
#[forms(crate = toy_backend)]
pub mod loaded {
    pub use crate::flat::{Omega, work};

    #[includes(crate::flat::Data)]
    pub struct Data {
        pub load: Param,
    }
}

/// The data need not be public: then they are included, and no value of them is handed over.
mod private {
    use forms_core::forms;

    #[forms(crate = toy_backend)]
    pub mod stiffness {
        struct Data {
            mu: Param,
        }
    }
    #[forms(crate = toy_backend)]
    pub mod doubled {
        #[includes(super::stiffness::Data)]
        pub struct Data {}
        #[cells]
        pub struct Rest;
        pub fn twice() -> Functional {
            integral(Rest, 2 * mu)
        }
    }
}

#[test]
fn private_data_are_included() {
    use private::doubled;
    let mesh = Mesh::<2>::cube(&mut Random(3));
    let value = |mu| functional(&mesh, &doubled::twice(&doubled::data().mu(mu), &doubled::Rest::on("all")));
    assert!(value(1.0) > 0.0 && (value(3.0) - 3.0 * value(1.0)).abs() < 1e-13);
}

fn lambda<const D: usize>() -> Given<f64, D> {
    Given::function(|x: &[f64; D]| 1.0 + x[0])
}

fn required<const D: usize>() -> flat::Data<D> {
    flat::data().lambda(lambda()).mu(0.7).gap(1.5)
}

#[test]
fn members_are_the_structs_own() {
    let mut random = Random(17);
    let mesh = Mesh::<3>::cube(&mut random);
    let u = random.field(mesh.nodes.len(), 3, 0.2, 0.3);
    let data = required().drift([0.1, -0.2, 0.3]);
    let coefficient = Given::constant(0.25);
    let whole =
        typed_out::data().lambda(lambda()).mu(0.7).gap(1.5).coefficient(coefficient).drift(data.drift);
    let model = flat::Model::new(data.clone());
    let mine = functional(&mesh, &model.work(u.source()));
    let theirs = functional(&mesh, &typed_out::Model::new(whole).work(u.source()));
    assert!(theirs.abs() > 1e-3 && (mine - theirs).abs() < 1e-14 * theirs.abs(), "{mine} {theirs}");
    let onward = loaded::Model::new(loaded::data_from(data.clone()).load(1.0));
    assert_eq!(functional(&mesh, &onward.work(u.source())), mine);
    // By an included parameter: gap coefficient u·u.
    let slopes = expression(&mesh, &model.slope(u.source()), (Entity::Cells, "all"));
    assert!(slopes.iter().all(|slope| slope[0] > 0.0));
}

#[test]
fn defaults_come_along() {
    let data: flat::Data<2> = required();
    let Source::Constant(coefficient) = data.coefficient.source() else { panic!("no constant") };
    assert_eq!((coefficient.as_slice(), data.drift), (&[0.25][..], [0.0; 2]));
}
