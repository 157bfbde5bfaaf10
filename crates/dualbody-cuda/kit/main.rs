//! A kit that goes to machines with a GPU: `kit.sh` beside the crate makes it, `run.sh` in it runs it there.
//!
//! `kit make FOLDER` computes expected results and compiles kernels, on a machine without a GPU; `kit run FOLDER` compares and measures on a machine with one.

mod cases;
mod catalogue;
mod ceilings;
mod correct;
mod expect;
mod functions;
mod gpu;
mod make;
mod rates;
mod report;
#[path = "../benches/kernels/report.rs"]
mod sizes;
mod special;
mod sweeps;
mod timing;
mod variants;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use dualbody_cuda::Architecture;

use catalogue::{Robot, robots};
use gpu::Gpu;
use make::{Order, make};
use rates::Ceilings;
use report::Report;

const USAGE: &str = "kit make FOLDER [--robots NAME,…] [--architectures 80,90] [--variants also|only] [--cache FOLDER]
kit run FOLDER [--parts correct,rates,contact,batch-sizes,variants,profile] [--robots NAME,…] [--seconds N] [--json FILE]";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match work(&arguments) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("kit: {error}");
            ExitCode::from(2)
        }
    }
}

fn work(arguments: &[String]) -> Result<ExitCode, Box<dyn Error>> {
    let [command, folder, options @ ..] = arguments else {
        return Err(USAGE.into());
    };
    let options = Options::of(options)?;
    match command.as_str() {
        "make" => make(&Order {
            folder: PathBuf::from(folder),
            only: options.list("--robots"),
            architectures: options.architectures()?,
            variants: options.value("--variants").is_some(),
            usual: options.value("--variants") != Some("only"),
            cache: options.value("--cache").map(PathBuf::from),
        })?,
        "run" => return run(folder.as_ref(), &options),
        _ => return Err(USAGE.into()),
    }
    Ok(ExitCode::SUCCESS)
}

/// Parts of a run, each with the share of the time that is over at its end at the latest.
const PARTS: [(&str, f64); 6] = [
    ("correct", 0.52),
    ("rates", 0.78),
    ("contact", 0.91),
    ("batch-sizes", 0.95),
    ("variants", 0.97),
    ("profile", 0.97),
];
/// Those that a run has if none are named: the next one needs NVRTC, the last one is for a profiler.
const USUAL: usize = 4;
/// Time of a run, s.
const SECONDS: f64 = 230.0;

/// Compares and measures on a GPU.
fn run(folder: &Path, options: &Options) -> Result<ExitCode, Box<dyn Error>> {
    let parts = options.list("--parts");
    let unknown = parts
        .iter()
        .find(|part| PARTS.iter().all(|(own, _)| own != part));
    if let Some(part) = unknown {
        return Err(format!("the part {part} is not known\n{USAGE}").into());
    }
    let seconds = options.value("--seconds").map_or(Ok(SECONDS), |word| {
        word.parse()
            .map_err(|_| format!("{word}: not a number of seconds"))
    })?;
    let mut report = Report::new(options.value("--json").map(PathBuf::from), seconds);
    let gpu = Gpu::new(folder)?;
    let (name, architecture) = (gpu.device.name()?, gpu.device.architecture()?);
    let row = vec![
        ("device", name.as_str().into()),
        ("architecture", architecture.to_string().into()),
    ];
    report.add(row, format!("{name}, {architecture}"));
    let robots = robots(&folder.join("robots"), &options.list("--robots"))?;
    let mut ceilings = None;
    for (k, (part, share)) in PARTS.into_iter().enumerate() {
        let is_chosen = match parts.is_empty() {
            true => k < USUAL,
            false => parts.iter().any(|own| own == part),
        };
        if !is_chosen {
            continue;
        }
        // Parts that are not chosen leave their time to the others.
        let share = if parts.is_empty() {
            share
        } else {
            PARTS[PARTS.len() - 1].1
        };
        let device = (&gpu, folder, &robots[..]);
        part_of(part, device, &mut ceilings, &mut report, share)?;
    }
    report.print();
    Ok(ExitCode::from(u8::from(!report.is_right())))
}

/// Runs a part.
fn part_of(
    part: &str,
    (gpu, folder, robots): (&Gpu, &Path, &[Robot]),
    ceilings: &mut Option<Ceilings>,
    report: &mut Report,
    share: f64,
) -> Result<(), Box<dyn Error>> {
    match part {
        "correct" => {
            special::special(gpu, report);
            correct::correct(gpu, folder, robots, report, share)
        }
        "rates" | "contact" => {
            let own = match ceilings.take() {
                Some(own) => own,
                None => Ceilings::measure(gpu, report)?,
            };
            let own = ceilings.insert(own);
            rates::rates(gpu, folder, robots, (own, part == "contact"), report, share)
        }
        "batch-sizes" => sweeps::batch_sizes(gpu, folder, robots, report, share),
        "variants" => variants::variants(gpu, folder, robots, report, share),
        _ => variants::profile(gpu, folder, robots, report),
    }
}

/// Options with a value each.
struct Options(Vec<(String, String)>);

impl Options {
    const KNOWN: [&str; 7] = [
        "--variants",
        "--robots",
        "--architectures",
        "--cache",
        "--parts",
        "--seconds",
        "--json",
    ];

    fn of(arguments: &[String]) -> Result<Self, Box<dyn Error>> {
        let pairs = arguments.chunks(2).map(|pair| match pair {
            [name, value] if Self::KNOWN.contains(&name.as_str()) => {
                Ok((name.clone(), value.clone()))
            }
            _ => Err(format!("the option {pair:?} is not known, or has no value\n{USAGE}").into()),
        });
        Ok(Self(pairs.collect::<Result<_, Box<dyn Error>>>()?))
    }

    fn value(&self, name: &str) -> Option<&str> {
        let found = self.0.iter().rev().find(|(own, _)| own == name);
        found.map(|(_, value)| value.as_str())
    }

    /// The words of a list with commas.
    fn list(&self, name: &str) -> Vec<String> {
        let words = self.value(name).unwrap_or("").split(',');
        words.filter(|w| !w.is_empty()).map(str::to_owned).collect()
    }

    fn architectures(&self) -> Result<Vec<Architecture>, Box<dyn Error>> {
        let one = |word: &String| {
            let number: u32 = word
                .parse()
                .map_err(|_| format!("{word}: not an architecture such as 90"))?;
            Ok(Architecture::new(number / 10, number % 10))
        };
        self.list("--architectures").iter().map(one).collect()
    }
}
