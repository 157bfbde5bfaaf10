//! Options of a run.

use crate::input::Kind;

/// Default number of cases: as many as the tests of the project have time for.
const DEFAULT_EXECUTIONS: u64 = 8_000;

/// Default seed; with the index it makes a case.
const DEFAULT_SEED: u64 = 1;

/// A run, or the part of one that a process does.
#[derive(Clone, Debug)]
pub(crate) struct Options {
    pub(crate) role: Role,
    pub(crate) executions: u64,
    pub(crate) jobs: u64,
    pub(crate) seed: u64,
    pub(crate) kinds: Vec<Kind>,
    /// The first case, and how far it is from one case to the next.
    pub(crate) from: u64,
    pub(crate) step: u64,
}

/// Role of a process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Role {
    /// Starts others and watches them.
    Parent,
    /// Runs cases.
    Child,
    /// Runs one case, in sight.
    Replay,
    /// Has nothing to do, since another test was selected.
    Idle,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            role: Role::Parent,
            executions: DEFAULT_EXECUTIONS,
            jobs: 1,
            seed: DEFAULT_SEED,
            kinds: Kind::ALL.to_vec(),
            from: 0,
            step: 1,
        }
    }
}

impl Options {
    /// From the command line; unknown options are for the harness of other tests.
    pub(crate) fn of(mut arguments: impl Iterator<Item = String>) -> Self {
        let mut out = Self::default();
        while let Some(argument) = arguments.next() {
            let mut number = || {
                let text = arguments.next().unwrap_or_default();
                let number = text.parse();
                number.unwrap_or_else(|_| panic!("{argument} takes a number, not \"{text}\""))
            };
            match argument.as_str() {
                "--child" => out.role = Role::Child,
                "--replay" => (out.role, out.from) = (Role::Replay, number()),
                "--executions" => out.executions = number(),
                "--jobs" => out.jobs = number().max(1),
                "--seed" => out.seed = number(),
                "--from" => out.from = number(),
                "--step" => out.step = number(),
                "--kinds" => out.kinds = Kind::listed(&arguments.next().unwrap_or_default()),
                "--list" => out.role = Role::Idle,
                name if !name.starts_with('-') && !"fuzz".contains(name) => out.role = Role::Idle,
                _ => {}
            }
        }
        out
    }

    /// The command line of a child that goes on at a case.
    pub(crate) fn for_child(&self, from: u64) -> Vec<String> {
        let kinds: Vec<_> = self.kinds.iter().map(|kind| kind.name()).collect();
        let numbers = [
            ("--executions", self.executions),
            ("--seed", self.seed),
            ("--from", from),
            ("--step", self.jobs),
        ];
        let numbers = numbers.map(|(name, number)| [name.to_owned(), number.to_string()]);
        let mut out = vec!["--child".to_owned(), "--kinds".to_owned(), kinds.join(",")];
        out.extend(numbers.into_iter().flatten());
        out
    }
}
