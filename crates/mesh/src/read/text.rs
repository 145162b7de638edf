//! Encodings, lines, words and numbers of text formats.

use std::borrow::Cow;

use super::error::ReadError;

/// Characters of a malformed word that an error shows.
const SHOWN_CHARS: usize = 20;

/// The bytes of a text without a byte order mark, converted to UTF-8 if they are UTF-16.
///
/// UTF-16 without a mark is recognised by the zero bytes of its first two characters.
pub(super) fn decoded(bytes: &[u8]) -> Cow<'_, [u8]> {
    let unit: fn([u8; 2]) -> u16 = match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => return Cow::Borrowed(rest),
        [0xff, 0xfe, ..] | [1..=255, 0, 1..=255, 0, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] | [0, 1..=255, 0, 1..=255, ..] => u16::from_be_bytes,
        _ => return Cow::Borrowed(bytes),
    };
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    let text = char::decode_utf16(units).map(|char| char.unwrap_or(char::REPLACEMENT_CHARACTER));
    Cow::Owned(text.skip_while(|&char| char == '\u{feff}').collect::<String>().into_bytes())
}

/// A text as UTF-8; one that is not UTF-8 is taken as Latin-1, so that different names stay
/// different.
pub(super) fn to_utf8(bytes: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()),
    }
}

/// The lines of a text, which end in LF, CR LF or CR: offset of the line in bytes, and its content
/// without the end.
pub(super) fn lines(bytes: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let mut start = 0;
    std::iter::from_fn(move || {
        let rest = bytes.get(start..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|&byte| byte == b'\n' || byte == b'\r');
        let length = length.unwrap_or(rest.len());
        let line = (start, &rest[..length]);
        start += length + if rest[length..].starts_with(b"\r\n") { 2 } else { 1 };
        Some(line)
    })
}

/// The words of a text, and the number of the line that each is on.
/// Words are separated by blanks and control characters.
#[derive(Clone)]
pub(super) struct Words<'a> {
    bytes: &'a [u8],
    position: usize,
    line: usize,
}

impl<'a> Words<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, position: 0, line: 1 }
    }

    /// Number of the current line, from 1.
    pub(super) fn line(&self) -> usize {
        self.line
    }

    /// Offset in bytes.
    pub(super) fn position(&self) -> usize {
        self.position
    }

    /// The next word.
    pub(super) fn next(&mut self) -> Option<&'a str> {
        while let Some(&byte) = self.bytes.get(self.position) {
            if byte > b' ' {
                return self.next_on_line();
            }
            self.position += 1;
            let ends_line =
                byte == b'\n' || byte == b'\r' && self.bytes.get(self.position) != Some(&b'\n');
            self.line += usize::from(ends_line);
        }
        None
    }

    /// The next word of the current line.
    pub(super) fn next_on_line(&mut self) -> Option<&'a str> {
        let rest = &self.bytes[self.position..];
        let is_blank = |&byte: &u8| byte <= b' ' && byte != b'\n' && byte != b'\r';
        let start = rest.iter().position(|byte| !is_blank(byte))?;
        let word = &rest[start..];
        let length = word.iter().position(|&byte| byte <= b' ').unwrap_or(word.len());
        if length == 0 {
            return None;
        }
        self.position += start + length;
        Some(std::str::from_utf8(&word[..length]).unwrap_or("\u{fffd}"))
    }

    /// The next word of the current line, which stays the next one.
    pub(super) fn peek_on_line(&self) -> Option<&'a str> {
        self.clone().next_on_line()
    }
}

/// Reads the next three words as coordinates; `line` is the number of their line.
pub(super) fn point<'a>(
    line: usize,
    words: impl Iterator<Item = &'a str>,
) -> Result<[f64; 3], ReadError> {
    let mut point = [0.0; 3];
    let mut count = 0;
    for word in words.take(3) {
        point[count] = number(word).map_err(|message| ReadError::line(line, message))?;
        count += 1;
    }
    if count < 3 {
        let message = format!("vertex has {count} coordinates, expected 3");
        return Err(ReadError::line(line, message));
    }
    Ok(point)
}

/// Reads a finite number; the error describes what is wrong.
pub(super) fn number(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!("'{}' is not a finite number", shown(word))),
        Err(_) => Err(format!("'{}' is not a number", shown(word))),
    }
}

/// The beginning of a word, for an error message.
pub(super) fn shown(word: &str) -> String {
    word.chars().take(SHOWN_CHARS).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_are_recognised() {
        let utf16 = |unit: fn(u16) -> [u8; 2]| -> Vec<u8> {
            "\u{feff}v ü 𝄞".encode_utf16().flat_map(unit).collect()
        };
        let unmarked = |unit: fn(u16) -> [u8; 2]| utf16(unit)[2..].to_vec();
        for bytes in [
            "v ü 𝄞".as_bytes().to_vec(),
            "\u{feff}v ü 𝄞".as_bytes().to_vec(),
            utf16(u16::to_le_bytes),
            utf16(u16::to_be_bytes),
            unmarked(u16::to_le_bytes),
            unmarked(u16::to_be_bytes),
        ] {
            assert_eq!(decoded(&bytes), "v ü 𝄞".as_bytes());
        }
    }

    #[test]
    fn lines_end_in_any_way() {
        let found: Vec<_> = lines(b"a\nb\r\n\rc\r").collect();
        let expected: [(usize, &[u8]); 4] = [(0, b"a"), (2, b"b"), (5, b""), (6, b"c")];
        assert_eq!(found, expected);
    }

    #[test]
    fn words_have_the_numbers_of_their_lines() {
        for end in ["\n", "\r\n", "\r"] {
            let text = format!("a  b{end}{end} c\0{end}\u{1a}");
            let mut words = Words::new(text.as_bytes());
            assert_eq!((words.next(), words.line()), (Some("a"), 1));
            assert_eq!(words.peek_on_line(), Some("b"));
            assert_eq!(words.next_on_line(), Some("b"));
            assert_eq!((words.peek_on_line(), words.next_on_line()), (None, None));
            assert_eq!((words.next(), words.line()), (Some("c"), 3));
            assert_eq!(words.next(), None);
        }
    }
}
