//! Overhangs: what lies in the air beyond the layer below.

use beadwork_base::{Control, Interrupted};

use super::areas::LayerAreas;

/// Maximum deviation in mm of the outlines that are compared.
const TOLERANCE_MM: f64 = 0.01;

/// For each layer, the size in mm² of what lies further than a distance in mm from the layer below,
/// to within some hundredths of a mm; 0 for the first layer, which rests on the bed.
///
/// Such parts need supports, unless they are short bridges.
/// Works on `control.threads`.
/// O(n log n) in the corners of the outlines.
pub fn overhangs_mm2(
    layers: &[LayerAreas],
    reach_mm: f64,
    control: &Control<'_>,
) -> Result<Vec<f64>, Interrupted> {
    let size = |number: usize| {
        control.check()?;
        let Some(below) = number.checked_sub(1) else { return Ok(0.0) };
        let [layer, below] =
            [number, below].map(|number| layers[number].union().simplified(TOLERANCE_MM));
        let supported = below.offset_within(reach_mm, TOLERANCE_MM);
        Ok(layer.difference(&supported).size_mm2())
    };
    control.threads.map_numbers(layers.len(), size).into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slice::areas::MaterialArea;
    use crate::{Area, slice::FillRule};

    #[test]
    fn what_is_near_the_layer_below_is_supported() {
        let layer = |side: f64| {
            let ring = vec![[0.0, 0.0], [side, 0.0], [side, 1.0], [0.0, 1.0]];
            let area = Area::from_rings(&[ring], FillRule::NonZero);
            LayerAreas { areas: vec![MaterialArea { material: 0, area }] }
        };
        let layers = [layer(10.0), layer(10.4), layer(15.4), LayerAreas::default(), layer(2.0)];
        let sizes = overhangs_mm2(&layers, 0.5, &Control::default()).unwrap();
        for (got, expected) in sizes.iter().zip([0.0, 0.0, 4.5, 0.0, 2.0]) {
            assert!((got - expected).abs() < 0.05, "{sizes:?}");
        }
    }
}
