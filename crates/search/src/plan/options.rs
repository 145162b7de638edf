//! All ways to print one layer, and the layer printed in one of them.

use beadwork_grid::{Cell, Crossings, Path};

use super::arrange::{Group, arrange};
use super::choice::Way;
use super::cover::Cover;
use super::covers::Covers;
use super::order::within::{NEVER, Within};
use super::sequence::{Block, Sequence, blocks, sequences};
use super::{LayerPlan, LayerRef, ToolCosts, kept_links};

/// All ways to print one layer.
pub(super) struct Options<'a> {
    layer: LayerRef<'a>,
    covers: &'a Covers,
    continuous_pieces: Vec<&'a [Cell]>,
    zone_pieces: Vec<&'a [Cell]>,
    blocks: Vec<Block>,
    pub(super) ways: Vec<Way>,
    hows: Vec<How>,
}

/// What a way looks like.
enum How {
    /// A sequence of blocks.
    Continuous(Sequence),
    /// Tool after tool.
    ByZones(Vec<u8>),
}

impl<'a> Options<'a> {
    /// No ways yet.
    pub(super) fn new(layer: LayerRef<'a>, covers: &'a Covers) -> Self {
        let pieces = |cover: &'a Option<Cover>| {
            cover.as_ref().map_or_else(Vec::new, |cover| cover.pieces(layer.zones))
        };
        Self {
            layer,
            covers,
            continuous_pieces: pieces(&covers.continuous),
            zone_pieces: pieces(&covers.by_zones),
            blocks: Vec::new(),
            ways: Vec::new(),
            hows: Vec::new(),
        }
    }

    /// Adds the ways of the continuous cover, if there is one.
    pub(super) fn add_sequences(&mut self, costs: &ToolCosts) {
        if self.continuous_pieces.is_empty() {
            return;
        }
        self.blocks = blocks(&self.continuous_pieces, self.layer.zones, costs);
        let lifts = self.continuous_pieces.len() as u64 - 1;
        for sequence in sequences(&self.blocks, costs) {
            let Sequence { first, last, cost, .. } = sequence;
            self.ways.push(Way { first, last, cost, lifts });
            self.hows.push(How::Continuous(sequence));
        }
    }

    /// Adds the cheapest order of the tools between any two of them, if the layer is covered by
    /// zones.
    pub(super) fn add_orders(&mut self, set: &[u8], within: &Within) {
        for from in 0..set.len() {
            for to in 0..set.len() {
                let cost = within.cost(from, to);
                if cost != NEVER {
                    self.add_order(within.order(from, to).to_vec(), cost);
                }
            }
        }
    }

    /// Adds one order of the tools, if the layer is covered by zones.
    pub(super) fn add_order(&mut self, order: Vec<u8>, cost: u64) {
        if self.zone_pieces.is_empty() {
            return;
        }
        let (first, last) = (order[0], order[order.len() - 1]);
        self.ways.push(Way { first, last, cost, lifts: self.zone_pieces.len() as u64 - 1 });
        self.hows.push(How::ByZones(order));
    }

    /// The layer printed in one of the ways.
    pub(super) fn plan(&self, way: usize, below: Option<&LayerPlan>) -> LayerPlan {
        let LayerRef { region, zones } = self.layer;
        let (groups, cover, crossing_cost): (Vec<Group<'_>>, &Option<Cover>, _) = match &self.hows
            [way]
        {
            How::Continuous(sequence) => {
                let group = |&(block, turned): &(usize, bool)| {
                    let block = &self.blocks[block];
                    let pieces: Vec<&[Cell]> =
                        block.pieces.iter().map(|&piece| self.continuous_pieces[piece]).collect();
                    if block.is_plain() {
                        Group::Any(pieces)
                    } else {
                        Group::Fixed(pieces[0], turned)
                    }
                };
                let inside = |&(block, turned): &(usize, bool)| self.blocks[block].inside(turned);
                let cost: u64 = sequence.blocks.iter().map(inside).sum();
                (sequence.blocks.iter().map(group).collect(), &self.covers.continuous, Some(cost))
            }
            How::ByZones(order) => {
                let pieces = |tool: u8| {
                    self.zone_pieces.iter().copied().filter(move |piece| zones.id(piece[0]) == tool)
                };
                let groups = order.iter().map(|&tool| Group::Any(pieces(tool).collect()));
                (groups.collect(), &self.covers.by_zones, None)
            }
        };
        let cover = cover.as_ref().expect("the way is one of the cover's");
        let from = below.and_then(|below| below.path.order().last().copied());
        let path = Path::in_pieces(region, arrange(region, groups, from))
            .expect("the pieces hold every cell once");
        LayerPlan {
            is_continuous: crossing_cost.is_some(),
            pieces: cover.pieces,
            piece_bound: cover.piece_bound,
            crossings: Crossings::new(region, zones).count(&path),
            crossing_cost: crossing_cost.map(|cost| [cost, cover.bound]),
            kept_links: below.map(|below| kept_links(&below.path, &path)),
            path,
        }
    }
}
