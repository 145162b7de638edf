//! Rectangles around islands: about how far it is from one tool's islands to those of another.

use beadwork_part::toolpath::Island;

/// A rectangle with sides along the axes.
#[derive(Clone, Copy)]
pub(super) struct Rectangle {
    /// Minimum x and y in mm.
    low: [f64; 2],
    /// Maximum x and y in mm.
    high: [f64; 2],
}

impl Rectangle {
    /// The smallest one around the printed islands of a tool; `None` if there are none.
    pub(super) fn around(islands: &[Island], tool: u8) -> Option<Self> {
        let printed = islands.iter().filter(|each| each.material == tool && each.is_printed());
        let bounds = printed.filter_map(|island| island.outline.bounds());
        bounds.map(|[low, high]| Self { low, high }).reduce(|a, b| Self {
            low: [0, 1].map(|axis| a.low[axis].min(b.low[axis])),
            high: [0, 1].map(|axis| a.high[axis].max(b.high[axis])),
        })
    }

    /// Distance to another rectangle in mm; 0 if they overlap.
    pub(super) fn distance_to_mm(self, other: Self) -> f64 {
        let [x, y] = [0, 1].map(|axis| {
            (other.low[axis] - self.high[axis]).max(self.low[axis] - other.high[axis]).max(0.0)
        });
        (x * x + y * y).sqrt()
    }

    /// Distance to a point in mm; 0 if it lies inside.
    pub(super) fn distance_mm(self, point_mm: [f64; 2]) -> f64 {
        self.distance_to_mm(Self { low: point_mm, high: point_mm })
    }
}
