//! The beads of one island, before their order is known.

use beadwork_base::Control;
use beadwork_gcode::Feature;
use beadwork_part::Bead;
use beadwork_part::toolpath::{Infill, Inset, Island, Settings as ToolpathSettings};

use super::infill::{Linked, Offer, Region};
use super::outcome::Counts;
use super::settings::Settings;
use super::strand::{Chain, Loop};
use crate::Stop;
use crate::join::{self, Line, Piece, Position};
use crate::link::LinksError;

/// The loops and chains of an island, and the beads that they form.
pub(super) struct IslandBeads {
    pub(super) loops: Vec<Loop>,
    pub(super) chains: Vec<Chain>,
    /// Together they contain every loop and chain once.
    pub(super) strands: Vec<join::Bead>,
    pub(super) counts: Counts,
    /// Reason why the linking of a region stopped early; `None` if none did.
    pub(super) interrupted: Option<Stop>,
}

/// Links and joins the lines of an island.
///
/// `seams` has an entry for each inset.
pub(super) fn island_beads(
    island: &Island,
    seams: &[Option<Position>],
    toolpath: &ToolpathSettings,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<IslandBeads, LinksError> {
    let Walls { loops, seams, chains, mut counts } = Walls::new(island, seams, toolpath.bead_mm);
    let rings: Vec<&[[f64; 2]]> = loops.iter().map(|each| &each.ring[..]).collect();
    let outline: Vec<&[[f64; 2]]> = island.outline.rings().map(Vec::as_slice).collect();
    let joiner =
        settings.join.as_ref().map(|join| join::Loops::new(&rings, &outline, &seams, join));
    let mut regions = Vec::new();
    for infill in &island.infill {
        let mut region = Region::new(infill, &settings.rule)?;
        if let Some(joiner) = &joiner {
            region.find_loops(joiner);
        }
        regions.push((infill, region));
    }
    let mut best: Option<IslandBeads> = None;
    for offer in Offer::ALL {
        if settings.join.is_none() && offer != Offer::Nothing {
            break;
        }
        let mut made = IslandBeads {
            loops: loops.clone(),
            chains: chains.clone(),
            strands: Vec::new(),
            counts,
            interrupted: None,
        };
        for (infill, region) in &regions {
            let linked = region.linked(offer, &settings.link, control)?;
            made.add_chains(infill, linked, toolpath.bead_mm);
        }
        if offer == Offer::Nothing {
            counts.infill_bound = made.counts.infill_bound;
            counts.optimal_regions = made.counts.optimal_regions;
        }
        made.strands = match &joiner {
            Some(joiner) => {
                let points: Vec<&[[f64; 2]]> =
                    made.chains.iter().map(|chain| &chain.points[..]).collect();
                joiner.join(&points).beads
            }
            None => separate(&loops, &seams, &made.chains),
        };
        if best.as_ref().is_none_or(|best| made.rank() < best.rank()) {
            best = Some(made);
        }
    }
    let mut best = best.expect("the first offer always counts");
    best.counts.infill_bound = counts.infill_bound;
    best.counts.optimal_regions = counts.optimal_regions;
    best.counts.beads = best.strands.len();
    best.counts.bead_bound = match settings.join {
        // No bead leaves its island.
        Some(_) => best.strands.len().min(1),
        None => counts.loops + counts.skeletons + counts.infill_bound,
    };
    Ok(best)
}

impl IslandBeads {
    /// Number of beads and of their pieces, both of which should be few.
    fn rank(&self) -> (usize, usize) {
        (self.strands.len(), self.strands.iter().map(join::Bead::piece_count).sum())
    }

    /// Adds the chains of an infill region.
    fn add_chains(&mut self, infill: &Infill, linked: Linked, bead_mm: f64) {
        let feature = infill_feature(infill);
        let Linked { chains, bound, stop } = linked;
        let loops = infill.loops.len();
        self.counts.infill += chains.len() + loops;
        self.counts.infill_bound += bound + loops;
        self.counts.regions += 1;
        self.counts.optimal_regions += usize::from(chains.len() <= bound);
        if matches!(stop, Stop::Cancelled | Stop::TimeUp) {
            self.interrupted = Some(stop);
        }
        let chains = chains.into_iter().filter_map(|points| Chain::new(points, bead_mm, feature));
        self.chains.extend(chains);
    }
}

fn infill_feature(infill: &Infill) -> Feature {
    if infill.is_solid { Feature::SolidInfill } else { Feature::Infill }
}

/// Everything of an island that is not linked: insets, skeletons, concentric infill.
#[derive(Default)]
struct Walls {
    loops: Vec<Loop>,
    /// For each loop, where it must begin if that is fixed.
    seams: Vec<Option<Position>>,
    /// Open skeletons.
    chains: Vec<Chain>,
    counts: Counts,
}

impl Walls {
    fn new(island: &Island, seams: &[Option<Position>], bead_mm: f64) -> Self {
        let mut walls = Self::default();
        for (Inset { depth, ring, .. }, &seam) in island.insets.iter().zip(seams) {
            let feature = if *depth == 0 { Feature::OuterWall } else { Feature::InnerWall };
            walls.add_loop(ring, vec![bead_mm; ring.len()], feature, seam);
        }
        walls.counts.loops = walls.loops.len();
        let feature = if island.insets.is_empty() { Feature::ThinWall } else { Feature::GapFill };
        for skeleton in &island.skeletons {
            walls.add_skeleton(&skeleton.bead(island.material, feature), skeleton.is_closed);
        }
        for infill in &island.infill {
            for ring in &infill.loops {
                walls.add_loop(ring, vec![bead_mm; ring.len()], infill_feature(infill), None);
            }
        }
        walls
    }

    fn add_loop(
        &mut self,
        ring: &[[f64; 2]],
        widths_mm: Vec<f64>,
        feature: Feature,
        seam: Option<Position>,
    ) {
        if ring.len() > 1 {
            self.loops.push(Loop { ring: ring.to_vec(), widths_mm, feature });
            self.seams.push(seam);
        }
    }

    fn add_skeleton(&mut self, bead: &Bead, is_closed: bool) {
        let Bead { start_mm, moves, .. } = bead;
        let Some((last, others)) = moves.split_last() else { return };
        self.counts.skeletons += 1;
        if is_closed {
            let ends = others.iter().map(|step| step.to_mm);
            let ring: Vec<[f64; 2]> = std::iter::once(*start_mm).chain(ends).collect();
            let widths_mm = moves.iter().map(|step| step.width_mm).collect();
            self.add_loop(&ring, widths_mm, last.feature, None);
        } else {
            let ends = moves.iter().map(|step| step.to_mm);
            let points = std::iter::once(*start_mm).chain(ends).collect();
            let widths_mm = moves.iter().map(|step| step.width_mm).collect();
            self.chains.push(Chain { points, widths_mm, feature: last.feature });
        }
    }
}

/// A bead for each loop and chain.
fn separate(loops: &[Loop], seams: &[Option<Position>], chains: &[Chain]) -> Vec<join::Bead> {
    let of_loop = |(number, (ring, seam)): (usize, (&Loop, &Option<Position>))| {
        let whole = |begin: Position| {
            let line = Line::Loop(number);
            vec![Piece { line, from: begin, to: begin, is_reversed: false }]
        };
        let corners = ring.ring.iter().enumerate();
        let corners = corners.map(|(edge, &point_mm)| whole(Position { edge, point_mm }));
        join::Bead { ways: seam.map_or_else(|| corners.collect(), |seam| vec![whole(seam)]) }
    };
    let of_chain = |(number, chain): (usize, &Chain)| {
        let [from, to] = chain.ends_mm();
        let from = Position { edge: 0, point_mm: from };
        let to = Position { edge: chain.points.len() - 2, point_mm: to };
        let line = Line::Chain(number);
        join::Bead { ways: vec![vec![Piece { line, from, to, is_reversed: false }]] }
    };
    let loops = loops.iter().zip(seams).enumerate().map(of_loop);
    loops.chain(chains.iter().enumerate().map(of_chain)).collect()
}
