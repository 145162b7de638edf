//! A program: the lines of a file of G-code.

use std::fmt;

use thiserror::Error;

use crate::Command;

/// The lines of a file, in order.
///
/// Every value can be written and read again: `Program::parse(&program.emit())` is the same
/// program, unless it selects tool 255.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Program {
    /// The lines.
    /// Errors and motions name them by number, from 1.
    pub lines: Vec<Line>,
}

/// One line: a command, a comment, both, or neither.
///
/// Invariant: the comment holds no line break and does not end in a carriage return.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Line {
    command: Option<Command>,
    comment: Option<String>,
}

/// A comment that is longer than its line.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("the comment '{0}' holds a line break")]
pub struct CommentError(pub String);

impl Line {
    /// A line of a command, a comment, or both.
    /// The comment is what follows the semicolon, blanks and all.
    pub fn new(command: Option<Command>, comment: Option<String>) -> Result<Self, CommentError> {
        match comment {
            Some(text) if text.contains('\n') || text.ends_with('\r') => Err(CommentError(text)),
            comment => Ok(Self { command, comment }),
        }
    }

    /// For the parser, which has split the text at the line breaks.
    pub(super) fn trusted(command: Option<Command>, comment: Option<String>) -> Self {
        Self { command, comment }
    }

    /// The command, if there is one.
    pub fn command(&self) -> Option<&Command> {
        self.command.as_ref()
    }

    /// What follows the semicolon, blanks and all, if there is one.
    pub fn comment(&self) -> Option<&str> {
        self.comment.as_deref()
    }

    pub(super) fn into_parts(self) -> (Option<Command>, Option<String>) {
        (self.command, self.comment)
    }

    fn push_to(&self, out: &mut String) {
        if let Some(command) = &self.command {
            command.push_to(out);
        }
        if let Some(comment) = &self.comment {
            if self.command.is_some() {
                out.push(' ');
            }
            out.push(';');
            out.push_str(comment);
        }
    }
}

impl From<Command> for Line {
    fn from(command: Command) -> Self {
        Self { command: Some(command), comment: None }
    }
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = String::new();
        self.push_to(&mut text);
        f.write_str(&text)
    }
}

impl Program {
    /// The text of the file: upper case, one blank between words, the shortest numbers, a line feed
    /// after every line.
    pub fn emit(&self) -> String {
        /// A usual move with extrusion.
        const USUAL_LINE: usize = 28;
        let mut text = String::with_capacity(USUAL_LINE * self.lines.len());
        for line in &self.lines {
            line.push_to(&mut text);
            text.push('\n');
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Move;

    #[test]
    fn lines_as_they_are_written() {
        let home = || Some(Command::Home { x: true, y: false, z: true });
        let lines = vec![
            Line::new(home(), Some(" twice".to_owned())).unwrap(),
            Line::from(Command::Move(Move { rapid: true, ..Move::default() })),
            Line::new(None, Some(String::new())).unwrap(),
            Line::default(),
        ];
        assert_eq!(lines[0].to_string(), "G28 X Z ; twice");
        assert_eq!(Program { lines }.emit(), "G28 X Z ; twice\nG0\n;\n\n");
    }

    #[test]
    fn a_comment_stays_in_its_line() {
        for text in ["a\nM112", "\r", "a\r"] {
            assert_eq!(Line::new(None, Some(text.to_owned())), Err(CommentError(text.to_owned())));
        }
        assert!(Line::new(None, Some("a;b\rc".to_owned())).is_ok());
    }
}
