//! Positions in a part at which the temperature is recorded.

use std::fmt::{self, Write};
use std::str::FromStr;

use anyhow::bail;
use beadwork_part::slice::Voxels;
use beadwork_thermal::sampling::Probes;

use super::position::{size_mm, voxel_at};

/// A position in mm from the left, front and bottom of the bounding box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Probe([f64; 3]);

impl FromStr for Probe {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "expected mm from the left, front and bottom, as in 30,5,1.2".to_owned();
        let number = |text: &str| text.trim().parse().ok().filter(|mm: &f64| mm.is_finite());
        let numbers: Option<Vec<f64>> = text.split(',').map(number).collect();
        numbers.and_then(|numbers| numbers.try_into().ok()).map(Self).ok_or_else(wrong)
    }
}

impl fmt::Display for Probe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "{x},{y},{z}")
    }
}

impl Probe {
    /// The voxel of the part at this position.
    pub(super) fn voxel(self, part: &Voxels) -> anyhow::Result<[u32; 3]> {
        let Some([x, y, z]) = voxel_at(part, self.0) else {
            let [width, depth, height] = size_mm(part);
            bail!(
                "probe {self} lies outside of the part, which is {width} x {depth} x {height} mm"
            );
        };
        if part.material(x, y, z as usize).is_none() {
            bail!("probe {self}: the part has no voxel there");
        }
        Ok([x, y, z])
    }
}

/// CSV with a row for each sample: its time, and the temperature at each probe.
///
/// Temperatures are empty until the voxel of the probe is deposited.
pub(super) fn csv(positions: &[Probe], probes: &Probes) -> String {
    let mut text = "seconds".to_owned();
    for Probe([x, y, z]) in positions {
        write!(text, ",x{x}_y{y}_z{z}_c").expect("writing to a string succeeds");
    }
    let mut columns: Vec<_> = (0..positions.len()).map(|probe| probes.celsius(probe)).collect();
    for seconds in probes.seconds() {
        // To the microsecond: further digits are rounding errors of a sum of durations.
        write!(text, "\n{}", (seconds * 1e6).round() / 1e6).expect("writing to a string succeeds");
        for column in &mut columns {
            let celsius =
                column.next().flatten().map_or_else(String::new, |celsius| celsius.to_string());
            write!(text, ",{celsius}").expect("writing to a string succeeds");
        }
    }
    text.push('\n');
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_are_three_numbers() {
        assert_eq!("30,5,1.2".parse(), Ok(Probe([30.0, 5.0, 1.2])));
        assert_eq!(" 1 , -2, 0 ".parse(), Ok(Probe([1.0, -2.0, 0.0])));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,inf", "1;2;3"] {
            assert!(wrong.parse::<Probe>().is_err(), "{wrong}");
        }
        assert_eq!(Probe([30.0, 5.0, 1.2]).to_string(), "30,5,1.2");
    }
}
