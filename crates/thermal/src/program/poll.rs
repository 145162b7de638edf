//! Interruption and progress of a pass over a program.

use beadwork_base::{Control, Interrupted};
use beadwork_gcode::Event;

/// Events of a program between two polls of the control: some 100 µs of work.
const EVENTS_PER_POLL: usize = 1 << 10;

/// Polls a control during a pass over a program, and reports the lines that are done.
pub(super) struct Poll<'a> {
    control: &'a Control<'a>,
    /// Lines of earlier passes.
    before: usize,
    /// Lines of all passes.
    total: usize,
    events: usize,
}

impl<'a> Poll<'a> {
    pub(super) fn new(control: &'a Control<'a>, before: usize, total: usize) -> Self {
        Self { control, before, total, events: 0 }
    }

    /// Counts an event; returns an error if the call should end.
    pub(super) fn count(&mut self, event: &Event) -> Result<(), Interrupted> {
        self.events += 1;
        if !self.events.is_multiple_of(EVENTS_PER_POLL) {
            return Ok(());
        }
        if let Event::Motion(motion) = event {
            self.control.report(self.before + motion.line - 1, self.total);
        }
        self.control.check()
    }
}
