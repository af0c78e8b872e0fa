"""The commands of the master's side, on a ring that they reach through a gateway that others wrote (bridge.py).

    master_through_bridge.py target/release/encoring

What a command says is compared with what the simulator itself holds, seen through its control port.
"""

import json
import os
import queue
import socket
import subprocess
import sys
import tempfile
import threading

ENCORING = os.path.abspath(sys.argv[1])
BRIDGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "bridge.py")

SCENARIO = """version = 1
[[device]]
position = 0
model = "la-66"
motion = { kind = "hold", raw = 250_000 }
[[device]]
position = 1
model = "ce-100-m"
motion = { kind = "hold", raw = 5_000 }
[[device]]
position = 2
model = "ce-65-m"
motion = { kind = "hold", raw = 5_000 }
"""
MODELS = ["la-66", "ce-100-m", "ce-65-m"]

# The journal of whoever runs this is left alone.
os.environ["XDG_STATE_HOME"] = tempfile.mkdtemp()


class Bridge:
    """A simulator with the foreign gateway before it."""

    patience = "1s"

    def __init__(self, folder, *options):
        scenario = os.path.join(folder, "ring.toml")
        with open(scenario, "w", encoding="ascii") as file:
            file.write(SCENARIO)
        command = [sys.executable, BRIDGE, "--start", ENCORING, *options]
        command += ["--", scenario, "--control", "127.0.0.1:0"]
        self.process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.lines = queue.Queue()
        threading.Thread(target=self.listen, daemon=True).start()
        self.bus = self.line("bus ")
        self.line("sim ")
        host, port = self.line("control ").rsplit(":", 1)
        self.control = socket.create_connection((host, int(port)), timeout=20).makefile("rw")

    def listen(self):
        for line in self.process.stdout:
            self.lines.put(line)
        self.lines.put("")

    def line(self, prefix):
        while True:
            line = self.lines.get(timeout=30)
            assert line, f"the bridge ended before {prefix!r}"
            if line.startswith(prefix):
                return line[len(prefix):].strip()

    def fault(self, line):
        """Spoils an answer, for a bridge with --faults; gives how many it has sent so far."""
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()
        return int(self.line("faults "))

    def add(self, option):
        self.bus += ("&" if "?" in self.bus else "?") + option

    def device(self, position):
        """What the simulator shows of an encoder."""
        self.control.write('{"verb":"view"}\n')
        self.control.flush()
        return find_devices(json.loads(self.control.readline()))[position]

    def truth(self, position):
        """What the simulator knows of an encoder: values by name of the service, offset writes, position."""
        device = self.device(position)
        values = {f"{p['service']:02X}": (p["programmed"], p["active"]) for p in device["parameters"]}
        return values, device["memory_writes"]["offset"], device["value"]

    def encoring(self, command, position, *more):
        line = [ENCORING, command, *more, "--bus", self.bus, "--at", str(position), "--format", "json"]
        # No word is decoded to take a service bit back.
        if command != "release":
            line += ["--model", MODELS[position], "--patience", self.patience]
        done = subprocess.run(line, capture_output=True, text=True, timeout=120, check=False)
        answer = json.loads(done.stdout) if done.stdout else None
        return done.returncode, answer, done.stderr

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        assert self.process.wait(timeout=20) == 0, "the bridge ends in order"


def find_devices(view):
    while "devices" not in view:
        view = next(value for value in view.values() if isinstance(value, dict))
    return view["devices"]


def good_gateway(folder, *options):
    """Every command does what it says."""
    with Bridge(folder, *options) as bridge:
        # A machine under load is slow, and that is not what is tested here.
        bridge.add("timeout_ms=10000")
        bridge.patience = "30s"
        for position in range(3):
            code, read, err = bridge.encoring("read", position, "all")
            assert code == 0, err
            values, _, shown = bridge.truth(position)
            assert {p["service"]: p["value"] for p in read["parameters"]} == {k: v[0] for k, v in values.items()}
            assert read["shown"]["position"] == shown

            backup = os.path.join(folder, f"backup-{position}-{len(os.listdir(folder))}.toml")
            wanted = ["linear", "--length-mm", "500", "--resolution-mm", "0.1"] if position == 0 else \
                ["rotary", "--steps-per-turn", "1000", "--turns", "3.5"]
            code, done, err = bridge.encoring("program", position, "--yes", "--backup", backup, *wanted)
            assert (code, done and done["result"]) == (0, "verified"), (err, done)
            values, _, _ = bridge.truth(position)
            expected = {"02": 5000} if position == 0 else {"02": 3499, "03": 35, "09": 10}
            for service, value in expected.items():
                assert values[service] == (value, value), values

            code, done, err = bridge.encoring("preset", position, "1234", "--yes")
            assert (code, done and done["after"]) == (0, 1234), (err, done)
            assert bridge.truth(position)[2] == 1234

            code, done, err = bridge.encoring("check", position, "--yes")
            assert (code, done and done["status_hex"]) == (0, "0000"), (err, done)

            code, _, err = bridge.encoring("preset", position, "16777215" if position else "99999999", "--yes")
            assert code == 2, err
            code, _, err = bridge.encoring("write", position, "measuring-length", "99", "--yes", "--read-only")
            assert code == 2 and "--read-only" in err, err

            code, done, err = bridge.encoring("program", position, "--yes", "--no-backup", "--file", backup)
            assert (code, done and done["result"]) == (0, "verified"), (err, done)
            code, again, err = bridge.encoring("read", position, "all")
            assert (code, again and again["parameters"]) == (0, read["parameters"]), err
    print(f"a good gateway {' '.join(options)}: read, program, preset, check, restore on three encoders")


def bad_gateway(folder, *options, impatient="timeout_ms=300"):
    """Whatever the gateway does: verified, or what is told is so."""
    ends = {}
    with Bridge(folder, *options) as bridge:
        bridge.add(impatient)
        for position, numerator in [(1, "77"), (2, "88"), (1, "99"), (2, "111")]:
            before, _, _ = bridge.truth(position)
            code, done, err = bridge.encoring(
                "program", position, "--yes", "--no-backup", "rotary", "--steps-per-turn", "100", "--turns", numerator)
            values, _, _ = bridge.truth(position)
            ends[code] = ends.get(code, 0) + 1
            if done is None:
                assert values == before, (err, before, values)
                continue
            for row in done["parameters"]:
                if row["now"] is not None:
                    assert values[row["service"]][0] == row["now"], (row, values)
                if code == 0 and row["wanted"] is not None:
                    assert values[row["service"]] == (row["wanted"], row["wanted"]), (row, values)
            if done["result"] in ("not_begun", "taken_back"):
                assert values == before, (done, before, values)

            writes = bridge.truth(position)[1]
            code, done, err = bridge.encoring("preset", position, "50", "--yes")
            now = bridge.truth(position)[1]
            assert now - writes <= 1, "a preset adjustment was carried out twice"
            if code == 0:
                assert bridge.truth(position)[2] == 50, done
    print(f"a gateway with {' '.join(options)}: exit codes of program {ends}; all that was told is so")


def silent_gateway(folder):
    with Bridge(folder) as bridge:
        bus = bridge.bus
    for command in (["read"], ["check", "--yes"], ["preset", "1", "--yes"], ["write", "numerator", "10", "--yes"]):
        line = [ENCORING, command[0], *command[1:], "--bus", bus, "--at", "1", "--model", "ce-100-m"]
        done = subprocess.run(line, capture_output=True, text=True, timeout=60, check=False)
        assert done.returncode == 3 and "no connection" in done.stderr, done
    print("a gateway that is not there: exit code 3, and why")


def probing(folder):
    for options in ([], ["--order", "low-first", "--in", "holding:300", "--out", "holding:500"], ["--layout", "inline"]):
        with Bridge(folder, *options) as bridge:
            # Without motion nothing can be certain.
            for position, verb in enumerate(["50000.0", "-7000.0", "9000.0"]):
                bridge.control.write(json.dumps({
                    "verb": "set", "position": position,
                    "set": {"motion": {"kind": "speed", "per_s": float(verb)}}}) + "\n")
                bridge.control.flush()
                answer = json.loads(bridge.control.readline())
                assert "error" not in answer, answer
            gateway = bridge.bus.split("?", 1)[0]
            done = subprocess.run(
                [ENCORING, "probe", gateway, "--format", "json"], capture_output=True, text=True, timeout=120, check=False)
            found = json.loads(done.stdout)
            best = found["candidates"][0]
            assert best["certainty"] == "certain", found
            read = subprocess.run(
                [ENCORING, "read", "--bus", bridge.bus, "--at", "2", "--model", "ce-65-m"], capture_output=True, check=False)
            assert read.returncode == 0
            wanted = dict(option.split("=") for option in bridge.bus.split("?", 1)[1].split("&")) if "?" in bridge.bus else {}
            got = dict(option.split("=") for option in best["bus"].split("?", 1)[1].split("&")) if "?" in best["bus"] else {}
            for key in ("in", "order", "layout"):
                assert wanted.get(key) == got.get(key), (wanted, got)
    print("probe: table, register, word order and layout of three gateways found")


def main():
    with tempfile.TemporaryDirectory() as folder:
        good_gateway(folder)
        good_gateway(folder, "--order", "low-first", "--in", "holding:300", "--out", "holding:500")
        good_gateway(folder, "--layout", "inline")
        good_gateway(folder, "--rtu", "--unit", "7")
        bad_gateway(folder, "--delay-every", "23", "--delay-ms", "450")
        bad_gateway(folder, "--drop-every", "29")
        bad_gateway(folder, "--double-every", "5")
        bad_gateway(folder, "--short-every", "31")
        bad_gateway(folder, "--busy-every", "7")
        bad_gateway(folder, "--hang-up-every", "37")
        bad_gateway(folder, "--rtu", "--drop-every", "41")
        silent_gateway(folder)
        probing(folder)


if __name__ == "__main__":
    main()
