//! Sleep of resting islands: trees of joints that touch or are tied to each other, and have hardly moved for a while, stay where they are at no cost.
//!
//! | file | what |
//! |---|---|
//! | `record` | what a [state](super::State) says of it, in numbers |
//! | `trees` | trees of joints, those that never sleep, and those that constraints tie to each other |
//! | `sleeper` | a step: who sleeps in it, and who falls asleep after it |
//! | `wake` | sleeping bodies that others reach within a step |

mod record;
mod sleeper;
mod trees;
mod wake;

use super::simulator::Simulator;
use super::state::State;
pub(super) use sleeper::Sleeper;
use trees::Trees;

impl Simulator {
    /// The names of the links that sleep in a state, in the order of [`link_names`](crate::Model::link_names); empty without
    /// [`Sleeping`](super::Sleeping). Bodies that the next step wakes
    /// because something reaches them are among them. Allocates.
    ///
    /// # Panics
    /// If the state has the wrong length.
    pub fn asleep(&self, state: &State) -> Vec<&str> {
        self.check(state);
        if self.sleeping().is_none() {
            return Vec::new();
        }
        let trees = Trees::new(self);
        let mut asleep = Vec::new();
        trees.asleep_into(state, &mut asleep);
        let links = self.model().link_names().into_iter().filter(|name| {
            let frame = self.model().frame(name);
            let body = frame.and_then(|frame| self.model().frame_of(frame).body);
            body.and_then(|body| trees.of_body(body))
                .is_some_and(|tree| asleep[tree])
        });
        links.collect()
    }
}
