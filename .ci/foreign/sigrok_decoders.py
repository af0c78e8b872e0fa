"""What sigrok's decoders find in captures, beside what `encoring ssi decode` finds, and beside the positions of the shaft.

Usage: sigrok_decoders.py PATH-TO-ENCORING

sigrok's own decoder for SPI knows nothing of an SSI: it takes a bit at each falling edge. What it says of a capture is
compared with words that are computed here. The decoder of this project, sigrok/ssienc, is compared with `ssi decode`
on sound and on troubled captures, and `ssi decode` reads what sigrok-cli wrote.
"""

import collections
import concurrent.futures
import json
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile
import zipfile

ENCORING = pathlib.Path(sys.argv[1]).resolve()
SIGROK = pathlib.Path(__file__).resolve().parents[2] / "sigrok"
SEED = 20261127
RATE = 20_000_000
ROWS = 60
# How often which fault was told.
FAULTS = collections.Counter()


class Format:
    def __init__(self, bits, code="binary", repetition=False, firmware="41/1997"):
        self.bits, self.code, self.repetition, self.firmware = bits, code, repetition, firmware
        self.ak40 = bits == 31 and firmware == "41/1997" and not repetition
        self.width = 24 if repetition else 32 if self.ak40 else bits

    def encoring(self):
        options = ["--bits", str(self.bits), "--code", self.code, "--firmware", self.firmware]
        return options + ["--repetition"] * self.repetition

    def ssienc(self, **more):
        options = {
            "clk": "clock", "data": "data", "bits": self.bits, "code": self.code,
            "ak40": "yes" if self.firmware == "41/1997" else "no",
            "repetition": "yes" if self.repetition else "no", **more,
        }
        return ":".join(["ssienc", *(f"{name}={value}" for name, value in options.items())])

    def field(self, position):
        """The bits that the encoder sends for a position, from the manual's words [CE-65 3.2.6]."""
        if self.ak40:
            ones = format(position, "b").count("1")
            return format(position, "031b") + ("0" if ones % 2 else "1")
        word = position ^ position >> 1 if self.code == "gray" else position
        return format(word, "032b")[-self.width:]

    def __str__(self):
        return " ".join(self.encoring())


def run(*command, expected=(0,)):
    environment = {**os.environ, "SIGROKDECODE_DIR": str(SIGROK)}
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, env=environment, check=False)
    assert done.returncode in expected, f"{command}: {done.returncode}: {done.stderr}"
    return done.stdout


def scenario(folder, form, positions):
    """An encoder whose shaft is somewhere else each millisecond."""
    rows = "".join(f"{number * 1000},{position}\n" for number, position in enumerate(positions))
    (folder / "shaft.csv").write_text("time_us,raw\n" + rows)
    (folder / "ring.toml").write_text(
        'version = 1\n[[device]]\nposition = 0\nmodel = "ce-65-m"\n'
        f'firmware = "{form.firmware}"\nmotion = {{ kind = "csv", file = "shaft.csv" }}\n'
    )
    return folder / "ring.toml"


def capture(folder, form, chance, *options, name="capture.sr"):
    positions = [chance.randrange(1 << 24) for _ in range(ROWS)]
    file = folder / name
    source = scenario(folder, form, positions)
    rate = ["--samplerate", RATE] if name.endswith(".sr") else []
    run(ENCORING, "ssi", "capture", source, "--out", file, *form.encoring(), "--for", "12ms", *rate, *options)
    return file, positions


def decoded(file, form, *options):
    lines = run(ENCORING, "ssi", "decode", file, *form.encoring(), "--clock", "clock", "--data", "data", *options,
                "--format", "json", expected=(0, 1, 3))
    return [json.loads(line) for line in lines.splitlines()]


def annotations(file, *decoders):
    """What each decoder says, with the first and last sample of it."""
    kind = ["-I", "vcd"] if file.suffix == ".vcd" else []
    stacks = [part for decoder in decoders for part in ("-P", decoder)]
    shown = [f"{decoder.split(':')[0]}" for decoder in decoders]
    shown = ["-A", ",".join("spi=miso-data" if name == "spi" else name for name in shown)]
    lines = run("sigrok-cli", *kind, "-i", file, *stacks, *shown, "--protocol-decoder-samplenum").splitlines()
    found = {"spi": [], "ssienc": []}
    for line in lines:
        first, last, decoder, text = re.fullmatch(r"(\d+)-(\d+) (\w+)-\d+: (.*)", line).groups()
        found[decoder].append((int(first), int(last), text))
    return found


def transfers(found, rate):
    """What ssienc says, as `ssi decode` says it. A bit never is as long as a transfer, so it has a time of its own."""
    told = {}
    for first, last, text in found:
        told.setdefault((first, last), []).append(text)
    result = []
    for (first, _), texts in sorted(told.items()):
        clocks = [re.match(r"(\d+) clocks", text) for text in texts]
        clocks = [int(match[1]) for match in clocks if match and "bring" not in match.string]
        if not clocks:
            continue
        field = next((text for text in texts if re.fullmatch(r"[01]{2,}|-", text)), "")
        position = [int(text.split()[1]) for text in texts if text.startswith("Position ")]
        faults = [text.split(":")[0] for text in texts if re.match(r"[a-z_]+: ", text)]
        result.append({
            "time_ns": first * 1_000_000_000 // rate, "clocks": clocks[0], "field": field.strip("-"),
            "position": position[0] if position else None, "fault": faults[0] if faults else None,
        })
    return result


def agree(ours, theirs, what):
    """sigrok says nothing of a transfer whose end it does not see."""
    if len(ours) == len(theirs) + 1:
        ours = ours[:-1]
    for number, (one, other) in enumerate(zip(ours, theirs)):
        FAULTS[one["fault"]] += 1
        one = {**one, "field": one["field"] if len(one["field"]) > 1 else ""}
        assert one == other, f"{what}, transfer {number}: ssi decode {one}, ssienc {other}"
    assert len(ours) == len(theirs), f"{what}: ssi decode found {len(ours)} transfers, ssienc {len(theirs)}"
    return len(ours)


def follows(part, whole):
    return any(whole[start:start + len(part)] == part for start in range(len(whole) - len(part) + 1))


def sound(folder, form, chance):
    """One clock more than the field has bits: the decoder for SPI knows the bits, too."""
    file, positions = capture(folder, form, chance)
    spi = f"spi:clk=clock:miso=data:cpol=1:cpha=0:wordsize={form.width + 1}"
    found = annotations(file, spi, form.ssienc())
    words = [format(int(text, 16), f"0{form.width + 1}b") for _, _, text in found["spi"]]
    assert len(words) >= 10 and all(word[0] == "1" for word in words), f"{form}: the decoder for SPI found {words}"
    fields = [word[1:] for word in words]
    assert follows(fields, [form.field(position) for position in positions]), f"{form}: {fields}, shaft at {positions}"
    ours = decoded(file, form)
    assert [one["field"] for one in ours][:len(fields)] == fields, f"{form}: the decoder for SPI found other bits"
    agree(ours, transfers(found["ssienc"], RATE), form)
    at = next(number for number, position in enumerate(positions) if form.field(position) == fields[0])
    shown = json.loads(run(ENCORING, "ssi", "encode", positions[at], *form.encoring(), "--format", "json"))
    assert shown["falling"] == words[0], f"{form}: ssi encode says {shown}, the decoder for SPI {words[0]}"
    return len(words)


def troubled(folder, form, chance, options, name, more):
    """Whatever the line suffers: ssienc says what `ssi decode` says."""
    file, _ = capture(folder, form, chance, *options, name=name)
    rate = RATE if name.endswith(".sr") else 1_000_000_000
    theirs = transfers(annotations(file, form.ssienc(**more))["ssienc"], rate)
    flags = [part for key, value in more.items() for part in (f"--{key}", value)]
    return agree(decoded(file, form, *flags), theirs, f"{form} {options} {more}")


def exported(folder, form, chance):
    """`ssi decode` reads what sigrok-cli wrote."""
    file, _ = capture(folder, form, chance)
    ours = decoded(file, form)
    for name, kind in [("again.sr", "srzip"), ("again.vcd", "vcd"), ("again.csv", "csv")]:
        run("sigrok-cli", "-i", file, "-o", folder / name, "-O", kind)
        assert decoded(folder / name, form) == ours, f"{form}: {name} says something else"
    return 3 * len(ours)


def lost_pulse(folder, form, chance):
    """A pulse is missing in the capture: one transfer is wrong, and the next is right. Not so for SPI."""
    file, positions = capture(folder, form, chance)
    with zipfile.ZipFile(file) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    samples = bytearray(parts["logic-1-1"])
    clock = bytes(sample & 1 for sample in samples)
    starts = [at + 1 for at in range(len(clock) - 1) if clock[at] and not clock[at + 1]]
    at = starts[2 * (form.width + 1) + 7]
    while not clock[at]:
        samples[at] |= 1
        at += 1
    parts["logic-1-1"] = bytes(samples)
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in parts.items():
            archive.writestr(name, data)
    spi = f"spi:clk=clock:miso=data:cpol=1:cpha=0:wordsize={form.width + 1}"
    found = annotations(file, spi, form.ssienc(clocks=form.width + 1))
    told = transfers(found["ssienc"], RATE)
    assert [one["fault"] for one in told].count("clocks") == 1 and told[2]["fault"] == "clocks", told
    fields = [form.field(position) for position in positions]
    assert follows([one["field"] for one in told[3:]], fields), f"{form}: ssienc did not find its way back: {told}"
    words = [format(int(text, 16), f"0{form.width + 1}b")[1:] for _, _, text in found["spi"]]
    assert not follows(words[3:], fields), f"{form}: the decoder for SPI found its way back, too"
    return agree(decoded(file, form, "--clocks", form.width + 1), told, f"{form}, a pulse lost")


def cases(chance):
    forms = [Format(bits, code) for bits in range(8, 33) for code in ("binary", "gray")]
    forms += [Format(31, code, firmware="40/1997") for code in ("binary", "gray")]
    forms += [Format(24, code, repetition=True) for code in ("binary", "gray")]
    yield from (("sound", sound, form) for form in forms)
    ak40, repeated = Format(31), Format(24, repetition=True)
    yield from (("exported", exported, form) for form in (Format(25), ak40, Format(14, "gray")))
    yield from (("lost pulse", lost_pulse, form) for form in (Format(24), ak40, Format(13, "gray")))
    for _ in range(30):
        form = chance.choice(forms)
        clocks = chance.randint(form.width, 3 * form.width)
        edge = chance.choice(["falling", "rising"])
        yield "n to 3n clocks", troubled, form, ["--clocks", clocks], "capture.sr", {"edge": edge}
    faults = [["--fault", fault] for fault in (
        "ssi_lost=20000", "ssi_added=20000", "ssi_flips=20000", "ssi_skew=900", "ssi_delay=1100", "ssi_low", "ssi_high")]
    faults += [["--noise", "30000"], ["--jitter", "300"], ["--noise", "5000", "--jitter", "100"], ["--clocks", "12"]]
    faults += [["--ssi", "0=45,25,2ms"], ["--ssi", "0=1300,25,2ms"]]
    for options in faults:
        for form in (ak40, repeated, chance.choice(forms)):
            clocks = [] if "--clocks" in options else ["--clocks", 2 * form.width + 4 if form.repetition else form.width + 1]
            more = {"edge": chance.choice(["falling", "rising"])}
            if clocks and chance.random() < 0.5:
                more["clocks"] = clocks[1]
            name = chance.choice(["capture.sr", "capture.sr", "capture.vcd"])
            yield "troubled", troubled, form, [*options, *clocks], name, more


def one(number, case):
    what, check, *rest = case
    chance = random.Random(f"{SEED} {number}")
    with tempfile.TemporaryDirectory() as folder:
        form, *more = rest
        return what, check(pathlib.Path(folder), form, chance, *more)


def main():
    counts = {}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for what, count in pool.map(one, *zip(*enumerate(cases(random.Random(SEED))))):
            captures, found = counts.get(what, (0, 0))
            counts[what] = captures + 1, found + count
    for what, (captures, found) in counts.items():
        print(f"sigrok: {what}: {captures} captures, {found} transfers")
    print("sigrok: told:", ", ".join(f"{fault or 'no fault'} {count}" for fault, count in FAULTS.most_common()))
    missing = {"clocks", "parity", "repetition", "trailing_high", "stuck_low", "stuck_high", "clock_limit"} - {*FAULTS}
    assert not missing, f"no capture had the faults {missing}"


main()
