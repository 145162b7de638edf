//! Damaged files: random changes of valid files must lead to a result or an error, not to a panic,
//! a hang or excessive memory.
//!
//! Every case takes a seed (a small file made here, or one of `../shared/parts` if that folder
//! exists), changes it in one to eight positions and runs all steps on it: meshes are read,
//! repaired, given materials, placed on the bed and sliced; G-code is read, emitted and read again,
//! traced, timed and checked.
//! A changed program of beads must be refused by the check, or print the same.
//! 3MF archives are changed both as bytes and before they are packed, because checksums hide most
//! of the reader from changes of the bytes.
//!
//! A case depends only on its seed and its number.
//! Manual runs:
//!
//! ```text
//! BEADWORK_MUTATIONS=300000 cargo test --release -p beadwork-part --test mutations -- --nocapture
//! BEADWORK_MUTATION_CASE='cube.obj 1234' \
//!     cargo test -p beadwork-part --test mutations -- --nocapture
//! ```
//!
//! The first runs 300,000 cases instead of a few thousand; the second repeats one case.
//! No files are written.
//!
//! # Hangs and memory
//! A watchdog thread aborts the process with the name of the case if a case takes more than 20 s:
//! on any machine, input of a few KB that takes this long is a hang.
//! On Linux the peak memory of the process must stay below 1 GiB, with the default limits of the
//! readers.
#![allow(clippy::unwrap_used, reason = "a test may fail")]
#![allow(clippy::print_stderr, reason = "skipped folders and failing cases are reported")]

mod bead_plan;
mod cell_plan;
mod change;
mod meshes;
mod packages;
mod programs;
mod runner;
mod seed;
mod shared_parts;
mod steps;

use bead_plan::BeadPlan;
use beadwork_base::Control;
use beadwork_gcode::Program;
use beadwork_mesh::{Format, Model, ReadLimits, RepairSettings};
use meshes::{obj_seeds, stl_seeds};
use packages::threemf_seeds;
use programs::{bead_seeds, gcode_seeds};
use runner::run;
use seed::{Content, pack};
use shared_parts::shared_seeds;
use zip::CompressionMethod;

#[test]
fn damaged_stl() {
    let mut seeds = stl_seeds();
    seeds.extend(shared_seeds(Format::Stl));
    run("STL", &seeds);
}

#[test]
fn damaged_obj() {
    run("OBJ", &obj_seeds());
}

#[test]
fn damaged_3mf() {
    let mut seeds = threemf_seeds();
    seeds.extend(shared_seeds(Format::ThreeMf));
    run("3MF", &seeds);
}

#[test]
fn damaged_gcode() {
    run("G-code", &gcode_seeds());
}

#[test]
fn damaged_beads() {
    run("beads", &bead_seeds());
}

/// All seeds pass all steps: changes of an invalid file would test only its first error.
#[test]
fn seeds_are_valid() {
    let seeds = [stl_seeds(), obj_seeds(), threemf_seeds(), gcode_seeds(), bead_seeds()];
    for seed in seeds.iter().flatten() {
        let read = |format, bytes: &[u8]| {
            let model =
                Model::read(format, bytes, &ReadLimits::default(), &Control::default()).unwrap();
            model.bodies.into_iter().for_each(|mut body| {
                _ = body.repair(&RepairSettings::default(), &Control::default()).unwrap();
            });
        };
        match &seed.content {
            Content::Mesh(format, bytes) => read(*format, bytes),
            Content::Parts(parts) => {
                read(Format::ThreeMf, &pack(parts, CompressionMethod::Deflated));
            }
            Content::Gcode(bytes) => {
                let program = Program::from_bytes(bytes, &Control::default()).unwrap();
                program.trace().for_each(|event| _ = event.unwrap());
            }
            Content::Beads(flavour, bytes) => {
                let program = Program::from_bytes(bytes, &Control::default()).unwrap();
                _ = BeadPlan::new().check(&program, *flavour).unwrap();
            }
        }
    }
}
