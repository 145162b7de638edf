//! Programs of beads pass; programs with a fault in a random position are refused.

use beadwork_gcode::{Command, Event, Feature, Motion, Number, Program};
use proptest::prelude::*;

use super::bead_cases::{Case, cases};
use super::*;
use crate::Bead;

/// The motions that extrude into the part.
fn part_motions(program: &Program) -> Vec<Motion> {
    let motion = |event| match event {
        Ok(Event::Motion(motion))
            if motion.is_extrusion() && motion.feature != Feature::PrimeTower =>
        {
            Some(motion)
        }
        _ => None,
    };
    program.trace().filter_map(motion).collect()
}

/// Index of the line of one of the motions that extrude into the part.
fn part_line(program: &Program, at: prop::sample::Index) -> usize {
    let motions = part_motions(program);
    motions[at.index(motions.len())].line - 1
}

/// The letter and the value of each word of a line that is a move.
fn words(line: &str) -> Vec<(char, f64)> {
    let words = line.strip_prefix("G1 ").map(|words| words.split(' ')).into_iter().flatten();
    words.map(|word| (word.as_bytes()[0] as char, word[1..].parse().unwrap())).collect()
}

fn value(words: &[(char, f64)], letter: char) -> Option<f64> {
    words.iter().find(|word| word.0 == letter).map(|word| word.1)
}

/// Whether another value of a word must be noticed; `change` is the difference.
///
/// Not noticed are: heights that differ by 0.001 mm; lower speeds and speeds of other moves than
/// those that print the part; z-hops; positions above which a tool change takes place; the shape of
/// the prime tower; the length of wipes; and changes of filament that are not more than rounding.
fn must_be_noticed(lines: &[&str], at: usize, letter: char, change: f64) -> bool {
    let here = words(lines[at]);
    let feature = lines[..at].iter().rev().find(|line| line.starts_with(";TYPE:"));
    let is_tower = |feature: Option<&&str>| feature.is_none_or(|line| line.contains("tower"));
    let e = value(&here, 'E');
    let moves = value(&here, 'X').or(value(&here, 'Y')).is_some();
    // The lines up to the next one that extrudes, and the feature there.
    let next = (at + 1..lines.len()).find(|&line| {
        let words = words(lines[line]);
        value(&words, 'E').is_some_and(|e| e > 0.0)
            && value(&words, 'X').or(value(&words, 'Y')).is_some()
    });
    let Some(next) = next.filter(|_| !is_tower(feature) || e.is_none_or(|e| e <= 0.0) || !moves)
    else {
        // Nothing follows, or the line prints the tower: only the last lines of the part count.
        return !is_tower(feature)
            && moves
            && e.is_some_and(|e| e > 0.0)
            && match letter {
                'F' => change > 0.1,
                'E' => change.abs() > 1.5e-5,
                _ => true,
            };
    };
    let next_feature = lines[..next].iter().rev().find(|line| line.starts_with(";TYPE:"));
    let between = &lines[at + 1..next];
    let is_overwritten =
        between.iter().any(|line| line.starts_with('T') || value(&words(line), letter).is_some());
    match (letter, e) {
        ('F', Some(e)) if e > 0.0 && moves => change > 0.1,
        ('F', _) => false,
        ('E', Some(e)) if e > 0.0 && moves => change.abs() > 1.5e-5,
        ('E', _) => change.abs() > 5e-5,
        ('Z', _) => !is_overwritten && change.abs() > 0.002,
        (_, Some(e)) if e > 0.0 => true,
        (_, Some(_)) => false,
        (_, None) => !is_overwritten && !is_tower(next_feature),
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 600,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn written_beads_pass(case in cases()) {
        let print = case.print();
        let report = case.check(&print.program);
        prop_assert!(report.is_ok(), "{report:?}\n{}", print.program.emit());
        let report = report.unwrap();
        prop_assert_eq!(report.layers, case.layers.len());
        prop_assert_eq!(report.dropped_beads, print.dropped_beads);
        let beads = case.layers.iter().flat_map(|layer| &layer.beads);
        prop_assert_eq!(report.beads, beads.clone().count() - report.dropped_beads);
        prop_assert!(report.beads >= beads.clone().filter(|bead| bead.length_mm() > 0.1).count());
        prop_assert_eq!(report.tool_changes, print.totals.tool_changes);
        prop_assert_eq!(report.motions, part_motions(&print.program).len());
        // Rounding and merging lose nothing but beads without length.
        let section_mm2 = |width| case.settings.process.section_mm2(width, case.frame.layer_mm);
        let expected_mm3: f64 = beads
            .clone()
            .flat_map(Bead::lines)
            .map(|([a, b], [c, d], width)| (c - a).hypot(d - b) * section_mm2(width))
            .sum();
        let lost_mm3 = report.dropped_beads as f64 * 0.02 * section_mm2(0.9) + 1e-4;
        prop_assert!((report.part_mm3 - expected_mm3).abs() < lost_mm3);
        let area_mm2: f64 = beads.map(Bead::area_mm2).sum();
        let filled_mm2: f64 = report.fill.iter().map(|fill| fill.extruded_mm2).sum();
        prop_assert!((area_mm2 - filled_mm2).abs() < report.dropped_beads as f64 * 0.02 + 1e-9);
        let outlines = case.outlines.iter().flatten();
        let outline_mm2: f64 = outlines.map(|(_, area)| area.size_mm2()).sum();
        let sum_mm2: f64 = report.fill.iter().map(|fill| fill.outline_mm2).sum();
        prop_assert!((outline_mm2 - sum_mm2).abs() < 1e-9 * outline_mm2);
        let [low, high] = [report.lowest_fill, report.highest_fill]
            .map(|fill| fill.unwrap().areas.ratio().unwrap());
        prop_assert!(low <= high && high < 40.0);
    }

    /// One digit is changed.
    #[test]
    fn a_changed_number_is_found(
        case in cases(),
        at: prop::sample::Index,
        word: prop::sample::Index,
        digit: prop::sample::Index,
        to in b'0'..=b'9',
    ) {
        let text = case.print().program.emit();
        let lines: Vec<_> = text.lines().collect();
        let moves: Vec<_> = (0..lines.len()).filter(|&at| lines[at].starts_with("G1 ")).collect();
        let at = moves[at.index(moves.len())];
        let words_here = words(lines[at]);
        let (letter, before) = words_here[word.index(words_here.len())];
        let begin = lines[at].find(letter).unwrap() + 1;
        let end = lines[at][begin..].find(' ').map_or(lines[at].len(), |length| begin + length);
        let mut bytes = lines[at].as_bytes().to_vec();
        let digits: Vec<_> = (begin..end).filter(|&byte| bytes[byte].is_ascii_digit()).collect();
        bytes[digits[digit.index(digits.len())]] = to;
        let line = String::from_utf8(bytes).unwrap();
        let after: f64 = line[begin..end].parse().unwrap();
        let mut changed: Vec<_> = lines.clone();
        changed[at] = &line;
        let is_found = case.check_text(&changed.join("\n")).is_err();
        if must_be_noticed(&lines, at, letter, after - before) && after != before {
            prop_assert!(is_found, "line {}: {} -> {line}\n{text}", at + 1, lines[at]);
        }
    }

    #[test]
    fn a_missing_or_repeated_or_swapped_line_is_found(
        case in cases(),
        at: prop::sample::Index,
        change in 0..3,
    ) {
        let mut program = case.print().program;
        let at = part_line(&program, at);
        match change {
            0 => _ = program.lines.remove(at),
            1 => {
                // The shortest moves extrude as little as rounding may.
                let here = part_motions(&program).into_iter().find(|motion| motion.line - 1 == at);
                prop_assume!(here.unwrap().extruded_mm > 5e-5);
                program.lines.insert(at, program.lines[at].clone());
            }
            _ => {
                let motions = part_motions(&program);
                let here = motions.iter().position(|motion| motion.line - 1 == at).unwrap();
                prop_assume!(here + 1 < motions.len());
                let next = &motions[here + 1];
                prop_assume!(motions[here].to_mm != next.to_mm);
                program.lines.swap(at, next.line - 1);
            }
        }
        prop_assert!(case.check(&program).is_err());
    }

    #[test]
    fn a_wrong_or_missing_tool_is_found(case in cases(), at: prop::sample::Index, to in 0_u8..4) {
        let mut program = case.print().program;
        let tools: Vec<_> = (0..program.lines.len())
            .filter(|&at| matches!(program.lines[at].command(), Some(Command::Tool(_))))
            .collect();
        let at = tools[at.index(tools.len())];
        prop_assume!(program.lines[at].command() != Some(&Command::Tool(to)));
        program.lines[at] = Command::Tool(to).into();
        prop_assert!(case.check(&program).is_err());
    }

    #[test]
    fn missing_retraction_is_found(case in cases(), at: prop::sample::Index) {
        let mut program = case.print().program;
        let last = part_motions(&program).last().unwrap().line;
        let retracts = |at: &usize| match program.lines[*at].command() {
            Some(Command::Move(step)) => {
                step.e.is_some_and(|e| e < Number::ZERO)
                    || (step.e.is_some() && step.x.or(step.y).is_none())
            }
            _ => false,
        };
        let lines: Vec<_> = (0..last).filter(retracts).collect();
        prop_assume!(!lines.is_empty());
        program.lines.remove(lines[at.index(lines.len())]);
        prop_assert!(case.check(&program).is_err());
    }

    #[test]
    fn beads_outside_the_outline_are_found(case in cases(), by in 0.06..0.4_f64) {
        // The wall along the outline leaves it if the outline shrinks by more than the tolerance.
        let program = case.print().program;
        let mut case: Case = case;
        let width_mm = case.layers[0].beads.iter().flat_map(|bead| &bead.moves);
        let width_mm = width_mm.map(|step| step.width_mm).fold(0.0, f64::max);
        let number = case.outlines.len() - 1;
        for (_, area) in &mut case.outlines[number] {
            *area = area.offset(-by * width_mm - 0.006);
        }
        let error = case.check(&program).unwrap_err();
        let is_named =
            matches!(error, CheckError::OutsideOutline { layer, .. } if layer == number);
        prop_assert!(is_named, "{error}");
        // A larger tolerance allows it.
        case.limits.outside = by + 0.05;
        case.limits.outside_skeleton = case.limits.outside;
        prop_assert!(case.check(&program).is_ok());
    }
}
