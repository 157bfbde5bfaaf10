//! Kernels on the CPU: their text as C, in a program that runs one thread of the device after the other.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

use dualbody::codegen::{CudaKernel, CudaSizes, CudaSource, Precision, RolloutInputs};
use dualbody::scalar::traced::Graph;
use dualbody_cuda::{Outputs, Real};

use crate::machine::{Left, Machine, Run};

/// Definitions of CUDA that C lacks. Blocks have three threads, so that the last one is not full.
const DEVICE: &str = r#"#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#define __global__
#define __device__
#define __noinline__ __attribute__((noinline))
static struct { unsigned x; } blockIdx, blockDim = { 3 }, threadIdx;
static void *take(size_t count, size_t size)
{
    void *all = calloc(count + 1, size);
    if (fread(all, size, count, stdin) != count) exit(2);
    return all;
}
static void give(const void *all, size_t count, size_t size)
{
    if (fwrite(all, size, count, stdout) != count) exit(3);
}
#define EACH_THREAD \
    for (blockIdx.x = 0; blockIdx.x < (count + blockDim.x - 1) / blockDim.x; ++blockIdx.x) \
        for (threadIdx.x = 0; threadIdx.x < blockDim.x; ++threadIdx.x)
"#;

/// The CPU.
pub(crate) struct Host;

impl Host {
    /// The CPU; prints a line if there is no compiler.
    pub(crate) fn new() -> Option<Self> {
        let found = Command::new("cc").arg("--version").output().is_ok();
        if !found {
            eprintln!("not tested: there is no C compiler `cc`");
        }
        found.then_some(Self)
    }
}

impl Machine for Host {
    fn batch<R: Real>(
        &self,
        graph: &Graph,
        shared: &[&str],
        count: usize,
        numbers: [&[R]; 2],
    ) -> Outputs<R> {
        let source = graph
            .to_cuda("f", R::PRECISION, shared)
            .expect("names that C takes");
        let sizes = source.sizes;
        let call = |kernel: &CudaKernel| {
            let name = kernel.name();
            format!("    EACH_THREAD {name}(count, in, shared, work, out, status);\n")
        };
        let calls: String = source.kernels.iter().map(call).collect();
        let main = format!(
            r#"int main(void)
{{
    const unsigned count = {count};
    REAL *in = take((size_t){} * count, sizeof(REAL)), *shared = take({}, sizeof(REAL));
    REAL *out = calloc((size_t){n} * count + 1, sizeof(REAL)), *work = calloc((size_t){} * (count + {tile}), sizeof(REAL));
    int *status = calloc(count, sizeof(int));
{calls}    give(out, (size_t){n} * count, sizeof(REAL));
    give(status, count, sizeof(int));
    return 0;
}}
"#,
            sizes.inputs,
            sizes.shared,
            sizes.work,
            tile = CudaSizes::TILE,
            n = sizes.outputs
        );
        assert_eq!(
            numbers[0].len(),
            sizes.inputs * count,
            "the inputs of the test"
        );
        let given = [
            bytes(&turned(numbers[0], count, sizes.inputs)),
            bytes(numbers[1]),
        ]
        .concat();
        let printed = run(&source, &main, &given);
        let (out, status) = printed.split_at(printed.len() - 4 * count);
        Outputs {
            numbers: turned(&of_bytes::<R>(out), sizes.outputs, count),
            status: integers(status),
        }
    }

    fn rollout<R: Real>(&self, graph: &Graph, inputs: &RolloutInputs, run_: Run<R>) -> Left<R> {
        let source = graph
            .to_cuda_rollout("f", R::PRECISION, inputs)
            .expect("a step");
        let (sizes, count) = (source.sizes, run_.count);
        let schedule = run_.schedule;
        let kept = schedule.kept() * sizes.outputs;
        let main = format!(
            r#"int main(void)
{{
    const unsigned count = {count};
    REAL *state = take((size_t){n} * count, sizeof(REAL)), *in = take((size_t){} * count, sizeof(REAL));
    REAL *each_step = take((size_t){} * count, sizeof(REAL)), *shared = take({}, sizeof(REAL));
    int *status = take(count, sizeof(int));
    unsigned *taken = take(count, sizeof(unsigned));
    REAL *kept = calloc((size_t){kept} * count + 1, sizeof(REAL));
    EACH_THREAD f_rollout(count, {}, {}, (REAL){:e}, state, in, each_step, shared, kept, status, taken);
    give(state, (size_t){n} * count, sizeof(REAL));
    give(kept, (size_t){kept} * count, sizeof(REAL));
    give(status, count, sizeof(int));
    give(taken, count, sizeof(unsigned));
    return 0;
}}
"#,
            sizes.inputs,
            sizes.each_step * schedule.steps,
            sizes.shared,
            schedule.steps,
            schedule.every,
            schedule.fastest,
            n = sizes.outputs,
        );
        let given = [
            bytes(&turned(&run_.state, count, sizes.outputs)),
            bytes(&turned(&run_.constants, count, sizes.inputs)),
            bytes(&turned(
                &run_.each_step,
                count,
                sizes.each_step * schedule.steps,
            )),
            bytes(&run_.shared),
            run_.status.iter().flat_map(|x| x.to_ne_bytes()).collect(),
            run_.taken.iter().flat_map(|x| x.to_ne_bytes()).collect(),
        ];
        let printed = run(&source, &main, &given.concat());
        let (numbers, integers_) = printed.split_at(printed.len() - 8 * count);
        let numbers = of_bytes::<R>(numbers);
        let (state, kept_numbers) = numbers.split_at(sizes.outputs * count);
        let (status, taken) = integers_.split_at(4 * count);
        Left {
            kept: turned(kept_numbers, kept, count),
            run: Run {
                state: turned(state, sizes.outputs, count),
                status: integers(status),
                taken: integers(taken)
                    .into_iter()
                    .map(i32::cast_unsigned)
                    .collect(),
                ..run_
            },
        }
    }
}

/// Compiles a kernel with a program, passes some bytes to it, and returns its output.
fn run(source: &CudaSource, main: &str, given: &[u8]) -> Vec<u8> {
    static RUNS: AtomicUsize = AtomicUsize::new(0);
    let number = RUNS.fetch_add(1, Ordering::Relaxed);
    let folder: PathBuf =
        std::env::temp_dir().join(format!("dualbody-cuda-{}-{number}", std::process::id()));
    fs::create_dir_all(&folder).expect("a folder");
    let kernels = source.kernels.iter().map(CudaKernel::text);
    let text = [DEVICE, &kernels.collect::<String>(), main].concat();
    fs::write(folder.join("kernel.c"), text).expect("a file");
    let flags = [
        "-std=gnu99",
        "-O0",
        "-Wall",
        "-Werror",
        "kernel.c",
        "-o",
        "kernel",
        "-lm",
    ];
    let output = Command::new("cc")
        .current_dir(&folder)
        .args(flags)
        .output()
        .expect("cc");
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let mut program = Command::new(folder.join("kernel"));
    let mut child = program
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("a program");
    child
        .stdin
        .take()
        .expect("its input")
        .write_all(given)
        .expect("numbers");
    let output = child.wait_with_output().expect("an end");
    assert!(output.status.success(), "{:?}", output.status);
    let _ = fs::remove_dir_all(&folder);
    output.stdout
}

/// A matrix of so many rows, row after row, as its columns one after the other.
fn turned<R: Real>(numbers: &[R], rows: usize, columns: usize) -> Vec<R> {
    assert_eq!(numbers.len(), rows * columns);
    let column = |j: usize| (0..rows).map(move |i| numbers[i * columns + j]);
    (0..columns).flat_map(column).collect()
}

fn bytes<R: Real>(numbers: &[R]) -> Vec<u8> {
    let all = numbers.iter().map(|x| x.to_f64());
    match R::PRECISION {
        Precision::Double => all.flat_map(f64::to_ne_bytes).collect(),
        Precision::Single => all.flat_map(|x| (x as f32).to_ne_bytes()).collect(),
    }
}

fn of_bytes<R: Real>(bytes: &[u8]) -> Vec<R> {
    let (double, _) = bytes.as_chunks::<8>();
    let (single, _) = bytes.as_chunks::<4>();
    match R::PRECISION {
        Precision::Double => double
            .iter()
            .map(|x| R::from_f64(f64::from_ne_bytes(*x)))
            .collect(),
        Precision::Single => single
            .iter()
            .map(|x| R::from_f64(f32::from_ne_bytes(*x).into()))
            .collect(),
    }
}

fn integers(bytes: &[u8]) -> Vec<i32> {
    let (all, _) = bytes.as_chunks::<4>();
    all.iter().map(|x| i32::from_ne_bytes(*x)).collect()
}
