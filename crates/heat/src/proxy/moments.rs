//! Sums over the blocks of a level.

use pulp::{Arch, NullaryFnOnce};

/// Partial sums, each over every eighth block: as many on every machine, so that results are the
/// same bits.
const SUMS: usize = 8;

/// Number of voxels, sum of θ over them, and sum of θ², from the voxels and the θ of each block.
///
/// Both slices have the same length.
pub(super) fn moments(voxels: &[f32], theta: &[f32]) -> [f64; 3] {
    Arch::new().dispatch(Moments { voxels, theta })
}

struct Moments<'a> {
    voxels: &'a [f32],
    theta: &'a [f32],
}

impl NullaryFnOnce for Moments<'_> {
    type Output = [f64; 3];

    #[expect(clippy::inline_always, reason = "only what is inlined uses wide instructions")]
    #[inline(always)]
    fn call(self) -> [f64; 3] {
        let ((voxels, rest), (theta, theta_rest)) =
            (self.voxels.as_chunks::<SUMS>(), self.theta.as_chunks::<SUMS>());
        let [mut count, mut sum, mut squares] = [[0.0; SUMS]; 3];
        for (voxels, theta) in voxels.iter().zip(theta) {
            for lane in 0..SUMS {
                let (voxels, theta) = (f64::from(voxels[lane]), f64::from(theta[lane]));
                count[lane] += voxels;
                sum[lane] += voxels * theta;
                squares[lane] += voxels * theta * theta;
            }
        }
        for (lane, (&voxels, &theta)) in rest.iter().zip(theta_rest).enumerate() {
            let (voxels, theta) = (f64::from(voxels), f64::from(theta));
            count[lane] += voxels;
            sum[lane] += voxels * theta;
            squares[lane] += voxels * theta * theta;
        }
        [count, sum, squares].map(|sums| sums.iter().sum())
    }
}
