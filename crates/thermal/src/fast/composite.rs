//! Steps of a large part: of its blocks, and of the voxels of a region around recent births.

use crate::law::Law;
use crate::patch::Patch;
use crate::piece::{self, Piece};
use crate::state::Voxels;
use crate::tally::Tally;

use super::Fast;
use super::far::{FarField, Flows, Region, Rim};
use super::nested::{Nested, Outer};
use super::window::Window;

/// How many of the longest steps of the voxels the blocks take in one: what crosses the border is the mean over that time.
const STEPS_IN_ONE: f64 = 2.0;

impl Fast {
    /// Takes the whole part through pieces that fit into one step of a level on blocks; through those around the window, if
    /// there is one, in steps of the voxels.
    pub(super) fn composite(
        &mut self,
        whole: &mut Nested<'_>,
        voxels: &mut Voxels<'_>,
        law: &Law,
        level: usize,
        pieces: &[Piece],
        window: Option<Window>,
    ) {
        whole.take_up(&self.memory.changes, law);
        let seconds = piece::seconds(pieces);
        let (tally, top) = (voxels.tally(), voxels.top());
        let far = &mut self.memory.far;
        far.begin(whole.patch, tally, law, top);
        let Some(window) = window else {
            far.step(seconds, &[], tally, law, top);
            self.now += seconds;
            return;
        };
        let region = Region::around(window, tally);
        let mut near = self.memory.windows.pop().unwrap_or_default();
        near.copy_window(region.window(tally, whole.patch.shape), whole.patch);
        far.add(1.0, &mut near, region, tally, law);
        let rim = Rim::close(&mut near, whole.patch, region, tally, law);
        let parts = (seconds / (STEPS_IN_ONE * self.levels[level - 1].seconds)).ceil();
        let flows = flows(far, pieces, seconds / parts, region, tally, law, top);
        let outer = Outer::Far { rim: &rim, flows: &flows };
        let mut finer = Nested::new(&mut near, whole.known, outer, seconds);
        self.advance(&mut finer, voxels, law, level - 1, pieces);
        finer.take_up(&self.memory.changes, law);
        whole.take_up(&self.memory.changes, law);
        rim.clear(&mut near);
        let (tally, far) = (voxels.tally(), &mut self.memory.far);
        far.look(&near, region, tally, law, voxels.top());
        far.add(-1.0, &mut near, region, tally, law);
        near.put_back(whole.patch);
        self.memory.windows.push(near);
    }

    /// Gives the voxels of the whole part what the far field has in stock for them.
    pub(super) fn end_composite(&mut self, whole: &mut Patch, voxels: &Voxels<'_>, law: &Law) {
        self.memory.far.end(whole, voxels.tally(), law, voxels.top());
    }
}

/// Takes the blocks through some pieces, in parts of so many seconds, and gives what crosses a region's border in each.
fn flows(
    far: &mut FarField,
    pieces: &[Piece],
    part_s: f64,
    region: Region,
    tally: &Tally,
    law: &Law,
    top: usize,
) -> Vec<Flows> {
    let border: Vec<_> = region.border(tally).collect();
    let (mut flows, mut rest, mut time) = (Vec::new(), pieces, 0.0);
    while !rest.is_empty() {
        let end = (flows.len() + 1) as f64 * part_s;
        // The middle of a piece tells where it belongs, so that none is left over by rounding.
        let now = rest.iter().take_while(|piece| {
            let middle = time + piece.seconds / 2.0;
            time += if middle < end { piece.seconds } else { 0.0 };
            middle < end
        });
        let (now, later) = rest.split_at(now.count());
        let births = now.iter().filter(|piece| piece.born);
        let sources: Vec<_> = births.filter_map(|birth| source(far, birth, part_s, tally, law)).collect();
        sources.iter().for_each(|&(block, rate)| far.heat(block, rate));
        flows.push(far.step(part_s, &border, tally, law, top));
        sources.iter().for_each(|&(block, rate)| far.heat(block, -rate));
        rest = later;
    }
    flows
}

/// What a birth is to the blocks: which of them it heats, and by how much in a time, K/s in voxels.
///
/// That is its own block, or the one below if its own is empty yet; one on the empty plate heats none.
fn source(far: &FarField, birth: &Piece, seconds: f64, tally: &Tally, law: &Law) -> Option<(usize, f32)> {
    let [x, y, z] = birth.held?;
    let (block, theta) = [z, z - 1]
        .into_iter()
        .filter(|&z| z > 0)
        .map(|z| tally.block([x, y, z]))
        .find_map(|block| Some((block, far.theta(block)?)))?;
    // While it is held, it gives heat without getting colder: to the voxel below, and to one or two beside it.
    let held = 1.0 + (law.vertical + 1.5 * law.lateral) * birth.seconds as f32;
    Some((block, held * (law.birth - theta) / seconds as f32))
}
