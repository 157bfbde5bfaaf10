//! Rates of kernels that are cut or compiled in other ways.

use std::error::Error;
use std::path::Path;

use dualbody_cuda::{Architecture, Compiler, CudaError, Real};

use crate::catalogue::{Ground, Robot};
use crate::functions::{Function, Kind, serves};
use crate::gpu::{Arrays, Gpu, word};
use crate::rates::{MEASURED, Measured};
use crate::report::{Report, short};
use crate::sweeps::load;
use crate::timing::time;

/// Lengths of parts, operations.
const LENGTHS: [usize; 4] = [1_000, 2_000, 4_000, 10_000];
/// Bounds of the registers of a thread.
const REGISTERS: [usize; 3] = [64, 96, 128];
/// Operations of a function that is not compiled in all ways.
pub(crate) const LONGEST: usize = 10_000;
/// Sizes of the workspace, MiB.
const LIMITS: [usize; 2] = [256, 4_096];
/// The usual one, bytes.
pub(crate) const LIMIT: usize = 1 << 30;
/// States of a run of variants.
const STATES: usize = 1 << 18;
/// Steps of a motion that is profiled.
const PROFILED: usize = 5;

/// A way to compile and run a function.
struct Way {
    name: String,
    /// Most operations of a part.
    length: usize,
    flags: Vec<String>,
    /// Bytes of the workspace.
    limit: usize,
}

/// All ways of a function.
fn ways(kind: Kind) -> Vec<Way> {
    let way = |name: String, length, flags: &[String], limit| Way {
        name,
        length,
        flags: flags.to_vec(),
        limit,
    };
    let parts = LENGTHS.map(|n| way(format!("parts of {n}"), n, &[], LIMIT));
    let bounded = REGISTERS.map(|n| {
        let flag = format!("--maxrregcount={n}");
        way(format!("{n} registers"), LENGTHS[3], &[flag], LIMIT)
    });
    let limited = LIMITS.map(|n| way(format!("workspace of {n} MiB"), LENGTHS[1], &[], n << 20));
    match kind.is_step() {
        true => parts.into_iter().chain(bounded).collect(),
        false => parts.into_iter().chain(limited).collect(),
    }
}

/// Compiles a function in all ways, for machines without NVRTC.
pub(crate) fn precompile<R: Real>(
    function: &Function,
    compiler: &Compiler,
    architecture: Architecture,
    folder: &Path,
) -> Result<(), Box<dyn Error>> {
    for way in ways(function.kind) {
        let flags: Vec<&str> = way.flags.iter().map(String::as_str).collect();
        let compiler = compiler.clone().with_flags(&flags);
        let source = function.source::<R>(Some(way.length))?;
        compiler.precompile(&source, architecture, folder)?;
    }
    Ok(())
}

/// Measures long functions in parts of several lengths, with bounded registers, and with workspaces of several sizes. It compiles them, and so needs NVRTC.
pub(crate) fn variants(
    gpu: &Gpu,
    folder: &Path,
    robots: &[Robot],
    report: &mut Report,
    share: f64,
) -> Result<(), Box<dyn Error>> {
    let is_chosen = |robot: &&Robot| {
        robots.len() <= MEASURED.len() || ["panda", "quadruped"].contains(&robot.name.as_str())
    };
    for robot in robots.iter().filter(is_chosen) {
        for (kind, steps) in [(Kind::Step, 1), (Kind::Gradients, 0), (Kind::Jacobians, 0)] {
            if let Some((function, cases)) = load(folder, robot, kind)? {
                let measured = Measured {
                    robot,
                    function: &function,
                    cases: &cases,
                    steps,
                };
                if function.graph.counts().operations() < LONGEST {
                    compiled::<f32>(gpu, folder, &measured, report, share);
                    compiled::<f64>(gpu, folder, &measured, report, share);
                }
            }
        }
    }
    gpu.device.limit_workspace(LIMIT);
    Ok(())
}

/// A function compiled in all ways.
fn compiled<R: Real>(
    gpu: &Gpu,
    folder: &Path,
    measured: &Measured<'_>,
    report: &mut Report,
    share: f64,
) {
    if !serves::<R>(measured.robot) {
        return;
    }
    let own = std::env::temp_dir().join("dualbody-kit-variants");
    for way in ways(measured.function.kind) {
        let (robot, kind) = (&measured.robot.name, measured.function.kind.name());
        let what = format!("{robot}, {kind}, {}, {}", word::<R>(), way.name);
        if !report.has_time(share, &format!("variant: {what}")) {
            continue;
        }
        let flags: Vec<&str> = way.flags.iter().map(String::as_str).collect();
        let compiler = Compiler::new()
            .with_precompiled(folder.join("kernels"))
            .with_cache(&own)
            .with_flags(&flags);
        let (device, function) = (&gpu.device, measured.function);
        device.limit_workspace(way.limit);
        let start = std::time::Instant::now();
        let loaded = function.load::<R>(Some(way.length), device, &compiler);
        let seconds = start.elapsed().as_secs_f64();
        match loaded.and_then(|loaded| time(gpu, &loaded, measured, STATES)) {
            Err(CudaError::NoNvrtc { .. }) => {
                report.note(vec![("variant", what.into()), ("found", "no NVRTC".into())]);
                return;
            }
            Err(error) => report.fail(format!("{what}: {error}")),
            Ok(found) => {
                let rate = found.states as f64 / found.seconds;
                let row = vec![
                    ("part", "variants".into()),
                    ("robot", robot.as_str().into()),
                    ("function", kind.into()),
                    ("numbers", word::<R>().into()),
                    ("way", way.name.into()),
                    ("per_second", rate.into()),
                    ("compiled_in", seconds.into()),
                ];
                let line = format!("{what}: {}/s, compiled in {seconds:.1} s", short(rate));
                report.add(row, line);
            }
        }
    }
}

/// Runs some functions once each, for a profiler of kernels.
pub(crate) fn profile(
    gpu: &Gpu,
    folder: &Path,
    robots: &[Robot],
    report: &mut Report,
) -> Result<(), Box<dyn Error>> {
    for robot in robots.iter().filter(|robot| robot.ground == Ground::Absent) {
        for (kind, steps) in [(Kind::Step, PROFILED), (Kind::Jacobians, 0)] {
            let Some((function, cases)) = load(folder, robot, kind)? else {
                continue;
            };
            let loaded = function.load::<f32>(None, &gpu.device, &gpu.compiler)?;
            let steps = [steps, 0];
            let cases = cases.calm();
            let mut arrays = Arrays::new(&gpu.device, &loaded, &cases, STATES, steps)?;
            arrays.reset(&loaded)?;
            arrays.run(&loaded)?;
            gpu.device.synchronize()?;
            let line = format!("{}, {}, f32: run once", robot.name, kind.name());
            report.add(vec![("part", "profile".into())], line);
        }
    }
    Ok(())
}
