//! Checks that all printers interpret the extrusion modes alike.

use beadwork_gcode::{Command, LinearMove, Program};

use super::error::CheckError;

/// Refuses extrusion that is absolute for Marlin and relative for Klipper, or the reverse.
///
/// Marlin has one extrusion mode: `G90` and `G91` set it together with the position mode, `M82` and
/// `M83` set it alone.
/// Klipper has a mode for positions (`G90`, `G91`) and one for extrusion (`M82`, `M83`), and
/// extrusion is relative if either of them is.
pub(super) fn check(program: &Program) -> Result<(), CheckError> {
    // Whether each mode is relative.
    let (mut positions, mut klipper, mut marlin) = (false, false, false);
    for (line, command) in (1..).zip(program.lines.iter().map(|line| line.command())) {
        match command {
            Some(Command::AbsolutePositioning) => (positions, marlin) = (false, false),
            Some(Command::RelativePositioning) => (positions, marlin) = (true, true),
            Some(Command::AbsoluteExtrusion) => (klipper, marlin) = (false, false),
            Some(Command::RelativeExtrusion) => (klipper, marlin) = (true, true),
            Some(Command::Move(LinearMove { e: Some(_), .. }))
                if (positions || klipper) != marlin =>
            {
                return Err(CheckError::AmbiguousExtrusion { line });
            }
            Some(Command::Arc(arc)) if arc.e.is_some() && (positions || klipper) != marlin => {
                return Err(CheckError::AmbiguousExtrusion { line });
            }
            _ => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_whose_order_matters() {
        for (text, expected) in [
            ("G90\nM83\nG1 E1", None),
            ("M83\nG90\nG1 X1\nG1 E1", Some(4)),
            ("M83\nG90\nM83\nG1 E1", None),
            ("M83\nG90\nM82\nG1 E1", None),
            ("M82\nG91\nG1 E-2 F2700\nG90\nG1 E1", None),
            ("G91\nM82\nG2 X1 R5 E1", Some(3)),
            ("M83\nG91\nG1 E1\nG90\nG3 X1 R5", None),
        ] {
            let expected =
                expected.map_or(Ok(()), |line| Err(CheckError::AmbiguousExtrusion { line }));
            assert_eq!(check(&text.parse().unwrap()), expected, "{text}");
        }
    }
}
