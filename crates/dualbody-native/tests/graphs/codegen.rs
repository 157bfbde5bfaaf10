//! Generated C, compiled and run as a process, against the library.

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use dualbody::codegen::{self, CodeError, Precision};
use dualbody::model::samples;
use dualbody::scalar::traced::{Graph, Port, trace};
use dualbody::{Model, Simulator};

use crate::common::{SAME_ALGEBRA, asset, random_point};

const ASSETS: [&str; 12] = [
    "acrobot",
    "box",
    "cartpole",
    "double_pendulum",
    "four_bar",
    "hopper",
    "humanoid",
    "panda",
    "quadrotor",
    "quadruped",
    "sphere",
    "ur5",
];

/// Whether there is a compiler; prints a line if not.
pub(crate) fn has_compiler() -> bool {
    let found = Command::new("cc").arg("--version").output().is_ok();
    if !found {
        println!("there is no compiler `cc`: generated code was not compiled");
    }
    found
}

/// A folder of this process for generated files, removed when it is done.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path = std::env::temp_dir().join(format!("dualbody-{name}-{}", std::process::id()));
        fs::create_dir_all(&path).expect("a folder for generated files");
        Self(path)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A program that prints the results of functions for their inputs.
pub(crate) struct Program {
    folder: Folder,
    main: String,
    files: Vec<String>,
}

impl Program {
    pub(crate) fn new(name: &str) -> Self {
        Self {
            folder: Folder::new(name),
            main: String::new(),
            files: Vec::new(),
        }
    }

    /// Adds a function at some inputs, through its batch.
    pub(crate) fn add(
        &mut self,
        graph: &Graph,
        name: &str,
        precision: Precision,
        inputs: &[Vec<f64>],
    ) {
        let text = graph.to_c(name, precision).expect("names that C takes");
        text.save(&self.folder.0).expect("files");
        self.files.push(format!("{name}.c"));
        let numbers: Vec<String> = inputs.concat().iter().map(|x| format!("{x:e}")).collect();
        let (count, n) = (inputs.len(), inputs.len() * graph.n_outputs());
        let given = if numbers.is_empty() {
            "0".to_owned()
        } else {
            numbers.join(", ")
        };
        let body = format!(
            "#include \"{name}.h\"\nstatic void run_{name}(void)\n{{\n\
             static const {name}_real in[] = {{ {given} }};\nstatic {name}_real out[{}];\nint status[{count}];\n\
             printf(\"%d\\n\", (int){name}_batch({count}, in, out, status));\n\
             for (int i = 0; i < {n}; ++i) printf(\"%.17g\\n\", (double)out[i]);\n}}\n",
            n.max(1)
        );
        self.main = format!("{body}{}", self.main);
    }

    /// Compiles and runs it. Returns the output of each function, the number of violated conditions first.
    pub(crate) fn run(&self, names: &[String]) -> Vec<f64> {
        let mut main = format!("#include <stdio.h>\n{}int main(void)\n{{\n", self.main);
        for name in names {
            writeln!(main, "run_{name}();").expect("text");
        }
        main += "return 0;\n}\n";
        fs::write(self.folder.0.join("main.c"), main).expect("a file");
        compile(&self.folder.0, &self.files);
        let output = Command::new(self.folder.0.join("program"))
            .output()
            .expect("a program");
        assert!(output.status.success());
        let text = String::from_utf8(output.stdout).expect("text");
        text.lines()
            .map(|line| line.parse().expect("a number"))
            .collect()
    }
}

fn compile(folder: &Path, files: &[String]) {
    let flags = [
        "-std=c99",
        "-O1",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-pedantic",
    ];
    let mut command = Command::new("cc");
    command.current_dir(folder).args(flags).args(files);
    let output = command
        .args(["main.c", "-o", "program", "-lm"])
        .output()
        .expect("cc");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
}

/// Inputs of a function at some random points: q, v, and tangent vectors for the rest.
fn inputs(model: &Model, graph: &Graph) -> Vec<Vec<f64>> {
    let at = |seed| {
        let point = random_point(model, seed);
        let all = point.q.iter().chain(&point.v).chain(&point.w).copied();
        all.take(graph.n_inputs()).collect()
    };
    (1..4).map(at).collect()
}

/// Compares functions in C with their graphs, which other tests compare with the library.
fn assert_compiled(name: &str, functions: &[(String, Model, Graph)], precision: Precision) {
    if !has_compiler() {
        return;
    }
    let tolerance = match precision {
        Precision::Double => 10.0 * SAME_ALGEBRA,
        Precision::Single => 1e-2,
    };
    let mut program = Program::new(name);
    for (name, model, graph) in functions {
        program.add(graph, name, precision, &inputs(model, graph));
    }
    let names: Vec<String> = functions.iter().map(|(name, ..)| name.clone()).collect();
    let mut printed = program.run(&names).into_iter();
    for (name, model, graph) in functions {
        assert_eq!(printed.next(), Some(0.0), "{name}: conditions");
        for x in inputs(model, graph) {
            let expected = graph.evaluate(&x).expect("slow motion");
            let largest = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
            for (k, e) in expected.iter().enumerate() {
                let a = printed.next().expect("as many numbers");
                let off = (a - e).abs();
                assert!(off <= tolerance * largest, "{name}, {k}: {a}, not {e}");
            }
        }
    }
    assert_eq!(printed.next(), None);
}

fn functions(robots: &[&str]) -> Vec<(String, Model, Graph)> {
    let mut out = Vec::new();
    for robot in robots {
        let model = asset(&format!("{robot}.urdf"));
        let simulator = Simulator::new(model.clone());
        out.push((
            format!("{robot}_rnea"),
            model.clone(),
            codegen::inverse_dynamics(&model),
        ));
        out.push((format!("{robot}_step"), model, codegen::step(&simulator)));
    }
    out
}

#[test]
fn compiled_rnea_and_step_of_all_assets_equal_the_library() {
    let all = functions(&ASSETS);
    // Graphs equal the library's functions (`traced.rs`); here once more, at one point, directly.
    for (name, model, graph) in all.iter().filter(|(name, ..)| name.ends_with("rnea")) {
        let x = &inputs(model, graph)[0];
        let (q, rest) = x.split_at(model.nq());
        let (v, a) = rest.split_at(model.nv());
        let tau = dualbody::dynamics::inverse_dynamics(model, q, v, a);
        for (own, expected) in graph.evaluate(x).expect("no conditions").iter().zip(&tau) {
            let off = (own - expected).abs();
            assert!(off < 1e-11 * expected.abs().max(1.0), "{name}: {off:e}");
        }
    }
    assert_compiled("assets", &all, Precision::Double);
}

#[test]
fn compiled_functions_in_single_precision_are_near_those_in_double() {
    let all = functions(&["cartpole", "ur5", "panda"]);
    assert_compiled("single", &all, Precision::Single);
}

#[test]
fn all_operations_compile() {
    use dualbody::Scalar;
    let graph = trace(|t| {
        let x = t.input(Port::vector("x", 3));
        let (a, b, c) = (x[0], x[1], x[2]);
        let s = a * a + 1.0;
        let y = [
            s.sqrt(),
            s.exp(),
            s.ln(),
            a.atan2(b),
            (a * 0.1).asin(),
            (b * 0.1).acos(),
            c.tanh(),
            a.mul_add(b, c),
            a.mul_add(b, -c) * 3.0,
            (-a).mul_add(c, b),
            (-a).mul_add(b, -c),
            a.select_lt(b, c, -c),
            a / b,
            -(a / c) * -2.5,
            a.sin_cos().0 - b.sin_cos().1,
            a,
            a * 0.0 - 7.5,
            a - b,
            b - a,
        ];
        t.output(Port::vector("y", y.len()), &y);
    });
    let model = samples::random_tree(3, 0); // for points
    assert_compiled(
        "operations",
        &[("operations".to_owned(), model, graph)],
        Precision::Double,
    );
}

// More operations than a part holds, and numbers that wait for later parts.
#[test]
fn long_functions_in_parts_equal_the_library() {
    let model = asset("quadruped.urdf");
    let graph = codegen::linearization(&Simulator::new(model.clone()));
    let text = graph
        .to_c("f", Precision::Double)
        .expect("a name")
        .source
        .to_owned();
    assert!(
        text.matches("void f_part_").count() > 3,
        "{}",
        graph.counts().operations()
    );
    assert_compiled(
        "parts",
        &[("f".to_owned(), model, graph)],
        Precision::Double,
    );
}

#[test]
fn conditions_that_do_not_hold_are_the_return_value() {
    if !has_compiler() {
        return;
    }
    let graph = codegen::step(&Simulator::new(samples::pendulum()));
    let mut program = Program::new("conditions");
    let inputs = [
        vec![0.1, 99.0, 0.0],
        vec![0.1, 101.0, 0.0],
        vec![0.1, -500.0, 0.0],
    ];
    program.add(&graph, "f", Precision::Double, &inputs);
    assert_eq!(program.run(&["f".to_owned()])[0], 2.0);
    assert!(
        graph
            .to_c("f", Precision::Double)
            .expect("a name")
            .header
            .contains("1: no coordinate rotates fast")
    );
}

#[test]
fn names_that_are_no_identifiers_of_c_are_refused() {
    let graph = codegen::mass_matrix(&samples::pendulum());
    for name in ["", "2fast", "µ", "a b", "int", "sin", "_x", &"x".repeat(80)] {
        let error = graph.to_c(name, Precision::Double).expect_err(name);
        assert!(matches!(error, CodeError::Name { .. }), "{name}: {error}");
        assert!(error.to_string().contains(name));
    }
    let ports = |inputs: &[&str]| {
        trace(|t| {
            for name in inputs {
                t.input(Port::number(*name));
            }
        })
    };
    let named = |inputs: &[&str]| ports(inputs).to_c("f", Precision::Double);
    assert!(matches!(named(&["q dot"]), Err(CodeError::Name { .. })));
    assert!(matches!(
        named(&["q", "Q"]),
        Err(CodeError::NameTwice { .. })
    ));
    assert!(matches!(
        named(&["q", "q_rows"]),
        Err(CodeError::NameTwice { .. })
    ));
    assert!(named(&["q", "v"]).is_ok());
}

#[test]
fn headers_say_of_which_robot_they_are_and_where_numbers_stand() {
    let model = asset("ur5.urdf");
    let graph = codegen::step(&Simulator::new(model.clone()));
    let text = graph.to_c("ur5_step", Precision::Single).expect("a name");
    let fingerprint = format!("{:016x}", model.fingerprint());
    for part in [
        &fingerprint[..],
        "typedef float ur5_step_real;",
        "/* v (6), rad/s or m/s */",
        "#define UR5_STEP_IN_V 6\n",
        "#define UR5_STEP_IN_SIZE 18\n",
        "#define UR5_STEP_OUT_V_NEXT 6\n",
    ] {
        assert!(text.header.contains(part), "{part}\n{}", text.header);
    }
    assert!(codegen::check_origin(graph.origin(), &model).is_ok());
    let changed = model.with_damping(0, 0.1);
    let error = codegen::check_origin(graph.origin(), &changed).expect_err("another robot");
    assert!(error.to_string().contains("trace it again"), "{error}");
}
