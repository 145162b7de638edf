//! The words of a command: a letter with a number (`X10.5`), or Klipper's `NAME=value`.

use thiserror::Error;

use crate::command::Command;
use crate::number::{Number, NumberError};

/// What is wrong with a word.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ParseFault {
    /// The text after the letter is not a number, or a number that is too large.
    #[error("is {0}")]
    Number(#[from] NumberError),
    /// It does not begin with a letter.
    #[error("is not a word of a command")]
    Word,
}

/// The text that cannot be read, and what is wrong with it.
pub(crate) type Fault<'a> = (&'a str, ParseFault);

/// Whether a character separates words.
/// A byte order mark, which may precede the first line, counts as blank; `char::is_whitespace` does
/// not include it.
pub(crate) fn is_blank(character: char) -> bool {
    character.is_whitespace() || character == '\u{feff}'
}

/// Collects the comments in parentheses of one line.
#[derive(Default)]
pub(crate) struct ParenthesisComments(pub(crate) Option<String>);

impl ParenthesisComments {
    /// Removes the comment that `text` begins with, and returns the rest.
    /// `text` begins with an opening parenthesis; a missing closing one ends the comment at the end
    /// of the line.
    pub(crate) fn take<'a>(&mut self, text: &'a str) -> &'a str {
        let (inner, rest) = text[1..].split_once(')').unwrap_or((&text[1..], ""));
        let inner = inner.trim_end_matches('\r');
        match &mut self.0 {
            Some(all) => all.extend([" ", inner]),
            None => self.0 = Some(inner.to_owned()),
        }
        rest
    }
}

/// The words of one command, by letter.
/// Of a repeated word the last one counts.
pub(crate) struct Words {
    /// One bit per letter (bit 0 is `A`): the words that are present.
    present: u32,
    /// The words that have a number.
    numbered: u32,
    values: [Number; 26],
    /// The words that the command's type can hold.
    known: u32,
    /// Whether it must hold all words of the text.
    exact: bool,
}

impl Words {
    /// Reads the text after the command's code.
    ///
    /// `known` lists the letters that the command's type can hold; each needs a number, except for
    /// those in `flags`.
    /// Other letters may have one.
    pub(crate) fn read<'a>(
        mut rest: &'a str,
        known: &str,
        flags: &str,
        exact: bool,
        comments: &mut ParenthesisComments,
    ) -> Result<Self, Fault<'a>> {
        let bits = |letters: &str| letters.bytes().fold(0, |bits, letter| bits | bit(letter));
        let (known, flags) = (bits(known), bits(flags));
        let mut words = Self { present: 0, numbered: 0, values: [Number::ZERO; 26], known, exact };
        loop {
            rest = rest.trim_start_matches(is_blank);
            let Some(&letter) = rest.as_bytes().first() else { return Ok(words) };
            if letter == b'(' {
                rest = comments.take(rest);
                continue;
            }
            let letter = letter.to_ascii_uppercase();
            if !letter.is_ascii_uppercase() {
                return Err((rest.split(is_blank).next().unwrap_or(rest), ParseFault::Word));
            }
            let value = rest[1..].trim_start_matches(is_blank);
            let first = value.as_bytes().first().copied().unwrap_or(b' ');
            words.present |= bit(letter);
            if matches!(first, b'0'..=b'9' | b'.' | b'+' | b'-') {
                let scanned = Number::scan(value.as_bytes()).and_then(|(number, length)| {
                    // The next word, a blank or a comment may follow a number; any other character
                    // means that it is malformed, such as `1.2.3`.
                    let next = value[length..].chars().next().unwrap_or(' ');
                    // In upper case, `X1e-5` is an exponent, not the words X1 and E-5.
                    let exponent = next == 'e' && rest.as_bytes()[0].is_ascii_uppercase();
                    let ends = is_blank(next) || next.is_ascii_alphabetic() || next == '(';
                    if ends && !exponent {
                        Ok((number, length))
                    } else {
                        Err(NumberError::Malformed)
                    }
                });
                let (number, length) = scanned.map_err(|error| (first_word(rest), error.into()))?;
                words.numbered |= bit(letter);
                words.values[usize::from(letter - b'A')] = number;
                rest = &value[length..];
            } else if bit(letter) & known & !flags != 0 {
                return Err((first_word(rest), NumberError::Malformed.into()));
            } else {
                rest = &rest[1..];
            }
        }
    }

    /// The number of a word, if it is present and has one.
    pub(crate) fn value(&self, letter: char) -> Option<Number> {
        let index = letter as usize - 'A' as usize;
        (self.numbered >> index & 1 == 1).then(|| self.values[index])
    }

    /// Whether a word is present, with or without a number.
    pub(crate) fn has(&self, letter: char) -> bool {
        self.present & bit(letter as u8) != 0
    }

    /// Builds a command from these words; `None` if it must hold all of them and cannot.
    pub(crate) fn only(self, command: impl FnOnce(&Self) -> Option<Command>) -> Option<Command> {
        let holds_all = self.present & !self.known == 0;
        if holds_all || !self.exact { command(&self) } else { None }
    }

    /// Builds a command from these words, which may have others that are dropped; `None` if one of
    /// `letters` is present with a number and must not be dropped.
    pub(crate) fn unless(
        self,
        letters: &str,
        command: impl FnOnce(&Self) -> Command,
    ) -> Option<Command> {
        let must_keep = self.exact && letters.chars().any(|letter| self.value(letter).is_some());
        (!must_keep).then(|| command(&self))
    }
}

fn bit(letter: u8) -> u32 {
    1 << (letter - b'A')
}

/// The letter that a text begins with and what looks like its value, for an error message.
fn first_word(text: &str) -> &str {
    let value = text[1..].trim_start_matches(is_blank);
    let length = value.find(|next| is_blank(next) || next == '(').unwrap_or(value.len());
    &text[..text.len() - value.len() + length]
}

/// Name of Klipper's command, and of its parameters that have a field in
/// [`Command::VelocityLimit`].
pub(crate) const VELOCITY_LIMIT: &str = "SET_VELOCITY_LIMIT";
pub(crate) const VELOCITY: &str = "VELOCITY";
pub(crate) const ACCELERATION: &str = "ACCEL";
pub(crate) const SQUARE_CORNER_VELOCITY: &str = "SQUARE_CORNER_VELOCITY";

/// The parameters of `SET_VELOCITY_LIMIT`.
pub(crate) struct VelocityWords {
    /// `VELOCITY`, `ACCEL` and `SQUARE_CORNER_VELOCITY`.
    pub(crate) values: [Option<Number>; 3],
    /// Whether there are parameters besides these three.
    pub(crate) has_others: bool,
}

impl VelocityWords {
    /// Reads a command; `None` if it is not `SET_VELOCITY_LIMIT`.
    pub(crate) fn read(code: &str) -> Result<Option<Self>, Fault<'_>> {
        let mut words = code.split_ascii_whitespace();
        if !words.next().is_some_and(|name| name.eq_ignore_ascii_case(VELOCITY_LIMIT)) {
            return Ok(None);
        }
        let mut read = Self { values: [None; 3], has_others: false };
        for word in words {
            let (name, value) = word.split_once('=').ok_or((word, ParseFault::Word))?;
            let known = [VELOCITY, ACCELERATION, SQUARE_CORNER_VELOCITY];
            match known.iter().position(|known| name.eq_ignore_ascii_case(known)) {
                Some(index) => {
                    read.values[index] =
                        Some(value.parse().map_err(|error| (word, ParseFault::Number(error)))?);
                }
                None => read.has_others = true,
            }
        }
        Ok(Some(read))
    }
}

/// The `ACCEL` of a `SET_VELOCITY_LIMIT` command that is kept verbatim, in mm/s².
pub(crate) fn verbatim_acceleration(code: &str) -> Option<Number> {
    VelocityWords::read(code).ok().flatten().and_then(|words| words.values[1])
}
