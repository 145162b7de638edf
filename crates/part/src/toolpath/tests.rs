//! Insets and infill compared with distances of points, lengths with densities, and bad input.

use beadwork_base::{CancelToken, Control, Interrupted};
use proptest::prelude::*;

use super::scan_lines::Family;
use super::*;
use crate::area::{Area, Ring};
use crate::simplify::squared_to_line;
use crate::slice::{FillRule, LayerAreas, MaterialArea};

const BEAD_MM: f64 = 0.5;

fn lines_of(ring: &Ring) -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
    ring.iter().copied().zip(ring.iter().skip(1).chain(ring.first()).copied())
}

fn distance(rings: &[&Ring], point: [f64; 2]) -> f64 {
    let lines = rings.iter().flat_map(|ring| lines_of(ring));
    lines.map(|(from, to)| squared_to_line(point, from, to)).fold(f64::INFINITY, f64::min).sqrt()
}

fn border(area: &Area) -> Vec<&Ring> {
    area.rings().collect()
}

fn is_inside(area: &Area, [x, y]: [f64; 2]) -> bool {
    let crosses = |&(from, to): &([f64; 2], [f64; 2])| {
        (from[1] <= y) != (to[1] <= y)
            && from[0] + (y - from[1]) / (to[1] - from[1]) * (to[0] - from[0]) > x
    };
    area.rings().flat_map(lines_of).filter(crosses).count() % 2 == 1
}

fn rectangle(x: f64, y: f64, width: f64, height: f64) -> Area {
    let ring = vec![[x, y], [x + width, y], [x + width, y + height], [x, y + height]];
    Area::from_rings(&[ring], FillRule::NonZero)
}

fn disc(x: f64, y: f64, radius: f64, corners: u32) -> Area {
    let corner = |i: u32| {
        let angle = f64::from(i) * std::f64::consts::TAU / f64::from(corners);
        [x + radius * angle.cos(), y + radius * angle.sin()]
    };
    Area::from_rings(&[(0..corners).map(corner).collect()], FillRule::NonZero)
}

/// Layers of one material each.
fn layers(areas: &[Area]) -> Vec<LayerAreas> {
    let layer =
        |area: &Area| LayerAreas { areas: vec![MaterialArea { material: 2, area: area.clone() }] };
    areas.iter().map(layer).collect()
}

fn laid_out(area: &Area, settings: &Settings) -> Vec<Island> {
    islands(&layers(std::slice::from_ref(area)), settings, &Control::default()).unwrap().remove(0)
}

fn without_solid() -> Settings {
    Settings { top_layers: 0, bottom_layers: 0, ..Settings::default() }
}

/// Unions and differences of rectangles and discs.
fn area() -> impl Strategy<Value = Area> {
    let size = prop_oneof![0.2..2.0_f64, 2.0..9.0_f64];
    let piece = (any::<bool>(), [0.0..12.0_f64, 0.0..12.0_f64], [size.clone(), size], 3_u32..60);
    prop::collection::vec((piece, 0..4), 1..7).prop_map(|pieces| {
        let mut area = rectangle(2.0, 3.0, 8.0, 6.0);
        for ((is_round, [x, y], [a, b], corners), kind) in pieces {
            let piece = if is_round { disc(x, y, a / 2.0, corners) } else { rectangle(x, y, a, b) };
            area = if kind == 0 { area.difference(&piece) } else { area.union(&piece) };
        }
        area.without_slivers(1e-4)
    })
}

/// Points of an outline that discs of a radius touch from inside, with the centres of the discs.
fn touched(outline: &Area, radius: f64) -> Vec<[f64; 2]> {
    let rings = border(outline);
    let mut centres = Vec::new();
    for (from, to) in outline.rings().flat_map(lines_of) {
        let [dx, dy] = [to[0] - from[0], to[1] - from[1]];
        let length = dx.hypot(dy);
        for part in [0.1, 0.35, 0.6, 0.9] {
            let point = [from[0] + part * dx, from[1] + part * dy];
            let centre = |by: f64| [point[0] - dy / length * by, point[1] + dx / length * by];
            if length > 1e-3 && distance(&rings, centre(radius)) > radius - 1e-6 {
                centres.push(centre(BEAD_MM / 2.0));
            }
        }
    }
    centres
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 400,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// The slow twin of insets is the distance of points to the outline.
    #[test]
    fn insets_lie_at_their_depth(
        area in area(),
        points in prop::collection::vec([0.0..14.0_f64, 0.0..14.0_f64], 200),
    ) {
        for island in laid_out(&area, &without_solid()) {
            let outline = border(&island.outline);
            for inset in &island.insets {
                let depth_mm = (f64::from(inset.depth) + 0.5) * BEAD_MM;
                for (from, to) in lines_of(&inset.ring) {
                    let middle = [0, 1].map(|k| f64::midpoint(from[k], to[k]));
                    for point in [from, middle] {
                        let got_mm = distance(&outline, point);
                        prop_assert!(is_inside(&island.outline, point));
                        // 5 % of a bead would be 0.025 mm.
                        prop_assert!(got_mm > depth_mm - 0.012, "{got_mm} {depth_mm}");
                        // Where insets are cut out, their ends lie deeper.
                        prop_assert!(got_mm < depth_mm + 0.36 * BEAD_MM, "{got_mm} {depth_mm}");
                    }
                }
            }
            // The outer edge follows the outline wherever a disc of 1.6 beads fits.
            let outer: Vec<&Ring> =
                island.insets.iter().filter(|it| it.depth == 0).map(|it| &it.ring).collect();
            for centre in touched(&island.outline, 0.82 * BEAD_MM) {
                prop_assert!(distance(&outer, centre) < 0.02, "{centre:?}");
            }
            // Points that nothing reaches are rare, or near corners.
            let reach_mm = BEAD_MM * 0.82;
            let insets: Vec<&Ring> = island.insets.iter().map(|it| &it.ring).collect();
            for &point in points.iter().filter(|&&point| is_inside(&island.outline, point)) {
                let region = island.infill.iter().map(|infill| &infill.region);
                let is_reached = distance(&insets, point) < reach_mm
                    || is_inside(&island.residue, point)
                    || distance(&border(&island.residue), point) < 0.3
                    || region.clone().any(|area| {
                        is_inside(area, point) || distance(&border(area), point) < reach_mm
                    });
                // Small islands and acute corners are left out.
                let is_thin = distance(&outline, point) < 0.15 * BEAD_MM
                    || island.outline.size_mm2() < 1.0;
                prop_assert!(is_reached || is_thin, "{point:?} in {:?}", island);
            }
            // Each inset has a neighbour one bead outside it.
            for inset in &island.insets {
                prop_assert_eq!(inset.parent.is_some(), inset.depth > 0);
                if let Some(parent) = inset.parent {
                    let parent = &island.insets[parent];
                    prop_assert_eq!(parent.depth + 1, inset.depth);
                    let mm = distance(&[&parent.ring], inset.ring[0]);
                    prop_assert!(mm < 1.4 * BEAD_MM, "{mm}");
                }
            }
        }
    }

    /// The slow twin of scan lines is the question whether a point of a line is inside.
    #[test]
    fn lines_are_inside(
        area in area(),
        degrees in 0.0..180.0_f64,
        spacing_mm in 0.2..5.0_f64,
        shift_mm in 0.0..1.0_f64,
        samples in prop::collection::vec((-30_i32..30, -20.0..20.0_f64), 100),
    ) {
        let along = [degrees.to_radians().cos(), degrees.to_radians().sin()];
        let lines = Family { along, spacing_mm, shift_mm }.clip(area.rings());
        let rings = border(&area);
        let across = |[x, y]: [f64; 2]| (along[0] * y - along[1] * x - shift_mm) / spacing_mm;
        for line in &lines {
            for &end in line {
                prop_assert!(distance(&rings, end) < 1e-9);
                prop_assert!((across(end) - across(end).round()).abs() < 1e-6);
            }
            let middle = [0, 1].map(|k| f64::midpoint(line[0][k], line[1][k]));
            prop_assert!(is_inside(&area, middle) || distance(&rings, middle) < 1e-6);
        }
        for (number, at_mm) in samples {
            let v = f64::from(number) * spacing_mm + shift_mm;
            let point = [along[0] * at_mm - along[1] * v, along[1] * at_mm + along[0] * v];
            if distance(&rings, point) > 1e-6 {
                let is_covered =
                    lines.iter().any(|line| squared_to_line(point, line[0], line[1]) < 1e-12);
                prop_assert_eq!(is_covered, is_inside(&area, point));
            }
        }
    }

    /// Every pattern stays within its region; solid and sparse regions fill the infill region, but
    /// for one bead between them.
    #[test]
    fn infill_stays_in_its_region(
        [below, area, above] in [area(), area(), area()],
        pattern in 0..InfillPattern::ALL.len(),
        density in prop_oneof![0.01..1.0_f64, Just(0.0), Just(1.0)],
        perimeters in 0_u32..4,
    ) {
        let pattern = InfillPattern::ALL[pattern];
        let settings = Settings {
            pattern, density, perimeters, top_layers: 1, bottom_layers: 1, ..Settings::default()
        };
        let stack = layers(&[below, area.clone(), above]);
        let middle = islands(&stack, &settings, &Control::default()).unwrap().remove(1);
        let alone = laid_out(&area, &Settings { density: 1.0, ..settings });
        prop_assert_eq!(middle.len(), alone.len());
        for (island, alone) in middle.iter().zip(&alone) {
            prop_assert_eq!(&island.insets, &alone.insets);
            let region = |is_solid: bool| {
                let of_kind = island.infill.iter().filter(|infill| infill.is_solid == is_solid);
                Area::union_of(of_kind.map(|infill| infill.region.clone()).collect())
            };
            let (solid, sparse) = (region(true), region(false));
            let whole = alone.infill.first().map(|infill| infill.region.clone());
            let whole = whole.unwrap_or_default();
            prop_assert!(solid.difference(&whole).size_mm2() < 0.01);
            prop_assert!(sparse.difference(&whole).size_mm2() < 0.01);
            // Boolean operations may leave spikes without width, where nothing is printed.
            let printed = solid.simplified(0.02 * BEAD_MM);
            let common = printed.offset(0.9 * BEAD_MM).intersection(&sparse);
            prop_assert!(common.size_mm2() < 0.01, "{common:?} {solid:?}");
            let rest = whole.difference(&sparse).difference(&solid.offset(1.05 * BEAD_MM));
            // Sparse strips beside solid areas stay empty where they are narrow.
            let rest = rest.opened(0.3 * BEAD_MM);
            prop_assert!(rest.without_slivers(0.02).is_empty() || !solid.is_empty());
            for infill in &island.infill {
                let rings = border(&infill.region);
                let is_in = |point| {
                    is_inside(&infill.region, point) || distance(&rings, point) < 0.005
                };
                for line in &infill.lines {
                    prop_assert!(line.len() > 1);
                    for end in [line[0], line[line.len() - 1]] {
                        prop_assert!(distance(&rings, end) < 1e-6, "{end:?}");
                    }
                    for pair in line.windows(2) {
                        let middle = [0, 1].map(|k| f64::midpoint(pair[0][k], pair[1][k]));
                        prop_assert!(is_in(middle));
                    }
                }
                prop_assert!(infill.loops.iter().flatten().all(|&point| is_in(point)));
                prop_assert!(density > 0.0 || infill.is_solid || infill.lines.is_empty());
            }
        }
    }
}

fn length(infill: &Infill) -> f64 {
    let mm = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let lines = infill.lines.iter().flat_map(|line| line.windows(2));
    let loops = infill.loops.iter().flat_map(lines_of);
    lines.map(|pair| mm(pair[0], pair[1])).sum::<f64>()
        + loops.map(|(from, to)| mm(from, to)).sum::<f64>()
}

#[test]
fn patterns_extrude_the_density() {
    let square = rectangle(0.3, 0.2, 600.0, 600.0);
    for pattern in InfillPattern::ALL {
        for density in [0.1, 0.2, 0.5, 0.8] {
            for angle_degrees in [0.0, 45.0, 77.0] {
                let settings = Settings { density, pattern, angle_degrees, ..without_solid() };
                let islands = laid_out(&square, &settings);
                let infill = &islands[0].infill[0];
                let got = length(infill) * BEAD_MM / infill.region.size_mm2();
                assert!((got / density - 1.0).abs() < 0.04, "{pattern} {density}: {got}");
                assert!(!infill.is_solid);
            }
        }
    }
}

#[test]
fn full_density_is_solid_and_has_one_region() {
    let stack = layers(&[rectangle(0.0, 0.0, 30.0, 20.0), rectangle(5.0, 5.0, 10.0, 10.0)]);
    for pattern in InfillPattern::ALL {
        let settings = Settings { density: 1.0, pattern, ..Settings::default() };
        let layers = islands(&stack, &settings, &Control::default()).unwrap();
        let infill = &layers[0][0].infill;
        assert_eq!((infill.len(), infill[0].is_solid), (1, true));
        let share = length(&infill[0]) * BEAD_MM / infill[0].region.size_mm2();
        assert!((0.95..1.05).contains(&share), "{pattern}: {share}");
        assert_eq!(pattern == InfillPattern::Concentric, infill[0].lines.is_empty());
    }
}

#[test]
fn solid_layers_follow_the_surfaces() {
    // Ten layers of a plate, and ten layers of a tower on its left half.
    let (plate, tower) = (rectangle(0.0, 0.0, 40.0, 20.0), rectangle(0.0, 0.0, 20.0, 20.0));
    let areas: Vec<Area> = (0..20).map(|z| if z < 10 { &plate } else { &tower }.clone()).collect();
    let settings = Settings { top_layers: 4, bottom_layers: 2, ..Settings::default() };
    let layers = islands(&layers(&areas), &settings, &Control::default()).unwrap();
    for (z, islands) in layers.iter().enumerate() {
        let kinds: Vec<bool> = islands[0].infill.iter().map(|infill| infill.is_solid).collect();
        let expected: &[bool] = match z {
            0..2 | 16..20 => &[true],
            6..10 => &[true, false],
            _ => &[false],
        };
        assert_eq!(kinds, expected, "layer {z}");
    }
    // The half without a tower, and a bead for anchorage.
    let [min, max] = layers[9][0].infill[0].region.bounds().unwrap();
    assert!((min[0] - 19.5).abs() < 0.02 && (max[0] - 38.775).abs() < 0.02, "{min:?} {max:?}");
    // Sparse beads end beside the solid ones.
    let [_, max] = layers[9][0].infill[1].region.bounds().unwrap();
    assert!((max[0] - (19.5 - 0.95 * BEAD_MM)).abs() < 0.02, "{max:?}");
    // Lines of one layer cross those of the next, and lie on those of the next but one.
    let lines = |z: usize| &layers[z][0].infill[0].lines;
    assert_eq!(lines(10), lines(12));
    assert_ne!(lines(10), lines(11));
}

#[test]
fn thin_walls_are_residue_until_two_strips_fit() {
    for tenths in 2..=20 {
        let width = f64::from(tenths) / 10.0;
        let island = &laid_out(&rectangle(0.0, 0.0, width, 20.0), &without_solid())[0];
        if [8, 18].contains(&tenths) {
            // Exactly the limit of the first or the second inset.
            continue;
        }
        let is_thin = width < 1.6 * BEAD_MM;
        assert_eq!(island.insets.is_empty(), is_thin, "{width}");
        if is_thin {
            let share = island.residue.size_mm2() / island.outline.size_mm2();
            assert!((0.97..1.001).contains(&share), "{width}: {share}");
            assert_eq!(island.skeletons.len(), 1, "{width}");
            let skeleton = &island.skeletons[0];
            assert!(skeleton.length_mm() > 18.5, "{width}");
            assert!(skeleton.widths_mm.iter().all(|it| (it - width).abs() < 0.02), "{width}");
        }
        // Gaps of 0.2 mm and more between the two sides.
        let gap = width - 2.0 * BEAD_MM;
        assert_eq!(island.residue.is_empty(), !is_thin && !(0.25..0.75).contains(&gap), "{width}");
    }
}

#[test]
fn thin_walls_end_where_wide_areas_begin() {
    // A block with a fin 0.6 mm wide.
    let area = rectangle(0.0, 0.0, 10.0, 10.0).union(&rectangle(10.0, 5.0, 10.0, 0.6));
    let island = &laid_out(&area, &without_solid())[0];
    assert_eq!(island.insets.len(), 2);
    assert_eq!(island.residue.components().len(), 1);
    let [min, max] = island.residue.bounds().unwrap();
    assert!((10.0..10.6).contains(&min[0]) && max[0] > 19.9, "{min:?} {max:?}");
    let reach = island.insets[0].ring.iter().map(|point| point[0]).fold(0.0, f64::max);
    assert!((min[0] - 0.5 * BEAD_MM - reach).abs() < 0.1, "{reach} {min:?}");
}

#[test]
fn beads_of_varying_width_can_be_left_out() {
    // A block with a fin 0.6 mm wide, and a wall with a gap 0.3 mm wide between its insets.
    let fin = rectangle(0.0, 0.0, 10.0, 10.0).union(&rectangle(10.0, 5.0, 10.0, 0.6));
    let wall = rectangle(30.0, 0.0, 20.0, 2.3);
    let count = |area: &Area, gap_fill: bool, thin_walls: bool| {
        let settings = Settings { gap_fill, thin_walls, ..without_solid() };
        laid_out(area, &settings)[0].skeletons.len()
    };
    for (area, expected) in [(&fin, [1, 1, 0, 0]), (&wall, [1, 0, 1, 0])] {
        let got = [[true, true], [false, true], [true, false], [false, false]];
        assert_eq!(got.map(|[gaps, walls]| count(area, gaps, walls)), expected);
    }
    // A stub beside insets is too short; a pillar of one bead is all there is.
    let stub = rectangle(0.0, 0.0, 10.0, 10.0).union(&rectangle(10.0, 5.0, 0.7, 0.6));
    assert_eq!(count(&stub, true, true), 0);
    assert_eq!(count(&rectangle(0.0, 0.0, 0.6, 0.6), true, true), 1);
}

#[test]
fn small_pieces_join_their_surroundings() {
    let kinds = |area: &Area, above: &Area, density: f64| -> Vec<bool> {
        let settings = Settings { density, top_layers: 1, bottom_layers: 0, ..Settings::default() };
        let stack = layers(&[area.clone(), above.clone()]);
        let islands = islands(&stack, &settings, &Control::default()).unwrap().remove(0);
        islands[0].infill.iter().map(|infill| infill.is_solid).collect()
    };
    let plate = rectangle(0.0, 0.0, 20.0, 20.0);
    let cut = |side: f64| plate.difference(&rectangle(10.0, 10.0, side, side));
    // Surfaces of 0.6 mm and of 3 mm.
    assert_eq!(kinds(&plate, &cut(0.6), 0.2), [false]);
    assert_eq!(kinds(&plate, &cut(3.0), 0.2), [true, false]);
    // Sparse regions 1.55 mm wide become solid, unless sparse infill has density 0.
    let pillar = rectangle(0.0, 0.0, 4.0, 4.0);
    assert_eq!(kinds(&pillar, &pillar, 0.2), [true]);
    assert_eq!(kinds(&pillar, &pillar, 0.0), [false]);
    // Small surfaces of small regions.
    assert_eq!(kinds(&pillar, &Area::default(), 0.0), [true]);
}

#[test]
fn circles_of_thousands_of_corners_need_few_moves() {
    let island = &laid_out(&disc(0.0, 0.0, 20.0, 20_000), &without_solid())[0];
    assert_eq!(island.insets.len(), 2);
    for inset in &island.insets {
        assert!((60..300).contains(&inset.ring.len()), "{}", inset.ring.len());
        let radius = 20.0 - (f64::from(inset.depth) + 0.5) * BEAD_MM;
        for (from, to) in lines_of(&inset.ring) {
            let middle = [0, 1].map(|k| f64::midpoint(from[k], to[k]));
            assert!((from[0].hypot(from[1]) - radius).abs() < 0.012);
            assert!((middle[0].hypot(middle[1]) - radius).abs() < 0.012);
        }
    }
}

#[test]
fn invalid_settings_are_named() {
    let refused = |settings: Settings| settings.check().unwrap_err().to_string();
    let settings = Settings::default;
    assert_eq!(
        refused(Settings { density: 1.2, ..settings() }),
        "infill density is 1.2: it must be from 0 to 1"
    );
    assert!(refused(Settings { density: f64::NAN, ..settings() }).contains("density is NaN"));
    assert!(refused(Settings { bead_mm: 0.0, ..settings() }).starts_with("bead width is 0:"));
    assert!(refused(Settings { bead_mm: f64::INFINITY, ..settings() }).contains("width is inf"));
    assert!(refused(Settings { angle_degrees: f64::NAN, ..settings() }).contains("angle is NaN"));
    assert!(refused(Settings { infill_overlap: -0.1, ..settings() }).contains("overlap is -0.1"));
    assert!(refused(Settings { perimeters: 2000, ..settings() }).contains("perimeters is 2000"));
    let huge = layers(&[rectangle(0.0, 0.0, 1e5, 1.0)]);
    let error = islands(&huge, &settings(), &Control::default()).unwrap_err().to_string();
    assert!(error.starts_with("layer 0 is 100000 mm long, more than 65536 beads"), "{error}");
    assert_eq!("waves".parse::<InfillPattern>().unwrap_err().kind, "infill pattern");
}

#[test]
fn extreme_areas_have_clear_results() {
    let square = |x: f64, side: f64| rectangle(x, x, side, side);
    // Spacing larger than the part, in every pattern.
    for pattern in InfillPattern::ALL {
        let settings = Settings { pattern, density: 1e-9, ..without_solid() };
        let island = &laid_out(&rectangle(0.1, 0.1, 5.0, 5.0), &settings)[0];
        assert!(island.infill[0].lines.len() <= 3, "{pattern}");
    }
    // Nothing, and islands that are too small.
    assert!(laid_out(&Area::default(), &without_solid()).is_empty());
    let dot = &laid_out(&square(0.0, 0.02), &without_solid())[0];
    assert!(dot.insets.is_empty() && dot.infill.is_empty() && dot.residue.is_empty());
    let flat = Area::from_rings(&[vec![[0.0; 2], [1.0, 0.0], [2.0, 0.0]]], FillRule::NonZero);
    assert!(flat.is_empty());
    // Two squares that touch in a corner.
    let touching = square(0.0, 5.0).union(&square(5.0, 5.0));
    let islands = laid_out(&touching, &without_solid());
    assert_eq!(islands.iter().map(|island| island.insets.len()).sum::<usize>(), 4);
    // No perimeters, and more than fit.
    let none = &laid_out(&square(0.0, 5.0), &Settings { perimeters: 0, ..without_solid() })[0];
    assert!(none.insets.is_empty() && (none.infill[0].region.size_mm2() - 4.5 * 4.5).abs() < 0.01);
    let many = &laid_out(&square(0.0, 5.0), &Settings { perimeters: 1000, ..without_solid() })[0];
    assert_eq!((many.insets.len(), many.infill.len()), (5, 0));
    // A narrow notch.
    let notched = square(0.0, 5.0).difference(&rectangle(2.0, 3.0, 0.001, 3.0));
    let notched = &laid_out(&notched, &without_solid())[0];
    assert_eq!(notched.insets.len(), 2);
}

#[test]
fn results_do_not_depend_on_threads_and_calls_can_be_cancelled() {
    let stack: Vec<Area> = (1..20).map(|z| disc(0.0, 0.0, 12.0 - 0.3 * f64::from(z), 40)).collect();
    let stack = layers(&stack);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let control = Control::on(beadwork_base::Threads::Pool(&pool));
    let settings = Settings::default();
    let [one, three] = [Control::default(), control].map(|it| islands(&stack, &settings, &it));
    assert_eq!(one, three);
    let cancel = CancelToken::new();
    cancel.cancel();
    let control = Control { cancel: Some(&cancel), ..Control::default() };
    assert_eq!(
        islands(&stack, &settings, &control),
        Err(ToolpathError::Interrupted(Interrupted::Cancelled))
    );
}
