"""Reads `exports.positions=[...]; exports.cells=[...]` on standard input, the text of a JavaScript module that is not
run, and writes the mesh as PLY on standard output."""

import json
import re
import sys


def read_array(text, name):
    """The array of arrays that the module exports under this name."""
    match = re.search(r"exports\." + name + r"\s*=\s*(\[\s*\[.*?\]\s*\])", text, re.DOTALL)
    if not match:
        sys.exit(f"bunny_to_ply.py: expected \"exports.{name} = [[...]]\" on standard input, got none")
    return json.loads(match.group(1))


def check_mesh(positions, cells):
    """Ends the program where a row is not three numbers, or a triangle names a vertex that is not there."""
    for i, row in enumerate(positions):
        if len(row) != 3 or not all(isinstance(value, (int, float)) for value in row):
            sys.exit(f"bunny_to_ply.py: position {i}: expected three numbers, got {row}")
    for i, row in enumerate(cells):
        if len(row) != 3 or not all(isinstance(v, int) and 0 <= v < len(positions) for v in row):
            sys.exit(f"bunny_to_ply.py: cell {i}: expected three indices under {len(positions)}, got {row}")


def main():
    text = sys.stdin.read()
    positions, cells = read_array(text, "positions"), read_array(text, "cells")
    check_mesh(positions, cells)
    print("ply\nformat ascii 1.0")
    print(f"element vertex {len(positions)}\nproperty float x\nproperty float y\nproperty float z")
    print(f"element face {len(cells)}\nproperty list uchar int vertex_indices\nend_header")
    for row in positions:
        print(*row)
    for row in cells:
        print(3, *row)


if __name__ == "__main__":
    main()
