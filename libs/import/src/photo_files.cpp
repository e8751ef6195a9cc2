// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
#include "photo_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <system_error>

#include "cf/base/error.h"

namespace cf {
namespace {

namespace fs = std::filesystem;

bool isDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// Numbers in names compare by value, everything else by character.
bool naturalLess(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!isDigit(a[i]) || !isDigit(b[j])) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
      continue;
    }
    while (i < a.size() && a[i] == '0') ++i;
    while (j < b.size() && b[j] == '0') ++j;
    std::size_t i_end = i, j_end = j;
    while (i_end < a.size() && isDigit(a[i_end])) ++i_end;
    while (j_end < b.size() && isDigit(b[j_end])) ++j_end;
    if (i_end - i != j_end - j) return i_end - i < j_end - j;
    const int order = a.compare(i, i_end - i, b, j, j_end - j);
    if (order != 0) return order < 0;
    i = i_end, j = j_end;
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;
}

std::string lowerCase(const std::string& text) {
  std::string out = text;
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

bool isPhoto(const fs::path& file) {
  static const std::set<std::string> kExtensions = {".jpg", ".jpeg", ".tif", ".tiff", ".png"};
  return kExtensions.count(lowerCase(file.extension().string())) != 0;
}

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// The last `depth` + 1 components of a path, joined by '_'.
std::string nameWithParents(const fs::path& path, std::size_t depth) {
  std::string name = path.filename().string();
  fs::path parent = path.parent_path();
  for (; depth > 0 && parent.has_filename(); --depth, parent = parent.parent_path())
    name = parent.filename().string() + "_" + name;
  return name;
}

using Spelling = std::string (*)(const std::string&);

/// Names made of as few parent folders as tell the paths apart; numbered where that cannot be.
/// Names are spelt by `spell`, and differ by more than what `key` drops.
std::vector<std::string> tellApart(const std::vector<fs::path>& paths, Spelling spell,
                                   Spelling key) {
  std::vector<std::string> names(paths.size());
  std::vector<std::size_t> undecided(paths.size());
  for (std::size_t i = 0; i < paths.size(); ++i) undecided[i] = i;
  std::set<std::string> taken;
  constexpr std::size_t kDeepest = 8;
  for (std::size_t depth = 0; depth <= kDeepest && !undecided.empty(); ++depth) {
    std::map<std::string, std::vector<std::size_t>> by_name;
    for (const std::size_t i : undecided) {
      names[i] = spell(nameWithParents(paths[i], depth));
      by_name[key(names[i])].push_back(i);
    }
    undecided.clear();
    for (const auto& [name, owners] : by_name) {
      if (owners.size() == 1 && taken.insert(name).second) continue;
      undecided.insert(undecided.end(), owners.begin(), owners.end());
    }
  }
  std::sort(undecided.begin(), undecided.end());
  for (const std::size_t i : undecided) {
    int number = 2;
    do names[i] = fmt::format("{}_{}", number++, spell(paths[i].filename().string()));
    while (!taken.insert(key(names[i])).second);
  }
  return names;
}

std::string asIs(const std::string& name) { return name; }

std::string asSectionName(const std::string& name) {
  std::string out = name;
  for (char& c : out) {
    const auto u = static_cast<unsigned char>(c);
    if (!std::isalnum(u) && c != '_' && c != '-') c = '_';
  }
  return out.empty() ? "uav" : out;
}

}  // namespace

PhotoFiles listPhotos(const fs::path& folder, const fs::path& out_dir) {
  std::error_code failed;
  if (!fs::is_directory(folder, failed))
    throw UsageError(fmt::format("{} is no folder of photos: is it there?", folder.string()));
  const fs::path root = fs::canonical(folder);
  const fs::path out = fs::weakly_canonical(fs::absolute(out_dir));
  PhotoFiles found;
  fs::recursive_directory_iterator it(root, fs::directory_options::skip_permission_denied), end;
  for (; it != end; it.increment(failed)) {
    if (failed)
      throw RunError(fmt::format("{} cannot be read: {}", folder.string(), failed.message()));
    const fs::path& path = it->path();
    const std::string name = path.filename().string();
    if (it->is_directory(failed)) {
      const bool earlier_import = path.parent_path() == out && endsWith(name, "_Images");
      if (name[0] == '.' || path == out || earlier_import) it.disable_recursion_pending();
      continue;
    }
    if (name[0] == '.') continue;
    if (isPhoto(path) && it->is_regular_file(failed))
      found.photos.push_back(path);
    else
      ++found.others;
  }
  sortNaturally(found.photos);
  return found;
}

void sortNaturally(std::vector<fs::path>& files) {
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return naturalLess(a.string(), b.string());
  });
}

PhotoFiles findPhotos(const fs::path& folder, const fs::path& out_dir) {
  PhotoFiles found = listPhotos(folder, out_dir);
  if (found.photos.empty())
    throw UsageError(fmt::format("{} holds no photo (jpg, jpeg, tif, tiff, png)", folder.string()));
  return found;
}

std::vector<std::string> uniqueNames(const std::vector<fs::path>& photos) {
  return tellApart(photos, asIs, asIs);
}

std::vector<std::string> uavNames(const std::vector<fs::path>& folders) {
  std::vector<fs::path> absolute;
  for (const fs::path& folder : folders) absolute.push_back(fs::weakly_canonical(folder));
  return tellApart(absolute, asSectionName, lowerCase);
}

void linkOrCopy(const fs::path& source, const fs::path& target) {
  std::error_code failed;
  fs::remove(target, failed);
  const fs::path real = fs::canonical(source, failed);
  if (!failed) fs::create_hard_link(real, target, failed);
  if (!failed) return;
  fs::copy_file(source, target, failed);
  if (failed)
    throw RunError(fmt::format("{} cannot be copied to {}: {}", source.string(), target.string(),
                               failed.message()));
}

}  // namespace cf
