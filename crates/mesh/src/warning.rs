//! What a reader reports besides the model.

use thiserror::Error;

/// Something that a file states and the model does not contain, or not exactly.
/// The display form is a sentence for users, without the name of the file.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ReadWarning {
    /// A binary STL file is longer than its header declares; all triangles are read.
    #[error("header declares {declared} triangles, file holds {held}: all of them are read")]
    TriangleCount {
        /// Number of triangles in the header.
        declared: u64,
        /// Number of triangles in the file.
        held: u64,
    },
    /// Triangles have corners of several colours; each has the colour of most of its corners.
    #[error("{triangles} triangles have corners of several colours: each has one of them")]
    MixedColours {
        /// Number of these triangles.
        triangles: usize,
    },
    /// Data that has no effect on the model.
    #[error("{what}: not used")]
    Ignored {
        /// A noun phrase in the plural, such as "texture coordinates".
        what: String,
    },
    /// Data that the model contains, but not exactly.
    #[error("{what}: {how}")]
    Approximated {
        /// A noun phrase in the plural, such as "colour gradients".
        what: String,
        /// What the model contains instead, as a sentence without a full stop.
        how: String,
    },
}
