//! Recognises files whose content is not of the format that their name says.

use super::text::{Words, decoded};

/// Text is searched for keywords in this many bytes.
const SEARCHED_BYTES: usize = 4096;

/// First bytes of binary formats, and what they are.
const SIGNATURES: [(&[u8], &str); 9] = [
    (b"PK\x03\x04", "a ZIP archive, such as 3MF"),
    (b"GCDE", "binary G-code"),
    (b"\x1f\x8b", "a gzip archive"),
    (b"\x89PNG", "a PNG image"),
    (b"ply\n", "a PLY mesh"),
    (b"ply\r", "a PLY mesh"),
    (b"glTF", "a glTF model"),
    (b"ISO-10303-21", "a STEP model"),
    (b"%PDF", "a PDF document"),
];

/// What the content of a file is, with an article, if that can be said for sure.
pub(super) fn recognise(bytes: &[u8]) -> Option<&'static str> {
    let found = SIGNATURES.iter().find(|(signature, _)| bytes.starts_with(signature));
    if let Some(&(_, what)) = found {
        return Some(what);
    }
    if is_binary_stl(bytes) {
        return Some("an STL mesh");
    }
    let text = decoded(&bytes[..bytes.len().min(SEARCHED_BYTES)]);
    // Binary files contain control characters.
    if text.iter().any(|&byte| byte < b' ' && !byte.is_ascii_whitespace()) {
        return None;
    }
    let trimmed = text.trim_ascii_start();
    if trimmed.starts_with(b"<") {
        return Some("XML or HTML");
    }
    let mut words = Words::new(&text);
    let first = words.next()?;
    if first.eq_ignore_ascii_case("solid") && contains(&text, b"facet") {
        return Some("an STL mesh");
    }
    // The first words of lines that only one format has.
    let mut counts = [0_usize; 2];
    for (_, line) in super::text::lines(&text) {
        let mut words = Words::new(line);
        let (Some(word), Some(next)) = (words.next(), words.next()) else { continue };
        let is_number = next.parse::<f64>().is_ok();
        counts[0] += usize::from(matches!(word, "v" | "vn") && is_number);
        let number = word.strip_prefix(['G', 'M']);
        let is_command =
            number.is_some_and(|digits| digits.len() <= 3 && digits.parse::<u32>().is_ok());
        counts[1] += usize::from(is_command);
    }
    match counts {
        [vertices, _] if vertices >= 3 => Some("an OBJ mesh"),
        [_, commands] if commands >= 3 => Some("G-code"),
        _ => None,
    }
}

/// Whether the number of triangles in the header fits the length of the file.
fn is_binary_stl(bytes: &[u8]) -> bool {
    let Some((header, triangles)) = bytes.split_at_checked(84) else { return false };
    let count = header[80..].try_into().map_or(0, u32::from_le_bytes);
    count > 0 && triangles.len() as u64 == 50 * u64::from(count)
}

fn contains(text: &[u8], word: &[u8]) -> bool {
    text.windows(word.len()).any(|window| window.eq_ignore_ascii_case(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_is_recognised() {
        let obj = "# a comment\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let stl = "Solid x\nfacet normal 0 0 1\n";
        let gcode = "; made by hand\nG28\nG1 X1\nM104 S215\nG1 Y2\nG1 X3\n";
        let cases: [(&[u8], Option<&str>); 8] = [
            (obj.as_bytes(), Some("an OBJ mesh")),
            (stl.as_bytes(), Some("an STL mesh")),
            (gcode.as_bytes(), Some("G-code")),
            (b"PK\x03\x04...", Some("a ZIP archive, such as 3MF")),
            (b"<?xml version=\"1.0\"?>", Some("XML or HTML")),
            (b"the cat sat on the mat", None),
            (b"solid in the header of a binary file\0\0\0", None),
            (b"", None),
        ];
        let stl: Vec<u8> = [&[b' '; 80][..], &2_u32.to_le_bytes(), &[0; 100]].concat();
        assert_eq!(recognise(&stl), Some("an STL mesh"));
        for (bytes, expected) in cases {
            assert_eq!(recognise(bytes), expected);
        }
    }
}
