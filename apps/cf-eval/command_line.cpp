// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "command_line.h"

#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cf/base/error.h"
#include "cf/evaluate/change.h"
#include "cf/evaluate/cloud.h"
#include "cf/evaluate/ground_control.h"
#include "cf/evaluate/run.h"
#include "cf/evaluate/trajectory.h"
#include "parse_arguments.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::string estimate, reference;
  std::string align;
  std::optional<double> gsd_m;
  bool table = false;
  std::vector<int> size;
};

void requireExisting(const Arguments& arguments) {
  for (const std::string& path : {arguments.estimate, arguments.reference})
    if (!fs::exists(path)) throw UsageError(path + ": there is no such file or folder");
}

std::optional<AlignmentModel> alignmentNamed(const std::string& name) {
  static const std::map<std::string, std::optional<AlignmentModel>> kModels = {
      {"none", std::nullopt},
      {"se3", AlignmentModel::kSe3},
      {"sim3", AlignmentModel::kSim3},
      {"yaw4", AlignmentModel::kYaw4}};
  return kModels.at(name);
}

std::string evaluateTrajectories(const Arguments& arguments) {
  requireExisting(arguments);
  const bool folder = fs::is_directory(arguments.estimate);
  if (folder != fs::is_directory(arguments.reference))
    throw UsageError("trajectory: give two folders, OUTDIR REFDIR, or two files, EST.tum REF.tum");
  const PosePairs pairs = folder ? pairByName(arguments.estimate, arguments.reference)
                                 : pairByTime(arguments.estimate, arguments.reference);
  return toJson(evaluateTrajectory(pairs, alignmentNamed(arguments.align)), arguments.align);
}

std::string evaluateClouds(const Arguments& arguments) {
  requireExisting(arguments);
  CloudPair clouds = readClouds(arguments.estimate, arguments.reference);
  return toJson(evaluateCloud(std::move(clouds), arguments.align == "icp"), arguments.gsd_m);
}

std::string evaluateWholeRun(const Arguments& arguments) {
  requireExisting(arguments);
  const std::string json = evaluateRun(arguments.estimate, arguments.reference);
  return arguments.table ? runTable(json) : json;
}

std::string evaluateGroundPoints(const Arguments& arguments) {
  requireExisting(arguments);
  GroundControlOptions options;
  options.align = alignmentNamed(arguments.align);
  if (!arguments.size.empty()) options.size = PhotoSize{arguments.size[0], arguments.size[1]};
  return evaluateGroundControl(arguments.estimate, arguments.reference, options);
}

std::string evaluateChanges(const Arguments& arguments, ChangeOptions options) {
  requireExisting(arguments);
  if (options.outdir.empty()) options.outdir = fs::path(arguments.reference) / "change";
  return evaluateChange(arguments.estimate, arguments.reference, options);
}

}  // namespace

int runEval(int argc, char** argv) {
  CLI::App app("Figures of merit of a run against a reference, as JSON on stdout", "cf-eval");
  app.set_version_flag("--version", CF_VERSION);
  app.require_subcommand(1);

  Arguments trajectory{{}, {}, "se3", {}, false, {}};
  auto* trajectory_app = app.add_subcommand(
      "trajectory", "Compare camera poses, joined by photo name (folders) or time (files)");
  trajectory_app->add_option("EST", trajectory.estimate, "output folder of a run, or a TUM file")
      ->required();
  trajectory_app
      ->add_option("REF", trajectory.reference,
                   "reference folder with images.tsv and poses.tum, or a TUM file")
      ->required();
  trajectory_app->add_option("--align", trajectory.align, "se3 by default")
      ->check(CLI::IsMember({"none", "se3", "sim3", "yaw4"}));

  Arguments cloud{{}, {}, "none", {}, false, {}};
  auto* cloud_app = app.add_subcommand(
      "cloud", "Compare point clouds where the reference has a point within 0.5 m horizontally");
  cloud_app->add_option("EST", cloud.estimate, "output folder of a run, or a PLY file")->required();
  cloud_app->add_option("REF", cloud.reference, "reference folder with cloud.ply, or a PLY file")
      ->required();
  cloud_app->add_option("--align", cloud.align, "none by default")
      ->check(CLI::IsMember({"none", "icp"}));
  cloud_app
      ->add_option("--gsd", cloud.gsd_m, "ground size of a pixel [m]: also report in units of it")
      ->check(CLI::PositiveNumber);

  Arguments run;
  auto* run_app = app.add_subcommand("run", "All figures of a run on a simulated flight");
  run_app->add_option("OUTDIR", run.estimate, "output folder of the run")->required();
  run_app->add_option("TRUTHDIR", run.reference, "folder truth of cf-simulate")->required();
  run_app->add_flag("--table", run.table, "print a table for people instead of JSON");

  Arguments gcp{{}, {}, "none", {}, false, {}};
  auto* gcp_app = app.add_subcommand(
      "gcp",
      "Ground points triangulated from their marks in photos, against each other and a survey");
  gcp_app->add_option("OUTDIR", gcp.estimate, "output folder of the run")->required();
  gcp_app
      ->add_option("GCP_LIST", gcp.reference,
                   "gcp_list.txt: the CRS, then lines x y z px py image [name]")
      ->required();
  gcp_app->add_option("--align", gcp.align, "of the points onto the surveyed ones; none by default")
      ->check(CLI::IsMember({"none", "se3", "sim3", "yaw4"}));
  gcp_app
      ->add_option("--size", gcp.size,
                   "WxH of the photos that the list was made with, where not the run's")
      ->delimiter('x')
      ->expected(2)
      ->check(CLI::PositiveNumber);

  Arguments change;
  ChangeOptions change_options;
  auto* change_app = app.add_subcommand(
      "change", "What has changed between two runs of one place: heights of B minus those of A");
  change_app->add_option("OUT_A", change.estimate, "output folder of the earlier run")->required();
  change_app->add_option("OUT_B", change.reference, "output folder of the later run")->required();
  change_app->add_option("-o", change_options.outdir,
                         "folder for difference.tif, sigma.tif, significance.tif, change.png and "
                         "change.json; OUT_B/change by default");
  change_app
      ->add_option("--cell", change_options.cell_m,
                   "side of the rasters' cells [m]; by default that of the finer surface model")
      ->check(CLI::PositiveNumber);
  change_app
      ->add_option("--min-area", change_options.min_area_m2,
                   "least area of a change that is listed [m2]; 1 by default")
      ->check(CLI::NonNegativeNumber);
  change_app
      ->add_option(
          "--min-views", change_options.min_views,
          "stereo pairs that must have seen a surface in either run; 2 by default, so that "
          "no single bad match counts")
      ->check(CLI::Range(1, 100));

  change_app->footer(
      "Example:\n"
      "  cf-eval change map map_later -o changes\n"
      "Rasters lie in the UTM grid and the heights of OUT_A; beyond a significance of 3 a cell "
      "counts\n"
      "as changed. docs/change.md says how the runs are brought onto each other, and what sigma "
      "is.");

  app.footer(
      "Example:\n"
      "  cf-eval trajectory map reference        reference/images.tsv and poses.tum\n"
      "  cf-eval cloud map reference/cloud.ply --align icp\n"
      "  cf-eval run map town/truth --table      a flight of cf-simulate\n"
      "  cf-eval gcp map gcp_list.txt            surveyed points\n"
      "  cf-eval change map map_later            rasters and a picture of what has changed\n"
      "cf-eval SUBCOMMAND --help says more; docs/evaluation.md explains the figures.");
  if (!parseArguments(app, argc, argv)) return 0;
  const std::string figures = trajectory_app->parsed() ? evaluateTrajectories(trajectory)
                              : cloud_app->parsed()    ? evaluateClouds(cloud)
                              : change_app->parsed()   ? evaluateChanges(change, change_options)
                              : gcp_app->parsed()      ? evaluateGroundPoints(gcp)
                                                       : evaluateWholeRun(run);
  std::printf("%s\n", figures.c_str());
  return 0;
}

}  // namespace cf
