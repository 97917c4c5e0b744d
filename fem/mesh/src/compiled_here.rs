//! Functions that are generic over the dimension alone, compiled in this crate and not in every program.
//!
//! A generic function is compiled where it is called: in each program anew, and after each edit. One that is marked
//! `#[inline(never)]` is not, where the library that declares it holds the instance that is called: programs link it, at
//! every level of optimisation. `compiled_here!` stands below such functions and makes their instances for two and for
//! three dimensions. What they call is compiled with them.

/// Compiles generic functions of the dimension `D` for two and three dimensions, in the crate that declares them.
#[doc(hidden)]
#[macro_export]
macro_rules! compiled_here {
    ($($function:expr),+ $(,)?) => {
        #[cfg(not(test))]
        const _: () = {
            fn instances<const D: usize>() -> Vec<*const ()> {
                vec![$($function as *const ()),+]
            }
            #[expect(dead_code, reason = "it is there for the instances that it names")]
            static INSTANCES: [fn() -> Vec<*const ()>; 2] = [instances::<2>, instances::<3>];
        };
    };
}
