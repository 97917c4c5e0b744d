//! A forms module bound once: regions by name, data, and a method per function.

use forms_core::contract::{Dim, Dimension, Form, Given};
use forms_core::forms;

#[forms(crate = forms_core)]
pub mod contact {
    pub struct Data {
        pub mu: Param,
        pub gap: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct GammaC;
    #[facets]
    pub struct GammaN;
    #[interior_facets]
    pub struct Skeleton;

    fn pressure(w: Scalar) -> Scalar {
        neg_part(gap - w)
    }
    pub fn direct(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        integral(Omega, mu * dot(grad(u), grad(v))) - integral(GammaC, pressure(u) * v)
            + integral(Skeleton, jump(u) * jump(v))
    }
    /// ∫ p
    pub fn force(u: State<Scalar>) -> Functional {
        integral(GammaC, pressure(u))
    }
    /// The integral over Γ_N is nothing; its region is asked for all the same.
    pub fn work(u: State<Scalar>) -> Functional {
        integral(GammaC, u) + 0 * integral(GammaN, u)
    }
}

#[forms(crate = forms_core)]
pub mod two_materials {
    #[cells]
    pub struct Steel;
    #[cells]
    pub struct Type;
    #[facets]
    pub struct Default_;

    pub fn content(u: State<Scalar>) -> Functional {
        integral(Steel, u) + 2 * integral(Type, u) + integral(Default_, u)
    }
}

fn model<const D: usize>() -> contact::Model<D> {
    contact::Model::new(contact::data().mu(2.0).gap(0.5))
}

fn names<const D: usize>(form: &Form<D>) -> Vec<(&'static str, String)> {
    form.inputs().regions.iter().map(|region| (region.symbol, region.name.clone())).collect()
}

/// Cells and interior facets have the mesh's names where there is one of them, facets their own.
#[test]
fn regions_have_names_of_their_own() {
    fn check<const D: usize>()
    where
        Dim: Dimension<D>,
    {
        let form = model::<D>().direct();
        let expected = [("Omega", "all"), ("GammaC", "gamma_c"), ("Skeleton", "interior")];
        assert_eq!(names(&form), expected.map(|(symbol, name)| (symbol, name.to_owned())));
    }
    check::<2>();
    check::<3>();
    let regions = two_materials::Regions::default();
    assert_eq!(
        [&regions.steel.0.name, &regions.r#type.0.name, &regions.default_.0.name],
        ["steel", "type", "default_"]
    );
}

/// Other names are given by name: no place in a list of arguments depends on what is integrated.
#[test]
fn regions_are_bound_by_name() {
    let regions = contact::Regions::default().gamma_n("top").gamma_c("bottom");
    let model = contact::Model { regions, ..model::<3>() };
    assert_eq!(names(&model.direct())[1], ("GammaC", "bottom".to_owned()));
    let work = model.work(Given::<f64, 3>::constant(1.0).source().clone());
    let regions: Vec<_> =
        work.inputs().regions.iter().map(|region| (region.symbol, &region.name[..])).collect();
    assert_eq!(regions.len(), 2, "the text names both");
    assert!(regions.contains(&("GammaC", "bottom")) && regions.contains(&("GammaN", "top")));
}

/// A method gives what the module's function gives.
#[test]
fn methods_are_the_functions() {
    let model = model::<2>();
    let u = contact::data::<2>().mu(0.0).gap(3.0).gap.source().clone();
    let one = model.force(u.clone());
    let other = contact::force(&model.data, &contact::GammaC::on("gamma_c"), u);
    assert_eq!(one.formula(), other.formula());
    assert_eq!(one.inputs().parameters, other.inputs().parameters);
    assert_eq!(one.inputs().regions, other.inputs().regions);
    let content = two_materials::Model::default().content(model.data.gap.source().clone());
    assert_eq!(content.inputs().regions.len(), 3);
}
