# SPDX-License-Identifier: GPL-3.0-or-later
# Part of Encoring. See LICENSE in this folder: it differs from that of the rest.
"""
The SSI output of an absolute encoder: clock and data of a synchronous serial interface.

Each train of clock pulses brings one position, the highest bit first. The decoder counts the pulses, reads the
field, and warns of what is wrong. A transfer ends when more than the mono period t_M has passed since its last
falling clock edge, so that after a lost or an added pulse the next transfer is read rightly again.
"""

from .pd import Decoder
