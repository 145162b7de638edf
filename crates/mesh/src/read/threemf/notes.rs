//! What a file states and the model does not contain, collected while it is read.

use std::collections::HashSet;

use crate::warning::ReadWarning;

/// Names that a message lists.
const MAX_NAMES: usize = 4;
/// Characters of a name that a message shows.
const MAX_NAME_CHARS: usize = 60;
/// Different messages of one file; more are dropped.
const MAX_NOTES: usize = 64;

/// One line for each kind of data, whatever the number of its occurrences.
#[derive(Debug, Default)]
pub(super) struct Notes {
    notes: Vec<Note>,
}

#[derive(Debug)]
struct Note {
    what: String,
    /// How it is approximated; `None` if it is not used.
    how: Option<&'static str>,
    /// The first names of what it concerns, each once.
    names: Vec<String>,
    /// All names beyond them.
    others: HashSet<String>,
}

impl Notes {
    /// Notes data that is not used: a noun phrase in the plural.
    pub(super) fn ignored(&mut self, what: &str) {
        self.add(what, None, None);
    }

    /// Notes data that is not used, and the name of the object or the extension that states it.
    pub(super) fn ignored_of(&mut self, what: &str, name: &str) {
        self.add(what, None, Some(name));
    }

    /// Notes data that is used, but not exactly.
    pub(super) fn approximated(&mut self, what: &str, how: &'static str) {
        self.add(what, Some(how), None);
    }

    fn add(&mut self, what: &str, how: Option<&'static str>, name: Option<&str>) {
        let found = self.notes.iter().position(|note| note.what == what && note.how == how);
        let number = match found {
            Some(number) => number,
            None if self.notes.len() == MAX_NOTES => return,
            None => {
                let (names, others) = (Vec::new(), HashSet::new());
                self.notes.push(Note { what: what.into(), how, names, others });
                self.notes.len() - 1
            }
        };
        let note = &mut self.notes[number];
        let Some(name) = name else { return };
        let name: String = name.chars().take(MAX_NAME_CHARS).collect();
        if note.names.len() < MAX_NAMES && !note.names.contains(&name) {
            note.names.push(name);
        } else if !note.names.contains(&name) {
            note.others.insert(name);
        }
    }

    /// Adds the notes of a part of the file.
    pub(super) fn append(&mut self, other: &Self) {
        for note in &other.notes {
            self.add(&note.what, note.how, None);
            for name in note.names.iter().chain(&note.others) {
                self.add(&note.what, note.how, Some(name));
            }
        }
    }

    pub(super) fn into_warnings(self) -> Vec<ReadWarning> {
        self.notes.into_iter().map(Note::into_warning).collect()
    }
}

impl Note {
    fn into_warning(self) -> ReadWarning {
        let mut what = self.what;
        if let [first, others @ ..] = &self.names[..] {
            what = format!("{what} ({first}");
            for name in others {
                what = format!("{what}, {name}");
            }
            if !self.others.is_empty() {
                what = format!("{what} and {} more", self.others.len());
            }
            what += ")";
        }
        match self.how {
            None => ReadWarning::Ignored { what },
            Some(how) => ReadWarning::Approximated { what, how: how.into() },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kind_of_data_is_one_line() {
        let mut notes = Notes::default();
        notes.ignored("textures");
        notes.ignored("textures");
        for name in ["a", "b", "a", "c", "d", "e", "f"] {
            notes.ignored_of("objects of type support", name);
        }
        notes.approximated("gradients", "the first corner counts");
        let mut all = Notes::default();
        all.append(&notes);
        let lines: Vec<_> = all.into_warnings().iter().map(ToString::to_string).collect();
        assert_eq!(
            lines,
            [
                "textures: not used",
                "objects of type support (a, b, c, d and 2 more): not used",
                "gradients: the first corner counts",
            ]
        );
    }
}
