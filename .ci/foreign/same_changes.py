"""Whether value change dumps hold the same signals and the same changes; the order within a time does not count."""

import sys


def read(path):
    """The time scale, each signal's changes by its full name, and the last time."""
    names, scopes, changes, shown, scale, at = {}, [], {}, {}, "", 0
    with open(path, encoding="ascii") as file:
        tokens = iter(file.read().split())
    for token in tokens:
        if token in ("$date", "$version", "$comment", "$timescale", "$var", "$scope", "$upscope", "$enddefinitions"):
            words = list(iter(lambda: next(tokens), "$end"))
            if token == "$timescale":
                scale = "".join(words)
            elif token == "$scope":
                scopes.append(words[1])
            elif token == "$upscope":
                scopes.pop()
            elif token == "$var":
                # The code, then the name and what follows it.
                names[words[2]] = ".".join([*scopes, " ".join(words[3:])]) + "/" + words[1]
        elif token in ("$dumpvars", "$end"):
            pass
        elif token[0] == "#":
            at = int(token[1:])
        else:
            if token[0] in "bB":
                value, code = token[1:], next(tokens)
            else:
                value, code = token[0], token[1:]
            name = names[code]
            if shown.get(name) == value:
                continue
            shown[name] = value
            # Within a time the last value stands.
            changes.setdefault(name, {})[at] = value
    return scale, changes, at


def main():
    first, *others = sys.argv[1:]
    expected = read(first)
    count = sum(map(len, expected[1].values()))
    if expected[0] != "100ns" or count < 100:
        sys.exit(f"{first}: {count} changes at {expected[0]}")
    for other in others:
        found = read(other)
        if found == expected:
            continue
        for name in sorted(expected[1].keys() | found[1].keys()):
            here, there = expected[1].get(name), found[1].get(name)
            if here != there:
                different = sorted(set((here or {}).items()) ^ set((there or {}).items()))
                sys.exit(f"{name}: {first} and {other} differ: {different[:4]}")
        sys.exit(f"{first} and {other}: {expected[0]}, {expected[2]} and {found[0]}, {found[2]}")
    print(f"{first}: {len(expected[1])} signals, {count} changes, the same in {', '.join(others)}")


main()
