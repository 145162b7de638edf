//! Voxels of a layer in the order of their deposition.

use beadwork_thermal::DepositionEvent;

use super::geometry::Blocks;

/// Voxels that have been deposited in each block of the printed layer.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Counts {
    /// Number of those that are not part of the state yet.
    pub(super) new: Vec<i32>,
    /// Sides of all of them that face the air, or a voxel that is not deposited yet.
    pub(super) open_sides: Vec<i32>,
}

/// The events of a layer, of which some have happened.
pub(super) struct Births<'a> {
    events: &'a [DepositionEvent],
    /// The first event that has not happened.
    next: usize,
    /// Time at which it begins, s.
    clock_s: f64,
    /// Blocks of one cell each.
    cells: &'a Blocks,
    /// 1 in those that are deposited, otherwise 0.
    deposited: Vec<i32>,
}

impl<'a> Births<'a> {
    /// Events of a layer whose blocks of one cell are `cells`, none of which has happened.
    pub(super) fn new(events: &'a [DepositionEvent], cells: &'a Blocks) -> Self {
        Self { events, next: 0, clock_s: 0.0, cells, deposited: vec![0; cells.len()] }
    }

    /// Lets all events happen whose middle is at most `until_s`, and adds what they deposit to the
    /// counts of blocks.
    ///
    /// Linear in the number of these events.
    ///
    /// # Panics
    /// If an event deposits a voxel outside of the blocks.
    pub(super) fn count_until(&mut self, until_s: f64, blocks: &Blocks, counts: &mut Counts) {
        let mut clock_s = self.clock_s;
        for event in &self.events[self.next..] {
            if clock_s + event.seconds * 0.5 > until_s {
                break;
            }
            if let Some([x, y, _]) = event.voxel {
                self.count(self.cells.position([x, y]), blocks, counts);
            }
            clock_s += event.seconds;
            self.next += 1;
        }
        self.clock_s = clock_s;
    }

    /// Deposits the voxel in a column and row of the box.
    fn count(&mut self, position: [u32; 2], blocks: &Blocks, counts: &mut Counts) {
        let [column, row] = position;
        let (cell, block) = (self.cells.block_at(position), blocks.block_at(position));
        let mut added = 4;
        let mut cover = |neighbor: usize, column: u32, row: u32| {
            if self.deposited[neighbor] > 0 {
                // The voxel covers a side of its neighbor, too.
                let other = blocks.block_at([column, row]);
                if other == block {
                    added -= 2;
                } else {
                    added -= 1;
                    counts.open_sides[other] -= 1;
                }
            }
        };
        cover(cell - 1, column.wrapping_sub(1), row);
        cover(cell + 1, column + 1, row);
        cover(cell - self.cells.width, column, row.wrapping_sub(1));
        cover(cell + self.cells.width, column, row + 1);
        counts.new[block] += 1;
        counts.open_sides[block] += added;
        self.deposited[cell] = 1;
    }

    /// The counts of all voxels that are deposited, in the last of some sizes of blocks, each twice
    /// as wide as the one before, from two cells on; in blocks of one cell without any.
    ///
    /// Linear in the number of blocks.
    pub(super) fn counts<'b>(&self, sizes: impl Iterator<Item = &'b Blocks>) -> Counts {
        let mut counts = self.counts_of_cells();
        let mut fine = self.cells;
        for coarse in sizes {
            counts.new = coarse.sums(fine, &counts.new);
            counts.open_sides = coarse.sums(fine, &counts.open_sides);
            fine = coarse;
        }
        counts
    }

    fn counts_of_cells(&self) -> Counts {
        let (width, count) = (self.cells.width, self.cells.len());
        let mut open_sides = vec![0; count];
        // All cells but the first and the last row, which are empty.
        let inside = count - 2 * width;
        let shifted = |first: usize| &self.deposited[first..][..inside];
        let (own, left, right) = (shifted(width), shifted(width - 1), shifted(width + 1));
        let (up, down) = (shifted(0), shifted(2 * width));
        for (cell, open) in open_sides[width..][..inside].iter_mut().enumerate() {
            let covered = left[cell] + right[cell] + up[cell] + down[cell];
            *open = -own[cell] & (4 - covered);
        }
        Counts { new: self.deposited.clone(), open_sides }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use rand::seq::SliceRandom;
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::super::geometry::Extent;
    use super::super::tests::random_part;
    use super::*;

    /// Voxels and open sides of each block by their definition.
    fn slow_counts(deposited: &HashSet<[u32; 2]>, blocks: &Blocks) -> Counts {
        let empty = || vec![0; blocks.len()];
        let mut counts = Counts { new: empty(), open_sides: empty() };
        for &[x, y] in deposited {
            let neighbors =
                [[x.wrapping_sub(1), y], [x + 1, y], [x, y.wrapping_sub(1)], [x, y + 1]];
            let open = neighbors.iter().filter(|cell| !deposited.contains(*cell)).count();
            counts.new[blocks.block([x, y])] += 1;
            counts.open_sides[blocks.block([x, y])] += open as i32;
        }
        counts
    }

    #[test]
    fn counts_are_those_of_their_definition() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let mut layers = 0;
        while layers < 500 {
            let part = random_part(&mut rng);
            let layer = rng.next_u64() as usize % 6;
            let width = part.frame.width;
            let mut cells: Vec<u32> = part.cells(layer).collect();
            if cells.is_empty() {
                continue;
            }
            layers += 1;
            cells.shuffle(&mut rng);
            let mut events = Vec::new();
            for cell in cells {
                let seconds = 0.5 + (rng.next_u64() % 8) as f64 / 8.0;
                let voxel = [cell % width, cell / width, layer as u32];
                events.push(DepositionEvent { voxel: Some(voxel), seconds });
                if rng.next_u64().is_multiple_of(3) {
                    events.push(DepositionEvent::pause(seconds));
                }
            }
            let extent = Extent::new(&part, layer, &[1, 2]);
            let mut sizes = vec![Blocks::new(&part, &extent, 1)];
            for size in 0..3 {
                sizes.push(sizes[size].coarser(&extent));
            }
            let total_s: f64 = events.iter().map(|event| event.seconds).sum();
            let mut births = Births::new(&events, &sizes[0]);
            let mut clock_s = 0.0;
            // The sizes of blocks change from time to time, and counts are made from nothing then.
            while clock_s < total_s {
                let size = rng.next_u64() as usize % 4;
                let mut counts = births.counts(sizes[1..=size].iter());
                for _ in 0..3 {
                    clock_s += total_s * (rng.next_u64() % 16) as f64 / 64.0;
                    births.count_until(clock_s, &sizes[size], &mut counts);
                    let mut begin_s = 0.0;
                    let mut deposited = HashSet::new();
                    for event in &events {
                        if let Some([x, y, _]) = event.voxel
                            && begin_s + 0.5 * event.seconds <= clock_s
                        {
                            deposited.insert([x, y]);
                        }
                        begin_s += event.seconds;
                    }
                    let slow = slow_counts(&deposited, &sizes[size]);
                    assert_eq!(counts, slow);
                    assert_eq!(births.counts(sizes[1..=size].iter()), slow);
                }
            }
        }
    }
}
