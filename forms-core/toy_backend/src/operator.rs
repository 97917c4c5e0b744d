//! Tests of one operator of the language: its value against plain numbers, a form that holds it against differences.

/// A module with an operator's value and a form that holds it, and the test of both in the plane and in space. The file has a
/// `State` of a vector u and a scalar s, which checks values.
#[macro_export]
macro_rules! operator_module {
    (
        $name:ident: $rank:ident tested by $test:ident,
        on #[$entity:ident] $region:ident $place:literal, seeds $plane:literal $space:literal,
        data { $($member:tt)* } = { $($given:tt)* },
        value { $($body:tt)* } density { $($density:tt)* } expected $expected:expr
    ) => {
        mod $name {
            use super::*;
            #[forms(crate = toy_backend, matrix_free)]
            pub mod operator {
                pub struct Data { $($member)* }
                #[$entity]
                pub struct $region;
                pub fn value(u: Vector, s: Scalar) -> $rank { $($body)* }
                pub fn form(u: Unknown<Vector>, s: Unknown<Scalar>, v: Test<$test>) -> Form {
                    integral($region, $($density)*)
                }
            }
            fn check<const D: usize>(seed: u64)
            where
                forms_core::contract::Dim: forms_core::contract::Dimension<D>,
            {
                let mut state = State::<D>::new(seed);
                let data = operator::Data { $($given)* };
                let [u, s] = &state.unknowns;
                let value = operator::value(&data, u.source(), s.source());
                state.check_value(&value, $expected);
                let form = operator::form(&data, &operator::$region::on($place));
                differences::check_tangent(&state.mesh, &form, &state.unknowns, &mut state.random);
            }
            #[test]
            fn in_2d() {
                check::<2>($plane);
            }
            #[test]
            fn in_3d() {
                check::<3>($space);
            }
        }
    };
}
