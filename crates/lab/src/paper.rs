//! Figures of Aali et al., which the tables of `eval zones` and `eval fusion` show next to ours.

use anyhow::bail;
use beadwork_base::Threads;
use beadwork_console::control;
use beadwork_dataset::Size;
use beadwork_grid::{Crossings, Layout, LayoutSpec, Region, Start};
use beadwork_search::anneal::Preset;

/// The presets whose mean is compared with the paper's Table 5, because it comes closest: all of
/// the paper's presets except the shortest.
pub(crate) const AVERAGED: [Preset; 4] =
    [Preset::Medium, Preset::Paper, Preset::Long, Preset::ExtraLong];

/// The sizes of the paper's tables.
/// Its 30x100 has 100 rows of 30 cells.
pub(crate) const SIZES: [Size; 6] =
    [size(30, 30), size(50, 50), size(60, 60), size(80, 80), size(100, 100), size(30, 100)];

const fn size(width: u32, height: u32) -> Size {
    Size { width, height }
}

/// A cell of the paper's tables: one layout in one size, with the paper's results.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    pub(crate) layout: Layout,
    pub(crate) size: Size,
    /// Crossings of the row zigzag on the paper's instance.
    pub(crate) zigzag: u32,
    /// Best reduction by annealing (Table 3), in %.
    pub(crate) best: f64,
    /// Best reduction by the genetic algorithm (Table 1), in %.
    pub(crate) genetic: f64,
    /// Mean reduction by annealing (Table 5), in %.
    pub(crate) mean: f64,
}

/// The 24 cells: the six sizes of each layout.
pub(crate) fn cells() -> impl Iterator<Item = Cell> {
    // For each layout and size: zigzag, best, genetic, mean.
    let rows = [
        (
            [30, 50, 60, 80, 100, 100],
            [60.0, 56.0, 56.7, 50.0, 54.0, 56.0],
            [60.0, 56.0, 56.7, 55.0, 50.0, 53.0],
            [47.6, 33.1, 33.7, 24.1, 8.2, 44.3],
        ),
        (
            [60, 100, 120, 160, 200, 200],
            [50.0, 54.0, 53.3, 42.5, 46.0, 54.0],
            [56.3, 52.0, 50.0, 48.8, 45.0, 53.0],
            [46.6, 41.8, 40.0, 30.8, 21.1, 46.2],
        ),
        (
            [48, 48, 48, 48, 48, 48],
            [33.3, 45.8, 41.7, 33.3, 45.8, 45.8],
            [52.1, 41.1, 40.0, 50.0, 50.0, 38.5],
            [23.4, 20.4, 19.0, 16.7, 16.1, 20.7],
        ),
        (
            [60, 99, 50, 142, 197, 27],
            [43.3, 40.4, 14.0, 19.7, 23.4, 37.3],
            [58.3, 11.7, 34.2, 15.0, 20.0, 20.2],
            [17.0, 13.0, 10.7, 7.7, 5.8, 9.8],
        ),
    ];
    Layout::PAPER.into_iter().zip(rows).flat_map(|(layout, (zigzag, best, genetic, mean))| {
        (0..6).map(move |i| Cell {
            layout,
            size: SIZES[i],
            zigzag: zigzag[i],
            best: best[i],
            genetic: genetic[i],
            mean: mean[i],
        })
    })
}

impl Cell {
    /// Whether both cells have the same layout and size.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        (self.layout, self.size) == (other.layout, other.size)
    }

    /// The first `max` seeds whose instance resembles the paper's: the crossings of the zigzag are
    /// within 10 % of those on the paper's instance.
    ///
    /// The crossings of the zigzag are all that is known of the paper's random instances.
    /// A layout that is not random has one instance, of seed 0.
    ///
    /// # Errors
    /// If none of the first 20,000 seeds matches, or if interrupted by Ctrl-C.
    pub(crate) fn matching_seeds(&self, max: u64) -> anyhow::Result<Vec<u64>> {
        const TRIED: u64 = 20_000;

        if !self.layout.is_random() {
            return Ok(vec![0]);
        }
        let control = control::cancellable(Threads::One)?;
        let region = Region::rectangle(self.size.width, self.size.height)?;
        let zigzag = Start::RowZigzag.path(&region, &control)?;
        let spec = LayoutSpec::new(self.layout);
        let matches = |seed: u64| {
            let zones = spec.zones(&region, seed).ok();
            let count = zones.map(|zones| Crossings::new(&region, &zones).count(&zigzag));
            count.is_some_and(|count| 10 * count.abs_diff(self.zigzag) <= self.zigzag)
        };
        let mut found = Vec::new();
        for seed in 0..TRIED {
            control.check()?;
            if matches(seed) {
                found.push(seed);
            }
            if found.len() as u64 == max {
                break;
            }
        }
        if found.is_empty() {
            bail!(
                "{} {}: no seed from 0 to {} gives a zigzag of about {} crossings",
                self.layout,
                self.size,
                TRIED - 1,
                self.zigzag
            );
        }
        Ok(found)
    }
}
