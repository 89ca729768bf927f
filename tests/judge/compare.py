"""The conformance judge: what `pldi stages` wrote, against the float64 reference, number by number.

    python tests/judge/compare.py --reference ../shared/reference \
        --case RECORDING FRAME STAGES_DIR [--case ...] [--json FILE] [--require-views] [--n-input stored]

RECORDING is a 640x480 folder in the TUM layout, FRAME counts from 0, STAGES_DIR is what
`pldi stages RECORDING --frame FRAME --out STAGES_DIR` wrote:

    filtered.png       u16, unit 1/8 mm, saturating at 65535 = 8191.875 mm, 0 = invalid
    n.png              u16, 65535 = 1
    view_I.png         u16, 128x128, 65535 = 1, one for each object, I = 0, 1, ...
    dwt_I.f32          16384 little-endian f32: the coefficients of view_I.png in the layout of pywt.coeffs_to_array
    descriptor_I.json  "paper" and "halves", 58 numbers each, of view_I.png

Prints a table with one row for each frame and criterion. Exit code: 0 when every criterion holds, 1 when one does
not, 2 for a wrong command line. Needs what requirements.txt lists (numba's eigh needs scipy).
"""

import argparse
import importlib
import json
import os
import re
import sys
import tempfile
import time
import warnings
from pathlib import Path

import cv2
import numpy as np
import pywt

UNIT_MM = 1 / 8
SATURATED_MM = 65535 * UNIT_MM
VIEW = 128
LEVELS = 7
NUMBERS = 58

# Criteria. Shares are of the pixels that are compared.
FILTERED_MM, FILTERED_SHARE, VALIDITY_SHARE = 0.5, 0.999, 0.999
N_WITHIN, N_SHARE = 0.002, 0.995
DWT_RELATIVE = 1e-5
DESCRIPTOR_RELATIVE, DESCRIPTOR_ABSOLUTE = 1e-4, 1e-7


def load_reference(folder):
    """The reference as a module. Nothing is written beside it: its folder may be read-only."""
    os.environ.setdefault("NUMBA_CACHE_DIR", tempfile.mkdtemp(prefix="pldi-judge-"))
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(folder))
    return importlib.import_module("pldi_reference")


def lines(path):
    return [line.split() for line in path.read_text().splitlines() if line.strip() and not line.startswith("#")]


def read_frame(folder, index):
    """(rgb, depth in m, fx, fy, cx, cy) at 320x240, as the reference's `read_frame` and also without colour: then rgb
    is constant, so that only depth guides the filter."""
    text = (folder / "camera_info.yaml").read_text()
    matrix = re.search(r"camera_matrix:.*?data:\s*\[(.*?)\]", text, re.DOTALL).group(1)
    k = [float(x) for x in matrix.split(",")]
    if (folder / "associations.txt").exists():
        _, colour_name, _, depth_name = lines(folder / "associations.txt")[index]
        rgb = read_image(folder / colour_name)[:, :, ::-1]
        # One block's mean, rounded half up.
        rgb = np.floor(rgb.reshape(240, 2, 320, 2, 3).mean((1, 3)) + 0.5).astype(np.uint8)
    else:
        _, depth_name = lines(folder / "depth.txt")[index]
        rgb = np.full((240, 320, 3), 128, np.uint8)
    depth = read_image(folder / depth_name)
    if depth.shape != (480, 640) or depth.dtype != np.uint16:
        raise ValueError(f"{depth_name}: {depth.shape} {depth.dtype}, not 640x480 u16")
    return rgb, depth[::2, ::2] / 1000.0, k[0] / 2, k[4] / 2, k[2] / 2, k[5] / 2


def read_image(path):
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise ValueError(f"{path.name}: missing, or not an image")
    return image


def read_u16(path, shape):
    image = read_image(path)
    if image.shape != shape or image.dtype != np.uint16:
        raise ValueError(f"{path.name}: {image.shape} {image.dtype}, not {shape} uint16")
    return image


class Verdicts:
    """Rows of the table."""

    def __init__(self):
        self.rows = []

    def add(self, case, criterion, holds, measured, bound, note="", judged=True):
        """`measured` and `bound` are numbers of one kind or text. A row that is not judged cannot fail."""
        holds = bool(holds)
        row = {"case": case, "criterion": criterion, "judged": judged, "holds": holds}
        self.rows.append(row | {"measured": measured, "bound": bound, "note": note})
        measured, bound = (x if isinstance(x, str) else f"{x:.6g}" for x in (measured, bound))
        verdict = ("ok" if holds else "FAILED") if judged else "info"
        print(f"{case:18} {criterion:34} {measured:>12} {bound:>12}  {verdict:6} {note}".rstrip(), flush=True)

    def share(self, case, criterion, hits, bound, note="", judged=True):
        """`hits`: one truth value for each pixel compared; their share must reach the bound."""
        value = float(np.mean(hits)) if hits.size else 0.0
        self.add(case, criterion, value >= bound, value, f">= {bound}", note or f"of {hits.size}", judged)

    def most(self, case, criterion, value, bound, note=""):
        """`value` must not exceed the bound (NaN fails)."""
        self.add(case, criterion, value <= bound, float(value), f"<= {bound:g}", note)

    def error(self, case, criterion, error):
        self.add(case, criterion, False, "-", "-", f"{type(error).__name__}: {error}")

    def counts(self):
        """How many criteria were judged, and how many of them failed."""
        judged = [row for row in self.rows if row["judged"]]
        return len(judged), sum(not row["holds"] for row in judged)


def compare_images(verdicts, case, reference, frame, stages, n_input):
    """Filter and N. `n_input` names the depth that N is judged on: "reference", the reference's own (from the sensor's
    depth to N), or "stored", filtered.png (the stage by itself). The other one is printed only: a radius has a sharp
    edge, so that the 1/8 mm steps alone move N by more than the bound at 2 to 3 % of the pixels."""
    rgb, depth, *intrinsics = frame
    expected = reference.reconstruct(rgb, depth)
    expected_mm = expected * 1000.0
    clipped = np.minimum(expected_mm, SATURATED_MM)
    filtered_mm = read_u16(stages / "filtered.png", depth.shape) * UNIT_MM
    both = (expected > 0) & (filtered_mm > 0)
    error = np.abs(filtered_mm - clipped)[both]
    note = f"of {error.size}, worst {error.max(initial=0):.3f} mm, {int((expected_mm > SATURATED_MM).sum())} clipped"
    verdicts.share(case, f"filter within {FILTERED_MM} mm", error <= FILTERED_MM, FILTERED_SHARE, note)
    verdicts.share(case, "filter, same validity", (expected > 0) == (filtered_mm > 0), VALIDITY_SHARE)

    n = read_u16(stages / "n.png", depth.shape) / 65535.0
    for name, depth_m in (("reference", expected), ("stored", filtered_mm / 1000.0)):
        error = np.abs(n - reference.diffusion(depth_m, *intrinsics))[both]
        note = f"of {error.size}, mean {error.mean() if error.size else 0:.2e}"
        judged = name == n_input
        verdicts.share(case, f"N within {N_WITHIN}, {name} depth", error <= N_WITHIN, N_SHARE, note, judged)


def compare_view(verdicts, case, reference, stages, index):
    """Wavelet and descriptors, both of the stored view."""
    image = read_u16(stages / f"view_{index}.png", (VIEW, VIEW)) / 65535.0
    case = f"{case} v{index}"
    coefficients = np.fromfile(stages / f"dwt_{index}.f32", "<f4")
    if coefficients.size != VIEW * VIEW:
        raise ValueError(f"dwt_{index}.f32: {coefficients.size} numbers, not {VIEW * VIEW}")
    with warnings.catch_warnings():
        # PyWavelets warns that 7 levels of 8 taps wrap round 128 pixels: they do, on purpose.
        warnings.simplefilter("ignore")
        decomposition = pywt.wavedec2(image, "db4", mode="periodization", level=LEVELS)
    expected, _ = pywt.coeffs_to_array(decomposition)
    error = np.abs(coefficients.reshape(VIEW, VIEW).astype(np.float64) - expected).max()
    largest = np.abs(expected).max()
    verdicts.most(case, "DWT, relative to the largest", error / largest if largest > 0 else error, DWT_RELATIVE)

    stored = json.loads((stages / f"descriptor_{index}.json").read_text())
    for kind in ("paper", "halves"):
        values = np.array(stored[kind], np.float64)
        if values.shape != (NUMBERS,):
            raise ValueError(f"descriptor_{index}.json: {kind} has {values.size} numbers, not {NUMBERS}")
        expected = reference.descriptor(image, kind)
        allowed = np.maximum(DESCRIPTOR_RELATIVE * np.abs(expected), DESCRIPTOR_ABSOLUTE)
        used = np.abs(values - expected) / allowed
        worst = int(np.argmax(used))
        note = f"number {worst}: {values[worst]:.6g}, reference {expected[worst]:.6g}"
        verdicts.most(case, f"{kind}, share of tolerance used", used[worst], 1.0, note)


def compare(verdicts, reference, recording, index, stages, n_input):
    """One frame; returns how many views it had."""
    case = f"{recording.name} {index}"
    try:
        compare_images(verdicts, case, reference, read_frame(recording, index), stages, n_input)
    except (OSError, ValueError, IndexError) as error:
        verdicts.error(case, "filter and N", error)
    # Every file of a view counts, so that a lone descriptor is missed as well as a lone image.
    names = [re.fullmatch(r"(?:view|dwt|descriptor)_(\d+)\.(?:png|f32|json)", path.name) for path in stages.glob("*_*")]
    indices = sorted({int(name.group(1)) for name in names if name})
    for view in indices:
        try:
            compare_view(verdicts, case, reference, stages, view)
        except (OSError, ValueError, KeyError, TypeError) as error:
            verdicts.error(f"{case} v{view}", "view", error)
    return len(indices)


def main():
    parser = argparse.ArgumentParser(description="Compares what `pldi stages` wrote with the reference.")
    parser.add_argument("--reference", type=Path, required=True, help="folder of pldi_reference.py")
    parser.add_argument("--case", nargs=3, action="append", required=True, metavar=("RECORDING", "FRAME", "STAGES"))
    parser.add_argument("--json", type=Path, help="write the table here, too")
    parser.add_argument("--require-views", action="store_true", help="fail if no frame has a view: nothing judged")
    parser.add_argument("--n-input", choices=("reference", "stored"), default="reference", help="depth N is judged on")
    arguments = parser.parse_args()

    start = time.monotonic()
    reference = load_reference(arguments.reference)
    verdicts = Verdicts()
    print(f"{'frame':18} {'criterion':34} {'measured':>12} {'bound':>12}  verdict")
    views = 0
    for recording, index, stages in arguments.case:
        views += compare(verdicts, reference, Path(recording), int(index), Path(stages), arguments.n_input)
    if arguments.require_views:
        verdicts.add("all", "views", views > 0, views, ">= 1", "wavelet and descriptors are judged on them")
    if arguments.json:
        arguments.json.write_text(json.dumps(verdicts.rows, indent=1) + "\n")
    judged, failed = verdicts.counts()
    seconds = time.monotonic() - start
    print(f"{len(arguments.case)} frames, {views} views, {judged} criteria judged, {failed} failed, {seconds:.0f} s")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
