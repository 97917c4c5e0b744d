//! Functions that are generic over the dimension alone, compiled in a library and not in every program.
//!
//! A generic function is compiled where it is called: in each program again, and after each edit. One that is marked
//! `#[inline(never)]` is not, where a library that the program links holds the instance that is called, at every level of
//! optimisation. `instantiate!` follows such functions and enters them, under a name of their file, in
//! [`Compiled`], whose list makes the instances. Those in the plane are in the crate that declares the functions, those in space
//! in `forms-fem`, since the paper's experiment needs none of them. What the functions call is compiled with them. A function that knows
//! its dimension, as [`cuboid`](crate::mesh::cuboid) does, is marked `#[inline]`: otherwise it is compiled where it is defined, with all that it calls in space.

/// Enters generic functions of the dimension `D` under a name in the crate's `instantiate::Compiled`.
#[doc(hidden)]
#[macro_export]
#[expect(clippy::crate_in_macro_def, reason = "functions enter the list of their own crate")]
macro_rules! instantiate {
    ($name:ident: $($function:expr),+ $(,)?) => {
        #[cfg(not(test))]
        impl<const D: usize> crate::instantiate::Compiled<D> {
            pub(crate) fn $name() -> Vec<*const ()> {
                vec![$($function as *const ()),+]
            }
        }
    };
}

/// The functions of this crate that are compiled once for the dimension D.
#[doc(hidden)]
pub struct Compiled<const D: usize>;

#[cfg(not(test))]
impl<const D: usize> Compiled<D> {
    /// All of them, file by file.
    pub fn all() -> Vec<Vec<*const ()>> {
        vec![
            Self::adaptive_mesh(),
            Self::bisection(),
            Self::bisection_coarsening(),
            Self::bodies(),
            Self::checksum(),
            Self::conformity(),
            Self::hanging_facets(),
            Self::interior(),
            Self::locate(),
            Self::mesh(),
            Self::moved(),
            Self::octree(),
            Self::octree_coarsening(),
            Self::part(),
            Self::quality(),
            Self::refine(),
            Self::regions(),
            Self::rigid_surface(),
            Self::simplices(),
            Self::structured(),
        ]
    }
}

#[cfg(not(test))]
#[expect(dead_code, reason = "it is there for the instances that it names")]
static IN_THE_PLANE: fn() -> Vec<Vec<*const ()>> = Compiled::<2>::all;
