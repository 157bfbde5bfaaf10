#!/usr/bin/env bash
# Compiles the kernels of some robots to machine code and compares registers, spilled bytes and instructions with counts.txt. It needs no GPU; with the
# version of NVRTC that the file names, counts are the same on any machine, but for what the C library of the machine rounds otherwise in constants.
#
#     bash crates/dualbody-cuda/benches/kernels/run.sh                fails if a kernel has over 5 % more instructions or spilled bytes than counts.txt says
#     bash crates/dualbody-cuda/benches/kernels/run.sh ur5            the same for one robot
#     bash crates/dualbody-cuda/benches/kernels/run.sh --update       writes counts.txt
#     bash crates/dualbody-cuda/benches/kernels/run.sh --print NAME+  prints all kernels of a robot, its derivatives too where they take long to compile
#
# NVRTC is installed from PyPI below target/; without it nothing is compared, and that is said.
set -euo pipefail
cd "$(dirname "$0")/../../../.."

readonly counts=crates/dualbody-cuda/benches/kernels/counts.txt
readonly tolerance=5 # per cent

mode=check
case "${1:-}" in --update | --print) mode=${1#--}; shift ;; esac

library=$(bash crates/dualbody-cuda/nvrtc.sh) || { echo "SKIPPED: no kernels counted: NVRTC cannot be installed"; exit 0; }

# The profile and features of the tests, for which all is built already.
measure() {
  LD_LIBRARY_PATH="$library${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}" \
    cargo bench --quiet --profile dev --workspace --features full --bench kernels -- "$@"
}

if [ "$mode" = print ]; then
  measure "$@"
  exit
fi

measured=$(mktemp)
trap 'rm -f "$measured"' EXIT
measure "$@" >"$measured"

if [ "$mode" = update ]; then
  {
    echo "# NVRTC $(basename "$(find "$library" -name 'libnvrtc-builtins.so.*' | head -n 1)" | sed 's/.*\.so\.//'); seconds of processor time to compile; written by run.sh --update"
    cat "$measured"
  } >"$counts"
  cat "$counts"
  exit
fi

[ -e "$counts" ] || { echo "$counts is missing: run.sh --update writes it" >&2; exit 1; }
awk -v tolerance="$tolerance" '
  /^#/ { next }
  NR == FNR { registers[$1] = $3; spilled[$1] = $4; instructions[$1] = $5; next }
  !($1 in registers) { printf "%-34s NOT IN THE FILE\n", $1; bad++; next }
  {
    grew = $5 > instructions[$1] * (1 + tolerance / 100) || $4 > spilled[$1] * (1 + tolerance / 100) + 64
    printf "%-34s registers %3d -> %3d  spilled %6d -> %6d  instructions %6d -> %6d  %5.1f s  %s\n",
      $1, registers[$1], $3, spilled[$1], $4, instructions[$1], $5, $6, grew ? "GREW" : ""
    bad += grew
  }
  END {
    if (bad) {
      print bad " kernels grew by over " tolerance " %, or are not in the file. If it is worth that: run.sh --update, and commit counts.txt"
      exit 1
    }
  }' "$counts" "$measured"
