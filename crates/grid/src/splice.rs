//! Applies any number of switches to a path at once.
//!
//! Several switches together can keep one path although some of them alone would not, so they are
//! checked and applied as a whole.
//! No walk along the cells is needed:
//!
//! 1. Add up the changes of all switches.
//!    A link that one switch puts in and a later one takes out does not change.
//! 2. The r links that are removed cut the path into r + 1 **runs** of consecutive positions.
//!    Inside a run nothing changes, so only its two ends matter.
//! 3. The r links that are added join ends of runs.
//!    A switch keeps the number of links of every cell, so every end at a cut is joined to exactly
//!    one other end.
//!    Only the first end of the first run and the last end of the last run stay free.
//! 4. Start at the first run and follow: leave a run at one end, enter the run that this end is
//!    joined to, leave that one at its other end, and so on, until the last run is reached.
//!    If all runs were visited on the way, the result is one path.
//!    Otherwise those left out form cycles.
//! 5. The order of the visits is the new order of the runs; a run that is entered at its last cell
//!    is reversed.
//!    The first and the last run keep their positions, so only the positions between the first and
//!    the last cut are rewritten.
//!
//! ```text
//!   positions   0 1 2 | 3 4 | 5 6 7 | 8 9          cuts after 2, 4 and 7: runs A, B, C and D
//!   joined      2-5, 7-4, 3-8
//!   follow      A, C, B backwards, D               0 1 2  5 6 7  4 3  8 9
//! ```
//!
//! A path in several pieces is treated as one line, too: the jumps between pieces lie inside runs
//! and move with them.

use crate::bits::link;
use crate::cuts::linked_sides;
use crate::splice_plan::{Link, Run, SplicePlan};
use crate::{Cell, Path, Sides, Switch};

impl Path {
    /// Whether applying these switches one after the other is possible and keeps the number of
    /// pieces.
    ///
    /// O(n^2) for n switches, independent of the length of the path.
    /// For two switches, [`Path::allows_pair`] is faster.
    pub fn allows(&self, switches: &[Switch]) -> bool {
        SplicePlan::default().make(self, switches)
    }

    /// Applies the switches one after the other, if together they keep the number of pieces.
    /// Otherwise changes nothing and returns false.
    ///
    /// Costs what [`Path::allows`] costs, plus one rewritten position for each cell between the
    /// first and the last cut.
    pub fn apply(&mut self, switches: &[Switch]) -> bool {
        let mut plan = std::mem::take(&mut self.splice_plan);
        let allowed = plan.make(self, switches);
        if allowed {
            plan.carry_out(self);
        }
        self.splice_plan = plan;
        allowed
    }

    /// Undoes the switches of the latest [`Path::apply`]: every cell has its former position again.
    ///
    /// # Panics
    /// If the path has changed since then, so that the switches can't be undone.
    pub fn undo(&mut self, switches: &[Switch]) {
        let inverse: Vec<Switch> = switches.iter().rev().map(|switch| switch.inverse()).collect();
        assert!(self.apply(&inverse), "undo needs the switches that were applied last");
    }
}

const FREE: u32 = u32::MAX;

impl SplicePlan {
    /// Makes the plan; returns false if the switches cannot be applied or would split off a cycle.
    fn make(&mut self, path: &Path, switches: &[Switch]) -> bool {
        self.changed.clear();
        for (index, &switch) in switches.iter().enumerate() {
            let earlier = &switches[..index];
            let applies = if earlier.iter().any(|&other| may_share_a_side(path, other, switch)) {
                self.add_dependent(path, switch)
            } else {
                self.add_independent(path, switch)
            };
            if !applies {
                return false;
            }
        }
        self.cuts.clear();
        for link in &self.changed {
            if link.present {
                let (a, b) = ends(path, *link);
                self.cuts.push(path.position(a).min(path.position(b)));
            }
        }
        self.cuts.sort_unstable();
        self.join(path);
        self.follow()
    }

    /// Adds the four changes of a switch that shares no side with earlier ones; false if it does
    /// not apply to the path.
    fn add_independent(&mut self, path: &Path, switch: Switch) -> bool {
        let applies = path.square(switch.corner()) == linked_sides(switch.from());
        if applies {
            let sides = sides(path, switch.corner());
            self.changed.extend(sides.map(|(cell, along)| Link {
                cell,
                along,
                present: along == switch.from(),
            }));
        }
        applies
    }

    /// Adds the four changes of a switch to those of earlier ones, some of which may have changed
    /// its links; false if it does not apply after them.
    fn add_dependent(&mut self, path: &Path, switch: Switch) -> bool {
        let corner = switch.corner();
        let is_corner =
            path.links.get(corner as usize).is_some_and(|bits| bits & link::CORNER != 0);
        if !is_corner {
            return false;
        }
        for (cell, along) in sides(path, corner) {
            let earlier =
                self.changed.iter().position(|link| (link.cell, link.along) == (cell, along));
            let present = match along {
                Sides::Horizontal => path.linked_right(cell),
                Sides::Vertical => path.linked_below(cell),
            };
            let now = present != earlier.is_some();
            if now != (along == switch.from()) {
                return false;
            }
            match earlier {
                // A second change restores the link.
                Some(index) => drop(self.changed.swap_remove(index)),
                None => self.changed.push(Link { cell, along, present }),
            }
        }
        true
    }

    /// Joins the ends of the runs by the added links.
    fn join(&mut self, path: &Path) {
        let Self { changed, cuts, joined, .. } = self;
        joined.clear();
        joined.resize(2 * cuts.len() + 2, FREE);
        let free_end = |cell: Cell, joined: &[u32]| {
            let position = path.position(cell);
            let run = cuts.partition_point(|&cut| cut < position);
            // A run of a single cell has both its ends there and is its own reverse: it does not
            // matter which of its two added links is assigned to which end.
            let is_first = run > 0 && cuts[run - 1] + 1 == position && joined[2 * run] == FREE;
            2 * run as u32 + u32::from(!is_first)
        };
        for link in changed.iter().filter(|link| !link.present) {
            let (a, b) = ends(path, *link);
            let a = free_end(a, joined);
            joined[a as usize] = a;
            let b = free_end(b, joined);
            joined[a as usize] = b;
            joined[b as usize] = a;
        }
    }

    /// Follows the joined ends from the first run to the last; false if that skips a run.
    fn follow(&mut self) -> bool {
        self.runs.clear();
        let last = self.cuts.len() as u32;
        // End 1 is the last cell of run 0.
        let mut leaving = 1;
        for _ in 1..last {
            let entering = self.joined[leaving as usize];
            let (run, backwards) = (entering / 2, entering % 2 == 1);
            if run == last {
                // Runs that were not visited before the last one form cycles.
                return false;
            }
            let first = self.cuts[run as usize - 1] + 1;
            self.runs.push(Run { first, last: self.cuts[run as usize], backwards });
            leaving = entering ^ 1;
        }
        true
    }

    /// Rewrites order, positions and links of the path.
    fn carry_out(&mut self, path: &mut Path) {
        for link in &self.changed {
            let (a, b) = ends(path, *link);
            let (of_a, of_b) = match link.along {
                Sides::Horizontal => (link::RIGHT, link::LEFT),
                Sides::Vertical => (link::BELOW, link::ABOVE),
            };
            path.links[a as usize] ^= of_a;
            path.links[b as usize] ^= of_b;
        }
        let Some(&Run { first: mut position, .. }) = self.runs.iter().min() else { return };
        // The first runs may be in place already.
        let in_place = self.runs.iter().take_while(|run| {
            let stays = run.first == position && !run.backwards;
            if stays {
                position = run.last + 1;
            }
            stays
        });
        let in_place = in_place.count();
        let start = position;
        let end = self.cuts[self.cuts.len() - 1] + 1;
        self.old.clear();
        self.old.extend_from_slice(&path.order[start as usize..end as usize]);
        for &Run { first, last, backwards } in &self.runs[in_place..] {
            let run = &self.old[(first - start) as usize..=(last - start) as usize];
            let order = &mut path.order[position as usize..position as usize + run.len()];
            order.copy_from_slice(run);
            if backwards {
                order.reverse();
            }
            for (position, &cell) in (position..).zip(&*order) {
                path.position[cell as usize] = position;
            }
            position += run.len() as u32;
        }
    }
}

/// The four sides of a unit cell, each as the cell where the link begins and its direction.
fn sides(path: &Path, corner: Cell) -> [(Cell, Sides); 4] {
    [
        (corner, Sides::Horizontal),
        (corner + path.width, Sides::Horizontal),
        (corner, Sides::Vertical),
        (corner + 1, Sides::Vertical),
    ]
}

/// A quick test whether two unit cells may share a side.
/// Always true if they do; also true for some that lie at opposite ends of successive rows.
fn may_share_a_side(path: &Path, one: Switch, other: Switch) -> bool {
    let step = one.corner().abs_diff(other.corner());
    step <= 1 || step == path.width
}

/// The two cells of a link.
fn ends(path: &Path, link: Link) -> (Cell, Cell) {
    match link.along {
        Sides::Horizontal => (link.cell, link.cell + 1),
        Sides::Vertical => (link.cell, link.cell + path.width),
    }
}

#[cfg(test)]
mod tests;
