//! Rates for several sizes of batches.

use std::error::Error;
use std::path::Path;

use dualbody_cuda::Real;

use crate::cases::Cases;
use crate::catalogue::{Ground, Robot};
use crate::functions::{Function, Kind, kinds};
use crate::gpu::{Gpu, word};
use crate::make::file_name;
use crate::rates::Measured;
use crate::report::{Report, short};
use crate::timing::time;

/// Sizes of batches, as powers of two.
const SIZES: [u32; 7] = [8, 10, 12, 14, 16, 18, 20];

/// A function of a robot with its random states.
pub(crate) fn load(
    folder: &Path,
    robot: &Robot,
    kind: Kind,
) -> Result<Option<(Function, Cases)>, Box<dyn Error>> {
    if !kinds(robot).contains(&kind) {
        return Ok(None);
    }
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
    let loaded = function.load::<R>(None, &gpu.device, &gpu.compiler)?;
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
