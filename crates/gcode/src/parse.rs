//! Parses G-code as slicers, printers and people write it.
//!
//! Accepts all line breaks, lower case, missing or extra blanks, repeated words (the last one
//! counts), line numbers with checksums, comments in parentheses, a byte order mark, and bytes that
//! are not UTF-8.
//!
//! A command without a type, or with words that its type cannot hold, is kept verbatim, and so is a
//! line with several commands; the trace interprets what it knows of them.
//! Commands that move the nozzle or redefine its position are typed even if they have other words
//! that do not matter, which are dropped.
//! A malformed number in a typed command is an error.

use std::str::FromStr;
use std::sync::atomic::{AtomicUsize, Ordering};

use beadwork_base::{Control, Interrupted};
use thiserror::Error;

use crate::code::words_without_code;
use crate::command::{Arc, Command, LinearMove, Verbatim, VerbatimError, Wait};
use crate::encoding::{EncodingError, decode};
use crate::number::Number;
use crate::program::{Line, Program};
use crate::words::{Fault, ParenthesisComments, ParseFault, VelocityWords, Words, is_blank};

/// Why a text cannot be read as a [`Program`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ParseError {
    /// A word of a command is malformed.
    #[error("line {line}: '{text}' {fault}")]
    Word {
        /// Number of the line, from 1.
        line: usize,
        /// The word, cut to its first 32 characters.
        text: String,
        /// What is wrong with it.
        fault: ParseFault,
    },
    /// The bytes are not the text of a G-code file.
    #[error(transparent)]
    Encoding(#[from] EncodingError),
    /// The caller ended the call early.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

/// Characters of a malformed word that an error shows.
const SHOWN_CHARS: usize = 32;

/// Bytes of text that are parsed between two checks for interruption.
const BLOCK_BYTES: usize = 1 << 17;

/// Why a block of lines cannot be read.
enum Failure {
    /// A word of the line with this index in the block is malformed.
    Word {
        index: usize,
        text: String,
        fault: ParseFault,
    },
    Interrupted(Interrupted),
}

impl Failure {
    /// The error, if the block comes after a number of lines.
    fn after(self, lines: usize) -> ParseError {
        match self {
            Self::Word { index, text, fault } => {
                ParseError::Word { line: lines + index + 1, text, fault }
            }
            Self::Interrupted(interrupted) => interrupted.into(),
        }
    }
}

/// The text in blocks of whole lines.
fn blocks(text: &str) -> Vec<&str> {
    let mut blocks = Vec::with_capacity(text.len() / BLOCK_BYTES + 1);
    let mut rest = text;
    while rest.len() > BLOCK_BYTES {
        let is_end = |&byte: &u8| byte == b'\n';
        let Some(end) = rest.as_bytes()[BLOCK_BYTES..].iter().position(is_end) else { break };
        let (block, after) = rest.split_at(BLOCK_BYTES + end + 1);
        blocks.push(block);
        rest = after;
    }
    blocks.push(rest);
    blocks
}

fn parse_lines(text: &str) -> Result<Vec<Line>, Failure> {
    let mut lines = Vec::with_capacity(text.bytes().filter(|&byte| byte == b'\n').count() + 1);
    for (index, line) in text.split_inclusive('\n').enumerate() {
        let parsed = parse_line(line.strip_suffix('\n').unwrap_or(line));
        lines.push(parsed.map_err(|(text, fault)| {
            let text = text.chars().take(SHOWN_CHARS).collect();
            Failure::Word { index, text, fault }
        })?);
    }
    Ok(lines)
}

impl Program {
    /// Parses the text of a G-code file.
    ///
    /// Linear in its length; takes at most about a hundred bytes of memory per line and twice the
    /// text.
    /// Works on `control.threads`, which do not change the result.
    /// Progress counts bytes of the text.
    /// For small texts, [`str::parse`] does the same without a [`Control`].
    pub fn parse(text: &str, control: &Control<'_>) -> Result<Self, ParseError> {
        let blocks = blocks(text);
        let done = AtomicUsize::new(0);
        let parse = |block: &&str| -> Result<Vec<Line>, Failure> {
            control.check().map_err(Failure::Interrupted)?;
            let lines = parse_lines(block)?;
            let done = done.fetch_add(block.len(), Ordering::Relaxed) + block.len();
            control.report(done, text.len());
            Ok(lines)
        };
        let parsed = control.threads.map(&blocks, parse);
        // Counting the lines first saves the spare capacity of a growing vector: up to half of it.
        let count = parsed.iter().flatten().map(Vec::len).sum();
        let mut lines = Vec::with_capacity(count);
        for block in parsed {
            lines.append(&mut block.map_err(|failure| failure.after(lines.len()))?);
        }
        Ok(Self { lines })
    }

    /// Parses the bytes of a file.
    ///
    /// Reads UTF-8 and UTF-16; bytes that are neither become replacement characters.
    /// A carriage return ends a line, with or without a line feed.
    /// Refuses binary G-code, archives, pictures, meshes and other binary files by name.
    /// Otherwise as [`Program::parse`].
    pub fn from_bytes(bytes: &[u8], control: &Control<'_>) -> Result<Self, ParseError> {
        Self::parse(&decode(bytes)?, control)
    }
}

impl FromStr for Program {
    type Err = ParseError;

    fn from_str(text: &str) -> Result<Self, ParseError> {
        Self::parse(text, &Control::default())
    }
}

impl Verbatim {
    /// Checks a text and wraps it.
    pub fn new(text: &str) -> Result<Self, VerbatimError> {
        let line = if text.contains('\n') { None } else { parse_line(text).ok() };
        match line.map(Line::into_parts) {
            Some((Some(Command::Other(verbatim)), None)) if *verbatim.as_str() == *text => {
                Ok(verbatim)
            }
            _ => Err(VerbatimError(text.to_owned())),
        }
    }
}

impl Command {
    /// Creates a verbatim command.
    pub fn other(text: &str) -> Result<Self, VerbatimError> {
        Verbatim::new(text).map(Self::Other)
    }
}

/// Parses one line, without its line feed.
fn parse_line(text: &str) -> Result<Line, Fault<'_>> {
    let text = text.trim_end_matches('\r');
    // A semicolon inside quotes begins a comment too: slicers do not write any there, and firmware
    // does not look for quotes either.
    let (code, comment) = match text.split_once(';') {
        Some((code, comment)) => (code, Some(comment.to_owned())),
        None => (text, None),
    };
    let mut comments = ParenthesisComments::default();
    let code = strip_line_number(code, &mut comments);
    if code.is_empty() {
        return Ok(Line::from_parsed(None, comment.or(comments.0)));
    }
    let command = match typed(code, Strictness::Exact, &mut comments)? {
        Some(command) => command,
        None => Command::Other(Verbatim::from_parsed(code)),
    };
    Ok(Line::from_parsed(Some(command), comment.or(comments.0)))
}

/// Removes surrounding blanks, line number and checksum, and comments before the command.
fn strip_line_number<'a>(code: &'a str, comments: &mut ParenthesisComments) -> &'a str {
    let mut code = code.trim_matches(is_blank);
    // A line has one checksum.
    // Searching for one after each of many line numbers would make the time quadratic in the length
    // of the line.
    let mut has_number = false;
    loop {
        if code.starts_with('(') {
            code = comments.take(code);
        } else if let Some(rest) = after_line_number(code) {
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

/// The text after a line number such as `N12`; `None` if the text does not begin with one.
fn after_line_number(code: &str) -> Option<&str> {
    let rest = code.strip_prefix(['N', 'n'])?;
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let rest = &rest[digits..];
    // The name of a macro may begin with N and digits too.
    let ends = rest.is_empty()
        || rest.starts_with(|next| is_blank(next) || "GgMmTt(*".contains(next))
        || words_without_code(rest).is_some();
    (digits > 0 && ends).then_some(rest)
}

/// Which words a typed command may have.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Strictness {
    /// Only those that its type can hold, so that emitting it loses nothing that matters.
    Exact,
    /// Any: those that its type cannot hold are dropped.
    Lenient,
}

/// The typed command of a text; `None` if it has to be kept verbatim.
pub(crate) fn typed<'a>(
    code: &'a str,
    strictness: Strictness,
    comments: &mut ParenthesisComments,
) -> Result<Option<Command>, Fault<'a>> {
    let letter = code.as_bytes()[0].to_ascii_uppercase();
    let is_code = matches!(letter, b'G' | b'M' | b'T');
    let digits = if is_code { code[1..].trim_start_matches(is_blank) } else { "" };
    let length = digits.bytes().take_while(u8::is_ascii_digit).count();
    if length == 0 {
        return velocity_limit(code);
    }
    let (digits, rest) = digits.split_at(length);
    let ends = |next: char| is_blank(next) || next.is_ascii_alphabetic() || next == '(';
    if !rest.is_empty() && !rest.starts_with(ends) {
        return Ok(None);
    }
    let Ok(number) = digits.parse::<u32>() else { return Ok(None) };
    let exact = strictness == Strictness::Exact;
    let mut read = |known: &str, flags: &str| Words::read(rest, known, flags, exact, comments);
    Ok(match (letter, number) {
        (b'G', 0 | 1) => read("XYZEF", "")?.unless(MOVE_OTHERS, |words| motion(number, words)),
        (b'G', 2 | 3) => read("XYZIJREF", "")?.unless(ARC_OTHERS, |words| motion(number, words)),
        (b'G', 28) => read("XYZ", "XYZ")?.unless(CODES, |words| {
            let [x, y, z] = ['X', 'Y', 'Z'].map(|letter| words.has(letter));
            Command::Home { x, y, z }
        }),
        (b'G', 92) => read("XYZE", "")?.unless(CODES, |words| {
            let [x, y, z, e] = ['X', 'Y', 'Z', 'E'].map(|letter| words.value(letter));
            Command::SetPosition { x, y, z, e }
        }),
        (b'G', 4) => read("SP", "")?.only(|words| {
            Some(Command::Dwell { seconds: words.value('S'), milliseconds: words.value('P') })
        }),
        (b'G', 10) => read("", "")?.only(|_| Some(Command::Retract)),
        (b'G', 11) => read("", "")?.only(|_| Some(Command::Unretract)),
        (b'G', 90) => read("", "")?.only(|_| Some(Command::AbsolutePositioning)),
        (b'G', 91) => read("", "")?.only(|_| Some(Command::RelativePositioning)),
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
            (false, true) => nozzle(words, 'R', Wait::HeatingOrCooling),
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
        // Slicers use numbers beyond all tools to say "no tool": T255 for some printers, T1000 for
        // others.
        (b'T', number) => match u8::try_from(number) {
            Ok(tool) if tool < u8::MAX => read("", "")?.only(|_| Some(Command::Tool(tool))),
            _ => None,
        },
        _ => None,
    })
}

/// The command `G0` to `G3` with these words.
pub(crate) fn motion(number: u32, words: &Words) -> Command {
    let [x, y, z, i, j, r, e, f] =
        ['X', 'Y', 'Z', 'I', 'J', 'R', 'E', 'F'].map(|letter| words.value(letter));
    if number < 2 {
        Command::Move(LinearMove { rapid: number == 0, x, y, z, e, f })
    } else {
        Command::Arc(Box::new(Arc { clockwise: number == 2, x, y, z, i, j, r, e, f }))
    }
}

/// Words that begin a further command on the line of a move.
const CODES: &str = "GMT";

/// Words that keep a straight move verbatim: further commands, additional axes, and words with
/// which RepRapFirmware moves differently (`H`, `R`).
const MOVE_OTHERS: &str = "GMTABCUVWHR";

/// Words that keep an arc verbatim: further commands, additional axes, turns (`P`) and the centre
/// in other planes (`K`).
const ARC_OTHERS: &str = "GMTABCUVWPK";

fn nozzle(words: &Words, letter: char, wait: Wait) -> Option<Command> {
    let tool = match words.value('T') {
        Some(number) => Some(to_u8(number)?),
        None => None,
    };
    Some(Command::NozzleTemperature { celsius: words.value(letter)?, tool, wait })
}

/// The integer that a number is; `None` if it has a fraction or is not in 0 to 255.
pub(crate) fn to_u8(number: Number) -> Option<u8> {
    let millionths = number.millionths();
    let scale = Number::whole(1).millionths();
    (millionths % scale == 0).then(|| u8::try_from(millionths / scale).ok()).flatten()
}

fn velocity_limit(code: &str) -> Result<Option<Command>, Fault<'_>> {
    Ok(VelocityWords::read(code)?.filter(|words| !words.has_others).map(|words| {
        let [velocity, acceleration, square_corner] = words.values;
        Command::VelocityLimit { velocity, acceleration, square_corner }
    }))
}

#[cfg(test)]
mod tests;
