//! Functions that are generic over the dimension and the lane type alone, compiled in a library and not in every program: as
//! in `forms_mesh::instantiate`, with the lane types that this build has.

#[cfg(not(test))]
use crate::dimension::{Dim, Dimension};
#[cfg(not(test))]
use crate::lanes::SimdLane;

/// Enters generic functions of the dimension `D`, with `in lanes` also of a type of lane `L`, under a name in [`Compiled`]; `of forms`
/// where they assemble forms, whose kernels want `Dim: Dimension<D>`.
macro_rules! instantiate {
    ($name:ident in lanes: $($function:expr),+ $(,)?) => {
        #[cfg(not(test))]
        impl<const D: usize> crate::instantiate::Compiled<D> {
            pub(crate) fn $name<L: crate::lanes::SimdLane>() -> Vec<*const ()> {
                vec![$($function as *const ()),+]
            }
        }
    };
    ($name:ident of forms: $($function:expr),+ $(,)?) => {
        #[cfg(not(test))]
        impl<const D: usize> crate::instantiate::Compiled<D>
        where
            crate::dimension::Dim: crate::dimension::Dimension<D>,
        {
            pub(crate) fn $name() -> Vec<*const ()> {
                vec![$($function as *const ()),+]
            }
        }
    };
    ($($functions:tt)+) => {
        forms_mesh::instantiate!($($functions)+);
    };
}
pub(crate) use instantiate;

/// The functions of this crate that are compiled once for the dimension D.
pub struct Compiled<const D: usize>;

#[cfg(not(test))]
impl<const D: usize> Compiled<D>
where
    Dim: Dimension<D>,
{
    /// All of them, file by file.
    pub fn all() -> Vec<Vec<*const ()>> {
        let mut all = vec![
            Self::assemble_projection(),
            Self::binding(),
            Self::block_pattern(),
            Self::bounds(),
            Self::constraints(),
            Self::continuation(),
            Self::cut(),
            Self::cut_band(),
            Self::cut_body(),
            Self::cut_derivative(),
            Self::cut_groups(),
            Self::cut_holding(),
            Self::cut_interface(),
            Self::cut_parts(),
            Self::derived(),
            Self::eigenproblem(),
            Self::elimination(),
            Self::entities(),
            Self::facet_groups(),
            Self::field(),
            Self::file(),
            Self::free_bodies(),
            Self::functional(),
            Self::functions_on_pairs(),
            Self::group_nodes(),
            Self::hanging_nodes(),
            Self::history(),
            Self::interpolation(),
            Self::known(),
            Self::linear_problems(),
            Self::norms(),
            Self::of_assembler(),
            Self::own_points(),
            Self::owned_cells(),
            Self::pair_groups(),
            Self::pair_histories(),
            Self::pair_reports(),
            Self::pair_search(),
            Self::residual(),
            Self::reference_tensor(),
            Self::rigid_body(),
            Self::rigid_loads(),
            Self::rigid_map(),
            Self::segment_tangent(),
            Self::solved(),
            Self::space(),
            Self::sums(),
            Self::tangent(),
            Self::touched(),
            Self::transfer_projection(),
            Self::solution(),
            Self::vtu(),
            Self::groups(),
            Self::walk_degrees(),
        ];
        all.extend(Self::in_lanes::<f64>());
        #[cfg(all(target_arch = "x86_64", not(without_avx2)))]
        all.extend(Self::in_lanes::<crate::lanes::Avx2>());
        #[cfg(all(target_arch = "x86_64", not(without_avx512)))]
        all.extend(Self::in_lanes::<crate::lanes::Avx512>());
        #[cfg(target_arch = "aarch64")]
        all.extend(Self::in_lanes::<crate::lanes::Neon>());
        all
    }

    fn in_lanes<L: SimdLane>() -> Vec<Vec<*const ()>> {
        vec![
            Self::buffers::<L>(),
            Self::checks::<L>(),
            Self::element_matrices::<L>(),
            Self::element_vectors::<L>(),
            Self::matrices::<L>(),
            Self::moving_points::<L>(),
        ]
    }
}

#[cfg(not(test))]
#[expect(dead_code, reason = "it is there for the instances that it names")]
static IN_THE_PLANE: fn() -> Vec<Vec<*const ()>> = Compiled::<2>::all;
