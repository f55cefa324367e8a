#!/usr/bin/env python3
"""Fits the probability of being right to samples of `parloc evaluate --samples`.

The probability is share / (1 + exp(-(offset + slope * log_odds))) (common/localize/health.cpp). Prints offset and slope by
logistic regression of "is right" on the log-odds, over the samples in which one place has nearly all of the weight (the share
says enough of the others), and over all samples the reliability, Brier score and AUC with the old and the new constants.
Every other trial is left out of the fit and judged apart, to see whether it holds.
"""

import bisect
import csv
import math
import re
import sys

from measuring import ROOT, Failure, option, parse, reported
from pages import fixed

HEALTH = ROOT / "common/localize/health.cpp"
NEEDED = ("seed", "right", "log_odds", "share")


def sample_of(path, row):
    sample = (path, row["seed"]), {"0": 0, "1": 1}[row["right"]], float(row["log_odds"]), float(row["share"])
    return sample if all(map(math.isfinite, sample[2:])) else None


def read_samples(paths):
    """(trial, right, log_odds, share) of every sample; a trial is a file and a seed."""
    samples = []
    for path in paths:
        try:
            with open(path, newline="") as file:
                rows = csv.DictReader(file)
                missing = [name for name in NEEDED if name not in (rows.fieldnames or [])]
                if missing:
                    raise Failure(2, f"{path}: expected the columns {', '.join(NEEDED)}, found no {missing[0]}")
                samples += [sample for row in rows if (sample := sample_of(path, row))]
        except UnicodeDecodeError as error:
            raise Failure(2, f"{path}: cannot be read ({error})") from None
        except (KeyError, TypeError, ValueError):
            raise Failure(2, f"{path}:{rows.line_num}: expected numbers, and 0 or 1 for right") from None
    return samples


def constants_in_use():
    """offset and slope as health.cpp has them."""
    found = re.search(r"kOffset = (-?[\d.]+), kSlope = (-?[\d.]+)", HEALTH.read_text())
    if not found:
        raise Failure(2, f"{HEALTH}: expected kOffset and kSlope; give --offset and --slope")
    return float(found[1]), float(found[2])


def sigmoid(x):
    return 1 / (1 + math.exp(-x)) if x >= 0 else math.exp(x) / (1 + math.exp(x))


def log_likelihood(points, a, b):
    """Of all outcomes, each (log_odds, right)."""
    exponents = ((a + b * log_odds, right) for log_odds, right in points)
    return -sum(math.log1p(math.exp(-abs(x))) + max(-x if right else x, 0.0) for x, right in exponents)


def fit(points):
    """Maximum likelihood by Newton's method, halved where it would not climb."""
    rights = sum(right for _, right in points)
    if rights in (0, len(points)):
        raise Failure(3, f"expected right and wrong samples, all {len(points)} are {'right' if rights else 'wrong'}")
    a, b = 0.0, 0.0
    best = log_likelihood(points, a, b)
    for _ in range(100):
        said = [(sigmoid(a + b * log_odds), log_odds, right) for log_odds, right in points]
        ga, gb = (sum((right - p) * log_odds**power for p, log_odds, right in said) for power in range(2))
        haa, hab, hbb = (sum(p * (1 - p) * log_odds**power for p, log_odds, _ in said) for power in range(3))
        det = haa * hbb - hab * hab
        if det <= 1e-12 * max(1.0, haa * hbb):
            raise Failure(3, "what the scans say parts right from wrong entirely, or is all the same: no curve fits best")
        da, db = (hbb * ga - hab * gb) / det, (haa * gb - hab * ga) / det
        scale = 1.0
        while scale > 1e-6 and log_likelihood(points, a + scale * da, b + scale * db) < best:
            scale /= 2
        a, b = a + scale * da, b + scale * db
        now = log_likelihood(points, a, b)
        if now - best < 1e-9 * abs(now) or scale <= 1e-6:
            return a, b
        best = now
    raise Failure(3, "the fit does not settle")


def auc_of(forecasts):
    """Chance that a right one was given more than a wrong one, ties half; None if all are alike."""
    wrongs = sorted(p for p, right in forecasts if not right)
    rights = [p for p, right in forecasts if right]
    won = sum(bisect.bisect_left(wrongs, p) + bisect.bisect_right(wrongs, p) for p in rights) / 2
    return won / (len(rights) * len(wrongs)) if rights and wrongs else None


def judge(samples, a, b):
    forecasts = [(share * sigmoid(a + b * log_odds), right) for _, right, log_odds, share in samples]
    bins = [[] for _ in range(10)]
    for p, right in forecasts:
        bins[min(int(10 * p), 9)].append((p, right))
    return {
        "brier": sum((p - right) ** 2 for p, right in forecasts) / len(forecasts),
        "auc": auc_of(forecasts),
        "bins": [(len(b), *(sum(column) / len(b) for column in zip(*b, strict=True))) if b else (0, None, None) for b in bins],
    }


def print_judgements(title, samples, old, new):
    both = judge(samples, *old), judge(samples, *new)
    print(f"\n{title}: {len(samples)} samples, {sum(s[1] for s in samples)} right")
    print(f"{'':14}{'before':>30}{'after':>30}")
    for name, key in (("Brier", "brier"), ("AUC", "auc")):
        print(f"{name:14}" + "".join(f"{fixed(judged[key], 4):>30}" for judged in both))
    print(f"{'said':14}" + f"{'samples':>10}{'mean':>10}{'right':>10}" * 2)
    for k in range(10):
        bins = [judged["bins"][k] for judged in both]
        cells = "".join(f"{n:>10}{fixed(said, 3):>10}{fixed(right, 3):>10}" for n, said, right in bins)
        print(f"{k / 10:.1f} to {(k + 1) / 10:.1f}    {cells}")


def calibrate(args):
    samples = read_samples(args.samples)
    used = [s for s in samples if s[3] >= args.min_share]
    if not used:
        raise Failure(3, f"no sample has a share of {args.min_share:g} or more")
    old = (args.offset, args.slope)
    if None in old:
        old = tuple(there if given is None else given for given, there in zip(old, constants_in_use(), strict=True))
    new = fit([(s[2], s[1]) for s in used])
    print(f"fitted to {len(used)} of {len(samples)} samples, those with a share of {args.min_share:g} or more")
    print(f"before  kOffset = {old[0]:.3f}, kSlope = {old[1]:.3f}")
    print(f"after   kOffset = {new[0]:.3f}, kSlope = {new[1]:.3f}")
    print_judgements("All", samples, old, new)

    trials = sorted({s[0] for s in used})
    kept = set(trials[::2])
    try:
        half = fit([(s[2], s[1]) for s in used if s[0] in kept])
    except Failure as e:
        print(f"\nEvery other trial alone: {e}")
        return 0
    print(f"\nFitted to every other trial alone: kOffset = {half[0]:.3f}, kSlope = {half[1]:.3f}")
    others = [s for s in samples if s[0] not in kept]
    if others:
        print_judgements("The trials that were left out", others, old, half)
    return 0


def main(arguments=None):
    return reported(lambda: calibrate(parse(__doc__, {calibrate: (
        ("samples", {"nargs": "+", "metavar": "SAMPLES.csv"}),
        option("--min-share", 0.8, "fit to samples with at least so much weight in one place", type=float),
        option("--offset", None, "the old constant (that of health.cpp)", type=float),
        option("--slope", None, "likewise", type=float))}, arguments)))


if __name__ == "__main__":
    sys.exit(main())
