//! Bytes as base64 (RFC 4648, section 4): arrays in XML files, pictures inside SVG files.

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Base64 of the bytes, appended to a text and filled up with `=` to whole groups of four characters.
pub fn append(text: &mut String, bytes: &[u8]) {
    text.reserve(bytes.len().div_ceil(3) * 4);
    // Characters are gathered before they are appended, because each call checks the room that is left.
    let mut line = [0_u8; 4 * GROUPS];
    for block in bytes.chunks(3 * GROUPS) {
        let groups = block.chunks_exact(3);
        let rest = groups.remainder();
        let mut length = 0;
        for (group, characters) in groups.zip(line.chunks_exact_mut(4)) {
            characters.copy_from_slice(&coded([group[0], group[1], group[2]]));
            length += 4;
        }
        if !rest.is_empty() {
            let mut group = [0; 3];
            group[..rest.len()].copy_from_slice(rest);
            let mut characters = coded(group);
            characters[rest.len() + 1..].fill(b'=');
            line[length..length + 4].copy_from_slice(&characters);
            length += 4;
        }
        text.extend(std::str::from_utf8(&line[..length]));
    }
}

/// Groups of three bytes that are coded at once.
const GROUPS: usize = 256;

/// Three bytes as four characters.
fn coded(group: [u8; 3]) -> [u8; 4] {
    let word = u32::from_be_bytes([0, group[0], group[1], group[2]]);
    [18, 12, 6, 0].map(|shift| ALPHABET[(word >> shift & 63) as usize])
}

#[cfg(test)]
mod tests {
    // RFC 4648, section 10; all 64 characters.
    #[test]
    fn groups_are_filled_up() {
        let plain = ["", "f", "fo", "foo", "foob", "fooba", "foobar"];
        let coded = ["", "Zg==", "Zm8=", "Zm9v", "Zm9vYg==", "Zm9vYmE=", "Zm9vYmFy"];
        for (plain, coded) in plain.iter().zip(coded) {
            let mut text = ">".to_owned();
            super::append(&mut text, plain.as_bytes());
            assert_eq!(text, format!(">{coded}"));
        }
        // Each group of 24 bits holds four numbers of six bits, from 0 to 63.
        let word = |k: u32| [0, 1, 2, 3].iter().fold(0, |word, j| word << 6 | (4 * k + j));
        let numbers: Vec<u8> = (0..16).flat_map(|k| word(k).to_be_bytes().into_iter().skip(1)).collect();
        let mut text = String::new();
        super::append(&mut text, &numbers);
        assert_eq!(text.as_bytes(), super::ALPHABET);
    }
}
