//! The backend's tests in one binary: what they share is compiled once.

mod action;
mod adaptivity;
mod assembly;
mod bad_input;
mod cell_means;
mod cell_values;
mod coupled_histories;
mod coupled_motions;
mod coupled_steps;
mod diameter_kinks;
mod eigenproblems;
mod facet_means;
mod facet_vertices;
mod field_files;
mod fixed_sizes;
mod floating_bodies;
mod friction;
mod gmsh;
mod gmsh_errors;
mod gmsh_mutations;
mod hanging_nodes;
mod high_degrees;
mod history;
mod interior_facets;
mod inverse;
mod inverse_maps;
mod inverse_schemes;
mod kept_candidates;
mod language_names;
mod linear_problems;
mod measures;
mod mixed;
mod moving_asymptotes;
mod multipliers;
mod newton_criterion;
mod octree;
mod only_what_changes;
mod owned_cells;
mod pairs;
mod positive_parts;
mod reactions;
mod redistributed_mass;
mod related_unknowns;
mod rigid_surfaces;
mod rotated_relations;
mod second_derivatives;
mod second_order;
mod second_order_motions;
mod several_shapes;
mod shape_derivatives;
mod sliding_linear_bodies;
mod sliding_pairs;
mod split_facets;
mod sum_factorisation;
mod sums;
mod swinging_body;
mod threads;
mod time_events;
mod time_runs;
mod time_schemes;
mod time_waves;
mod transfer;
mod tunnelling;
mod unoptimised;
mod vtk;
mod vtk_errors;
mod vtk_mutations;

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
