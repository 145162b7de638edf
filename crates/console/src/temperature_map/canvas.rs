//! A raster picture on which rectangles and numbers are drawn.

/// Side of a dot of a character, in pixels.
const DOT: usize = 3;

/// Height of a character, in pixels.
pub(super) const HEIGHT: usize = 5 * DOT;

/// Characters as five rows of three dots, with the top row in the highest bits.
const LETTERS: [(char, u16); 15] = [
    ('0', 0b111_101_101_101_111),
    ('1', 0b010_110_010_010_111),
    ('2', 0b111_001_111_100_111),
    ('3', 0b111_001_111_001_111),
    ('4', 0b101_101_111_001_001),
    ('5', 0b111_100_111_001_111),
    ('6', 0b111_100_111_101_111),
    ('7', 0b111_001_010_010_010),
    ('8', 0b111_101_111_101_111),
    ('9', 0b111_101_111_001_111),
    ('-', 0b000_000_111_000_000),
    ('.', 0b000_000_000_000_010),
    ('>', 0b100_010_001_010_100),
    ('°', 0b010_101_010_000_000),
    ('C', 0b111_100_100_100_111),
];

/// A picture, four bytes (RGBA) per pixel.
pub(super) struct Canvas {
    size: [usize; 2],
    pixels: Vec<u8>,
}

impl Canvas {
    pub(super) fn white(size: [usize; 2]) -> Self {
        Self { size, pixels: vec![u8::MAX; 4 * size[0] * size[1]] }
    }

    pub(super) fn pixels(&self) -> &[u8] {
        &self.pixels
    }

    /// Fills a rectangle, clipped to the picture.
    pub(super) fn fill(
        &mut self,
        [x, y]: [usize; 2],
        [wide, high]: [usize; 2],
        [red, green, blue]: [u8; 3],
    ) {
        let [width, height] = self.size;
        for row in y..(y + high).min(height) {
            let line = &mut self.pixels[4 * row * width..4 * (row + 1) * width];
            for pixel in line.chunks_exact_mut(4).take((x + wide).min(width)).skip(x) {
                pixel.copy_from_slice(&[red, green, blue, u8::MAX]);
            }
        }
    }

    /// Writes text in black from its upper left corner; characters without an entry in [`LETTERS`]
    /// stay blank.
    pub(super) fn write(&mut self, [x, y]: [usize; 2], text: &str) {
        for (number, letter) in text.chars().enumerate() {
            let dots =
                LETTERS.iter().find(|(known, _)| *known == letter).map_or(0, |(_, dots)| *dots);
            for dot in (0..15).filter(|dot| dots >> (14 - dot) & 1 == 1) {
                let corner = [x + (4 * number + dot % 3) * DOT, y + dot / 3 * DOT];
                self.fill(corner, [DOT; 2], [0; 3]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_and_edges() {
        let mut canvas = Canvas::white([20, 20]);
        canvas.write([0, 0], "1x1");
        let dark =
            |canvas: &Canvas| canvas.pixels().chunks(4).filter(|pixel| pixel[0] == 0).count();
        // The second 1 lies beyond the picture.
        assert_eq!(dark(&canvas), 8 * DOT * DOT);
        canvas.fill([15, 15], [100, 100], [0; 3]);
        assert_eq!(dark(&canvas), 8 * DOT * DOT + 25);
    }
}
