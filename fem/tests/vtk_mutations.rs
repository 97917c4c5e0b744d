//! Of mutated VTK files none makes the reader panic or think long, and every mesh that it accepts is valid.

use forms_fem::mesh::VtkReader;

use crate::gmsh::path;
use crate::gmsh_mutations::check_valid;
use crate::gmsh_mutations::mutate::{accepted, count};

/// With `FORMS_SWEEPS=1`; a tenth as a rule, and as many as `FORMS_MUTATIONS` says where it is set.
const MUTATIONS: u64 = 20_000;

// What VTK and meshio wrote.
fn corpus() -> Vec<Vec<u8>> {
    let mut files: Vec<_> = std::fs::read_dir(path(""))
        .expect("the folder is there")
        .map(|entry| entry.expect("it can be read").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "vtu" || extension == "vtk"))
        .collect();
    files.sort();
    assert!(files.len() >= 15);
    files.iter().map(|path| std::fs::read(path).expect("it can be read")).collect()
}

// Whether the reader takes the file as a mesh in D dimensions.
fn survives<const D: usize>(bytes: &[u8]) -> bool {
    match VtkReader::new().join_points().from_bytes::<D>("mutated", bytes) {
        Ok(read) => {
            check_valid(&read.mesh);
            assert!(read.notes.iter().all(|note| !note.to_string().is_empty()));
            for (arrays, count) in
                [(&read.point_data, read.mesh.node_count()), (&read.cell_data, read.mesh.cell_count())]
            {
                assert!(arrays.iter().all(|array| array.values.len() == array.components * count));
            }
            true
        }
        Err(error) => {
            assert!(error.to_string().starts_with("mutated: "), "{error}");
            false
        }
    }
}

#[test]
fn mutated_files_are_read_or_refused() {
    let corpus = corpus();
    for file in &corpus {
        assert!(survives::<2>(file) != survives::<3>(file), "the files of the corpus are good");
    }
    let count = count(MUTATIONS);
    let accepted = accepted(&corpus, count, |file| survives::<2>(file) | survives::<3>(file));
    // Some changes harm nothing, such as those of names, ranges and data, and others do.
    assert!(accepted > count / 100 && accepted < count * 3 / 4);
}
