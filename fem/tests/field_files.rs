//! Fields in files: read back to the last bit, and what does not belong together is reported with its line.

use std::path::Path;

use forms_fem::field::FieldFileError;
use forms_fem::mesh::RegionNames;
use forms_fem::prelude::*;

type Outcome = Result<(), Box<dyn std::error::Error>>;

fn mesh(width: f64) -> Mesh<2> {
    rectangle([0.0; 2], [width, 1.0], [2, 1], CellShape::Triangle, 1).expect("a rectangle")
}

/// Numbers whose last bits count: subnormal, nearly 1, negative zero, the largest.
#[test]
fn every_bit_comes_back() -> Outcome {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("field.txt");
    let mesh = mesh(2.0);
    let awkward = [f64::MIN_POSITIVE / 3.0, 1.0_f64.next_up(), -0.0, f64::MAX, 1.0 / 3.0, -1e-300];
    for space in [
        Space::vector(&mesh, 2)?,
        Space::discontinuous_scalar(&mesh, 0)?,
        Space::tensor(&mesh, 1)?,
        Space::on_facets(&mesh, "top", 1)?,
    ] {
        let values = (0..space.unknowns()).map(|unknown| awkward[unknown % 6]).collect();
        let field = Field::from_values(&space, values)?;
        field.write(&path)?;
        let back = Field::read(&path, &space)?;
        let bits = |field: &Field<2>| field.values().iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&back), bits(&field));
        // Another mesh that is equal will do.
        let equal =
            Space::of(&self::mesh(2.0), space.elements().clone(), space.scope().clone(), space.shape())?;
        assert_eq!(bits(&Field::read(&path, &equal)?), bits(&field));
    }
    Ok(())
}

fn message(path: &Path, space: &Arc<Space<2>>) -> String {
    match Field::read(path, space) {
        Ok(_) => "read".to_owned(),
        Err(error) => error.to_string().replace(&path.display().to_string(), "FILE"),
    }
}

#[test]
fn a_file_of_another_space_is_refused() -> Outcome {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("field.txt");
    let own = mesh(2.0);
    Field::zero(&Space::scalar(&own, 1)?).write(&path)?;
    assert_eq!(message(&path, &Space::scalar(&own, 1)?), "read");
    assert_eq!(
        message(&path, &Space::scalar(&own, 2)?),
        "FILE: line 4 is \"degree 1\"; for this space it is \"degree 2\""
    );
    assert_eq!(
        message(&path, &Space::vector(&own, 1)?),
        "FILE: line 5 is \"shape []\"; for this space it is \"shape [2]\""
    );
    assert_eq!(
        message(&path, &Space::discontinuous_scalar(&own, 1)?),
        "FILE: line 3 is \"family with continuous values\"; for this space it is \"family with discontinuous values\""
    );
    let other = message(&path, &Space::scalar(&mesh(3.0), 1)?);
    assert!(other.starts_with("FILE: line 7 is \"mesh "), "{other}");
    Ok(())
}

/// Each process of several would write its piece over those of the others.
#[test]
fn a_piece_of_a_mesh_has_no_file() -> Outcome {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("field.txt");
    let whole = mesh(2.0);
    let cut = whole.facet_region("right")?.to_vec();
    let piece = whole.into_piece(&cut, RegionNames { cells: &[], facets: &["right".to_owned()] });
    let space = Space::scalar(&piece, 1)?;
    let advice = "a file of a field is not available on a mesh that is divided among processes; take a `PartCheckpoint`";
    let error = Field::zero(&space).write(&path).map_err(|error| error.to_string());
    assert!(error.as_ref().is_err_and(|error| error.starts_with(advice)), "{error:?}");
    assert!(message(&path, &space).starts_with(advice) && !path.exists());
    Ok(())
}

/// No prefix of a file, whatever the place at which it breaks off, is a field.
#[test]
fn mistakes_are_told_with_their_line() -> Outcome {
    let directory = tempfile::tempdir()?;
    let path = directory.path().join("field.txt");
    let space = Space::scalar(&mesh(2.0), 1)?;
    Field::interpolate(&space, |x| x[0] / 3.0 + 1.0)?.write(&path)?;
    let text = std::fs::read_to_string(&path)?;
    for length in 0..text.len() {
        std::fs::write(&path, &text[..length])?;
        let read = Field::read(&path, &space);
        assert!(matches!(read, Err(FieldFileError::BreaksOff { .. })), "{length}: {read:?}");
    }
    for (from, to, wanted) in [
        ("1.0\n", "one\n", "FILE: line 8 is \"one\" instead of 1 numbers"),
        ("1.0\n", "1.0 2.0\n", "FILE: line 8 is \"1.0 2.0\" instead of 1 numbers"),
        ("end\n", "end\n3.0\n", "FILE: line 15 is \"3.0\" instead of the end of the file"),
        ("end\n", "3.0\nend\n", "FILE: line 14 is \"3.0\" instead of \"end\""),
        (
            "forms field 1",
            "forms field 2",
            "FILE: line 1 is \"forms field 2\"; for this space it is \"forms field 1\"",
        ),
    ] {
        std::fs::write(&path, text.replacen(from, to, 1))?;
        assert_eq!(message(&path, &space), wanted);
    }
    std::fs::write(&path, text.replacen("1.0\n", "inf\n", 1))?;
    assert!(message(&path, &space).ends_with("is not finite: inf"), "{}", message(&path, &space));
    Ok(())
}
