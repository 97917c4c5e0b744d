//! Odd but legal modules compile, and mean what they say.

use forms_core::forms;
use toy_backend::contract::*;
use toy_backend::mesh::Mesh;
use toy_backend::random::Random;
use toy_backend::{expression, functional, residual};

#[forms(crate = toy_backend, matrix_free)]
pub mod empty {}

#[forms(crate = toy_backend, matrix_free)]
pub mod only_data {
    pub struct Data {}
}

#[forms(crate = toy_backend, matrix_free, dimension = 3)]
mod one_dimension {

    pub struct Constants {
        /// With a doc comment.
        r#type: Param<Tensor>,
    }
    #[cells]
    pub struct Volume;
    #[facets]
    pub struct NeverUsed;

    /// The third component exists here.
    pub fn third(u: Vector) -> Scalar {
        u[D - 1] * u[1..D][1] / u[2] + r#type[2][2 * D - 4]
    }
    pub fn no_arguments() -> Scalar {
        tr(r#type)
    }
    pub fn volume() -> Functional {
        integral(Volume, 1)
    }
}

#[forms(crate = toy_backend, matrix_free)]
pub mod names {
    pub struct Data {
        form: Param,
        parameters: Param,
        cell: Given<Scalar>,
    }
    #[cells]
    pub struct Form;
    #[facets]
    pub struct Lane;

    /// Names that the emitted code uses for its own purposes.
    pub fn point(
        data: State<Scalar>,
        inputs: State<Scalar>,
        form_region: State<Scalar>,
        fields: Unknown<Scalar>,
        geometry: Test<Scalar>,
    ) -> Form {
        let t0 = data * inputs;
        let basis = t0 * form_region;
        integral(Form, form * parameters * cell * basis * fields * geometry)
    }
}

#[forms(crate = toy_backend, matrix_free)]
pub mod numbers {
    #[cells]
    pub struct Omega;

    /// D − 2 is zero in 2D; a literal zero would be reported at once.
    pub fn divided_by_zero(s: Scalar) -> Scalar {
        s / (D - 2)
    }
    pub fn zero_by_zero(s: Scalar) -> Scalar {
        (D - 2) / (D - 2) + s
    }
    pub fn infinite_constant() -> Scalar {
        1 / (D - 2)
    }
    pub fn root_of_minus_one() -> Scalar {
        sqrt(-1)
    }
    pub fn not_taken(s: Scalar) -> Scalar {
        if s > 0 { s / (D - 2) } else { ln(-1) + s / (D - 2) }
    }
    pub fn decided(s: Scalar) -> Scalar {
        if 1 > 2 { s / (D - 2) } else { s }
    }
    pub fn notations() -> Scalar {
        0x10 + 1_000 + 1e3 + 1.5 + 2. + 3f64
    }
    /// Exponents that no integer holds.
    pub fn towers(s: Scalar) -> Scalar {
        let a = pow(pow(pow(s, 16), 16), 16);
        let b = pow(pow(pow(pow(pow(a, 16), 16), 16), 16), 16);
        1 / (1 + pow(b, 16)) - 1 + pow(s, 0) + pow(a, 1 / 4096) + pow(pow(-2 * s, 3), 3)
    }
    pub fn nested(s: Scalar) -> Scalar {
        (-(-(-(-(-(-(-(-(-(-(-(-(s)))))))))))))
    }
    pub fn blocks(s: Scalar) -> Scalar {
        {
            let s = { s + 1 };
            let s = { s + 1 };
            { { s } }
        }
    }
    pub fn square_in_the_end(u: Unknown<Scalar>, v: Test<Scalar>) -> Form {
        let energy = u * u;
        0.5 * integral(Omega, derivative(energy, u, v)) * 2 / 1
    }
}

/// Functions under names of the prelude, of primitive types, of crates, of attributes and of the emitted code.
macro_rules! functions_named {
    ($($name:ident)*) => {
        #[forms(crate = toy_backend, matrix_free, dimension = 2)]
        pub mod functions_named {
            pub struct Data {
                pub k: Param,
                pub g: Given<Scalar>,
                pub law: Table,
            }
            #[cells]
            pub struct Omega;
            $(pub fn $name(u: Unknown<Scalar>, w: State<Scalar>) -> Energy {
                integral(Omega, law(k) * g * w * u * u)
            })*
        }
    };
}
functions_named! {
    Some None Ok Err Box Vec String Into Result Option Sized Copy Clone Debug Default ToString usize f64 bool str u8
    core std forms_core Form Lane derive doc allow vec stringify Region Source inputs kernels_2 main drop
}

/// Regions under such names.
macro_rules! regions_named {
    ($($name:ident)*) => {
        #[forms(crate = toy_backend, matrix_free, dimension = 2)]
        pub mod regions_named {
            pub struct Data {
                pub k: Param,
                pub g: Given<Scalar>,
            }
            $(#[cells]
            pub struct $name;)*
            pub fn everywhere(u: Unknown<Scalar>, w: State<Scalar>) -> Energy {
                $(integral($name, k * g * w * u * u) +)* integral(Ok, u)
            }
        }
    };
}
regions_named! {
    Some None Ok Err Box Vec String Into Result Option Sized Copy Clone Debug usize f64 bool str core std forms_core
    Lane derive vec Region GammaC gamma_c
}

/// Data structs under such names.
macro_rules! data_named {
    ($($module:ident $name:ident)*) => {
        $(#[forms(crate = toy_backend, matrix_free, dimension = 2)]
        pub mod $module {
            pub struct $name {
                pub u8: Param,
                pub r#move: Given<Vector>,
                pub bool: Table,
                pub f64: Carried<Scalar>,
            }
            #[cells]
            pub struct Omega;
            extern "Rust" {
                #[at(crate::same)]
                fn external(s: Scalar) -> Scalar;
            }
            pub fn energy(u: Unknown<Scalar>, None: State<Scalar>, Ok: State<Scalar>, r#type: State<Scalar>) -> Energy {
                integral(Omega, bool(u8) * r#move[0] * f64 * u * u * None * Ok * r#type * external(u))
            }
            pub fn external_external_2() -> Scalar {
                u8
            }
        })*
    };
}
data_named! { data_into Into data_some Some data_usize usize data_clone Clone data_debug Debug data_core core data_form Form }

fn same<R: Real>(s: R) -> R {
    s
}

/// Attributes and modifiers that Rust allows before and inside of declarations.
#[forms(crate = toy_backend, matrix_free, dimension = 2)]
pub mod attributes {
    //! Documentation from inside, with "quotes", \ and #![brackets].
    #![allow(unused)]

    /// Odd text: `"`, \, {}, `*/`, `#[cfg(any())]`.
    #[derive(PartialEq, Clone)]
    pub struct Data {
        #[doc = "\"\n"]
        #[allow(dead_code)]
        pub k: Param,
    }
    #[doc(hidden)]
    #[cells]
    #[derive(Debug, PartialEq, Eq)]
    #[allow(dead_code)]
    pub struct Omega;

    #[must_use]
    #[rustfmt::skip]
    pub fn shifted(#[allow(unused)] u: State<Scalar>) -> Scalar {
        #![allow(unused)]
        #![doc = "From inside."]
        #[allow(unused)]
        let a = { #![allow(unused)] u };
        #[rustfmt::skip]
        (a + r#u + k)
    }
    pub(crate) fn raw(u: State<Scalar>) -> Scalar {
        let r#w = r#u;
        r#sqrt(w * r#w)
    }
}

/// A value at s = `at`.
macro_rules! at {
    ($name:ident $(, $at:expr)?) => {{
        let mesh = Mesh::<2>::cube(&mut Random(1));
        let form: Expression<2> = numbers::$name($(Source::<2>::Constant(vec![$at]))?);
        expression(&mesh, &form, (Entity::Cells, "all"))[0][0]
    }};
}

#[test]
fn division_by_zero_shows_at_run_time_and_only_where_it_is_taken() {
    assert!(at!(divided_by_zero, 1.0).is_infinite());
    assert!(at!(zero_by_zero, 1.0).is_nan());
    assert!(at!(infinite_constant).is_infinite());
    assert!(at!(root_of_minus_one).is_nan());
    assert!(at!(not_taken, 1.0).is_infinite());
    assert!(at!(not_taken, -1.0).is_nan());
    assert_eq!(at!(decided, 3.0), 3.0);
}

#[test]
fn numbers_and_nesting() {
    assert_eq!(at!(notations), 16.0 + 1000.0 + 1000.0 + 1.5 + 2.0 + 3.0);
    // s^4096 to the power 1/4096 is |s|.
    assert!((at!(towers, 0.9) - (1.0 + 0.9 - 512.0 * 0.9_f64.powi(9))).abs() < 1e-12);
    assert_eq!(at!(nested, 0.25), 0.25);
    assert_eq!(at!(blocks, 0.25), 2.25);
    let mesh = Mesh::<2>::cube(&mut Random(2));
    let u = Random(3).field(4, 1, 0.0, 1.0);
    let form = numbers::square_in_the_end::<2>(&numbers::Omega::on("all"));
    let sum: f64 = residual::<f64, 2>(&mesh, &form, std::slice::from_ref(&u)).iter().sum();
    // ∫ 2u, exact by the mean of the nodal values.
    let cells = mesh.elements(Entity::Cells, "all");
    let mean = |cell: &&toy_backend::mesh::Element<2>| {
        cell.nodes.iter().map(|node| u.values[*node]).sum::<f64>() / 3.0 * cell.cell.cell_volume
    };
    assert!((sum - 2.0 * cells.iter().map(mean).sum::<f64>()).abs() < 1e-14);
}

#[test]
fn one_dimension_only() {
    let data = one_dimension::Constants::<3> { r#type: [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]] };
    let mesh = Mesh::<3>::cube(&mut Random(4));
    let third = one_dimension::third(&data, Source::Constant(vec![1.0, 2.0, 4.0]));
    assert_eq!(expression(&mesh, &third, (Entity::Cells, "all"))[0], [7.0]);
    let trace = one_dimension::no_arguments(&data);
    assert_eq!(expression(&mesh, &trace, (Entity::Cells, "all"))[0], [6.0]);
    let volume = one_dimension::volume(&data, &one_dimension::Volume::on("all"));
    assert!(functional(&mesh, &volume) > 0.0);
    let _ = (only_data::data::<2>(), one_dimension::NeverUsed::on("nowhere"));
}

#[test]
fn arguments_may_have_names_of_the_emitted_code() {
    let mesh = Mesh::<2>::cube(&mut Random(5));
    let data = names::data().form(2.0).parameters(3.0).cell(5.0);
    let [a, b, c] = [7.0, 11.0, 13.0].map(|value| Source::Constant(vec![value]));
    let form = names::point::<2>(&data, &names::Form::on("all"), a, b, c);
    let fields: Vec<_> = form.fields().iter().map(|field| field.name).collect();
    // The last one is the direction in which the unknown `fields` varies.
    assert_eq!(fields, ["data", "inputs", "form_region", "fields", "geometry", "cell", "dfields"]);
    let one = toy_backend::Nodal { components: 1, values: vec![1.0; 4] };
    let sum: f64 = residual::<f64, 2>(&mesh, &form, &[one]).iter().sum();
    let volume: f64 = mesh.elements(Entity::Cells, "all").iter().map(|cell| cell.cell.cell_volume).sum();
    assert!((sum - 30030.0 * volume).abs() < 1e-9, "{sum}");
}

#[test]
fn names_of_the_prelude_and_of_primitive_types_are_names_like_others() {
    let constant = |value: f64| Source::Constant(vec![value]);
    let law = || Table::linear(&[[0.0, 0.0], [10.0, 10.0]]).expect("a table");
    let data = functions_named::data().k(2.0).g(3.0).law(law());
    let form = functions_named::Some::<2>(&data, &functions_named::Omega::on("all"), constant(5.0));
    let mesh = Mesh::<2>::cube(&mut Random(6));
    let volume: f64 = mesh.elements(Entity::Cells, "all").iter().map(|cell| cell.cell.cell_volume).sum();
    let one = toy_backend::Nodal { components: 1, values: vec![1.0; 4] };
    let energy = toy_backend::energy(&mesh, &form, std::slice::from_ref(&one));
    assert!((energy - 30.0 * volume).abs() < 1e-12, "{energy}");

    let data = data_into::data().u8(2.0).r#move([3.0, 0.0]).bool(law()).f64(0.5);
    let form = data_into::energy::<2>(
        &data,
        &data_into::Omega::on("all"),
        constant(5.0),
        constant(7.0),
        constant(11.0),
    );
    let names: Vec<_> = form.fields().iter().map(|field| field.name).collect();
    assert_eq!(&names[..4], ["u", "None", "Ok", "r#type"]);
    assert!(attributes::data().k(1.0) == attributes::data::<2>().k(1.0).clone());
    assert!(format!("{:?}", attributes::Omega::on("all")).starts_with("Omega(Region"));
}

/// Zeros next to what is linear in the test function, and whole numbers of D.
#[forms(crate = toy_backend, matrix_free, dimension = 2)]
pub mod zeros {
    pub struct Data {
        pub lambda: Param,
        pub mu: Param,
    }
    #[cells]
    pub struct Omega;
    #[facets]
    pub struct Gamma;

    /// The strain of plane strain, as a tensor in space.
    fn solid_strain(w: Vector) -> Matrix<3, 3> {
        let e = eps(w);
        [[e[0][0], e[0][1], 0], [e[1][0], e[1][1], 0], [0, 0, 0]]
    }
    fn solid_stress(w: Vector) -> Matrix<3, 3> {
        2 * mu * solid_strain(w) + lambda * tr(solid_strain(w)) * identity(D + 1)
    }
    pub fn embedded(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, inner(solid_stress(u), solid_strain(v)))
    }
    pub fn plane(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, 2 * mu * inner(eps(u), eps(v)) + lambda * div(u) * div(v))
    }
    pub fn branches(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        let w = if u[0] > 2 { [0; D] } else { v };
        let rows = [[v[D - 1], 0], [0 * u[0], -0 * dot(u, u)]];
        integral(Omega, dot(u, w) + tr(rows - 0 * outer([u[0], 1], [1, 1])))
            - integral(Gamma, 0 * u[0] + dot(v, [0; 2 * D / 2]))
    }
    pub fn by_hand(u: Unknown<Vector>, v: Test<Vector>) -> Form {
        integral(Omega, dot(u, v) + v[1])
    }
    pub fn nothing_on_the_facets(u: State<Vector>) -> Functional {
        integral(Omega, u[D - 1]) + integral(Gamma, u[0] - u[0])
    }
}

#[test]
fn zeros_are_linear_in_the_test_function() {
    let mesh = Mesh::<2>::cube(&mut Random(7));
    let u = [Random(8).field(4, 2, 0.0, 1.0)];
    let (data, omega) = (zeros::data().lambda(1.3).mu(0.7), zeros::Omega::on("all"));
    let gamma = zeros::Gamma::on("boundary");
    let same = |first: Vec<f64>, second: Vec<f64>| {
        assert!(first.iter().any(|entry| entry.abs() > 1e-3));
        for (a, b) in first.iter().zip(&second) {
            assert!((a - b).abs() < 1e-14, "{a} and {b}");
        }
    };
    let embedded = residual::<f64, 2>(&mesh, &zeros::embedded(&data, &omega), &u);
    same(embedded, residual::<f64, 2>(&mesh, &zeros::plane(&data, &omega), &u));
    let branches = residual::<f64, 2>(&mesh, &zeros::branches(&data, &omega, &gamma), &u);
    same(branches, residual::<f64, 2>(&mesh, &zeros::by_hand(&data, &omega), &u));
    // Nothing is left on the facets; the constructor asks for what the text names.
    let last = zeros::nothing_on_the_facets(&data, &omega, &gamma, Source::Constant(vec![3.0, 5.0]));
    let volume: f64 = mesh.elements(Entity::Cells, "all").iter().map(|cell| cell.cell.cell_volume).sum();
    assert!((functional(&mesh, &last) - 5.0 * volume).abs() < 1e-14);
}
