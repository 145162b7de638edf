//! What a file of meshes holds: bodies and their materials.

use std::fmt;

use beadwork_base::{Control, Interrupted};
use thiserror::Error;

use super::surface::{Bounds, Mesh, MeshError};
use super::{obj, stl, threemf};

/// Bodies in one frame, and the materials they are made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// The bodies; where two of them overlap, the later one fills the place.
    pub bodies: Vec<Body>,
    /// The materials, as the file names them.
    /// Empty if it names none.
    pub materials: Vec<Material>,
}

/// A closed surface and what fills it.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// As the file calls it; may be empty.
    pub name: String,
    /// Its surface, in mm.
    pub mesh: Mesh,
    /// Number of its material; `None` where the file does not say.
    pub material: Option<usize>,
    /// One number of a material for each triangle, for a body whose surface is painted; else empty.
    pub paint: Vec<u8>,
}

/// A material as a file describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Material {
    /// Its name; may be empty.
    pub name: String,
    /// Red, green and blue, if the file says.
    pub colour: Option<[u8; 3]>,
}

/// The kinds of files that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// STL, binary or text.
    Stl,
    /// 3MF.
    ThreeMf,
    /// Wavefront OBJ.
    Obj,
}

impl Format {
    /// The format that the ending of a file name stands for, in upper or lower case.
    pub fn from_file_name(name: &str) -> Option<Self> {
        let (_, ending) = name.rsplit_once('.')?;
        match ending.to_ascii_lowercase().as_str() {
            "stl" => Some(Self::Stl),
            "3mf" => Some(Self::ThreeMf),
            "obj" => Some(Self::Obj),
            _ => None,
        }
    }
}

/// How much a file may hold.
/// A small file can unpack to any size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReadLimits {
    /// Most bytes that the parts of an archive may unpack to, together.
    pub unpacked_bytes: u64,
    /// Most triangles of all bodies.
    pub triangles: usize,
}

impl Default for ReadLimits {
    /// 1 GiB unpacked, 32 million triangles: what is read takes at most some ten times what was
    /// unpacked.
    fn default() -> Self {
        Self { unpacked_bytes: 1 << 30, triangles: 32_000_000 }
    }
}

/// Paint has one byte for each triangle.
pub(super) const MOST_MATERIALS: usize = 256;

/// Why a file can't be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// It has no bytes.
    #[error("the file is empty")]
    Empty,
    /// It does not begin like a file of its kind.
    #[error("it is {0}")]
    Kind(&'static str),
    /// It ends too early.
    #[error("its header promises {promised} triangles, but it has room for {room} only")]
    Short {
        /// Triangles that the header names.
        promised: u64,
        /// Triangles that its length allows.
        room: u64,
    },
    /// Something in its text is wrong.
    #[error("line {line}: {what}")]
    Text {
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// Something in a part of an archive is wrong.
    #[error("{part}, byte {byte}: {what}")]
    Part {
        /// Name of the part.
        part: String,
        /// Where, counted in the unpacked part.
        byte: u64,
        /// What is wrong.
        what: String,
    },
    /// A part of an archive is missing.
    #[error("the part {0} is missing")]
    NoPart(String),
    /// The archive can't be unpacked.
    #[error("{part} can't be unpacked")]
    Archive {
        /// Name of the part, or "the archive".
        part: String,
        /// Why.
        #[source]
        source: zip::result::ZipError,
    },
    /// It holds more than the [`ReadLimits`] allow.
    #[error("it holds more than {most} {what}")]
    TooLarge {
        /// The limit.
        most: u64,
        /// Of what.
        what: &'static str,
    },
    /// A body is no mesh.
    #[error("body {body}: {source}")]
    Mesh {
        /// Name of the body, or its number.
        body: String,
        /// Why.
        source: MeshError,
    },
    /// It has nothing to print.
    #[error("it holds no triangles")]
    NoTriangles,
    /// The caller ended the call.
    #[error(transparent)]
    Interrupted(#[from] Interrupted),
}

impl ReadError {
    pub(super) fn text(line: usize, what: impl fmt::Display) -> Self {
        Self::Text { line, what: what.to_string() }
    }
}

/// How bodies come to the numbers of their materials, the tools that print them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MaterialRule {
    /// As the files say; each body they say nothing of has one of its own.
    #[default]
    Stated,
    /// Each body has one of its own, whatever the files say.
    PerBody,
    /// All bodies have the same.
    Single,
}

impl Model {
    /// Reads a file's bytes.
    /// Linear in them.
    pub fn read(
        format: Format,
        bytes: &[u8],
        limits: &ReadLimits,
        control: &Control<'_>,
    ) -> Result<Self, ReadError> {
        control.check()?;
        if bytes.is_empty() {
            return Err(ReadError::Empty);
        }
        let model = match format {
            Format::Stl => stl::read(bytes, limits),
            Format::ThreeMf => threemf::read(bytes, limits),
            Format::Obj => obj::read(bytes, limits),
        }?;
        if model.bodies.iter().all(|body| body.mesh.triangles().is_empty()) {
            return Err(ReadError::NoTriangles);
        }
        Ok(model)
    }

    /// Takes over the bodies and the materials of another model in the same frame.
    /// Together they have at most 256 materials.
    pub fn append(&mut self, other: Self) -> Result<(), ReadError> {
        let before = self.materials.len();
        if before + other.materials.len() > MOST_MATERIALS {
            return Err(ReadError::TooLarge { most: MOST_MATERIALS as u64, what: "materials" });
        }
        self.materials.extend(other.materials);
        self.bodies.extend(other.bodies.into_iter().map(|mut body| {
            body.material = body.material.map(|material| material + before);
            body.paint.iter_mut().for_each(|material| *material += before as u8);
            body
        }));
        Ok(())
    }

    /// Gives every body a material, by a rule, and drops what is then not used.
    ///
    /// Materials of the same name and colour become one.
    /// Those that are left keep their order; bodies without one get theirs after them.
    ///
    /// # Panics
    /// If a body or its paint names a material that is not there.
    pub fn assign_materials(&mut self, rule: MaterialRule) {
        let stated = std::mem::take(&mut self.materials);
        let own = |number: usize, body: &Body| {
            let name = if body.name.is_empty() {
                format!("body {}", number + 1)
            } else {
                body.name.clone()
            };
            Material { name, colour: None }
        };
        match rule {
            MaterialRule::Single => {
                self.materials = vec![
                    stated
                        .first()
                        .cloned()
                        .unwrap_or(Material { name: "all".into(), colour: None }),
                ];
                for body in &mut self.bodies {
                    (body.material, body.paint) = (Some(0), Vec::new());
                }
            }
            MaterialRule::PerBody => {
                for (number, body) in self.bodies.iter_mut().enumerate() {
                    self.materials.push(own(number, body));
                    (body.material, body.paint) = (Some(number), Vec::new());
                }
            }
            MaterialRule::Stated => {
                let painted = self
                    .bodies
                    .iter()
                    .flat_map(|body| body.paint.iter().map(|&paint| usize::from(paint)));
                let filled = self
                    .bodies
                    .iter()
                    .filter(|body| body.paint.is_empty())
                    .filter_map(|body| body.material);
                let mut used = vec![false; stated.len()];
                painted.chain(filled).for_each(|material| used[material] = true);
                let mut number_of = vec![0; stated.len()];
                for (old, material) in stated.iter().enumerate().filter(|&(old, _)| used[old]) {
                    let found = self.materials.iter().position(|other| other == material);
                    number_of[old] = found.unwrap_or(self.materials.len());
                    if found.is_none() {
                        self.materials.push(material.clone());
                    }
                }
                for (number, body) in self.bodies.iter_mut().enumerate() {
                    body.paint
                        .iter_mut()
                        .for_each(|paint| *paint = number_of[usize::from(*paint)] as u8);
                    body.material = match body.material {
                        // The paint says it all.
                        _ if !body.paint.is_empty() => None,
                        Some(old) => Some(number_of[old]),
                        None => {
                            self.materials.push(own(number, body));
                            Some(self.materials.len() - 1)
                        }
                    };
                }
            }
        }
    }

    /// The smallest box around all bodies.
    pub fn bounds(&self) -> Bounds {
        let mut bounds = Bounds::EMPTY;
        self.bodies.iter().for_each(|body| bounds.merge(&body.mesh.bounds()));
        bounds
    }

    /// Triangles of all bodies.
    pub fn triangle_count(&self) -> usize {
        self.bodies.iter().map(|body| body.mesh.triangles().len()).sum()
    }
}
