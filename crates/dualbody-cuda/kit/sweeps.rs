//! Rates for several sizes of batches, and of kernels that are cut or compiled in other ways.

use std::error::Error;
use std::path::Path;

use dualbody_cuda::{Compiler, CudaError, CudaFunction, Real};

use crate::cases::Cases;
use crate::catalogue::{Ground, Robot};
use crate::functions::{Function, Kind, Loaded};
use crate::gpu::{Gpu, word};
use crate::make::file_name;
use crate::rates::{Measured, time};
use crate::report::{Report, short};

/// Sizes of batches, as powers of two.
const SIZES: [u32; 7] = [8, 10, 12, 14, 16, 18, 20];
/// Lengths of parts, operations.
const LENGTHS: [usize; 4] = [500, 1_000, 2_000, 4_000];
/// Bounds of the registers of a thread.
const REGISTERS: [usize; 4] = [64, 96, 128, 168];
/// States of a run of variants.
const STATES: usize = 1 << 16;

/// A function of a robot with its random states.
fn load(
    folder: &Path,
    robot: &Robot,
    kind: Kind,
) -> Result<Option<(Function, Cases)>, Box<dyn Error>> {
    let Some(function) = Function::new(robot, kind)? else {
        return Ok(None);
    };
    let cases = Cases::read(&folder.join("expected").join(file_name(robot, kind)))?;
    Ok(Some((function, cases.ordinary())))
}

/// Measures steps and inverse dynamics for several sizes of batches.
pub(crate) fn batch_sizes(
    gpu: &Gpu,
    folder: &Path,
    robots: &[Robot],
    report: &mut Report,
    share: f64,
) -> Result<(), Box<dyn Error>> {
    let is_measured = |robot: &&Robot| {
        ["ur5", "humanoid"].contains(&robot.name.as_str())
            || robots.len() == 1 && robot.ground == Ground::Absent
    };
    for robot in robots.iter().filter(is_measured) {
        for kind in [Kind::InverseDynamics, Kind::Step] {
            let what = format!("batch sizes: {}, {}", robot.name, kind.name());
            if !report.has_time(share, &what) {
                continue;
            }
            let Some((function, cases)) = load(folder, robot, kind)? else {
                continue;
            };
            if let Err(error) = sizes::<f32>(gpu, robot, &function, &cases, report) {
                report.fail(format!("{what}: {error}"));
            }
        }
    }
    Ok(())
}

fn sizes<R: Real>(
    gpu: &Gpu,
    robot: &Robot,
    function: &Function,
    cases: &Cases,
    report: &mut Report,
) -> Result<(), Box<dyn Error>> {
    let loaded = function.load::<R>(&gpu.device, &gpu.compiler)?;
    let measured = Measured {
        robot,
        function,
        cases,
        steps: usize::from(function.kind.is_step()),
    };
    let mut words = Vec::new();
    for power in SIZES {
        let found = time(gpu, &loaded, &measured, 1 << power)?;
        let rate = found.states as f64 / found.seconds;
        words.push(format!("{}{}", short(found.states as f64), short(rate)));
        report.note(vec![
            ("part", "batch-sizes".into()),
            ("robot", robot.name.as_str().into()),
            ("function", function.kind.name().into()),
            ("numbers", word::<R>().into()),
            ("states", found.states.into()),
            ("seconds", found.seconds.into()),
            ("per_second", rate.into()),
        ]);
    }
    let line = format!(
        "{}, {}, {}: states and rates/s {}",
        robot.name,
        function.kind.name(),
        word::<R>(),
        words.join("; ")
    );
    report.add(vec![("part", "batch-sizes".into())], line);
    Ok(())
}

/// Measures long functions in parts of several lengths, and with bounded registers. It compiles them, and so needs NVRTC.
pub(crate) fn variants(
    gpu: &Gpu,
    folder: &Path,
    robots: &[Robot],
    report: &mut Report,
    share: f64,
) -> Result<(), Box<dyn Error>> {
    let robots: Vec<&Robot> = match robots.len() {
        0..=3 => robots.iter().collect(),
        _ => robots
            .iter()
            .filter(|robot| ["panda", "quadruped"].contains(&robot.name.as_str()))
            .collect(),
    };
    for robot in robots {
        for kind in [Kind::Jacobians, Kind::Gradients] {
            if let Some((function, cases)) = load(folder, robot, kind)? {
                let measured = Measured {
                    robot,
                    function: &function,
                    cases: &cases,
                    steps: 0,
                };
                compiled::<f32>(gpu, &measured, report, share);
                compiled::<f64>(gpu, &measured, report, share);
            }
        }
    }
    Ok(())
}

/// A function compiled in all ways.
fn compiled<R: Real>(gpu: &Gpu, measured: &Measured<'_>, report: &mut Report, share: f64) {
    let folder = std::env::temp_dir().join("dualbody-kit-variants");
    let compiler = Compiler::new().with_cache(folder);
    let lengths = LENGTHS.map(|length| (format!("parts of {length}"), length, compiler.clone()));
    let bounded = REGISTERS.map(|registers| {
        let flag = format!("--maxrregcount={registers}");
        let compiler = compiler.clone().with_flags(&[&flag]);
        (format!("{registers} registers"), LENGTHS[2], compiler)
    });
    for (way, length, compiler) in lengths.into_iter().chain(bounded) {
        let (robot, kind) = (&measured.robot.name, measured.function.kind.name());
        let what = format!("{robot}, {kind}, {}, {way}", word::<R>());
        if !report.has_time(share, &format!("variant: {what}")) {
            continue;
        }
        let graph = &measured.function.graph;
        let start = std::time::Instant::now();
        let function = CudaFunction::<R>::in_parts(graph, "f", &[], length, &gpu.device, &compiler);
        let seconds = start.elapsed().as_secs_f64();
        let found = match function {
            Err(CudaError::NoNvrtc { .. }) => {
                report.note(vec![("variant", what.into()), ("found", "no NVRTC".into())]);
                return;
            }
            Err(error) => Err(error),
            Ok(function) => time(gpu, &Loaded::Batch(function), measured, STATES),
        };
        match found {
            Err(error) => report.fail(format!("{what}: {error}")),
            Ok(found) => {
                let rate = found.states as f64 / found.seconds;
                let row = vec![
                    ("part", "variants".into()),
                    ("robot", robot.as_str().into()),
                    ("function", kind.into()),
                    ("numbers", word::<R>().into()),
                    ("way", way.into()),
                    ("per_second", rate.into()),
                    ("compiled_in", seconds.into()),
                ];
                let line = format!("{what}: {}/s, compiled in {seconds:.1} s", short(rate));
                report.add(row, line);
            }
        }
    }
}
