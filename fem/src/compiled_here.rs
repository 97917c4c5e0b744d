//! Functions that are generic over the dimension and the lane type alone, compiled in this crate and not in every program: as
//! `forms_mesh::compiled_here!` does for the dimension.

/// Compiles generic functions of the dimension `D` for two and three dimensions; with `lanes`, also for each type of lane `L`.
macro_rules! compiled_here {
    (lanes: $($function:expr),+ $(,)?) => {
        #[cfg(not(test))]
        const _: () = {
            fn instances<L: crate::lanes::SimdLane, const D: usize>() -> Vec<*const ()> {
                vec![$($function as *const ()),+]
            }
            #[expect(dead_code, reason = "it is there for the instances that it names")]
            static INSTANCES: &[fn() -> Vec<*const ()>] = &[
                instances::<f64, 2>,
                instances::<f64, 3>,
                #[cfg(all(target_arch = "x86_64", not(without_avx2)))]
                instances::<crate::lanes::Avx2, 2>,
                #[cfg(all(target_arch = "x86_64", not(without_avx2)))]
                instances::<crate::lanes::Avx2, 3>,
                #[cfg(all(target_arch = "x86_64", not(without_avx512)))]
                instances::<crate::lanes::Avx512, 2>,
                #[cfg(all(target_arch = "x86_64", not(without_avx512)))]
                instances::<crate::lanes::Avx512, 3>,
                #[cfg(target_arch = "aarch64")]
                instances::<crate::lanes::Neon, 2>,
                #[cfg(target_arch = "aarch64")]
                instances::<crate::lanes::Neon, 3>,
            ];
        };
    };
    ($($function:tt)+) => {
        forms_mesh::compiled_here!($($function)+);
    };
}
pub(crate) use compiled_here;
