//! The beads of one layer in printing order.

use beadwork_base::Control;
use beadwork_part::toolpath::{Island, Settings as ToolpathSettings};
use beadwork_part::{Bead, BeadLayer};

use super::island::{IslandBeads, island_beads};
use super::outcome::Counts;
use super::rectangle::Rectangle;
use super::settings::Settings;
use super::solve::BeadError;
use super::strand::bead;
use crate::Stop;
use crate::join::{self, Line, Position};
use crate::travel::{self, Item, Shape, Visit, Way};

/// Orders the beads of layers one after the other.
pub(super) struct LayerPlanner<'a> {
    pub(super) toolpath: &'a ToolpathSettings,
    pub(super) settings: &'a Settings,
    pub(super) control: &'a Control<'a>,
    /// The tool that printed the bead before, and where that bead ended.
    pub(super) before: Option<(u8, [f64; 2])>,
}

/// A planned layer.
pub(super) struct PlannedLayer {
    pub(super) layer: BeadLayer,
    pub(super) counts: Counts,
    pub(super) travel_mm: f64,
    pub(super) travel_bound_mm: Option<f64>,
    pub(super) interrupted: Option<Stop>,
}

/// A bead of an island.
struct Candidate<'a> {
    island: &'a IslandBeads,
    strand: &'a join::Bead,
    group: u32,
    /// For a bead of loops, where it may begin.
    entries: Vec<[f64; 2]>,
}

impl LayerPlanner<'_> {
    /// Plans a layer whose tools are used in a given order; `seams` has an entry for each inset of
    /// each island.
    pub(super) fn plan(
        &mut self,
        number: usize,
        islands: &[Island],
        seams: &[Vec<Option<Position>>],
        tools: &[u8],
    ) -> Result<PlannedLayer, BeadError> {
        let layer = BeadLayer { number, beads: Vec::new() };
        let bound =
            (self.settings.bound_iterations > 0 && self.settings.join.is_none()).then_some(0.0);
        let mut planned = PlannedLayer {
            layer,
            counts: Counts::default(),
            travel_mm: 0.0,
            travel_bound_mm: bound,
            interrupted: None,
        };
        for (at, &tool) in tools.iter().enumerate() {
            let mut made = Vec::new();
            for (island, seams) in islands.iter().zip(seams) {
                if island.material == tool {
                    let beads =
                        island_beads(island, seams, self.toolpath, self.settings, self.control);
                    made.push(beads.map_err(|source| BeadError::Links { layer: number, source })?);
                }
            }
            for island in &made {
                planned.counts.add(&island.counts);
                planned.interrupted = planned.interrupted.or(island.interrupted);
            }
            let next = tools.get(at + 1).and_then(|&next| Rectangle::around(islands, next));
            self.order(tool, next, &made, &mut planned)?;
        }
        Ok(planned)
    }

    /// Adds the beads of one tool in the order of short travel; `next` is around the islands of the
    /// tool after it in this layer.
    fn order(
        &mut self,
        tool: u8,
        next: Option<Rectangle>,
        islands: &[IslandBeads],
        planned: &mut PlannedLayer,
    ) -> Result<(), BeadError> {
        let candidates: Vec<Candidate<'_>> = (0..)
            .zip(islands)
            .flat_map(|(group, island)| {
                island.strands.iter().map(move |strand| Candidate::new(island, strand, group))
            })
            .collect();
        let items: Vec<Item<'_>> = candidates.iter().map(Candidate::item).collect();
        let is_change = self.before.is_some_and(|(before, _)| before != tool);
        let from = match self.settings.tool_change_mm {
            Some(position) if is_change => Some(position),
            _ => self.before.map(|(_, end)| end),
        };
        let settings = travel::Settings {
            order: self.settings.order,
            from,
            retraction: self.settings.retraction,
            seed: self.settings.seed ^ planned.layer.number as u64,
            kicks_per_item: self.settings.kicks_per_bead,
            ..travel::Settings::default()
        };
        let number = planned.layer.number;
        let route = travel::solve(&items, &settings, self.control)
            .map_err(|source| BeadError::Travel { layer: number, source })?;
        if matches!(route.stop, Stop::Cancelled | Stop::TimeUp) {
            planned.interrupted = planned.interrupted.or(Some(route.stop));
        }
        // From anywhere: where the nozzle comes from depends on how the beads before are ordered.
        if let Some(sum) = planned.travel_bound_mm {
            let (order, iterations) = (settings.order, self.settings.bound_iterations);
            let control = self.control;
            let bound = travel::lower_bound_mm(&items, order, route.travel_mm, iterations, control)
                .map_err(|source| BeadError::Travel { layer: number, source })?;
            planned.travel_bound_mm = bound.map(|bound| sum + bound);
        }
        let mut here = from.filter(|_| !is_change);
        let mut visits = route.visits;
        if let (Some(next), None) = (next, self.settings.tool_change_mm) {
            turn_last(&mut visits, &items, from, next);
        }
        for visit in &visits {
            let bead = candidates[visit.item].bead(visit.way, tool);
            if let Some(here) = here {
                planned.travel_mm += distance_mm(here, bead.start_mm);
            }
            let end = bead.end_mm();
            here = Some(end);
            self.before = Some((tool, end));
            planned.layer.beads.push(bead);
        }
        Ok(())
    }
}

impl<'a> Candidate<'a> {
    fn new(island: &'a IslandBeads, strand: &'a join::Bead, group: u32) -> Self {
        let entries = if strand.has_only_loops() {
            strand.ways.iter().map(|way| way[0].from.point_mm).collect()
        } else {
            Vec::new()
        };
        Self { island, strand, group, entries }
    }

    fn item(&self) -> Item<'_> {
        let is_loop = |piece: &join::Piece| matches!(piece.line, Line::Loop(_));
        let has_loops = self.strand.ways[0].iter().any(is_loop);
        let item = if self.entries.is_empty() {
            let [start, end] = self.strand.ends_mm(0);
            Item { shape: Shape::Bead { start, end, reversible: true }, group: 0, stage: 0 }
        } else {
            Item::closed(&self.entries)
        };
        item.within(self.group, u32::from(!has_loops))
    }

    fn bead(&self, way: Way, tool: u8) -> Bead {
        let IslandBeads { loops, chains, .. } = self.island;
        match way {
            Way::Entry(entry) => bead(&self.strand.ways[entry], loops, chains, tool),
            Way::Forward => bead(&self.strand.ways[0], loops, chains, tool),
            Way::Backward => bead(&self.strand.reversed().ways[0], loops, chains, tool),
        }
    }
}

/// Turns the last bead of a route if that makes the travel to it and from it to the next islands
/// shorter.
fn turn_last(visits: &mut [Visit], items: &[Item<'_>], from: Option<[f64; 2]>, next: Rectangle) {
    let Some((last, before)) = visits.split_last_mut() else { return };
    let turned = match (items[last.item].shape, last.way) {
        (Shape::Bead { reversible: true, .. }, Way::Forward) => Way::Backward,
        (Shape::Bead { reversible: true, .. }, Way::Backward) => Way::Forward,
        _ => return,
    };
    let here = before.last().map(|visit| visit.ends(items)[1]).or(from);
    let turned = Visit { way: turned, ..*last };
    let travel_mm = |visit: Visit| {
        let [start, end] = visit.ends(items);
        here.map_or(0.0, |here| distance_mm(here, start)) + next.distance_mm(end)
    };
    if travel_mm(turned) < travel_mm(*last) {
        *last = turned;
    }
}

fn distance_mm(a: [f64; 2], b: [f64; 2]) -> f64 {
    let [x, y] = [a[0] - b[0], a[1] - b[1]];
    (x * x + y * y).sqrt()
}
