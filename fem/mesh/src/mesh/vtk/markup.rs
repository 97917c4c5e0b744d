//! The little of XML that VTK's files use: elements with attributes, text and children.

use super::error::VtkProblem;
use crate::mesh::imported::{FilePosition, shortened};

/// An element.
#[derive(Debug, Default)]
pub(super) struct Element<'a> {
    pub(super) name: &'a str,
    attributes: Vec<(&'a str, String)>,
    /// The text directly inside it.
    pub(super) text: Vec<u8>,
    pub(super) children: Vec<Element<'a>>,
}

/// A document: its outermost element, and what follows the underscore of its appended data.
pub(super) struct Document<'a> {
    pub(super) root: Element<'a>,
    /// To the end of the file: raw bytes may look like a mark.
    pub(super) appended: &'a [u8],
}

/// VTK's files are five elements deep.
const DEEPEST: usize = 32;

impl Element<'_> {
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(known, _)| *known == name).map(|(_, value)| value.as_str())
    }

    pub(super) fn child(&self, name: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.name == name)
    }
}

struct Parser<'a> {
    bytes: &'a [u8],
    at: usize,
}

/// Reads a document.
pub(super) fn parse(bytes: &[u8]) -> Result<Document<'_>, VtkProblem> {
    let mut parser = Parser { bytes, at: 0 };
    let mut open: Vec<Element> = Vec::new();
    loop {
        let text = parser.until(b'<');
        match open.last_mut() {
            Some(element) => element.text.extend(text),
            None if text.trim_ascii().is_empty() || text == b"\xef\xbb\xbf" => {}
            None => return Err(parser.unexpected(parser.at - text.len(), "an element, which begins with <")),
        }
        let start = parser.at;
        if !parser.skip(b"<") {
            let name = open.last().map_or("VTKFile", |element| element.name);
            return Err(parser.unexpected(start, &format!("</{name}>")));
        }
        if parser.skip(b"!--") {
            parser.behind(b"-->")?;
        } else if parser.skip(b"?") {
            parser.behind(b"?>")?;
        } else if parser.skip(b"/") {
            let name = parser.name()?;
            parser.white();
            let element = open.pop().filter(|element| element.name == name);
            let Some(element) = element.filter(|_| parser.skip(b">")) else {
                return Err(parser.unexpected(start, "the end of the innermost element"));
            };
            if let Some(root) = close(&mut open, element) {
                return Ok(Document { root, appended: &[] });
            }
        } else {
            let (element, empty) = parser.element()?;
            if element.name == "AppendedData" && !empty {
                parser.white();
                if !parser.skip(b"_") {
                    return Err(parser.unexpected(parser.at, "the underscore before appended data"));
                }
                // What is open closes behind the data.
                let appended = &bytes[parser.at..];
                open.push(element);
                while let Some(element) = open.pop() {
                    if let Some(root) = close(&mut open, element) {
                        return Ok(Document { root, appended });
                    }
                }
            } else if open.len() > DEEPEST {
                return Err(parser.unexpected(start, "the end of an element"));
            } else if !empty {
                open.push(element);
            } else if let Some(root) = close(&mut open, element) {
                return Ok(Document { root, appended: &[] });
            }
        }
    }
}

// The element belongs to the innermost one that is open, or is the outermost.
fn close<'a>(open: &mut [Element<'a>], element: Element<'a>) -> Option<Element<'a>> {
    match open.last_mut() {
        Some(parent) => {
            parent.children.push(element);
            None
        }
        None => Some(element),
    }
}

impl<'a> Parser<'a> {
    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.at..]
    }

    fn unexpected(&self, at: usize, expected: &str) -> VtkProblem {
        unexpected(self.bytes, at, expected)
    }

    fn skip(&mut self, mark: &[u8]) -> bool {
        let there = self.rest().starts_with(mark);
        self.at += if there { mark.len() } else { 0 };
        there
    }

    fn white(&mut self) {
        self.at += self.rest().iter().take_while(|byte| byte.is_ascii_whitespace()).count();
    }

    // Up to a byte, or to the end.
    fn until(&mut self, byte: u8) -> &'a [u8] {
        let rest = self.rest();
        let length = rest.iter().position(|&other| other == byte).unwrap_or(rest.len());
        self.at += length;
        &rest[..length]
    }

    fn behind(&mut self, mark: &[u8]) -> Result<(), VtkProblem> {
        match self.rest().windows(mark.len()).position(|window| window == mark) {
            Some(position) => {
                self.at += position + mark.len();
                Ok(())
            }
            None => Err(self.unexpected(self.bytes.len(), &String::from_utf8_lossy(mark))),
        }
    }

    fn name(&mut self) -> Result<&'a str, VtkProblem> {
        let rest = self.rest();
        let part = |byte: &&u8| byte.is_ascii_alphanumeric() || b"_-.:".contains(byte);
        let length = rest.iter().take_while(part).count();
        let name = std::str::from_utf8(&rest[..length]).unwrap_or_default();
        if name.is_empty() {
            return Err(self.unexpected(self.at, "a name"));
        }
        self.at += length;
        Ok(name)
    }

    // An element behind its <, and whether it is empty.
    fn element(&mut self) -> Result<(Element<'a>, bool), VtkProblem> {
        let mut element = Element { name: self.name()?, ..Element::default() };
        loop {
            self.white();
            if self.skip(b">") {
                return Ok((element, false));
            }
            if self.skip(b"/>") {
                return Ok((element, true));
            }
            let name = self.name()?;
            self.white();
            let assigned = self.skip(b"=");
            self.white();
            let quote = self.rest().first().copied().filter(|byte| assigned && b"\"'".contains(byte));
            let Some(quote) = quote else {
                return Err(
                    self.unexpected(self.at, &format!("= and the value of {name} in quotation marks"))
                );
            };
            self.at += 1;
            let value = String::from_utf8_lossy(self.until(quote)).into_owned();
            if !self.skip(&[quote]) {
                return Err(self.unexpected(self.at, &format!("the end of the value of {name}")));
            }
            element.attributes.push((name, plain(value)));
        }
    }
}

// Without XML's marks for characters.
fn plain(text: String) -> String {
    if !text.contains('&') {
        return text;
    }
    let marks = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
    marks.into_iter().fold(text, |text, (mark, character)| text.replace(mark, character))
}

/// An unexpected text at an offset.
pub(super) fn unexpected(bytes: &[u8], at: usize, expected: &str) -> VtkProblem {
    let line = 1 + bytes[..at].iter().filter(|&&byte| byte == b'\n').count();
    let found = match bytes[at..].split(|&byte| byte == b'\n').next() {
        Some(found) if at < bytes.len() => format!("{:?}", shortened(found)),
        _ => "the end of the file".to_owned(),
    };
    VtkProblem::Unexpected { position: FilePosition::Line(line), expected: expected.to_owned(), found }
}
