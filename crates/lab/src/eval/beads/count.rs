//! Counts of the beads of any slicer's program.

use std::ops::RangeInclusive;

use beadwork_base::Control;
use beadwork_gcode::{
    Command, Event, Feature, Filament, Line, Motion, MotionLimits, Program, Stopwatch, TraceError,
};
use serde::Serialize;

/// Travel in mm up to which an extrusion continues the bead before it.
/// Programs round coordinates to 0.001 mm.
const MAX_GAP_MM: f64 = 0.01;

/// Events between two checks for interruption.
const EVENTS_PER_CHECK: usize = 1 << 14;

/// What a program prints, from the first to the last extrusion move of the part.
///
/// Start and end sequences do not count: everything before the first and after the last extrusion
/// move of a layer whose feature is part of the printed object.
/// Skirts, supports and prime towers are not part of it: neither their beads nor the length of
/// these count, but their time and the travel to and from them do.
///
/// A **bead** is a maximal run of extrusion moves with one tool and without travel of more than
/// 0.01 mm between them.
/// A bead may continue from a wall to the infill; retraction in place does not end it.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct BeadCounts {
    /// Layers with an extrusion move, by the slicer's comments, or by z if no comment marks a
    /// layer.
    pub(super) layers: usize,
    /// All beads: the sum of the following five counts.
    pub(super) beads: usize,
    /// Beads of walls only, thin ones included.
    pub(super) walls: usize,
    /// Beads of sparse and solid infill only.
    pub(super) infill: usize,
    /// Beads of gap fill only.
    pub(super) gap_fill: usize,
    /// Beads of other features only, and of programs without comments.
    pub(super) other: usize,
    /// Beads that continue from one of these groups to another.
    pub(super) joined: usize,
    /// Breaks between two beads of one layer that one tool prints one after the other.
    pub(super) lifts: usize,
    pub(super) tool_changes: usize,
    /// Distance that the nozzle moves without printing the part, vertical moves included.
    pub(super) travel_mm: f64,
    /// Retractions, each with its wipe; those of the firmware (`G10`) included.
    pub(super) retractions: usize,
    /// Extrusion moves of the part; an arc counts as its chords.
    pub(super) extrusion_moves: usize,
    /// Distance that the nozzle moves while it prints the part.
    pub(super) extrusion_mm: f64,
    /// Minimum and maximum x and y of these moves; `None` if there are none.
    pub(super) bounds_mm: Option<[[f64; 2]; 2]>,
    /// Filament of these moves.
    pub(super) filament_mm3: f64,
    /// Printing time, see [`Stopwatch`].
    pub(super) print_seconds: f64,
}

/// The groups of features that counts distinguish.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Group {
    Walls,
    Infill,
    GapFill,
    Other,
}

impl Group {
    /// The group of a feature; `None` if it is not part of the printed object.
    fn of(feature: Feature) -> Option<Self> {
        match feature {
            Feature::OuterWall | Feature::InnerWall | Feature::ThinWall => Some(Self::Walls),
            Feature::Infill | Feature::SolidInfill => Some(Self::Infill),
            Feature::GapFill => Some(Self::GapFill),
            Feature::Custom | Feature::Skirt | Feature::Support | Feature::PrimeTower => None,
            _ => Some(Self::Other),
        }
    }
}

/// The bead to which the next extrusion move may belong.
struct OpenBead {
    /// Its group; `None` if it has several.
    group: Option<Group>,
    tool: u8,
    /// Layer by comments, and z as bits.
    layer: (Option<u32>, u64),
}

/// Counts that are not yet known to belong to the print: those since the last bead.
#[derive(Default)]
struct Pending {
    travel_mm: f64,
    /// Travel, and extrusion moves that are not part of the printed object.
    gap_mm: f64,
    retractions: usize,
    tool_changes: usize,
}

/// The part of a program that prints: from the first to the last extrusion move of the part.
struct Span {
    /// Numbers of its events.
    events: RangeInclusive<usize>,
    /// Indices of its lines.
    lines: RangeInclusive<usize>,
    /// Whether comments mark the layers.
    has_layers: bool,
}

/// State of a count that events are added to.
#[derive(Default)]
struct Counter {
    has_layers: bool,
    counts: BeadCounts,
    open: Option<OpenBead>,
    pending: Pending,
    /// Layers by comments, and heights as bits.
    layers: Vec<(Option<u32>, u64)>,
    is_retracted: bool,
}

impl BeadCounts {
    /// Counts a program for a printer with these limits, and one filament for all tools.
    ///
    /// Linear in lines and chords of arcs.
    pub(super) fn measure(
        program: &Program,
        limits: MotionLimits,
        filament: Filament,
        control: &Control<'_>,
    ) -> Result<Self, TraceError> {
        let Some(Span { events, lines, has_layers }) = Span::of(program, control)? else {
            return Ok(Self::default());
        };
        let mut counter = Counter { has_layers, ..Counter::default() };
        let mut stopwatch = Stopwatch::new(limits);
        let count = events.end() - events.start() + 1;
        for (number, event) in program.trace().skip(*events.start()).take(count).enumerate() {
            if number % EVENTS_PER_CHECK == 0 {
                control.check()?;
            }
            let event = event?;
            stopwatch.add(&event);
            counter.add(&event);
        }
        let Counter { mut counts, mut layers, .. } = counter;
        layers.sort_unstable();
        layers.dedup();
        counts.layers = layers.len();
        let is_retraction = |line: &&Line| matches!(line.command(), Some(Command::Retract));
        counts.retractions += program.lines[lines].iter().filter(is_retraction).count();
        counts.filament_mm3 *= filament.area_mm2();
        counts.print_seconds = stopwatch.seconds();
        Ok(counts)
    }

    /// The count of beads of one group, or of several.
    fn of(&mut self, group: Option<Group>) -> &mut usize {
        match group {
            Some(Group::Walls) => &mut self.walls,
            Some(Group::Infill) => &mut self.infill,
            Some(Group::GapFill) => &mut self.gap_fill,
            Some(Group::Other) => &mut self.other,
            None => &mut self.joined,
        }
    }
}

impl Span {
    /// Finds the span; `None` if the program prints no part.
    fn of(program: &Program, control: &Control<'_>) -> Result<Option<Self>, TraceError> {
        let mut spans: [Option<Self>; 2] = [None, None];
        for (number, event) in program.trace().enumerate() {
            if number % EVENTS_PER_CHECK == 0 {
                control.check()?;
            }
            let Event::Motion(motion) = event? else { continue };
            for (has_layers, span) in [false, true].into_iter().zip(&mut spans) {
                if part_group(&motion, has_layers).is_some() {
                    let span = span.get_or_insert(Self {
                        events: number..=number,
                        lines: motion.line - 1..=motion.line - 1,
                        has_layers,
                    });
                    span.events = *span.events.start()..=number;
                    span.lines = *span.lines.start()..=motion.line - 1;
                }
            }
        }
        let [without_layers, with_layers] = spans;
        Ok(with_layers.or(without_layers))
    }
}

impl Counter {
    fn add(&mut self, event: &Event) {
        match event {
            Event::Motion(motion) => self.add_motion(motion),
            Event::ToolChange { from, .. } => {
                self.pending.tool_changes += usize::from(from.is_some());
            }
            _ => {}
        }
    }

    fn add_motion(&mut self, motion: &Motion) {
        self.pending.retractions += usize::from(self.follow_filament(motion));
        let Some(group) = part_group(motion, self.has_layers) else {
            self.pending.gap_mm += motion.length_mm();
            if !motion.is_extrusion() {
                self.pending.travel_mm += motion.length_mm();
            }
            return;
        };
        let height = if self.has_layers { 0 } else { motion.to_mm[2].to_bits() };
        let layer = (motion.layer, height);
        if self.layers.last() != Some(&layer) {
            self.layers.push(layer);
        }
        let pending = std::mem::take(&mut self.pending);
        self.counts.travel_mm += pending.travel_mm;
        self.counts.retractions += pending.retractions;
        self.counts.tool_changes += pending.tool_changes;
        self.counts.extrusion_moves += 1;
        self.counts.extrusion_mm += motion.length_mm();
        for [x, y, _] in [motion.from_mm, motion.to_mm] {
            let [min, max] = self.counts.bounds_mm.get_or_insert([[x, y]; 2]);
            *min = [min[0].min(x), min[1].min(y)];
            *max = [max[0].max(x), max[1].max(y)];
        }
        // In mm until the end of the count.
        self.counts.filament_mm3 += motion.extruded_mm;
        match &mut self.open {
            Some(open) if pending.gap_mm <= MAX_GAP_MM && open.tool == motion.tool => {
                if open.group.is_some_and(|before| before != group) {
                    *self.counts.of(open.group) -= 1;
                    self.counts.joined += 1;
                    open.group = None;
                }
                open.layer = layer;
            }
            open => {
                self.counts.beads += 1;
                *self.counts.of(Some(group)) += 1;
                let is_lift = open
                    .as_ref()
                    .is_some_and(|open| open.layer == layer && open.tool == motion.tool);
                self.counts.lifts += usize::from(is_lift);
                *open = Some(OpenBead { group: Some(group), tool: motion.tool, layer });
            }
        }
    }

    /// Whether a motion begins a retraction.
    fn follow_filament(&mut self, motion: &Motion) -> bool {
        let begins = motion.extruded_mm < 0.0 && !self.is_retracted;
        if motion.extruded_mm.abs() > 0.0 {
            self.is_retracted = motion.extruded_mm < 0.0;
        }
        begins
    }
}

/// The group of a motion that prints the part; `None` for other motions.
///
/// In a program whose comments mark layers, motions before the first one are its start sequence.
fn part_group(motion: &Motion, has_layers: bool) -> Option<Group> {
    let is_in_layer = motion.layer.is_some() || !has_layers;
    (motion.is_extrusion() && is_in_layer).then(|| Group::of(motion.feature)).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: MotionLimits =
        MotionLimits { acceleration_mm_s2: 1000.0, square_corner_mm_s: 5.0, max_speed_mm_s: 200.0 };
    const FILAMENT: Filament = Filament { diameter_mm: 1.75, density_g_cm3: 1.24 };

    fn counted(text: &str) -> BeadCounts {
        let control = Control::default();
        let program = Program::parse(text, &control).expect("the text is valid");
        BeadCounts::measure(&program, LIMITS, FILAMENT, &control).expect("the program is valid")
    }

    const START: &str = "G90\nM83\nG1 X0 Y0 Z0.2 F6000\n;TYPE:Custom\nG1 X50 E5\nG1 E-1\n";
    const END: &str = "G1 E-1\n;TYPE:Custom\nG1 X0 Y0\nG1 X50 E5\n";

    /// A wall that continues into infill, a lift, infill, and a gap in the next layer.
    #[test]
    fn beads_are_sorted_by_group() {
        let text = format!(
            "{START};LAYER_CHANGE\nG1 X0\nG1 E1\n;TYPE:Perimeter\nG1 X10 E1\nG1 Y10 E1\n\
             ;TYPE:Solid infill\nG1 X10.005\nG1 X0 E1\nG1 E-.5\nG1 X1 E-.5\nG1 X5 Y0\nG1 E1\n\
             G1 X20 E1.5\nG1 E-1\nG1 E1\nG1 X25 E.5\n;LAYER_CHANGE\nG1 Z.4\n;TYPE:Gap fill\n\
             G1 X30 E.25\n;TYPE:Skirt\nG1 X40 E1\n;TYPE:Gap fill\nG1 X45 E.25\nT1\nG1 X50 E.25\n\
             {END}"
        );
        let counts = counted(&text);
        assert_eq!([counts.layers, counts.beads, counts.lifts], [2, 5, 2]);
        assert_eq!([counts.walls, counts.infill, counts.gap_fill], [0, 1, 3]);
        assert_eq!([counts.other, counts.joined], [0, 1]);
        // A wipe is one retraction; one in place does not end a bead.
        assert_eq!([counts.retractions, counts.tool_changes], [2, 1]);
        let travel = 0.005 + 1.0 + 4.0_f64.hypot(10.0) + 0.2;
        assert!((counts.travel_mm - travel).abs() < 1e-9, "{}", counts.travel_mm);
        assert!((counts.extrusion_mm - 65.005).abs() < 1e-9, "{}", counts.extrusion_mm);
        assert!((counts.filament_mm3 / FILAMENT.area_mm2() - 5.75).abs() < 1e-9);
        assert_eq!(counts.extrusion_moves, 8);
        assert_eq!(counts.bounds_mm, Some([[0.0, 0.0], [50.0, 10.0]]));
    }

    #[test]
    fn layers_without_comments_are_heights() {
        let counts = counted(
            "M83\nG1 X5 Z.2 F600\nG1 X9 E1\nG1 Z.4\nG1 X5 E1\nG1 Z.6\nG10\nG1 X9\nG11\nG1 X5 E1",
        );
        assert_eq!([counts.layers, counts.beads, counts.other, counts.lifts], [3, 3, 3, 0]);
        assert_eq!(counts.retractions, 1);
        assert_eq!(counted("G1 X5 F600\n"), BeadCounts::default());
    }

    /// The time of a print does not depend on its start and end sequences.
    #[test]
    fn time_is_that_of_the_print() {
        let text = ";LAYER_CHANGE\n;TYPE:Perimeter\nG1 X10 E1\nG1 Y10 E1\n";
        let within = counted(&format!("M83\nG1 F6000\n{text}"));
        let whole = counted(&format!("{START}G1 X0\n{text}{END}"));
        assert!((within.print_seconds - whole.print_seconds).abs() < 1e-9);
        assert!(within.print_seconds > 0.2);
    }
}
