//! Colours of the vertices of OBJ files.
//!
//! They are an extension that many programs share: red, green and blue follow the coordinates, as
//! shares from 0 to 1, or as whole numbers from 0 to 255. A vertex may have a weight between them.

use super::error::ReadError;
use super::text::number;

/// Red, green and blue of the vertices of a file.
#[derive(Default)]
pub(super) struct VertexColours {
    /// As in the file; empty as long as no vertex has a colour.
    colours: Vec<Option<[f64; 3]>>,
    /// Number of vertices.
    count: usize,
    /// The largest number of a colour.
    max: f64,
}

impl VertexColours {
    /// Adds a vertex; `words` are those after its coordinates.
    /// Returns what of them is not used, as a noun phrase.
    pub(super) fn add<'a>(
        &mut self,
        line: usize,
        mut words: impl Iterator<Item = &'a str>,
    ) -> Result<Option<&'static str>, ReadError> {
        let mut values = [0.0; 4];
        let mut count = 0;
        for word in words.by_ref().take(4) {
            values[count] = number(word).map_err(|message| ReadError::line(line, message))?;
            count += 1;
        }
        let colour = match count {
            3 => Some([values[0], values[1], values[2]]),
            4 => Some([values[1], values[2], values[3]]),
            _ => None,
        };
        if colour.is_some() {
            self.colours.resize(self.count, None);
        }
        self.count += 1;
        if colour.is_some() || !self.colours.is_empty() {
            self.colours.push(colour);
        }
        self.max = colour.iter().flatten().fold(self.max, |max, &value| max.max(value));
        let is_weighted = matches!(count, 1 | 4) && (values[0] - 1.0).abs() > 0.0;
        Ok(if count == 2 || words.next().is_some() {
            Some("more numbers of vertices than coordinates and a colour")
        } else if is_weighted {
            Some("weights of vertices")
        } else {
            None
        })
    }

    /// Whether any vertex has a colour.
    pub(super) fn is_any(&self) -> bool {
        !self.colours.is_empty()
    }

    /// Red, green and blue of a vertex.
    pub(super) fn of(&self, vertex: u32) -> Option<[u8; 3]> {
        let colour = (*self.colours.get(vertex as usize)?)?;
        // A file with a number above 1 has bytes.
        let scale = if self.max > 1.0 { 1.0 } else { 255.0 };
        Some(colour.map(|value| (value * scale).round().clamp(0.0, 255.0) as u8))
    }
}
