"""What people write instead of a diagnosis: hex words to numbers, differences, a threshold."""

import sys

import pandas

table = pandas.read_csv(sys.argv[1], dtype={"in": str})
position = table["in"].map(lambda word: int(word, 16)) & 0xFFFFFF
jumps = table[position.diff().abs() > 1000]
print(len(table), len(jumps))
