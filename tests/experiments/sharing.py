#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 ClusterFusion authors
# SPDX-License-Identifier: BSD-3-Clause
"""Experiment (b): one UAV doing the whole area against N UAVs sharing it.

The same 16 strips of a simulated area, flown by 1, 2, 4, 8 and 16 UAVs: CPU seconds per photo by
stage, memory, bytes over the seam, accuracy, and the critical path that N agents and a centre would
have on machines of their own. CPU seconds on one thread, so that what else the machine does matters
little.
"""

from experiment import COLOURS, Lab, spread, spread_text, table

WIDTH = 512  # of a photo [px]
AGENT = ["decode", "odometry", "georeference"]
CENTRE = ["align", "fuse", "deliver_cloud"]
DENSE = "densify"  # at the centre today; a UAV's own work by the design of the seam


def options(parser):
    parser.add_argument("--uavs", type=int, nargs="+", default=[1, 2, 4, 8, 16],
                        help="numbers of UAVs (default: %(default)s)")
    parser.add_argument("--width", type=int, default=WIDTH,
                        help="of the photos [px], 4:3 (default: %(default)s)")


def experiment(lab, seed, n):
    width = lab.options.width
    height = width * 3 // 4
    megapixels = width * height / 1e6

    def make(folder):
        flight = lab.simulate(
            folder,
            simulation={"seed": seed, "uavs": n, "shared": 0, "depth_megapixels": 0,
                        "reference_spacing": 0},
            scene={"tree_density": 0},
            camera={"photo_width": width, "photo_height": height},
            flight={"length": 85, "width": 480},
            gnss={"bias_limit_h": 1, "bias_limit_v": 2})
        run = folder / "run"
        # The defaults, but nothing larger than the photo.
        report = lab.run(flight / "config.ini", run, odometry__megapixels=min(1, megapixels),
                         densify__megapixels=min(1.5, megapixels), system__threads=1)
        figures = lab.evaluate("run", run, flight / "truth")
        photos = report["photos"]["total"]
        return {
            "photos": photos,
            "posed": report["photos"]["posed"],
            "components": report["components"],
            "cpu_s": {name: stage["cpu_s"] / photos for name, stage in report["stages"].items()},
            "memory_mb": report["peak_rss_mb"],
            "seam_kb": report["bytes_over_seam"] / photos / 1e3,
            "rmse_m": figures["trajectory"]["se3"]["rmse_m"],
        }

    return lab.kept(f"width{width}_uavs{n}_seed{seed}", make)


def share(result, stages):
    return sum(result["cpu_s"].get(name, 0) for name in stages)


def critical_path(result, n, dense_aboard):
    """CPU seconds per photo: each agent does its part of the photos, the centre its work on all."""
    agent = share(result, AGENT + [DENSE] * dense_aboard)
    centre = share(result, CENTRE + [DENSE] * (not dense_aboard))
    return agent / n + centre


def main():
    lab = Lab("sharing", __doc__, options)
    uavs = lab.options.uavs
    by_seed = [{n: experiment(lab, seed, n) for n in uavs} for seed in lab.seeds]
    results = {n: [of_seed[n] for of_seed in by_seed] for n in uavs}

    panels, tables = [], {}

    def panel(title, label, lines, key="top right"):
        """lines: {legend: function(result, n)}"""
        plots = []
        for k, (legend, value) in enumerate(lines.items()):
            name = f"t{len(tables)}"
            tables[name] = [(n, *spread(value(r, n) for r in results[n])) for n in uavs]
            colour = f"lc rgb '{COLOURS[k]}'"
            title_of = f"title '{legend}'" if len(lines) > 1 else "notitle"
            shift = 1 + 0.03 * (k - (len(lines) - 1) / 2)
            plots.append(f"${name} using ($1*{shift}):2:3:4 with yerrorlines pt 7 lw 1.8 {colour} "
                         f"{title_of} noenhanced")
        panels.append(f"set title '{title}'\nset ylabel '{label}'\nset key {key}\nplot "
                      + ", ".join(plots) + "\n")

    panel("work", "CPU s per photo",
          {name: lambda r, _, name=name: share(r, [name])
           for name in ["align", DENSE, "odometry", "fuse", "georeference"]},
          "top left maxrows 3")
    panel("critical path", "CPU s per photo of the area",
          {"densify at the centre": lambda r, n: critical_path(r, n, False),
           "densify aboard": lambda r, n: critical_path(r, n, True)}, "bottom left")
    panel("memory of all in one process", "peak [MB]", {"": lambda r, _: r["memory_mb"]})
    panel("over the seam", "kB per photo", {"": lambda r, _: r["seam_kb"]})
    lab.plot("sharing" if lab.options.width == WIDTH else f"sharing_{lab.options.width}",
             "set multiplot layout 2,2\nset logscale x 2\nset xrange [0.9:18]\nset yrange [0:*]\n"
             "set offsets 0, 0, graph 0.3, 0\n"
             "set xlabel 'UAVs'\n" + "".join(panels) + "unset multiplot\n",
             size="1000,720", **tables)

    rows = []
    for n in uavs:
        of = results[n]
        rows.append([n, sum(r["photos"] - r["posed"] for r in of),
                     spread_text((r["components"] for r in of), "{:.0f}"),
                     spread_text(share(r, AGENT) for r in of),
                     spread_text(share(r, [DENSE]) for r in of),
                     spread_text(share(r, CENTRE) for r in of),
                     spread_text((r["memory_mb"] for r in of), "{:.0f}"),
                     spread_text((r["seam_kb"] for r in of), "{:.0f}"),
                     spread_text(critical_path(r, n, False) for r in of),
                     spread_text(critical_path(r, n, True) for r in of),
                     spread_text(r["rmse_m"] for r in of)])
    table(["UAVs", "photos without a pose", "parts", "decode, odometry, georeference [s]",
           "densify [s]", "align, fuse, write [s]", "memory [MB]", "seam [kB]",
           "critical path, densify at the centre [s]", "densify aboard [s]", "RMSE, se3 [m]"], rows)


if __name__ == "__main__":
    main()
