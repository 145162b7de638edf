//! The covers of all layers: each on its own, or each one based on the layer below.

use std::cmp::Ordering;
use std::collections::HashMap;
use std::sync::atomic::{self, AtomicUsize};

use beadwork_base::Control;
use beadwork_grid::{Path, Region};

use super::cover::{Cover, Effort, LayerRef, SearchCosts, tools};
use super::stack::kept_links;
use super::tools::{PlanError, Settings, Stacking};
use crate::CostMatrix;

/// The kinds of covers that are wanted.
#[derive(Clone, Copy)]
pub(super) struct Wants {
    pub(super) continuous: bool,
    pub(super) by_zones: bool,
}

/// The covers of one layer.
#[derive(Clone)]
pub(super) struct Covers {
    pub(super) continuous: Option<Cover>,
    /// `None` also where the layer has only one tool and there is a continuous cover, since both
    /// would be the same.
    pub(super) by_zones: Option<Cover>,
}

impl Covers {
    /// The paths from which the covers of the layer above may start, for each kind of cover.
    /// A missing path is replaced by that of the other kind.
    fn paths(&self) -> [Option<&Path>; 2] {
        let [one, other] =
            [&self.continuous, &self.by_zones].map(|cover| cover.as_ref().map(|cover| &cover.path));
        [one.or(other), other.or(one)]
    }
}

/// Makes the covers of all layers.
/// Progress counts layers; equal layers count separately.
pub(super) fn covers(
    layers: &[LayerRef<'_>],
    costs: &CostMatrix,
    settings: &Settings,
    wants: Wants,
    control: &Control<'_>,
) -> Result<Vec<Covers>, PlanError> {
    let costs = wants.continuous.then(|| SearchCosts::new(costs));
    let maker = Maker { layers, settings, wants, costs, control: control.without_progress() };
    // Equal layers share one cover: for each layer the number of the first one that equals it.
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
    let report = || control.report(done.fetch_add(1, atomic::Ordering::Relaxed) + 1, layers.len());
    let firsts: Vec<usize> =
        (0..layers.len()).filter(|&number| first_of[number] == number).collect();
    let make = |&number: &usize| {
        let covers = maker.covers(number, None);
        if settings.stacking.is_none() {
            (0..copies[number]).for_each(|_| report());
        }
        covers
    };
    let found = control.threads.map(&firsts, make);
    let found = firsts.iter().copied().zip(found).map(|(number, covers)| Ok((number, covers?)));
    let found = found.collect::<Result<HashMap<usize, Covers>, PlanError>>()?;
    let mut stacked: Vec<Covers> = Vec::with_capacity(layers.len());
    for (number, first) in first_of.iter().enumerate() {
        let alone = found[first].clone();
        let covers = match (settings.stacking, stacked.last()) {
            (Some(stacking), Some(below)) => {
                let based = maker.covers(number, Some(below))?;
                let [continuous_below, zones_below] = below.paths();
                Covers {
                    continuous: better(
                        alone.continuous,
                        based.continuous,
                        continuous_below,
                        stacking,
                    ),
                    by_zones: better(alone.by_zones, based.by_zones, zones_below, stacking),
                }
            }
            _ => alone,
        };
        if settings.stacking.is_some() {
            report();
        }
        stacked.push(covers);
    }
    // Covers whose search was interrupted may be poor, so an interruption is an error.
    control.check()?;
    Ok(stacked)
}

/// Makes the covers of single layers.
struct Maker<'a> {
    layers: &'a [LayerRef<'a>],
    settings: &'a Settings,
    wants: Wants,
    /// `Some` if continuous covers are wanted.
    costs: Option<SearchCosts<'a>>,
    control: Control<'a>,
}

impl Maker<'_> {
    /// Whether the straight runs of a layer follow its columns.
    fn columns_first(&self, number: usize) -> bool {
        self.settings.stacking == Some(Stacking::Break) && number % 2 == 1
    }

    /// The covers of a layer, which start from those of the layer below if there are any.
    fn covers(&self, number: usize, below: Option<&Covers>) -> Result<Covers, PlanError> {
        let Self { layers, settings, wants, costs, control } = self;
        control.check()?;
        let layer = layers[number];
        let effort = Effort {
            seed: settings.seed,
            attempts: settings.attempts,
            columns_first: self.columns_first(number),
            control: control.on_one_thread(),
        };
        let [continuous_below, zones_below] = below.map_or([None; 2], Covers::paths);
        let by_zones = wants.by_zones && (!wants.continuous || tools(layer).len() > 1);
        let continuous =
            costs.as_ref().map(|costs| Cover::continuous(layer, costs, continuous_below, effort));
        let by_zones = by_zones.then(|| Cover::by_zones(layer, zones_below, effort));
        let in_layer = |source| PlanError::Layer { layer: number, source };
        Ok(Covers {
            continuous: continuous.transpose().map_err(in_layer)?,
            by_zones: by_zones.transpose().map_err(in_layer)?,
        })
    }
}

/// The better one of two covers of a layer: `alone` was made from scratch, `based` from the path
/// below.
/// Of equally good ones, `stacking` decides.
fn better(
    alone: Option<Cover>,
    based: Option<Cover>,
    below: Option<&Path>,
    stacking: Stacking,
) -> Option<Cover> {
    let (alone, based) = (alone?, based?);
    let merit = |cover: &Cover| (cover.pieces, cover.cost);
    let kept = |cover: &Cover| below.map_or(0, |below| kept_links(below, &cover.path));
    let takes_based = match merit(&based).cmp(&merit(&alone)) {
        Ordering::Less => true,
        Ordering::Greater => false,
        Ordering::Equal => match stacking {
            Stacking::Keep => kept(&based) >= kept(&alone),
            Stacking::Break => kept(&based) < kept(&alone),
        },
    };
    Some(if takes_based { based } else { alone })
}
