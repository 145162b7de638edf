//! Parallel lines clipped by the border of an area.

use crate::area::Ring;

/// A family of parallel lines.
///
/// Their position depends on the origin, not on the area, so that lines of one layer lie on those
/// of another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Family {
    /// Unit vector along the lines.
    pub(super) along: [f64; 2],
    /// Distance from one line to the next in mm.
    /// More than 0.
    pub(super) spacing_mm: f64,
    /// Distance in mm of a line to the left of the origin.
    pub(super) shift_mm: f64,
}

/// A point where the border of an area crosses a line.
struct Crossing {
    /// Number of the line, a whole number.
    line: f64,
    /// Position along the line in mm.
    along_mm: f64,
    point: [f64; 2],
}

impl Family {
    /// The intervals of the lines that lie inside the border of an area, line by line; each begins
    /// and ends on the border.
    ///
    /// O(n log n), where n counts each line that each edge of the border crosses.
    pub(super) fn clip<'a>(&self, rings: impl Iterator<Item = &'a Ring>) -> Vec<[[f64; 2]; 2]> {
        let [along_x, along_y] = self.along;
        let number =
            |[x, y]: [f64; 2]| (along_x * y - along_y * x - self.shift_mm) / self.spacing_mm;
        let mut crossings: Vec<Crossing> = Vec::new();
        for ring in rings {
            let ends = ring.iter().skip(1).chain(ring.first());
            for (&from, &to) in ring.iter().zip(ends) {
                // Low to high, so that an edge that two areas share is cut at the same points.
                let (mut low, mut high) = ((number(from), from), (number(to), to));
                if high.0 < low.0 {
                    (low, high) = (high, low);
                }
                // An edge crosses lines from its low end, inclusive, to its high end, exclusive: so
                // where two edges meet on a line, the line is crossed once or not at all.
                // Adding 0 turns -0 into 0, which is the same line.
                let mut line = low.0.ceil() + 0.0;
                while line < high.0 {
                    let part = (line - low.0) / (high.0 - low.0);
                    let point = [0, 1].map(|k| low.1[k] + part * (high.1[k] - low.1[k]));
                    let along_mm = along_x * point[0] + along_y * point[1];
                    crossings.push(Crossing { line, along_mm, point });
                    line += 1.0;
                }
            }
        }
        crossings.sort_by(|a, b| a.line.total_cmp(&b.line).then(a.along_mm.total_cmp(&b.along_mm)));
        crossings
            .chunk_by(|a, b| a.line.total_cmp(&b.line).is_eq())
            .flat_map(|line| line.chunks_exact(2))
            .filter(|pair| pair[0].along_mm < pair[1].along_mm)
            .map(|pair| [pair[0].point, pair[1].point])
            .collect()
    }
}
