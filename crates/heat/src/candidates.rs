//! The orders that planners choose from.

use beadwork_base::named_enum;
use beadwork_part::{LineOrder, Order, Pattern, Sequence, Stride};

/// Strides of the interleaved and scattered orders of lines.
const STRIDES: std::ops::RangeInclusive<u32> = 2..=15;

/// A set of named orders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum OrderSet {
    /// The 38 patterns.
    Patterns,
    /// Interleaved and scattered orders of lines with strides 2 to 15, golden and bit-reversed
    /// ones, along both axes and from all corners.
    Lines,
    /// Both: 278 orders.
    All,
}

named_enum! {
    OrderSet, "set of orders":
    Patterns = "patterns",
    Lines = "lines",
    All = "all",
}

impl OrderSet {
    /// The orders of the set.
    /// Patterns come first, and the conventional order is always among them.
    pub fn orders(self) -> Vec<Order> {
        let mut orders: Vec<Order> = match self {
            Self::Lines => vec![Order::CONVENTIONAL],
            Self::Patterns | Self::All => Pattern::ALL.map(Order::from).to_vec(),
        };
        if self != Self::Patterns {
            let strides = STRIDES.filter_map(|k| Stride::new(k).ok());
            let sequences = strides
                .flat_map(|k| [Sequence::Interleaved(k), Sequence::Scattered(k)])
                .chain([Sequence::Golden, Sequence::BitReversed]);
            orders.extend(sequences.flat_map(LineOrder::all_of).map(Order::from));
        }
        orders
    }
}
