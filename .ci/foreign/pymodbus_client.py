"""A client that others wrote does the manuals' worked example on the built-in ring.

Usage: pymodbus_client.py PATH-TO-ENCORING
"""

import contextlib
import json
import subprocess
import sys
import time

from pymodbus.client import ModbusTcpClient

DEADLINE_S = 10.0


class Encoder:
    """The OUT and the IN word of one encoder, each in two registers, the high half in the lower one."""

    def __init__(self, client, out, read_in, register_in):
        self.client, self.out = client, out
        self.read_in, self.register_in = read_in, register_in

    def write(self, word):
        answer = self.client.write_registers(self.out, [word >> 16, word & 0xFFFF])
        assert not answer.isError(), answer

    def write_half(self, half, value):
        answer = self.client.write_register(self.out + half, value)
        assert not answer.isError(), answer

    def read(self):
        answer = self.read_in(self.register_in, count=2)
        assert not answer.isError(), answer
        return answer.registers[0] << 16 | answer.registers[1]

    def wait(self, what, condition):
        until = time.monotonic() + DEADLINE_S
        while time.monotonic() < until:
            word = self.read()
            if condition(word):
                return word
        raise AssertionError(f"waited {DEADLINE_S} s for {what}; last word {word:08X}")

    def service(self, request):
        """One service: its four steps, in the order in which the encoder counts on them."""
        # Number and data without the service bit, and time for a cycle of the ring to carry them.
        self.write(request & 0x7FFFFFFF)
        self.wait("IN bit 31 = 0", lambda word: word >> 31 == 0)
        time.sleep(0.01)
        # The service bit, and nothing else: number and data stay as they are.
        self.write(request)
        reply = self.wait(f"the reply to {request:08X}", lambda word: word >> 31 == 1)
        # The service bit again 0. The position is back when IN bit 31 is 0 too.
        self.write(request & 0x7FFFFFFF)
        self.wait("the end of the service", lambda word: word >> 31 == 0)
        return reply


def expect(what, got, expected):
    assert got == expected, f"{what}: got {got:08X}, expected {expected:08X}"
    print(f"{what}: {got:08X}")


@contextlib.contextmanager
def ring(program, *options):
    command = [program, "sim", "--web", "off", "--modbus", "127.0.0.1:0", "--format", "json", *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as sim:
        try:
            address = json.loads(sim.stdout.readline())["modbus"]
            host, port = address.rsplit(":", 1)
            client = ModbusTcpClient(host, port=int(port))
            assert client.connect(), address
            yield client
            client.close()
        finally:
            sim.terminate()
        assert sim.wait(DEADLINE_S) == 0, "sim ends with 0 on SIGTERM"


def main(program):
    with ring(program) as client:
        # Holding registers 2k and 2k+1 are OUT of position k, input registers 2k and 2k+1 its IN.
        linear, shaft, encoder = (
            Encoder(client, 2 * position, client.read_input_registers, 2 * position) for position in range(3)
        )

        # 1000 steps a turn over ten turns: 3E8h * 0Ah / 1 - 1 = 270Fh.
        expect("measuring length", encoder.service(0xC200270F), 0xC200270F)
        expect("numerator", encoder.service(0xC300000A), 0xC300000A)
        expect("denominator", encoder.service(0xC9000001), 0xC9000001)
        expect("data check", encoder.service(0x88000000), 0x88000000)
        expect("measuring length read back", encoder.service(0x82123456), 0x8200270F)
        expect("an unknown service", encoder.service(0x87000000), 0xA7000000)
        expect("its status", encoder.service(0x88000000), 0x88000080)

        for name, moving in [("LA-66", linear), ("CE-100-M", shaft), ("CE-65-M", encoder)]:
            first = moving.read()
            second = moving.wait(f"the {name} to move", lambda word: word != first)
            print(f"{name} moves: {first:08X} -> {second:08X}")

        # The halves in two requests, the service bit first: the encoder takes a word that nobody meant.
        shaft.write(0x0000FFFF)
        time.sleep(0.01)
        shaft.write_half(0, 0xC200)
        torn = shaft.wait("the torn reply", lambda word: word >> 31 == 1)
        shaft.write_half(1, 0x270F)
        expect("a torn write is echoed torn", torn, 0xC200FFFF)
        shaft.write(0)
        shaft.wait("normal mode", lambda word: word >> 31 == 0)
        expect("and was stored torn", shaft.service(0x82000000), 0x8200FFFF)

        # Write and read in one request.
        answer = client.readwrite_registers(
            read_address=0, read_count=2, write_address=0, values=[0x4200, 0x1388]
        )
        assert not answer.isError() and answer.registers == [0x4200, 0x1388], answer

        # Status, parameter, and the faults of segments 0 to 3.
        for read in [client.read_holding_registers, client.read_input_registers]:
            answer = read(900, count=6)
            assert not answer.isError() and answer.registers == [0x00E0, 0, 0, 0, 0, 0], answer
        for problem in [
            client.read_holding_registers(906, count=1),
            client.write_register(902, 0),
            client.read_input_registers(6, count=1),
            client.read_input_registers(5, count=2),
            client.write_register(1000, 1),
        ]:
            assert problem.isError() and problem.exception_code == 2, problem

    inline(program)
    print("pymodbus: 1 passed, 0 failed")


def inline(program):
    """The ring as an Inline coupler shows it: a directory, IN of all encoders, then OUT of all."""
    with ring(program, "--layout", "inline") as client:
        answer = client.read_holding_registers(1400, count=4)
        assert not answer.isError() and answer.registers == [3, 0x0233, 0x0233, 0x0233], answer
        encoder = Encoder(client, 8006 + 2 * 2, client.read_holding_registers, 8000 + 2 * 2)
        expect("Inline, measuring length", encoder.service(0xC200270F), 0xC200270F)
        answer = client.read_holding_registers(900, count=3)
        assert not answer.isError() and answer.registers == [0x00E0, 0, 0], answer
        problem = client.readwrite_registers(read_address=8000, read_count=2, write_address=8006, values=[0])
        assert problem.isError() and problem.exception_code == 1, problem
        problem = client.write_register(8000, 1)
        assert problem.isError() and problem.exception_code == 2, problem


main(sys.argv[1])
