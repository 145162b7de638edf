//! The bits in which links are stored.

/// Bits of `Path::links` and `Links::bits`: the neighbours that a cell is linked to, and whether a
/// unit cell begins there.
///
/// Every link is stored twice in a path, once at each of its two cells: the link between a cell and
/// its right neighbour is `RIGHT` at the left cell and `LEFT` at the right one.
pub(crate) mod link {
    pub(crate) const RIGHT: u8 = 1;
    pub(crate) const BELOW: u8 = 2;
    pub(crate) const LEFT: u8 = 4;
    pub(crate) const ABOVE: u8 = 8;
    /// The cell is the top-left cell of a unit cell, that is, it lies neither in the last column
    /// nor in the last row of the grid.
    pub(crate) const CORNER: u8 = 16;
}

/// Bits of a unit cell: which of its four sides are links of the path.
///
/// The top-left cell knows the top and the left side, the bottom-right cell the other two, so two
/// bytes give all four sides.
/// The values are chosen such that the bits of [`link`] of these two cells can be used unchanged:
///
/// ```text
///  corner --- TOP ----  b          TOP    is RIGHT of the corner
///    |                  |          LEFT   is BELOW of the corner
///   LEFT              RIGHT        BOTTOM is LEFT  of d
///    |                  |          RIGHT  is ABOVE of d
///    c  --- BOTTOM ---  d
/// ```
pub(crate) mod square {
    use super::link;

    pub(crate) const TOP: u8 = link::RIGHT;
    pub(crate) const LEFT: u8 = link::BELOW;
    pub(crate) const BOTTOM: u8 = link::LEFT;
    pub(crate) const RIGHT: u8 = link::ABOVE;
    /// Exactly the top and the bottom side are linked.
    pub(crate) const HORIZONTAL: u8 = link::CORNER | TOP | BOTTOM;
    /// Exactly the left and the right side are linked.
    pub(crate) const VERTICAL: u8 = link::CORNER | LEFT | RIGHT;
}
