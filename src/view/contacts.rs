//! Contacts in a recorded motion.

use super::motion::kept;
use super::recording::Recording;
use super::touches::{Touches, of_report};
use super::track::Track;
use crate::sim::Simulator;

impl Recording {
    /// Draws the contact points and contact forces of the first robot: those of the simulator at the recorded states and inputs, at up to 60 times
    /// per second. Times that are recorded later keep the last contacts.
    ///
    /// # Panics
    /// If the simulator is one of another robot.
    pub(crate) fn show_contacts(&mut self, simulator: &Simulator) -> &mut Self {
        let track = &mut self.robots[0];
        assert!(
            track.model.structure() == simulator.model().structure(),
            "the contacts are those of \"{}\", another robot than \"{}\"",
            simulator.model().name(),
            track.model.name()
        );
        track.touches = find(track, &self.times, simulator);
        self
    }
}

/// Finds the contacts of a robot at the times that the viewer can show, under the recorded inputs. Times with unknown values are skipped.
fn find(track: &Track, times: &[f64], simulator: &Simulator) -> Vec<Touches> {
    // Of one byte a moment the rate alone decides.
    let moments = kept(times, 1).into_iter();
    let known = moments.filter(|&k| {
        let numbers = track.q(k).iter().chain(track.v(k)).chain(track.u(k));
        track.u(k).len() == simulator.nu() && numbers.into_iter().all(|x| x.is_finite())
    });
    let report = |k| simulator.contact_report(&track.state(k), track.u(k));
    let found = known.map(|moment| Touches {
        moment,
        points: of_report(&report(moment)),
    });
    found.collect()
}
