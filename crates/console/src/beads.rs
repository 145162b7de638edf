//! Parts as beads: insets, infill and skeletons from a cut part, and planned beads as checked
//! G-code.

use anyhow::{Context, bail};
use beadwork_base::Threads;
use beadwork_gcode::{Program, Totals};
use beadwork_mesh::{Bounds, Model};
use beadwork_part::print::{self, BeadLimits, BeadReport, Print, check_beads};
use beadwork_part::slice::{LayerAreas, overhangs_mm2};
use beadwork_part::toolpath::{self, Island, islands};
use beadwork_part::{Area, BeadLayer, Frame};

use crate::control;
use crate::part::CutPart;
use crate::printer::Profile;
use crate::remarks;
use crate::text::count;

/// Share of its width by which a skeleton may leave the outline: all of the half beyond its
/// centreline, because a wall's skeleton ends where the wall ends.
const SKELETON_OUTSIDE: f64 = 0.5;

/// A part laid out as insets, skeletons and infill.
pub struct BeadPart {
    /// Name of its first file.
    pub name: String,
    /// The mesh, repaired and placed on the bed.
    pub model: Model,
    /// Position of the part on the bed, and height of the layers.
    pub frame: Frame,
    /// Area of each material in every layer, from the first printed layer on.
    pub areas: Vec<LayerAreas>,
    /// The islands of these layers.
    pub islands: Vec<Vec<Island>>,
    /// How they were laid out.
    pub toolpath: toolpath::Settings,
    /// Repairs, data that is not used, and what is too small to be printed, each in one line.
    pub remarks: Vec<String>,
    /// Bounding box of the placed mesh, in mm.
    pub bounds: Bounds,
}

impl CutPart {
    /// Lays out the part in beads.
    ///
    /// Reports what cannot be printed, each on a line of stderr.
    pub fn into_beads(
        self,
        toolpath: &toolpath::Settings,
        threads: Threads<'_>,
    ) -> anyhow::Result<BeadPart> {
        let Self { name, model, cut, settings, mut remarks } = self;
        let mut areas =
            control::with_bar("areas", threads, |control| cut.areas(&settings, control))??;
        areas.iter_mut().for_each(LayerAreas::fill_slits);
        let mut layers =
            control::with_bar("lay out", threads, |control| islands(&areas, toolpath, control))??;
        let mut found = Vec::new();
        if model.bodies.len() > 1 {
            // Cells show which bodies others cover.
            let cells = control::quiet(threads, |control| cut.layers(&settings, control))??;
            let coverage =
                control::quiet(threads, |control| cut.coverage(&cells, &settings, control))??;
            found.extend(remarks::of_bodies(&model, &coverage));
        }
        let is_printed = |islands: &Vec<Island>| islands.iter().any(Island::is_printed);
        let first = layers.iter().position(is_printed);
        let last = layers.iter().rposition(is_printed);
        let (Some(first), Some(last)) = (first, last) else {
            if toolpath.perimeters == 0 && toolpath.density <= 0.0 {
                bail!("nothing to print: no perimeters, no infill and no solid layers");
            }
            bail!("nothing to print: the part is thinner than a bead of {} mm", toolpath.bead_mm);
        };
        if let Some(gap) = (first..last).find(|&layer| !is_printed(&layers[layer])) {
            bail!(
                "layer {} has no beads: the layers above it would be printed in the air",
                gap + 1
            );
        }
        if first > 0 {
            found.push(format!(
                "part lowered by {} without beads: its bottom is thinner than a bead",
                count(first as u64, "layer")
            ));
        }
        let above = areas[last + 1..].iter().filter(|layer| !layer.areas.is_empty()).count();
        if above > 0 {
            found.push(format!(
                "{} at the top without beads: the part is thinner than a bead there",
                count(above as u64, "layer")
            ));
        }
        layers.truncate(last + 1);
        areas.truncate(last + 1);
        layers.drain(..first);
        areas.drain(..first);
        let lost: Vec<&Island> =
            layers.iter().flatten().filter(|each| !each.is_printed()).collect();
        if !lost.is_empty() {
            found.push(format!(
                "{} too small to print: {:.2} mm² in all layers",
                count(lost.len() as u64, "island"),
                lost.iter().map(|island| island.outline.size_mm2()).sum::<f64>()
            ));
        }
        let overhangs =
            control::quiet(threads, |control| overhangs_mm2(&areas, toolpath.bead_mm, control))??;
        let overhanging = overhangs.iter().filter(|&&size| size > 1.0).count() as u64;
        if overhanging > 0 {
            found.push(format!(
                "{} beyond a bead's width, up to {:.0} mm²: supports are not generated",
                count(overhanging, "layer")
                    + if overhanging == 1 { " overhangs" } else { " overhang" },
                overhangs.iter().copied().fold(0.0, f64::max)
            ));
        }
        remarks::report(&found);
        remarks.extend(found);
        let frame = cut.frame(&settings)?;
        let bounds = model.bounds();
        let toolpath = *toolpath;
        Ok(BeadPart { name, model, frame, areas, islands: layers, toolpath, remarks, bounds })
    }
}

/// A plan of beads as checked G-code.
pub struct PrintedBeads {
    /// The text of the program.
    pub text: String,
    /// Time, travel and filament.
    pub totals: Totals,
    /// Result of the check of the text.
    pub checked: BeadReport,
    /// The settings, with the position of the prime tower.
    pub settings: print::Settings,
}

/// Writes planned layers as G-code, and checks the text: a faulty program must not reach a printer.
pub fn print_beads(
    part: &BeadPart,
    layers: &[BeadLayer],
    profile: &Profile,
    settings: print::Settings,
    threads: Threads<'_>,
) -> anyhow::Result<PrintedBeads> {
    let frame = &part.frame;
    let (Print { program, totals, .. }, settings) =
        profile.print_beads(&part.name, layers, frame, settings)?;
    let text = program.emit();
    drop(program);
    let program = control::quiet(threads, |control| Program::parse(&text, control))??;
    let outlines: Vec<Vec<(u8, Area)>> = part
        .areas
        .iter()
        .map(|layer| layer.areas.iter().map(|each| (each.material, each.area.clone())).collect())
        .collect();
    let limits = BeadLimits { outside_skeleton: SKELETON_OUTSIDE, ..BeadLimits::default() };
    let checked = control::quiet(Threads::One, |control| {
        check_beads(&program, layers, &outlines, frame, &settings, &limits, control)
    })?;
    let checked = checked.context("G-code does not print the plan; this is a bug of beadwork")?;
    Ok(PrintedBeads { text, totals, checked, settings })
}
