//! From the bytes of a file to its contents, section by section.

use super::error::{GmshError, GmshProblem};
use super::reader::{Encoding, Reader};
use super::version_4::Entities;
use super::{WORDS, version_2, version_4};
use crate::mesh::imported::Contents;

type Result<T> = std::result::Result<T, GmshError>;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Version {
    Two,
    Four,
}

/// Reads all sections. The reader knows the encoding afterwards.
pub(super) fn read(reader: &mut Reader) -> Result<Contents> {
    let mut contents = Contents::new(&WORDS);
    let mut entities = Entities::default();
    let mut version = None;
    let mut seen: Vec<String> = Vec::new();
    loop {
        reader.section = None;
        reader.skip_white();
        if reader.is_at_end() {
            break;
        }
        let at = reader.at;
        let line = reader.line();
        let name = match line.strip_prefix(b"$").map(std::str::from_utf8) {
            Some(Ok(name)) if !name.is_empty() && name.len() <= 100 => name.to_owned(),
            _ if seen.is_empty() => return Err(not_gmsh(reader)),
            _ => {
                let found = String::from_utf8_lossy(&line[..line.len().min(40)]).into_owned();
                let expected = "a section, which begins with $".to_owned();
                return Err(reader.error_at(at, GmshProblem::Unexpected { expected, found }));
            }
        };
        let once = matches!(
            name.as_str(),
            "MeshFormat" | "PhysicalNames" | "Entities" | "PartitionedEntities" | "Nodes" | "Elements"
        );
        if once && seen.contains(&name) {
            return Err(reader.error_at(at, GmshProblem::RepeatedSection { section: name }));
        }
        reader.section = Some(name.clone());
        match (name.as_str(), version) {
            ("MeshFormat", _) => version = Some(header(reader)?),
            (_, None) if !once => reader.skip_section(&name)?,
            (_, None) => return Err(not_gmsh(reader)),
            ("PhysicalNames", _) => physical_names(reader, &mut contents)?,
            ("Entities", Some(Version::Four)) => entities.read(reader, false)?,
            ("PartitionedEntities", Some(Version::Four)) => entities.read(reader, true)?,
            ("Nodes", Some(Version::Four)) => version_4::nodes(reader, &mut contents)?,
            ("Nodes", Some(Version::Two)) => version_2::nodes(reader, &mut contents)?,
            ("Elements", Some(Version::Four)) => version_4::elements(reader, &mut contents, &entities)?,
            ("Elements", Some(Version::Two)) => version_2::elements(reader, &mut contents)?,
            ("ParametricNodes", _) => return Err(reader.error_at(at, GmshProblem::ParametricNodes)),
            _ => reader.skip_section(&name)?,
        }
        if once {
            reader.end_section(&name)?;
        }
        seen.push(name);
    }
    reader.section = None;
    let missing = ["MeshFormat", "Nodes", "Elements"]
        .into_iter()
        .find(|section| !seen.iter().any(|name| name == section));
    match missing {
        Some("MeshFormat") => Err(not_gmsh(reader)),
        Some(section) => Err(reader.error_of_file(GmshProblem::MissingSection { section })),
        None => Ok(contents),
    }
}

fn not_gmsh(reader: &mut Reader) -> GmshError {
    reader.section = None;
    reader.error_of_file(GmshProblem::NotGmsh { start: reader.start() })
}

fn header(reader: &mut Reader) -> Result<Version> {
    let at = reader.here();
    let version: String = reader.text("a version")?;
    let version = match version.parse::<f64>() {
        Ok(2.2) => Version::Two,
        Ok(4.1) => Version::Four,
        _ => return Err(reader.error_at(at, GmshProblem::Version { version })),
    };
    let at = reader.here();
    let binary: i64 = reader.text("the file-type")?;
    let header = |field, value, requirement| GmshProblem::Header { field, value, requirement };
    if binary != 0 && binary != 1 {
        let problem = header("file-type", binary, "it is 0 for text and 1 for binary");
        return Err(reader.error_at(at, problem));
    }
    let at = reader.here();
    let size: i64 = reader.text("the data-size")?;
    reader.word = match (version, size) {
        (_, 8) => 8,
        (Version::Four, 4) => 4,
        _ => {
            let problem = header("data-size", size, "it is 8, or 4 where version 4.1 counts with 32 bits");
            return Err(reader.error_at(at, problem));
        }
    };
    reader.line();
    if binary == 1 {
        let at = reader.here();
        reader.encoding = Encoding::LittleEndian;
        let one = reader.integer("the number 1")?;
        if one != 1 {
            if one as i32 != 1_i32.swap_bytes() {
                let problem = header("byte order", one, "the number 1 should stand there");
                return Err(reader.error_at(at, problem));
            }
            reader.encoding = Encoding::BigEndian;
        }
    }
    Ok(version)
}

// Lines of dimension, tag and "name", written out in binary files too.
fn physical_names(reader: &mut Reader, contents: &mut Contents) -> Result<()> {
    let count: u64 = reader.text("the number of names")?;
    for _ in 0..count {
        reader.skip_white();
        if reader.is_at_end() {
            return Err(reader.truncated("a dimension, a tag and a name"));
        }
        let at = reader.at;
        let line = reader.line();
        let Some((dimension, tag, name)) = physical_name(line) else {
            return Err(reader.unexpected(at, "a dimension, a tag and a name in quotation marks", line));
        };
        if contents.names.insert((dimension, tag), name).is_some() {
            return Err(reader.error_at(at, GmshProblem::RepeatedGroup { dimension, tag }));
        }
    }
    Ok(())
}

fn physical_name(line: &[u8]) -> Option<(usize, i64, String)> {
    let line = std::str::from_utf8(line).ok()?;
    let (dimension, rest) = line.split_once(char::is_whitespace)?;
    let (tag, rest) = rest.trim_start().split_once(char::is_whitespace)?;
    let name = rest.trim().strip_prefix('"')?.strip_suffix('"')?;
    let dimension = dimension.parse().ok().filter(|&dimension| dimension <= 3)?;
    Some((dimension, tag.parse().ok()?, name.to_owned()))
}
