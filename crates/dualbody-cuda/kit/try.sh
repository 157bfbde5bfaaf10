#!/usr/bin/env bash
# Tries a kit of one robot on a machine without a GPU: a folder of its own, a path with a dozen programs on it, and a driver that starts nothing but counts what it is asked to start.
#
#     bash crates/dualbody-cuda/kit/try.sh
#
# It says what it skips where NVRTC or a C compiler cannot be had.
set -euo pipefail
cd "$(dirname "$0")/../../.."

readonly target=${CARGO_TARGET_DIR:-target} crate=crates/dualbody-cuda robot=cartpole
command -v cc >/dev/null || { echo "SKIPPED: there is no C compiler for the driver without a GPU"; exit 0; }

fail() {
  printf 'FAILED: %s\n' "$1" >&2
  [ $# -lt 2 ] || cat "$2" >&2
  exit 1
}

# Programs that run.sh may use, and nothing else: no compiler, Rust or Python.
place() {
  mkdir -p "$1/bin" "$1/driver"
  for program in sh env uname dirname mkdir ln tar gzip sed cat timeout; do
    ln -s "$(command -v "$program")" "$1/bin/$program"
  done
  cp -r "$2" "$1/kit"
}

# Runs the kit there: the folder of a driver, and assignments such as PARTS of run.sh.
run() {
  local folder=$1 driver=$2 code=0
  shift 2
  env -i PATH="$folder/bin" LD_LIBRARY_PATH="$driver" STUB_COUNTS="$folder/counts" "$@" >"$folder/printed" 2>&1 || code=$?
  echo "$code"
}

counted() { sed -n "s/^$1 //p" "$folder/counts"; }

NATIVE=${NATIVE-1} KIT=$target/kit-try ARCHITECTURES=90 bash $crate/kit.sh assets/$robot.urdf
tar -tzf "$target/kit-try/packed.tar.gz" | grep -c "cubin$" >/dev/null || { echo "SKIPPED: a kit without kernels is not run"; exit 0; }

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
place "$folder" "$target/kit-try"
cc -shared -fPIC -O1 -Wall -Wextra -Werror -o "$folder/driver/libcuda.so" $crate/kit/stub.c

code=$(run "$folder" "$folder/none" "$folder/kit/run.sh")
[ "$code" = 2 ] && grep -q "no CUDA driver" "$folder/printed" || fail "without a driver the code is $code" "$folder/printed"

# Nothing is computed, so all that is compared is wrong; but every kernel is found, loaded and started, without NVRTC.
code=$(run "$folder" "$folder/driver" "$folder/kit/run.sh")
[ "$code" = 1 ] || fail "with the driver that computes nothing the code is $code" "$folder/printed"
tail -n 1 "$folder/printed" | grep -q " rows, .* failed, in " || fail "the table does not come last" "$folder/printed"
grep -q "NVRTC: none" "$folder/printed" && ! grep -q "there is no NVRTC" "$folder/printed" || fail "NVRTC was asked for" "$folder/printed"
launches=$(counted launches) modules=$(counted modules)
[ "$modules" -ge 20 ] && [ "$launches" -ge 100 ] || fail "$modules modules, $launches launches" "$folder/printed"
results=$folder/kit/results/results.json
for word in '"part": "correct"' '"part": "rates"' '"per_second": ' '"left_out": \[\]'; do
  grep -q "$word" "$results" || fail "the JSON has no $word" "$results"
done
! command -v python3 >/dev/null || python3 -m json.tool "$results" >"$folder/json" || fail "no JSON" "$results"

# Parts that are chosen, and a time that is over at once: what was done is kept.
code=$(run "$folder" "$folder/driver" SECONDS_AT_MOST=0 RESULTS="$folder/other" "$folder/kit/run.sh" rates)
grep -q "left out, for the time was over: rate: $robot" "$folder/printed" || fail "nothing was left out" "$folder/printed"
grep -q "at most: " "$folder/printed" || fail "what was done is not kept" "$folder/printed"
! grep -q "off by" "$folder/printed" || fail "a part ran that was not chosen" "$folder/printed"

echo "a kit of $robot: $modules modules and $launches launches with a driver that computes nothing"
