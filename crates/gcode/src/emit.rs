//! Writes programs as text.

use std::fmt;

use crate::command::{Arc, Command, LinearMove, Wait};
use crate::number::Number;
use crate::program::{Line, Program};
use crate::words::{ACCELERATION, SQUARE_CORNER_VELOCITY, VELOCITY, VELOCITY_LIMIT};

impl Program {
    /// Returns the text of the file: upper case, one blank between words, the shortest spelling of
    /// each number, a line feed after every line.
    /// Linear in the length of the text.
    pub fn emit(&self) -> String {
        /// Bytes of a typical extrusion move.
        const TYPICAL_LINE: usize = 28;
        let mut text = String::with_capacity(TYPICAL_LINE * self.lines.len());
        for line in &self.lines {
            push_line(&mut text, line);
            text.push('\n');
        }
        text
    }
}

impl fmt::Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = String::new();
        push_line(&mut text, self);
        f.write_str(&text)
    }
}

fn push_line(out: &mut String, line: &Line) {
    if let Some(command) = line.command() {
        push_command(out, command);
    }
    if let Some(comment) = line.comment() {
        if line.command().is_some() {
            out.push(' ');
        }
        out.push(';');
        out.push_str(comment);
    }
}

fn push_command(out: &mut String, command: &Command) {
    match *command {
        Command::Move(LinearMove { rapid, x, y, z, e, f }) => {
            out.push_str(if rapid { "G0" } else { "G1" });
            push_words(out, [('X', x), ('Y', y), ('Z', z), ('E', e), ('F', f)]);
        }
        Command::Arc(ref arc) => {
            let Arc { clockwise, x, y, z, i, j, r, e, f } = **arc;
            out.push_str(if clockwise { "G2" } else { "G3" });
            push_words(out, [('X', x), ('Y', y), ('Z', z), ('I', i), ('J', j), ('R', r)]);
            push_words(out, [('E', e), ('F', f)]);
        }
        Command::Dwell { seconds, milliseconds } => {
            out.push_str("G4");
            push_words(out, [('S', seconds), ('P', milliseconds)]);
        }
        Command::Home { x, y, z } => {
            out.push_str("G28");
            for (word, is_named) in [(" X", x), (" Y", y), (" Z", z)] {
                if is_named {
                    out.push_str(word);
                }
            }
        }
        Command::SetPosition { x, y, z, e } => {
            out.push_str("G92");
            push_words(out, [('X', x), ('Y', y), ('Z', z), ('E', e)]);
        }
        Command::AbsolutePositioning => out.push_str("G90"),
        Command::RelativePositioning => out.push_str("G91"),
        Command::AbsoluteExtrusion => out.push_str("M82"),
        Command::RelativeExtrusion => out.push_str("M83"),
        Command::Retract => out.push_str("G10"),
        Command::Unretract => out.push_str("G11"),
        Command::Tool(tool) => {
            out.push('T');
            push_tool(out, tool);
        }
        Command::NozzleTemperature { celsius, tool, wait } => {
            out.push_str(if wait == Wait::No { "M104" } else { "M109" });
            if let Some(tool) = tool {
                out.push_str(" T");
                push_tool(out, tool);
            }
            let letter = if wait == Wait::HeatingOrCooling { 'R' } else { 'S' };
            push_words(out, [(letter, Some(celsius))]);
        }
        Command::BedTemperature { celsius, wait } => {
            out.push_str(if wait { "M190" } else { "M140" });
            push_words(out, [('S', Some(celsius))]);
        }
        Command::Fan(None) => out.push_str("M107"),
        Command::Fan(speed) => {
            out.push_str("M106");
            push_words(out, [('S', speed)]);
        }
        Command::Acceleration { print, travel, retract, all } => {
            out.push_str("M204");
            push_words(out, [('P', print), ('R', retract), ('T', travel), ('S', all)]);
        }
        Command::VelocityLimit { velocity, acceleration, square_corner } => {
            out.push_str(VELOCITY_LIMIT);
            let named = [
                (VELOCITY, velocity),
                (ACCELERATION, acceleration),
                (SQUARE_CORNER_VELOCITY, square_corner),
            ];
            for (name, value) in named {
                if let Some(value) = value {
                    out.extend([" ", name, "="]);
                    value.push_to(out);
                }
            }
        }
        Command::Jerk { x, y, z, e, junction_deviation } => {
            out.push_str("M205");
            push_words(out, [('X', x), ('Y', y), ('Z', z), ('E', e), ('J', junction_deviation)]);
        }
        Command::Progress { percent, minutes } => {
            out.push_str("M73");
            push_words(out, [('P', percent), ('R', minutes)]);
        }
        Command::Other(ref text) => out.push_str(text.as_str()),
    }
}

fn push_words<const N: usize>(out: &mut String, words: [(char, Option<Number>); N]) {
    for (letter, value) in words {
        if let Some(value) = value {
            out.push(' ');
            out.push(letter);
            value.push_to(out);
        }
    }
}

fn push_tool(out: &mut String, tool: u8) {
    Number::whole(i32::from(tool)).push_to(out);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_commands_and_comments() {
        let home = || Some(Command::Home { x: true, y: false, z: true });
        let lines = vec![
            Line::new(home(), Some(" twice".to_owned())).unwrap(),
            Line::from(Command::Move(LinearMove { rapid: true, ..LinearMove::default() })),
            Line::new(None, Some(String::new())).unwrap(),
            Line::default(),
        ];
        assert_eq!(lines[0].to_string(), "G28 X Z ; twice");
        assert_eq!(Program { lines }.emit(), "G28 X Z ; twice\nG0\n;\n\n");
    }
}
