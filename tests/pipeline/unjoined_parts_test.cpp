// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "unjoined_parts.h"

#include <gtest/gtest.h>

namespace cf {
namespace {

/// UAV "a" in the map; of "b" 2 photos are, `apart` are placed by GNSS alone and `lost` by nothing.
struct Flight {
  std::vector<UavRecord> uavs;
  PoseTable table;
};

Flight flight(int joined, int apart, int lost) {
  Flight f;
  f.uavs.resize(2);
  f.uavs[0].name = "a";
  f.uavs[1].name = "b";
  const auto add = [&](std::uint16_t u, PhotoStatus status, int component, int segment) {
    std::vector<PhotoRecord>& photos = f.uavs[u].photos;
    PhotoRecord photo;
    photo.name = std::to_string(photos.size()) + ".jpg";
    photo.status = status;
    photo.segment = segment;
    if (status == PhotoStatus::kPosed)
      f.table.poses[{u, static_cast<std::uint32_t>(photos.size())}].component = component;
    photos.push_back(photo);
  };
  for (int i = 0; i < 5; ++i) add(0, PhotoStatus::kPosed, 0, 0);
  for (int i = 0; i < joined; ++i) add(1, PhotoStatus::kPosed, 0, 0);
  for (int i = 0; i < apart; ++i) add(1, PhotoStatus::kPosed, 1, 1);
  for (int i = 0; i < lost; ++i) add(1, PhotoStatus::kUnjoined, -1, 2);
  return f;
}

std::vector<std::string> told(int joined, int apart, int lost) {
  const Flight f = flight(joined, apart, lost);
  return unjoinedParts(f.uavs, f.table);
}

TEST(UnjoinedParts, NothingToSayOfOneMap) { EXPECT_TRUE(told(6, 0, 0).empty()); }

TEST(UnjoinedParts, NamesAUavThatOnlyGnssPlaces) {
  const auto sentences = told(0, 2, 0);
  ASSERT_EQ(sentences.size(), 1u);
  EXPECT_EQ(sentences[0].rfind("b: no match joins its 2 photos (0.jpg to 1.jpg)", 0), 0u)
      << sentences[0];
  EXPECT_NE(sentences[0].find("only GNSS"), std::string::npos);
  EXPECT_NE(sentences[0].find("images/b.csv"), std::string::npos);
}

TEST(UnjoinedParts, NamesPartsOfAUav) {
  const auto sentences = told(3, 4, 5);
  ASSERT_EQ(sentences.size(), 2u);
  EXPECT_NE(sentences[0].find("a part of 5 photos (7.jpg to 11.jpg)"), std::string::npos)
      << sentences[0];
  EXPECT_NE(sentences[0].find("left out"), std::string::npos);
  EXPECT_NE(sentences[1].find("a part of 4 photos (3.jpg to 6.jpg)"), std::string::npos)
      << sentences[1];
}

TEST(UnjoinedParts, AFewPhotosAreNoPart) { EXPECT_TRUE(told(3, 3, 2).empty()); }

}  // namespace
}  // namespace cf
