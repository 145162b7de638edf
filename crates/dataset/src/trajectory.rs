//! The record of one search, from its start to the best path it found.

use beadwork_base::Control;
use beadwork_grid::{
    Crossings, Layout, LayoutSpec, Path, PlacedVariant, Region, Start, Switch, Variant, Zones,
};
use beadwork_search::Move;
use serde::{Deserialize, Serialize};

use crate::by_name;
use crate::source::Search;

/// A search on one instance: enough to draw the instance again, replay every move, and check every
/// number.
///
/// No times are kept: the same configuration gives the same bytes.
/// They lie beside the shard, see [`generate`](crate::generate()).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trajectory {
    /// Its number in the dataset, from 0.
    pub index: u64,
    /// What was searched.
    pub instance: Instance,
    /// Width of the plane in cells.
    pub width: u16,
    /// Height of the plane in cells.
    pub height: u16,
    /// Number of zones, as [`Zones::count`] gives it.
    pub zones: u8,
    /// The search, by its preset.
    #[serde(with = "by_name")]
    pub search: Search,
    /// Seed of the search.
    pub seed: u64,
    /// The path it started from.
    #[serde(with = "by_name")]
    pub start: Start,
    /// Pieces of that path, and of every later one.
    pub pieces: u32,
    /// Crossings of the start.
    pub initial: u32,
    /// Crossings of the best path, to which the moves lead.
    pub best: u32,
    /// A proven lower bound of the crossings in so many pieces, if one is known.
    pub bound: Option<u32>,
    /// The accepted moves up to the best path.
    pub moves: Moves,
}

/// What a search ran on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Instance {
    /// A drawn layout of a full rectangle.
    Layout {
        /// Its family.
        #[serde(with = "by_name")]
        layout: Layout,
        /// The `side` of its [`LayoutSpec`].
        side: u16,
        /// Number of zones asked for.
        zones: u8,
        /// Seed of its drawing.
        seed: u64,
    },
    /// A picture, kept whole so that the record stands alone; equal pictures in one block compress
    /// to almost nothing.
    Picture {
        /// Its file's name, without folder and extension.
        name: String,
        /// Zone of each cell of the plane, row by row; [`Zones::OUTSIDE`] outside the region.
        ids: Vec<u8>,
    },
}

/// Moves in columns, which compress better than rows; all columns have one length.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Moves {
    /// Variants of Aali et al.
    Variants {
        /// Class numbers, 0..12.
        class: Vec<u8>,
        /// Columns of the windows' top-left cells.
        x: Vec<u16>,
        /// Rows of the windows' top-left cells.
        y: Vec<u16>,
        /// Change of the crossings.
        change: Vec<i8>,
    },
    /// Any two switches, by [`Switch::code`].
    Pairs {
        /// The switches that come first.
        first: Vec<u32>,
        /// The switches that come second.
        second: Vec<u32>,
        /// Change of the crossings.
        change: Vec<i8>,
    },
}

/// A move of a trajectory with what it did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// The move.
    pub step: Move,
    /// Crossings before it.
    pub before: u32,
    /// Crossings after it.
    pub after: u32,
    /// Whether it led to a new best.
    pub effective: bool,
}

impl Instance {
    /// The name of its layout, or of its picture.
    pub fn name(&self) -> &str {
        match self {
            Self::Layout { layout, .. } => layout.name(),
            Self::Picture { name, .. } => name,
        }
    }

    /// Draws the region and its zones, in a plane of the given size in cells.
    pub fn draw(&self, width: u32, height: u32) -> Result<(Region, Zones), DrawError> {
        match self {
            &Self::Layout { layout, side, zones, seed } => {
                let region = Region::rectangle(width, height)?;
                let zones = LayoutSpec { layout, zones, side }.zones(&region, seed)?;
                Ok((region, zones))
            }
            Self::Picture { ids, .. } => {
                let inside = ids.iter().map(|&id| id != Zones::OUTSIDE).collect();
                let region = Region::from_mask(width, height, inside)?;
                let zones = Zones::new(&region, ids.clone())?;
                Ok((region, zones))
            }
        }
    }
}

/// Why an instance could not be drawn.
#[derive(Clone, Debug, thiserror::Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum DrawError {
    /// The region is impossible.
    #[error(transparent)]
    Region(#[from] beadwork_grid::RegionError),
    /// The layout is.
    #[error(transparent)]
    Layout(#[from] beadwork_grid::LayoutError),
    /// The zones don't fit the region.
    #[error(transparent)]
    Zones(#[from] beadwork_grid::ZonesError),
}

impl Moves {
    /// Records moves that apply one after the other to paths of this width.
    ///
    /// # Panics
    /// If moves of both sorts come mixed: a search uses one sort.
    pub fn record(moves: &[Move], crossings: &Crossings, width: u32) -> Self {
        let change = moves.iter().map(|step| {
            let sum: i32 =
                step.switches(width).iter().map(|&switch| crossings.change(switch)).sum();
            sum as i8
        });
        let change = change.collect();
        if let Some(Move::Pair(_)) = moves.first() {
            let (first, second) =
                moves.iter().map(|step| step.switches(width).map(Switch::code).into()).unzip();
            return Self::Pairs { first, second, change };
        }
        let placed = moves.iter().map(|step| match step {
            Move::Variant(placed) => *placed,
            Move::Pair(_) => panic!("a search records one sort of moves"),
        });
        let placed: Vec<PlacedVariant> = placed.collect();
        Self::Variants {
            class: placed.iter().map(|placed| placed.variant.class()).collect(),
            x: placed.iter().map(|placed| placed.x).collect(),
            y: placed.iter().map(|placed| placed.y).collect(),
            change,
        }
    }

    /// Number of moves.
    pub fn len(&self) -> usize {
        self.changes().len()
    }

    /// Whether the start was the best path.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The move at an index; `None` past the end, or where the record names no move.
    pub fn get(&self, index: usize) -> Option<Move> {
        match self {
            Self::Variants { class, x, y, .. } => {
                let variant = Variant::from_class(*class.get(index)?)?;
                Some(Move::Variant(PlacedVariant { variant, x: *x.get(index)?, y: *y.get(index)? }))
            }
            Self::Pairs { first, second, .. } => {
                Some(Move::Pair([*first.get(index)?, *second.get(index)?].map(Switch::from_code)))
            }
        }
    }

    /// Change of the crossings by each move.
    pub fn changes(&self) -> &[i8] {
        match self {
            Self::Variants { change, .. } | Self::Pairs { change, .. } => change,
        }
    }
}

impl Trajectory {
    /// The instance's region and zones.
    pub fn draw(&self) -> Result<(Region, Zones), DrawError> {
        self.instance.draw(u32::from(self.width), u32::from(self.height))
    }

    /// About how many bytes it takes uncompressed, at most.
    pub(crate) fn size_hint(&self) -> usize {
        let ids = match &self.instance {
            Instance::Layout { .. } => 0,
            Instance::Picture { ids, .. } => ids.len(),
        };
        64 + ids + 11 * self.moves.len()
    }

    /// The moves with the crossings before and after each.
    ///
    /// It ends early where the record names no move, as [`Trajectory::replay`] reports.
    pub fn steps(&self) -> impl Iterator<Item = Step> {
        let mut after = self.initial;
        let mut best = self.initial;
        let changes = self.moves.changes().iter().enumerate();
        changes.map_while(move |(index, &change)| {
            let step = self.moves.get(index)?;
            let before = after;
            after = before.saturating_add_signed(i32::from(change));
            let effective = after < best;
            best = best.min(after);
            Some(Step { step, before, after, effective })
        })
    }

    /// Runs the whole trajectory again and checks every number on the way; gives the best path.
    ///
    /// Costs a pass over the plane and what its moves cost.
    pub fn replay(&self) -> Result<Path, ReplayError> {
        let (region, zones) = self.draw()?;
        let mut path = self.start.path(&region, &Control::default())?;
        let crossings = Crossings::new(&region, &zones);
        let expect = |what, expected: u32, got: u32| {
            if expected == got { Ok(()) } else { Err(ReplayError::Number { what, expected, got }) }
        };
        expect("zones", zones.count(), u32::from(self.zones))?;
        expect("pieces", path.pieces(), self.pieces)?;
        expect("crossings at the start", walked_crossings(&path, &zones), self.initial)?;
        let bound = beadwork_search::bound::components(&region, &zones, self.pieces);
        expect("crossings that are the bound", bound, self.bound.unwrap_or(bound))?;

        let mut steps = self.steps();
        let mut last = None;
        for index in 0..self.moves.len() {
            let step = steps.next().ok_or(ReplayError::NoMove { index })?;
            if !step.step.apply(&mut path) {
                return Err(ReplayError::Refused { index });
            }
            let switches = step.step.switches(region.width());
            let change: i32 = switches.iter().map(|&switch| crossings.change(switch)).sum();
            let after = step.before.saturating_add_signed(change);
            if after != step.after {
                return Err(ReplayError::Crossings { index, expected: after, got: step.after });
            }
            last = Some(step);
        }
        beadwork_grid::verify(&region, path.order())?;
        expect("crossings at the end", walked_crossings(&path, &zones), self.best)?;
        if last.is_some_and(|step| !step.effective) {
            return Err(ReplayError::PastTheBest);
        }
        Ok(path)
    }
}

/// What is wrong with a trajectory.
#[derive(Clone, Debug, thiserror::Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ReplayError {
    /// Its instance can't be drawn.
    #[error(transparent)]
    Draw(#[from] DrawError),
    /// Its start does not exist.
    #[error(transparent)]
    Start(#[from] beadwork_grid::StartError),
    /// A number differs from what the replay gives.
    #[error("it has {expected} {what}, the record says {got}")]
    Number {
        /// What was counted.
        what: &'static str,
        /// By the replay.
        expected: u32,
        /// By the record.
        got: u32,
    },
    /// The columns name no move here.
    #[error("move {index} is none")]
    NoMove {
        /// Its index.
        index: usize,
    },
    /// A move does not apply.
    #[error("move {index} does not apply")]
    Refused {
        /// Its index.
        index: usize,
    },
    /// A move does not lead to the recorded crossings.
    #[error("move {index} leads to {expected} crossings, the record says {got}")]
    Crossings {
        /// Its index.
        index: usize,
        /// By the replay.
        expected: u32,
        /// By the record.
        got: u32,
    },
    /// The path at the end is none.
    #[error(transparent)]
    Path(#[from] beadwork_grid::VerifyError),
    /// The last move did not lead to a new best.
    #[error("moves follow the best path")]
    PastTheBest,
}

/// Crossings counted along the path, without the tables that the search used.
fn walked_crossings(path: &Path, zones: &Zones) -> u32 {
    let crossings = |piece: &[u32]| {
        piece.windows(2).filter(|step| zones.id(step[0]) != zones.id(step[1])).count()
    };
    path.iter_pieces().map(crossings).sum::<usize>() as u32
}

#[cfg(test)]
mod tests;
