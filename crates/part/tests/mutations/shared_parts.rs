//! The real parts of `../shared/parts`.

use std::io::{Cursor, Read as _};
use std::path::Path;

use beadwork_mesh::Format;
use zip::ZipArchive;

use crate::seed::Seed;

/// The files of `../shared/parts` in a format, if the folder is there.
pub(crate) fn shared_seeds(format: Format) -> Vec<Seed> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/parts");
    let mut seeds = Vec::new();
    for folder in [root.clone(), root.join("broken")] {
        let Ok(entries) = folder.read_dir() else {
            eprintln!("skipped: folder {} does not exist", folder.display());
            continue;
        };
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        // Sorted, so that cases do not depend on the order in which the folder lists them.
        names.sort_unstable();
        for name in names.into_iter().filter(|name| Format::from_file_name(name) == Some(format)) {
            let bytes = std::fs::read(folder.join(&name)).unwrap();
            match unpack(&bytes).filter(|_| format == Format::ThreeMf) {
                Some(parts) => seeds.extend(Seed::package(&name, parts)),
                None => seeds.push(Seed::mesh(&name, format, bytes)),
            }
        }
    }
    seeds
}

fn unpack(bytes: &[u8]) -> Option<Vec<(String, Vec<u8>)>> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).ok()?;
    let mut parts = Vec::new();
    for number in 0..archive.len() {
        let mut part = archive.by_index(number).ok()?;
        let name = part.name().ok()?.into_owned();
        let mut bytes = Vec::new();
        part.read_to_end(&mut bytes).ok()?;
        if [".model", ".rels"].iter().any(|ending| name.ends_with(ending)) {
            parts.push((name, bytes));
        }
    }
    (!parts.is_empty()).then_some(parts)
}
