//! Slots as the steppers take them.

/// A stretch of time in which at most one voxel is held.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// x, y and z, rim counted, of a voxel that keeps the temperature of its birth.
    pub(crate) held: Option<[usize; 3]>,
    /// Whether that voxel is born at the start.
    pub(crate) born: bool,
    /// More than 0.
    pub(crate) seconds: f64,
}

impl Piece {
    /// The same in as few equal parts as are no longer than a limit.
    pub(crate) fn parts(self, limit_s: f64) -> impl Iterator<Item = Self> {
        // A whole number of limits must not become one more by rounding.
        let parts = (self.seconds / limit_s - 1e-6).ceil().max(1.0);
        (0..parts as usize).map(move |part| Self {
            born: self.born && part == 0,
            seconds: self.seconds / parts,
            ..self
        })
    }
}

/// How long some pieces take, s.
pub(crate) fn seconds<'a>(pieces: impl IntoIterator<Item = &'a Piece>) -> f64 {
    pieces.into_iter().map(|piece| piece.seconds).sum()
}
