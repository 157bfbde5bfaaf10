//! States a second: the median of some runs, timed on the device, compared with the limits of the device.

use std::error::Error;
use std::path::Path;

use dualbody::codegen::{CudaSizes, Precision};
use dualbody_cuda::{CudaError, Real};

use crate::cases::Cases;
use crate::catalogue::{Ground, Robot};
use crate::ceilings::{bandwidth, fewest_operations, multiply_adds};
use crate::functions::{Function, Kind, Loaded, serves};
use crate::gpu::{Gpu, word};
use crate::make::file_name;
use crate::report::{Report, Row, short};
use crate::timing::{Time, time};

/// States of a run: enough to fill the largest GPUs many times over.
const STATES: usize = 1 << 20;
/// The fewest, of functions that need much memory.
const FEWEST: usize = 1 << 13;
/// Memory of a run, bytes.
const MEMORY: usize = 16 << 30;
/// Numbers that are handed to the device for a run, bytes.
const GIVEN: usize = 1 << 30;
/// Steps of a motion.
const STEPS: usize = 100;

/// Robots whose rates are measured.
pub(crate) const MEASURED: [&str; 4] = ["ur5", "panda", "quadruped", "humanoid"];

/// Limits of a device, a second.
pub(crate) struct Ceilings {
    single: f64,
    double: f64,
    bytes: f64,
}

impl Ceilings {
    /// Measures them.
    pub(crate) fn measure(gpu: &Gpu, report: &mut Report) -> Result<Self, Box<dyn Error>> {
        let out = Self {
            single: multiply_adds::<f32>(&gpu.device, &gpu.compiler)?,
            double: multiply_adds::<f64>(&gpu.device, &gpu.compiler)?,
            bytes: bandwidth(&gpu.device)?,
        };
        let row = vec![
            ("part", "ceilings".into()),
            ("f32_multiply_adds_per_second", out.single.into()),
            ("f64_multiply_adds_per_second", out.double.into()),
            ("bytes_per_second", out.bytes.into()),
        ];
        let line = format!(
            "at most: {}multiply-adds/s in f32, {}in f64; {}B/s of memory",
            short(out.single),
            short(out.double),
            short(out.bytes)
        );
        report.add(row, line);
        Ok(out)
    }

    fn operations<R: Real>(&self) -> f64 {
        match R::PRECISION {
            Precision::Single => self.single,
            Precision::Double => self.double,
        }
    }
}

/// A function that is measured.
pub(crate) struct Measured<'a> {
    pub(crate) robot: &'a Robot,
    pub(crate) function: &'a Function,
    pub(crate) cases: &'a Cases,
    /// Steps of each state; 0 of a function that is none.
    pub(crate) steps: usize,
}

impl Measured<'_> {
    /// Its name in tables.
    pub(crate) fn name(&self) -> String {
        match (self.function.kind, self.steps) {
            (kind, 0 | 1) => kind.name().to_owned(),
            (_, steps) => format!("{steps} steps"),
        }
    }

    /// Bytes that each state needs: those that are handed to the device, those that any kernel must read and write, and those of all arrays.
    fn bytes<R: Real>(&self, sizes: CudaSizes) -> [usize; 3] {
        let given = sizes.inputs + sizes.each_step * self.steps;
        let (taken, start) = match self.steps {
            0 => (sizes.outputs, 0),
            _ => (2 * sizes.outputs, sizes.outputs),
        };
        let least = (given + taken) * size_of::<R>() + size_of::<i32>();
        let all = least + (sizes.work + start) * size_of::<R>();
        [(given + start) * size_of::<R>(), least, all]
    }

    /// States that fit into the memory of a run, and fill the device.
    fn count<R: Real>(&self, sizes: CudaSizes) -> usize {
        let [given, _, all] = self.bytes::<R>(sizes);
        let most = (MEMORY / all).min(GIVEN / given).clamp(FEWEST, STATES);
        most / CudaSizes::TILE * CudaSizes::TILE
    }
}

/// Measures the functions of some robots, with ground or without.
pub(crate) fn rates(
    gpu: &Gpu,
    folder: &Path,
    robots: &[Robot],
    (ceilings, on_ground): (&Ceilings, bool),
    report: &mut Report,
    share: f64,
) -> Result<(), Box<dyn Error>> {
    use Kind::{ForwardDynamics, Gradients, InverseDynamics, Jacobians, Step};
    let all = [
        (InverseDynamics, 0),
        (ForwardDynamics, 0),
        (Step, 1),
        (Step, STEPS),
        (Jacobians, 0),
        (Gradients, 0),
    ];
    for robot in chosen(robots, on_ground) {
        for (kind, steps) in all {
            let exists = match robot.ground {
                Ground::Absent => true,
                Ground::Soft => !matches!(kind, InverseDynamics | ForwardDynamics),
                Ground::Relaxed => kind == Step,
            };
            let what = format!("rate: {}, {}", robot.name, kind.name());
            if !exists || !report.has_time(share, &what) {
                continue;
            }
            let Some(function) = Function::new(robot, kind)? else {
                continue;
            };
            let cases = Cases::read(&folder.join("expected").join(file_name(robot, kind)))?;
            let measured = Measured {
                robot,
                function: &function,
                cases: &cases.ordinary().calm(),
                steps,
            };
            rate::<f32>(gpu, &measured, ceilings, report);
            rate::<f64>(gpu, &measured, ceilings, report);
        }
    }
    Ok(())
}

/// The robots that are measured: those of [`MEASURED`], or the robots of a kit.
fn chosen(robots: &[Robot], on_ground: bool) -> impl Iterator<Item = &Robot> {
    let is_measured = |robot: &Robot| {
        let first = robot.name.split(' ').next().unwrap_or_default();
        MEASURED.contains(&first) || robots.len() <= MEASURED.len()
    };
    robots
        .iter()
        .filter(move |robot| (robot.ground != Ground::Absent) == on_ground && is_measured(robot))
}

/// Measures a function in one precision.
fn rate<R: Real>(gpu: &Gpu, measured: &Measured<'_>, ceilings: &Ceilings, report: &mut Report) {
    if !serves::<R>(measured.robot) {
        return;
    }
    let what = format!(
        "{}, {}, {}",
        measured.robot.name,
        measured.name(),
        word::<R>()
    );
    let found = measured
        .function
        .load::<R>(None, &gpu.device, &gpu.compiler);
    let found: Result<_, CudaError> = found.and_then(|loaded| {
        let sizes = sizes(&loaded);
        let mut states = measured.count::<R>(sizes);
        loop {
            match time(gpu, &loaded, measured, states) {
                Err(CudaError::NoMemory { .. }) if states > FEWEST => states /= 2,
                found => return Ok((sizes, found?)),
            }
        }
    });
    match found {
        Err(error) => report.fail(format!("{what}: {error}")),
        Ok((sizes, time)) => {
            let (row, line) = row::<R>(measured, sizes, &time, ceilings);
            report.add(row, format!("{what}: {line}"));
        }
    }
}

fn sizes<R: Real>(loaded: &Loaded<R>) -> CudaSizes {
    match loaded {
        Loaded::Batch(function) => function.sizes(),
        Loaded::Steps(stepper) => stepper.sizes(),
    }
}

/// The row and the line of a measurement.
fn row<R: Real>(
    measured: &Measured<'_>,
    sizes: CudaSizes,
    time: &Time,
    ceilings: &Ceilings,
) -> (Row, String) {
    let steps = measured.steps.max(1);
    let operations = fewest_operations(&measured.function.graph) * steps;
    let [_, bytes, _] = measured.bytes::<R>(sizes);
    let each = time.seconds / time.states as f64;
    let arithmetic = operations as f64 / ceilings.operations::<R>() / each;
    let memory = bytes as f64 / ceilings.bytes / each;
    let rate = steps as f64 / each;
    let row = vec![
        ("part", "rates".into()),
        ("robot", measured.robot.name.as_str().into()),
        ("function", measured.name().into()),
        ("numbers", word::<R>().into()),
        ("states", time.states.into()),
        ("seconds", time.seconds.into()),
        ("seconds_waited", time.waited.into()),
        ("per_second", rate.into()),
        ("operations", operations.into()),
        ("bytes", bytes.into()),
        ("work", sizes.work.into()),
        ("share_of_arithmetic", arithmetic.into()),
        ("share_of_memory", memory.into()),
        ("flagged", time.flagged.into()),
    ];
    let flagged = match time.flagged {
        0 => String::new(),
        n => format!("; {n} of {} states flagged", time.states),
    };
    let line = format!(
        "{}/s, {:.1} % of arithmetic, {:.1} % of memory{flagged}",
        short(rate),
        100.0 * arithmetic,
        100.0 * memory
    );
    (row, line)
}
