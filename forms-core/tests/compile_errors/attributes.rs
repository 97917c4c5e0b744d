//! Attributes that would change what is emitted, and what Rust has before and in declarations that forms have not.

use forms_core::forms;

#[forms(crate = forms_core)]
pub mod attributes {
    #[cfg(test)]
    pub struct Data {
        #[cfg_attr(test, cfg(test))]
        pub k: Param,
    }
    #[cfg(test)]
    #[cells]
    pub struct Omega;
    #[facets(2)]
    pub struct Gamma;

    #[cfg(test)]
    pub fn conditional(u: State<Scalar>) -> Scalar {
        u
    }
    pub fn inside(#[cfg(test)] u: State<Scalar>) -> Scalar {
        #[cfg(test)]
        let a = u;
        #[inline]
        (a + { #![recursion_limit = "9"] u })
    }
    pub fn conditions(u: State<Scalar>) -> Scalar
    where
        f64: Copy,
    {
        u
    }
    pub extern "C" fn foreign(u: State<Scalar>) -> Scalar {
        u
    }
    pub fn patterns(mut u: Scalar, ref w: Scalar, z @ y: Scalar) -> Scalar {
        u
    }
    pub fn references(u: Scalar) -> Scalar {
        let ref a = u;
        a
    }
    pub fn region(Omega: State<Scalar>) -> Scalar {
        Omega
    }
    pub fn __external(u: State<Scalar>) -> Scalar {
        u
    }
    extern "Rust" {
        #[cfg(test)]
        #[at(crate::a)]
        #[at(crate::b)]
        fn law(u: Scalar) -> Scalar;
    }
    #[cfg(test)]
    use forms_core::dot;
}

#[forms(crate = forms_core)]
unsafe mod not_unsafe {
    #[cells]
    pub struct Data {
        pub k: Param,
    }
}

fn main() {}
