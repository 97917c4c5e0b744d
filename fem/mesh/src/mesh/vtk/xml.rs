//! Grids from XML files (`.vtu`).

use super::array::{NumberType, RawArray, Values};
use super::bytes::{Encoding, Source};
use super::error::VtkProblem;
use super::grid::{Grid, not_vtk};
use super::markup::{self, Document, Element};

type Result<T> = std::result::Result<T, VtkProblem>;

/// Reads an XML file.
pub(super) fn read(bytes: &[u8]) -> Result<Grid> {
    let document = markup::parse(bytes)?;
    let root = &document.root;
    if root.name != "VTKFile" {
        return Err(not_vtk(bytes.trim_ascii_start()));
    }
    let Some(grid) = root.child("UnstructuredGrid") else {
        let found = root.attribute("type").unwrap_or("data without a type");
        return Err(VtkProblem::NotOneGrid { found: found.to_owned() });
    };
    // Programs that write in parallel leave pieces without cells.
    let has_cells =
        |piece: &&Element| piece.attribute("NumberOfCells").is_some_and(|count| count.trim() != "0");
    let pieces: Vec<_> = grid.children.iter().filter(|child| child.name == "Piece").collect();
    let full: Vec<_> = pieces.iter().copied().filter(has_cells).collect();
    let piece = match (full.as_slice(), pieces.as_slice()) {
        ([piece], _) | ([], [piece, ..]) => *piece,
        ([], []) => return Err(VtkProblem::missing("<Piece>")),
        (several, _) => return Err(VtkProblem::NotOneGrid { found: format!("{} pieces", several.len()) }),
    };
    let arrays = Arrays { document: &document, encoding: encoding(root)? };
    let (points, cells) = (count(piece, "NumberOfPoints")?, count(piece, "NumberOfCells")?);
    let part = |name: &str| piece.child(name).ok_or_else(|| VtkProblem::missing(format!("<{name}>")));

    let positions =
        part("Points")?.child("DataArray").ok_or_else(|| VtkProblem::missing("<DataArray> in <Points>"))?;
    let positions = arrays.read(positions, "Points", 3, points)?.values;
    let position = |point: usize| std::array::from_fn(|k| positions.real(3 * point + k));
    let topology = part("Cells")?;
    let integers = |name: &str, tuples: Option<usize>| -> Result<Vec<i64>> {
        let named = |array: &&Element| array.attribute("Name") == Some(name);
        let array = topology.children.iter().find(named);
        let array = array.ok_or_else(|| VtkProblem::missing(format!("array \"{name}\" in <Cells>")))?;
        let values = arrays.values(array, name)?;
        let tuples = tuples.unwrap_or(values.len());
        RawArray::new(name, 1, tuples, values)?.values.integers(name)
    };
    Ok(Grid {
        points: (0..points).map(position).collect(),
        connectivity: integers("connectivity", None)?,
        ends: integers("offsets", Some(cells))?,
        types: integers("types", Some(cells))?,
        point_data: arrays.data(piece.child("PointData"), points)?,
        cell_data: arrays.data(piece.child("CellData"), cells)?,
        before_9: before_9(root),
    })
}

// VTK 9 writes version 2.1 and later.
fn before_9(root: &Element) -> bool {
    let version = root.attribute("version").unwrap_or_default();
    let mut parts = version.split('.').map(|part| part.trim().parse::<u32>().unwrap_or(0));
    (parts.next().unwrap_or(0), parts.next().unwrap_or(0)) < (2, 1)
}

fn count(piece: &Element, name: &str) -> Result<usize> {
    let value = piece.attribute(name).ok_or_else(|| VtkProblem::missing(format!("{name} of <Piece>")))?;
    value.trim().parse().map_err(|_| VtkProblem::missing(format!("number in {name} = {value:?}")))
}

fn encoding(root: &Element) -> Result<Encoding> {
    let unknown =
        |what: &str, value: &str| Err(VtkProblem::missing(format!("way to read {what} = {value:?}")));
    let little = match root.attribute("byte_order") {
        None | Some("LittleEndian") => true,
        Some("BigEndian") => false,
        Some(other) => return unknown("byte_order", other),
    };
    let header = match root.attribute("header_type") {
        None | Some("UInt32") => 4,
        Some("UInt64") => 8,
        Some(other) => return unknown("header_type", other),
    };
    let zlib = match root.attribute("compressor") {
        None | Some("") => false,
        Some("vtkZLibDataCompressor") => true,
        Some(other) => return unknown("compressor", other),
    };
    Ok(Encoding { little, header, zlib })
}

/// The arrays of a file.
struct Arrays<'a> {
    document: &'a Document<'a>,
    encoding: Encoding,
}

impl Arrays<'_> {
    /// An array whose number of components may be left out.
    fn read(&self, array: &Element, name: &str, components: usize, tuples: usize) -> Result<RawArray> {
        let stated = array.attribute("NumberOfComponents").map(|count| count.trim().parse::<usize>());
        match stated {
            Some(Ok(stated)) if stated == components => {}
            None => {}
            _ => return Err(VtkProblem::array(name, format!("NumberOfComponents is not {components}"))),
        }
        RawArray::new(name, components, tuples, self.values(array, name)?)
    }

    /// The arrays of numbers at points or on cells; names of materials and the like are left out.
    fn data(&self, data: Option<&Element>, tuples: usize) -> Result<Vec<RawArray>> {
        let arrays = data.iter().flat_map(|data| &data.children).filter(|array| array.name == "DataArray");
        let of_numbers = arrays.filter(|array| array.attribute("type") != Some("String"));
        of_numbers
            .enumerate()
            .map(|(place, array)| {
                let name = array.attribute("Name").map_or_else(|| format!("array {place}"), str::to_owned);
                let components = array.attribute("NumberOfComponents").unwrap_or("1").trim();
                let components = components.parse().ok().filter(|&count| count > 0);
                let components =
                    components.ok_or_else(|| VtkProblem::array(&name, "NumberOfComponents is no count"));
                self.read(array, &name, components?, tuples)
            })
            .collect()
    }

    fn values(&self, array: &Element, name: &str) -> Result<Values> {
        let problem = |reason: String| VtkProblem::array(name, reason);
        let number = array.attribute("type").unwrap_or_default();
        let number =
            NumberType::of(number).ok_or_else(|| problem(format!("its type {number:?} is not known")))?;
        let bytes = match array.attribute("format").unwrap_or("ascii") {
            "ascii" => {
                let text =
                    std::str::from_utf8(&array.text).map_err(|_| problem("its text is not UTF-8".into()))?;
                let words = text.split_ascii_whitespace();
                let wrong = |word: &str| {
                    problem(format!(
                        "{:?} is no such number",
                        crate::mesh::imported::shortened(word.as_bytes())
                    ))
                };
                return number.parse(words).map_err(wrong);
            }
            "binary" => Source::Text(&array.text, Vec::new()).data(self.encoding),
            "appended" => {
                let offset = array.attribute("offset").and_then(|offset| offset.trim().parse::<usize>().ok());
                let from = offset.and_then(|offset| self.document.appended.get(offset..));
                let from = from.ok_or_else(|| problem("its offset lies behind the appended data".into()))?;
                let appended = self.document.root.child("AppendedData");
                match appended.and_then(|appended| appended.attribute("encoding")) {
                    Some("raw") => Source::Raw(from).data(self.encoding),
                    _ => Source::Text(from, Vec::new()).data(self.encoding),
                }
            }
            other => return Err(problem(format!("its format {other:?} is not known"))),
        };
        let bytes = bytes.map_err(|reason| problem(reason.to_owned()))?;
        if bytes.len() % number.size != 0 {
            return Err(problem(format!("its {} bytes are no whole count of numbers", bytes.len())));
        }
        Ok(number.decode(&bytes, self.encoding.little))
    }
}
