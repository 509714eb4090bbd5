"""Exports a network and writes PyTorch's own distances of some pairs of pictures, for tests/networks/main.rs.

    scores.py NETWORK ONNX-FILE SCORES-FILE

The test makes the same pictures.
"""

import math
import os
import sys

# Python must not write compiled files into the source tree.
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts"))
import export_networks as export

name, onnx_file, scores_file = sys.argv[1:]
torch = export.package("torch", "this test")
sys.argv[1:] = [name, onnx_file]
export.main()
network = export.build(torch, name)


def picture(width, height, phase):
    values = [[0.5 + 0.5 * math.sin(0.37 * i + c + phase) for i in range(width * height)] for c in range(3)]
    return torch.tensor(values, dtype=torch.float64).float().reshape(1, 3, height, width)


with open(scores_file, "w") as scores, torch.no_grad():
    for width, height, phase in [(64, 64, 0.1), (64, 64, 1.5), (97, 54, 0.4), (21, 33, 3.0), (160, 90, 0.0), (160, 90, 0.7)]:
        distance = network(picture(width, height, 0.0), picture(width, height, phase)).item()
        scores.write(f"{width} {height} {phase} {distance!r}\n")
