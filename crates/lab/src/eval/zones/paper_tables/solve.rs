//! All methods on one instance.

use std::time::Instant;

use beadwork_base::Threads;
use beadwork_console::control;
use beadwork_console::search::{Breeding, Choice, Row, Search};
use beadwork_grid::{Crossings, LayoutSpec, Region, Start};
use beadwork_search::anneal::Preset;
use beadwork_search::bound::Bounds;
use beadwork_search::genetic::{self, Seeding};
use beadwork_search::{Move, exact};

use crate::paper::Cell;

/// Runs the zigzag, annealing by all presets, the genetic algorithm by some presets and the exact
/// search on one instance of a cell, each on one thread.
///
/// All rows get the best lower bound that any of the methods proves.
pub(super) fn every_method(
    cell: &Cell,
    seed: u64,
    instance_seed: u64,
    presets: &[genetic::Preset],
) -> anyhow::Result<Vec<Row>> {
    let region = &Region::rectangle(cell.size.width, cell.size.height)?;
    let zones = &LayoutSpec::new(cell.layout).zones(region, instance_seed)?;
    let start = Start::RowZigzag;
    let control = &control::cancellable(Threads::One)?;
    let path = start.path(region, control)?;
    let bounds = Bounds::new(region, zones, control)?;
    // Presets with the same annealing runs share their population.
    let mut populations: Vec<(Seeding, Vec<Vec<Move>>, f64)> = Vec::new();
    for &preset in presets {
        let settings = genetic::Settings {
            proven_bound: Some(i64::from(bounds.crossings())),
            ..genetic::Settings::preset(preset, seed)
        };
        if populations.iter().all(|(made, ..)| *made != settings.seeding) {
            let begin = Instant::now();
            let crossings = Crossings::new(region, zones);
            let population = genetic::annealed(&path, &crossings, &settings, control);
            populations.push((settings.seeding, population, begin.elapsed().as_secs_f64()));
        }
    }
    let search = |choice| {
        let search = Search { region, zones, choice, seed, start, bounds: Some(bounds) };
        Ok::<Row, anyhow::Error>(search.run(cell.layout.name(), &path, control)?.1)
    };
    let mut rows = vec![search(Choice::Zigzag)?];
    for preset in Preset::ALL {
        rows.push(search(Choice::Anneal(preset))?);
    }
    for &preset in presets {
        let (seeding, _) = preset.parameters();
        let (_, population, seconds) = populations
            .iter()
            .find(|(made, ..)| *made == seeding)
            .expect("there is a population for each preset");
        let population = Some((&population[..], *seconds));
        let mut row = search(Choice::Genetic(Breeding { preset, population }))?;
        if let Some(genetic) = &mut row.genetic {
            let last = genetic.history.len() as u32 - 1;
            genetic.history.retain(|it| it.number == last || is_milestone(it.number));
        }
        rows.push(row);
    }
    rows.push(search(Choice::Exact(exact::Settings::default()))?);
    // The exact search may prove a higher bound than `Bounds` does, and a bound holds for all
    // methods.
    let bound = rows.iter().filter_map(|row| row.bound).reduce(f64::max);
    rows.iter_mut().for_each(|row| row.bound = bound);
    Ok(rows)
}

/// Whether a generation is stored for the plots.
///
/// Generations are stored at distances that grow by half from one to the next, because populations
/// change most at the start.
fn is_milestone(generation: u32) -> bool {
    let mut milestone = 0;
    while milestone < generation {
        milestone += milestone.div_ceil(2).max(1);
    }
    milestone == generation
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn milestones_grow_by_half() {
        let milestones: Vec<u32> =
            (0..=500).filter(|&generation| is_milestone(generation)).collect();
        assert_eq!(milestones[..8], [0, 1, 2, 3, 5, 8, 12, 18]);
        assert!(milestones.len() < 20);
    }
}
