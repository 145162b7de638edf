//! Valid files that cases change.

use std::io::{Cursor, Write as _};

use beadwork_mesh::Format;
use beadwork_part::print::Flavour;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// A valid file.
pub(crate) struct Seed {
    pub(crate) name: String,
    pub(crate) content: Content,
}

pub(crate) enum Content {
    Mesh(Format, Vec<u8>),
    /// The parts of a 3MF archive, changed before they are packed.
    Parts(Vec<(String, Vec<u8>)>),
    Gcode(Vec<u8>),
    /// A program of the bead plan, with the settings of this plan.
    Beads(Flavour, Vec<u8>),
}

impl Seed {
    pub(crate) fn mesh(name: &str, format: Format, bytes: impl Into<Vec<u8>>) -> Self {
        Self { name: name.to_owned(), content: Content::Mesh(format, bytes.into()) }
    }

    pub(crate) fn gcode(name: &str, bytes: impl Into<Vec<u8>>) -> Self {
        Self { name: name.to_owned(), content: Content::Gcode(bytes.into()) }
    }

    /// Two seeds of an archive: one changed as bytes, one changed before it is packed.
    pub(crate) fn package(name: &str, parts: Vec<(String, Vec<u8>)>) -> [Self; 2] {
        let bytes = pack(&parts, CompressionMethod::Deflated);
        let unpacked = Self { name: format!("{name}/parts"), content: Content::Parts(parts) };
        [Self::mesh(name, Format::ThreeMf, bytes), unpacked]
    }

    /// Relative number of cases: large files take longer and get fewer.
    pub(crate) fn weight(&self) -> f64 {
        let bytes = match &self.content {
            // Unpacked it is about eight times as large.
            Content::Mesh(Format::ThreeMf, bytes) => 8 * bytes.len(),
            Content::Mesh(_, bytes) | Content::Gcode(bytes) | Content::Beads(_, bytes) => {
                bytes.len()
            }
            Content::Parts(parts) => parts.iter().map(|(_, bytes)| bytes.len()).sum(),
        };
        (8192.0 / bytes as f64).clamp(0.005, 1.0)
    }
}

pub(crate) fn pack(parts: &[(String, Vec<u8>)], method: CompressionMethod) -> Vec<u8> {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in parts {
        writer
            .start_file(name.as_str(), SimpleFileOptions::default().compression_method(method))
            .unwrap();
        writer.write_all(bytes).unwrap();
    }
    writer.finish().unwrap().into_inner()
}
