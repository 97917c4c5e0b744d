//! An unstructured grid as VTK's XML, each array in base64 behind the number of its bytes.
//!
//! Arrays are coded in blocks on several threads, and written block by block: the text is never in memory as a whole.

use std::borrow::Cow;
use std::io::{self, Write};

use forms_mesh::files::base64;

use crate::threads::Threads;

/// The start of a file whose arrays this module writes: numbers in little endian, 64 bits for the number of bytes.
const HEAD: &str = concat!(
    "<?xml version=\"1.0\"?>\n",
    "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n",
    "<UnstructuredGrid>\n",
);

/// Bytes of a block, with those of the number before the array: whole numbers of each type, and whole groups of three.
const BLOCK: usize = 24 << 13;

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
    Reals(Cow<'a, [f64]>),
    Integers(Vec<i32>),
}

impl Grid<'_> {
    /// Writes the text of the file, coded on some threads.
    pub(super) fn write(&self, threads: Threads, writer: &mut dyn Write) -> io::Result<()> {
        let points = match &self.points.values {
            Values::Reals(values) => values.len(),
            Values::Integers(values) => values.len(),
        } / self.points.components;
        let cells = self.types.len();
        writeln!(writer, "{HEAD}<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">")?;
        for (name, arrays) in [("PointData", &self.point_data), ("CellData", &self.cell_data)] {
            writeln!(writer, "<{name}{}>", active(arrays))?;
            arrays.iter().try_for_each(|array| array.write(threads, writer))?;
            writeln!(writer, "</{name}>")?;
        }
        writeln!(writer, "<Points>")?;
        self.points.write(threads, writer)?;
        write!(writer, "</Points>\n<Cells>\n")?;
        let words = |number: u64| number.to_le_bytes();
        write_array(threads, writer, ("connectivity", 1, "UInt64"), &self.connectivity, words)?;
        write_array(threads, writer, ("offsets", 1, "UInt64"), &self.offsets, words)?;
        write_array(threads, writer, ("types", 1, "UInt8"), &self.types, |kind| [kind])?;
        writer.write_all(b"</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n")
    }
}

impl Array<'_> {
    fn write(&self, threads: Threads, writer: &mut dyn Write) -> io::Result<()> {
        let head = |kind| (self.name, self.components, kind);
        match &self.values {
            Values::Reals(values) => write_array(threads, writer, head("Float64"), values, f64::to_le_bytes),
            Values::Integers(values) => write_array(threads, writer, head("Int32"), values, i32::to_le_bytes),
        }
    }
}

/// The attributes that name the first array of each kind, which readers show by default.
pub(super) fn active(arrays: &[Array]) -> String {
    let mut text = String::new();
    for (kind, components) in [("Scalars", 1), ("Vectors", 3), ("Tensors", 9)] {
        if let Some(array) = arrays.iter().find(|array| array.components == components) {
            text.push_str(&format!(" {kind}=\"{}\"", escaped(array.name)));
        }
    }
    text
}

/// Writes an array of numbers of VTK's type `kind`, behind the number of their bytes.
fn write_array<T: Copy + Sync, const N: usize>(
    threads: Threads,
    writer: &mut dyn Write,
    (name, components, kind): (&str, usize, &str),
    numbers: &[T],
    bytes_of: impl Fn(T) -> [u8; N] + Sync,
) -> io::Result<()> {
    let name = escaped(name);
    write!(
        writer,
        "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">"
    )?;
    const HEADER: usize = size_of::<u64>();
    let size = N * numbers.len();
    let coded = |start: usize| {
        let end = (start + BLOCK).min(HEADER + size);
        let mut bytes = Vec::with_capacity(BLOCK);
        if start == 0 {
            bytes.extend((size as u64).to_le_bytes());
        }
        let first = start.saturating_sub(HEADER) / N;
        bytes.extend(numbers[first..(end - HEADER) / N].iter().flat_map(|number| bytes_of(*number)));
        let mut text = String::new();
        base64::append(&mut text, &bytes);
        text
    };
    let starts: Vec<usize> = (0..HEADER + size).step_by(BLOCK).collect();
    for starts in starts.chunks(threads.count()) {
        for text in threads.run(starts.to_vec(), coded) {
            writer.write_all(text.as_bytes())?;
        }
    }
    writeln!(writer, "</DataArray>")
}

/// A name as the value of an attribute. White space other than a blank would be read as one.
pub(super) fn escaped(name: &str) -> String {
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
        let reals = |values: &'static [f64]| Values::Reals(Cow::Borrowed(values));
        let grid = Grid {
            points: Array {
                name: "coordinates",
                components: 3,
                values: reals(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
            },
            connectivity: vec![0, 1],
            offsets: vec![2],
            types: vec![3],
            point_data: vec![array("σ < \"τ\" & t", reals(&[0.5, -2.0]))],
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
        let mut text = vec![];
        grid.write(Threads::ONE, &mut text).unwrap();
        assert_eq!(String::from_utf8(text).unwrap(), expected);
    }

    /// Arrays of several blocks, whose ends are before, at and behind the end of a block.
    #[test]
    fn blocks_follow_each_other() {
        for count in [BLOCK - 9, BLOCK - 8, BLOCK - 7, 3 * BLOCK + 5] {
            let bytes: Vec<u8> = (0..count).map(|k| (k * k / 7) as u8).collect();
            let integers: Vec<i32> = bytes.iter().map(|byte| i32::from(*byte) - 99).collect();
            let (mut written, mut expected) = (vec![], String::new());
            write_array(Threads::new(3), &mut written, ("t", 1, "UInt8"), &bytes, |byte| [byte]).unwrap();
            write_array(Threads::new(3), &mut written, ("i", 1, "Int32"), &integers, i32::to_le_bytes)
                .unwrap();
            let four: Vec<u8> = integers.iter().flat_map(|number| number.to_le_bytes()).collect();
            for (head, bytes) in [("UInt8\" Name=\"t", bytes), ("Int32\" Name=\"i", four)] {
                expected +=
                    &format!("<DataArray type=\"{head}\" NumberOfComponents=\"1\" format=\"binary\">");
                base64::append(&mut expected, &[&(bytes.len() as u64).to_le_bytes(), &bytes[..]].concat());
                expected += "</DataArray>\n";
            }
            assert!(written == expected.as_bytes(), "{count} bytes");
        }
    }
}
