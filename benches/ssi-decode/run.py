"""Decodes captures with sigrok-cli and with `encoring ssi decode`: see `run`."""

import argparse
import os
import pathlib
import statistics
import subprocess
import time

RATE = 20_000_000

# A reader that hardly pauses, so that most samples are part of a transfer, and one every millisecond.
READERS = {"dense": "2=500,25,80us", "sparse": "2=500,25,1ms"}


def measured(command):
    """Seconds, processor seconds, most memory in MB, and lines printed."""
    begun = time.monotonic()
    with subprocess.Popen([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as child:
        lines = sum(1 for _ in child.stdout)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    assert child.returncode == 0, (command, child.returncode)
    processor = usage.ru_utime + usage.ru_stime
    return time.monotonic() - begun, processor, usage.ru_maxrss / 1024, lines


def capture(program, file, reader, seconds):
    rate = ["--samplerate", RATE] if file.suffix == ".sr" else []
    measured([program, "ssi", "capture", "--out", file, "--ssi", reader, "--for", f"{seconds}s", *rate])
    return file


def decode(program, file):
    return [program, "ssi", "decode", file, "--clock", "clock", "--data", "data", "--format", "csv"]


def compare(options):
    print("| capture | decoder | samples/s, median | to spi | by the processor's time | most memory |")
    print("|---|---|--:|--:|--:|--:|")
    for name, reader in READERS.items():
        file = capture(options.encoring, options.folder / f"{name}.sr", reader, options.seconds)
        commands = {
            "sigrok-cli, spi": ["sigrok-cli", "-i", file, "-P",
                                "spi:clk=clock:miso=data:cpol=1:cpha=0:wordsize=25", "-A", "spi=miso-data"],
            "sigrok-cli, ssienc": ["sigrok-cli", "-i", file, "-P", "ssienc:clk=clock:data=data:bits=24",
                                   "-A", "ssienc=position:warning"],
            "encoring ssi decode": decode(options.encoring, file),
        }
        runs = {decoder: [] for decoder in commands}
        for number in range(options.rounds):
            order = list(commands)
            for decoder in order[number % 3:] + order[:number % 3]:
                runs[decoder].append(measured(commands[decoder]))
        found = {decoder: {lines for *_, lines in runs} for decoder, runs in runs.items()}
        # sigrok's decoders do not see the end of the capture; ours prints a head.
        counts = [max(lines) for lines in found.values()]
        assert max(counts) - min(counts) <= 2, found
        samples = options.seconds * RATE
        peer = [statistics.median(run[which] for run in runs["sigrok-cli, spi"]) for which in (0, 1)]
        for decoder, all_runs in runs.items():
            seconds, processor = [statistics.median(run[which] for run in all_runs) for which in (0, 1)]
            memory = max(run[2] for run in all_runs)
            print(f"| {name} | {decoder} | {samples / seconds / 1e6:.1f} million | {peer[0] / seconds:.1f} "
                  f"| {peer[1] / processor:.1f} | {memory:.0f} MB |", flush=True)


def large(options):
    print("\n| file | on the disk | samples or rows | seconds | processor | most memory |\n|---|--:|--:|--:|--:|--:|")
    for name in ("large.sr", "large.csv"):
        seconds = options.large
        file = capture(options.encoring, options.folder / name, READERS["dense"], seconds)
        size = file.stat().st_size / 1e6
        if name.endswith(".sr"):
            count = seconds * RATE
        else:
            with file.open("rb") as rows:
                count = sum(1 for _ in rows)
        begun, processor, memory, lines = measured(decode(options.encoring, file))
        print(f"| {name} | {size:.0f} MB | {count} | {begun:.1f} | {processor:.1f} | {memory:.1f} MB |", flush=True)
        file.unlink()


def main():
    reader = argparse.ArgumentParser()
    reader.add_argument("encoring", type=pathlib.Path)
    reader.add_argument("folder", type=pathlib.Path)
    reader.add_argument("--seconds", type=int, default=10)
    reader.add_argument("--rounds", type=int, default=3)
    reader.add_argument("--large", type=int, default=0)
    options = reader.parse_args()
    compare(options)
    if options.large:
        large(options)


main()
