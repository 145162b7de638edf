//! Settings and results of linking.

use super::bead::Bead;
use crate::Stop;

/// How lines are linked to beads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Nearest neighbour from one random start.
    Nearest,
    /// Nearest neighbour from both ends of every line, the best kept.
    Repetitive,
    /// The method of *ORNL toolpath RL*: nearest neighbour from one random start, then from both
    /// sides of each lift that occurred, the best kept.
    /// [`Settings::rounds`] repeats it.
    BreakPoints,
    /// The fewest beads, with a proven lower bound.
    #[default]
    Cover,
}

beadwork_base::named_enum! {
    Method, "linking method":
    Nearest = "nn",
    Repetitive = "repetitive",
    BreakPoints = "break-points",
    Cover = "cover",
}

/// Settings of linking.
///
/// Construct it with `..Settings::default()`: fields may be added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// The method.
    pub method: Method,
    /// Seed of all random choices.
    pub seed: u64,
    /// Whether nearest neighbour goes to the nearest end that may be linked, if there is one, and
    /// only otherwise to the nearest end, as in the paper.
    pub links_first: bool,
    /// Maximum number of rounds of [`Method::BreakPoints`]: 1 is the method of the paper, 0 leaves
    /// only the random start.
    ///
    /// Each further round starts at both sides of each lift of the best result so far.
    /// A round that finds no fewer beads is the last, so `u32::MAX` repeats until nothing improves.
    pub rounds: u32,
    /// Limit of [`Method::Cover`] on the states that its dynamic program generates, over all
    /// components, as a multiple of the number of lines.
    /// A limit on work rather than on time: results do not depend on the machine.
    pub states_per_line: u32,
    /// Maximum number of states that [`Method::Cover`] keeps at a time; at least 1.
    pub max_width: u32,
}

impl Default for Settings {
    /// The fewest beads, seed 0, linkable ends first, one round of break points, 600 states a line,
    /// 4,096 states at a time.
    fn default() -> Self {
        Self {
            method: Method::default(),
            seed: 0,
            links_first: true,
            rounds: 1,
            states_per_line: 600,
            max_width: 4096,
        }
    }
}

/// Work that a search did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Work {
    /// Runs of nearest neighbour, including those that were given up because they could not be the
    /// best.
    pub runs: u32,
    /// States that the dynamic program generated.
    pub states: u64,
    /// Connected components of lines and links.
    pub components: u32,
    /// Components whose number of beads is proven to be the minimum.
    pub proven_components: u32,
}

/// Beads that contain each line once, and what is proven about their number.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Outcome {
    /// The beads.
    /// With nearest neighbour they have the order and directions in which it found them; with cover
    /// their order and directions have no meaning.
    pub beads: Vec<Bead>,
    /// Proven lower bound on the number of beads.
    pub bound: usize,
    /// Reason why the search stopped: [`Stop::Optimal`] if [`is_optimal`](Self::is_optimal).
    pub stop: Stop,
    /// Work done.
    pub work: Work,
}

impl Outcome {
    /// Whether the number of beads is proven to be the minimum.
    pub fn is_optimal(&self) -> bool {
        self.beads.len() <= self.bound
    }
}
