"""The U-Net of the scripts that fit networks of pictures, and how it is written for OpenCV."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import onnx
import torch
from torch import nn
from torch.nn import functional

# Channels at each depth; chosen by hand.
CHANNELS = (16, 32, 48, 64, 96, 128)
# The newest operators that all supported versions of OpenCV read.
ONNX_OPSET = 13


class Block(nn.Sequential):
    """Two convolutions."""

    def __init__(self, inputs: int, outputs: int) -> None:
        layers: list[nn.Module] = []
        for channels in (inputs, outputs):
            layers += [nn.Conv2d(channels, outputs, 3, padding=1, bias=False), nn.BatchNorm2d(outputs), nn.ReLU()]
        super().__init__(*layers)


class UNet(nn.Module):
    """Ronneberger et al., U-Net: convolutional networks for biomedical image segmentation, 2015; small."""

    def __init__(self, inputs: int, outputs: int, channels: tuple[int, ...] = CHANNELS) -> None:
        super().__init__()
        before = (inputs, *channels[:-1])
        self.down = nn.ModuleList([Block(*pair) for pair in zip(before, channels, strict=True)])
        pairs = zip(channels[1:], channels[:-1], strict=True)
        self.up = nn.ModuleList([Block(below + beside, beside) for below, beside in pairs])
        self.last = nn.Conv2d(channels[0], outputs, 1)

    def forward(self, layers: torch.Tensor) -> torch.Tensor:
        """Scores, shape (N, outputs, H, W), of layers, shape (N, inputs, H, W).

        Sides are multiples of 2 to the number of levels minus one.
        """
        levels: list[torch.Tensor] = []
        for depth, block in enumerate(self.down):
            layers = block(functional.max_pool2d(layers, 2) if depth else layers)
            levels.append(layers)
        for block, level in zip(reversed(self.up), levels[-2::-1], strict=True):
            layers = functional.interpolate(layers, scale_factor=2, mode="nearest")
            layers = block(torch.cat([level, layers], 1))
        return self.last(layers)


def has_bfloat16() -> bool:
    """Whether the processor computes in bfloat16; without support it would be ten times slower than float32."""
    return bool(torch.ops.mkldnn._is_mkldnn_bf16_supported())


def write_onnx(network: nn.Module, path: Path, *, inputs: int, input_name: str, output_name: str) -> None:
    """Write a network as ONNX, for images of any size whose sides 32 divides; inputs: number of its layers."""
    sides = {2: "height", 3: "width"}
    torch.onnx.export(
        network.eval(),
        (torch.zeros(1, inputs, 256, 320),),
        str(path),
        input_names=[input_name],
        output_names=[output_name],
        dynamic_axes={input_name: sides, output_name: sides},
        opset_version=ONNX_OPSET,
        dynamo=False,
    )


def read_onnx(network: UNet, path: Path, layers: torch.Tensor) -> None:
    """Set the weights of a network to those that write_onnx has written, to train it further.

    layers: shape (N, inputs, H, W), of lessons. The file has no batch normalisation: its statistics are those of these.
    """
    written = [[tensor(each) for each in pair] for pair in list_convolutions(onnx.load(str(path)))]
    blocks = [*network.down, *reversed(network.up)]
    convolutions = [layer for block in blocks for layer in block if isinstance(layer, nn.Conv2d)]
    norms = [layer for block in blocks for layer in block if isinstance(layer, nn.BatchNorm2d)]
    with torch.no_grad():
        for layer, (weight, _) in zip([*convolutions, network.last], written, strict=True):
            layer.weight.copy_(weight)
        network.last.bias.copy_(written[-1][1])

        def normalise(norm: nn.Module, inputs: tuple[torch.Tensor], bias: torch.Tensor) -> None:
            values = inputs[0]
            mean, variance = values.mean((0, 2, 3)), values.var((0, 2, 3))
            norm.running_mean.copy_(mean)
            norm.running_var.copy_(variance)
            norm.weight.copy_((variance + norm.eps).sqrt())
            norm.bias.copy_(bias + mean)

        hooks = [
            norm.register_forward_pre_hook(lambda norm, inputs, bias=bias: normalise(norm, inputs, bias))
            for norm, (_, bias) in zip(norms, written, strict=False)
        ]
        network.eval()
        network(layers)
        for hook in hooks:
            hook.remove()
        network.train()


def average_onnx(path: Path, start: Path, share: float) -> None:
    """Replace the weights in a file by their mean with those of the file from which training started.

    share: of the weights in the first file, 0 … 1 (Wortsman et al., Robust fine-tuning of zero-shot models, 2022).
    """
    model = onnx.load(str(path))
    pairs = zip(list_convolutions(model), list_convolutions(onnx.load(str(start))), strict=True)
    for own, other in (each for pair in pairs for each in zip(*pair, strict=True)):
        mean = share * tensor(own) + (1 - share) * tensor(other)
        own.CopyFrom(onnx.numpy_helper.from_array(mean.numpy(), own.name))
    onnx.save(model, str(path))


def list_convolutions(model: onnx.ModelProto) -> list[list[onnx.TensorProto]]:
    """Weight and bias of each convolution in the order in which it runs, with what is beside before what is below."""
    graph = model.graph
    values = {each.name: each for each in graph.initializer}
    joins = {node.output[0]: node for node in graph.node if node.op_type == "Concat"}
    convolutions = []
    for node in (node for node in graph.node if node.op_type == "Conv"):
        weight, bias = (values[name] for name in node.input[1:3])
        join = joins.get(node.input[0])
        if join is not None and "Resize" in join.input[0]:
            # Older files have what comes from below first
            old = onnx.numpy_helper.to_array(weight)
            swapped = np.concatenate([old[:, -len(old) :], old[:, : -len(old)]], axis=1)
            weight.CopyFrom(onnx.numpy_helper.from_array(swapped, weight.name))
        convolutions.append([weight, bias])
    return convolutions


def tensor(written: onnx.TensorProto) -> torch.Tensor:
    """The values of an array in a file."""
    return torch.from_numpy(onnx.numpy_helper.to_array(written).copy())
