//! Data that include another module's whole data, and defaults: forms read included members as they read their own.

use forms_core::{form, forms};
use toy_backend::contract::*;
use toy_backend::mesh::Mesh;
use toy_backend::random::Random;
use toy_backend::{Nodal, expression, functional, residual, tangent};

/// Includes what includes another, before both.
#[forms(crate = toy_backend)]
pub mod loaded {
    pub use super::library::contact::{GammaC, Omega, direct, pressure};

    /// Data of the loaded body.
    #[includes(super::library::contact::Data)]
    pub struct Data {
        /// Force per volume.
        #[default(0)]
        pub force: Param<Vector>,
        /// Weight of J.
        #[default(-2.5)]
        weight: Param,
        #[default(0)]
        twist: Param<Matrix<2, D>>,
    }
    /// J.
    pub fn criterion(u: State<Vector>) -> Functional {
        integral(Omega, weight * dot(force, u) + mu * dot(u, u) + inner(twist, twist))
            + integral(GammaC, gap * law(pressure(u)))
    }
    pub fn adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }
    /// By a member of what the included data include, and of the included data.
    pub fn by_stiffness(u: State<Vector>, p: State<Vector>) -> Functional {
        derivative(direct(u, p) + criterion(u), mu, 1)
    }
    pub fn by_gap(u: State<Vector>, p: State<Vector>, change: State<Scalar>) -> Functional {
        derivative(direct(u, p) + criterion(u), gap, change)
    }
    pub fn slope(u: State<Vector>) -> Scalar {
        diff(mu * mu * pressure(u), mu)
    }
}

mod library {
    use forms_core::forms;

    #[forms(crate = toy_backend)]
    pub mod contact {
        use crate::elasticity::stress;

        #[includes(crate::elasticity::Data)]
        pub struct Data {
            #[doc(alias = "g")]
            pub gap: Given<Scalar>,
            pub gamma0: Param,
            #[default(0.25)]
            pub friction: Given<Scalar>,
            #[default(0)]
            pub drift: Carried<Vector>,
        }
        #[cells]
        pub struct Omega;
        #[facets]
        pub struct GammaC;

        pub fn pressure(w: Vector) -> Scalar {
            pos_part(gamma0 / h * (dot(w, n) - gap) - dot(stress(w) * n, n))
        }
        pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
            integral(Omega, inner(stress(u), grad(v)) - dot(drift, v))
                + integral(GammaC, (pressure(u) + friction) * dot(v, n))
        }
    }
}

#[forms(crate = toy_backend)]
pub mod elasticity {
    pub struct Data {
        #[doc(alias = "λ")]
        pub lambda: Given<Scalar>,
        pub mu: Param,
        pub law: Table,
    }
    pub fn stress(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }
}

/// Data that include others, imported as the type that they are; and data whose members all have defaults.
#[forms(crate = toy_backend)]
pub mod imported {
    pub use super::library::contact::{Data, Omega};

    pub fn mass(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, mu * gamma0 * u * v)
    }
}

#[forms(crate = toy_backend)]
pub mod all_by_default {
    pub use super::library::contact::Omega;

    pub struct Data {
        #[default(2.1)]
        pub rho: Param,
    }
    pub fn mass(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, rho * u * v)
    }
}

/// The meaning of `loaded`, with all members in one struct.
#[forms(crate = toy_backend)]
pub mod typed_out {
    pub struct Data {
        weight: Param,
        force: Param<Vector>,
        gamma0: Param,
        law: Table,
        gap: Given<Scalar>,
        mu: Param,
        friction: Given<Scalar>,
        lambda: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct GammaC;

    fn sigma(w: Vector) -> Tensor {
        2 * mu * eps(w) + lambda * tr(eps(w)) * I
    }
    fn pressure(w: Vector) -> Scalar {
        pos_part(gamma0 / h * (dot(w, n) - gap) - dot(sigma(w) * n, n))
    }
    pub fn direct(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(sigma(u), grad(v))) + integral(GammaC, (pressure(u) + friction) * dot(v, n))
    }
    pub fn criterion(u: State<Vector>) -> Functional {
        integral(Omega, weight * dot(force, u) + mu * dot(u, u)) + integral(GammaC, gap * law(pressure(u)))
    }
    pub fn adjoint(u: State<Vector>, p: Unknown<Vector>, q: Test<Vector>) -> Form {
        derivative(direct(u, p), u, q) + derivative(criterion(u), u, q)
    }
    /// R(u; p) + J(u), a number.
    pub fn sum(u: State<Vector>, p: State<Vector>) -> Functional {
        direct(u, p) + criterion(u)
    }
}

const GAMMA0: f64 = 3.0;
const GAP: f64 = 0.05;

fn law() -> Table {
    Table::linear(&[[-1.0, 0.5], [0.5, 1.0], [4.0, 3.0]]).unwrap()
}

fn lambda<const D: usize>() -> Given<f64, D> {
    Given::function(|x: &[f64; D]| 1.0 + x[0])
}

fn contact<const D: usize>(mu: f64, gap: Given<f64, D>) -> library::contact::Data<D> {
    let elastic = elasticity::data().lambda(lambda()).mu(mu).law(law());
    library::contact::data_from(elastic).gap(gap).gamma0(GAMMA0)
}

fn loaded<const D: usize>(mu: f64, gap: Given<f64, D>) -> loaded::Data<D> {
    loaded::data_from(contact(mu, gap)).force([0.3; D])
}

fn whole<const D: usize>(mu: f64, gap: Given<f64, D>) -> typed_out::Data<D> {
    typed_out::data()
        .weight(-2.5)
        .force([0.3; D])
        .gamma0(GAMMA0)
        .law(law())
        .gap(gap)
        .mu(mu)
        .friction(0.25)
        .lambda(lambda())
}

/// Sums are ordered differently, so the last bits may differ.
fn close(mine: &[f64], theirs: &[f64], tolerance: f64) {
    assert_eq!(mine.len(), theirs.len());
    let size = theirs.iter().fold(0.0, |size: f64, entry| size.max(entry.abs()));
    assert!(size > 1e-3);
    for (mine, theirs) in mine.iter().zip(theirs) {
        assert!((mine - theirs).abs() <= tolerance * size, "{mine} and {theirs}");
    }
}

struct Body<const D: usize> {
    mesh: Mesh<D>,
    u: Nodal,
    p: Nodal,
    change: Nodal,
}

impl<const D: usize> Body<D> {
    fn new() -> Self {
        let mut random = Random(11);
        let mesh = Mesh::<D>::cube(&mut random);
        let nodes = mesh.nodes.len();
        let [u, p, change] = [(D, 0.2), (D, 0.1), (1, 0.5)]
            .map(|(components, centre)| random.field(nodes, components, centre, 0.3));
        Body { mesh, u, p, change }
    }
}

fn check_forms<const D: usize>()
where
    Dim: Dimension<D>,
{
    let Body { mesh, u, p, .. } = Body::<D>::new();
    let gap = Given::constant(GAP);
    let model = loaded::Model {
        regions: loaded::Regions::default().gamma_c("boundary"),
        ..loaded::Model::new(loaded(0.7, gap.clone()))
    };
    let other = typed_out::Model {
        regions: typed_out::Regions::default().gamma_c("boundary"),
        ..typed_out::Model::new(whole(0.7, gap))
    };
    let unknowns = [u.clone()];
    let (mine, theirs) = (model.direct(), other.direct());
    close(
        &residual::<f64, D>(&mesh, &mine, &unknowns),
        &residual::<f64, D>(&mesh, &theirs, &unknowns),
        1e-14,
    );
    let mine = tangent::<f64, D>(&mesh, &mine, &unknowns);
    close(&mine.concat(), &tangent::<f64, D>(&mesh, &theirs, &unknowns).concat(), 1e-14);
    let (mine, theirs) = (model.adjoint(u.source()), other.adjoint(u.source()));
    let unknowns = [p];
    close(
        &residual::<f64, D>(&mesh, &mine, &unknowns),
        &residual::<f64, D>(&mesh, &theirs, &unknowns),
        1e-14,
    );
    let (mine, theirs) = (model.criterion(u.source()), other.criterion(u.source()));
    close(&[functional(&mesh, &mine)], &[functional(&mesh, &theirs)], 1e-14);
}

#[test]
fn included_members_are_members() {
    check_forms::<2>();
    check_forms::<3>();
}

#[test]
fn data_that_include_others_are_imported_as_they_are() {
    let Body { mesh, change, .. } = Body::<2>::new();
    let omega = library::contact::Omega::on("all");
    let mine = imported::mass(&contact(0.7, Given::constant(GAP)), &omega);
    let theirs = all_by_default::mass(&all_by_default::data::<2>(), &omega);
    let unknowns = [change];
    let [mine, theirs] =
        [tangent::<f64, 2>(&mesh, &mine, &unknowns), tangent::<f64, 2>(&mesh, &theirs, &unknowns)];
    close(&mine.concat(), &theirs.concat(), 1e-14);
}

/// A constructor asks for imported regions in the order of their own module, whatever that of the imports.
#[test]
fn imported_regions_keep_their_order() {
    let data = loaded::<2>(0.7, Given::constant(GAP));
    let direct = loaded::direct(&data, &loaded::Omega::on("all"), &loaded::GammaC::on("boundary"));
    let symbols: Vec<&str> = direct.inputs().regions.iter().map(|region| region.symbol).collect();
    assert_eq!(symbols, ["Omega", "GammaC"]);
}

/// Central differences of what `typed_out` gives.
fn check_derivatives<const D: usize>()
where
    Dim: Dimension<D>,
{
    let Body { mesh, u, p, change } = Body::<D>::new();
    // On the far side of the contact's kink everywhere.
    let (mu, gap) = (0.01, -1.0);
    let regions = typed_out::Regions::default().gamma_c("boundary");
    let sum = |mu: f64, gap: Given<f64, D>| {
        let model = typed_out::Model { data: whole(mu, gap), regions: regions.clone() };
        functional(&mesh, &model.sum(u.source(), p.source()))
    };
    let model = loaded::Model {
        regions: loaded::Regions::default().gamma_c("boundary"),
        ..loaded::Model::new(loaded(mu, Given::constant(gap)))
    };
    let step = 1e-5;
    let by_mu = (sum(mu + step, Given::constant(gap)) - sum(mu - step, Given::constant(gap))) / (2.0 * step);
    let found = functional(&mesh, &model.by_stiffness(u.source(), p.source()));
    close(&[found], &[by_mu], 1e-7);
    let by_gap = (sum(mu, Given::constant(gap + step)) - sum(mu, Given::constant(gap - step))) / (2.0 * step);
    let one = Nodal { values: change.values.iter().map(|_| 1.0).collect(), ..change };
    let found = functional(&mesh, &model.by_gap(u.source(), p.source(), one.source()));
    close(&[found], &[by_gap], 1e-7);
}

#[test]
fn one_may_differentiate_by_included_members() {
    check_derivatives::<2>();
    check_derivatives::<3>();
}

#[test]
fn defaults_stand_where_nothing_was_given() {
    let data = contact::<3>(0.7, Given::constant(GAP));
    let constant = |source: &Source<3>| match source {
        Source::Constant(values) => values.clone(),
        _ => panic!("no constant"),
    };
    assert_eq!(constant(data.friction.source()), [0.25]);
    assert_eq!(constant(data.drift.source()), [0.0; 3]);
    let data: loaded::Data<3> =
        loaded::data().lambda(data.lambda.clone()).mu(0.7).law(law()).gap(GAP).gamma0(GAMMA0);
    assert_eq!(constant(data.friction.source()), [0.25]);
    assert_eq!((data.force, data.weight, data.twist), ([0.0; 3], -2.5, [[0.0; 3]; 2]));
    assert_eq!(data.mu, 0.7);
}

/// Parameters are reported by their own names, and formulas have the signs and documentation of included members.
#[test]
fn names_and_signs_of_included_members_are_kept() {
    let model = loaded::Model::<2>::new(loaded(0.7, Given::constant(GAP)));
    let criterion = model.criterion(Given::<[f64; 2], 2>::constant([0.0; 2]).source().clone());
    let names = &criterion.inputs().parameter_names;
    assert_eq!(names[..4], ["mu", "gamma0", "force[0]", "force[1]"]);
    let formula = criterion.formula().unicode;
    assert!(formula.contains("g law(") && formula.contains("λ tr"), "{formula}");
}

/// The partial derivative by an included member, against differences.
#[test]
fn a_value_is_differentiated_by_an_included_member() {
    let Body { mesh, u, .. } = Body::<3>::new();
    let on_facets = |mu: f64| {
        let data = loaded(mu, Given::constant(-1.0));
        let pressure = expression(&mesh, &loaded::pressure(&data, u.source()), (Entity::Facets, "boundary"));
        let slope = expression(&mesh, &loaded::slope(&data, u.source()), (Entity::Facets, "boundary"));
        (pressure.concat().iter().map(|pressure| mu * mu * pressure).collect::<Vec<f64>>(), slope.concat())
    };
    let (mu, step) = (0.01, 1e-5);
    let ((ahead, _), (behind, _)) = (on_facets(mu + step), on_facets(mu - step));
    let differences: Vec<f64> =
        ahead.iter().zip(behind).map(|(ahead, behind)| (ahead - behind) / (2.0 * step)).collect();
    close(&on_facets(mu).1, &differences, 1e-7);
}

/// A value of the first included data brings all of its members, also those with a default; the others have their defaults.
#[test]
fn a_value_of_the_first_included_data_is_handed_over() {
    let given = contact::<2>(0.7, Given::constant(GAP)).friction(0.5).drift([0.1, 0.2]);
    let data = loaded::data_from(given).weight(2.0);
    let constant = |source: &Source<2>| match source {
        Source::Constant(values) => values.clone(),
        _ => panic!("no constant"),
    };
    assert_eq!(constant(data.friction.source()), [0.5]);
    assert_eq!(constant(data.drift.source()), [0.1, 0.2]);
    assert_eq!(constant(data.gap.source()), [GAP]);
    assert_eq!((data.mu, data.gamma0, data.force, data.weight), (0.7, GAMMA0, [0.0; 2], 2.0));
    // `Into` takes the required members as well.
    let elastic = elasticity::data::<2>().lambda(lambda()).mu(0.9).law(law());
    let required = library::contact::data().lambda(lambda()).mu(0.9).law(law()).gap(GAP).gamma0(GAMMA0);
    let data: loaded::Data<2> = loaded::data_from(required);
    let other = library::contact::data_from(elastic).gap(GAP).gamma0(GAMMA0);
    assert_eq!((data.mu, constant(data.friction.source())), (other.mu, vec![0.25]));
}

/// An operator that reads included members asks `form!` for them.
#[test]
fn a_form_without_a_module_imports_what_reads_included_data() {
    let Body { mesh, u, .. } = Body::<2>::new();
    let imported = form!(
        use library::contact::pressure;
        |u: State<Vector>| -> Functional { integral(facets("boundary"), pressure(u)) },
        gamma0: Param = 3.0,
        gap: Given<Scalar> = 0.05,
        lambda: Param = 1.5,
        mu: Param = 0.7,
        crate = toy_backend,
    );
    let typed = form!(
        |u: State<Vector>| -> Functional {
            let sigma = 1.4 * eps(u) + 1.5 * div(u) * I;
            integral(facets("boundary"), pos_part(3 / h * (dot(u, n) - 0.05) - dot(sigma * n, n)))
        },
        crate = toy_backend,
    );
    let (mine, theirs) = (imported(u.source()), typed(u.source()));
    close(&[functional(&mesh, &mine)], &[functional(&mesh, &theirs)], 1e-14);
}
