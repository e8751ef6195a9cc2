// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "delaunay.h"

#include <cstdint>
#include <utility>

namespace cf {
namespace {

/// Edges in groups of four: e and sym(e) = e ^ 2 are an edge in both directions, the odd ones its
/// dual. next(e) is the edge that follows counter-clockwise about the origin of e.
class QuadEdges {
 public:
  explicit QuadEdges(const std::vector<cv::Point>& points) : points_(points) {}

  std::vector<std::array<int, 3>> triangles() {
    const int n = static_cast<int>(points_.size());
    std::vector<std::array<int, 3>> out;
    if (n < 3) return out;
    build(0, n);
    for (int e = 0; e < static_cast<int>(next_.size()); e += 2) {
      if (origin(e) < 0) continue;
      const int f = leftNext(e), g = leftNext(f);
      // Each triangle once, from its least edge; the outer face is no triangle or runs clockwise.
      if (leftNext(g) != e || e > f || e > g) continue;
      if (!counterClockwise(origin(e), origin(f), origin(g))) continue;
      out.push_back({origin(e), origin(f), origin(g)});
    }
    return out;
  }

 private:
  static int rot(int e) { return (e & ~3) | ((e + 1) & 3); }
  static int back(int e) { return (e & ~3) | ((e + 3) & 3); }
  static int sym(int e) { return e ^ 2; }
  static std::size_t at(int e) { return static_cast<std::size_t>(e); }
  int next(int e) const { return next_[at(e)]; }
  int previous(int e) const { return rot(next(rot(e))); }
  int leftNext(int e) const { return rot(next(back(e))); }
  int rightPrevious(int e) const { return next(sym(e)); }
  int origin(int e) const { return origin_[at(e)]; }
  int target(int e) const { return origin(sym(e)); }

  bool counterClockwise(int a, int b, int c) const {
    const cv::Point p = points_[at(a)], q = points_[at(b)], r = points_[at(c)];
    return static_cast<std::int64_t>(q.x - p.x) * (r.y - p.y) -
               static_cast<std::int64_t>(r.x - p.x) * (q.y - p.y) >
           0;
  }
  bool leftOf(int point, int e) const { return counterClockwise(point, origin(e), target(e)); }
  bool rightOf(int point, int e) const { return counterClockwise(point, target(e), origin(e)); }
  /// Is d inside the circle about the counter-clockwise triangle abc?
  bool inCircle(int a, int b, int c, int d) const {
    const cv::Point o = points_[at(d)];
    const auto lifted = [&](int k) {
      const std::int64_t x = points_[at(k)].x - o.x, y = points_[at(k)].y - o.y;
      return std::array<std::int64_t, 3>{x, y, x * x + y * y};
    };
    const auto p = lifted(a), q = lifted(b), r = lifted(c);
    return p[0] * (q[1] * r[2] - q[2] * r[1]) - p[1] * (q[0] * r[2] - q[2] * r[0]) +
               p[2] * (q[0] * r[1] - q[1] * r[0]) >
           0;
  }

  int makeEdge(int from, int to) {
    const int e = static_cast<int>(next_.size());
    next_.insert(next_.end(), {e, e + 3, e + 2, e + 1});
    origin_.insert(origin_.end(), {from, -1, to, -1});
    return e;
  }
  void splice(int a, int b) {
    const int alpha = rot(next(a)), beta = rot(next(b));
    std::swap(next_[at(a)], next_[at(b)]);
    std::swap(next_[at(alpha)], next_[at(beta)]);
  }
  int connect(int a, int b) {
    const int e = makeEdge(target(a), origin(b));
    splice(e, leftNext(a));
    splice(sym(e), b);
    return e;
  }
  void remove(int e) {
    splice(e, previous(e));
    splice(sym(e), previous(sym(e)));
    origin_[at(e)] = origin_[at(sym(e))] = -1;
  }

  /// Triangulates [first, end): the counter-clockwise hull edge out of the leftmost point and the
  /// clockwise one out of the rightmost.
  std::pair<int, int> build(int first, int end) {
    if (end - first == 2) {
      const int e = makeEdge(first, first + 1);
      return {e, sym(e)};
    }
    if (end - first == 3) {
      const int a = makeEdge(first, first + 1), b = makeEdge(first + 1, first + 2);
      splice(sym(a), b);
      if (counterClockwise(first, first + 1, first + 2)) {
        connect(b, a);
        return {a, sym(b)};
      }
      if (counterClockwise(first, first + 2, first + 1)) {
        const int c = connect(b, a);
        return {sym(c), c};
      }
      return {a, sym(b)};
    }
    const int middle = first + (end - first) / 2;
    const std::pair<int, int> left = build(first, middle), right = build(middle, end);
    return merge(left, right);
  }

  std::pair<int, int> merge(std::pair<int, int> left, std::pair<int, int> right) {
    auto [left_outer, left_inner] = left;
    auto [right_inner, right_outer] = right;
    // The lower common tangent.
    while (true) {
      if (leftOf(origin(right_inner), left_inner)) {
        left_inner = leftNext(left_inner);
      } else if (rightOf(origin(left_inner), right_inner)) {
        right_inner = rightPrevious(right_inner);
      } else {
        break;
      }
    }
    int base = connect(sym(right_inner), left_inner);
    if (origin(left_inner) == origin(left_outer)) left_outer = sym(base);
    if (origin(right_inner) == origin(right_outer)) right_outer = base;
    const auto above = [&](int e) { return rightOf(target(e), base); };
    while (true) {
      int from_left = next(sym(base));
      if (above(from_left)) {
        while (inCircle(target(base), origin(base), target(from_left), target(next(from_left)))) {
          const int following = next(from_left);
          remove(from_left);
          from_left = following;
        }
      }
      int from_right = previous(base);
      if (above(from_right)) {
        while (inCircle(target(base), origin(base), target(from_right),
                        target(previous(from_right)))) {
          const int following = previous(from_right);
          remove(from_right);
          from_right = following;
        }
      }
      const bool has_left = above(from_left), has_right = above(from_right);
      if (!has_left && !has_right) return {left_outer, right_outer};
      const bool take_right =
          !has_left || (has_right && inCircle(target(from_left), origin(from_left),
                                              origin(from_right), target(from_right)));
      base = take_right ? connect(from_right, sym(base)) : connect(sym(base), sym(from_left));
    }
  }

  const std::vector<cv::Point>& points_;
  std::vector<int> next_, origin_;
};

}  // namespace

std::vector<std::array<int, 3>> delaunayTriangles(const std::vector<cv::Point>& points) {
  return QuadEdges(points).triangles();
}

}  // namespace cf
