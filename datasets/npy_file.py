"""Positions as scenes read them: `initial.positions`."""

import struct


def write_npy(file, nodes):
    """Writes [(x, y, z), ..] as float64, version 1.0 of the format .npy."""
    header = f"{{'descr': '<f8', 'fortran_order': False, 'shape': ({len(nodes)}, 3), }}"
    header += " " * (63 - (10 + len(header)) % 64) + "\n"
    values = [value for node in nodes for value in node]
    data = struct.pack(f"<{len(values)}d", *values)
    file.write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode() + data)
