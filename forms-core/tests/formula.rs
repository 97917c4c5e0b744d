//! A form hands its formula to the program, and to a backend that knows only its value.

use forms_core::contract::{Energy, Expression, Form, Formula};
use forms_core::forms;

#[forms(crate = forms_core)]
pub mod membrane {
    pub struct Data {
        k: Param,
        /// f, the load.
        #[doc(alias = "f")]
        load: Given<Scalar>,
    }
    #[cells]
    pub struct Omega;

    #[doc(alias = "Φ")]
    fn stored(s: Scalar) -> Scalar {
        k / 2 * dot(grad(s), grad(s))
    }
    pub fn ratio() -> Scalar {
        load / k
    }
    pub fn potential(s: Unknown<Scalar>) -> Energy {
        integral(Omega, stored(s) - load * s)
    }
}

#[test]
fn an_energy_is_shown_with_its_variations() {
    let data = membrane::data::<2>().k(1.0).load(1.0);
    let form = membrane::potential(&data, &membrane::Omega::on("all"));
    let text = "\
potential(s) = ∫_Ω (Φ(s) − f s) dx
D potential(s)[δs] = ∫_Ω (DΦ(s)[δs] − f δs) dx
D² potential(s)[δs, Δs] = ∫_Ω D²Φ(s)[δs, Δs] dx
where
  Φ(s) = (k/2) ∇s·∇s
  DΦ(s)[δs] = k ∇δs·∇s
  D²Φ(s)[δs, Δs] = k ∇δs·∇Δs";
    assert_eq!(form.formula().unicode, text);
    assert!(form.formula().latex.contains("\\int_{\\Omega } (\\Phi (s) - f\\, s) \\,\\mathrm{d}x"));
    let (energy, form_of_it): (&Energy<2>, &Form<2>) = (&form, &form);
    let others: [Formula; 3] = [energy.formula(), form_of_it.formula(), membrane::potential::FORMULA];
    assert!(others.iter().all(|formula| *formula == form.formula()));
}

#[test]
fn a_derived_field_is_shown_in_each_dimension() {
    let data = membrane::data::<3>().k(1.0).load(1.0);
    let field: Expression<3> = membrane::ratio(&data);
    assert_eq!(field.formula().unicode, "ratio = f/k");
}
