//! 3MF files: all objects that are to be printed, with transforms, units and materials.
//!
//! A 3MF file is a ZIP archive of XML documents.
//! The root document lists the **build items**: objects to print.
//! An **object** is a mesh, or is composed of **components**, other objects with a transform; each
//! mesh that is reached from the build items becomes a body, once for every path to it.
//!
//! Supported are the core specification 1.3, the materials extension except textures, and the
//! production extension.
//! Files that require another extension are refused, and so are objects whose shape is defined by
//! one; other data of extensions is reported.
//! A document that is referred to has its own unit, because the `unit` of a model applies to all
//! measurements in that model (core specification, section 3.4).
//!
//! Slicers store **projects** in the same archives: filaments, parts that are subtracted or that
//! modify others, painted facets, plates, and purge volumes.
//! Projects of PrusaSlicer, Bambu Studio and Orca Slicer are read; their print settings are not.

mod archive;
mod bambu;
mod builder;
mod document;
mod mesh;
mod namespace;
mod notes;
mod painting;
mod parts;
mod project;
mod properties;
mod prusa;
mod subdivision;
mod xml;

use std::borrow::Cow;
use std::io::BufRead;

use beadwork_base::Control;

use self::archive::Archive;
use self::builder::Builder;
use self::project::Project;
use self::xml::{Element, each_element};
use super::error::{ReadError, ReadLimits};
use crate::model::Model;

/// The entry that names the root document.
const RELATIONSHIPS: &str = "_rels/.rels";
/// The root document if that entry is missing or does not name one.
const DEFAULT_ROOT: &str = "3D/3dmodel.model";

pub(super) fn read(
    bytes: &[u8],
    limits: &ReadLimits,
    control: &Control<'_>,
) -> Result<Model, ReadError> {
    let mut archive = Archive::open(bytes, limits, control)?;
    let root = if archive.contains(RELATIONSHIPS) {
        archive.read(RELATIONSHIPS, |source| root_entry(RELATIONSHIPS, source))?
    } else {
        None
    };
    let mut project = Project::default();
    prusa::read(&mut archive, &mut project)?;
    bambu::read(&mut archive, &mut project)?;
    let root = root.unwrap_or_else(|| DEFAULT_ROOT.to_owned());
    Builder::new(archive, project, limits, control).build(&root)
}

/// The target of the relationship that names the root document.
fn root_entry(entry: &str, source: &mut dyn BufRead) -> Result<Option<String>, ReadError> {
    let mut found = None;
    each_element(entry, source, |element| {
        if let Element::Start(tag) = element
            && tag.name == "Relationship"
            && tag.attribute("Type")?.is_some_and(|kind| kind.ends_with("/3dmodel"))
        {
            found = found.take().or(tag.attribute("Target")?.map(Cow::into_owned));
        }
        Ok(())
    })?;
    Ok(found.map(|target| target.trim_start_matches('/').to_owned()))
}

#[cfg(test)]
mod tests;
