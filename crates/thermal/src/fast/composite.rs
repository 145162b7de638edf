//! Composite steps of large parts: all blocks of the far field, and the voxels of a region around
//! recent births.
//!
//! `far/mod.rs` explains the method.
//! One step is:
//!
//! 1. Copy the region's voxels into a window, and add the pending change to make them current.
//! 2. Step the blocks, with the births as sources of heat, and record what crosses the border of
//!    the region.
//! 3. Step the window on voxels, by the next lower level, with just these fluxes across its border.
//! 4. Restrict the window: the blocks of the region take over the result of the voxels.
//! 5. Subtract the pending change again and write the voxels back.

use crate::block_grid::BlockGrid;
use crate::coefficients::Coefficients;
use crate::interval::{self, Interval};
use crate::patch::Patch;
use crate::state::OccupancyMut;

use super::far::{BorderFluxes, FarField, FluxHalo, Region};
use super::nested::{HaloSource, NestedPatch};
use super::stepper::FastStepper;
use super::window::Window;

/// Maximum length of a substep of the blocks, in longest steps of the level below.
///
/// The fluxes across the border are constant within a substep.
const VOXEL_STEPS_PER_SUBSTEP: f64 = 2.0;

impl FastStepper {
    /// Steps the whole part through intervals that fit into one step of a level on blocks.
    /// The voxels of a region around `window`, if there is one, are stepped by the level below.
    pub(super) fn step_composite(
        &mut self,
        whole: &mut NestedPatch<'_>,
        occupancy: &mut OccupancyMut<'_>,
        coefficients: &Coefficients,
        level: usize,
        intervals: &[Interval],
        window: Option<Window>,
    ) {
        whole.apply(&self.buffers.changes, coefficients);
        let seconds = interval::total_seconds(intervals);
        let (block_grid, top) = (occupancy.block_grid(), occupancy.top());
        let far = &mut self.buffers.far;
        far.begin(whole.patch, block_grid, coefficients, top);
        let Some(window) = window else {
            far.step(seconds, &[], block_grid, coefficients, top);
            self.now += seconds;
            return;
        };
        let region = Region::around(window, block_grid);
        let mut near = self.buffers.windows.pop().unwrap_or_default();
        near.copy_window(region.window(block_grid, whole.patch.shape), whole.patch);
        far.add_change(1.0, &mut near, region, block_grid, coefficients);
        let halo = FluxHalo::close(&mut near, whole.patch, region, block_grid, coefficients);
        let substep_s = VOXEL_STEPS_PER_SUBSTEP * self.levels[level - 1].seconds;
        let substeps = (seconds / substep_s).ceil() as usize;
        let fluxes =
            step_blocks(far, intervals, seconds, substeps, region, block_grid, coefficients, top);
        let source = HaloSource::Fluxes { halo: &halo, substeps: &fluxes };
        let mut finer = NestedPatch::new(&mut near, whole.applied, source, seconds);
        self.advance(&mut finer, occupancy, coefficients, level - 1, intervals)
            .expect("a window is not interrupted");
        finer.apply(&self.buffers.changes, coefficients);
        whole.apply(&self.buffers.changes, coefficients);
        // The halo holds fluxes, which must not be summed up as temperatures.
        halo.clear(&mut near);
        // Births have changed the block grid.
        // A block that gets its first voxels here starts without a pending change.
        let (block_grid, far) = (occupancy.block_grid(), &mut self.buffers.far);
        far.restrict(&near, region, block_grid, coefficients, occupancy.top());
        far.add_change(-1.0, &mut near, region, block_grid, coefficients);
        near.write_back(whole.patch);
        self.buffers.windows.push(near);
    }

    /// Adds the pending change of the far field to the voxels of the whole part, and deactivates
    /// the far field.
    pub(super) fn end_far_field(
        &mut self,
        whole: &mut Patch,
        occupancy: &OccupancyMut<'_>,
        coefficients: &Coefficients,
    ) {
        self.buffers.far.end(whole, occupancy.block_grid(), coefficients, occupancy.top());
    }
}

/// Steps the blocks through some intervals, which take `seconds` together, in equal substeps, and
/// returns the fluxes across a region's border in each of them.
#[expect(clippy::too_many_arguments, reason = "the step, and what all steps on blocks need")]
fn step_blocks(
    far: &mut FarField,
    mut intervals: &[Interval],
    seconds: f64,
    substeps: usize,
    region: Region,
    block_grid: &BlockGrid,
    coefficients: &Coefficients,
    top: usize,
) -> Vec<BorderFluxes> {
    let border: Vec<_> = region.border(block_grid).collect();
    let substep_s = seconds / substeps as f64;
    let mut time = 0.0;
    let mut take_substep = |end: usize| {
        // An interval belongs to the substep that contains its midpoint, even if it is longer than
        // that.
        let now = intervals.iter().take_while(|interval| {
            let midpoint = time + interval.seconds / 2.0;
            let within = end == substeps || midpoint < end as f64 * substep_s;
            time += if within { interval.seconds } else { 0.0 };
            within
        });
        let (now, later) = intervals.split_at(now.count());
        intervals = later;
        let births = now.iter().filter(|interval| interval.born);
        let sources: Vec<_> = births
            .filter_map(|birth| birth_source(far, birth, substep_s, block_grid, coefficients))
            .collect();
        sources.iter().for_each(|&(block, rate)| far.add_source(block, rate));
        let fluxes = far.step(substep_s, &border, block_grid, coefficients, top);
        sources.iter().for_each(|&(block, rate)| far.add_source(block, -rate));
        fluxes
    };
    (1..=substeps).map(&mut take_substep).collect()
}

/// Heat source that stands for a birth in a step of the blocks: the flat index of the block, and
/// the rate, K voxels/s, when the heat is spread over `seconds`.
///
/// The block is the voxel's own, or the one below if its own has no voxels yet.
/// `None` if neither has voxels, as on the empty plate.
fn birth_source(
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
        .map(|z| block_grid.block_of([x, y, z]))
        .find_map(|block| Some((block, far.mean_theta(block)?)))?;
    // The nozzle holds the voxel at its birth temperature, so the part gains more than the voxel's
    // own heat: also what the voxel conducts, during the interval, to the voxel below and to one or
    // two neighbours in the layer (1.5 on average).
    let conductance = coefficients.vertical + 1.5 * coefficients.lateral;
    let held = 1.0 + conductance * birth.seconds as f32;
    Some((block, held * (coefficients.birth_theta - theta) / seconds as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fast::level::{Accuracy, levels};
    use crate::material::ThermalMaterial;
    use crate::process::ProcessParameters;
    use crate::shape::Shape;
    use crate::state::State;

    #[test]
    fn blocks_are_stepped_through_the_whole_time_however_intervals_are_cut() {
        let coefficients = Coefficients::new(
            &ThermalMaterial::abs(),
            &ProcessParameters::default(),
            0.5e-3,
            0.25e-3,
        );
        let mut state = State::unprinted(Shape::with_halo(30, 20, 12), &coefficients);
        let (state_mut, mut changes) = (state.make_mut(), Vec::new());
        let (patch, mut occupancy) = (state_mut.patch, state_mut.occupancy);
        for i in 0..30 * 20 * 12 {
            let position = [i % 30 + 1, i / 30 % 20 + 1, i / 600 + 1];
            occupancy.birth(position, patch, &coefficients, &mut changes);
            patch.apply(&changes, &coefficients);
            changes.clear();
        }
        let (block_grid, top) = (occupancy.block_grid(), occupancy.top());
        let region = Region { low: [1, 2, 1], high: [16, 5, 4] };
        let seconds = levels(Accuracy::High, &coefficients)[4].seconds;
        let pause = |seconds| Interval { held: None, born: false, seconds, completes: None };
        let many = vec![pause(seconds / 100.0); 100];
        let cases = [
            vec![pause(seconds)],
            [&[pause(0.1 * seconds)], &many[..20], &[pause(0.7 * seconds)]].concat(),
        ];
        for substeps in 1..=5 {
            let ends = [&many].into_iter().chain(&cases).map(|intervals| {
                let mut far = FarField::default();
                far.begin(patch, block_grid, &coefficients, top);
                let fluxes = step_blocks(
                    &mut far,
                    intervals,
                    seconds,
                    substeps,
                    region,
                    block_grid,
                    &coefficients,
                    top,
                );
                assert_eq!(fluxes.len(), substeps);
                let blocks = 0..block_grid.shape.len();
                blocks.map(|block| far.mean_theta(block)).collect::<Vec<_>>()
            });
            let ends: Vec<_> = ends.collect();
            assert!(ends.iter().all(|end| *end == ends[0]), "in {substeps} substeps");
        }
    }
}
