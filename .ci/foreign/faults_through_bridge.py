"""One answer of a gateway that others wrote (bridge.py) is spoilt, whichever: what each command tells of it is so.

    faults_through_bridge.py target/release/encoring EVERY

One in EVERY of: each command, each answer that it needs, each way to spoil it. What was told is compared with the
encoder, seen through the control port of its simulation.
"""

import collections
import contextlib
import socket
import struct
import sys
import tempfile
import threading
import time

from master_through_bridge import Bridge

KINDS = ["delay", "drop", "double", "short", "busy", "hang_up"]
AT = 2
LENGTH = "02"
SIDE_BY_SIDE = 6


def ask(bus, pdu):
    """What the gateway answers, behind its header."""
    host, port = bus.split("//")[1].split("?")[0].rsplit(":", 1)
    with socket.create_connection((host, int(port)), timeout=20) as gateway:
        gateway.sendall(struct.pack(">HHHB", 1, 0, 1 + len(pdu), 1) + pdu)
        answer = gateway.recv(100)
        assert len(answer) > 9, answer
        return answer[7:]


def write_out(bus, word):
    """Writes the OUT word through the gateway, as a program that was killed would have left it."""
    ask(bus, struct.pack(">BHHBI", 16, 2 * AT, 2, 4, word))


class Run:
    """A command on a bridge, once with a fault."""

    def __init__(self, bridge, number):
        self.bridge, self.number = bridge, number

    def encoring(self, command, *more):
        return self.bridge.encoring(command, AT, *more)

    def service_bit(self, answer, err):
        """A service bit that stands is told."""
        out = int(self.bridge.device(AT)["out"], 16)
        if out >> 31:
            assert answer and answer.get("service_bit_left"), (f"{out:08X} was not told", answer, err)
            write_out(self.bridge.bus, out & 0x7FFF_FFFF)

    def read(self):
        code, answer, err = self.encoring("read", LENGTH)
        if code == 0:
            assert answer["parameters"][0]["value"] == self.bridge.truth(AT)[0][LENGTH][0], answer
        return code, answer, err

    def check(self):
        code, answer, err = self.encoring("check", "--yes")
        if code == 0:
            assert answer["status_hex"] == "0000", answer
        return code, answer, err

    def write(self):
        before = self.bridge.truth(AT)[0]
        value = 5000 + self.number
        code, answer, err = self.encoring("write", "measuring-length", str(value), "--yes", "--no-backup")
        values = self.bridge.truth(AT)[0]
        if code == 0:
            assert values[LENGTH] == (value, value), (answer, values)
        elif answer is None or answer.get("result") in ("not_begun", "taken_back"):
            assert values == before, (answer, err, before, values)
        return code, answer, err

    def program(self):
        before = self.bridge.truth(AT)[0]
        steps = 100 + self.number % 900
        code, answer, err = self.encoring(
            "program", "--yes", "--no-backup", "rotary", "--steps-per-turn", str(steps), "--turns", "7/2")
        values = self.bridge.truth(AT)[0]
        for row in (answer or {}).get("parameters", []):
            if row["now"] is not None:
                assert values[row["service"]][0] == row["now"], (row, values)
            if code == 0 and row["wanted"] is not None:
                assert values[row["service"]] == (row["wanted"], row["wanted"]), (row, values)
        if code and (answer is None or answer.get("result") in ("not_begun", "taken_back")):
            assert values == before, (answer, err, before, values)
        return code, answer, err

    def preset(self):
        writes = self.bridge.truth(AT)[1]
        code, answer, err = self.encoring("preset", str(self.number % 300), "--yes")
        made = self.bridge.truth(AT)[1] - writes
        fate = ((answer or {}).get("failure") or {}).get("carried_out")
        known = {"yes": 1, "no": 0}.get(fate, 1 if code == 0 else made)
        assert made == known and made <= 1, (made, code, answer, err)
        return code, answer, err

    def prepare(self, command):
        """What is there before the command, and before the gateway spoils an answer."""
        if command != "release":
            return
        write_out(self.bridge.bus, 0x8200_0000)
        # Until the gateway shows the reply the words do change.
        until = time.monotonic() + 60
        while not ask(self.bridge.bus, struct.pack(">BHH", 4, 2 * AT, 2))[2] >> 7:
            assert time.monotonic() < until, "no reply within a minute"

    def release(self):
        code, answer, err = self.encoring("release", "--yes")
        out = int(self.bridge.device(AT)["out"], 16)
        assert code == 3 or code == 0 and out == 0x0200_0000, (code, f"{out:08X}", answer, err)
        return code, None, err


COMMANDS = ["read", "check", "write", "program", "preset", "release"]


def work(bridge, cases, told):
    for number, (command, kind, at) in cases:
        run = Run(bridge, number)
        run.prepare(command)
        bridge.fault(f"{kind} {at}")
        code, answer, err = getattr(run, command)()
        bridge.fault("sound")
        if command == "release":
            write_out(bridge.bus, 0x0200_0000)
        else:
            run.service_bit(answer, err)
        told[command, code] += 1


def main():
    every = int(sys.argv[2])
    with contextlib.ExitStack() as stack:
        folder = stack.enter_context(tempfile.TemporaryDirectory())
        options = ["--faults", "--delay-ms", "300"]
        bridges = [stack.enter_context(Bridge(folder, *options)) for _ in range(SIDE_BY_SIDE)]
        for bridge in bridges:
            bridge.add("timeout_ms=200")
            bridge.patience = "800ms"
        cases = []
        for number, command in enumerate(COMMANDS):
            run = Run(bridges[0], 4000 + number)
            run.prepare(command)
            before = bridges[0].fault("sound")
            code, answer, err = getattr(run, command)()
            assert code == 0, (command, answer, err)
            answers = bridges[0].fault("sound") - before
            print(f"{command}: {answers} answers")
            cases += [(command, kind, at) for kind in KINDS for at in range(1, answers + 1)]
        cases = list(enumerate(cases[::every]))
        told, failed = collections.Counter(), []

        def some(place, bridge):
            try:
                work(bridge, cases[place::SIDE_BY_SIDE], told)
            except BaseException as problem:  # told when all are done
                failed.append(repr(problem))

        threads = [threading.Thread(target=some, args=place) for place in enumerate(bridges)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert not failed, "\n".join(failed)
        assert told, "something was run"
        ends = ", ".join(f"{command} {code}: {count}" for (command, code), count in sorted(told.items()))
        print(f"one answer spoilt in each of {len(cases)} runs; exit codes: {ends}; all that was told is so")


if __name__ == "__main__":
    main()
