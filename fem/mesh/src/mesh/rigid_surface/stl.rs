//! Surfaces from STL files, binary and text. Triangles come with coordinates of their own: corners at one place, to the last bit,
//! are one point.

use std::collections::HashMap;
use std::path::Path;
use std::str::SplitWhitespace;

use super::{RigidSurface, RigidSurfaceError, flat_facet};

/// Bytes before the triangles of a binary file, and bytes of each.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// A triangle as the file has it, with the normal that it says (zero where it says none).
struct Triangle {
    place: String,
    normal: [f64; 3],
    corners: [[f64; 3]; 3],
}

impl RigidSurface<3> {
    /// A surface from the contents of an STL file. Lengths are the file's.
    ///
    /// # Errors
    /// A [`RigidSurfaceError`] that names the byte or the line: a file that breaks off or is none; a triangle without an area, with a
    /// coordinate that is not finite, or whose normal contradicts the order of its corners; neighbours that turn opposite sides outward; a
    /// closed surface that is inside out. Whether the outward side of an open one ([`RigidSurface::rim`]) is the right one cannot be judged.
    pub fn from_stl(contents: &[u8]) -> Result<Self, RigidSurfaceError> {
        let triangles = match promised(contents) {
            Some((_, length)) if length == contents.len() as u64 => binary(contents),
            promise => match (contents.trim_ascii_start().starts_with(b"solid"), promise) {
                (true, _) => text(contents)?,
                (false, Some((triangles, expected))) => {
                    let found = contents.len() as u64;
                    return Err(RigidSurfaceError::Length { triangles, expected, found });
                }
                (false, None) => return Err(RigidSurfaceError::NoStl { found: contents.len() as u64 }),
            },
        };
        let surface = joined(&triangles)?;
        match surface.enclosed() {
            Some(volume) if volume < 0.0 => Err(RigidSurfaceError::InsideOut { volume }),
            _ => Ok(surface),
        }
    }

    /// A surface from an STL file.
    ///
    /// # Errors
    /// [`RigidSurfaceError::Read`]; [`RigidSurfaceError::File`] with those of [`RigidSurface::from_stl`].
    pub fn from_stl_file(path: impl AsRef<Path>) -> Result<Self, RigidSurfaceError> {
        let name = || path.as_ref().display().to_string();
        let contents =
            std::fs::read(&path).map_err(|source| RigidSurfaceError::Read { path: name(), source })?;
        RigidSurface::from_stl(&contents)
            .map_err(|source| RigidSurfaceError::File { path: name(), source: Box::new(source) })
    }
}

/// The number of triangles that a binary header says, and the length that goes with it.
fn promised(contents: &[u8]) -> Option<(u32, u64)> {
    let count: [u8; 4] = contents.get(HEADER - 4..HEADER)?.try_into().ok()?;
    let count = u32::from_le_bytes(count);
    Some((count, HEADER as u64 + u64::from(count) * TRIANGLE as u64))
}

fn binary(contents: &[u8]) -> Vec<Triangle> {
    let triangle = |(index, bytes): (usize, &[u8])| {
        let number = |k: usize| {
            f64::from(f32::from_le_bytes([
                bytes[4 * k],
                bytes[4 * k + 1],
                bytes[4 * k + 2],
                bytes[4 * k + 3],
            ]))
        };
        let vector = |first: usize| [0, 1, 2].map(|k| number(first + k));
        let place = format!("byte {}", HEADER + index * TRIANGLE);
        Triangle { place, normal: vector(0), corners: [3, 6, 9].map(vector) }
    };
    contents[HEADER..].chunks_exact(TRIANGLE).enumerate().map(triangle).collect()
}

/// The words of a text with their lines.
struct Words<'a> {
    lines: std::iter::Enumerate<std::str::Lines<'a>>,
    line: usize,
    words: SplitWhitespace<'a>,
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<&'a str> {
        loop {
            if let Some(word) = self.words.next() {
                return Some(word);
            }
            let (index, line) = self.lines.next()?;
            (self.line, self.words) = (index + 1, line.split_whitespace());
        }
    }

    fn refused<T>(&self, found: Option<&str>, expected: &'static str) -> Result<T, RigidSurfaceError> {
        let found = found.map_or_else(|| "the end of the file".to_owned(), |found| format!("\"{found}\""));
        Err(RigidSurfaceError::Text { line: self.line, found, expected })
    }

    fn expect(&mut self, words: &[&'static str]) -> Result<(), RigidSurfaceError> {
        for &word in words {
            let found = self.next();
            if found != Some(word) {
                return self.refused(found, word);
            }
        }
        Ok(())
    }

    fn vector(&mut self) -> Result<[f64; 3], RigidSurfaceError> {
        let mut vector = [0.0; 3];
        for component in &mut vector {
            let word = self.next();
            match word.and_then(|word| word.parse().ok()) {
                Some(number) => *component = number,
                None => return self.refused(word, "a number"),
            }
        }
        Ok(vector)
    }
}

/// The triangles of a text: one solid or several.
fn text(contents: &[u8]) -> Result<Vec<Triangle>, RigidSurfaceError> {
    let text = String::from_utf8_lossy(contents);
    let mut words = Words { lines: text.lines().enumerate(), line: 1, words: "".split_whitespace() };
    let mut triangles = Vec::new();
    while let Some(word) = words.next() {
        if word != "solid" {
            return words.refused(Some(word), "solid");
        }
        // The rest of the line is its name.
        words.words = "".split_whitespace();
        loop {
            match words.next() {
                Some("facet") => {
                    let place = format!("line {}", words.line);
                    words.expect(&["normal"])?;
                    let normal = words.vector()?;
                    words.expect(&["outer", "loop"])?;
                    let mut corners = [[0.0; 3]; 3];
                    for corner in &mut corners {
                        words.expect(&["vertex"])?;
                        *corner = words.vector()?;
                    }
                    words.expect(&["endloop", "endfacet"])?;
                    triangles.push(Triangle { place, normal, corners });
                }
                Some("endsolid") => break,
                other => return words.refused(other, "facet or endsolid"),
            }
        }
        words.words = "".split_whitespace();
    }
    Ok(triangles)
}

/// The surface of triangles, with one point at each place.
fn joined(triangles: &[Triangle]) -> Result<RigidSurface<3>, RigidSurfaceError> {
    let mut numbers: HashMap<[u64; 3], u32> = HashMap::new();
    let (mut points, mut facets) = (Vec::new(), Vec::with_capacity(triangles.len()));
    for (index, Triangle { place, normal, corners }) in triangles.iter().enumerate() {
        let refused =
            |why: String| RigidSurfaceError::Triangle { triangle: index, place: place.clone(), why };
        if let Some(corner) = corners.iter().find(|corner| !corner.iter().all(|x| x.is_finite())) {
            return Err(refused(format!("a corner is not finite: {corner:?}")));
        }
        let Some(own) = flat_facet::normal(corners) else {
            return Err(refused(format!(
                "it is degenerate: corners at {corners:?} have no area between them"
            )));
        };
        let along: f64 = own.iter().zip(normal).map(|(a, b)| a * b).sum();
        if along < 0.0 {
            return Err(refused(format!(
                "its normal {normal:?} contradicts the order of its corners, whose normal is {own:?}"
            )));
        }
        facets.push(corners.map(|corner| {
            // 0 and −0 are one place.
            *numbers.entry(corner.map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                points.push(corner);
                points.len() as u32 - 1
            })
        }));
    }
    RigidSurface::new(points, facets)
}
