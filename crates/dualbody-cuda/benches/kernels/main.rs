//! Sizes of kernels in machine code, which need no GPU: registers, spilled bytes, instructions, and the time to compile.
//!
//! Measured from outside: see `benches/kernels/run.sh` in this crate. With names of robots it prints the kernels of these.

mod kernels;
mod report;

use std::error::Error;
use std::path::Path;

use dualbody_cuda::{Architecture, Compiler, CudaError};

use kernels::kernels;
use report::Report;

/// Robots whose kernels are counted; those of a humanoid take minutes to compile.
const ROBOTS: [&str; 3] = ["ur5", "panda", "quadruped"];

fn main() -> Result<(), Box<dyn Error>> {
    let given: Vec<String> = std::env::args()
        .skip(1)
        .filter(|name| !name.starts_with('-'))
        .collect();
    let named: Vec<&str> = given.iter().map(String::as_str).collect();
    let robots = if named.is_empty() {
        &ROBOTS[..]
    } else {
        &named
    };
    let folder = std::env::temp_dir().join(format!("dualbody-kernels-{}", std::process::id()));
    let printed = print_all(robots, &folder);
    let _ = std::fs::remove_dir_all(&folder);
    match printed {
        Err(error) if matches!(error.downcast_ref(), Some(CudaError::NoNvrtc { .. })) => {
            eprintln!("SKIPPED: {error}");
            Ok(())
        }
        printed => printed,
    }
}

fn print_all(robots: &[&str], folder: &Path) -> Result<(), Box<dyn Error>> {
    let compiler = Compiler::new().with_cache(folder);
    println!(
        "# kernel/precision/architecture/robot operations registers spilled_bytes instructions seconds"
    );
    for robot in robots {
        for kernel in kernels(robot)? {
            for architecture in [Architecture::new(8, 0), Architecture::new(9, 0)] {
                let report = Report::of(&kernel.source, &compiler, architecture)?;
                println!(
                    "{}/{architecture}/{robot} {} {report}",
                    kernel.name, kernel.operations
                );
            }
        }
    }
    Ok(())
}
