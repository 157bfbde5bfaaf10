//! Makes a kit, on a machine without a GPU: random states with the library's results, and compiled kernels.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use dualbody::codegen::Precision;
use dualbody_cuda::{Architecture, Compiler, CudaError};

use crate::catalogue::{Robot, robots};
use crate::expect::expect;
use crate::functions::{Function, Kind, kinds, serves};
use crate::special::sources;
use crate::variants::{LONGEST, precompile};

/// Parts of a kit to make.
pub(crate) struct Order {
    /// The kit's folder, with `robots/*.urdf`.
    pub(crate) folder: PathBuf,
    /// Names of robots; all if there are none.
    pub(crate) only: Vec<String>,
    /// Architectures that kernels are compiled for.
    pub(crate) architectures: Vec<Architecture>,
    /// Whether steps are compiled in all ways that are measured.
    pub(crate) variants: bool,
    /// Whether functions are compiled in the usual way.
    pub(crate) usual: bool,
    /// Where compiled kernels are kept for the next kit.
    pub(crate) cache: Option<PathBuf>,
}

/// The name of the file of a function.
pub(crate) fn file_name(robot: &Robot, kind: Kind) -> String {
    format!("{}, {}", robot.name, kind.name()).replace([' ', ','], "_")
}

/// Makes all files of a kit but the programs.
pub(crate) fn make(order: &Order) -> Result<(), Box<dyn Error>> {
    let cases = order.folder.join("expected");
    fs::create_dir_all(&cases)?;
    let robots = robots(&order.folder.join("robots"), &order.only)?;
    let mut functions = Vec::new();
    for robot in &robots {
        for kind in kinds(robot) {
            let Some(function) = Function::new(robot, kind)? else {
                continue;
            };
            let expected = expect(robot, &function);
            let left = expected.status[..expected.ordinary].iter();
            if left.clone().any(|&status| status != 0.0) {
                let name = (&robot.name, kind.name());
                let statuses: Vec<_> = left.collect();
                eprintln!("{name:?}: a condition does not hold: {statuses:?}");
            }
            expected.write(&cases.join(file_name(robot, kind)))?;
            functions.push((robot, function));
        }
    }
    println!("{} functions of {} robots", functions.len(), robots.len());
    for &architecture in &order.architectures {
        match compile(order, &functions, architecture) {
            Err(error) if matches!(error.downcast_ref(), Some(CudaError::NoNvrtc { .. })) => {
                eprintln!("SKIPPED: no kernels are in the kit: {error}");
                return Ok(());
            }
            compiled => compiled?,
        }
    }
    Ok(())
}

/// Compiles all functions, those first that take long.
fn compile(
    order: &Order,
    functions: &[(&Robot, Function)],
    architecture: Architecture,
) -> Result<(), Box<dyn Error>> {
    let folder = order.folder.join("kernels");
    let compiler = match &order.cache {
        Some(cache) => Compiler::new().with_cache(cache),
        None => Compiler::new(),
    };
    let (start, mut bytes) = (Instant::now(), 0);
    let double = sources::<f64>()?.into_iter();
    for source in double.chain(sources::<f32>()?) {
        compiler.precompile(&source, architecture, &folder)?;
    }
    for (robot, function) in functions {
        let mut sizes = Vec::new();
        if order.usual {
            let of =
                |precision| precision_of(function, &compiler, architecture, &folder, precision);
            sizes.push(of(Precision::Double)?);
            if serves::<f32>(robot) {
                sizes.push(of(Precision::Single)?);
            }
        }
        bytes += sizes.iter().map(|(own, _)| own).sum::<usize>();
        let operations = function.graph.counts().operations();
        if order.variants && function.kind == Kind::Step && operations < LONGEST {
            precompile::<f32>(function, &compiler, architecture, &folder)?;
            precompile::<f64>(function, &compiler, architecture, &folder)?;
        }
        let sizes = sizes.into_iter().map(|(_, sizes)| sizes);
        let sizes: Vec<String> = sizes.filter(|sizes| !sizes.is_empty()).collect();
        let (name, kind) = (&robot.name, function.kind.name());
        let (megabytes, seconds) = (bytes as f64 * 1e-6, start.elapsed().as_secs_f64());
        print!("{architecture} {name}, {kind}: {operations} operations");
        if !sizes.is_empty() {
            let sizes = sizes.join("; ");
            print!("; registers, spilled, instructions, seconds: {sizes}");
        }
        println!("; {megabytes:.1} MB after {seconds:.0} s");
    }
    Ok(())
}

/// Compiles a function in a precision.
fn precision_of(
    function: &Function,
    compiler: &Compiler,
    architecture: Architecture,
    folder: &Path,
    precision: Precision,
) -> Result<(usize, String), CudaError> {
    match precision {
        Precision::Double => function.precompile::<f64>(compiler, architecture, folder),
        Precision::Single => function.precompile::<f32>(compiler, architecture, folder),
    }
}
