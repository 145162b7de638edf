//! Recognises what the bytes of a file are, and decodes those that are text.
//!
//! People pass other files than G-code: packed or binary G-code, meshes, web pages.
//! Their bytes would be read as a program without a motion, so they are recognised by their first
//! bytes and refused by name.

use std::borrow::Cow;

use thiserror::Error;

/// Why bytes are not the text of a G-code file.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum EncodingError {
    /// The file has another format.
    #[error("{format} is not plain G-code text; {help}")]
    Format {
        /// Name of the format.
        format: &'static str,
        /// How to get a readable file.
        help: &'static str,
    },
    /// A text in UTF-16 ends within a character.
    #[error("text in UTF-16 has an odd number of bytes ({bytes}): its end is missing")]
    OddLength {
        /// Number of bytes.
        bytes: usize,
    },
    /// A zero byte, which no text contains.
    #[error(
        "line {line}: byte {offset} of the file is zero: the file is binary, or its contents are \
         damaged"
    )]
    ZeroByte {
        /// Offset in the file, from 0.
        offset: usize,
        /// Number of the line, from 1.
        line: usize,
    },
}

/// Magic bytes, the format that they begin, and what helps.
const MAGIC: [(&[u8], &str, &str); 13] = [
    (b"GCDE", "binary G-code (.bgcode)", "export it as text (.gcode), or convert it"),
    (&[0x1f, 0x8b], "a gzip archive", "unpack it first"),
    (b"PK\x03\x04", "a ZIP archive (.zip, .3mf, .ufp)", "unpack the G-code in it first"),
    (b"PK\x05\x06", "an empty ZIP archive", "export the G-code again"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", "unpack it first"),
    (b"BZh", "a bzip2 archive", "unpack it first"),
    (&[0xfd, b'7', b'z', b'X', b'Z', 0], "an xz archive", "unpack it first"),
    (&[0x28, 0xb5, 0x2f, 0xfd], "a Zstandard archive", "unpack it first"),
    (b"\x89PNG", "a PNG picture", "name a G-code file"),
    (&[0xff, 0xd8, 0xff], "a JPEG picture", "name a G-code file"),
    (b"%PDF", "a PDF document", "name a G-code file"),
    (&[0xff, 0xfe, 0, 0], "text in UTF-32", "save it as UTF-8"),
    (&[0, 0, 0xfe, 0xff], "text in UTF-32", "save it as UTF-8"),
];

/// Bytes at the beginning of a file that show what it is.
const PROBE: usize = 1 << 10;

/// Bytes before the triangles of a binary STL file, and bytes per triangle.
const STL_HEADER: usize = 84;
const STL_RECORD: usize = 50;

/// Decodes the bytes of a file; returns text with line feeds at the ends of lines.
///
/// Reads UTF-8 and UTF-16, the latter with or without a byte order mark.
/// Bytes that are not UTF-8 become replacement characters: comments may be in any encoding.
/// Carriage returns end lines too, as firmware reads them.
pub(crate) fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, EncodingError> {
    refuse_other_formats(bytes)?;
    let text = match utf16(bytes) {
        Some(big_endian) => Cow::Owned(decode_utf16(bytes, big_endian)?),
        None => String::from_utf8_lossy(bytes),
    };
    if let Some(offset) = text.find('\0') {
        let line = 1 + text[..offset].bytes().filter(|&byte| byte == b'\n').count();
        return Err(EncodingError::ZeroByte { offset, line });
    }
    let text = match text {
        // A byte order mark is not text.
        Cow::Borrowed(text) => Cow::Borrowed(text.strip_prefix('\u{feff}').unwrap_or(text)),
        Cow::Owned(text) => match text.strip_prefix('\u{feff}') {
            Some(rest) => Cow::Owned(rest.to_owned()),
            None => Cow::Owned(text),
        },
    };
    Ok(with_line_feeds(text))
}

fn refuse_other_formats(bytes: &[u8]) -> Result<(), EncodingError> {
    for (magic, format, help) in MAGIC {
        if bytes.starts_with(magic) {
            return Err(EncodingError::Format { format, help });
        }
    }
    let start = &bytes[..bytes.len().min(PROBE)];
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start).trim_ascii_start();
    let starts =
        |word: &[u8]| start.len() >= word.len() && start[..word.len()].eq_ignore_ascii_case(word);
    let contains =
        |word: &[u8]| start.windows(word.len()).any(|window| window.eq_ignore_ascii_case(word));
    let mesh = "name it as the part, and the G-code with --gcode";
    if is_binary_stl(bytes) || starts(b"solid") && contains(b"facet") {
        return Err(EncodingError::Format { format: "an STL mesh", help: mesh });
    }
    let is_vertex = |line: &&[u8]| {
        line.strip_prefix(b"v ")
            .is_some_and(|rest| rest.iter().all(|byte| b" +-.0123456789eE\r".contains(byte)))
    };
    let is_obj = start.split(|&byte| byte == b'\n').filter(is_vertex).count() >= 3;
    if is_obj {
        return Err(EncodingError::Format { format: "an OBJ mesh", help: mesh });
    }
    if starts(b"<") {
        return Err(EncodingError::Format {
            format: "an XML or HTML document",
            help: "name a G-code file",
        });
    }
    Ok(())
}

/// Whether the number of triangles in the header fits the length of the file.
fn is_binary_stl(bytes: &[u8]) -> bool {
    bytes.get(STL_HEADER - 4..STL_HEADER).is_some_and(|count| {
        let count = u32::from_le_bytes([count[0], count[1], count[2], count[3]]);
        let length = (count as usize).checked_mul(STL_RECORD).map(|length| length + STL_HEADER);
        count > 0 && length == Some(bytes.len())
    })
}

/// Whether bytes are text in UTF-16, and then whether it is big-endian.
///
/// Without a byte order mark, it shows in the zero bytes: G-code is ASCII apart from comments, so
/// nearly every second byte is zero.
fn utf16(bytes: &[u8]) -> Option<bool> {
    match bytes {
        [0xff, 0xfe, ..] => return Some(false),
        [0xfe, 0xff, ..] => return Some(true),
        _ => {}
    }
    let start = &bytes[..bytes.len().min(PROBE) / 2 * 2];
    let zeros = |parity: usize| start.iter().skip(parity).step_by(2).filter(|&&b| b == 0).count();
    let (high, low) = (zeros(0), zeros(1));
    let mostly = |count: usize| start.len() >= 4 && count * 2 * 10 >= start.len() * 9;
    match (mostly(high) && low == 0, mostly(low) && high == 0) {
        (true, _) => Some(true),
        (_, true) => Some(false),
        _ => None,
    }
}

fn decode_utf16(bytes: &[u8], big_endian: bool) -> Result<String, EncodingError> {
    if !bytes.len().is_multiple_of(2) {
        return Err(EncodingError::OddLength { bytes: bytes.len() });
    }
    let unit = if big_endian { u16::from_be_bytes } else { u16::from_le_bytes };
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    let replaced = char::decode_utf16(units);
    Ok(replaced.map(|read| read.unwrap_or(char::REPLACEMENT_CHARACTER)).collect())
}

/// Replaces carriage returns that end lines by line feeds; one or more before a line feed stay.
fn with_line_feeds(text: Cow<'_, str>) -> Cow<'_, str> {
    let ends_line = |at: usize| !matches!(text.as_bytes().get(at + 1), Some(b'\r' | b'\n') | None);
    let lone = |at: &usize| text.as_bytes()[*at] == b'\r' && ends_line(*at);
    if !(0..text.len()).any(|at| lone(&at)) {
        return text;
    }
    // The character after the last of several carriage returns decides whether they end one line or
    // several.
    let mut fed = String::with_capacity(text.len());
    let mut rest = &*text;
    while let Some(at) = rest.find('\r') {
        let returns = rest[at..].bytes().take_while(|&byte| byte == b'\r').count();
        fed.push_str(&rest[..at]);
        rest = &rest[at + returns..];
        if !rest.starts_with('\n') {
            fed.extend(std::iter::repeat_n('\n', returns));
        }
    }
    fed.push_str(rest);
    Cow::Owned(fed)
}

#[cfg(test)]
mod tests;
