//! The example parts: their surfaces are sound, and sliced they have the documented cells.
#![allow(clippy::unwrap_used, reason = "a test may fail")]

use beadwork_base::Control;
use beadwork_mesh::{Example, MaterialRule, Placement, RepairSettings};
use beadwork_part::slice::{Settings, slice};

#[test]
fn examples_are_sound_and_of_the_documented_sizes() {
    for (example, size, materials) in [
        (Example::Rectangular, [120, 40, 12], 1),
        (Example::UShape, [90, 50, 12], 1),
        (Example::Pyramid, [60, 60, 77], 1),
        (Example::LogoPlate, [120, 80, 8], 2),
        (Example::Palette, [120, 90, 8], 12),
    ] {
        assert_eq!(example.name().parse(), Ok(example));
        let mut model = example.model();
        for body in &mut model.bodies {
            assert!(
                body.repair(&RepairSettings::default(), &Control::default()).unwrap().was_sound(),
                "{example}: {}",
                body.name
            );
        }
        model.assign_materials(MaterialRule::Stated);
        Placement::default().apply(&mut model).unwrap();
        let layers = slice(&model, &Settings::default(), &Control::default()).unwrap();
        let frame = layers.frame;
        assert_eq!([frame.width, frame.height, layers.layers.len() as u32], size, "{example}");
        assert_eq!(layers.tools(), materials);
    }
    assert!("cube".parse::<Example>().is_err());
}

#[test]
fn the_u_shape_has_the_documented_cells() {
    let layers =
        slice(&Example::UShape.model(), &Settings::default(), &Control::default()).unwrap();
    assert_eq!(layers.cell_count(), 39_600);
    let region = &layers.layers[0].as_ref().unwrap().region;
    assert!(region.contains(region.cell(25, 19)) && !region.contains(region.cell(25, 20)));
}
