#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 ClusterFusion authors
# SPDX-License-Identifier: BSD-3-Clause
"""Experiment (a): the scale as known over time, two_stage against global_fusion.

One simulated UAV to and fro over an area, several noise levels of its receiver, several seeds; and
on one long line, where nothing is seen again and the odometry's scale drifts most. All methods get
the same photos and fixes. The errors are those of cf-eval run: against the similarity that takes the
odometry so far to the truth.
"""

import math

from experiment import COLOURS, Lab, read_csv, read_tum, spread, spread_text, table

METHODS = {
    "two_stage": {"georeference__method": "two_stage"},
    "global_fusion": {"georeference__method": "global_fusion"},
    "global_fusion, start 30": {"georeference__method": "global_fusion",
                                "georeference__fusion_start_fixes": 30},
}
STRIPS = {"length": 240, "width": 120}
LINE = {"length": 1200, "width": 1, "forward_overlap": 0.7}
CASES = {  # noise of the fixes [m], flight
    "fixes 0.5 m": (0.5, STRIPS),
    "fixes 1.5 m": (1.5, STRIPS),
    "fixes 5 m": (5.0, STRIPS),
    "fixes 1.5 m, one long line": (1.5, LINE),
}
SETTLED = 15
ALIGN_LITTLE_MAP_NOTHING = {"align__update_every": 0, "align__method": "homography",
                            "align__max_pairs_per_photo": 1, "densify__min_overlap": 1,
                            "deliver__html": "false"}


def largest_segment(segments):
    return max(segments.items(), key=lambda item: item[1]["photos"])


def odometry_drift(flight, run, segment):
    """Largest departure of the odometry's true scale over 10 photos from that over all."""
    truth = dict(read_tum(flight / "truth" / "trajectories" / "uav1.tum"))
    mine = {row["t"] for row in read_csv(run / "images" / "uav1.csv") if row["segment"] == segment}
    local = [row for row in read_tum(run / "odometry" / "uav1.tum") if row[0] in mine]

    def scale(rows):
        return (sum(math.dist(truth[a[0]], truth[b[0]]) for a, b in zip(rows, rows[1:]))
                / sum(math.dist(a[1], b[1]) for a, b in zip(rows, rows[1:])))

    whole = scale(local)
    return max(abs(scale(local[k:k + 10]) / whole - 1) for k in range(max(1, len(local) - 9)))


def measure(lab, flight, run):
    segments = lab.evaluate("run", run, flight / "truth")["scale"]["segments"]["uav1"]
    name, segment = largest_segment(segments)
    online = lab.evaluate("trajectory", run / "trajectories" / "uav1.online.tum",
                          flight / "truth" / "trajectories" / "uav1.tum", "--align", "none")
    return {
        "curve": [(photos, error) for photos, error, _ in segment["history"]],
        "final": abs(segment["error_end_pct"]),
        "converged": segment["photos_to_converge"] or segment["photos"],
        "online_rmse_m": online["rmse_m"],
        "segments": len(segments),
        "drift": odometry_drift(flight, run, name),
    }


def experiment(lab, seed, case):
    noise, flight_keys = CASES[case]

    def make(folder):
        flight = lab.simulate(
            folder,
            simulation={"seed": seed, "uavs": 1, "depth_megapixels": 0, "reference_spacing": 0},
            scene={"tree_density": 0},
            camera={"photo_width": 512, "photo_height": 384},
            flight=flight_keys,
            gnss={"sigma_h": noise, "sigma_v": 2 * noise})
        result = {}
        for method, georeference in METHODS.items():
            run = folder / "run"
            lab.run(flight / "config.ini", run, odometry__megapixels=0.2, **georeference,
                    **ALIGN_LITTLE_MAP_NOTHING)
            result[method] = measure(lab, flight, run)
        return result

    return lab.kept(f"{case.replace(' ', '_').replace(',', '')}_seed{seed}", make)


def movement(result):
    """How far the error of the scale moves once most of it has settled [%]."""
    late = [error for photos, error in result["curve"] if photos > SETTLED]
    return max(late) - min(late)


def curves(of):
    """Rows (photo, median, largest) of the error's magnitude over the seeds."""
    by_photo = {}
    for result in of:
        for photo, error in result["curve"]:
            by_photo.setdefault(photo, []).append(abs(error))
    return [(photo, *spread(errors)[::2]) for photo, errors in sorted(by_photo.items())
            if len(errors) == len(of)]


def main():
    lab = Lab("scale_over_time", __doc__)
    by_seed = [{case: experiment(lab, seed, case) for case in CASES} for seed in lab.seeds]
    results = {case: [of_seed[case] for of_seed in by_seed] for case in CASES}

    tables, panels, rows = {}, [], []
    for k, case in enumerate(CASES):
        panels.append(f"set title '{case}'\n" + ("unset key\n" if k else "set key top right\n"))
        lines = []
        for m, method in enumerate(METHODS):
            of = [result[method] for result in results[case]]
            name = f"t{k}_{m}"
            tables[name] = curves(of)
            colour = f"lc rgb '{COLOURS[m]}'"
            lines += [f"${name} using 1:2 with lines lw 2.5 {colour} title '{method}' noenhanced",
                      f"${name} using 1:3 with lines lw 1.2 dt (6,3) {colour} notitle"]
            rows.append([case, method,
                         spread_text(r["final"] for r in of),
                         spread_text((r["converged"] for r in of), "{:.0f}"),
                         spread_text(movement(r) for r in of),
                         spread_text(r["online_rmse_m"] for r in of)])
        panels.append("plot " + ", ".join(lines) + "\n")
    lab.plot("scale_over_time",
             "set multiplot layout 2,2\nset xlabel 'photo'\nset logscale y\n"
             "set yrange [0.02:30]\nset format y '%g'\nset ylabel 'error of the scale [%]'\n"
             + "".join(panels) + "unset multiplot\n", size="1000,720", **tables)

    table(["case", "method", "scale at the end, error [%]",
           "photo from which it stays within 1 %", f"range after photo {SETTLED} [%]",
           "online poses, RMSE [m]"], rows)
    for case in ("fixes 1.5 m", "fixes 1.5 m, one long line"):
        of = [result["two_stage"] for result in results[case]]
        print(f"{case}: odometry's own scale over 10 photos departs from that of the flight by up to "
              f"{spread_text(100 * r['drift'] for r in of)} %; segments: "
              f"{spread_text((r['segments'] for r in of), '{:.0f}')}")


if __name__ == "__main__":
    main()
