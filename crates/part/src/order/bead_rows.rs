//! Beads in parallel rows, in any order of the rows.

use super::sequence::Sequence;
use crate::bead::Bead;

/// Mostly straight beads, such as the infill lines of a slicer, in parallel rows.
///
/// The rows run along the mean direction of all extrusion moves, and a bead belongs to the row of
/// its centre.
/// Beads of which the centres are less than half the maximum width of a bead apart, measured across
/// the rows, share a row.
/// Rows are numbered across their direction, and the beads of a row are listed along it.
///
/// [`BeadRows::order`] prints the rows in the order of a [`Sequence`], as
/// [`Lines::permutation`](super::lines::Lines::permutation) does with rows of cells.
///
/// # Example
/// ```
/// use beadwork_gcode::Feature;
/// use beadwork_part::{Bead, BeadRows, ExtrusionMove};
///
/// let line = |y: f64| Bead {
///     tool: 0,
///     start_mm: [0.0, y],
///     moves: vec![ExtrusionMove { to_mm: [9.0, y], width_mm: 0.5, feature: Feature::Infill }],
/// };
/// let rows = BeadRows::new((0..6).map(|row| line(0.5 * f64::from(row))).collect());
/// let beads = rows.order("interleaved-3".parse()?, Some([0.0, 0.0]));
/// let starts: Vec<[f64; 2]> = beads.iter().map(|bead| bead.start_mm).collect();
/// assert_eq!(starts[..3], [[0.0, 0.0], [9.0, 1.5], [0.0, 0.5]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct BeadRows {
    beads: Vec<Bead>,
    /// Numbers of the beads of each row.
    rows: Vec<Vec<usize>>,
}

impl BeadRows {
    /// Finds the rows of some beads, and turns all beads into the same direction.
    ///
    /// Coordinates must be finite.
    /// Sorts the beads, O(n log n).
    pub fn new(mut beads: Vec<Bead>) -> Self {
        let along = direction(&beads);
        let across = [-along[1], along[0]];
        for bead in &mut beads {
            if dot(bead.end_mm(), along) < dot(bead.start_mm, along) {
                *bead = bead.reversed();
            }
        }
        let centres: Vec<[f64; 2]> = beads.iter().map(centre_mm).collect();
        let key = |bead: usize, axis: [f64; 2]| dot(centres[bead], axis);
        let mut sorted: Vec<usize> = (0..beads.len()).collect();
        sorted.sort_by(|&a, &b| key(a, across).total_cmp(&key(b, across)));
        let mut rows: Vec<Vec<usize>> = Vec::new();
        let widths = beads.iter().flat_map(|bead| &bead.moves).map(|step| step.width_mm);
        let width_mm = widths.fold(0.0, f64::max);
        let mut before = f64::NEG_INFINITY;
        for bead in sorted {
            let position = key(bead, across);
            match rows.last_mut() {
                Some(row) if position - before < 0.5 * width_mm => row.push(bead),
                _ => rows.push(vec![bead]),
            }
            before = position;
        }
        for row in &mut rows {
            row.sort_by(|&a, &b| key(a, along).total_cmp(&key(b, along)));
        }
        Self { beads, rows }
    }

    /// Number of rows.
    pub fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// The beads in the order in which they were given, all turned into the rows' direction.
    pub fn beads(&self) -> &[Bead] {
        &self.beads
    }

    /// All beads, with the rows in the order of a sequence.
    ///
    /// A row begins at the end that is nearer to the nozzle, and so does each of its beads; of
    /// equal distances, at the end at which the rows' direction begins.
    /// `from_mm` is where the nozzle is; `None` prints the first row along the rows' direction.
    pub fn order(&self, sequence: Sequence, from_mm: Option<[f64; 2]>) -> Vec<Bead> {
        let turned = self.row_order(&sequence.order(self.rows.len()), from_mm);
        turned.iter().map(|turned| turned.of(&self.beads)).collect()
    }

    /// As [`BeadRows::order`], for a list of rows.
    ///
    /// # Panics
    /// If a number is not below [`BeadRows::row_count`].
    pub fn row_order(&self, rows: &[usize], from_mm: Option<[f64; 2]>) -> Vec<TurnedBead> {
        let mut ordered = Vec::with_capacity(self.beads.len());
        let mut nozzle = BeadNozzle { position_mm: from_mm };
        for &row in rows {
            let mut row = self.rows[row].clone();
            let (first, last) = (&self.beads[row[0]], &self.beads[row[row.len() - 1]]);
            if is_second_nearer(nozzle.position_mm, first.start_mm, last.end_mm()) {
                row.reverse();
            }
            ordered.extend(row.into_iter().map(|bead| nozzle.print(bead, &self.beads[bead])));
        }
        ordered
    }
}

/// A bead of a list, and its direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TurnedBead {
    /// Number of the bead in the list.
    pub bead: u32,
    /// Whether it is printed from its end to its beginning.
    pub is_reversed: bool,
}

impl TurnedBead {
    /// The bead in its direction.
    ///
    /// # Panics
    /// If the list has no such bead.
    pub fn of(self, beads: &[Bead]) -> Bead {
        let bead = &beads[self.bead as usize];
        if self.is_reversed { bead.reversed() } else { bead.clone() }
    }
}

/// Position of the nozzle between beads.
struct BeadNozzle {
    position_mm: Option<[f64; 2]>,
}

impl BeadNozzle {
    /// Prints a bead from the end that is nearer, and returns its direction.
    fn print(&mut self, number: usize, bead: &Bead) -> TurnedBead {
        let [start_mm, end_mm] = [bead.start_mm, bead.end_mm()];
        let is_reversed = is_second_nearer(self.position_mm, start_mm, end_mm);
        self.position_mm = Some(if is_reversed { start_mm } else { end_mm });
        TurnedBead { bead: number as u32, is_reversed }
    }
}

/// Some beads of a list, in the given order, each from the end that is nearer to the nozzle.
///
/// `from_mm` is where the nozzle is; `None` prints the first bead as it is.
///
/// # Panics
/// If a number is not below that of the beads.
pub fn turn_beads(
    beads: &[Bead],
    order: impl IntoIterator<Item = usize>,
    from_mm: Option<[f64; 2]>,
) -> Vec<TurnedBead> {
    let mut nozzle = BeadNozzle { position_mm: from_mm };
    order.into_iter().map(|bead| nozzle.print(bead, &beads[bead])).collect()
}

/// Unit vector of the mean direction of all moves, with a direction and its opposite the same; x
/// without any.
fn direction(beads: &[Bead]) -> [f64; 2] {
    // Of the angles between the moves and x, twice the angles are averaged.
    let (mut cos, mut sin) = (0.0, 0.0);
    for (from, to, _) in beads.iter().flat_map(Bead::lines) {
        let [x, y] = [to[0] - from[0], to[1] - from[1]];
        let length = libm::hypot(x, y);
        if length > 0.0 {
            cos += (x * x - y * y) / length;
            sin += 2.0 * x * y / length;
        }
    }
    let angle = 0.5 * libm::atan2(sin, cos);
    [libm::cos(angle), libm::sin(angle)]
}

/// Centre of gravity of a bead's moves.
fn centre_mm(bead: &Bead) -> [f64; 2] {
    let (mut length, mut sum) = (0.0, [0.0; 2]);
    for (from, to, _) in bead.lines() {
        let own = libm::hypot(to[0] - from[0], to[1] - from[1]);
        length += own;
        for axis in 0..2 {
            sum[axis] += own * f64::midpoint(from[axis], to[axis]);
        }
    }
    if length > 0.0 { sum.map(|sum| sum / length) } else { bead.start_mm }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn is_second_nearer(nozzle_mm: Option<[f64; 2]>, first: [f64; 2], second: [f64; 2]) -> bool {
    let Some([x, y]) = nozzle_mm else { return false };
    let distance = |end: [f64; 2]| libm::hypot(end[0] - x, end[1] - y);
    distance(second) < distance(first)
}

#[cfg(test)]
mod tests {
    use beadwork_gcode::Feature;
    use beadwork_grid::{Cell, Region};
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::bead::ExtrusionMove;
    use crate::order::{Ends, LineOrder, Lines, Stride};

    fn bead(points: &[[f64; 2]]) -> Bead {
        let moves = points[1..].iter();
        let moves = moves.map(|&to_mm| ExtrusionMove {
            to_mm,
            width_mm: 1.0,
            feature: Feature::SolidInfill,
        });
        Bead { tool: 0, start_mm: points[0], moves: moves.collect() }
    }

    /// The positions of a bead, such that the order of beads and their directions can be compared.
    fn points(beads: &[Bead]) -> Vec<[f64; 2]> {
        let of = |bead: &Bead| {
            std::iter::once(bead.start_mm).chain(bead.moves.iter().map(|step| step.to_mm)).collect()
        };
        beads.iter().flat_map(|bead| -> Vec<[f64; 2]> { of(bead) }).collect()
    }

    fn centre(cell: Cell, width: u32) -> [f64; 2] {
        [f64::from(cell % width), f64::from(cell / width)]
    }

    fn cell_beads(lines: &Lines, width: u32) -> Vec<Bead> {
        let of = |line: &[Cell]| line.iter().map(|&cell| centre(cell, width)).collect::<Vec<_>>();
        lines.iter().map(|line| bead(&of(line))).collect()
    }

    #[test]
    fn beads_on_rows_of_cells_are_ordered_as_the_cells() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(0);
        for case in 0..2000 {
            let (width, height) = (3 + rng.next_u64() as u32 % 9, 2 + rng.next_u64() as u32 % 9);
            let cells = (0..width * height).filter(|_| !rng.next_u64().is_multiple_of(4));
            let mut inside = vec![false; (width * height) as usize];
            cells.for_each(|cell| inside[cell as usize] = true);
            let Ok(region) = Region::from_mask(width, height, inside) else { continue };
            let order: LineOrder = "lines-x-sequential-0".parse().unwrap();
            let lines = order.lines(&region);
            let stride = Stride::new(1 + case % 5).unwrap();
            let sequence = [
                Sequence::Sequential,
                Sequence::Interleaved(stride),
                Sequence::Scattered(stride),
                Sequence::Golden,
            ][case as usize / 5 % 4];
            let from = rng.next_u64() as u32 % (width * height);
            let from = (!rng.next_u64().is_multiple_of(5)).then_some(from);
            let ends = Ends::Nearest { from };
            let expected = lines.flatten(&lines.permutation(sequence, ends), ends);

            // Beads without moves have no width.
            let beads = cell_beads(&lines, width);
            if beads.iter().all(|bead| bead.moves.is_empty()) {
                continue;
            }
            let mut shuffled: Vec<Bead> = beads.clone();
            for last in (1..shuffled.len()).rev() {
                shuffled.swap(last, rng.next_u64() as usize % (last + 1));
                if rng.next_u64().is_multiple_of(2) {
                    shuffled[last] = shuffled[last].reversed();
                }
            }
            let rows = BeadRows::new(shuffled);
            assert_eq!(rows.row_count(), lines.row_count());
            let ordered = rows.order(sequence, from.map(|cell| centre(cell, width)));
            let expected: Vec<_> = expected.iter().map(|&cell| centre(cell, width)).collect();
            assert_eq!(points(&ordered), expected, "{sequence}");
        }
    }

    #[test]
    fn slanted_lines_are_rows() {
        let slanted = |row: f64| bead(&[[row, 0.0], [row + 5.0, 5.0], [row + 9.0, 9.0]]);
        let rows = BeadRows::new([4.0, 0.0, 2.0, 6.0].map(slanted).to_vec());
        assert_eq!(rows.row_count(), 4);
        let ordered = rows.order(Sequence::Sequential, Some([6.0, 0.0]));
        let starts: Vec<f64> = ordered.iter().map(|bead| bead.start_mm[0]).collect();
        // Rows are numbered to the left of their direction; every second one is reversed.
        assert_eq!(starts, [6.0, 13.0, 2.0, 9.0]);
    }

    #[test]
    fn there_may_be_no_beads_or_beads_without_moves() {
        assert_eq!(BeadRows::new(Vec::new()).order(Sequence::Golden, None), []);
        let rows = BeadRows::new(vec![bead(&[[1.0, 1.0]]), bead(&[[1.0, 1.0], [1.0, 1.0]])]);
        assert_eq!(rows.order(Sequence::Golden, Some([0.0, 0.0])).len(), 2);
    }
}
