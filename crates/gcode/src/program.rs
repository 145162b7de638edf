//! A program: the lines of a G-code file.

use thiserror::Error;

use crate::command::Command;

/// The lines of a G-code file, in order.
///
/// [`Program::emit`] and [`Program::parse`] are inverse to each other: parsing the emitted text
/// returns the same program, unless it contains [`Command::Tool`]`(255)`, which is read verbatim.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Program {
    /// The lines.
    /// Errors, events and motions number them from 1.
    pub lines: Vec<Line>,
}

/// One line: a command, a comment, both, or neither.
///
/// Invariant: the comment contains no line break and does not end in a carriage return.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Line {
    command: Option<Command>,
    comment: Option<String>,
}

/// A comment that does not fit on one line.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("comment '{0}' contains a line break")]
pub struct CommentError(pub String);

impl Line {
    /// Creates a line from a command, a comment, or both.
    /// The comment is the text after the semicolon, including leading blanks.
    pub fn new(command: Option<Command>, comment: Option<String>) -> Result<Self, CommentError> {
        match comment {
            Some(text) if text.contains('\n') || text.ends_with('\r') => Err(CommentError(text)),
            comment => Ok(Self { command, comment }),
        }
    }

    /// Creates a line from parts that the parser has already split at line breaks.
    pub(crate) fn from_parsed(command: Option<Command>, comment: Option<String>) -> Self {
        Self { command, comment }
    }

    /// The command, if there is one.
    pub fn command(&self) -> Option<&Command> {
        self.command.as_ref()
    }

    /// The text after the semicolon, including leading blanks, if there is a comment.
    pub fn comment(&self) -> Option<&str> {
        self.comment.as_deref()
    }

    pub(crate) fn into_parts(self) -> (Option<Command>, Option<String>) {
        (self.command, self.comment)
    }
}

impl From<Command> for Line {
    fn from(command: Command) -> Self {
        Self { command: Some(command), comment: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_with_line_breaks_are_refused() {
        for text in ["a\nM112", "\r", "a\r"] {
            assert_eq!(Line::new(None, Some(text.to_owned())), Err(CommentError(text.to_owned())));
        }
        assert!(Line::new(None, Some("a;b\rc".to_owned())).is_ok());
    }
}
