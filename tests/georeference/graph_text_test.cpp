// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "georeference/flight.h"

namespace cf {
namespace {

std::map<int, Eigen::Vector3d> vertices(const std::string& text) {
  std::map<int, Eigen::Vector3d> out;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    int id = -1;
    Eigen::Vector3d p;
    if (words >> kind >> id >> p.x() >> p.y() >> p.z() && kind == "VERTEX3") out[id] = p;
  }
  return out;
}

/// Every photo's vertex moved by (3, -2, 1) m; nothing else changed.
std::string moved(const std::string& text) {
  std::istringstream lines(text);
  std::ostringstream out;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind, angles;
    int id = -1;
    Eigen::Vector3d p;
    if (words >> kind >> id >> p.x() >> p.y() >> p.z() && kind == "VERTEX3" && id > 0) {
      std::getline(words, angles);
      out << "VERTEX3 " << id << ' ' << p.x() + 3 << ' ' << p.y() - 2 << ' ' << p.z() + 1 << angles
          << '\n';
    } else {
      out << line << '\n';
    }
  }
  return out.str();
}

std::string contents(const std::string& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

int count(const std::string& text, const std::string& word) {
  int n = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++n;
  return n;
}

TEST(GraphText, HoldsEveryPhotoItsIncrementsAndTheWorld) {
  const test::Flight flight = test::fly({}, 1);
  const std::string text = test::run(flight).graphText();
  EXPECT_EQ(count(text, "VERTEX3"), 49);
  EXPECT_EQ(count(text, "EDGE3"), 47 + 48);
  EXPECT_NE(text.find("FIX 0"), std::string::npos);
}

TEST(GraphText, StockGraphSlamReadsAndSolvesIt) {
  if (std::system("command -v graph-slam > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "graph-slam (mrpt-apps) is not installed";
  // Without noise, since that tool ignores the information of the edges.
  test::FlightPlan plan;
  plan.vo_rotation_deg = plan.vo_step = plan.vo_depth = 0;
  plan.sigma_m.setZero();
  const test::Flight flight = test::fly(plan, 1);
  const auto dir = std::filesystem::temp_directory_path() / "cf_graph_text_test";
  std::filesystem::create_directories(dir);
  const std::string in = (dir / "in.graph").string(), out = (dir / "out.graph").string();
  std::ofstream(in) << moved(test::run(flight).graphText());
  const std::string command = "graph-slam --3d --levmarq --no-span --max-iters 20 -i " + in +
                              " -o " + out + " > " + (dir / "log").string() + " 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const auto solved = vertices(contents(out));
  ASSERT_EQ(solved.size(), 49u);
  for (int i = 0; i < 48; ++i)
    EXPECT_LT(
        (solved.at(i + 1) - flight.T_world_cam[static_cast<std::size_t>(i)].translation()).norm(),
        0.1)
        << i;
  std::filesystem::remove_all(dir);
}

}  // namespace
}  // namespace cf
