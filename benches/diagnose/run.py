"""Rows a second of `encoring diagnose` beside a pandas script and the bare csv reader, and its memory by rows."""

import argparse
import os
import pathlib
import statistics
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).parent


def measured(command, source=None):
    begun = time.monotonic()
    child = subprocess.Popen(list(map(str, command)), stdin=source, stdout=subprocess.PIPE)
    printed = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    return time.monotonic() - begun, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, printed, os.waitstatus_to_exitcode(status)


def compare(options):
    file = options.folder / "axis.csv"
    with file.open("wb") as out:
        subprocess.run([options.programs / "axis_log", str(options.rows)], stdout=out, check=True)
    commands = {
        "pandas": [sys.executable, HERE / "jumps.py", file],
        "bare csv reader": [options.programs / "bare_csv", file],
        "encoring diagnose": [options.programs / "encoring", "diagnose", file],
        "with --plot": [options.programs / "encoring", "diagnose", file, "--overwrite", "--plot", options.folder / "axis.svg"],
    }
    runs = {name: [] for name in commands}
    for number in range(options.rounds):
        order = list(commands)
        for name in order[number % len(order):] + order[:number % len(order)]:
            runs[name].append(measured(commands[name]))
    wrong = options.rows // 250_007
    # Long names of files wrap the lines.
    found = " ".join(runs["encoring diagnose"][0][3].decode().split()).count("one wrong bit")
    assert found == wrong, (found, wrong)
    print(f"{options.rows} rows, {file.stat().st_size / 1e6:.0f} MB, {wrong} wrong bits found, {options.rounds} rounds\n")
    print("| | rows a second, median | processor, s | most memory |\n|---|--:|--:|--:|")
    for name, all_runs in runs.items():
        rate = statistics.median(options.rows / run[0] for run in all_runs)
        processor = statistics.median(run[1] for run in all_runs)
        print(f"| {name} | {rate / 1e6:.2f} million | {processor:.2f} | {max(run[2] for run in all_runs):.0f} MB |")
    for peer in ("pandas", "bare csv reader"):
        ratio = statistics.median(theirs[1] / ours[1] for theirs, ours in zip(runs[peer], runs["encoring diagnose"]))
        wall = statistics.median(theirs[0] / ours[0] for theirs, ours in zip(runs[peer], runs["encoring diagnose"]))
        print(f"\nto {peer}: {wall:.2f} times as fast by the clock, {ratio:.2f} by the processor's time")


def memory(options):
    print("\n| rows through a pipe | seconds | most memory |\n|--:|--:|--:|")
    rows = 10_000
    while rows <= options.most:
        source = subprocess.Popen([options.programs / "axis_log", str(rows)], stdout=subprocess.PIPE)
        seconds, _, most, _, code = measured([options.programs / "encoring", "diagnose", "-"], source.stdout)
        assert source.wait() == 0 and code in (0, 1), code
        print(f"| {rows} | {seconds:.1f} | {most:.1f} MB |", flush=True)
        rows *= 10


def main():
    reader = argparse.ArgumentParser()
    reader.add_argument("programs", type=pathlib.Path)
    reader.add_argument("folder", type=pathlib.Path)
    reader.add_argument("--rows", type=int, default=2_000_000)
    reader.add_argument("--rounds", type=int, default=5)
    reader.add_argument("--most", type=int, default=10_000_000)
    options = reader.parse_args()
    compare(options)
    memory(options)


main()
