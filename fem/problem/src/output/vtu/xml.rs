//! An unstructured grid as VTK's XML, each array in base64 behind the number of its bytes.

use forms_mesh::files::base64;

/// The start of a file whose arrays this module writes: numbers in little endian, 64 bits for the number of bytes.
const HEAD: &str = concat!(
    "<?xml version=\"1.0\"?>\n",
    "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n",
    "<UnstructuredGrid>\n",
);

/// Points and cells with their data.
pub(super) struct Grid<'a> {
    pub(super) points: Array<'a>,
    /// The points of all cells, one cell after the other.
    pub(super) connectivity: Vec<u64>,
    /// For each cell the end of its points in `connectivity`.
    pub(super) offsets: Vec<u64>,
    /// VTK's numbers of the types of cells.
    pub(super) types: Vec<u8>,
    pub(super) point_data: Vec<Array<'a>>,
    pub(super) cell_data: Vec<Array<'a>>,
}

/// A named array, `values[place * components + component]`.
pub(super) struct Array<'a> {
    pub(super) name: &'a str,
    pub(super) components: usize,
    pub(super) values: Values<'a>,
}

/// The numbers of an array.
pub(super) enum Values<'a> {
    Reals(&'a [f64]),
    Integers(Vec<i32>),
}

impl Grid<'_> {
    /// The text of the file.
    pub(super) fn encode(&self) -> String {
        let mut text = HEAD.to_owned();
        let points = match &self.points.values {
            Values::Reals(values) => values.len(),
            Values::Integers(values) => values.len(),
        } / self.points.components;
        let piece = format!("<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{}\">\n", self.types.len());
        text.push_str(&piece);
        let part = |text: &mut String, name: &str, arrays: &[Array]| {
            text.push_str(&format!("<{name}{}>\n", active(arrays)));
            arrays.iter().for_each(|array| array.append(text));
            text.push_str(&format!("</{name}>\n"));
        };
        part(&mut text, "PointData", &self.point_data);
        part(&mut text, "CellData", &self.cell_data);
        text.push_str("<Points>\n");
        self.points.append(&mut text);
        text.push_str("</Points>\n<Cells>\n");
        let words = |numbers: &[u64]| little_endian(numbers, |number| number.to_le_bytes());
        append(&mut text, "connectivity", 1, "UInt64", words(&self.connectivity));
        append(&mut text, "offsets", 1, "UInt64", words(&self.offsets));
        append(&mut text, "types", 1, "UInt8", little_endian(&self.types, |kind| [kind]));
        text.push_str("</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
        text
    }
}

impl Array<'_> {
    fn append(&self, text: &mut String) {
        let (kind, bytes) = match &self.values {
            Values::Reals(values) => ("Float64", little_endian(values, |value| value.to_le_bytes())),
            Values::Integers(values) => ("Int32", little_endian(values, |value| value.to_le_bytes())),
        };
        append(text, self.name, self.components, kind, bytes);
    }
}

/// The attributes that name the first array of each kind, which readers show by default.
fn active(arrays: &[Array]) -> String {
    let mut text = String::new();
    for (kind, components) in [("Scalars", 1), ("Vectors", 3), ("Tensors", 9)] {
        if let Some(array) = arrays.iter().find(|array| array.components == components) {
            text.push_str(&format!(" {kind}=\"{}\"", escaped(array.name)));
        }
    }
    text
}

/// The bytes of an array, behind their number.
fn little_endian<T: Copy, const N: usize>(numbers: &[T], bytes_of: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    let mut bytes = vec![0; size_of::<u64>() + N * numbers.len()];
    let (head, rest) = bytes.split_at_mut(size_of::<u64>());
    head.copy_from_slice(&((N * numbers.len()) as u64).to_le_bytes());
    for (target, number) in rest.chunks_exact_mut(N).zip(numbers) {
        target.copy_from_slice(&bytes_of(*number));
    }
    bytes
}

/// Appends an array of numbers of VTK's type `kind`, whose `bytes` follow their number.
fn append(text: &mut String, name: &str, components: usize, kind: &str, bytes: Vec<u8>) {
    let name = escaped(name);
    let head = format!(
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">"
    );
    text.push_str(&head);
    base64::append(text, &bytes);
    text.push_str("</DataArray>\n");
}

/// A name as the value of an attribute. White space other than a blank would be read as one.
fn escaped(name: &str) -> String {
    let mut text = String::with_capacity(name.len());
    for character in name.chars() {
        match character {
            '&' => text.push_str("&amp;"),
            '<' => text.push_str("&lt;"),
            '>' => text.push_str("&gt;"),
            '"' => text.push_str("&quot;"),
            '\t' | '\n' | '\r' => text.push_str(&format!("&#{};", u32::from(character))),
            other => text.push(other),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One segment, written down by hand; the base64 is that of Python's `struct` and `base64`.
    #[test]
    fn a_file_in_full() {
        let array = |name, values| Array { name, components: 1, values };
        let grid = Grid {
            points: Array {
                name: "coordinates",
                components: 3,
                values: Values::Reals(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
            },
            connectivity: vec![0, 1],
            offsets: vec![2],
            types: vec![3],
            point_data: vec![array("σ < \"τ\" & t", Values::Reals(&[0.5, -2.0]))],
            cell_data: vec![array("region", Values::Integers(vec![-1]))],
        };
        let expected = "<?xml version=\"1.0\"?>
<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">
<UnstructuredGrid>
<Piece NumberOfPoints=\"2\" NumberOfCells=\"1\">
<PointData Scalars=\"σ &lt; &quot;τ&quot; &amp; t\">
<DataArray type=\"Float64\" Name=\"σ &lt; &quot;τ&quot; &amp; t\" NumberOfComponents=\"1\" format=\"binary\">EAAAAAAAAAAAAAAAAADgPwAAAAAAAADA</DataArray>
</PointData>
<CellData Scalars=\"region\">
<DataArray type=\"Int32\" Name=\"region\" NumberOfComponents=\"1\" format=\"binary\">BAAAAAAAAAD/////</DataArray>
</CellData>
<Points>
<DataArray type=\"Float64\" Name=\"coordinates\" NumberOfComponents=\"3\" format=\"binary\">MAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAADwPwAAAAAAAAAAAAAAAAAAAAA=</DataArray>
</Points>
<Cells>
<DataArray type=\"UInt64\" Name=\"connectivity\" NumberOfComponents=\"1\" format=\"binary\">EAAAAAAAAAAAAAAAAAAAAAEAAAAAAAAA</DataArray>
<DataArray type=\"UInt64\" Name=\"offsets\" NumberOfComponents=\"1\" format=\"binary\">CAAAAAAAAAACAAAAAAAAAA==</DataArray>
<DataArray type=\"UInt8\" Name=\"types\" NumberOfComponents=\"1\" format=\"binary\">AQAAAAAAAAAD</DataArray>
</Cells>
</Piece>
</UnstructuredGrid>
</VTKFile>
";
        assert_eq!(grid.encode(), expected);
    }
}
