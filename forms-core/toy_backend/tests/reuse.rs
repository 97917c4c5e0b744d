//! Imports: functions of one forms module in another give what the same text written there gives, whatever the order of
//! the modules, the way of the import and the names in between.

use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::mesh::Mesh;
use toy_backend::random::Random;
use toy_backend::{expression, functional, residual, tangent};

/// Before the modules that it imports from.
#[forms(crate = toy_backend)]
pub mod contact {
    use super::elasticity::{elasticity, stress as sigma};
    use super::library::obstacle::{approach, pressure};

    pub struct Data {
        mu: Param,
        /// In the exporting module it is a constant.
        lambda: Given<Scalar>,
        gamma0: Param,
        gap: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct GammaC;

    /// A function with the name of a private one of `elasticity` that `stress` needs.
    fn strain(w: Vector) -> Tensor {
        grad(w)
    }
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        elasticity(u, v)
            + integral(GammaC, pressure(u) * approach(v))
            + integral(Omega, inner(strain(u), strain(v)))
    }
    pub fn mean_stress(u: Vector) -> Scalar {
        tr(sigma(u)) / D
    }
}

#[forms(crate = toy_backend)]
pub mod elasticity {
    pub struct Data {
        lambda: Param,
        mu: Param,
    }
    #[cells]
    pub struct Omega;

    fn strain(w: Vector) -> Tensor {
        // A local of the name of a member that `strain` does not read.
        let gap = grad(w);
        (gap + transpose(gap)) / 2
    }
    pub fn stress(w: Vector) -> Tensor {
        2 * mu * strain(w) + lambda * tr(strain(w)) * I
    }
    /// a(u, v).
    pub fn elasticity(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(stress(u), strain(v)))
    }
}

mod library {
    use forms_core::forms;

    /// A module that imports, and that others import from.
    #[forms(crate = toy_backend)]
    pub mod obstacle {
        pub use crate::elasticity::stress;

        pub struct Data {
            lambda: Param,
            mu: Param,
            gamma0: Param,
            gap: Given<Scalar>,
        }

        pub fn approach(w: Vector) -> Scalar {
            dot(w, n)
        }
        fn gamma() -> Scalar {
            gamma0 / h
        }
        pub fn pressure(w: Vector) -> Scalar {
            pos_part(gamma() * (approach(w) - gap) - dot(stress(w) * n, n))
        }
    }
}

/// `contact`, typed out.
#[forms(crate = toy_backend)]
pub mod typed_out {
    pub struct Data {
        mu: Param,
        lambda: Given<Scalar>,
        gamma0: Param,
        gap: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct GammaC;

    fn sigma(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(sigma(u), eps(v)) + inner(grad(u), grad(v)))
            + integral(GammaC, pos_part(gamma0 / h * (dot(u, n) - gap) - dot(sigma(u) * n, n)) * dot(v, n))
    }
    pub fn mean_stress(u: Vector) -> Scalar {
        tr(sigma(u)) / D
    }
}

/// The same function on two ways, one of them through the other module's `pub use`; and a whole form, made a form of
/// this module.
#[forms(crate = toy_backend)]
pub mod both_ways {
    use super::elasticity::stress as direct_way;
    pub use super::elasticity::{elasticity, stress};
    use super::library::obstacle::stress as other_way;
    use super::library::obstacle::stress;

    pub struct Data {
        lambda: Param,
        mu: Param,
    }
    #[cells]
    pub struct Omega;

    pub fn difference(w: Vector) -> Tensor {
        direct_way(w) - other_way(w)
    }
}

/// Data and region of another module; one is renamed.
#[forms(crate = toy_backend)]
pub mod dynamics {
    use super::elasticity::{Data, Omega as Body, stress};

    pub fn momentum(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Body, mu * dot(u, v) + inner(stress(u), grad(v)))
    }
}

/// Two modules of one name and one text.
macro_rules! twin {
    ($outer:ident) => {
        mod $outer {
            #[forms_core::forms(crate = toy_backend)]
            pub mod twin {
                pub fn twice(s: Scalar) -> Scalar {
                    2 * s
                }
            }
        }
    };
}
twin!(first);
twin!(second);

fn check<const D: usize>()
where
    Dim: Dimension<D>,
{
    let mut random = Random(7);
    let mesh = Mesh::<D>::cube(&mut random);
    let u = random.field(mesh.nodes.len(), D, 0.0, 0.3);
    let (mu, gamma0) = (0.7, 3.0);
    let (lambda, gap) = (Given::function(|x: &[f64; D]| 1.0 + x[0]), Given::constant(0.05));
    let imported = contact::data().mu(mu).lambda(lambda.clone()).gamma0(gamma0).gap(gap.clone());
    let typed = typed_out::data().mu(mu).lambda(lambda).gamma0(gamma0).gap(gap);
    let form = contact::direct(&imported, &contact::Omega::on("all"), &contact::GammaC::on("boundary"));
    let other = typed_out::direct(&typed, &typed_out::Omega::on("all"), &typed_out::GammaC::on("boundary"));
    let unknowns = [u.clone()];
    let (mine, theirs) =
        (residual::<f64, D>(&mesh, &form, &unknowns), residual::<f64, D>(&mesh, &other, &unknowns));
    assert!(mine.iter().any(|entry| entry.abs() > 1e-3));
    close(&mine, &theirs);
    let (mine, theirs) =
        (tangent::<f64, D>(&mesh, &form, &unknowns), tangent::<f64, D>(&mesh, &other, &unknowns));
    close(&mine.concat(), &theirs.concat());
    let value = expression(&mesh, &contact::mean_stress(&imported, u.source()), (Entity::Cells, "all"));
    let other = expression(&mesh, &typed_out::mean_stress(&typed, u.source()), (Entity::Cells, "all"));
    close(&value.concat(), &other.concat());
}

/// Sums are ordered differently, so the last bits may differ.
fn close(mine: &[f64], theirs: &[f64]) {
    assert_eq!(mine.len(), theirs.len());
    let size = theirs.iter().fold(0.0, |size: f64, entry| size.max(entry.abs()));
    for (mine, theirs) in mine.iter().zip(theirs) {
        assert!((mine - theirs).abs() <= 1e-14 * size, "{mine} and {theirs}");
    }
}

#[test]
fn imported_functions_mean_what_they_mean_typed_out() {
    check::<2>();
    check::<3>();
}

#[test]
fn a_function_on_two_ways_is_one_function_and_pub_use_makes_it_the_modules_own() {
    let mut random = Random(3);
    let mesh = Mesh::<2>::cube(&mut random);
    let u = random.field(mesh.nodes.len(), 2, 0.0, 0.3);
    let data = both_ways::data::<2>().lambda(1.3).mu(0.7);
    let zero = expression(&mesh, &both_ways::difference(&data, u.source()), (Entity::Cells, "all"));
    assert!(zero.concat().iter().all(|entry| *entry == 0.0));
    let mine = tangent::<f64, 2>(
        &mesh,
        &both_ways::elasticity(&data, &both_ways::Omega::on("all")),
        std::slice::from_ref(&u),
    );
    let original = elasticity::data::<2>().lambda(1.3).mu(0.7);
    let theirs = tangent::<f64, 2>(
        &mesh,
        &elasticity::elasticity(&original, &elasticity::Omega::on("all")),
        std::slice::from_ref(&u),
    );
    assert_eq!(mine, theirs);
    let stress = expression(&mesh, &both_ways::stress(&data, u.source()), (Entity::Cells, "all"));
    assert!(stress.concat().iter().any(|entry| *entry != 0.0));
}

#[test]
fn data_and_regions_are_imported_as_the_types_that_they_are() {
    let mut random = Random(3);
    let mesh = Mesh::<2>::cube(&mut random);
    let u = random.field(mesh.nodes.len(), 2, 0.0, 0.3);
    let (data, omega) = (elasticity::data::<2>().lambda(1.3).mu(0.7), elasticity::Omega::on("all"));
    let unknowns = [u];
    let sum = tangent::<f64, 2>(&mesh, &dynamics::momentum(&data, &omega), &unknowns);
    let stiffness = tangent::<f64, 2>(&mesh, &elasticity::elasticity(&data, &omega), &unknowns);
    // Rows of a stiffness matrix sum to zero; those of μ times the mass matrix to μ|Ω| in all, per component.
    let total = |matrix: &[Vec<f64>]| matrix.iter().flatten().sum::<f64>();
    let area: f64 = mesh.elements(Entity::Cells, "all").iter().map(|cell| cell.cell.cell_volume).sum();
    assert!((total(&sum) - total(&stiffness) - 2.0 * 0.7 * area).abs() < 1e-12);
}

#[test]
fn modules_of_one_name_do_not_collide() {
    let mesh = Mesh::<2>::cube(&mut Random(1));
    let (one, two) = (
        first::twin::twice::<2>(Source::Constant(vec![1.0])),
        second::twin::twice::<2>(Source::Constant(vec![2.0])),
    );
    assert_eq!(expression(&mesh, &one, (Entity::Cells, "all"))[0], [2.0]);
    assert_eq!(expression(&mesh, &two, (Entity::Cells, "all"))[0], [4.0]);
}

/// Names that are keywords, in all places that travel: functions that call each other, members, regions, modules.
#[forms(crate = toy_backend)]
pub mod r#loop {
    pub struct Data {
        r#type: Param,
    }
    #[cells]
    pub struct r#match;

    fn r#fn(s: Scalar) -> Scalar {
        r#type * s
    }
    pub fn r#use(r#in: Scalar) -> Scalar {
        let r#let = r#fn(r#in);
        r#let + 1
    }
    pub fn r#struct(r#mut: State<Scalar>) -> Functional {
        integral(r#match, r#use(r#mut))
    }
}

#[forms(crate = toy_backend)]
pub mod keywords {
    pub use super::r#loop::{r#match, r#struct};
    use super::r#loop::{r#use as plain, r#use as r#where};

    #[includes(super::r#loop::Data)]
    pub struct Data {
        r#as: Param,
    }

    pub fn r#dyn(r#ref: State<Scalar>) -> Functional {
        integral(r#match, r#where(r#ref) + r#as * plain(r#ref))
    }
}

/// Imports whose origin imported them under another name, and which are renamed here.
#[forms(crate = toy_backend)]
pub mod again {
    pub use super::keywords::{r#dyn as r#enum, r#struct};
    use super::r#loop::r#match;

    #[includes(super::keywords::Data)]
    pub struct Data {}
}

#[test]
fn names_that_are_keywords_travel() {
    let mesh = Mesh::<2>::cube(&mut Random(1));
    let volume: f64 = mesh.elements(Entity::Cells, "all").iter().map(|cell| cell.cell.cell_volume).sum();
    let two = || Source::<2>::Constant(vec![2.0]);
    let value = |form: &dyn Fn() -> f64, expected: f64| assert!((form() / volume - expected).abs() < 1e-12);
    let data = keywords::data::<2>().r#type(3.0).r#as(10.0);
    value(&|| functional(&mesh, &keywords::r#struct(&data, &r#loop::r#match::on("all"), two())), 7.0);
    value(&|| functional(&mesh, &keywords::r#dyn(&data, &r#loop::r#match::on("all"), two())), 77.0);
    let included = again::data_from(data.clone());
    value(&|| functional(&mesh, &again::r#enum(&included, &r#loop::r#match::on("all"), two())), 77.0);
    let model = keywords::Model { data, regions: keywords::Regions::default().r#match("all") };
    value(&|| functional(&mesh, &model.r#dyn(two())), 77.0);
}
