//! Random changes of bytes.

use rand::RngExt;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Text that may break readers: limits of number ranges, and characters with a special meaning.
const TEXTS: [&[u8]; 64] = [
    b"0",
    b"9",
    b"-",
    b"-0",
    b"e",
    b".",
    b"nan",
    b"inf",
    b"-inf",
    b"1e308",
    b"-1e308",
    b"1e-320",
    b"1e39",
    b"1e400",
    b"255",
    b"256",
    b"65536",
    b"4294967295",
    b"4294967296",
    b"9223372036854775807",
    b"-9223372036854775808",
    b"9223372036854.775807",
    b"1000000000",
    b"0.0000005",
    b" ",
    b"\n",
    b"\r",
    b"\r\n",
    b"\t",
    b"\0",
    b"\xff",
    b"\xc3\xa9",
    b"\xef\xbb\xbf",
    b"\xc2\xa0",
    b"\\",
    b"\\\n",
    b"/",
    b"//",
    b"#",
    b";",
    b"(",
    b")",
    b"*",
    b"N1 ",
    b"<",
    b">",
    b"/>",
    b"</",
    b"\"",
    b"'",
    b"&",
    b"&amp;",
    b"&#x110000;",
    b"<!--",
    b"<![CDATA[",
    b"<?",
    b"=",
    b"endsolid\n",
    b"solid\n",
    b"G91\n",
    b"G92\n",
    b"M82\n",
    b"G2 I1\n",
    b"T1\n",
];

/// Critical values of little-endian numbers of four bytes: counts, indices, and floats.
const WORDS: [u32; 10] = [
    0,
    1,
    0xff,
    0xffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7f80_0000,
    0x7fc0_0000,
    0x7f7f_ffff,
];

/// A copy with one to eight changes.
pub(crate) fn changed(bytes: &[u8], rng: &mut Xoshiro256PlusPlus) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    // Mostly few changes, so that many files are read completely and reach later steps.
    let most = [1, 1, 2, 8][rng.random_range(0..4_usize)];
    for _ in 0..rng.random_range(1..=most) {
        change(&mut bytes, rng);
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, rng: &mut Xoshiro256PlusPlus) {
    if bytes.is_empty() {
        bytes.push(rng.random());
        return;
    }
    let at = rng.random_range(0..bytes.len());
    // Mostly short: after a long change, little of the file is left to read.
    let longest = [4, 16, 64, 4096][rng.random_range(0..4_usize)];
    let end = bytes.len().min(at + rng.random_range(1..=longest));
    let text = TEXTS[rng.random_range(0..TEXTS.len())];
    match rng.random_range(0..48) {
        0..4 => bytes[at] = rng.random(),
        4..8 => bytes[at] ^= 1 << rng.random_range(0..8),
        8..12 => drop(bytes.splice(at..at, text.iter().copied())),
        12..15 => drop(bytes.splice(at..(at + text.len()).min(bytes.len()), text.iter().copied())),
        15..18 => drop(bytes.drain(at..end)),
        18..21 => {
            let again = bytes[at..end].to_vec();
            let to = rng.random_range(0..=bytes.len());
            bytes.splice(to..to, again);
        }
        21..23 => {
            let other = rng.random_range(0..bytes.len());
            for step in 0..(end - at).min(bytes.len() - other) {
                bytes.swap(at + step, other + step);
            }
        }
        23..25 => {
            let word = WORDS[rng.random_range(0..WORDS.len())].to_le_bytes();
            bytes.iter_mut().skip(at).zip(word).for_each(|(byte, new)| *byte = new);
        }
        25..31 => {
            // Replaces the next number.
            let is_part = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'-' | b'.');
            let from = bytes[at..].iter().position(is_part).map_or(at, |skip| at + skip);
            let length = bytes[from..].iter().take_while(|byte| is_part(byte)).count();
            let number = TEXTS[rng.random_range(0..24_usize)];
            bytes.splice(from..from + length, number.iter().copied());
        }
        31..47 => {
            // Another digit: the syntax stays valid, the meaning changes.
            let digit =
                bytes[at..].iter().position(u8::is_ascii_digit).map_or(at, |skip| at + skip);
            bytes[digit] = b'0' + rng.random_range(0..10_u8);
        }
        _ => bytes.truncate(at),
    }
}
