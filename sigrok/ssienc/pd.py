# SPDX-License-Identifier: GPL-3.0-or-later
# Part of Encoring. See LICENSE in this folder: it differs from that of the rest.
"""Decodes the SSI output of an absolute encoder; `encoring ssi decode` tells the same of a capture."""

import sigrokdecode as srd

NANOS = 1_000_000_000

# Pulses after which a repeated word begins again: 24 bits and two Low.
ROUND = 26

# A clock period shorter than the first is too fast for the encoder; one longer than the second breaks at t_M.
SHORTEST_HZ = 1_100_000
LONGEST_NS = NANOS // 50_000

# Bits that a position has at most.
POSITION_BITS = 24

BIT, FIELD, POSITION, CLOCKS, WARNING = range(5)

HIGH, LOW = 1, 0


class SamplerateError(Exception):
    pass


class Format:
    """How the bits of a transfer are laid out."""

    def __init__(self, options):
        self.gray = options['code'] == 'gray'
        self.repeats = options['repetition'] == 'yes'
        self.parity = False
        self.bits = min(max(int(options['bits']), 8), 32)
        if self.repeats:
            self.bits = 24
        elif self.bits == 31 and options['ak40'] == 'yes':
            self.bits, self.gray, self.parity = 32, False, True

    def position(self, field):
        if self.parity:
            return field >> 1
        if self.gray:
            shift = 1
            while shift < self.bits:
                field ^= field >> shift
                shift *= 2
        return field


class Transfer:
    """A train of clock pulses so far. Times in nanoseconds; with `_at` in samples."""

    def __init__(self, at, now, begun, pause):
        self.began_at, self.began, self.begun, self.pause = at, now, begun, pause
        self.fell_at, self.fell = at, now
        self.rose_at = None
        self.falls, self.clocks = 1, 0
        self.longest_low, self.longest_period = 0, None
        self.rest = None
        self.bits, self.field, self.last = 0, 0, None
        self.unlike = self.trailing = self.low = False
        # When an edge would take the last bit if the clock went on, and the level then.
        self.due, self.settled = None, None

    def take(self, level, form):
        """Takes the level that stands for the pulse that has passed."""
        if self.clocks == 0:
            self.rest = level
            return
        if self.bits >= self.clocks:
            return
        index = self.bits
        self.bits += 1
        self.last = level
        self.low |= level == LOW
        if index < form.bits:
            self.field = self.field << 1 | level
        elif form.repeats and index % ROUND < form.bits:
            self.unlike |= self.field >> (form.bits - 1 - index % ROUND) & 1 != level
        else:
            self.trailing |= level == HIGH

    def fall(self, at, now):
        period = now - self.fell
        self.longest_period = max(self.longest_period or 0, period)
        self.fell_at, self.fell = at, now
        self.falls += 1

    def rise(self, at, now, rising, mono):
        low = now - self.fell
        period = self.longest_period or 2 * low
        self.due = min(now + (period if rising else max(period - low, 0)), self.fell + mono)
        self.settled = None
        self.longest_low = max(self.longest_low, low)
        self.clocks += 1
        self.rose_at = at

    def too_fast(self):
        return (self.falls - 1) * NANOS > (self.fell - self.began) * SHORTEST_HZ

    def too_slow(self):
        return 2 * self.longest_low > LONGEST_NS or self.pause is not None and self.pause <= 2 * LONGEST_NS

    def warnings(self, form, clocks, cut):
        """All that is wrong, the gravest first."""
        short = self.bits < form.bits
        unfinished = short or clocks > 0 and self.clocks < clocks
        never_ones = self.bits > form.bits or form.bits > POSITION_BITS or form.parity
        found = []
        if self.begun == 'missed' or unfinished and (cut or self.begun == 'unsure'):
            found.append(('cut', 'the capture begins or ends within the transfer'))
        if self.rest == LOW:
            found.append(('stuck_low', 'data Low where they rest High: no supply, a broken wire, or the pair exchanged'))
        if not short and not self.low and never_ones:
            found.append(('stuck_high', 'data never Low: a broken wire, or no encoder'))
        if self.too_fast() or short and self.too_slow():
            found.append(('clock_limit', 'the clock is faster than 1.1 MHz, or so slow that the word breaks at t_M'))
        if short:
            found.append(('clocks', '%d clocks bring %d bits of %d' % (self.clocks, self.bits, form.bits)))
        elif clocks > 0 and self.clocks != clocks:
            found.append(('clocks', '%d clocks, not %d' % (self.clocks, clocks)))
        if self.unlike:
            found.append(('repetition', 'the word was not the same again'))
        if form.parity and not short and bin(self.field).count('1') % 2 == 0:
            found.append(('parity', 'the number of ones is even'))
        if self.trailing:
            found.append(('trailing_high', 'data High after the field: more bits, or a disturbed line'))
        return found


class Decoder(srd.Decoder):
    api_version = 3
    id = 'ssienc'
    name = 'SSI encoder'
    longname = 'Synchronous Serial Interface of an absolute encoder'
    desc = 'Positions of an encoder with SSI: bits, AK-40 parity, repetition, clock count.'
    license = 'gplv3+'
    inputs = ['logic']
    outputs = []
    tags = ['Embedded/industrial', 'Sensor']
    channels = (
        {'id': 'clk', 'name': 'Clock', 'desc': 'Clock+ of the receiver'},
        {'id': 'data', 'name': 'Data', 'desc': 'Data+ of the encoder'},
    )
    options = (
        {'id': 'bits', 'desc': 'Data bits, 8 to 32', 'default': 24},
        {'id': 'code', 'desc': 'Code of the position', 'default': 'binary', 'values': ('binary', 'gray')},
        {'id': 'edge', 'desc': 'Data are taken before this clock edge', 'default': 'falling',
            'values': ('falling', 'rising')},
        {'id': 'ak40', 'desc': '31 bits are AK-40, with a parity (firmware from week 41/1997)', 'default': 'yes',
            'values': ('yes', 'no')},
        {'id': 'repetition', 'desc': 'The word comes again every 26 clocks', 'default': 'no',
            'values': ('no', 'yes')},
        {'id': 'clocks', 'desc': 'Clocks of every transfer, 0 for any', 'default': 0},
        {'id': 't_m', 'desc': 'Mono period t_M in microseconds', 'default': 20.0},
    )
    annotations = (
        ('bit', 'Bit'),
        ('field', 'Field'),
        ('position', 'Position'),
        ('clocks', 'Clocks'),
        ('warning', 'Warning'),
    )
    annotation_rows = (
        ('bits', 'Bits', (BIT,)),
        ('fields', 'Fields', (FIELD,)),
        ('positions', 'Positions', (POSITION,)),
        ('clocks', 'Clocks', (CLOCKS,)),
        ('warnings', 'Warnings', (WARNING,)),
    )

    def __init__(self):
        self.reset()

    def reset(self):
        self.samplerate = None
        self.transfer = None
        self.fell = None
        self.since = None

    def metadata(self, key, value):
        if key == srd.SRD_CONF_SAMPLERATE:
            self.samplerate = value

    def start(self):
        self.out_ann = self.register(srd.OUTPUT_ANN)
        self.form = Format(self.options)
        self.rising = self.options['edge'] == 'rising'
        self.mono = round(float(self.options['t_m']) * 1000)

    def time(self, at):
        return at * NANOS // self.samplerate

    def decode(self):
        if not self.samplerate:
            raise SamplerateError('The sample rate is not known, and without it nobody knows when a transfer ends.')
        clock, data = self.wait()
        self.since = self.time(self.samplenum)
        if clock == LOW:
            self.begin(self.samplenum, 'missed', None)
        edges = [{0: 'e'}, {1: 'e'}]
        try:
            while True:
                before, level = clock, data
                wanted = edges
                if self.transfer is not None:
                    over = -((self.transfer.fell + self.mono + 1) * -self.samplerate // NANOS)
                    wanted = edges + [{'skip': max(over - self.samplenum, 1)}]
                clock, data = self.wait(wanted)
                self.settle(level)
                if clock != before:
                    self.edge(clock, level)
        except EOFError:
            # Older versions of the library end the decoder without a word.
            if self.transfer is not None:
                self.finish(self.samplenum, cut=True)

    def settle(self, level):
        """Up to this sample the data had that level: it may be the last bit, and the transfer may be over."""
        transfer = self.transfer
        if transfer is None:
            return
        now = self.time(self.samplenum)
        if transfer.settled is None and transfer.due is not None and now > transfer.due:
            transfer.settled = level
        if now - transfer.fell > self.mono:
            self.finish(self.samplenum, cut=False)

    def begin(self, at, begun, pause):
        self.transfer = Transfer(at, self.time(at), begun, pause)

    def edge(self, clock, level):
        """The clock has changed; just before, the data had that level."""
        at, transfer = self.samplenum, self.transfer
        now = self.time(at)
        if transfer is None:
            if clock == HIGH:
                return
            if self.fell is not None:
                self.begin(at, 'seen', now - self.fell)
            elif now - self.since > self.mono:
                self.begin(at, 'seen', None)
            else:
                self.begin(at, 'unsure' if level == HIGH else 'missed', None)
            if not self.rising:
                self.transfer.take(level, self.form)
            return
        if (clock == HIGH) == self.rising:
            transfer.take(level, self.form)
        if clock == LOW:
            transfer.fall(at, now)
        else:
            self.put_bit(transfer, at)
            transfer.rise(at, now, self.rising, self.mono)

    def put_bit(self, transfer, until):
        """The bit of the pulse before, from its rising edge on."""
        if transfer.rose_at is not None and transfer.bits == transfer.clocks:
            self.put(transfer.rose_at, until, self.out_ann, [BIT, [str(transfer.last)]])

    def finish(self, until, cut):
        transfer, self.transfer = self.transfer, None
        self.fell = transfer.fell
        if transfer.begun == 'missed' and transfer.clocks == 0:
            return
        if transfer.bits < transfer.clocks and transfer.settled is not None:
            transfer.take(transfer.settled, self.form)
        self.put_bit(transfer, until)
        self.put_words(transfer, until, transfer.warnings(self.form, int(self.options['clocks']), cut))

    def put_words(self, transfer, until, warnings):
        def put(kind, texts):
            self.put(transfer.began_at, until, self.out_ann, [kind, texts])

        bits = min(transfer.bits, self.form.bits)
        put(FIELD, [format(transfer.field, '0%db' % bits) if bits else '-'])
        text = '%d clocks' % transfer.clocks
        if transfer.falls > 1:
            khz = (transfer.falls - 1) * 1_000_000 / max(transfer.fell - transfer.began, 1)
            text += ', %.1f kHz' % khz
        put(CLOCKS, [text, str(transfer.clocks)])
        if not warnings:
            position = self.form.position(transfer.field)
            put(POSITION, ['Position %d (%Xh)' % (position, position), str(position)])
        for name, what in warnings:
            put(WARNING, ['%s: %s' % (name, what), name])
