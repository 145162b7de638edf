//! Planes through a part on which temperatures are drawn.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::bail;
use beadwork_console::output;
use beadwork_console::temperature_map::{Map, Row, Scale, png, svg};
use beadwork_thermal::Simulation;
use beadwork_thermal::section::Plane;

use super::position::voxel_at;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Axis {
    X,
    Y,
    Z,
}

/// A plane at a distance in mm from the left, front or bottom of the bounding box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Section {
    axis: Axis,
    mm: f64,
}

impl FromStr for Section {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let axis = |name: &str| match name.trim() {
            "x" | "X" => Some(Axis::X),
            "y" | "Y" => Some(Axis::Y),
            "z" | "Z" => Some(Axis::Z),
            _ => None,
        };
        let found = text
            .split_once('=')
            .and_then(|(name, mm)| Some((axis(name)?, mm.trim().parse().ok()?)));
        let found = found.filter(|(_, mm): &(Axis, f64)| mm.is_finite());
        found
            .map(|(axis, mm)| Self { axis, mm })
            .ok_or_else(|| "expected an axis and mm, as in x=30".to_owned())
    }
}

impl fmt::Display for Section {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axis = match self.axis {
            Axis::X => 'x',
            Axis::Y => 'y',
            Axis::Z => 'z',
        };
        write!(f, "{axis}={}", self.mm)
    }
}

impl Section {
    /// Refuses a plane outside of a part of this size.
    pub(super) fn check(self, size_mm: [f64; 3]) -> anyhow::Result<()> {
        let size_mm = size_mm[self.axis as usize];
        if (0.0..=size_mm).contains(&self.mm) {
            return Ok(());
        }
        bail!("section {self} lies outside of the part, which ends at {size_mm} mm")
    }

    /// The temperatures on the plane, as seen from the right, from the front, or from above.
    pub(super) fn map(self, simulation: &Simulation, title: String) -> Map {
        let mut position_mm = [0.0; 3];
        position_mm[self.axis as usize] = self.mm;
        let [x, y, z] = voxel_at(simulation.part(), position_mm).expect("the plane was checked");
        let plane = match self.axis {
            Axis::X => Plane::X(x),
            Axis::Y => Plane::Y(y),
            Axis::Z => Plane::Layer(z),
        };
        Map::of(&simulation.section(plane), &simulation.part().frame, title)
    }
}

/// Files for the pictures of sections.
pub(super) enum Target {
    File(PathBuf),
    Folder(PathBuf),
}

impl Target {
    /// The target that `--section-out` names, for a number of sections.
    ///
    /// Ends the process with a usage error if the target does not fit.
    pub(super) fn new(path: &Path, sections: usize) -> Self {
        if path.is_dir() {
            return Self::Folder(path.to_owned());
        }
        match path.extension() {
            None => Self::Folder(path.to_owned()),
            Some(_) if !is_picture(path) => output::usage_error(&format!(
                "--section-out '{}': expected a .png file, an .svg file or a folder",
                path.display()
            )),
            Some(_) if sections > 1 => {
                output::usage_error("--section-out must be a folder for several sections")
            }
            Some(_) => Self::File(path.to_owned()),
        }
    }

    pub(super) fn file(&self) -> Option<&Path> {
        match self {
            Self::File(path) => Some(path),
            Self::Folder(_) => None,
        }
    }

    /// Writes the picture of each section, all with the same colour scale.
    pub(super) fn write(&self, sections: &[(Section, Map)]) -> anyhow::Result<()> {
        let scale = Scale::of(sections.iter().flat_map(|(_, map)| map.celsius()));
        for (section, map) in sections {
            let row = Row { heading: None, maps: std::slice::from_ref(map) };
            match self {
                Self::File(path) if has_extension(path, "png") => {
                    output::file(path, png(map, scale))?;
                }
                Self::File(path) => {
                    output::file(path, svg(&[row], scale))?;
                }
                Self::Folder(folder) => {
                    std::fs::create_dir_all(folder)?;
                    let name = format!("section-{}", section.to_string().replace('=', ""));
                    output::file(&folder.join(format!("{name}.svg")), svg(&[row], scale))?;
                    output::file(&folder.join(format!("{name}.png")), png(map, scale))?;
                }
            }
        }
        Ok(())
    }
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

fn is_picture(path: &Path) -> bool {
    has_extension(path, "png") || has_extension(path, "svg")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_named_by_an_axis_and_mm() {
        assert_eq!("x=30".parse(), Ok(Section { axis: Axis::X, mm: 30.0 }));
        assert_eq!("Z = 0.25".parse(), Ok(Section { axis: Axis::Z, mm: 0.25 }));
        for wrong in ["", "x", "w=3", "x=", "x=nan", "3", "x=1=2"] {
            assert!(wrong.parse::<Section>().is_err(), "{wrong}");
        }
        assert_eq!(Section { axis: Axis::Y, mm: 2.5 }.to_string(), "y=2.5");
    }

    #[test]
    fn planes_lie_within_the_part() {
        let section = |text: &str| text.parse::<Section>().unwrap();
        assert!(
            section("x=0").check([60.0, 20.0, 3.0]).is_ok()
                && section("z=3").check([60.0, 20.0, 3.0]).is_ok()
        );
        assert!(section("y=20.1").check([60.0, 20.0, 3.0]).is_err());
        assert!(section("z=-1").check([60.0, 20.0, 3.0]).is_err());
    }
}
