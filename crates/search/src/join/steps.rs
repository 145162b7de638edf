//! Steps found by position.

use std::collections::BTreeMap;

use super::geometry::crosses;
use crate::segment::{Segment, are_near};

/// Distance in mm below which points are the same.
const SAME_MM: f64 = 1e-4;

/// Short segments, with an index by the cells of a square grid.
#[derive(Default)]
pub(super) struct Steps {
    all: Vec<Segment>,
    /// Side of a cell in mm.
    cell_mm: f64,
    /// For each cell the steps whose bounding box touches it.
    cells: BTreeMap<[i64; 2], Vec<usize>>,
}

impl Steps {
    /// No steps; they will be at most about `cell_mm` long.
    pub(super) fn new(cell_mm: f64) -> Self {
        Self { cell_mm, ..Self::default() }
    }

    pub(super) fn push(&mut self, step: Segment) {
        for cell in self.cells_near(step, SAME_MM) {
            self.cells.entry(cell).or_default().push(self.all.len());
        }
        self.all.push(step);
    }

    /// Whether a segment comes nearer than a distance to a step, or crosses it.
    pub(super) fn any_near(&self, segment: Segment, distance_mm: f64) -> bool {
        let is_near = |&number: &usize| {
            let other = self.all[number];
            crosses(segment, other, SAME_MM)
                || (distance_mm > 0.0 && are_near(segment, other, distance_mm))
        };
        self.cells_near(segment, distance_mm)
            .any(|cell| self.cells.get(&cell).is_some_and(|steps| steps.iter().any(is_near)))
    }

    /// Whether a segment crosses a step that is not among some of them.
    pub(super) fn crosses_other_than(&self, segment: Segment, some: &[Segment]) -> bool {
        let is_crossed = |&number: &usize| {
            let other = self.all[number];
            crosses(segment, other, SAME_MM) && !some.contains(&other)
        };
        self.cells_near(segment, SAME_MM)
            .any(|cell| self.cells.get(&cell).is_some_and(|steps| steps.iter().any(is_crossed)))
    }

    /// The cells that the bounding box of a segment touches, wider by a distance on each side.
    fn cells_near(
        &self,
        [a, b]: Segment,
        distance_mm: f64,
    ) -> impl Iterator<Item = [i64; 2]> + use<> {
        let [columns, rows] = [0, 1].map(|k| {
            let (low, high) = (a[k].min(b[k]) - distance_mm, a[k].max(b[k]) + distance_mm);
            [low, high].map(|value| (value / self.cell_mm).floor() as i64)
        });
        (rows[0]..=rows[1])
            .flat_map(move |row| (columns[0]..=columns[1]).map(move |column| [column, row]))
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    #[test]
    fn the_index_finds_what_a_scan_finds() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        let mut found = [0; 2];
        for _ in 0..200 {
            let mut steps = Steps::new(rng.random_range(0.3..2.0));
            for _ in 0..40 {
                let from = [0, 1].map(|_| rng.random_range(-6.0..6.0));
                let step = [from, from.map(|value: f64| value + rng.random_range(-1.0..1.0))];
                let distance_mm = [0.0, rng.random_range(0.0..0.3)][rng.random_range(0..2)];
                let expected = steps.all.iter().any(|&other| {
                    crosses(step, other, SAME_MM)
                        || (distance_mm > 0.0 && are_near(step, other, distance_mm))
                });
                assert_eq!(steps.any_near(step, distance_mm), expected);
                let some = &steps.all[..steps.all.len() / 2];
                let others = &steps.all[some.len()..];
                let expected_other = others.iter().any(|&other| crosses(step, other, SAME_MM));
                assert_eq!(steps.crosses_other_than(step, some), expected_other);
                found[usize::from(expected)] += 1;
                steps.push(step);
            }
        }
        assert!(found.iter().all(|&count| count > 500), "{found:?}");
    }
}
