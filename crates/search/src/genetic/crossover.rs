//! Crossover and mutation: how children are made from their parents.

use beadwork_grid::{PlacedVariant, Variant};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::gene::Gene;
use crate::Move;
use crate::random::below;

/// How two parents make a child.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crossover {
    /// The first genes of one parent, followed by the last ones of the other.
    OnePoint {
        /// Share of the genes, 0..=1, that come from the first parent; 0.6 in the paper.
        first: f64,
    },
    /// The genes of one parent, with a random range replaced by the genes of the other.
    TwoPoint,
    /// The moves of one parent outside a random window of the grid and those of the other inside
    /// it.
    /// Both keep their order; moves beyond the length of an individual are dropped.
    ///
    /// Whether a variant applies depends only on the links near it, and crossings are links.
    /// So the child has the crossings of one parent inside the window and those of the other
    /// outside, except along the window's border: it can combine the best parts of both.
    Window,
}

impl Crossover {
    /// Makes a child in a grid of the given width and height.
    /// Both parents have the same number of genes, and so does the child.
    pub(super) fn cross(
        self,
        [one, other]: [&[Gene]; 2],
        (width, height): (u32, u32),
        rng: &mut Xoshiro256PlusPlus,
    ) -> Vec<Gene> {
        match self {
            Self::OnePoint { first } => {
                let cut = ((first * one.len() as f64) as usize).min(one.len());
                [&one[..cut], &other[cut..]].concat()
            }
            Self::TwoPoint => {
                let (from, to) = range(one.len(), rng);
                [&one[..from], &other[from..to], &one[to..]].concat()
            }
            Self::Window => {
                let window = Window::draw(width, height, rng);
                // Which genes are kept is unpredictable, so a branch for each of them would be
                // slow.
                // So every gene is written, but the length advances only past those that are kept,
                // and the next gene overwrites the others.
                // The list has room for all genes of both parents.
                let mut genes = vec![None; one.len() + other.len() + 1];
                let mut length = 0;
                for (outer, inner) in one.iter().zip(other) {
                    genes[length] = *outer;
                    length += usize::from(outer.is_some_and(|gene| !window.contains(gene)));
                    genes[length] = *inner;
                    length += usize::from(inner.is_some_and(|gene| window.contains(gene)));
                }
                genes.truncate(length);
                genes.resize(one.len(), None);
                genes
            }
        }
    }
}

/// A rectangle of cells.
struct Window {
    left: u32,
    top: u32,
    columns: u32,
    rows: u32,
    /// Width of the grid.
    width: u32,
}

impl Window {
    fn draw(width: u32, height: u32, rng: &mut Xoshiro256PlusPlus) -> Self {
        let (left, right) = range(width as usize, rng);
        let (top, bottom) = range(height as usize, rng);
        let [left, right, top, bottom] = [left, right, top, bottom].map(|side| side as u32);
        Self { left, top, columns: right - left, rows: bottom - top, width }
    }

    /// Whether a gene lies in the window, judged by one cell: the top-left cell of a variant, or
    /// the corner of a pair's first switch.
    #[inline]
    fn contains(&self, gene: Move) -> bool {
        let (x, y) = match gene {
            Move::Variant(placed) => (u32::from(placed.x), u32::from(placed.y)),
            Move::Pair([first, _]) => (first.corner() % self.width, first.corner() / self.width),
        };
        x.wrapping_sub(self.left) < self.columns && y.wrapping_sub(self.top) < self.rows
    }
}

/// Replaces a random gene by a random variant anywhere in the grid, which `write` turns into a
/// move.
pub(super) fn mutate(
    genes: &mut [Gene],
    (width, height): (u32, u32),
    write: impl Fn(PlacedVariant) -> Move,
    rng: &mut Xoshiro256PlusPlus,
) {
    if genes.is_empty() {
        return;
    }
    let variant = Variant::ALL[below(rng, Variant::ALL.len())];
    let (x, y) = (below(rng, width as usize) as u16, below(rng, height as usize) as u16);
    genes[below(rng, genes.len())] = Some(write(PlacedVariant { variant, x, y }));
}

/// Two random numbers in 0..=`end`, the lower one first.
fn range(end: usize, rng: &mut Xoshiro256PlusPlus) -> (usize, usize) {
    let (a, b) = (below(rng, end + 1), below(rng, end + 1));
    (a.min(b), a.max(b))
}
