#!/usr/bin/env bash
# GTKWave's own converters read recordings of the line, and find the same changes in both formats.
set -euo pipefail
program=$(realpath "$1")
here=$(dirname "$(realpath "$0")")
if ! command -v fst2vcd >/dev/null || ! command -v vcd2fst >/dev/null; then
  apt-get update -qq && apt-get install -y -qq gtkwave
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

# A ring of both kinds with everything that a line can suffer, and one that just runs, beyond a section of an FST.
"$program" sim --example >calm.toml
cat >troubled.toml <<'SCENARIO'
version = 1
[[device]]
position = 0
model = "la-66"
[[device]]
position = 1
model = "ce-65-m"
[[event]]
at_s = 0.02
segment = 1
line = { flips = 2000 }
for_s = 0.05
[[event]]
at_s = 0.1
segment = 2
line = "silent"
for_s = 0.1
[[event]]
at_s = 0.3
position = 0
set = { supply_v = 0.0 }
[[event]]
at_s = 0.4
position = 0
set = { supply_v = 24.0 }
SCENARIO

passed=0
check() {
  local ring=$1 time=$2
  shift 2
  for format in vcd fst; do
    "$program" sim "$ring.toml" --for "$time" --speed max --modbus off --overwrite --record "ring.$format" --words "$@" >/dev/null
  done
  fst2vcd ring.fst >from-fst.vcd
  vcd2fst ring.vcd repacked.fst >/dev/null
  fst2vcd repacked.fst >repacked.vcd
  python3 "$here/same_changes.py" ring.vcd from-fst.vcd repacked.vcd
  passed=$((passed + 1))
}

check calm 5s --lines
check calm 5s
check troubled 600ms --lines
check troubled 600ms
echo "gtkwave: $passed passed, 0 failed"
