// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace cf {

/// Why an expected failure happened: a short machine-readable code, counted in the report, and a
/// sentence for people.
struct Failure {
  std::string code;    ///< e.g. "too_few_inliers"
  std::string detail;  ///< e.g. "12 inliers of 240 matches, 30 needed"
};

/// A value or the reason why there is none. Expected failures (few inliers, no fix) travel in it;
/// broken contracts, bad configuration and I/O throw (error.h).
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}
  Result(Failure failure) : state_(std::move(failure)) {}

  bool ok() const { return std::holds_alternative<T>(state_); }
  explicit operator bool() const { return ok(); }
  const T& value() const { return std::get<T>(state_); }
  T& value() { return std::get<T>(state_); }
  const T* operator->() const { return &value(); }
  const T& operator*() const { return value(); }
  const Failure& failure() const { return std::get<Failure>(state_); }

 private:
  std::variant<T, Failure> state_;
};

}  // namespace cf
