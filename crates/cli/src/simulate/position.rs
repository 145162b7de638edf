//! Positions as people measure them: in mm from the left, front and bottom of a part.

use beadwork_part::slice::Voxels;

/// Width, depth and height of the bounding box of a part, in mm.
pub(super) fn size_mm(part: &Voxels) -> [f64; 3] {
    let frame = &part.frame;
    let (width, height, depth) =
        (f64::from(frame.width), f64::from(frame.height), part.depth as f64);
    [width * frame.cell_mm, height * frame.cell_mm, depth * frame.layer_mm]
}

/// x, y and z of the voxel at a position in the bounding box; `None` outside the box.
///
/// The voxel need not belong to the part.
///
/// A face between two voxels belongs to the one farther right, back or up; the outer faces of the
/// box belong to the voxels inside.
pub(super) fn voxel_at(part: &Voxels, mm: [f64; 3]) -> Option<[u32; 3]> {
    let inside = mm.iter().zip(size_mm(part)).all(|(mm, size_mm)| (0.0..=size_mm).contains(mm));
    let frame = &part.frame;
    let number = |mm: f64, step_mm: f64, count: u32| ((mm / step_mm + 1e-9) as u32).min(count - 1);
    let [x_mm, y_mm, z_mm] = mm;
    inside.then(|| {
        // Rows are counted from the back.
        let y = frame.height - 1 - number(y_mm, frame.cell_mm, frame.height);
        [
            number(x_mm, frame.cell_mm, frame.width),
            y,
            number(z_mm, frame.layer_mm, part.depth as u32),
        ]
    })
}

#[cfg(test)]
mod tests {
    use beadwork_part::Frame;

    use super::*;

    #[test]
    fn faces_belong_to_the_voxel_behind_them() {
        let frame =
            Frame { left_mm: 0.0, back_mm: 0.0, cell_mm: 0.5, layer_mm: 0.25, width: 6, height: 4 };
        let part = Voxels::new(frame, ndarray::Array3::zeros((2, 4, 6)));
        assert_eq!(voxel_at(&part, [0.0; 3]), Some([0, 3, 0]));
        assert_eq!(voxel_at(&part, [0.5, 0.5, 0.25]), Some([1, 2, 1]));
        assert_eq!(voxel_at(&part, [3.0, 2.0, 0.5]), Some([5, 0, 1]));
        for outside in [[-0.1, 0.0, 0.0], [0.0, 2.1, 0.0], [0.0, 0.0, 0.6]] {
            assert_eq!(voxel_at(&part, outside), None);
        }
    }
}
