//! A layer of beads, cut into pieces that can be printed in another order.

use beadwork_gcode::Feature;
use beadwork_part::{Bead, BeadRows, ExtrusionMove, TurnedBead};

use super::timing::{SAME_MM, distance_mm};

/// Minimum length of a line, in its widths: shorter moves are links between lines, or corners.
const LINE_WIDTHS: f64 = 3.0;

/// Cosine of the maximum angle between the lines of a bead, and between those of parallel beads.
const PARALLEL: f64 = 0.94;

/// A layer of beads as pieces.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pieces {
    /// Beads that stay in their order, before all others: everything that is not infill; then the
    /// pieces of the infill, direction by direction.
    pub(super) beads: Vec<Bead>,
    /// Number of beads that stay in their order.
    pub(super) fixed: usize,
    /// The pieces of each direction of the infill, in rows.
    pub(super) directions: Vec<BeadRows>,
    /// The order of the pieces in which the layer was given.
    pub(super) listed: Vec<TurnedBead>,
}

impl Pieces {
    /// Cuts the infill of a layer at the beginning of each link between two lines.
    ///
    /// Every move of the layer is a move of one piece.
    pub(super) fn of(layer: &[Bead]) -> Self {
        // A bead that stays, by its number; or a piece, by its direction and its number there.
        let mut listed: Vec<(Option<usize>, usize)> = Vec::new();
        let mut fixed: Vec<Bead> = Vec::new();
        let mut parallel: Vec<Vec<Bead>> = Vec::new();
        for bead in layer {
            if !is_infill(bead) {
                listed.push((None, fixed.len()));
                fixed.push(bead.clone());
                continue;
            }
            for piece in lines_of(bead) {
                let along = direction(&piece);
                let is_parallel =
                    |others: &Vec<Bead>| dot(along, direction(&others[0])).abs() >= PARALLEL;
                let at = parallel.iter().position(is_parallel).unwrap_or(parallel.len());
                if at == parallel.len() {
                    parallel.push(Vec::new());
                }
                listed.push((Some(at), parallel[at].len()));
                parallel[at].push(piece);
            }
        }
        let directions: Vec<BeadRows> = parallel.iter().cloned().map(BeadRows::new).collect();
        let first = |at: usize| fixed.len() + parallel[..at].iter().map(Vec::len).sum::<usize>();
        let turned = |&(at, number): &(Option<usize>, usize)| match at {
            None => TurnedBead { bead: number as u32, is_reversed: false },
            Some(at) => {
                let (given, row) = (&parallel[at][number], &directions[at].beads()[number]);
                let is_reversed = distance_mm(given.start_mm, row.start_mm) > 0.0;
                TurnedBead { bead: (first(at) + number) as u32, is_reversed }
            }
        };
        let listed = listed.iter().map(turned).collect();
        let rows = directions.iter().flat_map(|rows| rows.beads().iter().cloned());
        let beads = fixed.iter().cloned().chain(rows).collect();
        Self { beads, fixed: fixed.len(), directions, listed }
    }

    /// The beads of an order of the pieces: those that follow one another without travel are one.
    pub(super) fn join(&self, order: &[TurnedBead]) -> Vec<Bead> {
        let mut joined: Vec<Bead> = Vec::new();
        let mut is_open = false;
        for turned in order {
            let next = turned.of(&self.beads);
            let is_free = turned.bead as usize >= self.fixed;
            match joined.last_mut() {
                Some(last)
                    if is_free
                        && is_open
                        && last.tool == next.tool
                        && distance_mm(last.end_mm(), next.start_mm) < SAME_MM =>
                {
                    last.moves.extend(next.moves);
                }
                _ => joined.push(next),
            }
            is_open = is_free;
        }
        joined
    }
}

fn is_infill(bead: &Bead) -> bool {
    let is_infill =
        |step: &ExtrusionMove| matches!(step.feature, Feature::Infill | Feature::SolidInfill);
    !bead.moves.is_empty() && bead.moves.iter().all(is_infill)
}

/// The pieces of a bead of infill: each has one line, with the link before it, and the last one
/// what comes after it.
fn lines_of(bead: &Bead) -> Vec<Bead> {
    let along = direction(bead);
    let is_line = |(from, to, width_mm): ([f64; 2], [f64; 2], f64)| {
        let length = distance_mm(from, to);
        let step = [to[0] - from[0], to[1] - from[1]];
        length >= LINE_WIDTHS * width_mm && dot(step, along).abs() >= PARALLEL * length
    };
    let lines: Vec<usize> =
        bead.lines().enumerate().filter(|&(_, line)| is_line(line)).map(|(at, _)| at).collect();
    let mut pieces = Vec::with_capacity(lines.len().max(1));
    let (mut start_mm, mut begin) = (bead.start_mm, 0);
    for pair in 0..lines.len().max(1) {
        // Lines one after the other, such as the two sides of a corner, are separate pieces, too.
        let end = if pair + 1 < lines.len() { lines[pair] + 1 } else { bead.moves.len() };
        let moves = bead.moves[begin..end].to_vec();
        let end_mm = moves.last().map_or(start_mm, |last| last.to_mm);
        pieces.push(Bead { tool: bead.tool, start_mm, moves });
        (start_mm, begin) = (end_mm, end);
    }
    pieces
}

/// Unit vector along the longest move of a bead; x without any.
fn direction(bead: &Bead) -> [f64; 2] {
    let longest = bead.lines().map(|(from, to, _)| [to[0] - from[0], to[1] - from[1]]);
    let length = |step: &[f64; 2]| libm::hypot(step[0], step[1]);
    let longest = longest.max_by(|a, b| length(a).total_cmp(&length(b)));
    match longest {
        Some(step) if length(&step) > 0.0 => step.map(|side| side / length(&step)),
        _ => [1.0, 0.0],
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;

    fn bead(points: &[[f64; 2]], feature: Feature) -> Bead {
        let moves = points[1..].iter();
        let moves = moves.map(|&to_mm| ExtrusionMove { to_mm, width_mm: 0.5, feature });
        Bead { tool: 0, start_mm: points[0], moves: moves.collect() }
    }

    /// A zigzag of lines along an axis, with links between them.
    fn zigzag(lines: usize, length: f64, along_y: bool) -> Bead {
        let points = (0..2 * lines).map(|end| {
            let (across, along) = ((end / 2) as f64 * 0.5, [0.0, length][(end + end / 2) % 2]);
            if along_y { [across, along] } else { [along, across] }
        });
        bead(&points.collect::<Vec<_>>(), Feature::SolidInfill)
    }

    #[test]
    fn a_zigzag_is_cut_before_its_links() {
        let pieces = lines_of(&zigzag(3, 9.0, false));
        let lengths: Vec<f64> = pieces.iter().map(Bead::length_mm).collect();
        assert_eq!(lengths, [9.0, 9.5, 9.5]);
        let curl = bead(&[[0.0, 0.0], [0.3, 0.0], [0.3, 0.3]], Feature::Infill);
        assert_eq!(lines_of(&curl), [curl]);
    }

    #[test]
    fn walls_come_first_and_directions_are_apart() {
        let wall = bead(&[[0.0, 0.0], [9.0, 0.0], [9.0, 9.0]], Feature::OuterWall);
        let layer = [zigzag(4, 9.0, true), wall.clone(), zigzag(3, 9.0, false)];
        let pieces = Pieces::of(&layer);
        assert_eq!((pieces.fixed, &pieces.beads[0]), (1, &wall));
        let rows: Vec<usize> = pieces.directions.iter().map(BeadRows::row_count).collect();
        assert_eq!(rows, [4, 3]);
        assert_eq!(pieces.join(&pieces.listed), layer);
    }

    #[test]
    fn listed_pieces_are_the_layer() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let mut number = |below: u64| rng.next_u64() % below;
        for _ in 0..1000 {
            let features = [Feature::InnerWall, Feature::Infill, Feature::SolidInfill];
            let layer: Vec<Bead> = (0..number(6))
                .map(|_| {
                    let points: Vec<[f64; 2]> = (0..2 + number(12))
                        .map(|_| [number(20) as f64 / 4.0, number(20) as f64 / 4.0])
                        .collect();
                    bead(&points, features[number(3) as usize])
                })
                .collect();
            let pieces = Pieces::of(&layer);
            let joined = pieces.join(&pieces.listed);
            let moves = |beads: &[Bead]| -> Vec<_> {
                beads.iter().flat_map(Bead::lines).map(|(from, to, _)| (from, to)).collect()
            };
            assert_eq!(moves(&joined), moves(&layer));
            assert!(joined.len() <= layer.len());
            let all: usize = pieces.beads.iter().map(|bead| bead.moves.len()).sum();
            assert_eq!(all, layer.iter().map(|bead| bead.moves.len()).sum::<usize>());
        }
    }
}
