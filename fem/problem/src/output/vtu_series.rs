//! Steps of a computation as `.vtu` files, with the `.pvd` file that says at which time each of them is: ParaView opens it as one
//! film.

use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};

use super::vtu::{VtuError, VtuFile};
use super::write_whole;

/// A series of `.vtu` files next to one another: `out/ring.pvd` names `ring_0000.vtu`, `ring_0001.vtu` and so on. Of pieces of a mesh
/// ([`VtuFile::on`]) each step is a `.pvtu` file with one `.vtu` file for each process.
///
/// ```
/// use forms_fem::output::{VtuFile, VtuSeries};
/// use forms_fem::prelude::*;
///
/// let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [2, 2], CellShape::Quadrilateral, 1)?;
/// let directory = std::env::temp_dir();
/// let mut series = VtuSeries::new(directory.join("heating.pvd"))?;
/// for time in [0.0, 0.5] {
///     series.write(time, &VtuFile::new(&mesh).cell_data("heat", 1, &[time; 4])?)?;
/// }
/// let listed = std::fs::read_to_string(directory.join("heating.pvd"))?;
/// assert!(listed.contains("<DataSet timestep=\"0.5\" file=\"heating_0001.vtu\"/>"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct VtuSeries {
    path: PathBuf,
    stem: String,
    /// The time of each step, and whether its file is a list of pieces.
    steps: Vec<(f64, bool)>,
}

impl VtuSeries {
    /// A series without steps, listed in this `.pvd` file.
    ///
    /// # Errors
    /// [`VtuError::Series`] for a path that names no file, or not as Unicode.
    pub fn new(path: impl AsRef<Path>) -> Result<Self, VtuError> {
        let path = path.as_ref().to_path_buf();
        let Some(stem) = path.file_stem().and_then(OsStr::to_str) else {
            return Err(VtuError::Series { path });
        };
        Ok(VtuSeries { stem: stem.to_owned(), path, steps: Vec::new() })
    }

    /// The next step, written and listed. After each step the series can be opened.
    ///
    /// # Errors
    /// [`VtuError`] for a time that is not finite, or if a file cannot be written.
    pub fn write<const D: usize>(&mut self, time: f64, file: &VtuFile<'_, D>) -> Result<(), VtuError> {
        let index = self.steps.len();
        if !time.is_finite() {
            return Err(VtuError::NotFinite { name: "time".to_owned(), index, value: time });
        }
        let written = file.write_by_all(&self.path.with_file_name(self.name(index, false)))?;
        self.steps.push((time, written.extension().is_some_and(|extension| extension == "pvtu")));
        let list = self.list();
        file.by_first(|| {
            let written = write_whole(&self.path, |writer| writer.write_all(list.as_bytes()));
            written.map_err(|source| VtuError::Write { source })
        })
    }

    fn name(&self, index: usize, in_pieces: bool) -> String {
        format!("{}_{index:04}.{}", self.stem, if in_pieces { "pvtu" } else { "vtu" })
    }

    fn list(&self) -> String {
        let mut list = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
        );
        for (index, (time, in_pieces)) in self.steps.iter().enumerate() {
            let mut name = self.name(index, *in_pieces);
            for (mark, written) in [("&", "&amp;"), ("<", "&lt;"), ("\"", "&quot;")] {
                name = name.replace(mark, written);
            }
            list.push_str(&format!("<DataSet timestep=\"{time}\" file=\"{name}\"/>\n"));
        }
        list.push_str("</Collection>\n</VTKFile>\n");
        list
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::element::CellShape;
    use crate::mesh::rectangle;

    #[test]
    fn what_names_no_step_is_refused() {
        let error = VtuSeries::new("..").unwrap_err().to_string();
        assert_eq!(error, "\"..\" names no .pvd file");
        let mesh = rectangle([0.0, 0.0], [1.0, 1.0], [1, 1], CellShape::Quadrilateral, 1).unwrap();
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml").join("steps.pvd");
        let mut series = VtuSeries::new(path).unwrap();
        let error = series.write(f64::NAN, &VtuFile::new(&mesh)).unwrap_err().to_string();
        assert_eq!(error, "value 0 of \"time\" is NaN");
        assert!(series.write(0.0, &VtuFile::new(&mesh)).unwrap_err().to_string().contains("steps_0000.vtu"));
    }

    #[test]
    fn names_are_written_as_xml_asks() {
        let series = VtuSeries { path: "a&b.pvd".into(), stem: "a&b".to_owned(), steps: vec![(0.25, false)] };
        assert!(series.list().contains("file=\"a&amp;b_0000.vtu\""));
    }
}
