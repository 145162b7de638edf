//! The sweeps over a patch: where all the time goes.
//!
//! Written on lanes of whatever width the processor has, chosen when the program runs. Products are fused into sums
//! wherever the source says so and nowhere else, so that every processor computes the same bits.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined into a sweep is compiled for the processor's lanes"
)]

use pulp::{Arch, Simd, WithSimd};

use crate::aligned::{Aligned, LINE};
use crate::law::Law;
use crate::patch::{Activity, Line, Patch, Shape};

/// A range of a plane of temperatures, or of their rates, with the same of the planes behind and before it.
#[derive(Clone, Copy)]
struct Planes<'a> {
    back: &'a [f32],
    /// With the row below and the row above.
    here: &'a [f32],
    front: &'a [f32],
}

impl<'a> Planes<'a> {
    /// Around a range of a patch.
    #[inline(always)]
    fn of(numbers: &'a [f32], start: usize, len: usize, row: usize, plane: usize) -> Self {
        Self {
            back: &numbers[start - plane..][..len],
            here: &numbers[start - row..][..len + 2 * row],
            front: &numbers[start + plane..][..len],
        }
    }
}

/// One range of a plane and its six neighbours, in lanes.
struct Stencil<'a, S: Simd> {
    simd: S,
    lateral: S::f32s,
    vertical: S::f32s,
    here: &'a [S::f32s],
    left: &'a [S::f32s],
    right: &'a [S::f32s],
    back: &'a [S::f32s],
    front: &'a [S::f32s],
    below: &'a [S::f32s],
    above: &'a [S::f32s],
}

#[inline(always)]
fn lanes<S: Simd>(numbers: &[f32], start: usize, len: usize) -> &[S::f32s] {
    S::as_simd_f32s(&numbers[start..start + len]).0
}

impl<'a, S: Simd> Stencil<'a, S> {
    /// `here` of the planes begins one row before the range, `back` and `front` with it.
    #[inline(always)]
    fn new(simd: S, law: &Law, planes: Planes<'a>, row: usize) -> Self {
        let Planes { back, here, front } = planes;
        let len = back.len();
        Self {
            simd,
            lateral: simd.splat_f32s(law.lateral),
            vertical: simd.splat_f32s(law.vertical),
            here: lanes::<S>(here, row, len),
            left: lanes::<S>(here, row - 1, len),
            right: lanes::<S>(here, row + 1, len),
            below: lanes::<S>(here, 0, len),
            above: lanes::<S>(here, 2 * row, len),
            back: lanes::<S>(back, 0, len),
            front: lanes::<S>(front, 0, len),
        }
    }

    /// So many lanes: known to the compiler, it need not check the loops over them.
    #[inline(always)]
    fn len(&self) -> usize {
        let n = self.here.len();
        let all = [self.left, self.right, self.back, self.front, self.below, self.above];
        assert!(all.iter().all(|numbers| numbers.len() == n), "all neighbours have the range's length");
        n
    }

    /// What flows in from the neighbours.
    #[inline(always)]
    fn inflow(&self, i: usize) -> S::f32s {
        let s = self.simd;
        let x = s.add_f32s(self.left[i], self.right[i]);
        let y = s.add_f32s(self.back[i], self.front[i]);
        let z = s.add_f32s(self.below[i], self.above[i]);
        s.mul_add_f32s(self.lateral, s.add_f32s(x, y), s.mul_f32s(self.vertical, z))
    }
}

/// What a surface loses, in lanes.
struct Surface<'a, S: Simd> {
    simd: S,
    radiation: [S::f32s; 4],
    damping: &'a [S::f32s],
    exposure: &'a [S::f32s],
    caps: &'a [S::f32s],
    resistance: Option<[S::f32s; 3]>,
}

impl<'a, S: Simd> Surface<'a, S> {
    #[inline(always)]
    fn new(simd: S, law: &Law, activity: &'a Activity, start: usize, n: usize, derived: bool) -> Self {
        let len = n * S::F32_LANES;
        // The derivative of θ · radiation(θ) is a cubic polynomial too.
        let power = |i: usize| if derived { (i + 1) as f32 } else { 1.0 };
        Self {
            simd,
            radiation: std::array::from_fn(|i| simd.splat_f32s(power(i) * law.radiation[i])),
            damping: &lanes::<S>(&activity.damping, start, len)[..n],
            exposure: &lanes::<S>(&activity.exposure, start, len)[..n],
            caps: if activity.caps.is_empty() { &[] } else { &lanes::<S>(&activity.caps, start, len)[..n] },
            resistance: law.resistance.map(|numbers| numbers.map(|number| simd.splat_f32s(number))),
        }
    }

    /// The factor of a voxel's own temperature, or of its rate.
    #[inline(always)]
    fn damping(&self, i: usize, theta: S::f32s) -> S::f32s {
        let s = self.simd;
        let [r0, r1, r2, r3] = self.radiation;
        let radiated = s.mul_add_f32s(s.mul_add_f32s(s.mul_add_f32s(r3, theta, r2), theta, r1), theta, r0);
        let Some([convection, side, cap]) = self.resistance else {
            return s.negate_mul_add_f32s(radiated, self.exposure[i], self.damping[i]);
        };
        let h = s.add_f32s(radiated, convection);
        let one = s.splat_f32s(1.0);
        let passed =
            |exposure, distance| s.div_f32s(s.mul_f32s(h, exposure), s.mul_add_f32s(h, distance, one));
        let lost = s.add_f32s(passed(self.exposure[i], side), passed(self.caps[i], cap));
        s.sub_f32s(self.damping[i], lost)
    }

    /// Numbers of active voxels; 0 for all others.
    #[inline(always)]
    fn active(&self, i: usize, number: S::f32s) -> S::f32s {
        let zero = self.simd.splat_f32s(0.0);
        self.simd.select_f32s(self.simd.less_than_f32s(self.damping[i], zero), number, zero)
    }
}

/// The runs of equal lines in a range of a patch: what they are, and where each begins and ends, in lanes of a width.
///
/// An iterator and not a function that takes a closure: closures that are not inlined lose the lanes.
struct Runs<'a> {
    lines: &'a [Line],
    begin: usize,
    /// Lanes in a line.
    lanes: usize,
}

impl<'a> Runs<'a> {
    #[inline(always)]
    fn new<S: Simd>(activity: &'a Activity, start: usize, len: usize) -> Self {
        let lines = &activity.lines[start / LINE..(start + len) / LINE];
        Self { lines, begin: 0, lanes: LINE / S::F32_LANES }
    }
}

impl Iterator for Runs<'_> {
    type Item = (Line, usize, usize);

    #[inline(always)]
    fn next(&mut self) -> Option<Self::Item> {
        let begin = self.begin;
        let line = *self.lines.get(begin)?;
        self.begin += 1;
        while self.lines.get(self.begin) == Some(&line) {
            self.begin += 1;
        }
        Some((line, begin * self.lanes, self.begin * self.lanes))
    }
}

/// One explicit step of a whole patch, from one array into another: the plain scheme.
pub(crate) struct Euler<'a> {
    pub(crate) law: &'a Law,
    pub(crate) shape: Shape,
    pub(crate) activity: &'a Activity,
    pub(crate) from: &'a [f32],
    pub(crate) to: &'a mut [f32],
    /// Rows of each plane from here on are left alone.
    pub(crate) top: usize,
    pub(crate) seconds: f32,
}

impl WithSimd for Euler<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { law, shape, activity, from, to, top, seconds } = self;
        let (row, plane) = (shape.row, shape.plane());
        let dt = s.splat_f32s(seconds);
        let interior = s.splat_f32s(law.interior().damping);
        let swept = (top - 1) * row;
        for y in 1..shape.planes - 1 {
            let start = y * plane + row;
            let around = Planes::of(from, start, swept, row, plane);
            let stencil = Stencil::new(s, law, around, row);
            let n = stencil.len();
            let surface = Surface::<S>::new(s, law, activity, start, n, false);
            let to = &mut S::as_mut_simd_f32s(&mut to[start..start + swept]).0[..n];
            for (line, begin, end) in Runs::new::<S>(activity, start, swept) {
                let run = begin..end.min(n);
                match line {
                    Line::Empty => {}
                    Line::Interior => {
                        for i in run {
                            let rate = s.mul_add_f32s(interior, stencil.here[i], stencil.inflow(i));
                            to[i] = s.mul_add_f32s(dt, rate, stencil.here[i]);
                        }
                    }
                    Line::Mixed => {
                        for i in run {
                            let here = stencil.here[i];
                            let rate = s.mul_add_f32s(surface.damping(i, here), here, stencil.inflow(i));
                            to[i] = s.mul_add_f32s(dt, surface.active(i, rate), here);
                        }
                    }
                }
            }
        }
    }
}

/// Two stages of a step in place: θ + a f(θ) + b J f(θ), where f is the rate of change and J its derivative.
///
/// With a = dt and b = dt² / 2 that is Heun's method; steps of more stages are products of such pairs. Rates are kept of
/// three planes only, so that each temperature is read and written once for both stages.
pub(crate) struct Pair<'a> {
    pub(crate) law: &'a Law,
    pub(crate) patch: &'a mut Patch,
    pub(crate) rates: &'a mut [f32],
    pub(crate) a: f32,
    pub(crate) b: f32,
    /// A voxel that keeps the temperature of its birth.
    pub(crate) held: Option<usize>,
    /// Rows of each plane from here on are left alone.
    pub(crate) top: usize,
}

/// Memory for the rates of [`Pair`]: three planes, and one of zeros that stands for the rim's.
#[derive(Debug, Default)]
pub(crate) struct Rates(Aligned);

impl Rates {
    /// For patches of a shape: the rows that are read but never written hold 0.
    pub(crate) fn of(&mut self, shape: Shape, top: usize) -> &mut [f32] {
        let (row, plane) = (shape.row, shape.plane());
        self.0.resize(4 * plane);
        for rates in self.0[..3 * plane].chunks_exact_mut(plane) {
            rates[..row].fill(0.0);
            rates[top * row..(top + 1) * row].fill(0.0);
        }
        self.0[3 * plane..].fill(0.0);
        &mut self.0
    }
}

impl WithSimd for Pair<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { law, patch, rates, a, b, held, top } = self;
        let Patch { shape, activity, theta, .. } = patch;
        let (row, plane) = (shape.row, shape.plane());
        let (kept, zeros) = rates.split_at_mut(3 * plane);
        let swept = (top - 1) * row;
        let last = shape.planes - 1;
        for y in 1..=last {
            if y < last {
                let here = y % 3 * plane;
                rate(s, law, activity, theta, y * plane, (row, plane), &mut kept[here + row..][..swept]);
                if let Some(held) = held.filter(|held| held / plane == y) {
                    kept[here + held % plane] = 0.0;
                }
            }
            if y > 1 {
                let y = y - 1;
                let own = |y: usize| {
                    let rates = if y == 0 || y == last { &*zeros } else { &kept[y % 3 * plane..] };
                    &rates[row..row + swept]
                };
                let here = y % 3 * plane;
                let rates =
                    Planes { back: own(y - 1), here: &kept[here..here + swept + 2 * row], front: own(y + 1) };
                second(
                    s,
                    law,
                    activity,
                    &mut theta[y * plane + row..][..swept],
                    y * plane + row,
                    rates,
                    row,
                    (a, b),
                );
            }
        }
        if let Some(held) = held {
            theta[held] = law.birth;
        }
    }
}

/// The rates of change of one plane, which starts at `start`: the first stage.
#[inline(always)]
fn rate<S: Simd>(
    s: S,
    law: &Law,
    activity: &Activity,
    theta: &[f32],
    start: usize,
    (row, plane): (usize, usize),
    rates: &mut [f32],
) {
    let (start, len) = (start + row, rates.len());
    let interior = s.splat_f32s(law.interior().damping);
    let stencil = Stencil::new(s, law, Planes::of(theta, start, len, row, plane), row);
    let n = stencil.len();
    let surface = Surface::<S>::new(s, law, activity, start, n, false);
    let rates = &mut S::as_mut_simd_f32s(rates).0[..n];
    for (line, begin, end) in Runs::new::<S>(activity, start, len) {
        let run = begin..end.min(n);
        match line {
            Line::Empty => rates[run].fill(s.splat_f32s(0.0)),
            Line::Interior => {
                for i in run {
                    rates[i] = s.mul_add_f32s(interior, stencil.here[i], stencil.inflow(i));
                }
            }
            Line::Mixed => {
                for i in run {
                    let here = stencil.here[i];
                    let rate = s.mul_add_f32s(surface.damping(i, here), here, stencil.inflow(i));
                    rates[i] = surface.active(i, rate);
                }
            }
        }
    }
}

/// The second stage of a plane, given the rates of the first.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "inlined, and called once")]
fn second<S: Simd>(
    s: S,
    law: &Law,
    activity: &Activity,
    theta: &mut [f32],
    start: usize,
    around: Planes<'_>,
    row: usize,
    (a, b): (f32, f32),
) {
    let (a, b) = (s.splat_f32s(a), s.splat_f32s(b));
    let interior = s.splat_f32s(law.interior().damping);
    let len = theta.len();
    let stencil = Stencil::new(s, law, around, row);
    let n = stencil.len();
    let surface = Surface::<S>::new(s, law, activity, start, n, true);
    let theta = &mut S::as_mut_simd_f32s(theta).0[..n];
    for (line, begin, end) in Runs::new::<S>(activity, start, len) {
        let run = begin..end.min(n);
        match line {
            Line::Empty => {}
            Line::Interior => {
                for i in run {
                    let change = s.mul_add_f32s(interior, stencil.here[i], stencil.inflow(i));
                    theta[i] = s.mul_add_f32s(b, change, s.mul_add_f32s(a, stencil.here[i], theta[i]));
                }
            }
            Line::Mixed => {
                for i in run {
                    let damping = surface.damping(i, theta[i]);
                    let change =
                        surface.active(i, s.mul_add_f32s(damping, stencil.here[i], stencil.inflow(i)));
                    theta[i] = s.mul_add_f32s(b, change, s.mul_add_f32s(a, stencil.here[i], theta[i]));
                }
            }
        }
    }
}

/// Runs a sweep on the widest lanes that the processor has.
pub(crate) fn dispatch<W: WithSimd>(sweep: W) -> W::Output {
    Arch::new().dispatch(sweep)
}
