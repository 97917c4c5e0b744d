//! `cargo +nightly fuzz run gmsh_files fuzz/corpus/gmsh_files fem/tests/meshes`: any bytes, read as a plane and as a solid
//! mesh. The same reader meets 100,000 mutated files in `fem/tests/gmsh_mutations`, on stable Rust.
#![no_main]

use forms_fem::mesh::Mesh;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = Mesh::<2>::read_gmsh_bytes("fuzz", bytes);
    let _ = Mesh::<3>::read_gmsh_bytes("fuzz", bytes);
});
