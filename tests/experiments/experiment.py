# SPDX-FileCopyrightText: 2026 ClusterFusion authors
# SPDX-License-Identifier: BSD-3-Clause
"""What the experiments share: the programs, results that are kept, files of poses, plots."""

import argparse
import json
import pathlib
import shutil
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"]


class Lab:
    """The programs of one build, a folder for what they write, and one for the pictures."""

    def __init__(self, name, description, extra=None):
        parser = argparse.ArgumentParser(description=description)
        parser.add_argument("--build", type=pathlib.Path, default=ROOT / "build",
                            help="build folder that holds bin/cf-run (default: %(default)s)")
        parser.add_argument("-o", "--out", type=pathlib.Path, default=ROOT / "build" / "experiments" / name,
                            help="results, kept and continued (default: %(default)s)")
        parser.add_argument("--images", type=pathlib.Path, default=ROOT / "docs" / "images",
                            help="where the pictures go (default: %(default)s)")
        parser.add_argument("--seeds", type=int, default=5, help="(default: %(default)s)")
        if extra:
            extra(parser)
        self.options = parser.parse_args()
        self.out = self.options.out.resolve()
        self.images = self.options.images.resolve()
        self.seeds = range(1, self.options.seeds + 1)
        for folder in (self.out, self.images):
            folder.mkdir(parents=True, exist_ok=True)
        if not shutil.which("gnuplot"):
            sys.exit("gnuplot is missing: apt-get install gnuplot-nox")

    def call(self, program, *arguments):
        """Runs one program; returns its standard output. Ends with its last words if it fails."""
        path = self.options.build.resolve() / "bin" / program
        if not path.exists():
            sys.exit(f"{path} is missing: build it (ninja {program}) or give --build")
        done = subprocess.run([path, *map(str, arguments)], capture_output=True, text=True)
        if done.returncode:
            words = " ".join([program, *map(str, arguments)])
            sys.exit(f"{words}\nended with {done.returncode}: " + done.stderr.strip()[-2000:])
        return done.stdout

    def simulate(self, folder, **sections):
        """cf-simulate of the ini that the sections make, into folder / flight."""
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        ini = folder / "simulation.ini"
        ini.write_text("".join(
            f"[{name}]\n" + "".join(f"{key} = {value}\n" for key, value in keys.items())
            for name, keys in sections.items()))
        self.call("cf-simulate", ini, "-o", folder / "flight")
        return folder / "flight"

    def run(self, config, outdir, **overrides):
        """cf-run; section__key=value overrides. Returns report.json."""
        arguments = [config, "-o", outdir, "-w", "-s", "view.snapshots=false"]
        for name, value in overrides.items():
            arguments += ["-s", f"{name.replace('__', '.')}={value}"]
        self.call("cf-run", *arguments)
        return json.loads((outdir / "report.json").read_text())

    def evaluate(self, *arguments):
        return json.loads(self.call("cf-eval", *arguments))

    def kept(self, name, make):
        """The result of that name, made now or by an earlier call of the same experiment."""
        file = self.out / f"{name}.json"
        if not file.exists():
            print(f"{name} …", file=sys.stderr, flush=True)
            result = make(self.out / name)
            file.write_text(json.dumps(result, indent=1))
            shutil.rmtree(self.out / name, ignore_errors=True)
        return json.loads(file.read_text())

    def plot(self, name, commands, size="1000,420", **tables):
        """A picture by gnuplot; `$table` in the commands names a table of rows."""
        blocks = "".join(
            f"${key} << EOD\n" + "".join(" ".join(map(str, row)) + "\n" for row in rows) + "EOD\n"
            for key, rows in tables.items())
        picture = self.images / f"{name}.png"
        script = (f"set terminal pngcairo size {size} font 'DejaVu Sans,10'\n"
                  f"set output '{picture}'\nset grid lc rgb '#dddddd'\n"
                  "set style fill transparent solid 0.25 noborder\n" + blocks + commands)
        (self.out / f"{name}.gp").write_text(script)
        subprocess.run(["gnuplot", self.out / f"{name}.gp"], check=True)
        print(f"{picture}", file=sys.stderr)


def read_tum(file):
    """Rows (t as its text, (x, y, z)) of a trajectory."""
    rows = [line.split() for line in file.read_text().splitlines()
            if line.strip() and not line.startswith("#")]
    return [(row[0], tuple(map(float, row[1:4]))) for row in rows]


def read_csv(file):
    """Rows of a comma-separated file as dictionaries."""
    lines = file.read_text().splitlines()
    header = lines[0].split(",")
    return [dict(zip(header, line.split(","))) for line in lines[1:] if line]


def spread(values):
    """(median, lowest, highest)"""
    values = list(values)
    return statistics.median(values), min(values), max(values)


def spread_text(values, form="{:.2f}"):
    """Median (lowest – highest), or the only value."""
    values = list(values)
    if len(values) == 1:
        return form.format(values[0])
    return "{} ({} – {})".format(*(form.format(v) for v in spread(values)))


def table(header, rows):
    """Prints a Markdown table."""
    print("| " + " | ".join(header) + " |\n|" + "---|" * len(header))
    for row in rows:
        print("| " + " | ".join(map(str, row)) + " |")
    print()
