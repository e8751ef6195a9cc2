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

std::map<int, Eigen::Vector3d> vertices(std::istream& in) {
  std::map<int, Eigen::Vector3d> out;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string kind;
    int id = -1;
    Eigen::Vector3d p;
    if (words >> kind >> id >> p.x() >> p.y() >> p.z() && kind == "VERTEX3") out[id] = p;
  }
  return out;
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
  const test::Flight flight = test::fly({}, 1);
  const auto dir = std::filesystem::temp_directory_path() / "cf_graph_text_test";
  std::filesystem::create_directories(dir);
  const std::string in = (dir / "in.graph").string(), out = (dir / "out.graph").string();
  std::ofstream(in) << test::run(flight).graphText();
  const std::string command = "graph-slam --3d --levmarq --no-span --max-iters 20 -i " + in +
                              " -o " + out + " > " + (dir / "log").string() + " 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0);
  std::ifstream before_file(in), after_file(out);
  const auto before = vertices(before_file), after = vertices(after_file);
  ASSERT_EQ(before.size(), 49u);
  ASSERT_EQ(after.size(), 49u);
  // Our estimate is its estimate but for what the format cannot say (scale, robust losses).
  for (const auto& [id, p] : before) EXPECT_LT((p - after.at(id)).norm(), 1.0) << id;
  EXPECT_LT((after.at(1) - flight.T_world_cam[0].translation()).norm(), 5);
  std::filesystem::remove_all(dir);
}

}  // namespace
}  // namespace cf
