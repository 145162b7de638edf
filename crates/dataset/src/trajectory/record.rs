//! The fields of a trajectory's record, and its moves.

use beadwork_grid::{
    Crossings, Layout, LayoutError, LayoutSpec, PlacedVariant, Region, RegionError, Start, Switch,
    Variant, Zones, ZonesError,
};
use beadwork_search::Move;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::by_name;
use crate::shard::Record;
use crate::source::Search;

/// The record of a search on one instance.
///
/// It is enough to draw the instance, replay every move and check every number.
/// It holds no times, so that the same configuration gives the same bytes; see
/// [`search_times`](crate::generate::search_times).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Trajectory {
    /// Its number in the dataset, from 0.
    pub index: u64,
    /// The layer that was searched.
    pub instance: Instance,
    /// Width of the grid in cells.
    pub width: u16,
    /// Height of the grid in cells.
    pub height: u16,
    /// Number of zones, see [`Zones::count`].
    pub zones: u8,
    /// The search and its preset.
    #[serde(with = "by_name")]
    pub search: Search,
    /// Seed of the search.
    pub seed: u64,
    /// The start path.
    #[serde(with = "by_name")]
    pub start: Start,
    /// Number of pieces of the start path, and of every later path.
    pub pieces: u32,
    /// Crossings of the start path.
    pub initial: u32,
    /// Crossings of the best path, which the moves lead to.
    pub best: u32,
    /// A proven lower bound on the crossings of any path with as many pieces, if one is known.
    pub bound: Option<u32>,
    /// The accepted moves up to the best path.
    pub moves: Moves,
}

impl Record for Trajectory {
    const KIND: u16 = 1;
}

/// The layer that a search ran on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Instance {
    /// A layout on a full rectangle.
    Layout {
        /// The family of layouts.
        #[serde(with = "by_name")]
        layout: Layout,
        /// Side of an island or a block in cells, the `side` of [`LayoutSpec`].
        side: u16,
        /// Number of zones that the layout was drawn with, the `zones` of [`LayoutSpec`].
        zones: u8,
        /// Seed that the layout was drawn with; 0 for layouts that are not random.
        seed: u64,
    },
    /// A picture.
    /// Each record contains all of it, so that it can be read alone; repetitions within a block
    /// compress to almost nothing.
    Picture {
        /// Name of its file, without folder and extension.
        name: String,
        /// Zone of each cell of the grid, row by row; [`Zones::OUTSIDE`] outside the region.
        ids: Vec<u8>,
    },
}

/// Moves in columns, which compress better than rows.
/// All columns have the same length.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Moves {
    /// Move variants of Aali et al.
    Variants {
        /// Classes of the variants, 0 to 11.
        class: Vec<u8>,
        /// Columns of the windows' top-left cells.
        x: Vec<u16>,
        /// Rows of the windows' top-left cells.
        y: Vec<u16>,
        /// Change of the number of crossings by each move.
        change: Vec<i8>,
    },
    /// Pairs of arbitrary switches, as [`Switch::code`].
    Pairs {
        /// The first switch of each pair.
        first: Vec<u32>,
        /// The second switch of each pair.
        second: Vec<u32>,
        /// Change of the number of crossings by each move.
        change: Vec<i8>,
    },
}

/// A move of a trajectory and its effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// The move.
    pub action: Move,
    /// Crossings before the move.
    pub before: u32,
    /// Crossings after the move.
    pub after: u32,
    /// Whether the move reached a new best.
    pub effective: bool,
}

impl Instance {
    /// The name of the layout's family, or of the picture.
    pub fn name(&self) -> &str {
        match self {
            Self::Layout { layout, .. } => layout.name(),
            Self::Picture { name, .. } => name,
        }
    }

    /// Draws the region and its zones on a grid of `width` times `height` cells.
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

/// Why an instance cannot be drawn.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum DrawError {
    /// The region is invalid.
    #[error(transparent)]
    Region(#[from] RegionError),
    /// The layout cannot be drawn on the region.
    #[error(transparent)]
    Layout(#[from] LayoutError),
    /// The zones do not fit the region.
    #[error(transparent)]
    Zones(#[from] ZonesError),
}

impl Moves {
    /// Records the moves of a search, in the order in which they are applied, on a grid of this
    /// width.
    ///
    /// # Panics
    /// If variants and pairs of switches are mixed: a search uses one kind.
    pub fn record(moves: &[Move], crossings: &Crossings, width: u32) -> Self {
        let change_of = |action: &Move| -> i32 {
            action.switches(width).iter().map(|&switch| crossings.change(switch)).sum()
        };
        let change = moves.iter().map(|action| change_of(action) as i8).collect();
        if let Some(Move::Pair(_)) = moves.first() {
            let (first, second) =
                moves.iter().map(|action| action.switches(width).map(Switch::code).into()).unzip();
            return Self::Pairs { first, second, change };
        }
        let placed = moves.iter().map(|action| match action {
            Move::Variant(placed) => *placed,
            Move::Pair(_) => panic!("a search records one kind of moves"),
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

    /// Whether there are no moves: the start path was the best path.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The move at an index; `None` past the end, or if the record is damaged there.
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

    /// Change of the number of crossings by each move.
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

    /// Upper estimate of the encoded length in bytes.
    pub(crate) fn size_hint(&self) -> usize {
        let ids = match &self.instance {
            Instance::Layout { .. } => 0,
            Instance::Picture { ids, .. } => ids.len(),
        };
        64 + ids + 11 * self.moves.len()
    }

    /// The moves, with the crossings before and after each.
    ///
    /// Ends early if the record is damaged; [`Trajectory::replay`] reports that.
    pub fn steps(&self) -> impl Iterator<Item = Step> {
        let mut after = self.initial;
        let mut best = self.initial;
        let changes = self.moves.changes().iter().enumerate();
        changes.map_while(move |(index, &change)| {
            let action = self.moves.get(index)?;
            let before = after;
            after = before.saturating_add_signed(i32::from(change));
            let effective = after < best;
            best = best.min(after);
            Some(Step { action, before, after, effective })
        })
    }
}
