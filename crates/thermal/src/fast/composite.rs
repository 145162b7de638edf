//! Steps of a large part: of its blocks, and of the voxels of a region around recent births.

use crate::block_grid::BlockGrid;
use crate::coefficients::Coefficients;
use crate::interval::{self, Interval};
use crate::patch::Patch;
use crate::state::Voxels;

use super::FastStepper;
use super::far::{BorderFluxes, FarField, FluxHalo, Region};
use super::nested::{HaloSource, NestedPatch};
use super::window::Window;

/// How many of the longest steps of the voxels the blocks take in one: what crosses the border is
/// the mean over that time.
const STEPS_IN_ONE: f64 = 2.0;

impl FastStepper {
    /// Takes the whole part through intervals that fit into one step of a level on blocks; through
    /// those around the window, if there is one, in steps of the voxels.
    pub(super) fn composite(
        &mut self,
        whole: &mut NestedPatch<'_>,
        voxels: &mut Voxels<'_>,
        coefficients: &Coefficients,
        level: usize,
        intervals: &[Interval],
        window: Option<Window>,
    ) {
        whole.apply(&self.memory.changes, coefficients);
        let seconds = interval::total_seconds(intervals);
        let (block_grid, top) = (voxels.block_grid(), voxels.top());
        let far = &mut self.memory.far;
        far.begin(whole.patch, block_grid, coefficients, top);
        let Some(window) = window else {
            far.step(seconds, &[], block_grid, coefficients, top);
            self.now += seconds;
            return;
        };
        let region = Region::around(window, block_grid);
        let mut near = self.memory.windows.pop().unwrap_or_default();
        near.copy_window(region.window(block_grid, whole.patch.shape), whole.patch);
        far.add(1.0, &mut near, region, block_grid, coefficients);
        let halo = FluxHalo::close(&mut near, whole.patch, region, block_grid, coefficients);
        let parts = (seconds / (STEPS_IN_ONE * self.levels[level - 1].seconds)).ceil() as usize;
        let flows = flows(far, intervals, seconds, parts, region, block_grid, coefficients, top);
        let outer = HaloSource::Far { halo: &halo, flows: &flows };
        let mut finer = NestedPatch::new(&mut near, whole.known, outer, seconds);
        self.advance(&mut finer, voxels, coefficients, level - 1, intervals)
            .expect("a window is not interrupted");
        finer.apply(&self.memory.changes, coefficients);
        whole.apply(&self.memory.changes, coefficients);
        halo.clear(&mut near);
        let (block_grid, far) = (voxels.block_grid(), &mut self.memory.far);
        far.restrict(&near, region, block_grid, coefficients, voxels.top());
        far.add(-1.0, &mut near, region, block_grid, coefficients);
        near.put_back(whole.patch);
        self.memory.windows.push(near);
    }

    /// Gives the voxels of the whole part what the far field has in stock for them.
    pub(super) fn end_composite(
        &mut self,
        whole: &mut Patch,
        voxels: &Voxels<'_>,
        coefficients: &Coefficients,
    ) {
        self.memory.far.end(whole, voxels.block_grid(), coefficients, voxels.top());
    }
}

/// Takes the blocks through some intervals of so many seconds together, in equal parts, and gives
/// what crosses a region's border in each.
#[expect(clippy::too_many_arguments, reason = "a step's own, and what all steps on blocks need")]
fn flows(
    far: &mut FarField,
    mut intervals: &[Interval],
    seconds: f64,
    parts: usize,
    region: Region,
    block_grid: &BlockGrid,
    coefficients: &Coefficients,
    top: usize,
) -> Vec<BorderFluxes> {
    let border: Vec<_> = region.border(block_grid).collect();
    let part_s = seconds / parts as f64;
    let mut time = 0.0;
    let mut part = |end: usize| {
        // The middle of a interval tells where it belongs, however many parts it lasts.
        let now = intervals.iter().take_while(|interval| {
            let middle = time + interval.seconds / 2.0;
            let within = end == parts || middle < end as f64 * part_s;
            time += if within { interval.seconds } else { 0.0 };
            within
        });
        let (now, later) = intervals.split_at(now.count());
        intervals = later;
        let births = now.iter().filter(|interval| interval.born);
        let sources: Vec<_> = births
            .filter_map(|birth| source(far, birth, part_s, block_grid, coefficients))
            .collect();
        sources.iter().for_each(|&(block, rate)| far.heat(block, rate));
        let flows = far.step(part_s, &border, block_grid, coefficients, top);
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
    birth: &Interval,
    seconds: f64,
    block_grid: &BlockGrid,
    coefficients: &Coefficients,
) -> Option<(usize, f32)> {
    let [x, y, z] = birth.held?;
    let (block, theta) = [z, z - 1]
        .into_iter()
        .filter(|&z| z > 0)
        .map(|z| block_grid.block([x, y, z]))
        .find_map(|block| Some((block, far.theta(block)?)))?;
    // While it is held, it gives heat without getting colder: to the voxel below, and to one or two
    // beside it.
    let held = 1.0 + (coefficients.vertical + 1.5 * coefficients.lateral) * birth.seconds as f32;
    Some((block, held * (coefficients.birth_theta - theta) / seconds as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fast::level::{Accuracy, levels};
    use crate::material::ThermalMaterial;
    use crate::patch::Shape;
    use crate::process::ProcessParameters;
    use crate::state::State;

    /// A step is as long for the blocks as for the voxels, wherever its intervals begin and end.
    #[test]
    fn blocks_take_all_of_the_time() {
        let coefficients = Coefficients::new(
            &ThermalMaterial::abs(),
            &ProcessParameters::default(),
            0.5e-3,
            0.25e-3,
        );
        let mut state = State::empty(Shape::around(30, 20, 12), &coefficients);
        let (state_mut, mut changes) = (state.make_mut(), Vec::new());
        let (patch, mut voxels) = (state_mut.patch, state_mut.voxels);
        for i in 0..30 * 20 * 12 {
            voxels.birth(
                [i % 30 + 1, i / 30 % 20 + 1, i / 600 + 1],
                patch,
                &coefficients,
                &mut changes,
            );
            patch.apply(&changes, &coefficients);
            changes.clear();
        }
        let (block_grid, top) = (voxels.block_grid(), voxels.top());
        let region = Region { low: [1, 2, 1], high: [16, 5, 4] };
        let seconds = levels(Accuracy::High, &coefficients)[4].seconds;
        let pause = |seconds| Interval { held: None, born: false, seconds, completes: None };
        let many = vec![pause(seconds / 100.0); 100];
        let cases = [
            vec![pause(seconds)],
            [&[pause(0.1 * seconds)], &many[..20], &[pause(0.7 * seconds)]].concat(),
        ];
        for parts in 1..=5 {
            let ends = [&many].into_iter().chain(&cases).map(|intervals| {
                let mut far = FarField::default();
                far.begin(patch, block_grid, &coefficients, top);
                let flows = flows(
                    &mut far,
                    intervals,
                    seconds,
                    parts,
                    region,
                    block_grid,
                    &coefficients,
                    top,
                );
                assert_eq!(flows.len(), parts);
                (0..block_grid.shape.len()).map(|block| far.theta(block)).collect::<Vec<_>>()
            });
            let ends: Vec<_> = ends.collect();
            assert!(ends.iter().all(|end| *end == ends[0]), "in {parts} parts");
        }
    }
}
