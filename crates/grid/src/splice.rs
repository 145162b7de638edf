//! Which switches keep a path whole, decided from positions, and how the path runs afterwards.
//!
//! Removing r links cuts the path into r + 1 runs.
//! The added links join the ends of the runs anew; the result is one path exactly if following them
//! from the first run reaches every other one.
//! No walk along the cells is needed, and only the positions between the first and the last cut can
//! change.
//!
//! For two switches there is a closed form.
//! Say a switch *opens* if its two links are passed in the same direction (then it alone turns the
//! run between its cuts round and leaves one path) and *closes* if they are passed in opposite
//! directions (then it alone makes that run a cycle).
//! Two switches are *interleaved* if exactly one cut of the second lies between the cuts of the
//! first.
//! Then:
//! - two that close keep the path exactly if interleaved: only then does the second join the first
//!   one's cycle to the rest;
//! - one that closes and one that opens likewise, for a switch between a cycle and a path joins
//!   them in any direction;
//! - two that open keep the path exactly if *not* interleaved: if they are, the first turns one
//!   link of the second round and so makes it close.
//!
//! Together: interleaved exactly if at least one closes.

use crate::path::{link, square};
use crate::{Cell, Path, Sides, Switch};

/// Where a switch cuts a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cuts {
    /// Position before the first cut link.
    pub first: u32,
    /// Position before the second cut link; greater than `first`.
    pub second: u32,
    /// Whether the switch alone would make the positions `first + 1 ..= second` a cycle (otherwise
    /// it turns them round).
    pub closes: bool,
}

impl Cuts {
    /// Whether two switches with these cuts, all four different, together keep one path.
    #[inline]
    #[allow(
        clippy::needless_bitwise_bool,
        reason = "no branch: which way it goes is as good as random"
    )]
    pub fn keep_whole(self, other: Self) -> bool {
        let within = |cut: u32| (self.first < cut) & (cut < self.second);
        (within(other.first) ^ within(other.second)) == (self.closes | other.closes)
    }
}

impl Path {
    /// Where the links of the unit cell at `corner` along `from` cut the path.
    ///
    /// Both links must be there, as [`Path::sides`] tells; otherwise the answer means nothing, or
    /// there is a panic where no unit cell begins.
    #[inline]
    pub fn cuts(&self, corner: Cell, from: Sides) -> Cuts {
        let (a, d) = (corner as usize, corner as usize + self.width as usize + 1);
        let (b, c) = match from {
            Sides::Horizontal => (a + 1, d - 1),
            Sides::Vertical => (d - 1, a + 1),
        };
        let (a, b) = (self.position[a], self.position[b]);
        let (c, d) = (self.position[c], self.position[d]);
        let (one, two) = (a.min(b), c.min(d));
        Cuts { first: one.min(two), second: one.max(two), closes: (a < b) != (c < d) }
    }

    /// Whether `first` and then `second` leave a path of as many pieces.
    /// O(1).
    #[inline]
    pub fn allows_pair(&self, first: Switch, second: Switch) -> bool {
        let step = second.corner().wrapping_sub(first.corner()) as i32;
        let width = self.width as i32;
        // A side that the two unit cells share has been switched when the second one's turn comes.
        let (shared, along) = match step {
            1 => (square::LEFT, Sides::Vertical),
            -1 => (square::RIGHT, Sides::Vertical),
            _ if step == width => (square::TOP, Sides::Horizontal),
            _ if step == -width => (square::BOTTOM, Sides::Horizontal),
            _ => (0, Sides::Horizontal),
        };
        if step == 0 || (shared != 0 && second.from() == along) {
            // The second takes out a link that the first put in: not one of the path's cuts.
            return self.allows(&[first, second]);
        }
        self.square(first.corner()) == before(first.from())
            && self.square(second.corner()) ^ shared == before(second.from())
            && self
                .cuts(first.corner(), first.from())
                .keep_whole(self.cuts(second.corner(), second.from()))
    }

    /// Whether these switches, one after the other, leave a path of as many pieces.
    ///
    /// O(n log n) for n switches; for two, [`Path::allows_pair`] is faster.
    pub fn allows(&self, switches: &[Switch]) -> bool {
        Splicer::default().plan(self, switches)
    }

    /// Applies the switches one after the other, if together they leave a path of as many pieces;
    /// otherwise it changes nothing and gives false.
    ///
    /// Costs what [`Path::allows`] does, and one rewritten position for each cell between the first
    /// and the last cut.
    pub fn apply(&mut self, switches: &[Switch]) -> bool {
        let mut splicer = std::mem::take(&mut self.splicer);
        let allowed = splicer.plan(self, switches);
        if allowed {
            splicer.rewrite(self);
        }
        self.splicer = splicer;
        allowed
    }

    /// Takes applied switches back: the path is again, position by position, what it was before
    /// [`Path::apply`].
    ///
    /// # Panics
    /// If the path has changed since and can't be taken back.
    pub fn undo(&mut self, switches: &[Switch]) {
        let back: Vec<Switch> = switches.iter().rev().map(|switch| switch.inverse()).collect();
        assert!(self.apply(&back), "only switches that were just applied can be taken back");
    }
}

/// The bits of a unit cell that a switch can take the links `from` out of.
fn before(from: Sides) -> u8 {
    match from {
        Sides::Horizontal => square::HORIZONTAL,
        Sides::Vertical => square::VERTICAL,
    }
}

/// A link between a cell and its right or lower neighbour, and whether the path has it.
#[derive(Clone, Copy, Debug)]
struct Link {
    cell: Cell,
    along: Sides,
    present: bool,
}

/// Plans a combination of switches; keeps its buffers from one plan to the next.
#[derive(Clone, Debug, Default)]
pub(crate) struct Splicer {
    /// Links that end up otherwise than they are now.
    changed: Vec<Link>,
    /// Positions before the removed links, rising.
    cuts: Vec<u32>,
    /// For each end of a run (2 * run: its first cell, 2 * run + 1: its last), the end that an
    /// added link joins it to.
    joined: Vec<u32>,
    /// The inner runs in their new order: first position, last position, whether passed backwards.
    runs: Vec<(u32, u32, bool)>,
    /// The cells of the rewritten stretch, as they were.
    old: Vec<Cell>,
}

const FREE: u32 = u32::MAX;

impl Splicer {
    /// Works out the new order of the runs; false if the switches don't apply or leave more than
    /// one path.
    fn plan(&mut self, path: &Path, switches: &[Switch]) -> bool {
        self.changed.clear();
        for (index, &switch) in switches.iter().enumerate() {
            let applies =
                if switches[..index].iter().any(|&earlier| share_a_side(path, earlier, switch)) {
                    self.toggle(path, switch)
                } else {
                    self.take(path, switch)
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

    /// Notes the four links of a switch that shares none with those before it; false if it does not
    /// apply.
    fn take(&mut self, path: &Path, switch: Switch) -> bool {
        let applies = path.square(switch.corner()) == before(switch.from());
        if applies {
            let present = |along: Sides| along == switch.from();
            let sides = sides(path, switch.corner());
            self.changed.extend(sides.map(|(cell, along)| Link {
                cell,
                along,
                present: present(along),
            }));
        }
        applies
    }

    /// Notes the four links that a switch changes, given those before it; false if it does not
    /// apply.
    fn toggle(&mut self, path: &Path, switch: Switch) -> bool {
        let corner = switch.corner();
        let is_corner =
            path.links.get(corner as usize).is_some_and(|bits| bits & link::CORNER != 0);
        if !is_corner {
            return false;
        }
        for (cell, along) in sides(path, corner) {
            let known =
                self.changed.iter().position(|link| (link.cell, link.along) == (cell, along));
            let present = match along {
                Sides::Horizontal => path.linked_right(cell),
                Sides::Vertical => path.linked_below(cell),
            };
            let now = present != known.is_some();
            if now != (along == switch.from()) {
                return false;
            }
            match known {
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
            // A run of one cell has both ends there; it does not matter which link takes which.
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

    /// Follows the joined ends from the first run; false if they come to the last one before having
    /// seen all.
    fn follow(&mut self) -> bool {
        self.runs.clear();
        let last = self.cuts.len() as u32;
        let mut leaving = 1;
        for _ in 1..last {
            let entering = self.joined[leaving as usize];
            let (run, backwards) = (entering / 2, entering % 2 == 1);
            if run == last {
                return false;
            }
            self.runs.push((self.cuts[run as usize - 1] + 1, self.cuts[run as usize], backwards));
            leaving = entering ^ 1;
        }
        true
    }

    /// Rewrites order, positions and links as planned.
    fn rewrite(&mut self, path: &mut Path) {
        for link in &self.changed {
            let (a, b) = ends(path, *link);
            let (of_a, of_b) = match link.along {
                Sides::Horizontal => (link::RIGHT, link::LEFT),
                Sides::Vertical => (link::BELOW, link::ABOVE),
            };
            path.links[a as usize] ^= of_a;
            path.links[b as usize] ^= of_b;
        }
        let Some(&(base, ..)) = self.runs.iter().min() else { return };
        let mut place = base;
        let unmoved = self.runs.iter().take_while(|&&(first, last, backwards)| {
            let stays = first == place && !backwards;
            if stays {
                place = last + 1;
            }
            stays
        });
        let unmoved = unmoved.count();
        let start = place;
        let end = self.cuts[self.cuts.len() - 1] + 1;
        self.old.clear();
        self.old.extend_from_slice(&path.order[start as usize..end as usize]);
        for &(first, last, backwards) in &self.runs[unmoved..] {
            let run = &self.old[(first - start) as usize..=(last - start) as usize];
            let order = &mut path.order[place as usize..place as usize + run.len()];
            order.copy_from_slice(run);
            if backwards {
                order.reverse();
            }
            for (place, &cell) in (place..).zip(&*order) {
                path.position[cell as usize] = place;
            }
            place += run.len() as u32;
        }
    }
}

/// The four sides of a unit cell.
fn sides(path: &Path, corner: Cell) -> [(Cell, Sides); 4] {
    [
        (corner, Sides::Horizontal),
        (corner + path.width, Sides::Horizontal),
        (corner, Sides::Vertical),
        (corner + 1, Sides::Vertical),
    ]
}

fn share_a_side(path: &Path, one: Switch, other: Switch) -> bool {
    let step = one.corner().abs_diff(other.corner());
    step <= 1 || step == path.width
}

fn ends(path: &Path, link: Link) -> (Cell, Cell) {
    match link.along {
        Sides::Horizontal => (link.cell, link.cell + 1),
        Sides::Vertical => (link.cell, link.cell + path.width),
    }
}

#[cfg(test)]
mod tests;
