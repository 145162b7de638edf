//! Places of a part whose temperature is followed.

use std::fmt::{self, Write};
use std::str::FromStr;

use anyhow::bail;
use beadwork_part::slice::Voxels;
use beadwork_thermal::sampling::Probes;

use super::place::{size_mm, voxel_at};

/// A place in mm from the left, the front and the bottom of the part's box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Probe([f64; 3]);

impl FromStr for Probe {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || "give mm from the left, the front and the bottom, as 30,5,1.2".to_owned();
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
    /// The voxel of the part at this place.
    pub(super) fn voxel(self, part: &Voxels) -> anyhow::Result<[u32; 3]> {
        let Some([x, y, z]) = voxel_at(part, self.0) else {
            let [width, depth, height] = size_mm(part);
            bail!(
                "the probe {self} lies outside of the part, which is {width} x {depth} x {height} mm"
            );
        };
        if part.material(x, y, z as usize).is_none() {
            bail!("the part has no voxel at the probe {self}");
        }
        Ok([x, y, z])
    }
}

/// A row for each reading: its time, and the temperature at each probe; empty before there is a
/// voxel.
pub(super) fn csv(places: &[Probe], probes: &Probes) -> String {
    let mut text = "seconds".to_owned();
    for Probe([x, y, z]) in places {
        write!(text, ",x{x}_y{y}_z{z}_c").expect("a string takes all text");
    }
    let mut columns: Vec<_> = (0..places.len()).map(|probe| probes.celsius(probe)).collect();
    for seconds in probes.seconds() {
        // To the microsecond: what rounding leaves of a sum of slots would read as if it meant
        // something.
        write!(text, "\n{}", (seconds * 1e6).round() / 1e6).expect("a string takes all text");
        for column in &mut columns {
            let celsius =
                column.next().flatten().map_or_else(String::new, |celsius| celsius.to_string());
            write!(text, ",{celsius}").expect("a string takes all text");
        }
    }
    text.push('\n');
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_three_numbers() {
        assert_eq!("30,5,1.2".parse(), Ok(Probe([30.0, 5.0, 1.2])));
        assert_eq!(" 1 , -2, 0 ".parse(), Ok(Probe([1.0, -2.0, 0.0])));
        for wrong in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,inf", "1;2;3"] {
            assert!(wrong.parse::<Probe>().is_err(), "{wrong}");
        }
        assert_eq!(Probe([30.0, 5.0, 1.2]).to_string(), "30,5,1.2");
    }
}
