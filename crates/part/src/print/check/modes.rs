//! Whether all printers take the lengths of filament for the same.

use beadwork_gcode::{Command, Move, Program};

use super::CheckError;

/// Refuses filament that Marlin and Klipper would count differently.
///
/// In Marlin `G90` and `G91` count filament as they count places, until `M82` or `M83` says
/// otherwise; in Klipper `G91` does, until `G90`, and `M83` holds until `M82`.
pub(super) fn check(program: &Program) -> Result<(), CheckError> {
    let (mut places, mut klipper, mut marlin) = (false, false, false);
    for (line, command) in (1..).zip(program.lines.iter().map(|line| line.command())) {
        match command {
            Some(Command::AbsolutePositioning) => (places, marlin) = (false, false),
            Some(Command::RelativePositioning) => (places, marlin) = (true, true),
            Some(Command::AbsoluteExtrusion) => (klipper, marlin) = (false, false),
            Some(Command::RelativeExtrusion) => (klipper, marlin) = (true, true),
            Some(Command::Move(Move { e: Some(_), .. })) if (places || klipper) != marlin => {
                return Err(CheckError::Ambiguous { line });
            }
            Some(Command::Arc(arc)) if arc.e.is_some() && (places || klipper) != marlin => {
                return Err(CheckError::Ambiguous { line });
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
    fn orders_of_the_modes() {
        for (text, expected) in [
            ("G90\nM83\nG1 E1", None),
            ("M83\nG90\nG1 X1\nG1 E1", Some(4)),
            ("M83\nG90\nM83\nG1 E1", None),
            ("M83\nG90\nM82\nG1 E1", None),
            ("M82\nG91\nG1 E-2 F2700\nG90\nG1 E1", None),
            ("G91\nM82\nG2 X1 R5 E1", Some(3)),
            ("M83\nG91\nG1 E1\nG90\nG3 X1 R5", None),
        ] {
            let expected = expected.map_or(Ok(()), |line| Err(CheckError::Ambiguous { line }));
            assert_eq!(check(&text.parse().unwrap()), expected, "{text}");
        }
    }
}
