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
use crate::join::{self, OnLoop, Part};
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
    seams: &[Option<OnLoop>],
    toolpath: &ToolpathSettings,
    settings: &Settings,
    control: &Control<'_>,
) -> Result<IslandBeads, LinksError> {
    let Walls { loops, seams, chains, mut counts } = Walls::new(island, seams, toolpath.bead_mm);
    let rings: Vec<&[[f64; 2]]> = loops.iter().map(|each| &each.ring[..]).collect();
    let outline: Vec<&[[f64; 2]]> = island.outline.rings().map(Vec::as_slice).collect();
    let joiner = settings.join.as_ref().map(|join| join::Loops::new(&rings, &outline, join));
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
            Some(joiner) => join_all(joiner, &seams, &made.ends_mm()),
            None => separate(&loops, &seams, &made.chains),
        };
        if best.as_ref().is_none_or(|best| made.strands.len() < best.strands.len()) {
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
    /// Both ends of each chain.
    pub(super) fn ends_mm(&self) -> Vec<[[f64; 2]; 2]> {
        self.chains.iter().map(Chain::ends_mm).collect()
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
        let chains = chains.iter().filter_map(|points| Chain::new(points, bead_mm, feature));
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
    seams: Vec<Option<OnLoop>>,
    /// Open skeletons.
    chains: Vec<Chain>,
    counts: Counts,
}

impl Walls {
    fn new(island: &Island, seams: &[Option<OnLoop>], bead_mm: f64) -> Self {
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
        seam: Option<OnLoop>,
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
            self.chains.push(Chain { start_mm: *start_mm, moves: moves.clone() });
        }
    }
}

/// A bead for each loop and chain.
fn separate(loops: &[Loop], seams: &[Option<OnLoop>], chains: &[Chain]) -> Vec<join::Bead> {
    let of_loop = |(number, (ring, seam)): (usize, (&Loop, &Option<OnLoop>))| {
        let corners = ring.ring.iter().enumerate();
        let corners = corners.map(|(edge, &point_mm)| vec![OnLoop { edge, point_mm }]);
        let ways = seam.map_or_else(|| corners.collect(), |seam| vec![vec![seam]]);
        join::Bead { parts: vec![Part::Loop(number)], ways }
    };
    let loops = loops.iter().zip(seams).enumerate().map(of_loop);
    let chains = (0..chains.len()).map(|number| join::Bead {
        parts: vec![Part::Chain { number, is_reversed: false }],
        ways: vec![Vec::new()],
    });
    loops.chain(chains).collect()
}

fn join_all(
    joiner: &join::Loops<'_>,
    seams: &[Option<OnLoop>],
    ends: &[[[f64; 2]; 2]],
) -> Vec<join::Bead> {
    let mut strands = joiner.join(ends).beads;
    for strand in &mut strands {
        keep_seam(strand, seams);
    }
    strands
}

/// Keeps the way of a bead whose beginning on an outline is nearest to the seam of that outline.
fn keep_seam(strand: &mut join::Bead, seams: &[Option<OnLoop>]) {
    let loops = strand.parts.iter().filter_map(|part| match part {
        Part::Loop(number) => Some(*number),
        Part::Chain { .. } => None,
    });
    let seam = loops.enumerate().find_map(|(at, number)| Some((at, seams[number]?)));
    let Some((at, seam)) = seam else { return };
    if strand.parts.len() == 1 {
        strand.ways = vec![vec![seam]];
        return;
    }
    let distance2 = |way: &Vec<OnLoop>| {
        (0..2).map(|axis| (way[at].point_mm[axis] - seam.point_mm[axis]).powi(2)).sum::<f64>()
    };
    let nearest = strand.ways.drain(..).min_by(|a, b| distance2(a).total_cmp(&distance2(b)));
    strand.ways.extend(nearest);
}
