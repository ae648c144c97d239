"""Records one after another on one tape, cut into chunks of one size: one program for any number and length of them.

The solver marches along the tape block by block, and at the first block of a record it begins anew. The state goes from
chunk to chunk, so nothing that is compiled knows how long a record is, how many there are, or how finely they are
divided. Side by side, in lanes, they would be no faster: the derivatives by the parameters fill the vector units
(`experiments/benchmarks/speed.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from .lane import Lane, Numbers

BLOCK = 128  # steps: a record ends somewhere inside its last block, and the rest of that is wasted
BLOCKS = 64  # blocks of a chunk: enough that handing it over costs a few per cent of marching through it


class Chunk(NamedTuple):
    """The drive on a stretch of the tape, (BLOCKS, …).

    **Arguments:** `voltage` and `rate`, (…, 2 BLOCK + 1) on the half-step grid; per block the `step`, s; the `clock`, s
    since the first sample of the record; `omega`, `load`, `moving`, `order`, `stiffer`, `damped`, `sine`, `allowed`
    and `beside` of it; whether it is its `first`; `count` of the blocks that hold something.
    """

    voltage: Numbers
    rate: Numbers
    step: Numbers
    clock: Numbers
    omega: Numbers
    load: Numbers
    moving: Numbers
    order: Numbers
    stiffer: Numbers
    damped: Numbers
    sine: Numbers
    allowed: Numbers
    beside: Numbers
    first: Numbers
    count: Numbers


class Span(NamedTuple):
    """Where a record lies: its first `block` and how many `blocks`; `substeps` per sample; how many `samples`."""

    block: int
    blocks: int
    substeps: int
    samples: int

    @property
    def points(self) -> int:
        """Of its half-step grid."""
        return 2 * (self.samples - 1) * self.substeps + 1


@dataclass(frozen=True, eq=False)
class Tape:
    """The drives of several records, each in its own `span`, as chunks for the programs."""

    lanes: tuple[Lane, ...]
    spans: tuple[Span, ...]

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Samples of each record among those of all."""
        ends = np.cumsum([0, *(span.samples for span in self.spans)])
        return tuple(slice(int(a), int(b)) for a, b in zip(ends[:-1], ends[1:], strict=True))

    @property
    def samples(self) -> int:
        """Of all records together."""
        return sum(span.samples for span in self.spans)

    @cached_property
    def chunks(self) -> tuple[Chunk, ...]:
        """The drives; in NumPy, for a march takes them as soon as from the device, and putting them there takes longer
        than one of a record."""
        voltage = self.windows([lane.voltage for lane in self.lanes])
        rate = self.windows([lane.rate for lane in self.lanes])
        shape = (len(voltage) * BLOCKS,)
        own = ("step", "omega", "load", "moving", "order", "stiffer", "damped", "sine", "allowed", "beside")
        told = {name: np.zeros(shape) for name in ("step", "clock", *own[1:], "first")}
        for lane, span in zip(self.lanes, self.spans, strict=True):
            there = slice(span.block, span.block + span.blocks)
            for name in own:
                told[name][there] = getattr(lane, name)
            told["clock"][there] = lane.into + lane.step * BLOCK * np.arange(span.blocks)
            told["first"][span.block] = 1.0
        last = max(span.block + span.blocks for span in self.spans)
        found = []
        for c, (v, r) in enumerate(zip(voltage, rate, strict=True)):
            part = {name: x[c * BLOCKS : (c + 1) * BLOCKS] for name, x in told.items()}
            found.append(Chunk(v, r, **part, count=np.int32(min(last - c * BLOCKS, BLOCKS))))
        return tuple(found)

    def windows(self, grids: Sequence[np.ndarray]) -> list[np.ndarray]:
        """Half-step grids of the records, (…, points) each, as what each block sees, (BLOCKS, …, 2 BLOCK + 1) a chunk;
        beyond the end of a record its last value."""
        last = max(span.block + span.blocks for span in self.spans)
        whole = np.zeros((-(-last // BLOCKS) * BLOCKS, *grids[0].shape[:-1], 2 * BLOCK + 1))
        for grid, span in zip(grids, self.spans, strict=True):
            for k in range(span.blocks):
                seen, own = grid[..., 2 * BLOCK * k : 2 * BLOCK * (k + 1) + 1], whole[span.block + k]
                n = seen.shape[-1]
                own[..., :n], own[..., n:] = seen, grid[..., -1:]
        return [whole[c : c + BLOCKS] for c in range(0, len(whole), BLOCKS)]

    def begun(self, starts: np.ndarray) -> list[np.ndarray]:
        """Numbers of each record, (records, k), at its blocks, (BLOCKS, k) a chunk; zero elsewhere."""
        whole = np.zeros((len(self.chunks) * BLOCKS, starts.shape[1]))
        for span, own in zip(self.spans, starts, strict=True):
            whole[span.block : span.block + span.blocks] = own
        return [whole[c : c + BLOCKS] for c in range(0, len(whole), BLOCKS)]

    def at_samples(self, found: Sequence[Numbers]) -> np.ndarray:
        """What the solver said at the beginning of every step, (BLOCKS, BLOCK, k) a chunk, at the samples of all
        records, (k, samples)."""
        parts = [np.asarray(part).reshape(BLOCKS * BLOCK, -1) for part in found]
        out = np.empty((parts[0].shape[1], self.samples))
        for span, own in zip(self.spans, self.slices, strict=True):
            done = 0
            while done < span.samples:
                at = span.block * BLOCK + done * span.substeps
                chunk, first = divmod(at, BLOCKS * BLOCK)
                more = min(-(-(BLOCKS * BLOCK - first) // span.substeps), span.samples - done)
                last = first + (more - 1) * span.substeps + 1
                out[:, own.start + done : own.start + done + more] = parts[chunk][first : last : span.substeps].T
                done += more
        return out


def lay(lanes: Sequence[Lane], substeps: Sequence[int]) -> Tape:
    """Put records on a tape; `substeps` per sample of each."""
    spans, block = [], 0
    for lane, each in zip(lanes, substeps, strict=True):
        samples = (len(lane.voltage) - 1) // (2 * each) + 1
        blocks = -(-((samples - 1) * each + 1) // BLOCK)
        spans.append(Span(block, blocks, each, samples))
        block += blocks
    return Tape(tuple(lanes), tuple(spans))
