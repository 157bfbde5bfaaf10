#!/usr/bin/env bash
# Counts the instructions of the hottest functions and compares them with counts.txt: unlike times, counts are the same on a busy
# machine, so a change that makes the library slower is seen where it is made.
#
#     bash benches/instructions/run.sh             fails if a function needs over 5 % more than counts.txt says
#     bash benches/instructions/run.sh --update    writes counts.txt, after a change that is worth its price or an improvement
#
# Needs valgrind, which it installs where it may; without it nothing is compared, and that is said.
set -euo pipefail
cd "$(dirname "$0")/../.."

readonly counts=benches/instructions/counts.txt
readonly tolerance=5 # per cent: above what a new compiler changes by chance
# Of the vector instructions after it common versions of valgrind do not know all, so the code for wider vectors, which the library else picks
# when it runs, is left out.
readonly cpu=x86-64-v2

skip() {
  printf 'SKIPPED: no instructions counted: %s\n' "$1"
  exit 0
}

install_valgrind() {
  command -v apt-get >/dev/null || return 1
  local sudo=()
  [ "$(id -u)" = 0 ] || sudo=(sudo -n)
  { "${sudo[@]}" apt-get update -qq && "${sudo[@]}" apt-get install -y -qq valgrind; } >/dev/null 2>&1
}

[ "$(uname -sm)" = "Linux x86_64" ] || skip "they are those of Linux on x86-64"
command -v valgrind >/dev/null || install_valgrind || skip "valgrind is missing (apt-get install valgrind)"

export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-target}/instructions" RUSTFLAGS="-C target-cpu=$cpu --cfg dualbody_one_width"
program=$(cargo bench --quiet -p dualbody-benches --no-default-features --features dualbody/formats --bench instructions --no-run --message-format=json |
  sed -n 's/.*"executable":"\([^"]*\)".*/\1/p' | tail -n 1)
compiler=$(rustc --version)

# `rep stosb` and `rep movsb`, which the C library uses from some kilobytes on, count as one instruction for each byte; without them its loops are
# counted. A matrix that is zeroed by a call and no longer by a loop would else look as if a function took 5 % more.
export GLIBC_TUNABLES=glibc.cpu.x86_rep_stosb_threshold=100000000:glibc.cpu.x86_rep_movsb_threshold=100000000

# One line a function: name, instructions per call.
measure() {
  local name calls output total
  "$program" | while read -r name calls; do
    output=$(valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect='instructions::measured*' \
      "$program" "$name" 2>&1) || { printf '%s\n' "$output" >&2; return 1; }
    total=$(printf '%s\n' "$output" | sed -n 's/.*Collected : \([0-9]*\).*/\1/p')
    [ "${total:-0}" -gt 0 ] || { printf 'nothing was counted for %s:\n%s\n' "$name" "$output" >&2; return 1; }
    printf '%s %s\n' "$name" "$((total / calls))"
  done
}

measured=$(mktemp)
trap 'rm -f "$measured"' EXIT
measure >"$measured"

if [ "${1:-}" = --update ]; then
  {
    echo "# Instructions per call of function/scalar/robot, $cpu, $compiler; written by run.sh --update"
    cat "$measured"
  } >"$counts"
  cat "$counts"
  exit
fi

[ -e "$counts" ] || { echo "$counts is missing: bash benches/instructions/run.sh --update writes it" >&2; exit 1; }
printf 'compiler: %s; file: %s\n' "$compiler" "$(head -n 1 "$counts")"
awk -v tolerance="$tolerance" '
  /^#/ { next }
  NR == FNR { before[$1] = $2; next }
  !($1 in before) { printf "%-42s %10s -> %10d  NOT IN THE FILE\n", $1, "", $2; bad++; next }
  {
    change = 100 * ($2 - before[$1]) / before[$1]
    verdict = change > tolerance ? "GREW" : change < -tolerance ? "better" : ""
    printf "%-42s %10d -> %10d  %+6.1f %%  %s\n", $1, before[$1], $2, change, verdict
    if (change > tolerance) bad++
    if (change < -tolerance) better++
    delete before[$1]
  }
  END {
    for (name in before) { printf "%-42s %10d -> NOT MEASURED\n", name, before[name]; bad++ }
    if (better) print better " need fewer: bash benches/instructions/run.sh --update keeps it so"
    if (bad) {
      print bad " need over " tolerance " % more than the file says, or are not in it."
      print "If it is worth that: bash benches/instructions/run.sh --update, and commit benches/instructions/counts.txt"
      exit 1
    }
  }' "$counts" "$measured"
