//! Whole-system tests in one binary: kernels that several files use are compiled once.

mod against_scikit_fem_anisotropic_elasticity;
mod against_scikit_fem_elasticity;
mod against_scikit_fem_ghost_penalty;
mod against_scikit_fem_interior_penalty;
mod against_scikit_fem_mooney_rivlin;
mod against_scikit_fem_neo_hookean;
mod against_scikit_fem_nitsche;
mod against_scikit_fem_p_laplacian;
mod against_scikit_fem_poisson;
mod against_scikit_fem_stokes;
#[cfg(target_os = "linux")]
mod calls_of_an_entry;
mod closed_forms;
mod convergence;
mod cylinder_against_getfem;
mod exact_adjoint_transition;
mod exact_block_patch;
mod exact_hertz_line;
mod exact_hertz_sphere;
mod exact_scalar_signorini;
mod exact_signorini_transition;
mod exact_smooth_adjoint;
mod form_boundary_derivative;
mod form_consistent_adjoint;
mod form_criterion;
mod form_derived_fields;
mod form_direct;
mod form_discrete_adjoint;
mod form_elasticity;
mod form_extended_adjoint;
mod form_lengths;
mod frictional_block_against_getfem;
mod frictional_cylinder_against_getfem;
mod gamma0_sweep;
mod half_plane;
mod identities;
mod imported_operators;
mod loaded_adjoint;
mod operators_page;
#[rustfmt::skip]
mod page_code;
mod related_adjoint;
mod separate_crate;
mod shape_gradient;
mod solver_orderings;
mod solver_paths;
mod split_contact_in_space;
mod threshold;
mod unit_scaling;

#[test]
fn every_file_is_part_of_this_binary() {
    let listed = include_str!("main.rs");
    for entry in
        std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/tests")).expect("the folder is there")
    {
        let path = entry.expect("it can be read").path();
        let is_module =
            path.extension().is_some_and(|extension| extension == "rs") || path.join("mod.rs").exists();
        let name = path.file_stem().expect("it has a name").to_string_lossy().into_owned();
        if is_module && name != "main" {
            assert!(listed.contains(&format!("mod {name};")), "tests/{name} is not listed in tests/main.rs");
        }
    }
}
