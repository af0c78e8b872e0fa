"""A PLC program as others write one, with pymodbus: the handshake as the manuals have it, or with one usual mistake.

Usage: handshake.py PORT right|together|torn|changed|dropped|kept|hasty|unchecked|backwards

It programs the encoder at position 0. handshake.c is the same with libmodbus.
"""

import sys
import time

from pymodbus.client import ModbusTcpClient

DEADLINE_S = 30.0


class Encoder:
    def __init__(self, client):
        self.client = client

    def write(self, word):
        answer = self.client.write_registers(0, [word >> 16, word & 0xFFFF])
        assert not answer.isError(), answer

    def write_half(self, register, value):
        answer = self.client.write_register(register, value)
        assert not answer.isError(), answer

    def until(self, bit):
        until = time.monotonic() + DEADLINE_S
        while time.monotonic() < until:
            answer = self.client.read_input_registers(0, count=2)
            assert not answer.isError(), answer
            if answer.registers[0] >> 15 == bit:
                return
        raise AssertionError(f"waited {DEADLINE_S} s for IN bit 31 = {bit}")

    def end(self, request):
        self.until(1)
        self.write(request & 0x7FFFFFFF)
        self.until(0)

    def service(self, request):
        """Data and number first, the service bit in a later cycle; then the reply, then the end."""
        self.write(request & 0x7FFFFFFF)
        time.sleep(0.02)
        self.write(request)
        self.end(request)


def together(encoder):
    encoder.write(0xC200270F)
    encoder.end(0xC200270F)
    encoder.service(0x88000000)


def torn(encoder):
    encoder.write_half(0, 0xC600)
    encoder.write_half(1, 0x0005)
    encoder.end(0xC6000005)


def changed(encoder):
    encoder.write(0x46000005)
    time.sleep(0.1)
    encoder.write(0xC6000005)
    encoder.write(0xC6000006)
    encoder.end(0xC6000005)


def dropped(encoder):
    encoder.write(0x46000005)
    time.sleep(0.1)
    encoder.write(0xC6000005)
    encoder.write(0x46000005)
    time.sleep(0.5)


def kept(encoder):
    encoder.write(0x46000005)
    time.sleep(0.02)
    encoder.write(0xC6000005)
    encoder.until(1)
    time.sleep(1.5)


def hasty(encoder):
    encoder.write(0x02000000)
    time.sleep(0.1)
    encoder.write(0x82000000)
    encoder.until(1)
    encoder.write(0x03000000)
    encoder.write(0x83000000)
    time.sleep(0.5)
    encoder.write(0x03000000)
    encoder.until(0)


def unchecked(encoder):
    encoder.service(0xC200270F)
    encoder.service(0xC6000005)


def backwards(encoder):
    encoder.service(0xC8000000)
    encoder.service(0x88000000)


def right(encoder):
    encoder.service(0xC200270F)
    encoder.service(0xC300000A)
    encoder.service(0xC9000001)
    encoder.service(0x88000000)
    encoder.service(0xC6000005)
    encoder.service(0x82000000)


PROGRAMS = {
    program.__name__: program
    for program in (right, together, torn, changed, dropped, kept, hasty, unchecked, backwards)
}


def main(port, name):
    client = ModbusTcpClient("127.0.0.1", port=int(port))
    assert client.connect(), port
    PROGRAMS[name](Encoder(client))
    client.close()


main(*sys.argv[1:])
