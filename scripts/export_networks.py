#!/usr/bin/env python3
"""Writes the network of LPIPS, ST-LPIPS or DISTS as the ONNX file that `cyclopean compare --lpips FILE --dists FILE` reads.

Needs PyTorch with torchvision, and the network's own package: `lpips` (Zhang et al. 2018), `stlpips_pytorch`
(Ghildyal & Liu 2022) or `DISTS_pytorch` (Ding et al. 2020). The weights are theirs, under their licences.

`cyclopean compare` reads any network whose ONNX file has:
- two inputs, the reference and then the picture, each 1 x 3 x height x width of 32-bit floats: red, green and blue,
  sRGB-encoded, from 0 to 1; height and width are free;
- one output, a single number; 0 means alike;
- the entry `smallest_side` of the file's metadata: the smallest height and width that the network was made for.
"""

import argparse
import sys
import types


# Packages that `stlpips_pytorch` imports but does not need here, each with the name that it imports from them.
UNUSED = {"torchsummary": "summary", "IPython": "embed"}


def package(name, wanted_for):
    """Imports a module, or exits with a sentence that says what to install."""
    import importlib

    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as missing:
        if missing.name in UNUSED:
            sys.modules[missing.name] = types.SimpleNamespace(**{UNUSED[missing.name]: None})
            return package(name, wanted_for)
        sys.exit(f"{wanted_for} needs the Python package {missing.name}: pip install {missing.name}")


def lpips(trunk):
    def make(torch):
        network = package("lpips", f"lpips-{trunk}").LPIPS(net=trunk, verbose=False)
        return network, lambda reference, picture: network(reference, picture, normalize=True)

    return make


def st_lpips(trunk):
    def make(torch):
        module = package("stlpips_pytorch.stlpips", f"st-lpips-{trunk}")
        network = module.LPIPS(net=trunk, variant="shift_tolerant", verbose=False)
        return network, lambda reference, picture: network(reference, picture, normalize=True)

    return make


def dists(torch):
    network = package("DISTS_pytorch", "dists").DISTS()
    return network, lambda reference, picture: network(reference, picture)


NETWORKS = {
    "lpips-alex": lpips("alex"),
    "lpips-vgg": lpips("vgg"),
    "lpips-squeeze": lpips("squeeze"),
    "st-lpips-alex": st_lpips("alex"),
    "st-lpips-vgg": st_lpips("vgg"),
    "dists": dists,
}


def build(torch, name):
    """The network as a module with two inputs and one number as its output."""
    network, distance = NETWORKS[name](torch)

    class Distance(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.network = network

        def forward(self, reference, picture):
            return distance(reference, picture).reshape(1)

    return Distance().eval()


def smallest_side(torch, network):
    """The side of the smallest square picture that the network accepts, found by trying."""
    for side in range(1, 257):
        try:
            black = torch.zeros(1, 3, side, side)
            if bool(torch.isfinite(network(black, black)).all()):
                return side
        except RuntimeError:
            continue
    sys.exit("the network takes no picture of up to 256 pixels a side")


def metadata(key, value):
    """An entry of ONNX metadata in protocol buffer form: field 14 of the model, with a key (1) and a value (2)."""

    def field(number, content):
        assert len(content) < 128, "the length does not fit in one byte"
        return bytes([number << 3 | 2, len(content)]) + content

    return field(14, field(1, key.encode()) + field(2, value.encode()))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("network", choices=sorted(NETWORKS))
    parser.add_argument("file", help="the ONNX file to write")
    parser.add_argument(
        "--random-weights", action="store_true", help="do not load the trunk's weights; for tests, not for measurements"
    )
    arguments = parser.parse_args()
    torch = package("torch", "every network")
    if arguments.random_weights:
        without_weights()
        torch.manual_seed(1)
    with torch.no_grad():
        network = build(torch, arguments.network)
        side = smallest_side(torch, network)
        example = (torch.zeros(1, 3, 2 * side, 2 * side), torch.ones(1, 3, 2 * side, 2 * side))
        free = {2: "height", 3: "width"}
        torch.onnx.export(
            network,
            example,
            arguments.file,
            input_names=["reference", "picture"],
            output_names=["distance"],
            dynamic_axes={"reference": free, "picture": free},
            opset_version=13,
            **({"dynamo": False} if "dynamo" in torch.onnx.export.__code__.co_varnames else {}),
        )
    # The fields of a protocol buffer may come in any order, so the entry can be appended.
    with open(arguments.file, "ab") as file:
        file.write(metadata("smallest_side", str(side)))
    print(f"{arguments.file}: {arguments.network}, pictures of at least {side} x {side} pixels")


def without_weights():
    """Makes torchvision build its trunks without downloading their weights."""
    models = package("torchvision.models", "every network but st-lpips-alex")
    for name in ("alexnet", "vgg16", "squeezenet1_1"):
        original = getattr(models, name)
        setattr(models, name, lambda pretrained=False, original=original: original())


if __name__ == "__main__":
    main()
