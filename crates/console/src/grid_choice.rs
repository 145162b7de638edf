//! Choice of the cell grid: its position relative to the part, and the bead width.
//!
//! The number of pieces that a round part needs depends on where the grid lies and on the size of
//! its cells, so a command can try several grids.
//! All candidates are *screened*: a proven lower bound on the pieces of their layers ranks them,
//! which takes a fraction of the time of planning them.
//! The caller plans only the best few.

use anyhow::Context;
use beadwork_base::{Control, Interrupted, Threads};
use beadwork_grid::{Region, piece_bound};
use beadwork_part::slice::{Layer, Layers, Settings};
use ndarray::Array2;

use crate::part::CutPart;
use crate::{cancel, progress};

/// Difference between consecutive bead widths, as a share of the width that `--bead` gives.
const BEAD_STEP: f64 = 0.025;

/// Flags that name the grids to try.
#[derive(clap::Args)]
pub struct GridArgs {
    /// Try N x N positions of the grid relative to the part, and keep the cheapest plan.
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        value_parser = clap::value_parser!(u32).range(1..=16)
    )]
    phases: u32,
    /// Also try bead widths up to this many per cent narrower and wider, in steps of 2.5 %; 0
    /// to 10.
    #[arg(long, value_name = "PERCENT", default_value_t = 0.0, value_parser = percent)]
    bead_range: f64,
}

fn percent(text: &str) -> Result<f64, String> {
    let percent = text.parse().ok().filter(|percent| (0.0..=10.0).contains(percent));
    percent.ok_or_else(|| "expected a number from 0 to 10".to_owned())
}

impl GridArgs {
    /// Settings of all grids to try; the first one has the bead width of the flags and no shift.
    pub fn settings(&self, first: &Settings) -> Vec<Settings> {
        let steps = (self.bead_range / 100.0 / BEAD_STEP + 1e-9).floor() as i32;
        let mut widths: Vec<i32> = (-steps..=steps).collect();
        // The width of the flags first, then those closest to it.
        widths.sort_by_key(|step| (step.abs(), *step));
        let share = |number: u32| f64::from(number) / f64::from(self.phases);
        let mut all = Vec::new();
        for width in widths {
            for y in 0..self.phases {
                for x in 0..self.phases {
                    all.push(Settings {
                        cell_mm: first.cell_mm * (1.0 + BEAD_STEP * f64::from(width)),
                        phase: [share(x), share(y)],
                        ..*first
                    });
                }
            }
        }
        all
    }

    /// Number of grids to try.
    pub fn count(&self) -> usize {
        self.settings(&Settings::default()).len()
    }

    /// Screens all grids, and returns the settings of the `count` best ones.
    ///
    /// The best grids are those with the lowest bound on the pieces of all layers; equal grids keep
    /// the order of [`GridArgs::settings`].
    /// The first grid of [`GridArgs::settings`] always comes first, so that a plan is never worse
    /// than without a choice, unless that grid cannot be planned and another one can.
    ///
    /// For each grid, fills the outlines of all layers with cells and computes a maximum 2-matching
    /// of each layer.
    pub fn best(
        &self,
        part: &CutPart,
        count: usize,
        threads: Threads<'_>,
    ) -> anyhow::Result<Vec<Settings>> {
        let all = self.settings(&part.settings);
        if all.len() == 1 {
            return Ok(all);
        }
        let bar = progress::bar(all.len() as u64, "grids");
        let control = Control { cancel: Some(cancel::token()?), ..Control::on(threads) };
        let mut bounds = Vec::new();
        for settings in &all {
            control.check().context("stopped")?;
            // A grid that cannot be planned is skipped; if none remains, planning the first one
            // reports the error.
            let layers = part.layers(settings, threads).ok();
            if let Some(layers) = layers.filter(|layers| layers.gap().is_none()) {
                bounds.push((*settings, pieces(&layers, &control).context("stopped")?));
            }
            bar.inc(1);
        }
        bar.finish_and_clear();
        let is_first = |settings: &Settings| *settings == all[0];
        bounds.sort_by_key(|(settings, bound)| (!is_first(settings), *bound));
        let mut best: Vec<Settings> =
            bounds.into_iter().take(count.max(1)).map(|(settings, _)| settings).collect();
        if best.is_empty() {
            best.push(all[0]);
        }
        Ok(best)
    }
}

/// Lower bound on the pieces of all layers if every piece lies in one zone.
fn pieces(layers: &Layers, control: &Control<'_>) -> Result<u64, Interrupted> {
    let filled: Vec<&Layer> = layers.layers.iter().flatten().collect();
    // A prism has equal layers: consecutive equal ones need only one computation.
    let alike = filled.chunk_by(|a, b| a == b).collect::<Vec<_>>();
    let bounds = control.threads.map(&alike, |layers| {
        let bound = zone_pieces(layers[0], &control.on_one_thread())?;
        Ok(bound * layers.len() as u64)
    });
    bounds.into_iter().sum()
}

/// Lower bound on the pieces of a layer if every piece lies in one zone.
fn zone_pieces(layer: &Layer, control: &Control<'_>) -> Result<u64, Interrupted> {
    let Layer { region, zones } = layer;
    if zones.count() == 1 {
        return Ok(u64::from(piece_bound(region, control)?));
    }
    let (inside, materials) = (region.view(), zones.view(region));
    let mut sum = 0;
    for zone in 0..zones.count() {
        let mask = Array2::from_shape_fn(inside.raw_dim(), |at| {
            inside[at] && u32::from(materials[at]) == zone
        });
        // A zone without cells has no region.
        if let Ok(region) = Region::from_array(mask.view()) {
            sum += u64::from(piece_bound(&region, control)?);
        }
    }
    Ok(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_grid_is_that_of_the_flags() {
        let flags = Settings::default();
        for (phases, bead_range, count) in [(1, 0.0, 1), (3, 0.0, 9), (2, 10.0, 36), (1, 2.4, 1)] {
            let all = GridArgs { phases, bead_range }.settings(&flags);
            assert_eq!(all.len(), count);
            assert_eq!(all[0], flags);
            let widths = all.iter().map(|settings| settings.cell_mm / flags.cell_mm);
            assert!(widths.into_iter().all(|width| (0.8999..=1.1001).contains(&width)));
        }
    }
}
