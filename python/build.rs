//! Writes the types of the module, `dualbody/_dualbody.pyi`, whoever builds it: pip, maturin or cargo.

use std::env;
use std::process::Command;

fn main() {
    for path in ["src", "table/src/functions", "stubs.py"] {
        println!("cargo::rerun-if-changed={path}");
    }
    println!("cargo::rerun-if-env-changed=PYO3_PYTHON");
    let python = env::var_os("PYO3_PYTHON").unwrap_or_else(|| "python3".into());
    let status = Command::new(&python).arg("stubs.py").status();
    assert!(
        status.as_ref().is_ok_and(std::process::ExitStatus::success),
        "{} stubs.py: {status:?}",
        python.display()
    );
}
