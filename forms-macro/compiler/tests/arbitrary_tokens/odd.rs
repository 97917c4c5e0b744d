//! Legal Rust that is odd in a forms module: what comes out is Rust all the same.

use super::check_text;

/// Attributes, documentation, generics, visibility and raw names wherever Rust's grammar has a place for them.
const ODD: &[&str] = &[
    "mod m",
    "mod m;",
    "unsafe mod m {}",
    "pub(crate) mod m { #![allow(x)] //! text\n }",
    "mod m { fn f(u: Vector) -> Scalar { #![allow(x)] u[0] } }",
    "mod m { fn f(u: Scalar) -> Scalar { { #![allow(x)] u } } }",
    "mod m { fn f(u: Scalar) -> Scalar { #[allow(x)] let a = u; #[cfg(test)] (#[x] a + #[x = 1] u) } }",
    "mod m { fn f(u: Scalar) -> Scalar { #[y] if #[x] u > 0 { u } else #[x] { 0 } } }",
    "mod m { fn f(#[cfg(test)] u: Scalar) -> #[x] Scalar { u } }",
    "mod m { fn f(u: Scalar) -> Scalar { u } #[cfg(test)] fn f(u: Scalar) -> Scalar { 0 } }",
    "mod m { #[cfg(test)] struct Data { k: Param } fn f() -> Scalar { k } }",
    "mod m { struct Data { #[cfg(test)] k: Param, #[doc = \"\\\"\\n]\"] l: Param } fn f() -> Scalar { k } }",
    "mod m { #[cfg(test)] #[cells] struct Omega; fn f() -> Functional { integral(Omega, 1) } }",
    "mod m { #[cells(3)] struct Omega; fn f() -> Functional { integral(Omega, 1) } }",
    "mod m { #[cells] #[doc] #[doc(hidden)] #[doc = include_str!(\"a\")] struct Omega; }",
    "mod m { #[cells] struct Omega where f64: Copy; struct Data where f64: Copy { k: Param } }",
    "mod m { fn f<>() -> Scalar where f64: Copy { 1 } fn g<const D: usize>() -> Scalar { 1 } }",
    "mod m { extern \"C\" fn f() -> Scalar { 1 } const fn g() -> Scalar { 1 } default fn h() -> Scalar { 1 } }",
    "mod m { pub(super) fn f() -> Scalar { 1 } pub(in crate) struct Data {} pub(self) fn g() -> Scalar { 1 } }",
    "mod m { fn f(mut u: Scalar, ref v: Scalar, w @ z: Scalar) -> Scalar { let ref a = u; a } }",
    "mod m { fn f(r#u: Scalar, r#type: Scalar) -> Scalar { let r#a = u + r#type; a } fn r#fn() -> Scalar { 1 } }",
    "mod m { struct Data { k: Param = 3 } }",
    "mod m { #[extends] struct Data { base: Param } fn f() -> Scalar { k } }",
    "mod m { #[extends(a)] #[extends = 3] struct Data; #[extends(a::b<c>)] fn f() -> Scalar { k } }",
    "mod m { #[includes] struct Data { k: Param } fn f() -> Scalar { k } }",
    "mod m { #[includes(a)] #[includes = 3] struct Data; #[includes(a::b<c>)] fn f() -> Scalar { k } }",
    "mod m { #[first_included] #[first_included(3)] struct Data { #[included(-1)] k: Param, rest: Param } fn f() -> Scalar { k + rest } }",
    "mod m { #[first_included((3 +) k)] struct Data { k: Param } fn f() -> Scalar { k } }",
    "mod m { #[first_included((a::b) k 3)] struct Data { #[included] k: Param, #[included] #[included] k: Table } fn f() -> Scalar { k(k) } }",
    "mod m { #[includes(a::super)] struct Data {} #[includes(::a::b)] struct Data { k: Param } fn f() -> Scalar { k } }",
    "mod m { #[first_included((a::b) k)] struct Data { k: Param, l: Param } struct Rest { l: Param } fn Rest() -> Scalar { l } }",
    "mod m { struct Data { #[default] k: Param, #[default = 3] l: Param, #[default(--1)] m: Param, #[default()] #[default(0)] n: Table } }",
    "mod m { struct Required { #[default(0)] k: Param } fn f() -> Scalar { k } }",
    "mod m { extern \"Rust\" { #![allow(x)] #[cfg(test)] #[at(a::b)] pub fn f(#[x] u: Scalar) -> Scalar; } }",
    "mod m { unsafe extern \"Rust\" { safe fn f(u: Scalar) -> Scalar; } extern { fn g(); } }",
    "mod m { #[cfg(test)] use a::b; #[allow(x)] pub use ::c::{d as e, dot}; }",
    "mod r#mod { fn Some() -> Scalar { 1 } fn r#Some() -> Scalar { 2 } }",
];

#[test]
fn odd_modules_give_rust() {
    for source in ODD {
        check_text(source.parse().expect("tokens"), source);
    }
}
