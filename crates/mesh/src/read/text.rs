//! Numbers and words in text formats.

use super::error::ReadError;

/// Characters of a malformed word that an error shows.
const SHOWN_CHARS: usize = 20;

/// Reads the next three words as coordinates; `line` is the number of their line.
pub(super) fn point<'a>(
    line: usize,
    words: impl Iterator<Item = &'a str>,
) -> Result<[f64; 3], ReadError> {
    let mut point = [0.0; 3];
    let mut count = 0;
    for word in words.take(3) {
        point[count] = number(word).map_err(|message| ReadError::line(line, message))?;
        count += 1;
    }
    if count < 3 {
        let message = format!("vertex has {count} coordinates, expected 3");
        return Err(ReadError::line(line, message));
    }
    Ok(point)
}

/// Reads a finite number; the error describes what is wrong.
pub(super) fn number(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!("'{}' is not a finite number", shown(word))),
        Err(_) => Err(format!("'{}' is not a number", shown(word))),
    }
}

/// The beginning of a word, for an error message.
pub(super) fn shown(word: &str) -> String {
    word.chars().take(SHOWN_CHARS).collect()
}
