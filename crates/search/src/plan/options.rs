//! All ways to print one layer, and the layer as it is printed in one of them.

use beadwork_grid::{Cell, Crossings, Path};

use super::arrange::{Group, arrange};
use super::choice::Way;
use super::cover::{Cover, LayerRef};
use super::covers::Covers;
use super::order::within::Within;
use super::sequence::{Block, Sequence, blocks, sequences};
use super::stack::kept_links;
use super::tools::LayerPlan;
use crate::CostMatrix;

/// All ways to print one layer.
pub(super) struct Options<'a> {
    layer: LayerRef<'a>,
    covers: &'a Covers,
    costs: &'a CostMatrix,
    continuous_pieces: Vec<&'a [Cell]>,
    zone_pieces: Vec<&'a [Cell]>,
    blocks: Vec<Block>,
    /// The ways: what the choice for the whole part needs to know about each.
    pub(super) ways: Vec<Way>,
    /// The order of the pieces in each way.
    orders: Vec<Order>,
}

/// Order of the pieces of a layer.
enum Order {
    /// The continuous cover: a sequence of blocks.
    Continuous(Sequence),
    /// The cover by zones: one tool after the other.
    ByZones(Vec<u8>),
}

impl<'a> Options<'a> {
    /// The options of a layer, without any ways yet.
    pub(super) fn new(layer: LayerRef<'a>, covers: &'a Covers, costs: &'a CostMatrix) -> Self {
        let pieces = |cover: &'a Option<Cover>| {
            cover.as_ref().map_or_else(Vec::new, |cover| cover.pieces(layer.zones))
        };
        Self {
            layer,
            covers,
            costs,
            continuous_pieces: pieces(&covers.continuous),
            zone_pieces: pieces(&covers.by_zones),
            blocks: Vec::new(),
            ways: Vec::new(),
            orders: Vec::new(),
        }
    }

    /// Adds the ways of the continuous cover, if there is one.
    pub(super) fn add_sequences(&mut self) {
        if self.continuous_pieces.is_empty() {
            return;
        }
        self.blocks = blocks(&self.continuous_pieces, self.layer.zones, self.costs);
        let lifts = self.continuous_pieces.len() as u64 - 1;
        for sequence in sequences(&self.blocks, self.costs) {
            let Sequence { first, last, cost, .. } = sequence;
            self.ways.push(Way { first, last, cost, lifts });
            self.orders.push(Order::Continuous(sequence));
        }
    }

    /// Adds a way for each known order of the tools, if the layer is covered by zones.
    pub(super) fn add_orders(&mut self, within: &Within) {
        for (order, cost) in within.iter() {
            self.add_order(order.to_vec(), cost);
        }
    }

    /// Adds a way for one order of the tools with its scaled cost, if the layer is covered by
    /// zones.
    pub(super) fn add_order(&mut self, order: Vec<u8>, cost: u64) {
        if self.zone_pieces.is_empty() {
            return;
        }
        let (first, last) = (order[0], order[order.len() - 1]);
        self.ways.push(Way { first, last, cost, lifts: self.zone_pieces.len() as u64 - 1 });
        self.orders.push(Order::ByZones(order));
    }

    /// The layer as it is printed in one of the ways, above the layer `below`.
    pub(super) fn plan(&self, way: usize, below: Option<&LayerPlan>) -> LayerPlan {
        let LayerRef { region, zones } = self.layer;
        let (groups, cover, crossing_cost) = match &self.orders[way] {
            Order::Continuous(sequence) => {
                let group = |&(block, is_reversed): &(usize, bool)| {
                    let block = &self.blocks[block];
                    let pieces: Vec<&[Cell]> =
                        block.pieces.iter().map(|&piece| self.continuous_pieces[piece]).collect();
                    if block.is_plain() {
                        Group::Any(pieces)
                    } else {
                        Group::Fixed(pieces[0], is_reversed)
                    }
                };
                let inside =
                    |&(block, is_reversed): &(usize, bool)| self.blocks[block].inside(is_reversed);
                let groups: Vec<_> = sequence.blocks.iter().map(group).collect();
                let cost: u64 = sequence.blocks.iter().map(inside).sum();
                (groups, &self.covers.continuous, Some(cost))
            }
            Order::ByZones(order) => {
                let pieces = |tool: u8| {
                    self.zone_pieces.iter().copied().filter(move |piece| zones.id(piece[0]) == tool)
                };
                let groups = order.iter().map(|&tool| Group::Any(pieces(tool).collect()));
                (groups.collect(), &self.covers.by_zones, None)
            }
        };
        let cover = cover.as_ref().expect("the way is one of this cover");
        let from = below.and_then(|below| below.path.order().last().copied());
        let path = Path::in_pieces(region, arrange(region, groups, from))
            .expect("the pieces hold every cell once");
        let unscaled = |cost| [cost, cover.bound].map(|cost| self.costs.unscaled(cost));
        LayerPlan {
            is_continuous: crossing_cost.is_some(),
            pieces: cover.pieces,
            piece_bound: cover.piece_bound,
            crossings: Crossings::new(region, zones).count(&path),
            crossing_cost: crossing_cost.map(unscaled),
            kept_links: below.map(|below| kept_links(&below.path, &path)),
            path,
        }
    }
}
