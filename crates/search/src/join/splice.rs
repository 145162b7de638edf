//! Splices loops into the beads that pass near them.

use super::bead::{Bead, Line, Piece, Position};
use super::curves::Curves;
use super::geometry::distance2;
use super::merge::MAX_WAYS;
use super::sequence::{Part, Sequence};
use super::slits::{Scene, Splice};
use super::steps::Steps;
use crate::disjoint_sets::DisjointSets;
use crate::segment::Segment;

/// Rounds after which no sequence is taken apart any more.
/// Two or three are usual; more would be slow for islands of very many loops.
const MAX_ROUNDS: u32 = 8;

/// The beads of some sequences, with sequences of loops spliced into others where that is possible.
///
/// At most as many beads as sequences, unless steps of sequences cross each other.
pub(super) fn splice(mut sequences: Vec<Sequence>, scene: &Scene<'_>) -> Vec<Bead> {
    // Few ways of a sequence are needed: the one at the seam.
    sequences.iter_mut().for_each(|sequence| keep_seam(sequence, scene));
    let rings = sequences.iter().filter(|sequence| sequence.has_only_loops()).flat_map(loops);
    let rings: Vec<usize> = rings.collect();
    let splices = if scene.slit_mm > 0.0 { scene.splices(&rings) } else { Vec::new() };
    let mut is_kept = kept_sequences(&sequences, &splices, scene);
    let mut round = 0;
    loop {
        let mut curves = Curves::new(scene.paths, scene.loop_count, scene.near.reach_mm());
        for (sequence, _) in sequences.iter().zip(&is_kept).filter(|(_, is_kept)| **is_kept) {
            curves.follow(sequence, 0);
        }
        for splice in &splices {
            scene.try_splice(&mut curves, splice);
        }
        // What is impossible once stays impossible, so one pass is enough.
        debug_assert!(!splices.iter().any(|splice| scene.try_splice(&mut curves, splice)));
        let failed = failed_sequences(&sequences, &is_kept, &mut curves);
        if failed.is_empty() {
            return beads(&sequences, &is_kept, curves, scene);
        }
        failed.into_iter().for_each(|number| is_kept[number] = true);
        round += 1;
        if round == MAX_ROUNDS {
            is_kept.iter_mut().zip(&sequences).for_each(|(is_kept, sequence)| {
                *is_kept |= sequence.parts.len() > 1;
            });
        }
    }
}

/// The loops of a sequence.
fn loops(sequence: &Sequence) -> impl Iterator<Item = usize> + '_ {
    sequence.parts.iter().filter_map(|part| match *part {
        Part::Loop(number) => Some(number),
        Part::Chain { .. } => None,
    })
}

/// Keeps the way of a sequence that begins nearest to the seam of its first loop with one.
fn keep_seam(sequence: &mut Sequence, scene: &Scene<'_>) {
    let seam = loops(sequence)
        .enumerate()
        .find_map(|(at, ring)| Some((at, scene.seams.get(ring).copied().flatten()?)));
    let Some((at, seam)) = seam else { return };
    if sequence.parts.len() == 1 {
        sequence.ways = vec![vec![seam]];
        return;
    }
    let from_seam = |&way: &usize| distance2(sequence.ways[way][at].point_mm, seam.point_mm);
    let compare = |a: &usize, b: &usize| from_seam(a).total_cmp(&from_seam(b)).then(a.cmp(b));
    if let Some(nearest) = (0..sequence.ways.len()).min_by(compare) {
        sequence.ways.swap(0, nearest);
        sequence.ways.truncate(1);
    }
}

/// Which sequences stay joined end to end: all that contain chains, and the longest one of loops
/// where no chain is near, because one step leaves fewer marks than two.
fn kept_sequences(sequences: &[Sequence], splices: &[Splice], scene: &Scene<'_>) -> Vec<bool> {
    let mut components = DisjointSets::new(scene.paths.len());
    for sequence in sequences {
        let elements: Vec<usize> =
            sequence.parts.iter().map(|&part| element(part, scene)).collect();
        for pair in elements.windows(2) {
            components.union(pair[0] as u32, pair[1] as u32);
        }
    }
    for splice in splices {
        components.union(splice.paths[0] as u32, splice.paths[1] as u32);
    }
    let mut is_kept: Vec<bool> =
        sequences.iter().map(|sequence| !sequence.has_only_loops()).collect();
    // For each component the sequence that others are spliced into.
    let mut host: Vec<Option<usize>> = vec![None; scene.paths.len()];
    for (number, sequence) in sequences.iter().enumerate() {
        let host = &mut host[components.find(element(sequence.parts[0], scene) as u32) as usize];
        let rank = |number: usize| (is_kept[number], sequences[number].parts.len());
        if host.is_none_or(|host| rank(number) > rank(host)) {
            *host = Some(number);
        }
    }
    for host in host.into_iter().flatten() {
        is_kept[host] |= sequences[host].parts.len() > 1;
    }
    is_kept
}

/// The number of a loop or chain among the paths.
fn element(part: Part, scene: &Scene<'_>) -> usize {
    match part {
        Part::Loop(number) => number,
        Part::Chain { number, .. } => scene.loop_count + number,
    }
}

/// The sequences that are not kept, and whose loops were not all spliced into one other bead.
///
/// If none failed, every sequence is part of a single bead, so beads do not outnumber sequences.
fn failed_sequences(
    sequences: &[Sequence],
    is_kept: &[bool],
    curves: &mut Curves<'_>,
) -> Vec<usize> {
    let mut failed = Vec::new();
    for (number, sequence) in sequences.iter().enumerate() {
        if is_kept[number] || sequence.parts.len() < 2 {
            continue;
        }
        let mut of_loops: Vec<usize> = loops(sequence).map(|ring| curves.curve(ring)).collect();
        of_loops.dedup();
        if of_loops.len() > 1 || !curves.is_open(loops(sequence).next().unwrap_or(0)) {
            failed.push(number);
        }
    }
    failed
}

/// The beads of finished curves.
fn beads(
    sequences: &[Sequence],
    is_kept: &[bool],
    mut curves: Curves<'_>,
    scene: &Scene<'_>,
) -> Vec<Bead> {
    let mut beads = Vec::new();
    let mut is_done = vec![false; scene.paths.len()];
    // Sequences of loops that nothing was spliced into can still begin anywhere.
    let mut more_steps = Steps::new(scene.near.reach_mm());
    for (sequence, _) in sequences.iter().zip(is_kept).filter(|(_, is_kept)| **is_kept) {
        let is_alone = loops(sequence).all(|ring| curves.cut_count(ring) == 1);
        let curve = curves.curve(element(sequence.parts[0], scene));
        if sequence.has_only_loops()
            && is_alone
            && loops(sequence).all(|ring| curves.curve(ring) == curve)
        {
            let ways = ways(sequence, &curves, &mut more_steps);
            beads.push(Bead { ways });
            is_done[curve] = true;
        }
    }
    for (curve, pieces) in curves.open_curves() {
        if !std::mem::replace(&mut is_done[curve], true) {
            beads.push(Bead { ways: vec![pieces] });
        }
    }
    for sequence in sequences {
        for ring in loops(sequence) {
            let curve = curves.curve(ring);
            if std::mem::replace(&mut is_done[curve], true) {
                continue;
            }
            // What is left is closed.
            let ways = if curves.is_cut(ring) {
                closed_ways(ring, &curves, scene)
            } else {
                sequence.ways.iter().map(|way| vec![whole(ring, way[0])]).collect()
            };
            beads.push(Bead { ways });
        }
    }
    beads
}

/// A whole loop from one of its points.
fn whole(ring: usize, begin: Position) -> Piece {
    Piece { line: Line::Loop(ring), from: begin, to: begin, is_reversed: false }
}

/// The ways of a sequence of loops alone whose steps cross no step of another bead.
///
/// `more_steps` are those of other ways of the sequences before; the ones of this are added.
fn ways(sequence: &Sequence, curves: &Curves<'_>, more_steps: &mut Steps) -> Vec<Vec<Piece>> {
    let own: Vec<Segment> = steps(&sequence.ways[0]).collect();
    let is_clear = |way: &&Vec<Position>| {
        steps(way).all(|step| {
            !curves.steps().crosses_other_than(step, &own) && !more_steps.any_near(step, 0.0)
        })
    };
    let pieces = |way: &&Vec<Position>| {
        loops(sequence).zip(way.iter()).map(|(ring, &begin)| whole(ring, begin)).collect()
    };
    // The first way was compared with all other steps before.
    let more = sequence.ways[1..].iter().filter(is_clear);
    let ways: Vec<_> = sequence.ways[..1].iter().chain(more).collect();
    let pieces = ways.iter().map(pieces).collect();
    ways[1..].iter().flat_map(|way| steps(way)).for_each(|step| more_steps.push(step));
    pieces
}

fn steps(way: &[Position]) -> impl Iterator<Item = Segment> + '_ {
    way.windows(2).map(|pair| [pair[0].point_mm, pair[1].point_mm])
}

/// Ways of a closed curve, beginning at the seam of a loop or anywhere along it.
fn closed_ways(ring: usize, curves: &Curves<'_>, scene: &Scene<'_>) -> Vec<Vec<Piece>> {
    let seam = scene.seams.get(ring).copied().flatten();
    let at_seam = seam.and_then(|seam| curves.closed_curve(ring, seam));
    if let Some(pieces) = at_seam {
        return vec![pieces];
    }
    let samples = scene.near.samples(ring);
    let every = samples.len().div_ceil(MAX_WAYS).max(1);
    let begins = samples.iter().step_by(every);
    let mut ways: Vec<_> = begins.filter_map(|&begin| curves.closed_curve(ring, begin)).collect();
    if ways.is_empty() {
        ways.push(curves.closed_curve_at_cut(ring));
    }
    ways
}
