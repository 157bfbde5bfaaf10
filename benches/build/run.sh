#!/usr/bin/env bash
# What building costs, in CPU seconds (user and system, all cores): they say more than a clock on a machine with other work, though a busy
# neighbour on the same core still makes them larger. Prints a table; takes half an hour on two cores.
#
#     bash benches/build/run.sh [FOLDER]        FOLDER: target/build-bench, is emptied
set -euo pipefail
cd "$(dirname "$0")/../.."

readonly root=$PWD folder=${1:-target/build-bench}
rm -rf "$folder"
mkdir -p "$folder/user/src"
export CARGO_TARGET_DIR="$root/$folder/out"

# A program of 850 lines that optimises trajectories: five examples as modules of one program.
cat >"$folder/user/Cargo.toml" <<END
[package]
name = "user"
version = "0.0.0"
edition = "2024"
[dependencies]
dualbody = { path = "$root" }
nalgebra = "0.35"
indicatif = "0.18.6"
[workspace]
END
cp examples/common/mod.rs "$folder/user/src/common.rs"
printf '#![allow(dead_code)]\nmod common;\n' >"$folder/user/src/main.rs"
calls=""
for example in hopper cartpole_swing_up quadruped_stand arm_reach mpc_cartpole; do
  sed -e 's/^mod common;$/use crate::common;/' -e 's/^fn main()/pub fn main()/' "examples/$example.rs" >"$folder/user/src/$example.rs"
  printf 'mod %s;\n' "$example" >>"$folder/user/src/main.rs"
  calls+="    $example::main()?;"$'\n'
done
printf 'fn main() -> Result<(), Box<dyn std::error::Error>> {\n%s    Ok(())\n}\n' "$calls" >>"$folder/user/src/main.rs"

# cost NAME COMMAND...: CPU seconds of a command
cost() {
  local name=$1
  shift
  # `times` must not run in a subshell, which has children of its own.
  times >"$folder/before"
  "$@" >"$folder/log" 2>&1 || { cat "$folder/log"; exit 1; }
  times >"$folder/after"
  printf '%-66s %7.0f\n' "$name" "$(cat "$folder/before" "$folder/after" | awk '
    NR % 2 == 0 { gsub(/m/, " "); gsub(/s/, ""); s = $1 * 60 + $2 + $3 * 60 + $4 - s }
    END { print s }')"
}

printf '%-66s %7s\n' "" "CPU s"
cost "the first command of the README, clean" cargo build --release --example cartpole
touch examples/cartpole.rs
cost "a changed line in that example" cargo build --release --example cartpole
# Last, for it makes the library older than its sources also in the form that examples take. Without what tests and examples need, crates below it have
# other features, and are built once more.
cargo build --release --lib >/dev/null 2>&1
cost "the library alone, again" bash -c "touch src/lib.rs; cargo build --release --lib"
cost "the second command of the README without running, clean" cargo test --no-run --features plot,transcription
(cd "$folder/user" && cargo build --release >/dev/null 2>&1)
touch "$folder/user/src/main.rs"
cost "a program of 850 lines with Ddp, again" cargo build --release --manifest-path "$folder/user/Cargo.toml"
