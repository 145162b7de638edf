//! Chooses the reader for a file.

use beadwork_base::Control;

use super::error::{ReadError, ReadLimits};
use super::{obj, signature, stl, threemf};
use crate::model::Model;

/// A file format that can be read.
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
    /// The format that the extension of a file name stands for, in upper or lower case.
    pub fn from_file_name(name: &str) -> Option<Self> {
        let (_, extension) = name.rsplit_once('.')?;
        match extension.to_ascii_lowercase().as_str() {
            "stl" => Some(Self::Stl),
            "3mf" => Some(Self::ThreeMf),
            "obj" => Some(Self::Obj),
            _ => None,
        }
    }
}

impl Format {
    fn name(self) -> &'static str {
        match self {
            Self::Stl => "STL",
            Self::ThreeMf => "3MF",
            Self::Obj => "OBJ",
        }
    }

    /// What [`signature::recognise`] may find in files of this format.
    fn own_signatures(self) -> &'static [&'static str] {
        match self {
            Self::Stl => &["an STL mesh"],
            Self::ThreeMf => &["a ZIP archive, such as 3MF"],
            Self::Obj => &["an OBJ mesh"],
        }
    }
}

impl Model {
    /// Reads a model from the bytes of a file.
    ///
    /// STL and OBJ files do not state a unit; their numbers are taken as mm.
    /// The meshes are as in the file: [`Body::repair`](crate::Body::repair) closes them and turns
    /// them outwards.
    ///
    /// Linear in the bytes of the file, or for archives in the unpacked bytes and the triangles of
    /// all instances of objects.
    /// Progress counts bytes of the file.
    pub fn read(
        format: Format,
        bytes: &[u8],
        limits: &ReadLimits,
        control: &Control<'_>,
    ) -> Result<Self, ReadError> {
        if bytes.is_empty() {
            return Err(ReadError::Empty);
        }
        if let Some(found) = signature::recognise(bytes)
            && !format.own_signatures().contains(&found)
        {
            return Err(ReadError::OtherFormat { expected: format.name(), found });
        }
        let model = match format {
            Format::Stl => stl::read(bytes, limits, control),
            Format::ThreeMf => threemf::read(bytes, limits, control),
            Format::Obj => obj::read(bytes, limits, control),
        }?;
        if model.triangle_count() == 0 {
            return Err(ReadError::NoTriangles);
        }
        control.report(bytes.len(), bytes.len());
        Ok(model)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use beadwork_base::{CancelToken, Interrupted, Progress};

    use super::*;

    #[test]
    fn formats_are_known_by_their_extension() {
        assert_eq!(Format::from_file_name("a.b.STL"), Some(Format::Stl));
        assert_eq!(Format::from_file_name("part.3mf"), Some(Format::ThreeMf));
        assert_eq!(Format::from_file_name("stl"), None);
    }

    #[test]
    fn a_wrong_extension_is_named() {
        let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".repeat(9);
        let error = |format, bytes: &[u8]| {
            let limits = ReadLimits::default();
            Model::read(format, bytes, &limits, &Control::default()).unwrap_err().to_string()
        };
        assert_eq!(
            error(Format::Stl, obj.as_bytes()),
            "not a valid STL file: content is an OBJ mesh"
        );
        assert_eq!(
            error(Format::Obj, b"solid x\nfacet normal 0 0 1\n"),
            "not a valid OBJ file: content is an STL mesh"
        );
        assert_eq!(
            error(Format::ThreeMf, b"solid x\nfacet normal 0 0 1\n"),
            "not a valid 3MF file: content is an STL mesh"
        );
    }

    #[test]
    fn reading_can_be_cancelled_and_reports_progress() {
        let facet = "facet\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 1\nendfacet\n";
        let stl = format!("solid s\n{}endsolid\n", facet.repeat(3_000));
        let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned() + &"f 1 2 3\n".repeat(15_000);
        for (format, text) in [(Format::Stl, stl), (Format::Obj, obj)] {
            let seen = Mutex::new(Vec::new());
            let cancel = CancelToken::new();
            let progress = |progress: Progress| {
                seen.lock().unwrap().push(progress);
                if progress.done > text.len() / 2 {
                    cancel.cancel();
                }
            };
            let control =
                Control { cancel: Some(&cancel), progress: Some(&progress), ..Control::default() };
            let limits = ReadLimits::default();
            let error = Model::read(format, text.as_bytes(), &limits, &control);
            assert!(matches!(error, Err(ReadError::Interrupted(Interrupted::Cancelled))));
            let seen = seen.into_inner().unwrap();
            assert!(seen.len() > 2 && seen.is_sorted_by_key(|progress| progress.done));
            assert!(seen.iter().all(|progress| progress.total == text.len()));
        }
    }
}
