//! The bytes of an array in an XML file: raw or in base64, as they are or compressed.

use std::io::Read;

use flate2::read::ZlibDecoder;

/// The file's encoding of bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Encoding {
    pub(super) little: bool,
    /// Bytes of the numbers before the data: 4 or 8.
    pub(super) header: usize,
    pub(super) zlib: bool,
}

/// Bytes that are taken from the front.
pub(super) enum Source<'a> {
    Raw(&'a [u8]),
    /// Base64, and what is decoded but not taken.
    Text(&'a [u8], Vec<u8>),
}

impl Source<'_> {
    /// The next bytes; none if there are fewer.
    fn take(&mut self, count: usize) -> Option<Vec<u8>> {
        match self {
            Source::Raw(bytes) => {
                let (taken, rest) = bytes.split_at_checked(count)?;
                *bytes = rest;
                Some(taken.to_vec())
            }
            Source::Text(text, decoded) => {
                // Four characters hold three bytes: a count that lies reserves nothing.
                if count > decoded.len() + text.len() {
                    return None;
                }
                while decoded.len() < count {
                    group(text, decoded)?;
                }
                let rest = decoded.split_off(count);
                Some(std::mem::replace(decoded, rest))
            }
        }
    }

    fn number(&mut self, encoding: Encoding) -> Option<usize> {
        let mut bytes = self.take(encoding.header)?;
        if !encoding.little {
            bytes.reverse();
        }
        bytes.resize(8, 0);
        usize::try_from(u64::from_le_bytes(bytes.try_into().ok()?)).ok()
    }

    /// The data behind their header, or what is wrong with them.
    pub(super) fn data(&mut self, encoding: Encoding) -> Result<Vec<u8>, &'static str> {
        const CUT: &str = "its data break off, or are not in the encoding that the file states";
        if !encoding.zlib {
            let length = self.number(encoding).ok_or(CUT)?;
            return self.take(length).ok_or(CUT);
        }
        let [blocks, size, last] = [(); 3].map(|()| self.number(encoding));
        let (blocks, size, last) = (blocks.ok_or(CUT)?, size.ok_or(CUT)?, last.ok_or(CUT)?);
        let mut lengths = Vec::new();
        for _ in 0..blocks {
            lengths.push(self.number(encoding).ok_or(CUT)?);
        }
        let mut data = Vec::new();
        for (block, length) in lengths.into_iter().enumerate() {
            // The last block may be a shorter one.
            let size = if block + 1 == blocks && last > 0 { last } else { size };
            let packed = self.take(length).ok_or(CUT)?;
            let before = data.len();
            let limit = (size as u64).saturating_add(1);
            let read = ZlibDecoder::new(packed.as_slice()).take(limit).read_to_end(&mut data);
            if read.is_err() || data.len() - before != size {
                return Err("its data are not what zlib makes of as many bytes as its header states");
            }
        }
        Ok(data)
    }
}

// Decodes the next four characters; a group that is filled up with = ends a run of bytes, and others may follow.
fn group(text: &mut &[u8], decoded: &mut Vec<u8>) -> Option<()> {
    let (mut word, mut characters, mut bytes) = (0_u32, 0, 3_usize);
    while characters < 4 {
        let (&character, rest) = text.split_first()?;
        *text = rest;
        let value = match character {
            b'A'..=b'Z' => character - b'A',
            b'a'..=b'z' => character - b'a' + 26,
            b'0'..=b'9' => character - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            b'=' if characters >= 2 => {
                bytes -= 1;
                0
            }
            _ if character.is_ascii_whitespace() => continue,
            _ => return None,
        };
        // Nothing follows the filling.
        if bytes < 3 && character != b'=' {
            return None;
        }
        word = word << 6 | u32::from(value);
        characters += 1;
    }
    decoded.extend(&word.to_be_bytes()[1..=bytes]);
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    // RFC 4648, section 10; runs that follow each other; white space.
    #[test]
    fn base64_is_decoded_run_by_run() {
        let take = |text: &str, count: usize| Source::Text(text.as_bytes(), Vec::new()).take(count);
        for (text, plain) in [("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYmE=", "fooba")] {
            assert_eq!(take(text, plain.len()).as_deref(), Some(plain.as_bytes()));
            assert_eq!(take(text, plain.len() + 1), None);
        }
        assert_eq!(take("Zg==\n Zm 8=", 3).as_deref(), Some(&b"ffo"[..]));
        for wrong in ["Zm9", "Z===", "Zg=a", "Zm9!"] {
            assert_eq!(take(wrong, 1), None, "{wrong}");
        }
    }
}
