// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "cf/align/segment_joining.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "cf/base/median.h"
#include "cf/geometry/pnp.h"
#include "cf/geometry/similarity.h"

namespace cf {
namespace {

constexpr int kMinSharedPoints = 12;
constexpr double kAgreeingDepths = 0.03;  ///< distance of shared points, of the median depth
constexpr int kMinPairInliers = 8;
constexpr int kCells = 5;              ///< by which an overlap is divided, each way
constexpr double kMinCover = 0.25;     ///< part of an overlap's cells in which photos must agree
constexpr double kRelativeDepth = 50;  ///< median depth of a map without any georeference

/// A segment in its own frame: the georeferenced world, or its local frame.
struct Piece {
  const GeoSegment* segment = nullptr;
  std::map<FrameId, Eigen::Isometry3d> poses;
  double scale = 1;         ///< piece frame units per VO unit
  double median_depth = 0;  ///< piece frame units; 0 = nothing triangulated
};

Piece pieceOf(const GeoSegment& segment, const MatchGraph& graph) {
  Piece piece;
  piece.segment = &segment;
  piece.scale = segment.georeferenced ? segment.scale : 1;
  std::vector<double> depths;
  for (const auto& pose : segment.poses) {
    if (graph.photos().count(pose.frame) == 0) continue;
    piece.poses[pose.frame] = pose.T_world_cam;
    for (const float inverse : graph.photo(pose.frame).inverse_depth)
      if (inverse > 0) depths.push_back(piece.scale / static_cast<double>(inverse));
  }
  piece.median_depth = upperMedian(std::move(depths));
  return piece;
}

/// A feature's point in the frame of a pose; none where it has no depth.
std::optional<Eigen::Vector3d> pointOf(const Keyframe& photo, int feature,
                                       const Eigen::Isometry3d& T_frame_cam, double scale) {
  const auto f = static_cast<std::size_t>(feature);
  if (photo.inverse_depth[f] <= 0) return std::nullopt;
  const Eigen::Vector3d ray =
      photo.camera.undistort(photo.features->pixel[f].cast<double>()).homogeneous();
  return T_frame_cam * Eigen::Vector3d(ray * (scale / static_cast<double>(photo.inverse_depth[f])));
}

struct Joint {
  int a = 0, b = 0;
  int inliers = 0;
  Sim3 S_a_b;
};

/// What two pieces both see: points in the frame of each, and the photos of each.
struct Shared {
  struct View {
    FrameId photo_a, photo_b;
    int feature_a = 0;
  };
  std::vector<Eigen::Vector3d> a, b;
  std::vector<View> views;
};

std::map<std::pair<int, int>, Shared> sharedPoints(const std::vector<Piece>& pieces,
                                                   const MatchGraph& graph) {
  std::map<FrameId, int> piece_of;
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (const auto& [id, T] : pieces[i].poses) piece_of[id] = static_cast<int>(i);
  std::map<std::pair<int, int>, Shared> shared;
  for (const auto& [pair, matches] : graph.pairs()) {
    const auto first = piece_of.find(pair.first), second = piece_of.find(pair.second);
    if (first == piece_of.end() || second == piece_of.end() || first->second == second->second)
      continue;
    const bool ordered = first->second < second->second;
    const auto& [photo_a, a] = ordered ? *first : *second;
    const auto& [photo_b, b] = ordered ? *second : *first;
    const Piece& A = pieces[static_cast<std::size_t>(a)];
    const Piece& B = pieces[static_cast<std::size_t>(b)];
    Shared& points = shared[{a, b}];
    for (const FeatureMatch& m : matches) {
      const int feature_a = ordered ? m.a : m.b, feature_b = ordered ? m.b : m.a;
      const auto in_a = pointOf(graph.photo(photo_a), feature_a, A.poses.at(photo_a), A.scale);
      const auto in_b = pointOf(graph.photo(photo_b), feature_b, B.poses.at(photo_b), B.scale);
      if (!in_a || !in_b) continue;
      points.a.push_back(*in_a);
      points.b.push_back(*in_b);
      points.views.push_back({photo_a, photo_b, feature_a});
    }
  }
  return shared;
}

/// What a joint predicts of a pair of photos, and what the pair's matches say to it.
struct Evidence {
  int inliers = 0, matches = 0;
  int seen = 0;     ///< cells of the overlap with landmarks of photo a, kCells² at most
  int covered = 0;  ///< of them, those with an inlier

  bool agrees() const {
    return inliers >= kMinPairInliers && 2 * inliers >= matches && covered >= kMinCover * seen;
  }
};

/// Cells are of the part of photo a that photo b sees if the joint is true: the box around the
/// landmarks of a that project into b.
void coverOf(const Keyframe& a, const Eigen::Isometry3d& T_a, double scale_a, const Keyframe& b,
             const Eigen::Isometry3d& T_b, const Sim3& S_b_a, const std::set<int>& inliers,
             Evidence& evidence) {
  std::vector<int> visible;
  Eigen::AlignedBox2f box;
  const Eigen::Isometry3d T_b_inverse = T_b.inverse();
  for (int f = 0; f < static_cast<int>(a.features->size()); ++f) {
    const auto p = pointOf(a, f, T_a, scale_a);
    if (!p) continue;
    const Eigen::Vector3d seen = T_b_inverse * (S_b_a * *p);
    if (seen.z() <= 0 || !b.camera.contains(b.camera.project(seen))) continue;
    visible.push_back(f);
    box.extend(a.features->pixel[static_cast<std::size_t>(f)]);
  }
  std::set<std::pair<int, int>> seen, covered;
  for (const int f : visible) {
    const Eigen::Array2f at = (a.features->pixel[static_cast<std::size_t>(f)] - box.min()).array() /
                              box.sizes().array().max(1.0f);
    const Eigen::Array2i cell = (at * kCells).cast<int>().min(kCells - 1);
    seen.emplace(cell.x(), cell.y());
    if (inliers.count(f) > 0) covered.emplace(cell.x(), cell.y());
  }
  evidence.seen = static_cast<int>(seen.size());
  evidence.covered = static_cast<int>(covered.size());
}

/// Whether the photo pairs of two pieces bear a joint out. Look-alikes (the same roof, the same
/// car) match as well as the real thing, and over many photos, but they fill a patch of the overlap
/// that they claim, not the overlap.
bool holds(const RobustAlignment& alignment, const Shared& shared, const Piece& A, const Piece& B,
           const MatchGraph& graph) {
  std::map<std::pair<FrameId, FrameId>, std::pair<Evidence, std::set<int>>> pairs;
  for (std::size_t i = 0; i < shared.views.size(); ++i) {
    const Shared::View& view = shared.views[i];
    auto& [evidence, inliers] = pairs[{view.photo_a, view.photo_b}];
    ++evidence.matches;
    if (!alignment.inlier[i]) continue;
    ++evidence.inliers;
    inliers.insert(view.feature_a);
  }
  const Sim3 S_b_a = alignment.S_a_b.inverse();
  int agreeing = 0, seen = 0, covered = 0;
  for (auto& [photos, data] : pairs) {
    auto& [evidence, inliers] = data;
    const auto& [a, b] = photos;
    coverOf(graph.photo(a), A.poses.at(a), A.scale, graph.photo(b), B.poses.at(b), S_b_a, inliers,
            evidence);
    agreeing += evidence.agrees() ? 1 : 0;
    seen += evidence.seen;
    covered += evidence.covered;
  }
  const int needed = A.poses.size() > 2 && B.poses.size() > 2 && pairs.size() > 1 ? 2 : 1;
  return agreeing >= needed && covered >= kMinCover * seen;
}

std::vector<Joint> findJoints(const std::vector<Piece>& pieces, const MatchGraph& graph) {
  std::vector<Joint> joints;
  for (const auto& [key, points] : sharedPoints(pieces, graph)) {
    const Piece& A = pieces[static_cast<std::size_t>(key.first)];
    const Piece& B = pieces[static_cast<std::size_t>(key.second)];
    const auto alignment = alignPointsRobust(points.a, points.b, AlignmentModel::kSim3,
                                             kAgreeingDepths * A.median_depth, kMinSharedPoints, 1);
    if (alignment && holds(*alignment, points, A, B, graph))
      joints.push_back({key.first, key.second, alignment->inliers, alignment->S_a_b});
  }
  return joints;
}

/// A tree of joined pieces: each piece's frame in the frame of the root.
struct Tree {
  int root = 0;
  std::vector<int> pieces;
  std::map<int, Sim3> S_root_piece;
  std::size_t photos = 0, center_photos = 0;
};

std::vector<Tree> growTrees(const std::vector<Piece>& pieces, std::vector<Joint> joints,
                            std::uint16_t center) {
  std::sort(joints.begin(), joints.end(), [](const Joint& x, const Joint& y) {
    return x.inliers != y.inliers ? x.inliers > y.inliers
                                  : std::pair(x.a, x.b) < std::pair(y.a, y.b);
  });
  // The largest pieces become roots first, georeferenced ones before others.
  std::vector<int> order(pieces.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  const auto rank = [&](int i) {
    const Piece& p = pieces[static_cast<std::size_t>(i)];
    return std::pair(p.segment->georeferenced, p.poses.size());
  };
  std::stable_sort(order.begin(), order.end(), [&](int x, int y) { return rank(x) > rank(y); });
  std::set<int> taken;
  std::vector<Tree> trees;
  for (const int root : order) {
    if (taken.count(root) > 0 || pieces[static_cast<std::size_t>(root)].poses.empty()) continue;
    Tree tree;
    tree.root = root;
    tree.S_root_piece[root] = Sim3{};
    taken.insert(root);
    for (bool grown = true; grown;) {
      grown = false;
      // Prim's algorithm: the strongest joint that leads out of the tree.
      for (const Joint& joint : joints) {
        const bool has_a = tree.S_root_piece.count(joint.a) > 0;
        const bool has_b = tree.S_root_piece.count(joint.b) > 0;
        if (has_a == has_b || taken.count(has_a ? joint.b : joint.a) > 0) continue;
        const int next = has_a ? joint.b : joint.a;
        tree.S_root_piece[next] = has_a ? tree.S_root_piece[joint.a] * joint.S_a_b
                                        : tree.S_root_piece[joint.b] * joint.S_a_b.inverse();
        taken.insert(next);
        grown = true;
        break;
      }
    }
    for (const auto& [i, S] : tree.S_root_piece) {
      const Piece& piece = pieces[static_cast<std::size_t>(i)];
      tree.pieces.push_back(i);
      tree.photos += piece.poses.size();
      if (piece.segment->id.uav == center) tree.center_photos += piece.poses.size();
    }
    trees.push_back(std::move(tree));
  }
  std::stable_sort(trees.begin(), trees.end(), [](const Tree& x, const Tree& y) {
    return std::pair(x.center_photos, x.photos) > std::pair(y.center_photos, y.photos);
  });
  return trees;
}

/// The world as the georeferenced pieces of a tree see it together: their camera centres, and a
/// point along each camera axis so that attitudes count where the centres lie on a line.
Result<Sim3> worldOf(const Tree& tree, const std::vector<Piece>& pieces) {
  std::vector<Eigen::Vector3d> world, root;
  std::vector<double> weights;
  for (const int i : tree.pieces) {
    const Piece& piece = pieces[static_cast<std::size_t>(i)];
    if (!piece.segment->georeferenced) continue;
    const Sim3& S = tree.S_root_piece.at(i);
    const double arm = 0.5 * std::max(piece.median_depth, 1e-3);
    for (const auto& pose : piece.segment->poses) {
      if (piece.poses.count(pose.frame) == 0) continue;
      const double sigma2 = std::max(1e-4, pose.covariance.topLeftCorner<3, 3>().trace() / 3);
      const double weight = 1 / (sigma2 + 0.01 * arm * arm);
      for (const Eigen::Vector3d& offset :
           {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(arm, 0, 0), Eigen::Vector3d(0, arm, 0),
            Eigen::Vector3d(0, 0, arm)}) {
        const Eigen::Vector3d p = pose.T_world_cam * offset;
        world.push_back(p);
        root.push_back(S * p);
        weights.push_back(offset.isZero() ? weight : 0.3 * weight);
      }
    }
  }
  return alignPoints(world, root, AlignmentModel::kSim3, weights);
}

/// Without any georeference: a world whose origin is the first camera, in which the cameras look
/// down on average, and whose unit makes the median depth 50.
Sim3 levelled(const Piece& piece) {
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  for (const auto& [id, T] : piece.poses) axis += T.linear().col(2);
  Sim3 S;
  S.scale = piece.median_depth > 0 ? kRelativeDepth / piece.median_depth : 1;
  S.rotation =
      Eigen::Quaterniond::FromTwoVectors(axis, -Eigen::Vector3d::UnitZ()).toRotationMatrix();
  S.translation = -S.scale * (S.rotation * piece.poses.begin()->second.translation());
  return S;
}

/// Poses photos without a segment of their own against the points that their matches see.
void resectLoners(const MatchGraph& graph, const std::vector<Piece>& pieces, Placement& placement) {
  for (bool grown = true; grown;) {
    grown = false;
    for (const Piece& piece : pieces) {
      if (piece.poses.size() != 1) continue;
      const FrameId id = piece.poses.begin()->first;
      if (placement.photos.count(id) > 0) continue;
      const Keyframe& photo = graph.photo(id);
      std::map<int, std::pair<std::vector<Eigen::Vector3d>, std::vector<Eigen::Vector2d>>>
          by_component;
      for (const auto& [pair, matches] : graph.pairs()) {
        if (pair.first != id && pair.second != id) continue;
        const FrameId other = pair.first == id ? pair.second : pair.first;
        const auto placed = placement.photos.find(other);
        if (placed == placement.photos.end()) continue;
        auto& [points, seen] = by_component[placed->second.component];
        for (const FeatureMatch& m : matches) {
          const int own = pair.first == id ? m.a : m.b, theirs = pair.first == id ? m.b : m.a;
          const auto p =
              pointOf(graph.photo(other), theirs, placed->second.T_world_cam, placed->second.scale);
          if (!p) continue;
          points.push_back(*p);
          seen.push_back(photo.camera.undistort(
              photo.features->pixel[static_cast<std::size_t>(own)].cast<double>()));
        }
      }
      for (const auto& [component, data] : by_component) {
        const auto pose =
            resect(data.first, data.second, {2 * graph.threshold(id), kMinSharedPoints});
        if (!pose) continue;
        placement.photos[id] = {pose->T_world_cam, 1, component};
        grown = true;
        break;
      }
    }
  }
}

}  // namespace

Placement joinSegments(const MatchGraph& graph, const std::vector<GeoSegment>& segments,
                       std::uint16_t center) {
  std::vector<Piece> pieces;
  for (const GeoSegment& segment : segments) pieces.push_back(pieceOf(segment, graph));
  const std::vector<Tree> trees = growTrees(pieces, findJoints(pieces, graph), center);

  Placement placement;
  placement.relative = std::none_of(segments.begin(), segments.end(),
                                    [](const GeoSegment& s) { return s.georeferenced; });
  const auto place = [&](const Tree& tree, const Sim3& S_world_root) {
    for (const int i : tree.pieces) {
      const Piece& piece = pieces[static_cast<std::size_t>(i)];
      const Sim3 S = S_world_root * tree.S_root_piece.at(i);
      for (const auto& [id, T] : piece.poses)
        placement.photos[id] = {S.carry(T), S.scale * piece.scale, placement.components};
    }
    ++placement.components;
  };
  for (const Tree& tree : trees) {
    if (tree.photos < 2) continue;
    const auto S_world_root = worldOf(tree, pieces);
    if (S_world_root)
      place(tree, *S_world_root);
    else if (placement.relative && placement.components == 0)
      place(tree, levelled(pieces[static_cast<std::size_t>(tree.root)]));
  }
  resectLoners(graph, pieces, placement);
  for (const Tree& tree : trees) {
    const Piece& piece = pieces[static_cast<std::size_t>(tree.pieces.front())];
    if (tree.photos == 1 && piece.segment->georeferenced &&
        placement.photos.count(piece.poses.begin()->first) == 0)
      place(tree, Sim3{});
  }
  return placement;
}

}  // namespace cf
