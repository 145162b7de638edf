//! Reads G-code as real files have it.
//!
//! Lenient are: line breaks of both kinds, lower case, missing or additional blanks, repeated words
//! (the last one holds), line numbers and their checksums, comments in parentheses, a byte order
//! mark, and text that is not UTF-8.
//! A command that is not typed, or has words that its type does not hold, is kept word for word;
//! only those that move the head or say where it is are always typed, and lose words that are not
//! theirs: a program must not move unseen.
//! A broken number in a typed command is an error.

use thiserror::Error;

use super::command::{ACCELERATION, SQUARE_CORNER_VELOCITY, VELOCITY, VELOCITY_LIMIT};
use crate::{Arc, Command, Line, Move, Number, NumberError, Program, Verbatim, Wait};

/// A command that can't be read.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("line {line}: '{text}' {fault}")]
pub struct ParseError {
    /// Number of the line, from 1.
    pub line: usize,
    /// The word that is broken; of a long one the beginning.
    pub text: String,
    /// What is wrong with it.
    pub fault: ParseFault,
}

/// What is wrong with a word.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ParseFault {
    /// The text behind its letter is no number, or one too large.
    #[error("{0}")]
    Number(#[from] NumberError),
    /// It does not begin with a letter.
    #[error("is not a word of a command")]
    Word,
}

/// A fault with the text it lies in.
pub(super) type Broken<'a> = (&'a str, ParseFault);

/// Characters of a broken word that an error shows.
const SHOWN: usize = 32;

impl Program {
    /// Reads a file.
    /// Linear in its length; takes at most about a hundred bytes for each line and twice the text.
    pub fn parse(text: &str) -> Result<Self, ParseError> {
        // Counting first saves the half that growth would leave unused.
        let mut lines = Vec::with_capacity(text.bytes().filter(|&byte| byte == b'\n').count() + 1);
        for (number, text) in (1..).zip(text.split_inclusive('\n')) {
            let text = text.strip_suffix('\n').unwrap_or(text);
            lines.push(line(text).map_err(|(text, fault)| {
                let text = text.chars().take(SHOWN).collect();
                ParseError { line: number, text, fault }
            })?);
        }
        Ok(Self { lines })
    }

    /// Reads a file that may hold bytes which are not UTF-8: in comments and macros they become
    /// replacement characters.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ParseError> {
        Self::parse(&String::from_utf8_lossy(bytes))
    }
}

/// Reads one line, which holds no line feed.
pub(super) fn line(text: &str) -> Result<Line, Broken<'_>> {
    let text = text.trim_end_matches('\r');
    // Slicers write no semicolon inside quotes, and firmware does not look for quotes either.
    let (code, comment) = match text.split_once(';') {
        Some((code, comment)) => (code, Some(comment.to_owned())),
        None => (text, None),
    };
    let mut asides = Asides::default();
    let code = unnumbered(code, &mut asides);
    if code.is_empty() {
        return Ok(Line::trusted(None, comment.or(asides.0)));
    }
    let command = match typed(code, &mut asides)? {
        Some(command) => command,
        None => Command::Other(Verbatim::trusted(code)),
    };
    Ok(Line::trusted(Some(command), comment.or(asides.0)))
}

/// The comments in parentheses of a line.
#[derive(Default)]
struct Asides(Option<String>);

impl Asides {
    /// Takes the comment at the beginning of `text`, which starts with a parenthesis, and gives
    /// what follows it.
    fn take<'a>(&mut self, text: &'a str) -> &'a str {
        let (inner, rest) = text[1..].split_once(')').unwrap_or((&text[1..], ""));
        let inner = inner.trim_end_matches('\r');
        match &mut self.0 {
            Some(all) => all.extend([" ", inner]),
            None => self.0 = Some(inner.to_owned()),
        }
        rest
    }
}

fn is_blank(character: char) -> bool {
    // The byte order mark counts as no blank elsewhere.
    character.is_whitespace() || character == '\u{feff}'
}

/// The command without blanks around it, without line number and checksum, and without comments
/// before it.
fn unnumbered<'a>(code: &'a str, asides: &mut Asides) -> &'a str {
    let mut code = code.trim_matches(is_blank);
    // A line has one checksum; looking for it behind each of many numbers would take the square of
    // the line's length.
    let mut has_number = false;
    loop {
        if code.starts_with('(') {
            code = asides.take(code);
        } else if let Some(rest) = after_number(code) {
            code = match (!has_number).then(|| rest.rsplit_once('*')).flatten() {
                Some((rest, sum)) if sum.bytes().all(|byte| byte.is_ascii_digit()) => rest,
                _ => rest,
            };
            has_number = true;
        } else {
            return code;
        }
        code = code.trim_matches(is_blank);
    }
}

/// What follows a line number, if the text begins with one.
fn after_number(code: &str) -> Option<&str> {
    let rest = code.strip_prefix(['N', 'n'])?;
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let rest = &rest[digits..];
    // A macro's name may begin like a line number.
    let ends =
        rest.is_empty() || rest.starts_with(|next| is_blank(next) || "GgMmTt(*".contains(next));
    (digits > 0 && ends).then_some(rest)
}

/// The typed command of a text; `None` if there is no type for it.
fn typed<'a>(code: &'a str, asides: &mut Asides) -> Result<Option<Command>, Broken<'a>> {
    let bytes = code.as_bytes();
    let letter = bytes[0].to_ascii_uppercase();
    let digits = bytes[1..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    if !matches!(letter, b'G' | b'M' | b'T') || digits == 0 {
        return velocity_limit(code);
    }
    let rest = &code[1 + digits..];
    if !rest.is_empty()
        && !rest
            .starts_with(|next: char| is_blank(next) || next.is_ascii_alphabetic() || next == '(')
    {
        return Ok(None);
    }
    let Ok(number) = code[1..=digits].parse::<u32>() else { return Ok(None) };
    let mut read = |known: &str, flags: &str| Words::read(rest, known, flags, asides);
    Ok(match (letter, number) {
        (b'G', 0 | 1) => {
            let words = read("XYZEF", "")?;
            let [x, y, z, e, f] = ['X', 'Y', 'Z', 'E', 'F'].map(|letter| words.value(letter));
            Some(Command::Move(Move { rapid: number == 0, x, y, z, e, f }))
        }
        (b'G', 2 | 3) => {
            let words = read("XYZIJREF", "")?;
            let [x, y, z, i, j, r, e, f] =
                ['X', 'Y', 'Z', 'I', 'J', 'R', 'E', 'F'].map(|letter| words.value(letter));
            Some(Command::Arc(Box::new(Arc { clockwise: number == 2, x, y, z, i, j, r, e, f })))
        }
        (b'G', 28) => {
            let words = read("XYZ", "XYZ")?;
            let [x, y, z] = ['X', 'Y', 'Z'].map(|letter| words.has(letter));
            Some(Command::Home { x, y, z })
        }
        (b'G', 92) => {
            let words = read("XYZE", "")?;
            let [x, y, z, e] = ['X', 'Y', 'Z', 'E'].map(|letter| words.value(letter));
            Some(Command::SetPosition { x, y, z, e })
        }
        (b'G', 4) => read("SP", "")?.only(|words| {
            Some(Command::Dwell { seconds: words.value('S'), milliseconds: words.value('P') })
        }),
        (b'G', 10) => read("", "")?.only(|_| Some(Command::Retract)),
        (b'G', 11) => read("", "")?.only(|_| Some(Command::Unretract)),
        (b'G', 90) => read("", "")?.only(|_| Some(Command::Absolute)),
        (b'G', 91) => read("", "")?.only(|_| Some(Command::Relative)),
        (b'M', 82) => read("", "")?.only(|_| Some(Command::AbsoluteExtrusion)),
        (b'M', 83) => read("", "")?.only(|_| Some(Command::RelativeExtrusion)),
        (b'M', 107) => read("", "")?.only(|_| Some(Command::Fan(None))),
        (b'M', 106) => {
            let full = Number::whole(255);
            read("S", "")?.only(|words| Some(Command::Fan(Some(words.value('S').unwrap_or(full)))))
        }
        (b'M', 104) => read("ST", "")?.only(|words| nozzle(words, 'S', Wait::No)),
        (b'M', 109) => read("STR", "")?.only(|words| match (words.has('S'), words.has('R')) {
            (true, false) => nozzle(words, 'S', Wait::Heating),
            (false, true) => nozzle(words, 'R', Wait::Both),
            _ => None,
        }),
        (b'M', 140 | 190) => read("S", "")?.only(|words| {
            Some(Command::BedTemperature { celsius: words.value('S')?, wait: number == 190 })
        }),
        (b'M', 204) => read("PRTS", "")?.only(|words| {
            let [print, retract, travel, all] =
                ['P', 'R', 'T', 'S'].map(|letter| words.value(letter));
            Some(Command::Acceleration { print, travel, retract, all })
        }),
        (b'M', 205) => read("XYZEJ", "")?.only(|words| {
            let [x, y, z, e, junction_deviation] =
                ['X', 'Y', 'Z', 'E', 'J'].map(|letter| words.value(letter));
            Some(Command::Jerk { x, y, z, e, junction_deviation })
        }),
        (b'M', 73) => read("PR", "")?.only(|words| {
            Some(Command::Progress { percent: words.value('P'), minutes: words.value('R') })
        }),
        // Some slicers count tools beyond any that exist, to say "none"; the printers of one take
        // 255 so.
        (b'T', number) => match u8::try_from(number) {
            Ok(tool) if tool < u8::MAX => read("", "")?.only(|_| Some(Command::Tool(tool))),
            _ => None,
        },
        _ => None,
    })
}

fn nozzle(words: &Words, letter: char, wait: Wait) -> Option<Command> {
    let tool = match words.value('T') {
        Some(number) => Some(whole_byte(number)?),
        None => None,
    };
    Some(Command::NozzleTemperature { celsius: words.value(letter)?, tool, wait })
}

fn whole_byte(number: Number) -> Option<u8> {
    let millionths = number.millionths();
    let scale = Number::whole(1).millionths();
    (millionths % scale == 0).then(|| u8::try_from(millionths / scale).ok()).flatten()
}

/// Klipper's `NAME=value` words, as far as one command needs them; `None` for other commands.
struct VelocityWords {
    /// Those of `VELOCITY`, `ACCEL` and `SQUARE_CORNER_VELOCITY`.
    values: [Option<Number>; 3],
    /// Whether there are others.
    others: bool,
}

impl VelocityWords {
    fn read(code: &str) -> Result<Option<Self>, Broken<'_>> {
        let mut words = code.split_ascii_whitespace();
        if !words.next().is_some_and(|name| name.eq_ignore_ascii_case(VELOCITY_LIMIT)) {
            return Ok(None);
        }
        let mut read = Self { values: [None; 3], others: false };
        for word in words {
            let (name, value) = word.split_once('=').ok_or((word, ParseFault::Word))?;
            let known = [VELOCITY, ACCELERATION, SQUARE_CORNER_VELOCITY];
            match known.iter().position(|known| name.eq_ignore_ascii_case(known)) {
                Some(at) => {
                    read.values[at] =
                        Some(value.parse().map_err(|error| (word, ParseFault::Number(error)))?);
                }
                None => read.others = true,
            }
        }
        Ok(Some(read))
    }
}

fn velocity_limit(code: &str) -> Result<Option<Command>, Broken<'_>> {
    Ok(VelocityWords::read(code)?.filter(|words| !words.others).map(|words| {
        let [velocity, acceleration, square_corner] = words.values;
        Command::VelocityLimit { velocity, acceleration, square_corner }
    }))
}

/// What a limit of Klipper's that is kept word for word says of the acceleration, in mm/s².
pub(super) fn acceleration(code: &str) -> Option<Number> {
    VelocityWords::read(code).ok().flatten().and_then(|words| words.values[1])
}

/// The words of a command: a letter each, and mostly a number.
struct Words {
    /// One bit a letter: those that are there.
    present: u32,
    /// Those that have a number.
    numbered: u32,
    values: [Number; 26],
    /// Those the command is known to take.
    known: u32,
}

impl Words {
    /// Reads all words.
    /// Those of `known` need a number, except for `flags`; the others may have one.
    fn read<'a>(
        mut rest: &'a str,
        known: &str,
        flags: &str,
        asides: &mut Asides,
    ) -> Result<Self, Broken<'a>> {
        let bits = |letters: &str| letters.bytes().fold(0, |bits, letter| bits | bit(letter));
        let (known, flags) = (bits(known), bits(flags));
        let mut words = Self { present: 0, numbered: 0, values: [Number::ZERO; 26], known };
        loop {
            rest = rest.trim_start_matches(is_blank);
            let Some(&letter) = rest.as_bytes().first() else { return Ok(words) };
            if letter == b'(' {
                rest = asides.take(rest);
                continue;
            }
            let letter = letter.to_ascii_uppercase();
            if !letter.is_ascii_uppercase() {
                return Err((rest.split(is_blank).next().unwrap_or(rest), ParseFault::Word));
            }
            let behind = rest[1..].trim_start_matches(is_blank);
            let follows = behind.as_bytes().first().copied().unwrap_or(b' ');
            words.present |= bit(letter);
            if matches!(follows, b'0'..=b'9' | b'.' | b'+' | b'-') {
                let scanned = Number::scan(behind.as_bytes()).and_then(|(number, length)| {
                    // A number ends where a word, a blank or a comment begins, not in the midst of
                    // other signs.
                    let next = behind[length..].chars().next().unwrap_or(' ');
                    let ends = is_blank(next) || next.is_ascii_alphabetic() || next == '(';
                    if ends { Ok((number, length)) } else { Err(NumberError::Junk) }
                });
                let (number, length) = scanned.map_err(|error| (word(rest), error.into()))?;
                words.numbered |= bit(letter);
                words.values[usize::from(letter - b'A')] = number;
                rest = &behind[length..];
            } else if bit(letter) & known & !flags != 0 {
                return Err((word(rest), NumberError::Junk.into()));
            } else {
                rest = &rest[1..];
            }
        }
    }

    fn value(&self, letter: char) -> Option<Number> {
        let place = letter as usize - 'A' as usize;
        (self.numbered >> place & 1 == 1).then(|| self.values[place])
    }

    fn has(&self, letter: char) -> bool {
        self.present & bit(letter as u8) != 0
    }

    /// The command that is made of these words, unless there are others.
    fn only(self, command: impl FnOnce(&Self) -> Option<Command>) -> Option<Command> {
        if self.present & !self.known == 0 { command(&self) } else { None }
    }
}

fn bit(letter: u8) -> u32 {
    1 << (letter - b'A')
}

/// The word a text begins with, for an error.
fn word(text: &str) -> &str {
    let number = text[1..].trim_start_matches(is_blank);
    let length = number.find(|next| is_blank(next) || next == '(').unwrap_or(number.len());
    &text[..text.len() - number.len() + length]
}

#[cfg(test)]
mod tests;
