#!/usr/bin/env bash
# PLC programs of others, right and with the usual mistakes, are judged from what `sim --record-bus` saw of them.
#
# Usage: handshake.sh PATH-TO-ENCORING PYTHON
set -euo pipefail
encoring=$1 python=$2
here=$(dirname "$0")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

cc -Wall -Werror -o "$folder/handshake" "$here/handshake.c" $(pkg-config --cflags --libs libmodbus)

# The rules that a program breaks, as the referee names them. What must come between two ring cycles is done on a slow ring.
broken_by() { # VARIANT SPEED PROGRAM...
  local variant=$1 speed=$2 file="$folder/bus.csv" line sim ended=0
  shift 2
  mkfifo "$folder/lines"
  "$encoring" sim "$here/handshake.toml" --web off --modbus 127.0.0.1:0 --speed "$speed" --format json \
    --record-bus "$file" --overwrite >"$folder/lines" 2>/dev/null &
  sim=$!
  {
    read -r line
    "$@" "$(sed 's/.*"modbus":"127.0.0.1:\([0-9]*\)".*/\1/' <<<"$line")" "$variant" >&2 || ended=$?
    kill -TERM "$sim"
    cat >/dev/null
  } <"$folder/lines"
  wait "$sim"
  rm "$folder/lines"
  [ "$ended" -eq 0 ] || return "$ended"
  { "$encoring" referee "$file" --format json || [ $? -eq 1 ]; } | sed -n 's/.*"rule":"\([a-z_]*\)".*/\1/p' | tr '\n' ' '
}

judged=0
expect() { # VARIANT SPEED RULES
  local program found
  for program in pymodbus libmodbus; do
    case $program in
      pymodbus) found=$(broken_by "$1" "$2" "$python" "$here/handshake.py") ;;
      libmodbus) found=$(broken_by "$1" "$2" "$folder/handshake") ;;
    esac
    if [ "${found% }" != "$3" ]; then
      echo "$program, $1: found '${found% }' instead of '$3'" >&2
      exit 1
    fi
    judged=$((judged + 1))
  done
}

expect right 1 ""
expect together 1 "data_with_service_bit"
expect torn 0.02 "torn_words"
expect changed 0.02 "data_changed_in_service"
expect dropped 0.02 "dropped_before_acknowledgement"
expect kept 1 "never_dropped"
expect hasty 0.02 "next_before_end"
expect unchecked 1 "no_data_check"
expect backwards 1 "wrong_direction"
echo "foreign PLC programs: $judged judged as they should be"
