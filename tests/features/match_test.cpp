// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/features/match.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>

namespace cf {
namespace {

using Descriptor = std::array<int, FeatureSet::kDescriptorSize>;

FeatureSet setOf(const std::vector<Descriptor>& rows) {
  FeatureSet set;
  for (const Descriptor& row : rows) {
    set.pixel.emplace_back(0.0f, 0.0f);
    set.scale_px.push_back(1);
    set.colour.insert(set.colour.end(), {0, 0, 0});
    for (const int value : row) set.descriptor.push_back(static_cast<std::uint8_t>(value));
  }
  return set;
}

Descriptor randomDescriptor(std::mt19937& random, int largest = 255) {
  Descriptor d;
  for (int& value : d) value = static_cast<int>(random() % static_cast<unsigned>(largest + 1));
  return d;
}

Descriptor disturbed(Descriptor d, double sigma, std::mt19937& random) {
  std::normal_distribution<double> gauss(0, sigma);
  for (int& value : d)
    value = std::min(255, std::max(0, value + static_cast<int>(std::lround(gauss(random)))));
  return d;
}

double distance(const FeatureSet& a, int i, const FeatureSet& b, int j) {
  double sum = 0;
  for (int k = 0; k < FeatureSet::kDescriptorSize; ++k) {
    const double d = static_cast<double>(a.row(static_cast<std::size_t>(i))[k]) -
                     static_cast<double>(b.row(static_cast<std::size_t>(j))[k]);
    sum += d * d;
  }
  return std::sqrt(sum);
}

/// Straight from the definition: nearest of each other, and nearer than `ratio` times the second.
std::vector<std::pair<int, int>> reference(const FeatureSet& a, const FeatureSet& b, double ratio) {
  const int na = static_cast<int>(a.size()), nb = static_cast<int>(b.size());
  std::vector<std::pair<int, int>> matches;
  for (int i = 0; i < na; ++i) {
    int nearest = -1;
    double best = 1e30, second = 1e30;
    for (int j = 0; j < nb; ++j) {
      const double d = distance(a, i, b, j);
      if (d < best) {
        second = best;
        best = d;
        nearest = j;
      } else {
        second = std::min(second, d);
      }
    }
    if (nearest < 0 || best >= ratio * second) continue;
    bool mutual = true;
    for (int other = 0; other < na; ++other)
      mutual = mutual && (other == i || distance(a, other, b, nearest) > best);
    if (mutual) matches.emplace_back(i, nearest);
  }
  return matches;
}

std::vector<std::pair<int, int>> pairsOf(const std::vector<FeatureMatch>& matches) {
  std::vector<std::pair<int, int>> pairs;
  for (const FeatureMatch& m : matches) pairs.emplace_back(m.a, m.b);
  return pairs;
}

TEST(MatchFeatures, EqualsBruteForce) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::vector<Descriptor> a, b;
    for (int i = 0; i < 150; ++i) a.push_back(randomDescriptor(random));
    // A third true partners of all degrees of likeness, a tenth with a double, the rest strangers.
    for (int i = 0; i < 50; ++i) b.push_back(disturbed(a[static_cast<std::size_t>(i)], i, random));
    for (int i = 0; i < 15; ++i) b.push_back(disturbed(b[static_cast<std::size_t>(i)], 5, random));
    while (b.size() < 131) b.push_back(randomDescriptor(random));
    const FeatureSet sa = setOf(a), sb = setOf(b);
    for (const double ratio : {0.6, 0.85, 0.99}) {
      const auto expected = reference(sa, sb, ratio);
      EXPECT_EQ(pairsOf(matchFeatures(sa, sb, {ratio})), expected) << seed << " " << ratio;
      EXPECT_GT(expected.size(), 20u);
      EXPECT_LT(expected.size(), 120u);
    }
  }
}

/// Small values make many equal distances; with the ratio below 1 a tie is no match.
TEST(MatchFeatures, EqualsBruteForceWithTies) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::vector<Descriptor> a, b;
    for (int i = 0; i < 60; ++i) a.push_back(randomDescriptor(random, 1));
    for (int i = 0; i < 60; ++i) b.push_back(randomDescriptor(random, 1));
    for (int i = 0; i < 20; ++i)
      b.push_back(disturbed(a[static_cast<std::size_t>(i)], 0.2, random));
    const FeatureSet sa = setOf(a), sb = setOf(b);
    EXPECT_EQ(pairsOf(matchFeatures(sa, sb, {0.9})), reference(sa, sb, 0.9)) << seed;
  }
}

/// From the definition: brute force among the pairs that the discs allow.
std::vector<std::pair<int, int>> referenceWithin(const FeatureSet& a, const FeatureSet& b,
                                                 const std::vector<SearchDisc>& disc,
                                                 const std::vector<Eigen::Vector2d>& position,
                                                 double ratio) {
  const auto allowed = [&](std::size_t i, std::size_t j) {
    return disc[i].radius >= 0 && (position[j] - disc[i].centre).norm() <= disc[i].radius;
  };
  std::vector<std::pair<int, int>> matches;
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::vector<std::pair<double, std::size_t>> candidates;
    for (std::size_t j = 0; j < b.size(); ++j)
      if (allowed(i, j))
        candidates.emplace_back(distance(a, static_cast<int>(i), b, static_cast<int>(j)), j);
    std::sort(candidates.begin(), candidates.end());
    if (candidates.size() < 2 || candidates[0].first >= ratio * candidates[1].first) continue;
    const std::size_t j = candidates[0].second;
    bool mutual = true;
    for (std::size_t other = 0; other < a.size(); ++other)
      mutual = mutual &&
               (other == i || !allowed(other, j) ||
                distance(a, static_cast<int>(other), b, static_cast<int>(j)) > candidates[0].first);
    if (mutual) matches.emplace_back(i, j);
  }
  return matches;
}

TEST(MatchFeaturesWithin, EqualsBruteForceOverTheAllowedPairs) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> place(-3, 5), size(-0.5, 6);
    std::vector<Descriptor> a, b;
    std::vector<SearchDisc> disc;
    std::vector<Eigen::Vector2d> position;
    for (int i = 0; i < 150; ++i) {
      a.push_back(randomDescriptor(random));
      // Discs beyond the features' area, empty ones and none at all among them.
      disc.push_back({{2 * place(random), place(random)}, size(random)});
    }
    for (int i = 0; i < 90; ++i) b.push_back(disturbed(a[static_cast<std::size_t>(i)], i, random));
    for (int i = 0; i < 20; ++i) b.push_back(disturbed(b[static_cast<std::size_t>(i)], 5, random));
    for (std::size_t j = 0; j < b.size(); ++j) position.emplace_back(place(random), place(random));
    const FeatureSet sa = setOf(a), sb = setOf(b);
    const auto expected = referenceWithin(sa, sb, disc, position, 0.85);
    EXPECT_EQ(pairsOf(matchFeaturesWithin(sa, sb, disc, position, {0.85})), expected) << seed;
    EXPECT_GT(expected.size(), 5u);
  }
}

/// What the ratio test refuses everywhere else, a place decides.
TEST(MatchFeaturesWithin, TellsRepeatedFeaturesApart) {
  std::mt19937 random(7);
  const Descriptor plant = randomDescriptor(random);
  std::vector<Descriptor> row_a, row_b;
  std::vector<SearchDisc> disc;
  std::vector<Eigen::Vector2d> position;
  for (int i = 0; i < 20; ++i) {
    row_a.push_back(disturbed(plant, 6, random));
    row_b.push_back(disturbed(plant, 6, random));
    row_b.push_back(randomDescriptor(random));
    position.emplace_back(10 * i, 0);
    position.emplace_back(10 * i + 1, 0);
    disc.push_back({{10.0 * i, 0}, 4});
  }
  const FeatureSet a = setOf(row_a), b = setOf(row_b);
  EXPECT_LT(matchFeatures(a, b).size(), 3u);
  const auto matches = matchFeaturesWithin(a, b, disc, position);
  ASSERT_EQ(matches.size(), 20u);
  for (const FeatureMatch& m : matches) EXPECT_EQ(m.b, 2 * m.a);
}

TEST(MatchFeaturesWithin, CopesWithFeaturesInOnePlaceAndNone) {
  std::mt19937 random(8);
  const FeatureSet a = setOf({randomDescriptor(random)});
  const FeatureSet b = setOf({randomDescriptor(random), randomDescriptor(random)});
  const std::vector<Eigen::Vector2d> one_place(2, Eigen::Vector2d(3, 4));
  EXPECT_EQ(matchFeaturesWithin(a, b, {{{3, 4}, 0}}, one_place, {0.99}).size(),
            referenceWithin(a, b, {{{3, 4}, 0}}, one_place, 0.99).size());
  EXPECT_TRUE(matchFeaturesWithin(a, b, {{{3, 5}, 0.5}}, one_place).empty());
  EXPECT_TRUE(matchFeaturesWithin({}, b, {}, one_place).empty());
  EXPECT_TRUE(matchFeaturesWithin(a, {}, {{{3, 4}, 1}}, {}).empty());
}

TEST(MatchFeatures, ExtremeDescriptorsDoNotOverflow) {
  Descriptor none, full, half;
  none.fill(0);
  full.fill(255);
  half.fill(128);
  const auto matches = matchFeatures(setOf({none, full}), setOf({full, half, none}));
  EXPECT_EQ(pairsOf(matches), (std::vector<std::pair<int, int>>{{0, 2}, {1, 0}}));
}

TEST(MatchFeatures, RatioRefusesDoubles) {
  std::mt19937 random(1);
  const Descriptor d = randomDescriptor(random), other = randomDescriptor(random);
  const Descriptor near = disturbed(d, 10, random), also = disturbed(d, 10, random);
  EXPECT_EQ(matchFeatures(setOf({d, other}), setOf({near, other})).size(), 2u);
  EXPECT_EQ(pairsOf(matchFeatures(setOf({d, other}), setOf({near, also, other}))),
            (std::vector<std::pair<int, int>>{{1, 2}}));
}

TEST(MatchFeatures, OnlyTheNearerOfTwoGetsTheFeature) {
  std::mt19937 random(2);
  const Descriptor d = randomDescriptor(random), other = randomDescriptor(random);
  const Descriptor near = disturbed(d, 5, random), further = disturbed(d, 15, random);
  EXPECT_EQ(pairsOf(matchFeatures(setOf({further, near}), setOf({d, other}))),
            (std::vector<std::pair<int, int>>{{1, 0}}));
}

TEST(MatchFeatures, WithoutASecondBestThereIsNoMatch) {
  std::mt19937 random(3);
  const Descriptor d = randomDescriptor(random), e = randomDescriptor(random);
  EXPECT_TRUE(matchFeatures({}, {}).empty());
  EXPECT_TRUE(matchFeatures({}, setOf({d, e})).empty());
  EXPECT_TRUE(matchFeatures(setOf({d, e}), {}).empty());
  EXPECT_TRUE(matchFeatures(setOf({d, e}), setOf({d})).empty());
}

}  // namespace
}  // namespace cf
