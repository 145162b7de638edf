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

/// How many of the longest steps of the voxels the blocks take in one: what crosses the border is
/// the mean over that time.
const STEPS_IN_ONE: f64 = 2.0;

impl Fast {
    /// Takes the whole part through pieces that fit into one step of a level on blocks; through
    /// those around the window, if there is one, in steps of the voxels.
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
        let parts = (seconds / (STEPS_IN_ONE * self.levels[level - 1].seconds)).ceil() as usize;
        let flows = flows(far, pieces, seconds, parts, region, tally, law, top);
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

/// Takes the blocks through some pieces of so many seconds together, in equal parts, and gives what
/// crosses a region's border in each.
#[expect(clippy::too_many_arguments, reason = "a step's own, and what all steps on blocks need")]
fn flows(
    far: &mut FarField,
    mut pieces: &[Piece],
    seconds: f64,
    parts: usize,
    region: Region,
    tally: &Tally,
    law: &Law,
    top: usize,
) -> Vec<Flows> {
    let border: Vec<_> = region.border(tally).collect();
    let part_s = seconds / parts as f64;
    let mut time = 0.0;
    let mut part = |end: usize| {
        // The middle of a piece tells where it belongs, however many parts it lasts.
        let now = pieces.iter().take_while(|piece| {
            let middle = time + piece.seconds / 2.0;
            let within = end == parts || middle < end as f64 * part_s;
            time += if within { piece.seconds } else { 0.0 };
            within
        });
        let (now, later) = pieces.split_at(now.count());
        pieces = later;
        let births = now.iter().filter(|piece| piece.born);
        let sources: Vec<_> =
            births.filter_map(|birth| source(far, birth, part_s, tally, law)).collect();
        sources.iter().for_each(|&(block, rate)| far.heat(block, rate));
        let flows = far.step(part_s, &border, tally, law, top);
        sources.iter().for_each(|&(block, rate)| far.heat(block, -rate));
        flows
    };
    (1..=parts).map(&mut part).collect()
}

/// What a birth is to the blocks: which of them it heats, and by how much in a time, K/s in voxels.
///
/// That is its own block, or the one below if its own is empty yet; one on the empty plate heats
/// none.
fn source(
    far: &FarField,
    birth: &Piece,
    seconds: f64,
    tally: &Tally,
    law: &Law,
) -> Option<(usize, f32)> {
    let [x, y, z] = birth.held?;
    let (block, theta) = [z, z - 1]
        .into_iter()
        .filter(|&z| z > 0)
        .map(|z| tally.block([x, y, z]))
        .find_map(|block| Some((block, far.theta(block)?)))?;
    // While it is held, it gives heat without getting colder: to the voxel below, and to one or two
    // beside it.
    let held = 1.0 + (law.vertical + 1.5 * law.lateral) * birth.seconds as f32;
    Some((block, held * (law.birth - theta) / seconds as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fast::level::{Accuracy, levels};
    use crate::material::Material;
    use crate::patch::Shape;
    use crate::process::Process;
    use crate::state::State;

    /// A step is as long for the blocks as for the voxels, wherever its pieces begin and end.
    #[test]
    fn blocks_take_all_of_the_time() {
        let law = Law::new(&Material::abs(), &Process::default(), 0.5e-3, 0.25e-3);
        let mut state = State::empty(Shape::around(30, 20, 12), &law);
        let (state_mut, mut changes) = (state.make_mut(), Vec::new());
        let (patch, mut voxels) = (state_mut.patch, state_mut.voxels);
        for i in 0..30 * 20 * 12 {
            voxels.birth([i % 30 + 1, i / 30 % 20 + 1, i / 600 + 1], patch, &law, &mut changes);
            patch.take_up(&changes, &law);
            changes.clear();
        }
        let (tally, top) = (voxels.tally(), voxels.top());
        let region = Region { low: [1, 2, 1], high: [16, 5, 4] };
        let seconds = levels(Accuracy::High, &law)[4].seconds;
        let pause = |seconds| Piece { held: None, born: false, seconds };
        let many = vec![pause(seconds / 100.0); 100];
        let cases = [
            vec![pause(seconds)],
            [&[pause(0.1 * seconds)], &many[..20], &[pause(0.7 * seconds)]].concat(),
        ];
        for parts in 1..=5 {
            let ends = [&many].into_iter().chain(&cases).map(|pieces| {
                let mut far = FarField::default();
                far.begin(patch, tally, &law, top);
                let flows = flows(&mut far, pieces, seconds, parts, region, tally, &law, top);
                assert_eq!(flows.len(), parts);
                (0..tally.shape.len()).map(|block| far.theta(block)).collect::<Vec<_>>()
            });
            let ends: Vec<_> = ends.collect();
            assert!(ends.iter().all(|end| *end == ends[0]), "in {parts} parts");
        }
    }
}
