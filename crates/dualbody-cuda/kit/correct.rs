//! Kernels on the GPU, compared with the library's results on the CPU.

use std::error::Error;
use std::path::Path;

use dualbody::codegen::Precision;
use dualbody_cuda::{CudaError, Real};

use crate::cases::Cases;
use crate::catalogue::{Ground, Robot};
use crate::functions::{Function, Loaded, kinds, serves};
use crate::gpu::{Arrays, Gpu, word};
use crate::make::file_name;
use crate::report::Report;
use crate::variants::LIMIT;

/// Sizes of batches that are not multiples of the 32 threads of a warp; the last one is smaller where outputs are many.
const COUNTS: [usize; 3] = [45, 1_003, 100_003];
/// Outputs of the largest batch, about.
const OUTPUTS: usize = 8_000_000;

/// Largest error that is allowed, relative to the largest output of a state. Forces of stiff ground are differences of near numbers, those of relaxed contact come from an iteration.
fn tolerance<R: Real>(ground: Ground) -> f64 {
    match (R::PRECISION, ground) {
        (Precision::Double, Ground::Absent) => 1e-12,
        (Precision::Double, Ground::Soft) => 1e-10,
        (Precision::Double, Ground::Relaxed) => 1e-8,
        (Precision::Single, Ground::Absent) => 2e-4,
        (Precision::Single, _) => 2e-3,
    }
}

/// Results of a run on the device.
struct Found<R> {
    numbers: Vec<R>,
    kept: Vec<R>,
    status: Vec<i32>,
    taken: Vec<u32>,
}

/// How far a batch is off.
#[derive(Default)]
struct Off {
    error: f64,
    statuses: usize,
}

/// Compares all functions of some robots.
pub(crate) fn correct(
    gpu: &Gpu,
    folder: &Path,
    robots: &[Robot],
    report: &mut Report,
    share: f64,
) -> Result<(), Box<dyn Error>> {
    // The smallest workspace that there is, so that large batches are computed in pieces.
    gpu.device.limit_workspace(1);
    for robot in robots {
        for kind in kinds(robot) {
            let what = format!("{}, {}", robot.name, kind.name());
            let Some(function) = Function::new(robot, kind)? else {
                continue;
            };
            if !report.has_time(share, &format!("correct: {what}")) {
                continue;
            }
            let cases = Cases::read(&folder.join("expected").join(file_name(robot, kind)))?;
            both(gpu, robot, &function, &cases, report);
        }
    }
    gpu.device.limit_workspace(LIMIT);
    Ok(())
}

/// Compares a function in both precisions.
fn both(gpu: &Gpu, robot: &Robot, function: &Function, cases: &Cases, report: &mut Report) {
    compare::<f64>(gpu, robot, function, cases, report);
    if serves::<f32>(robot) {
        compare::<f32>(gpu, robot, function, cases, report);
    }
}

/// Compares a function in one precision.
fn compare<R: Real>(
    gpu: &Gpu,
    robot: &Robot,
    function: &Function,
    cases: &Cases,
    report: &mut Report,
) {
    let kind = function.kind;
    let what = format!("{}, {}, {}", robot.name, kind.name(), word::<R>());
    let rows = function.graph.n_outputs().max(1);
    let largest = (OUTPUTS / rows).clamp(COUNTS[1] + 4, COUNTS[2]) | 1;
    let mut worst = Off::default();
    let loaded = match function.load::<R>(None, &gpu.device, &gpu.compiler) {
        Ok(loaded) => loaded,
        Err(error) => return report.fail(format!("{what}: {error}")),
    };
    for count in [COUNTS[0], COUNTS[1], largest] {
        match batch(gpu, &loaded, cases, count) {
            Ok((off, is_same)) => {
                worst.error = worst.error.max(off.error);
                worst.statuses += off.statuses;
                if !is_same {
                    report.fail(format!("{what}: {count} states: another result each time"));
                }
            }
            Err(error) => return report.fail(format!("{what}: {error}")),
        }
    }
    let (error, tolerance) = (worst.error, tolerance::<R>(robot.ground));
    if error > tolerance || worst.statuses > 0 {
        let statuses = worst.statuses;
        report.fail(format!(
            "{what}: off by {error:.1e}, {statuses} wrong statuses"
        ));
    }
    let row = vec![
        ("part", "correct".into()),
        ("robot", robot.name.as_str().into()),
        ("function", kind.name().into()),
        ("numbers", word::<R>().into()),
        ("states", largest.into()),
        ("error", error.into()),
        ("tolerance", tolerance.into()),
        ("wrong_statuses", worst.statuses.into()),
    ];
    report.add(
        row,
        format!("{what}: off by {error:.1e} of {tolerance:.0e}"),
    );
}

/// Runs a function twice, each time into outputs that are not numbers; how far it is off, and whether both have the same bits.
fn batch<R: Real>(
    gpu: &Gpu,
    loaded: &Loaded<R>,
    cases: &Cases,
    count: usize,
) -> Result<(Off, bool), Box<dyn Error>> {
    let mut runs = Vec::new();
    for _ in 0..2 {
        let mut arrays = Arrays::new(
            &gpu.device,
            loaded,
            cases,
            count,
            [cases.steps, cases.steps / 2],
        )?;
        arrays.poison(loaded)?;
        arrays.reset(loaded)?;
        arrays.run(loaded)?;
        runs.push(found(&arrays)?);
    }
    let is_same = runs[0].status == runs[1].status
        && runs[0].taken == runs[1].taken
        && bits(&runs[0].numbers).eq(bits(&runs[1].numbers));
    Ok((off(&runs[0], cases, count), is_same))
}

fn found<R: Real>(arrays: &Arrays<R>) -> Result<Found<R>, CudaError> {
    Ok(Found {
        numbers: arrays.out.download()?,
        kept: arrays.kept.download()?,
        status: arrays.status.found()?,
        taken: arrays.status.taken()?,
    })
}

fn bits<R: Real>(numbers: &[R]) -> impl Iterator<Item = u64> + '_ {
    numbers.iter().map(|x| x.to_f64().to_bits())
}

/// Compares a run with the expected result of each state.
fn off<R: Real>(found: &Found<R>, cases: &Cases, count: usize) -> Off {
    let (rows, mut out) = (cases.rows(&cases.expected), Off::default());
    let sizes: Vec<f64> = (cases.expected.chunks(rows.max(1)))
        .map(|own| own.iter().fold(0.0, |most: f64, x| most.max(x.abs())))
        .collect();
    let is_right = |i: usize| {
        let own = i % cases.count;
        let taken = cases
            .taken
            .get(own)
            .is_none_or(|n| f64::from(found.taken[i]) == *n);
        f64::from(found.status[i]) == cases.status[own] && taken
    };
    out.statuses = (0..count).filter(|&i| !is_right(i)).count();
    for (k, row) in found.numbers.chunks(count).enumerate() {
        for (i, x) in row.iter().enumerate() {
            let own = i % cases.count;
            if cases.status[own] == 0.0 {
                let difference = (x.to_f64() - cases.expected[own * rows + k]).abs();
                let error = difference / sizes[own].max(f64::MIN_POSITIVE);
                // A number that is none is off by all that there is.
                out.error = out
                    .error
                    .max(if error.is_nan() { f64::INFINITY } else { error });
            }
        }
    }
    out.statuses += kept_wrong(found, cases, count);
    out
}

/// States whose last one was not kept unchanged.
fn kept_wrong<R: Real>(found: &Found<R>, cases: &Cases, count: usize) -> usize {
    let Some(first) = found.kept.len().checked_sub(found.numbers.len()) else {
        return 0;
    };
    let both = found.kept[first..].iter().zip(&found.numbers).enumerate();
    let moved = both.filter(|(_, (kept, last))| kept.to_f64() != last.to_f64());
    moved
        .filter(|(i, _)| cases.status[i % count % cases.count] == 0.0)
        .count()
}
