#!/usr/bin/env bash
# sigrok reads our waveforms, and its SPI decoder finds in them the position that the encoder was put to. Then its
# decoders and ours are compared on captures.
set -euo pipefail
program=$(realpath "$1")
here=$(realpath "$(dirname "$0")")
if ! command -v sigrok-cli >/dev/null; then
  apt-get update -qq && apt-get install -y -qq sigrok-cli
fi
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

cat >ring.toml <<'SCENARIO'
version = 1
[[device]]
position = 0
model = "ce-65-m"
motion = { kind = "hold", raw = 9999 }
ssi = { khz = 500, clocks = 25, every_ms = 1 }
SCENARIO
for lines in "" --lines; do
  # shellcheck disable=SC2086
  "$program" sim ring.toml --for 10ms --speed max --modbus off --overwrite --record ring.vcd $lines >/dev/null
  samples=$(sigrok-cli -I vcd -i ring.vcd -O csv | grep -c '^[01],')
  [ "$samples" -gt 1000 ] || { echo "sigrok: $samples samples with '$lines'" >&2; exit 1; }
  # The High of rest, then 24 bits: 270Fh behind a 1.
  words=$(sigrok-cli -I vcd -i ring.vcd \
    -P spi:clk=encoder_0_ssi_clock:miso=encoder_0_ssi_data:cpol=1:cpha=0:wordsize=25 -A spi=miso-data)
  found=$(grep -c ': 100270F$' <<<"$words")
  [ "$found" -ge 8 ] || { printf 'sigrok found with "%s":\n%s\n' "$lines" "$words" >&2; exit 1; }
done
echo "sigrok: $samples samples, $found words of 270Fh"

# As people install it: below the folder of their own data.
mkdir -p data/libsigrokdecode
cp -r "$here/../../sigrok" data/libsigrokdecode/decoders
XDG_DATA_HOME="$folder/data" sigrok-cli -P ssienc --show | grep -q '^ID: ssienc$'
python3 "$here/sigrok_decoders.py" "$program"
