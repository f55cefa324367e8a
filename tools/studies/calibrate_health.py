#!/usr/bin/env python3
"""Fits the probability of being right to samples of `parloc evaluate --samples`.

The probability is 1 / (1 + exp(-(offset + slope * log_odds))) (common/localize/health.cpp) times what it is worth: the share of
the weight, how far off the pose may be by its covariance, and how many places were refuted before. Prints offset and slope by
logistic regression of "is right" on the log-odds, over the samples that are worth nearly all, and over all samples the
reliability, Brier score and AUC with the old and the new constants. To see whether it holds, every other trial is left out of
the fit and judged apart; of `parloc evaluate --families` each family is left out once.
"""

import bisect
import csv
import math
import re
import sys
import typing

from measuring import ROOT, Failure, option, parse, reported
from pages import fixed

HEALTH = ROOT / "common/localize/health.cpp"
NEEDED = ("seed", "right", "log_odds", "probability")


class Sample(typing.NamedTuple):
    trial: tuple  # a file, a family of drives and a seed
    right: int
    log_odds: float
    worth: float  # what the logistic curve is multiplied by

    def probability(self, a, b):
        return self.worth * sigmoid(a + b * self.log_odds)


def sample_of(path, row, a, b):
    """None of a run without the closed loop, and of what is not a number."""
    log_odds, probability = float(row["log_odds"]), float(row["probability"])
    right = {"0": 0, "1": 1}[row["right"]]
    if row.get("run", "loop") != "loop" or not (math.isfinite(log_odds) and math.isfinite(probability)):
        return None
    return Sample((path, row.get("family"), row["seed"]), right, log_odds, min(1.0, probability / sigmoid(a + b * log_odds)))


def read_samples(paths, a, b):
    """Every sample that a program with the constants a and b has written."""
    samples = []
    for path in paths:
        try:
            with open(path, newline="") as file:
                rows = csv.DictReader(file)
                missing = [name for name in NEEDED if name not in (rows.fieldnames or [])]
                if missing:
                    raise Failure(2, f"{path}: expected the columns {', '.join(NEEDED)}, found no {missing[0]}")
                samples += [sample for row in rows if (sample := sample_of(path, row, a, b))]
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
    return judge_forecasts([(s.probability(a, b), s.right) for s in samples])


def judge_forecasts(forecasts):
    bins = [[] for _ in range(10)]
    for p, right in forecasts:
        bins[min(int(10 * p), 9)].append((p, right))
    return {
        "brier": sum((p - right) ** 2 for p, right in forecasts) / len(forecasts),
        "auc": auc_of(forecasts),
        "error": sum(abs(sum(p - right for p, right in b)) for b in bins) / len(forecasts),
        "bins": [(len(b), *(sum(column) / len(b) for column in zip(*b, strict=True))) if b else (0, None, None) for b in bins],
    }


def print_judgements(title, samples, old, new):
    both = judge(samples, *old), judge(samples, *new)
    print(f"\n{title}: {len(samples)} samples, {sum(s.right for s in samples)} right")
    print(f"{'':14}{'before':>30}{'after':>30}")
    for name, key in (("Brier", "brier"), ("AUC", "auc"), ("error", "error")):
        print(f"{name:14}" + "".join(f"{fixed(judged[key], 4):>30}" for judged in both))
    print(f"{'said':14}" + f"{'samples':>10}{'mean':>10}{'right':>10}" * 2)
    for k in range(10):
        bins = [judged["bins"][k] for judged in both]
        cells = "".join(f"{n:>10}{fixed(said, 3):>10}{fixed(right, 3):>10}" for n, said, right in bins)
        print(f"{k / 10:.1f} to {(k + 1) / 10:.1f}    {cells}")


def print_families(samples, used):
    """Each family judged by constants that were fitted to the others."""
    print(f"\n{'family left out':18}{'kOffset':>9}{'kSlope':>9}{'samples':>9}{'right':>8}{'said':>8}{'error':>8}{'AUC':>8}")
    forecasts = []
    for family in sorted({s.trial[1] for s in samples}):
        a, b = fit([(s.log_odds, s.right) for s in used if s.trial[1] != family])
        mine = [(s.probability(a, b), s.right) for s in samples if s.trial[1] == family]
        judged = judge_forecasts(mine)
        said, right = (sum(column) / len(mine) for column in zip(*mine, strict=True))
        counts = f"{a:>9.3f}{b:>9.3f}{len(mine):>9}{right:>8.3f}{said:>8.3f}"
        print(f"{family:18}{counts}{judged['error']:>8.3f}{fixed(judged['auc'], 3):>8}")
        forecasts += mine
    judged = judge_forecasts(forecasts)
    print(f"together: error {judged['error']:.4f}, AUC {fixed(judged['auc'], 4)}")


def calibrate(args):
    old = (args.offset, args.slope)
    if None in old:
        old = tuple(there if given is None else given for given, there in zip(old, constants_in_use(), strict=True))
    samples = read_samples(args.samples, *old)
    used = [s for s in samples if s.worth >= args.min_worth]
    if not used:
        raise Failure(3, f"no sample is worth {args.min_worth:g} or more")
    new = fit([(s.log_odds, s.right) for s in used])
    print(f"fitted to {len(used)} of {len(samples)} samples, those worth {args.min_worth:g} or more")
    print(f"before  kOffset = {old[0]:.3f}, kSlope = {old[1]:.3f}")
    print(f"after   kOffset = {new[0]:.3f}, kSlope = {new[1]:.3f}")
    print_judgements("All", samples, old, new)
    if len({s.trial[1] for s in samples}) > 1:
        print_families(samples, used)
        return 0

    kept = set(sorted({s.trial for s in used})[::2])
    try:
        half = fit([(s.log_odds, s.right) for s in used if s.trial in kept])
    except Failure as e:
        print(f"\nEvery other trial alone: {e}")
        return 0
    print(f"\nFitted to every other trial alone: kOffset = {half[0]:.3f}, kSlope = {half[1]:.3f}")
    others = [s for s in samples if s.trial not in kept]
    if others:
        print_judgements("The trials that were left out", others, old, half)
    return 0


def main(arguments=None):
    return reported(lambda: calibrate(parse(__doc__, {calibrate: (
        ("samples", {"nargs": "+", "metavar": "SAMPLES.csv"}),
        option("--min-worth", 0.8, "fit to samples whose probability is at least so much of the curve's", type=float),
        option("--offset", None, "the old constant (that of health.cpp)", type=float),
        option("--slope", None, "likewise", type=float))}, arguments)))


if __name__ == "__main__":
    sys.exit(main())
