//! Words and phrases that make text hard to read; `banned-words.txt` lists them.

use super::numbered;

/// The list of banned words.
pub(super) struct BannedWords(Vec<Entry>);

struct Entry {
    /// In lower case.
    phrase: String,
    /// Whether the last word may have any ending.
    any_ending: bool,
    instead: String,
    /// Longer phrases, in lower case, within which the phrase is allowed.
    allowed: Vec<String>,
}

impl BannedWords {
    /// The list of the repository.
    pub(super) fn load() -> Self {
        Self::parse(include_str!("../../banned-words.txt"))
    }

    /// Reads lines `phrase | instead | allowed, allowed`; the last column may be missing.
    fn parse(list: &str) -> Self {
        let lines = list.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
        let entries = lines.map(|line| {
            let mut columns = line.split('|').map(str::trim);
            let phrase = columns.next().unwrap_or_default();
            let instead = columns.next().unwrap_or_default().to_owned();
            let allowed = columns.next().into_iter().flat_map(|all| all.split(','));
            Entry {
                phrase: phrase.trim_end_matches('*').to_lowercase(),
                any_ending: phrase.ends_with('*'),
                instead,
                allowed: allowed.map(|phrase| phrase.trim().to_lowercase()).collect(),
            }
        });
        Self(entries.collect())
    }

    /// The banned phrases of a text with the numbers of their lines.
    /// A phrase that is broken across two lines is not found.
    pub(super) fn check(&self, text: &str) -> Vec<(usize, String)> {
        let mut found = Vec::new();
        for (number, line) in numbered(text) {
            let line = line.to_lowercase();
            for entry in self.0.iter().filter(|entry| entry.is_in(&line)) {
                found.push((number, format!("'{}': write {}", entry.phrase, entry.instead)));
            }
        }
        found
    }
}

impl Entry {
    fn is_in(&self, line: &str) -> bool {
        line.match_indices(&self.phrase).any(|(at, _)| {
            let end = at + self.phrase.len();
            let is_word = |c: char| c.is_alphanumeric() || c == '_';
            let starts = !line[..at].ends_with(is_word);
            let ends = self.any_ending || !line[end..].starts_with(is_word);
            let is_allowed = self.allowed.iter().any(|longer| {
                line.match_indices(longer.as_str())
                    .any(|(from, _)| from <= at && end <= from + longer.len())
            });
            starts && ends && !is_allowed
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIST: &str = "\
# Comment

black sheep | white sheep
sheep*      | goat | Sheep Dog, a flock of sheep
";

    fn lines(text: &str) -> Vec<usize> {
        BannedWords::parse(LIST).check(text).into_iter().map(|(line, _)| line).collect()
    }

    #[test]
    fn phrases_match_whole_words_in_any_case() {
        assert_eq!(lines("one\na Black sheep\n"), [2, 2]);
        assert_eq!(lines("sheepish"), [1]);
        assert!(lines("asheep, my_sheep, blacksheep").is_empty());
    }

    #[test]
    fn phrases_are_allowed_within_longer_ones() {
        assert!(lines("the sheep dog and a flock of sheep").is_empty());
        assert_eq!(lines("the sheep dog and a sheep"), [1]);
    }

    #[test]
    fn list_of_the_repository_is_complete() {
        for Entry { phrase, instead, .. } in BannedWords::load().0 {
            assert!(!phrase.is_empty() && !instead.is_empty(), "'{phrase}': '{instead}'");
        }
    }
}
