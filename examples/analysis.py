"""Reads an export of `mos export` and computes its mean opinion scores and tests again with pandas and SciPy.

    mos export sessions/STUDY -o export
    python3 analysis.py export [A B]

For each study, prints the mean opinion scores by scene and method with 90 % intervals, and the signed-rank test of
method A against method B. Without A and B the first two methods in alphabetical order are tested. Writes `mos.csv` and
`test.csv` into the export's folder, and `mos.png` where matplotlib is installed. The figures agree with those of
`mos table` and `mos test`:

* A score is the mean of the participants' mean votes. Its interval is Student's t over participants.
* A test pairs the sums of votes of the participants who have every cell of both methods. It drops zero differences
  before ranking. Its exact p is exact given the sizes of the differences, also where they tie.
"""

import itertools
import pathlib
import sys

import numpy as np
import pandas as pd
from scipy import stats

LEVEL = 0.90


def scores(trials):
    """Mean, standard deviation and interval of each cell over participants."""
    people = trials.groupby(["study", "scene", "method", "participant"])["rating"].mean()
    table = people.groupby(["study", "scene", "method"]).agg(n="count", mean="mean", sd="std").reset_index()
    half = stats.t.ppf(0.5 + LEVEL / 2, (table["n"] - 1).clip(lower=1)) * table["sd"] / np.sqrt(table["n"])
    table["lo"], table["hi"] = table["mean"] - half, table["mean"] + half
    return table


def differences(trials, a, b):
    """For each participant who has every cell of both methods, the sum of a's ratings minus that of b's.

    Also returns the number of ratings in each sum.
    """
    trials = trials[trials["method"].isin([a, b])]
    cells = trials.pivot_table(
        index="participant", columns=["method", "scene", "repetition"], values="rating", aggfunc="sum"
    ).dropna()
    return cells[a].sum(axis=1) - cells[b].sum(axis=1), cells[a].shape[1]


def exact_p(d):
    """Two-sided p of min(R+, R-) over all signs of the differences, none of which may be 0. Ties have mid-ranks."""
    ranks = stats.rankdata(np.abs(d))
    smaller = min(ranks[d > 0].sum(), ranks[d < 0].sum())
    sums = {0.0: 1}
    for rank in ranks:
        grown = dict(sums)
        for total, ways in sums.items():
            grown[total + rank] = grown.get(total + rank, 0) + ways
        sums = grown
    below = sum(ways for total, ways in sums.items() if total <= smaller + 1e-9)
    return min(1.0, 2 * below / 2 ** len(ranks))


def signed_rank(trials, a, b):
    """The test of a against b, as one row of the table."""
    d, votes = differences(trials, a, b)
    used = d[d != 0].to_numpy(float)
    row = {"a": a, "b": b, "n": len(d), "zeros": int((d == 0).sum()), "mean_difference": d.mean() / votes}
    if len(used) == 0:
        return {**row, "p_exact": 1.0, "p_asymptotic": 1.0}
    ranks = stats.rankdata(np.abs(used))
    plus, expected = ranks[used > 0].sum(), ranks.sum() / 2
    z = (plus - expected) / np.sqrt((ranks**2).sum() / 4)
    # SciPy's own test gives the asymptotic p, without continuity correction. Its exact p does not allow for ties.
    mode = {"correction": False, "zero_method": "wilcox"}
    try:
        p_scipy = stats.wilcoxon(used, method="asymptotic", **mode).pvalue
    except ValueError:  # Before version 1.13 SciPy calls this method "approx".
        p_scipy = stats.wilcoxon(used, method="approx", **mode).pvalue
    return {**row, "r_plus": plus, "r_minus": ranks.sum() - plus, "z": z, "p_exact": exact_p(used),
            "p_asymptotic": p_scipy}


def plot(table, path):
    """Draws the means with their intervals, with one panel for each study."""
    try:
        import matplotlib
    except ImportError:
        print("matplotlib is not installed, so no plot is drawn")
        return
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    studies = table["study"].unique()
    figure, axes = plt.subplots(1, len(studies), figsize=(6 * len(studies), 3.5), squeeze=False)
    for axis, study in zip(axes[0], studies):
        rows = table[table["study"] == study]
        scenes, methods = sorted(rows["scene"].unique()), sorted(rows["method"].unique())
        for (i, method), marker in zip(enumerate(methods), itertools.cycle("os^D")):
            of = rows[rows["method"] == method]
            x = np.array([scenes.index(s) for s in of["scene"]]) + 0.15 * (i - (len(methods) - 1) / 2)
            # The mean of a single participant has no interval.
            half = (of["hi"] - of["mean"]).fillna(0)
            axis.errorbar(x, of["mean"], yerr=half, fmt=marker, capsize=3, label=method)
        axis.set_xticks(range(len(scenes)), scenes)
        axis.set_xlim(-0.5, len(scenes) - 0.5)
        axis.set_ylabel("mean opinion score")
        axis.set_title(study)
        axis.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=150)


def main():
    if len(sys.argv) not in (2, 4):
        sys.exit("usage: analysis.py FOLDER [A B]")
    folder = pathlib.Path(sys.argv[1])
    answers = pd.read_csv(folder / "responses.csv", keep_default_na=False, na_values={"rating": ["", "NA"]})
    trials = answers[answers["purpose"] == "trial"]
    # Real, pilot and simulated sessions are never analysed together.
    kinds = trials["kind"].unique()
    if len(kinds) != 1:
        sys.exit(f"{folder}: holds sessions of several kinds ({', '.join(kinds)}); export one with --kind")
    if kinds[0] != "real":
        print(f"*** {kinds[0].upper()} data ***")
    table = scores(trials)
    tests = []
    for study, rows in trials.groupby("study"):
        a, b = sys.argv[2:] if len(sys.argv) == 4 else sorted(rows["method"].unique())[:2]
        tests.append({"study": study, **signed_rank(rows, a, b)})
    tests = pd.DataFrame(tests)
    table.to_csv(folder / "mos.csv", index=False)
    tests.to_csv(folder / "test.csv", index=False)
    print(table.round(3).to_string(index=False))
    print(tests.round(4).to_string(index=False))
    plot(table, folder / "mos.png")


main()
