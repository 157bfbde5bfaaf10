#!/usr/bin/env bash
# Measures this crate beside Pinocchio and MuJoCo on the same robots and prints a table of ratios, then that of batches.
#
#     bash benches/peers/run.sh [FOLDER [REPETITIONS]]      FOLDER: target/peers, REPETITIONS: 9
#
# Into FOLDER go a Python environment with both engines and the robots, all from PyPI, and two programs in C++. The first run takes
# ten minutes and 5 GiB of memory, most of it to compile Pinocchio's templates. For figures to be quoted: an idle machine.
set -euo pipefail
cd "$(dirname "$0")/../.."

readonly folder=${1:-target/peers} repetitions=${2:-9}
readonly packages=("pin==4.1.0" "mujoco==4.0.0" "example-robot-data==5.0.0")
readonly cxxflags="-O3 -march=native -DNDEBUG" rustflags="-C target-cpu=native"

fail() {
  printf '%s\n' "$1" >&2
  exit 1
}

command -v c++ >/dev/null || fail "no C++ compiler (Debian: apt-get install g++)"
eigen=${EIGEN_INCLUDE:-/usr/include/eigen3}
[ -e "$eigen/Eigen/Core" ] ||
  fail "no headers of Eigen in $eigen (Debian: apt-get install libeigen3-dev; elsewhere: EIGEN_INCLUDE=<folder with Eigen/>)"

mkdir -p "$folder"
python="$folder/venv/bin/python"
[ -x "$python" ] || python3 -m venv "$folder/venv" || fail "no Python environment (Debian: apt-get install python3-venv)"
"$python" -m pip --quiet --disable-pip-version-check install "${packages[@]}"
place() { "$python" -c "import pathlib, $1; print(pathlib.Path($1.__file__).resolve().parents[$2])"; }
mujoco=$(place mujoco 0)
prefix=$(place pinocchio 4)

# build NAME ARGUMENTS...: NAME.cpp to a program, unless it is up to date
build() {
  local name=$1 target="$folder/${1}_times"
  shift
  if [ "$target" -nt "benches/peers/$name.cpp" ] && [ "$target" -nt benches/peers/timing.hpp ]; then return; fi
  printf 'compiling %s\n' "$target" >&2
  # shellcheck disable=SC2086 # several flags in one string
  c++ -std=c++17 -w $cxxflags "benches/peers/$name.cpp" -o "$target" "$@"
}

build mujoco -I"$mujoco/include" "$mujoco"/libmujoco.so.* -Wl,-rpath,"$mujoco"
# Pinocchio's list of joints is longer than what Boost takes without being asked.
build pinocchio -isystem "$prefix/include" -isystem "$eigen" -L"$prefix/lib" -lboost_serialization -Wl,-rpath,"$prefix/lib" \
  -DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS -DBOOST_MPL_LIMIT_LIST_SIZE=30 -DBOOST_MPL_LIMIT_VECTOR_SIZE=30 \
  -DBOOST_FUSION_INVOKE_MAX_ARITY=12

# Absolute, for Criterion takes it from the folder of the benches.
built=$(realpath -m "${CARGO_TARGET_DIR:-target}/native")
readonly built
native() { CARGO_TARGET_DIR="$built" RUSTFLAGS="$rustflags" cargo bench --quiet "$@"; }
ours=$(native --bench peers --no-run --message-format=json | sed -n 's/.*"executable":"\([^"]*\)".*/\1/p' | tail -n 1)

PYTHONDONTWRITEBYTECODE=1 "$python" benches/peers/compare.py "$folder" "$ours" "$repetitions" \
  "ours: release profile, \`$rustflags\`" \
  "Pinocchio: from its headers, \`$cxxflags\`, the faster of its conventions" \
  "MuJoCo: its wheel; Euler, explicit damping, no contacts or constraints; forward differences for ∂ step"

# Batches run on both sides' threads, so not in turn with the rest.
native --bench batch -- --noplot >"$folder/batch.log" 2>&1
printf '\n'
"$python" benches/peers/rollout.py "$built"
