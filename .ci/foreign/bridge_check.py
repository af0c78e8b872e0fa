"""The bus client against a gateway that others wrote: reads, writes and probes through bridge.py, in every layout.

Usage: bridge_check.py PATH-TO-ENCORING PATH-TO-THE-EXAMPLE-BUS
"""

import contextlib
import pathlib
import re
import subprocess
import sys

from pymodbus.client import ModbusTcpClient

BRIDGE = pathlib.Path(__file__).with_name("bridge.py")
LAYOUTS = [
    [],
    ["--order", "low-first"],
    ["--in", "holding:1000", "--out", "holding:200", "--order", "low-first", "--unit", "1"],
    ["--layout", "inline"],
    ["--layout", "inline", "--order", "low-first", "--modules", "0101,0233,0D02,0233,0432,0231,0233"],
    ["--rtu", "--order", "low-first"],
]
# The answers of a call that fails are a few, so these numbers have no common factor.
MISBEHAVIOUR = ["--drop-every", "17", "--double-every", "5", "--short-every", "19", "--busy-every", "23"]
LATE = ["--delay-every", "13", "--delay-ms", "150", "--hang-up-every", "29"]


@contextlib.contextmanager
def bridge(encoring, *options):
    command = [sys.executable, BRIDGE, "--start", encoring, *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        try:
            bus, sim = (child.stdout.readline().split()[1] for _ in range(2))
            yield bus, sim
        finally:
            child.terminate()
        assert child.wait(10) == 0, "the bridge ends with 0 on SIGTERM"


def run(*command):
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    assert done.returncode == 0, f"{command}: {done.returncode}"
    return done.stdout


def words(text):
    return [(out, int(word, 16)) for out, word in re.findall(r"OUT (\w{8}) IN (\w{8})", text)]


def check_refusal(bus):
    """Some couplers do not know function 23; this one does not."""
    client = ModbusTcpClient("127.0.0.1", port=int(re.search(r":(\d+)", bus)[1]))
    assert client.connect(), bus
    answer = client.readwrite_registers(read_address=8000, read_count=2, write_address=8006, values=[0, 0])
    assert answer.isError() and answer.exception_code == 1, answer
    client.close()


def main(encoring, example):
    for options in LAYOUTS:
        with bridge(encoring, *options) as (bus, sim):
            first = run(example, bus)
            encoders = [int(position) for position in re.findall(r"^(\d+): OUT", first, re.M)]
            assert len(encoders) == 3 and all(out == "00000000" for out, _ in words(first)), first
            run(example, bus, "write", str(encoders[1]), "4200270F")
            host, port = sim.rsplit(":", 1)
            direct = ModbusTcpClient(host, port=int(port))
            assert direct.connect(), sim
            while (answer := direct.read_holding_registers(0, count=6)).registers != [0, 0, 0x4200, 0x270F, 0, 0]:
                assert not answer.isError(), answer
            direct.close()
            second = run(example, bus)
            assert all(new > old for (_, old), (_, new) in zip(words(first), words(second), strict=True)), second

            if "inline" in options:
                check_refusal(bus)

            # What it is told is only the way; the rest it finds.
            way = re.sub(r"[?&](unit|out|in|layout|order)=[^&]*", "", bus).replace("&", "?", "?" not in bus)
            found = run(example, way, "probe")
            assert f"certain: {bus.replace('&unit=1', '')} (3 encoders)" in found, f"{bus}\n{found}"
            print("bridge:", bus)

    for options in [MISBEHAVIOUR, LATE, ["--rtu", *MISBEHAVIOUR], ["--rtu", *LATE]]:
        with bridge(encoring, *options) as (bus, _):
            told = run(example, bus + ("&" if "?" in bus else "?") + "timeout_ms=100", "try", "300")
            answered, errors = map(int, re.findall(r"\d+", told))
            assert answered > 100 and errors > 0, told
            print("bridge:", " ".join(options), "->", told.strip())
    print("bridge: 1 passed, 0 failed")


main(*sys.argv[1:])
