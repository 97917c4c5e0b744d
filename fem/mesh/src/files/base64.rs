//! Bytes as base64 (RFC 4648, section 4): arrays in XML files, pictures inside SVG files.

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Appends the bytes in base64, filled up with `=` to whole groups of four characters.
pub fn append(text: &mut String, bytes: &[u8]) {
    text.reserve(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let mut word = [0; 4];
        word[1..][..group.len()].copy_from_slice(group);
        let word = u32::from_be_bytes(word);
        let characters = [18, 12, 6, 0].map(|shift| ALPHABET[(word >> shift & 63) as usize]);
        text.extend(characters[..=group.len()].iter().map(|&character| char::from(character)));
        text.push_str(&"=="[..3 - group.len()]);
    }
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
