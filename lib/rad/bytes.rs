//! Any bytes as text and back: scene files are not always UTF-8, and none of their bytes may be lost.
//!
//! A byte that is not part of valid UTF-8 becomes one character of a private range (U+10FF00 + byte). Text that already
//! holds such characters is taken apart into bytes the same way, so that [`encode`] undoes [`decode`] for every input.

const PRIVATE: u32 = 0x10FF00;

/// The text of `bytes`.
pub fn decode(bytes: Vec<u8>) -> String {
    match String::from_utf8(bytes) {
        Ok(text) if !text.bytes().any(|b| b == 0xF4) || !text.chars().any(|c| stray(c).is_some()) => text,
        Ok(text) => escape(text.as_bytes()),
        Err(error) => escape(error.as_bytes()),
    }
}

/// The bytes that [`decode`] made `text` of.
pub fn encode(text: &str) -> Vec<u8> {
    // Private characters begin with this byte.
    if !text.as_bytes().contains(&0xF4) {
        return text.as_bytes().to_vec();
    }
    let mut bytes = Vec::with_capacity(text.len());
    for c in text.chars() {
        match stray(c) {
            Some(byte) => bytes.push(byte),
            None => bytes.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes()),
        }
    }
    bytes
}

/// The text for a reader who wants UTF-8 alone: bytes that are none are taken for Latin-1.
pub fn readable(text: &str) -> String {
    text.chars().map(|c| stray(c).map_or(c, char::from)).collect()
}

/// How many bytes the character stands for.
pub fn width(c: char) -> usize {
    if stray(c).is_some() { 1 } else { c.len_utf8() }
}

fn stray(c: char) -> Option<u8> {
    (c as u32).checked_sub(PRIVATE).and_then(|b| u8::try_from(b).ok()).filter(|&b| b >= 0x80)
}

fn escape(bytes: &[u8]) -> String {
    let private = |b: &u8| char::from_u32(PRIVATE + u32::from(*b)).unwrap_or('\u{FFFD}');
    let mut text = String::with_capacity(bytes.len() + 16);
    for chunk in bytes.utf8_chunks() {
        for c in chunk.valid().chars() {
            match stray(c) {
                Some(_) => text.extend(c.encode_utf8(&mut [0; 4]).as_bytes().iter().map(private)),
                None => text.push(c),
            }
        }
        text.extend(chunk.invalid().iter().map(private));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_bytes_survive(bytes: Vec<u8>) {
            prop_assert_eq!(encode(&decode(bytes.clone())), bytes);
        }
    }

    #[test]
    fn what_is_no_utf_8_reads_as_latin_1() {
        assert_eq!(readable(&decode(b"caf\xe9 \xc3\xa9".to_vec())), "café é");
    }

    #[test]
    fn latin_1_and_private_characters_survive() {
        for bytes in [b"caf\xe9 \xff".to_vec(), "\u{10FF80}é\u{10FFFF}".as_bytes().to_vec()] {
            assert_eq!(encode(&decode(bytes.clone())), bytes);
        }
    }
}
