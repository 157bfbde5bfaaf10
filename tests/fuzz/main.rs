//! Mutation fuzzer over everything that the library reads: descriptions, meshes, recordings; and over distances of shapes.
//!
//! `cargo test --test fuzz` runs a few thousand cases. A long run:
//!
//! ```text
//! cargo test --release --test fuzz -- --executions 10000000 --jobs 2
//! ```
//!
//! Every case is a file that is changed at the level of its language, and what comes of it: an error that names its source, or something
//! that is what it claims to be (see `check`). Cases run in a process of their own under a limit of memory, 100 times the input and 64 MiB; its
//! parent watches how long each takes, blames the case at which the process is lost, and goes on behind it. Files at which something does
//! not hold are kept in `out/fuzz/`; `--replay INDEX`, with the seed and the kinds of the run, shows one again.
//!
//! | option | |
//! |---|---|
//! | `--executions N` | number of cases |
//! | `--jobs N` | processes side by side |
//! | `--seed N` | another seed makes other cases; the same one makes the same on every machine |
//! | `--kinds a,b` | some of urdf, sdf, mjcf, stl, obj, dae, msh, csv, json, pairs (of convex shapes) |

mod check;
mod child;
mod findings;
mod input;
mod memory;
mod mutate;
mod options;
mod parent;
mod seeds;

use std::process::ExitCode;

use options::{Options, Role};

#[global_allocator]
static ALLOCATOR: memory::Limited = memory::Limited;

fn main() -> ExitCode {
    let options = Options::of(std::env::args().skip(1));
    match options.role {
        Role::Parent => parent::run(&options),
        Role::Child => child::run(options),
        Role::Replay => child::replay(&options),
        Role::Idle => ExitCode::SUCCESS,
    }
}
