//! Windows around births that are far apart.
//!
//! Where the nozzle jumps, the births of a step and those shortly before it lie in several
//! clusters.
//! One window around all of them could be as large as the part, so each cluster gets a window of
//! its own, unless a common one is cheaper.
//! The births of an order without jumps are one cluster.

use crate::patch::Patch;

use super::window::Window;

/// Cost of each further window, in voxels: what its sweeps cost beside their updates.
const WINDOW_VOXELS: usize = 300;

/// A birth, as seen from a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Birth {
    pub(super) position: [usize; 3],
    pub(super) time: BirthTime,
}

/// When a birth happens, as seen from a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum BirthTime {
    /// Within the step.
    Coming,
    /// Shortly before the step.
    Recent,
    /// So long before the step that it matters only where the nozzle has left.
    Old,
}

/// The smallest box around some voxels, without margins.
#[derive(Clone, Copy, Debug)]
struct Box3 {
    low: [usize; 3],
    high: [usize; 3],
}

impl Box3 {
    fn of(voxel: [usize; 3]) -> Self {
        Self { low: voxel, high: voxel }
    }

    /// Whether a voxel is at most `reach` from the box, along x and y, and along z.
    fn reaches(&self, voxel: [usize; 3], reach: [usize; 2]) -> bool {
        (0..3).all(|axis| {
            let reach = reach[axis / 2];
            voxel[axis] + reach >= self.low[axis] && voxel[axis] <= self.high[axis] + reach
        })
    }

    fn merge(&mut self, other: &Self) {
        for axis in 0..3 {
            self.low[axis] = self.low[axis].min(other.low[axis]);
            self.high[axis] = self.high[axis].max(other.high[axis]);
        }
    }

    fn window(&self, margins: [usize; 2], patch: &Patch, top: usize) -> Window {
        Window::around(self.low, self.high, margins, patch, top)
    }
}

/// Births that are near each other.
struct Cluster {
    /// Around all of them.
    all: Box3,
    /// Around those that are not old.
    young: Option<Box3>,
    /// Whether some of them are coming.
    coming: bool,
}

impl Cluster {
    fn add(&mut self, birth: Birth) {
        let voxel = Box3::of(birth.position);
        self.all.merge(&voxel);
        if birth.time != BirthTime::Old {
            self.young.get_or_insert(voxel).merge(&voxel);
        }
        self.coming |= birth.time == BirthTime::Coming;
    }

    /// The box in which shorter steps are needed.
    fn needed(&self) -> Option<Box3> {
        if self.coming { self.young } else { Some(self.all) }
    }
}

/// Windows around births with margins in x and y, and in z; none if there are no births.
///
/// Old births count only in clusters without coming ones, if there are several clusters.
/// No two windows overlap, halos included, so no voxel and no halo of one is stepped in another.
/// Together they are not larger than a single window around all of them.
/// There are at most `max` of them, which is at least 1, and one if no birth is far from the ones
/// before it.
///
/// Positions are those in the part's patch, whose rows from `top` on are empty.
pub(super) fn windows(
    births: impl Iterator<Item = Birth>,
    margins: [usize; 2],
    patch: &Patch,
    top: usize,
    max: usize,
) -> Vec<Window> {
    // The windows of nearer births would overlap.
    let reach = margins.map(|margin| 2 * (margin + 1));
    let mut clusters: Vec<Cluster> = Vec::new();
    for birth in births {
        let near = clusters.iter().rposition(|cluster| cluster.all.reaches(birth.position, reach));
        // Beyond the maximum, the last cluster takes in all others.
        let near = near.or(clusters.len().checked_sub(1).filter(|&last| last + 1 == max));
        let near = near.unwrap_or_else(|| {
            clusters.push(Cluster { all: Box3::of(birth.position), young: None, coming: false });
            clusters.len() - 1
        });
        clusters[near].add(birth);
    }
    let boxes: Vec<Box3> = match &clusters[..] {
        [one] => one.young.into_iter().collect(),
        several => several.iter().filter_map(Cluster::needed).collect(),
    };
    let Some((&first, others)) = boxes.split_first() else { return Vec::new() };
    let mut all = first;
    others.iter().for_each(|other| all.merge(other));
    let single = all.window(margins, patch, top);
    if others.is_empty() {
        return vec![single];
    }
    let windows = separate(boxes, margins, patch, top);
    let cost = |windows: &[Window]| {
        windows.iter().map(|window| window.shape.len() + WINDOW_VOXELS).sum::<usize>()
    };
    if cost(&windows) < cost(&[single]) { windows } else { vec![single] }
}

/// The windows of some boxes, after those are merged whose windows overlap, or for which a common
/// window costs less.
fn separate(boxes: Vec<Box3>, margins: [usize; 2], patch: &Patch, top: usize) -> Vec<Window> {
    // No two of these are to be merged.
    let mut apart: Vec<(Box3, Window)> = Vec::with_capacity(boxes.len());
    for mut one in boxes {
        let mut window = one.window(margins, patch, top);
        loop {
            let merged = apart.iter().enumerate().find_map(|(i, (other, other_window))| {
                let mut common = one;
                common.merge(other);
                let around = common.window(margins, patch, top);
                let apart_len = window.shape.len() + other_window.shape.len() + WINDOW_VOXELS;
                let merge = window.overlaps(other_window) || around.shape.len() <= apart_len;
                merge.then_some((i, common, around))
            });
            let Some((i, common, around)) = merged else { break };
            // The larger window may overlap others.
            apart.swap_remove(i);
            (one, window) = (common, around);
        }
        apart.push((one, window));
    }
    apart.into_iter().map(|(_, window)| window).collect()
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::coefficients::Coefficients;
    use crate::material::ThermalMaterial;
    use crate::process::ProcessParameters;
    use crate::shape::Shape;

    const SIZE: [usize; 3] = [150, 60, 20];

    fn patch() -> Patch {
        let coefficients = Coefficients::new(
            &ThermalMaterial::abs(),
            &ProcessParameters::default(),
            0.5e-3,
            0.25e-3,
        );
        let [width, height, depth] = SIZE;
        Patch::unprinted(Shape::with_halo(width, height, depth), &coefficients)
    }

    /// Births along straight lines, which begin at random voxels.
    fn lines(random: &mut Xoshiro256PlusPlus, count: usize, times: &[BirthTime]) -> Vec<Birth> {
        let mut births = Vec::new();
        for _ in 0..count {
            let start = SIZE.map(|size| random.random_range(1..=size));
            let axis = random.random_range(0..2);
            for i in 0..random.random_range(1..30) {
                let mut position = start;
                position[axis] = (start[axis] + i).min(SIZE[axis]);
                let time = times[random.random_range(0..times.len())];
                births.push(Birth { position, time });
            }
        }
        births
    }

    fn contains(window: &Window, position: [usize; 3]) -> bool {
        let sizes = window.shape.sizes();
        (0..3).all(|axis| {
            let low = window.origin[axis];
            (low + 1..low + sizes[axis] - 1).contains(&position[axis])
        })
    }

    #[test]
    fn windows_contain_all_young_births_with_their_margins_and_do_not_overlap() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
        let patch = patch();
        let (mut several, mut one) = (0, 0);
        for _ in 0..4000 {
            let count = random.random_range(0..12);
            let births =
                lines(&mut random, count, &[BirthTime::Coming, BirthTime::Recent, BirthTime::Old]);
            let margins = [random.random_range(1..8), random.random_range(1..8)];
            let highest = births.iter().map(|birth| birth.position[2]).max().unwrap_or(1);
            let top = random.random_range(1..=highest + 1);
            let max = random.random_range(1..20);
            let windows = windows(births.iter().copied(), margins, &patch, top, max);
            assert!(windows.len() <= max);
            for (i, window) in windows.iter().enumerate() {
                assert!(windows[..i].iter().all(|other| !other.overlaps(window)));
            }
            let young = || births.iter().filter(|birth| birth.time != BirthTime::Old);
            for birth in young() {
                let [x, y, z] = birth.position;
                let [side, below] = margins;
                let corners = [
                    [
                        x.saturating_sub(side).max(1),
                        y.saturating_sub(side).max(1),
                        z.saturating_sub(below).max(1),
                    ],
                    [(x + side).min(SIZE[0]), (y + side).min(SIZE[1]), z],
                ];
                let with_margins =
                    |window: &&Window| corners.iter().all(|&corner| contains(window, corner));
                assert_eq!(windows.iter().filter(with_margins).count(), 1, "{birth:?}");
            }
            let volume: usize = windows.iter().map(|window| window.shape.len()).sum();
            let boxes: Vec<_> = young().map(|birth| Box3::of(birth.position)).collect();
            if let (Some(first), true) = (boxes.first(), births.len() == boxes.len()) {
                let mut all = *first;
                boxes.iter().for_each(|one| all.merge(one));
                assert!(volume <= all.window(margins, &patch, top).shape.len());
            }
            several += u32::from(windows.len() > 1);
            one += u32::from(windows.len() == 1);
        }
        assert!(several > 1000 && one > 300, "{several} {one}");
    }

    /// Orders without jumps give the same windows as ever: one around all births but old ones.
    #[test]
    fn births_next_to_each_other_have_one_window() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(4);
        let patch = patch();
        for _ in 0..2000 {
            let mut position = SIZE.map(|size| random.random_range(1..=size));
            let mut births = Vec::new();
            for i in 0..random.random_range(1..200) {
                let axis = random.random_range(0..2);
                let step = if random.random_bool(0.5) { 1 } else { usize::MAX };
                position[axis] = position[axis].wrapping_add(step).clamp(1, SIZE[axis]);
                let time = if i < 40 { BirthTime::Old } else { BirthTime::Recent };
                births.push(Birth { position, time });
            }
            let margins = [random.random_range(1..8), random.random_range(1..8)];
            let top = position[2] + 1;
            let windows = windows(births.iter().copied(), margins, &patch, top, 32);
            let young = births.iter().filter(|birth| birth.time != BirthTime::Old);
            let young = young.map(|birth| Box3::of(birth.position));
            let expected = young.reduce(|mut all, one| {
                all.merge(&one);
                all
            });
            let expected = expected.map(|all| all.window(margins, &patch, top));
            assert_eq!(windows, expected.into_iter().collect::<Vec<_>>());
        }
    }

    #[test]
    fn old_births_count_only_where_the_nozzle_has_left() {
        let patch = patch();
        let birth = |x: usize, time: BirthTime| Birth { position: [x, 5, 3], time };
        let around = |births: &[Birth]| windows(births.iter().copied(), [2, 2], &patch, 4, 32);
        let (left, here) = (birth(10, BirthTime::Old), birth(120, BirthTime::Coming));
        let [both, one] = [&[left, here][..], &[here]].map(around);
        assert_eq!((both.len(), one.len()), (2, 1));
        assert!(contains(&both[0], left.position) && both[1] == one[0]);
        // The nozzle is still near.
        assert_eq!(around(&[birth(114, BirthTime::Old), here]).len(), 1);
        assert_eq!(around(&[birth(114, BirthTime::Old), here]), around(&[here]));
        assert_eq!(around(&[left]), []);
    }
}
