#!/usr/bin/env bash
# The README's commands, typed by a script: mbpoll programs the CE-65-M of the built-in ring.
set -euo pipefail
program=$1
lines=$(mktemp)
"$program" sim --modbus 127.0.0.1:0 >"$lines" &
sim=$!
trap 'kill "$sim" 2>/dev/null || true; rm -f "$lines"' EXIT
until grep -q '^modbus ' "$lines"; do
  kill -0 "$sim"
  sleep 0.05
done
port=$(sed -n 's/^modbus .*://p' "$lines")

out() { mbpoll -m tcp -p "$port" -a 1 -t 4:hex -r 5 127.0.0.1 "$@" >/dev/null; }
in_words() { mbpoll -m tcp -p "$port" -a 1 -t 3:hex -r 5 -c 2 -1 -q 127.0.0.1 | sed -n 's/^\[[0-9]*\]:[[:space:]]*0x//p' | tr -d '\n'; }
expect() {
  local got
  for _ in $(seq 100); do
    got=$(in_words)
    [[ $got =~ $2 ]] && { echo "$1: $got"; return; }
  done
  echo "$1: got $got, expected $2" >&2
  exit 1
}

out 0x4200 0x270F
expect "normal mode" '^00'
out 0xC200 0x270F
expect "measuring length" '^C200270F$'
out 0x4200 0x270F
expect "end of the service" '^00'
out 0x4300 0x000A
out 0xC300 0x000A
expect "numerator" '^C300000A$'
out 0x0000 0x0000
expect "end of the service" '^00'
out 0x0800 0x0000
out 0x8800 0x0000
expect "data check" '^88000000$'
out 0x0800 0x0000
expect "position within 0..9999" '^0000[0-2][0-9A-F]{3}$'
diagnosis=$(mbpoll -m tcp -p "$port" -a 1 -t 4:hex -r 901 -c 6 -1 -q 127.0.0.1 | sed -n 's/^\[[0-9]*\]:[[:space:]]*0x//p' | tr '\n' ' ')
[ "$diagnosis" = "00E0 0000 0000 0000 0000 0000 " ] || { echo "diagnosis: got $diagnosis" >&2; exit 1; }
echo "status, parameter, faults: $diagnosis"
kill -TERM "$sim"
wait "$sim"
echo "mbpoll: 1 passed, 0 failed"
