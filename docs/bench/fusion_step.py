#!/usr/bin/env python3
"""Compares the time of a training step of FusionNet in PyTorch and in beadwork.

The network has f = 32, the batch 64 examples of 32 x 32 cells, in single precision.

    pip install torch==2.13.0 safetensors numpy
    cargo xtask gen-data --preset chains --out datasets/chains
    cargo xtask bench learn                                     # builds the binary
    python3 docs/bench/fusion_step.py target/release/beadwork datasets/chains

Both use the same network, loss, optimiser and memory layout (channels last), and one thread per
core. The script alternates between both five times, and prints the examples per second of both and
the ratio of the medians of their step times.
"""

import json
import pathlib
import statistics
import subprocess
import sys
import time

import torch
from torch.nn import functional

sys.path.append(str(pathlib.Path(__file__).parents[2] / "crates/learn/tests/data"))
from make_fusion import FusionNet  # noqa: E402

F, HIDDEN, HISTORY, CANVAS, BATCH = 32, 192, 32, 32, 64


def loss(position, action, truth, label, negatives):
    """Ranking loss of the positions plus cross entropy of the actions, as in crates/learn."""
    scores = position.flatten(1)
    own = scores.gather(1, truth[:, None])
    hardest = scores.masked_fill(~negatives, -1e4).topk(32, sorted=False).values
    real = (hardest > -5e3).float()
    ranking = (functional.relu(hardest - own + 1.0) * real).sum() / real.sum().clamp(min=1.0)
    logits = action.flatten(2)

    def at(cell):
        return logits.gather(2, cell[:, None, None].expand(-1, 12, 1)).squeeze(2)

    total = ranking + functional.cross_entropy(at(truth), label, label_smoothing=0.1)
    x, y, near, count = truth % CANVAS, truth // CANVAS, 0.0, 0.0
    for dx, dy in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        inside = ((x + dx >= 0) & (x + dx < CANVAS) & (y + dy >= 0) & (y + dy < CANVAS)).float()
        cell = (y + dy).clamp(0, CANVAS - 1) * CANVAS + (x + dx).clamp(0, CANVAS - 1)
        entropy = functional.cross_entropy(at(cell), label, reduction="none", label_smoothing=0.2)
        near, count = near + (entropy * inside).sum(), count + inside.sum()
    return total + 0.3 * near / count


def step_seconds(net, optimiser, steps=6):
    """Median time of a training step on random input, after two warm-up steps."""
    past = (BATCH, HISTORY)
    batch = (
        torch.rand(BATCH, CANVAS, CANVAS, 9).permute(0, 3, 1, 2),
        torch.randint(12, past), torch.randint(CANVAS, past), torch.randint(CANVAS, past),
        torch.rand(past), torch.rand(past), torch.ones(past),
    )
    truth, label = torch.randint(CANVAS * CANVAS, (BATCH,)), torch.randint(12, (BATCH,))
    negatives = torch.rand(BATCH, CANVAS * CANVAS) < 0.1
    seconds = []
    for _ in range(steps + 2):
        begin = time.perf_counter()
        value = loss(*net(*batch), truth, label, negatives)
        value.item()
        optimiser.zero_grad()
        value.backward()
        torch.nn.utils.clip_grad_norm_(net.parameters(), 1.0)
        optimiser.step()
        seconds.append(time.perf_counter() - begin)
    return statistics.median(seconds[2:])


def main():
    binary, data = sys.argv[1:3]
    net = FusionNet(F, HIDDEN, 128).train()
    optimiser = torch.optim.AdamW(net.parameters(), 4e-4)
    theirs, ours = [], []
    for _ in range(5):
        theirs.append(step_seconds(net, optimiser))
        command = [binary, "bench", "learn", "--json", "--data", data]
        rates = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
        ours.append(BATCH / rates["train_examples_per_second"]["single"])
    theirs, ours = statistics.median(theirs), statistics.median(ours)
    print(f"PyTorch {torch.__version__}: {BATCH / theirs:.0f} examples/s")
    print(f"beadwork: {BATCH / ours:.0f} examples/s, {ours / theirs:.3f} of PyTorch's step time")


if __name__ == "__main__":
    main()
