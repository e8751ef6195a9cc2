#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 ClusterFusion authors
# SPDX-License-Identifier: BSD-3-Clause
"""Experiment (c): accuracy of the dense cloud against a reference, as in the paper's figure.

Shares of the cloud's points within 1 m and 2 m of the reference: simulated towns against the true
surface, registered onto it by ICP and as GNSS places them; and real flights registered onto an
offline reference, where CF_REAL_DATA names a folder of them (brighton_beach, sheffield_cross, with
images/ and reference/ in each). Only points with a reference point within 0.5 m horizontally are
judged; the distance is that to its local plane.
"""

import os
import pathlib

from experiment import COLOURS, Lab, spread_text, table

LIMITS = ["0.1m", "0.25m", "0.5m", "1m", "2m"]
FLIGHTS = {"brighton_beach": "strips", "sheffield_cross": "4"}  # how they become several UAVs
# As printed in arXiv 2304.04943: the lowest and highest share of its flights.
PAPER = {"1m": (0.74, 0.75), "2m": (0.90, 0.94)}


def judged(lab, run, reference, align):
    cloud = lab.evaluate("cloud", run, reference, "--align", align)
    return {"within": [cloud["plane"]["share_within"][limit] for limit in LIMITS],
            "median_m": cloud["plane"]["median_m"],
            "completeness": cloud["completeness"]["1m"]}


def simulated(lab, seed):
    def make(folder):
        flight = lab.simulate(
            folder,
            simulation={"seed": seed, "uavs": 3, "depth_megapixels": 0},
            camera={"photo_width": 800, "photo_height": 600, "k1": -0.02,
                    "told_focal_error": 1},
            flight={"length": 80, "width": 90},
            gnss={"bias_limit_h": 1, "bias_limit_v": 2})
        run = folder / "run"
        lab.run(flight / "config.ini", run)
        return {align: judged(lab, run, flight / "truth", align) for align in ("none", "icp")}

    return lab.kept(f"town_seed{seed}", make)


def real(lab, photos, name):
    def make(folder):
        lab.call("cf-import", "--images", photos / "images", "--split", FLIGHTS[name],
                 "-o", folder / "flight")
        run = folder / "run"
        lab.run(folder / "flight" / "config.ini", run)
        return {"icp": judged(lab, run, photos / "reference", "icp")}

    return lab.kept(name, make)


def main():
    lab = Lab("accuracy", __doc__)
    rows = {}
    towns = [simulated(lab, seed) for seed in lab.seeds]
    rows["town"] = [town["icp"] for town in towns]
    data = os.environ.get("CF_REAL_DATA")
    for name in FLIGHTS:
        if data and (pathlib.Path(data) / name).exists():
            rows[name] = [real(lab, pathlib.Path(data) / name, name)["icp"]]

    rows["town by GNSS alone"] = [town["none"] for town in towns]

    bars, text = [('"paper"', *(100 * value for limit in ("1m", "2m")
                              for value in (sum(PAPER[limit]) / 2, *PAPER[limit])))], []
    for name, of in rows.items():
        shares = {limit: [100 * r["within"][k] for r in of] for k, limit in enumerate(LIMITS)}
        bars.append((f'"{name}"',
                     *(value for limit in ("1m", "2m") for value in
                       (sorted(shares[limit])[len(of) // 2], min(shares[limit]),
                        max(shares[limit])))))
        text.append([name, *(spread_text(shares[limit], "{:.1f}") for limit in LIMITS),
                     spread_text((100 * r["completeness"] for r in of), "{:.1f}"),
                     spread_text(r["median_m"] for r in of)])
    lab.plot("accuracy",
             "set style data histogram\nset style histogram errorbars gap 1.5 lw 1\nset errorbars 1 lc rgb '#333333'\n"
             "set style fill solid 0.8 noborder\nset yrange [0:105]\nset key outside right top\n"
             "set ylabel 'points within the distance [%]'\nset xtics noenhanced\n"
             f"plot $bars using 2:3:4:xtic(1) lc rgb '{COLOURS[0]}' title 'within 1 m', "
             f"$bars using 5:6:7 lc rgb '{COLOURS[4]}' title 'within 2 m'\n",
             size="1020,420", bars=bars)
    table(["flight", *(f"within {limit[:-1]} m [%]" for limit in LIMITS),
           "completeness within 1 m [%]", "median [m]"], text)


if __name__ == "__main__":
    main()
