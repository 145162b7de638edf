//! The covers of all layers: side by side, or one on top of the other.

use std::cmp::Ordering;
use std::collections::HashMap;
use std::sync::atomic::{self, AtomicUsize};

use beadwork_grid::{Path, Region};

use super::cover::{Cover, CrossingCosts, Effort, tools};
use super::{LayerRef, PlanError, Progress, Settings, Stacking, kept_links};
use crate::parallel::in_parallel;
use crate::stop::is_cancelled;

/// Which covers are wanted.
#[derive(Clone, Copy)]
pub(super) struct Wants {
    pub(super) continuous: bool,
    pub(super) by_zones: bool,
}

/// The covers of one layer.
#[derive(Clone)]
pub(super) struct Covers {
    pub(super) continuous: Option<Cover>,
    /// `None` also where the layer has one tool and the other cover is there: both would be the
    /// same.
    pub(super) by_zones: Option<Cover>,
}

impl Covers {
    /// The paths that the layer above may start from: of each kind, or of the other where there is
    /// none.
    fn paths(&self) -> [Option<&Path>; 2] {
        let [one, other] =
            [&self.continuous, &self.by_zones].map(|cover| cover.as_ref().map(|cover| &cover.path));
        [one.or(other), other.or(one)]
    }
}

/// The covers of all layers, each in the ways wanted.
pub(super) fn covers(
    layers: &[LayerRef<'_>],
    settings: &Settings<'_>,
    wants: Wants,
) -> Result<Vec<Covers>, PlanError> {
    // Costs that no crossing may have are no matter to covers without crossings.
    let costs = wants.continuous.then(|| CrossingCosts::new(settings.costs)).transpose()?;
    let maker = Maker { layers, settings, wants, costs };
    // Layers that come to the same, by the number of the first of them.
    let mut numbers: HashMap<(&Region, &[u8], bool), usize> = HashMap::new();
    let first_of: Vec<usize> = (0..layers.len())
        .map(|number| {
            let LayerRef { region, zones } = layers[number];
            *numbers.entry((region, zones.ids(), maker.columns_first(number))).or_insert(number)
        })
        .collect();
    let mut copies = vec![0; layers.len()];
    first_of.iter().for_each(|&first| copies[first] += 1);
    let done = AtomicUsize::new(0);
    let tell = |count: usize| {
        if let Some(observer) = settings.observer {
            let done = done.fetch_add(count, atomic::Ordering::Relaxed) + count;
            observer(Progress { done, layers: layers.len() });
        }
    };
    let firsts: Vec<usize> =
        (0..layers.len()).filter(|&number| first_of[number] == number).collect();
    let make = |(): &mut (), &number: &usize| {
        let covers = maker.covers(number, None);
        if settings.stacking.is_none() {
            tell(copies[number]);
        }
        covers
    };
    let found = in_parallel(settings.pool, &firsts, || (), make);
    let found = firsts.iter().copied().zip(found).map(|(number, covers)| Ok((number, covers?)));
    let found = found.collect::<Result<HashMap<usize, Covers>, PlanError>>()?;
    let mut stacked: Vec<Covers> = Vec::with_capacity(layers.len());
    for (number, first) in first_of.iter().enumerate() {
        let alone = found[first].clone();
        let covers = match (settings.stacking, stacked.last()) {
            (Some(stacking), Some(below)) => {
                let aware = maker.covers(number, Some(below))?;
                let [continuous_below, zones_below] = below.paths();
                Covers {
                    continuous: better(
                        alone.continuous,
                        aware.continuous,
                        continuous_below,
                        stacking,
                    ),
                    by_zones: better(alone.by_zones, aware.by_zones, zones_below, stacking),
                }
            }
            _ => alone,
        };
        if settings.stacking.is_some() {
            tell(1);
        }
        stacked.push(covers);
    }
    // A cover that was stopped was made in haste.
    if is_cancelled(settings.cancel) { Err(PlanError::Cancelled) } else { Ok(stacked) }
}

/// Makes the covers of single layers.
struct Maker<'a> {
    layers: &'a [LayerRef<'a>],
    settings: &'a Settings<'a>,
    wants: Wants,
    /// There if continuous covers are wanted.
    costs: Option<CrossingCosts>,
}

impl Maker<'_> {
    /// Whether the straight stretches of a layer run along its columns.
    fn columns_first(&self, number: usize) -> bool {
        self.settings.stacking == Some(Stacking::Break) && number % 2 == 1
    }

    fn covers(&self, number: usize, below: Option<&Covers>) -> Result<Covers, PlanError> {
        let Self { layers, settings, wants, costs } = self;
        if is_cancelled(settings.cancel) {
            return Err(PlanError::Cancelled);
        }
        let layer = layers[number];
        let effort = Effort {
            seed: settings.seed,
            attempts: settings.attempts,
            columns_first: self.columns_first(number),
            cancel: settings.cancel,
        };
        let [continuous_below, zones_below] = below.map_or([None; 2], Covers::paths);
        let by_zones = wants.by_zones && (!wants.continuous || tools(layer).len() > 1);
        let continuous =
            costs.as_ref().map(|costs| Cover::continuous(layer, costs, continuous_below, effort));
        let by_zones = by_zones.then(|| Cover::by_zones(layer, zones_below, effort));
        let wrong = |source| PlanError::Layer { layer: number, source };
        Ok(Covers {
            continuous: continuous.transpose().map_err(wrong)?,
            by_zones: by_zones.transpose().map_err(wrong)?,
        })
    }
}

/// The better of two covers; of equal ones the one that keeps more, or fewer, of the links below.
fn better(
    alone: Option<Cover>,
    aware: Option<Cover>,
    below: Option<&Path>,
    stacking: Stacking,
) -> Option<Cover> {
    let (alone, aware) = (alone?, aware?);
    let merit = |cover: &Cover| (cover.pieces, cover.cost);
    let kept = |cover: &Cover| below.map_or(0, |below| kept_links(below, &cover.path));
    let takes_aware = match merit(&aware).cmp(&merit(&alone)) {
        Ordering::Less => true,
        Ordering::Greater => false,
        Ordering::Equal => match stacking {
            Stacking::Keep => kept(&aware) >= kept(&alone),
            Stacking::Break => kept(&aware) < kept(&alone),
        },
    };
    Some(if takes_aware { aware } else { alone })
}
