//! Grids from legacy files (`.vtk`), text and binary, up to version 5.1.

use super::array::{NumberType, RawArray, Values};
use super::error::VtkProblem;
use super::grid::{Grid, not_vtk};
use super::legacy_reader::Reader;

type Result<T> = std::result::Result<T, VtkProblem>;

/// Reads a legacy file.
pub(super) fn read(bytes: &[u8]) -> Result<Grid> {
    let start = bytes.trim_ascii_start();
    let mut reader = Reader::new(start);
    let version = match reader.words().as_slice() {
        ["#", name, "DataFile", "Version", version] if name.eq_ignore_ascii_case("vtk") => {
            version.parse::<f64>()
        }
        _ => return Err(not_vtk(start)),
    };
    // VTK 9 writes version 5.1.
    let before_9 = version.map_err(|_| not_vtk(start))? < 5.1;
    reader.line();
    let at = reader.at;
    match reader.word().map(str::to_ascii_uppercase).as_deref() {
        Some("ASCII") => {}
        Some("BINARY") => reader.binary = true,
        _ => return Err(reader.unexpected(at, "ASCII or BINARY")),
    }
    reader.expect("DATASET")?;
    match reader.word() {
        Some(kind) if kind.eq_ignore_ascii_case("UNSTRUCTURED_GRID") => {}
        Some(kind) => return Err(VtkProblem::NotOneGrid { found: kind.to_owned() }),
        None => return Err(reader.unexpected(reader.at, "UNSTRUCTURED_GRID")),
    }
    let mut file = File { reader, found: [false; 3], grid: Grid { before_9, ..Grid::default() } };
    file.sections()?;
    if let Some(place) = file.found.iter().position(|found| !found) {
        return Err(VtkProblem::missing(format!("section {}", SECTIONS[place])));
    }
    let (cells, types) = (file.grid.ends.len(), file.grid.types.len());
    if cells != types {
        return Err(VtkProblem::array("CELL_TYPES", format!("there are {types} types of {cells} cells")));
    }
    Ok(file.grid)
}

/// Those that a file has once: data have their sizes.
const SECTIONS: [&str; 3] = ["POINTS", "CELLS", "CELL_TYPES"];

struct File<'a> {
    reader: Reader<'a>,
    /// Which of [`SECTIONS`] were read.
    found: [bool; 3],
    grid: Grid,
}

/// The entities that data belong to.
#[derive(Clone, Copy)]
enum Target {
    Points,
    Cells,
    /// To the file.
    None,
}

impl File<'_> {
    fn sections(&mut self) -> Result<()> {
        let mut target = (Target::None, 0);
        loop {
            let at = self.reader.at;
            let Some(section) = self.reader.word() else { return Ok(()) };
            let section = section.to_ascii_uppercase();
            if let Some(place) = SECTIONS.iter().position(|known| *known == section) {
                if self.found[place] {
                    return Err(VtkProblem::array(&section, "the section stands twice"));
                }
                self.found[place] = true;
            }
            match section.as_str() {
                "POINTS" => self.points()?,
                "CELLS" => self.cells()?,
                "CELL_TYPES" => self.types()?,
                "POINT_DATA" => target = (Target::Points, self.tuples(self.grid.points.len(), &section)?),
                "CELL_DATA" => target = (Target::Cells, self.tuples(self.grid.ends.len(), &section)?),
                "METADATA" => self.reader.skip_block(),
                "FIELD" => self.field(target)?,
                _ => {
                    let known = self.attribute(&section, target)?;
                    if !known {
                        return Err(self.reader.unexpected(at, "a section of an unstructured grid"));
                    }
                }
            }
        }
    }

    fn tuples(&mut self, expected: usize, section: &str) -> Result<usize> {
        let count = self.reader.count("a count")?;
        if count != expected {
            return Err(VtkProblem::array(section, format!("it is for {count} where there are {expected}")));
        }
        Ok(count)
    }

    fn points(&mut self) -> Result<()> {
        let count = self.reader.count("the number of points")?;
        let number = self.reader.number_type()?;
        let values = self.reader.numbers("POINTS", number, count.checked_mul(3))?;
        self.grid.points =
            (0..count).map(|point| std::array::from_fn(|k| values.real(3 * point + k))).collect();
        Ok(())
    }

    fn cells(&mut self) -> Result<()> {
        let (first, second) =
            (self.reader.count("the number of cells")?, self.reader.count("the size of the list")?);
        let integers = |values: Values| values.integers("CELLS");
        if self.reader.skip("OFFSETS") {
            let number = self.reader.number_type()?;
            let offsets = integers(self.reader.numbers("OFFSETS", number, Some(first))?)?;
            self.reader.expect("CONNECTIVITY")?;
            let number = self.reader.number_type()?;
            self.grid.connectivity = integers(self.reader.numbers("CONNECTIVITY", number, Some(second))?)?;
            match offsets.split_first() {
                Some((0, ends)) => self.grid.ends = ends.to_vec(),
                None => {}
                Some(_) => return Err(VtkProblem::array("OFFSETS", "the first one is not 0")),
            }
        } else {
            // For each cell the number of its points and these.
            let list = integers(self.reader.numbers("CELLS", NumberType::INT, Some(second))?)?;
            let mut rest = list.as_slice();
            while let Some((&count, others)) = rest.split_first() {
                let cell = self.grid.ends.len();
                let points = usize::try_from(count).ok().and_then(|count| others.split_at_checked(count));
                let Some((points, others)) = points else {
                    return Err(VtkProblem::array(
                        "CELLS",
                        format!("it ends within the {count} points of cell {cell}"),
                    ));
                };
                self.grid.connectivity.extend(points);
                self.grid.ends.push(self.grid.connectivity.len() as i64);
                rest = others;
            }
            if self.grid.ends.len() != first {
                let found = self.grid.ends.len();
                return Err(VtkProblem::array(
                    "CELLS",
                    format!("it has {found} cells where {first} are announced"),
                ));
            }
        }
        Ok(())
    }

    fn types(&mut self) -> Result<()> {
        let count = self.reader.count("the number of types")?;
        let values = self.reader.numbers("CELL_TYPES", NumberType::INT, Some(count))?;
        self.grid.types = values.integers("CELL_TYPES")?;
        Ok(())
    }

    fn push(
        &mut self,
        (target, tuples): (Target, usize),
        name: &str,
        components: usize,
        values: Values,
    ) -> Result<()> {
        let list = match target {
            Target::Points => &mut self.grid.point_data,
            Target::Cells => &mut self.grid.cell_data,
            Target::None => return Ok(()),
        };
        list.push(RawArray::new(name, components, tuples, values)?);
        Ok(())
    }

    // Arrays with their own sizes.
    fn field(&mut self, target: (Target, usize)) -> Result<()> {
        self.reader.word();
        for _ in 0..self.reader.count("the number of arrays")? {
            while self.reader.skip("METADATA") {
                self.reader.skip_block();
            }
            let name = self.name()?;
            let components = self.reader.count("the number of components")?;
            let tuples = self.reader.count("the number of tuples")?;
            let number = self.reader.number_type()?;
            let values = self.reader.numbers(&name, number, components.checked_mul(tuples))?;
            self.push(target, &name, components, values)?;
        }
        Ok(())
    }

    // Names have %20 for a space and so on.
    fn name(&mut self) -> Result<String> {
        let at = self.reader.at;
        let Some(word) = self.reader.word() else { return Err(self.reader.unexpected(at, "a name")) };
        let mut name = Vec::with_capacity(word.len());
        let mut rest = word.as_bytes();
        while let Some((&first, others)) = rest.split_first() {
            let code = others.get(..2).and_then(|code| std::str::from_utf8(code).ok());
            match code.and_then(|code| u8::from_str_radix(code, 16).ok()) {
                Some(code) if first == b'%' => {
                    name.push(code);
                    rest = &others[2..];
                }
                _ => {
                    name.push(first);
                    rest = others;
                }
            }
        }
        Ok(String::from_utf8_lossy(&name).into_owned())
    }

    /// An array of the sizes that its section says; whether there is such a section.
    fn attribute(&mut self, section: &str, target: (Target, usize)) -> Result<bool> {
        let colours = if self.reader.binary { NumberType::BYTE } else { NumberType::FLOAT };
        let tuples = target.1;
        let fixed = match section {
            "VECTORS" | "NORMALS" => Some(3),
            "TENSORS" => Some(9),
            "TENSORS6" => Some(6),
            "GLOBAL_IDS" | "PEDIGREE_IDS" => Some(1),
            "SCALARS" | "COLOR_SCALARS" | "LOOKUP_TABLE" | "TEXTURE_COORDINATES" => None,
            _ => return Ok(false),
        };
        let name = self.name()?;
        let (components, number) = match (section, fixed) {
            (_, Some(components)) => (components, self.reader.number_type()?),
            ("SCALARS", _) => {
                let number = self.reader.number_type()?;
                // Their number may be left out, and so may the table.
                let at = self.reader.at;
                let stated = self.reader.word().and_then(|word| word.parse().ok());
                if stated.is_none() {
                    self.reader.at = at;
                }
                if self.reader.skip("LOOKUP_TABLE") {
                    self.reader.word();
                }
                (stated.unwrap_or(1), number)
            }
            ("TEXTURE_COORDINATES", _) => (self.reader.count("a dimension")?, self.reader.number_type()?),
            ("LOOKUP_TABLE", _) => {
                let size = self.reader.count("the size of the table")?;
                self.reader.numbers(&name, colours, size.checked_mul(4))?;
                return Ok(true);
            }
            _ => (self.reader.count("the number of components")?, colours),
        };
        let values = self.reader.numbers(&name, number, components.checked_mul(tuples))?;
        self.push(target, &name, components, values)?;
        Ok(true)
    }
}
