//! Splits the text of a verbatim command into single codes.
//!
//! A line may hold several commands (`G90 G21 M83`), as in the standard NIST RS274/NGC and in
//! RepRapFirmware; Marlin and Klipper read only the first.
//! The codes of a line are executed from left to right.

use std::fmt;

use crate::words::is_blank;

/// The name of a code, such as `G92.1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CodeName {
    /// `G`, `M` or `T`.
    pub letter: char,
    /// Number without its decimals.
    pub number: u32,
    /// Decimals of the number; 0 if there are none.
    pub decimals: u32,
}

impl fmt::Display for CodeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { letter, number, decimals } = self;
        if *decimals > 0 {
            write!(f, "{letter}{number}.{decimals}")
        } else {
            write!(f, "{letter}{number}")
        }
    }
}

/// One command of a line: its name and the text of its words.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Code<'a> {
    pub(crate) name: CodeName,
    /// The whole text, such as `G92.1 X0`.
    pub(crate) text: &'a str,
    /// The text after the number.
    pub(crate) words: &'a str,
}

/// M-codes whose words are free text, such as messages and file names.
const TEXT_CODES: [u32; 27] = [
    0, 1, 16, 20, 23, 28, 30, 32, 33, 36, 37, 38, 98, 117, 118, 291, 408, 471, 472, 505, 550, 587,
    588, 589, 808, 928, 997,
];

/// First and last of the codes that store the rest of their line as a macro (Marlin).
const MACRO_CODES: std::ops::RangeInclusive<u32> = 810..=819;

/// G- and M-codes after which `T` and a number begin a tool change; in others it is a word.
const PLAIN_G: [u32; 17] = [0, 1, 2, 3, 4, 17, 18, 19, 20, 21, 28, 53, 54, 90, 91, 92, 94];
const PLAIN_M: [u32; 14] = [2, 3, 5, 7, 8, 9, 17, 18, 73, 82, 83, 84, 220, 400];

impl<'a> Code<'a> {
    /// Splits a text after its first code; returns the code and the rest.
    /// `None` if the text does not begin with one: it is a macro, or words without a code.
    pub(crate) fn first(text: &'a str) -> Option<(Self, &'a str)> {
        let text = after_comments(text);
        let (name, words) = name_and_rest(text)?;
        let begin = text.len() - words.len();
        let end = begin + words_length(name, words);
        let (code, rest) = text.split_at(end);
        let code = code.trim_end_matches(is_blank);
        let words = code.get(begin..).unwrap_or("");
        Some((Self { name, text: code, words }, after_comments(rest)))
    }
}

/// Splits words that have no code, such as `X5 E1`, from a code that follows on the same line.
/// `None` if the text begins with another letter than those of moves, or without a number.
pub(crate) fn words_without_code(text: &str) -> Option<(&str, &str)> {
    let text = after_comments(text);
    let letter = text.chars().next()?.to_ascii_uppercase();
    let value = text[letter.len_utf8()..].trim_start_matches(is_blank);
    let has_number = value.starts_with(|next: char| next.is_ascii_digit() || "+-.".contains(next));
    let g1 = CodeName { letter: 'G', number: 1, decimals: 0 };
    (MOVE_LETTERS.contains(letter) && has_number).then(|| text.split_at(words_length(g1, text)))
}

/// Letters of the words of moves.
const MOVE_LETTERS: &str = "XYZEFIJKR";

/// Removes blanks and comments in parentheses before a text.
fn after_comments(mut text: &str) -> &str {
    loop {
        text = text.trim_start_matches(is_blank);
        if !text.starts_with('(') {
            return text;
        }
        text = text.split_once(')').map_or("", |(_, rest)| rest);
    }
}

/// The name of the code that a text begins with, and the text after it.
fn name_and_rest(text: &str) -> Option<(CodeName, &str)> {
    let letter = char::from(text.as_bytes().first()?.to_ascii_uppercase());
    if !matches!(letter, 'G' | 'M' | 'T') {
        return None;
    }
    let rest = text[1..].trim_start_matches(is_blank);
    let digits = digits(rest);
    let number = rest[..digits].parse().ok()?;
    let mut rest = &rest[digits..];
    let mut decimals = 0;
    if let Some(after) = rest.strip_prefix('.') {
        let digits = self::digits(after);
        decimals = if digits > 0 { after[..digits].parse().ok()? } else { 0 };
        rest = &after[digits..];
    }
    let ends = |next: char| is_blank(next) || next.is_ascii_alphabetic() || "(\"{*".contains(next);
    let name = CodeName { letter, number, decimals };
    (rest.is_empty() || rest.starts_with(ends)).then_some((name, rest))
}

/// Length of the words of a code: up to the next code, or to the end if they are free text.
fn words_length(name: CodeName, words: &str) -> usize {
    let CodeName { letter, number, .. } = name;
    let is_text = TEXT_CODES.contains(&number) || MACRO_CODES.contains(&number);
    if letter == 'M' && is_text {
        return words.len();
    }
    let has_tool_word = match letter {
        'G' => !PLAIN_G.contains(&number),
        'M' => !PLAIN_M.contains(&number),
        _ => false,
    };
    let mut rest = words;
    loop {
        rest = after_comments(rest);
        let Some(first) = rest.chars().next() else { return words.len() };
        let closing = match first {
            '"' => Some('"'),
            '{' => Some('}'),
            '[' => Some(']'),
            _ => None,
        };
        if let Some(closing) = closing {
            let Some((_, after)) = rest[1..].split_once(closing) else { return words.len() };
            rest = after;
            continue;
        }
        if !first.is_ascii_alphabetic() {
            // Free text, or an expression.
            return words.len();
        }
        let begins_code = match first.to_ascii_uppercase() {
            'G' | 'M' => name_and_rest(rest).is_some(),
            'T' => !has_tool_word && name_and_rest(rest).is_some(),
            _ => false,
        };
        if begins_code {
            return words.len() - rest.len();
        }
        let value = rest[1..].trim_start_matches(is_blank);
        let number = value.bytes().take_while(|byte| b"+-.0123456789:".contains(byte)).count();
        if number > 0 {
            rest = &value[number..];
        } else if rest[1..].starts_with(|next: char| next.is_ascii_alphabetic() || next == '_') {
            // Two letters side by side: a name or a message.
            return words.len();
        } else {
            rest = &rest[1..];
        }
    }
}

fn digits(text: &str) -> usize {
    text.bytes().take_while(u8::is_ascii_digit).count()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn split(mut text: &str) -> Vec<&str> {
        let mut codes = Vec::new();
        while let Some((code, rest)) = Code::first(text) {
            codes.push(code.text);
            text = rest;
        }
        codes
    }

    #[test]
    fn codes_of_a_line() {
        for (text, codes) in [
            ("G90 G21 M83", &["G90", "G21", "M83"][..]),
            ("g90g21m83", &["g90", "g21", "m83"]),
            ("G20 (Units: Inches)", &["G20 (Units: Inches)"]),
            ("G92.1 X0 G1 X5", &["G92.1 X0", "G1 X5"]),
            ("T0 S1 L0 D0", &["T0 S1 L0 D0"]),
            ("T1 M6", &["T1", "M6"]),
            ("M6 T1", &["M6 T1"]),
            ("G 1 X 5 T 1", &["G 1 X 5", "T 1"]),
            ("M104 S200 T1 G28", &["M104 S200 T1", "G28"]),
            ("G29 P1 T4 V4", &["G29 P1 T4 V4"]),
            ("M117 Layer 5 of G28", &["M117 Layer 5 of G28"]),
            ("M810 G28 | G0 X10", &["M810 G28 | G0 X10"]),
            ("M486 A\"G28\" G90", &["M486 A\"G28\"", "G90"]),
            ("M42 Hello G28", &["M42 Hello G28"]),
            ("G10 P0 S{temps[0]} G91", &["G10 P0 S{temps[0]}", "G91"]),
            ("START_PRINT", &[]),
            ("G1_SLOW", &[]),
            ("T?", &[]),
            ("Tx", &[]),
            ("X5", &[]),
            ("", &[]),
        ] {
            assert_eq!(split(text), codes, "{text}");
        }
        assert_eq!(Code::first("m0862.3 P1").unwrap().0.name.to_string(), "M862.3");
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            cases: 2_000,
            failure_persistence: None,
            ..ProptestConfig::default()
        })]

        #[test]
        fn codes_do_not_get_lost(
            codes in prop::collection::vec((
                prop::sample::select(vec!["G1", "g0", "M204", "G92.1", "M83", "G90", "m104"]),
                prop::collection::vec(
                    (prop::sample::select(vec!['X', 'y', 'S', 'P', 'F']), -99..99_i32), 0..4,
                ),
            ), 1..6),
            blank in prop::sample::select(vec!["", " ", "\t"]),
        ) {
            let mut expected = Vec::new();
            for (code, words) in &codes {
                let words = words.iter().map(|(letter, value)| format!("{blank}{letter}{value}"));
                expected.push(format!("{code}{}", words.collect::<String>()));
            }
            let line = expected.join(blank);
            prop_assert_eq!(split(&line), expected);
        }

        #[test]
        fn any_text_is_split(text in "[GMTXYZ0-9.\"{}\\[\\]() _é*-]{0,60}") {
            let mut rest = &*text;
            let mut steps = 0;
            while let Some((code, after)) = Code::first(rest) {
                prop_assert!(after.len() < rest.len());
                prop_assert!(code.text.ends_with(code.words));
                (rest, steps) = (after, steps + 1);
            }
            prop_assert!(steps <= text.len());
        }
    }
}
