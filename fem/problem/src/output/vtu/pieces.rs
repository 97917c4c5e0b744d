//! `.pvtu` files: the list of the `.vtu` files into which processes write their pieces of a mesh, with the arrays that all of these have.

use std::ffi::OsStr;
use std::io::{self, Write};
use std::path::Path;

use super::VtuError;
use super::xml::{Array, Grid, Values, active, escaped};
use crate::solve::communicator::Fingerprint;

/// The name of a process's file, next to that of the list.
pub(super) fn name(path: &Path, rank: usize) -> Result<String, VtuError> {
    let stem = path.file_stem().and_then(OsStr::to_str);
    let stem = stem.ok_or_else(|| VtuError::Series { path: path.to_owned() })?;
    Ok(format!("{stem}_p{rank:04}.vtu"))
}

impl Grid<'_> {
    /// A number that tells other arrays apart.
    pub(super) fn fingerprint(&self) -> u64 {
        let arrays = self.point_data.iter().chain(&self.cell_data);
        let all = Fingerprint::default().numbers([self.point_data.len() as u64]);
        arrays.fold(all, |all, array| all.text(&array.declared())).finish()
    }
}

impl Array<'_> {
    /// The array without its numbers.
    fn declared(&self) -> String {
        let kind = match self.values {
            Values::Reals(_) => "Float64",
            Values::Integers(_) => "Int32",
        };
        let (name, components) = (escaped(self.name), self.components);
        format!("<PDataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"/>\n")
    }
}

/// Writes the list of files with the arrays of a grid.
pub(super) fn write_list(grid: &Grid<'_>, names: &[String], writer: &mut dyn Write) -> io::Result<()> {
    writeln!(
        writer,
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<PUnstructuredGrid GhostLevel=\"0\">"
    )?;
    for (name, arrays) in [("PPointData", &grid.point_data), ("PCellData", &grid.cell_data)] {
        writeln!(writer, "<{name}{}>", active(arrays))?;
        arrays.iter().try_for_each(|array| writer.write_all(array.declared().as_bytes()))?;
        writeln!(writer, "</{name}>")?;
    }
    write!(writer, "<PPoints>\n{}</PPoints>\n", grid.points.declared())?;
    names.iter().try_for_each(|name| writeln!(writer, "<Piece Source=\"{}\"/>", escaped(name)))?;
    writer.write_all(b"</PUnstructuredGrid>\n</VTKFile>\n")
}
