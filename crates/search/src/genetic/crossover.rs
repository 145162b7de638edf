//! How children come from parents.

use beadwork_grid::{PlacedVariant, Variant};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::individual::Gene;
use crate::Move;
use crate::random::below;

/// How two parents make a child.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Crossover {
    /// The first genes of one parent and the last ones of the other.
    OnePoint {
        /// Share of the genes, 0..=1, that come from the first parent; 0.6 in the paper.
        first: f64,
    },
    /// The genes of one parent, but for a random stretch of the other's in place of its own.
    TwoPoint,
    /// The moves of one parent outside a random window of the plane, and those of the other inside,
    /// in their own order and as many as fit.
    ///
    /// A variant applies or not by the links near it alone, and crossings are links too.
    /// So the child has the crossings of one parent inside the window, those of the other outside,
    /// and surprises only along its edges: it can have the best of both.
    Window,
}

impl Crossover {
    /// Makes a child in a plane of such a width and height.
    /// Both parents have as many genes, and so has the child.
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
                // Room for all of both, so that each gene can be written whether it counts or not:
                // which do is as good as random.
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

/// A rectangle of a plane.
struct Window {
    left: u32,
    top: u32,
    columns: u32,
    rows: u32,
    /// Of the plane.
    width: u32,
}

impl Window {
    fn draw(width: u32, height: u32, rng: &mut Xoshiro256PlusPlus) -> Self {
        let (left, right) = range(width as usize, rng);
        let (top, bottom) = range(height as usize, rng);
        let [left, right, top, bottom] = [left, right, top, bottom].map(|side| side as u32);
        Self { left, top, columns: right - left, rows: bottom - top, width }
    }

    /// Whether a gene begins here: the window of a variant, or the first switch of a pair.
    #[inline]
    fn contains(&self, gene: Move) -> bool {
        let (x, y) = match gene {
            Move::Variant(placed) => (u32::from(placed.x), u32::from(placed.y)),
            Move::Pair([first, _]) => (first.corner() % self.width, first.corner() / self.width),
        };
        x.wrapping_sub(self.left) < self.columns && y.wrapping_sub(self.top) < self.rows
    }
}

/// Replaces a gene by a random variant somewhere in the plane, written as `write` does.
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

/// Two numbers from 0 to `end`, the lower one first.
fn range(end: usize, rng: &mut Xoshiro256PlusPlus) -> (usize, usize) {
    let (a, b) = (below(rng, end + 1), below(rng, end + 1));
    (a.min(b), a.max(b))
}
