//! Encodings and line ends, and files that are not G-code.

use proptest::prelude::*;

use super::*;

const TEXT: &str = "; pièce\nG1 X1 E1\nG1 X2 E1\n";

fn utf16_of(text: &str, big_endian: bool) -> Vec<u8> {
    let bytes = if big_endian { u16::to_be_bytes } else { u16::to_le_bytes };
    text.encode_utf16().flat_map(bytes).collect()
}

// PowerShell's redirection writes UTF-16 with a byte order mark.
#[test]
fn utf16_is_decoded() {
    for big_endian in [false, true] {
        let plain = utf16_of(TEXT, big_endian);
        let marked = utf16_of(&format!("\u{feff}{TEXT}"), big_endian);
        assert_eq!(decode(&plain).unwrap(), TEXT);
        assert_eq!(decode(&marked).unwrap(), TEXT);
        assert_eq!(
            decode(&marked[..marked.len() - 1]),
            Err(EncodingError::OddLength { bytes: marked.len() - 1 })
        );
    }
    assert_eq!(decode(&[0xff, 0xfe, 0, 0xd8]).unwrap(), "\u{fffd}", "half of a surrogate pair");
}

#[test]
fn utf8_and_other_encodings_of_comments_are_read() {
    assert_eq!(decode(TEXT.as_bytes()).unwrap(), TEXT);
    assert_eq!(decode(format!("\u{feff}{TEXT}").as_bytes()).unwrap(), TEXT);
    assert_eq!(decode(b"; \xb0C\nG28\n").unwrap(), "; \u{fffd}C\nG28\n");
}

#[test]
fn carriage_returns_end_lines() {
    for (text, expected) in [
        ("G28\rG90\rG91", "G28\nG90\nG91"),
        ("; a\rG1 X5\nG1 X6\r\n", "; a\nG1 X5\nG1 X6\n"),
        ("G28\r\r\nG90\r\r\n", "G28\r\r\nG90\r\r\n"),
        ("G28\r\nG90\r", "G28\r\nG90\r"),
        ("G28\r\rG90", "G28\n\nG90"),
    ] {
        assert_eq!(decode(text.as_bytes()).unwrap(), expected, "{text:?}");
    }
}

// kliment/Printrun#1551
#[test]
fn other_formats_are_refused_by_name() {
    let mut stl = vec![b' '; 80];
    stl.extend(1_u32.to_le_bytes());
    stl.extend([0; 50]);
    for (bytes, name) in [
        (&b"GCDE\x01\0\0\0"[..], "binary G-code (.bgcode)"),
        (b"\x1f\x8b\x08", "gzip"),
        (b"PK\x03\x04\x14", "ZIP"),
        (b"\x89PNG\r\n", "PNG"),
        (b"solid a\nfacet normal 0 0 1\n", "STL"),
        (&stl, "STL"),
        (b"# cube\nv 0 0 0\nv 1 0 0\nv 0 1.5e-3 0\nf 1 2 3\n", "OBJ"),
        (b"<!DOCTYPE html>", "HTML"),
        (b"\xff\xfe\0\0G\0\0\0", "UTF-32"),
        (b"G1 X1\nG1 \0X2\n", "line 2: byte 9"),
        (b"G1 X1\n\0\0\0\0", "line 2: byte 6"),
    ] {
        let error = decode(bytes).unwrap_err().to_string();
        assert!(error.contains(name), "{error}");
    }
    assert!(decode(b"solid_start\nG1 X1").is_ok());
    assert!(decode(b"").is_ok());
}

proptest! {
        #![proptest_config(ProptestConfig {
            cases: 2_000,
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

    #[test]
    fn text_is_decoded_from_any_encoding(text in "[ -~äλ\n]{8,200}", big_endian: bool) {
        prop_assume!(refuse_other_formats(text.as_bytes()).is_ok());
        let expected = text.as_str();
        prop_assert_eq!(decode(expected.as_bytes()).unwrap(), expected);
        let marked = utf16_of(&format!("\u{feff}{expected}"), big_endian);
        prop_assert_eq!(decode(&marked).unwrap(), expected);
    }

    #[test]
    fn lines_end_as_in_a_slow_twin(text in "[a\r\n]{0,30}") {
        // Splits at line feeds, then at carriage returns except those before a line feed.
        let lines = text.split('\n').map(|line| line.trim_end_matches('\r'));
        let slow: Vec<String> = lines.map(|line| line.replace('\r', "\n")).collect();
        let fed = decode(text.as_bytes()).unwrap();
        let fast: Vec<&str> = fed.split('\n').map(|line| line.trim_end_matches('\r')).collect();
        let last = text.rsplit('\n').next().unwrap_or("");
        if !last.ends_with('\r') {
            prop_assert_eq!(fast.join("\n"), slow.join("\n"));
        }
    }

    #[test]
    fn any_bytes_are_decoded_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        _ = decode(&bytes);
    }
}
