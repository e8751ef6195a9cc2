// SPDX-FileCopyrightText: 2026 ClusterFusion authors
// SPDX-License-Identifier: BSD-3-Clause
// Runs a fuzz target where there is no libFuzzer: every seed, every input of a corpus, then a
// number of mutations of them, the same each time.
//
//   fuzz_<reader> [--runs N] [--seed S] [--corpus DIR] [--write-seeds DIR] [FILE...]
//
// The input that crashed, threw, took more than 20 seconds or made the process grow beyond 1 GB is
// left in crash-<reader>.
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>

#include "fuzz/fuzz_target.h"

namespace {

namespace fs = std::filesystem;
using Bytes = std::string;

constexpr unsigned kSecondsAtMost = 20;
constexpr long kKilobytesAtMost = 1 << 20;
constexpr std::size_t kBytesAtMost = 1 << 16;
constexpr const char* kCrashFile = "crash-" CF_FUZZ_NAME;

// For the signal handler.
const char* current_data = nullptr;
std::size_t current_size = 0;

void saveCurrent() {
  const int file = open(kCrashFile, O_WRONLY | O_CREAT | O_TRUNC, 0644);
  if (file < 0) return;
  if (write(file, current_data, current_size) < 0) return;
  close(file);
}

extern "C" void onSignal(int signal) {
  saveCurrent();
  constexpr const char* kText =
      CF_FUZZ_NAME ": crashed or hung; input saved: crash-" CF_FUZZ_NAME "\n";
  if (write(STDERR_FILENO, kText, std::strlen(kText)) < 0) _exit(3);
  std::signal(signal, SIG_DFL);
  raise(signal);
}

[[noreturn]] void fail(const std::string& what) {
  saveCurrent();
  std::fprintf(stderr, "%s: %s; input saved: %s\n", CF_FUZZ_NAME, what.c_str(), kCrashFile);
  std::exit(1);
}

void run(const Bytes& input) {
  current_data = input.data();
  current_size = input.size();
  alarm(kSecondsAtMost);
  try {
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  } catch (const std::exception& e) {
    fail(std::string("exception: ") + e.what());
  }
  alarm(0);
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  if (usage.ru_maxrss > kKilobytesAtMost) fail("grew beyond 1 GB");
}

class Mutator {
 public:
  Mutator(std::vector<Bytes> pool, std::uint64_t seed) : pool_(std::move(pool)), random_(seed) {}

  Bytes next() {
    Bytes input = pool_[upTo(pool_.size() - 1)];
    for (std::size_t n = 1 + upTo(5); n > 0; --n) mutate(input);
    if (input.size() > kBytesAtMost) input.resize(kBytesAtMost);
    return input;
  }

 private:
  std::size_t upTo(std::size_t most) { return random_() % (most + 1); }

  /// A place and a length inside the input.
  std::pair<std::size_t, std::size_t> span(const Bytes& input) {
    const std::size_t at = upTo(input.size());
    const std::size_t longest = std::min<std::size_t>(input.size() - at, upTo(3) == 0 ? 4096 : 16);
    return {at, upTo(longest)};
  }

  void mutate(Bytes& input) {
    static const std::array<const char*, 16> kWords = {
        "nan", "inf", "-inf", "1e999", "-1", "0",   "99999999999999999999", "1e-320",
        "\n",  " ",   "\"",   "[",     "=",  "../", "\xEF\xBB\xBF",         "2147483648"};
    static const std::array<std::uint64_t, 10> kNumbers = {
        0, 1, 0x7F, 0x80, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF, 0x7FF8000000000000, ~0ull};
    const auto [at, length] = span(input);
    switch (upTo(8)) {
      case 0:
        if (at < input.size()) input[at] = static_cast<char>(input[at] ^ (1 << upTo(7)));
        break;
      case 1:
        if (at < input.size()) input[at] = static_cast<char>(upTo(255));
        break;
      case 2:
        input.erase(at, length);
        break;
      case 3:
        input.insert(upTo(input.size()), input.substr(at, length));
        break;
      case 4:
        input.insert(at, kWords[upTo(kWords.size() - 1)]);
        break;
      case 5: {
        const std::uint64_t number = kNumbers[upTo(kNumbers.size() - 1)];
        const std::size_t bytes = std::min(std::size_t{1} << upTo(3), input.size() - at);
        if (bytes > 0) std::memcpy(&input[at], &number, bytes);
        break;
      }
      case 6:
        if (upTo(4) == 0) input.resize(at);
        break;
      case 7: {
        const Bytes& other = pool_[upTo(pool_.size() - 1)];
        const auto [from, count] = span(other);
        input.insert(at, other.substr(from, count));
        break;
      }
      case 8:
        for (std::size_t i = at; i < at + length; ++i) input[i] = static_cast<char>(upTo(255));
        break;
    }
  }

  std::vector<Bytes> pool_;
  std::mt19937_64 random_;
};

Bytes fileBytes(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void writeSeeds(const fs::path& folder) {
  fs::create_directories(folder);
  int number = 0;
  for (const Bytes& seed : cf::fuzz::seeds())
    std::ofstream(folder / ("seed" + std::to_string(number++)), std::ios::binary) << seed;
}

}  // namespace

int main(int argc, char** argv) {
  unsigned long runs = 0;
  std::uint64_t seed = 1;
  std::vector<fs::path> files;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool has_value = i + 1 < argc;
    if (word == "--runs" && has_value) {
      runs = std::strtoul(argv[++i], nullptr, 10);
    } else if (word == "--seed" && has_value) {
      seed = std::strtoull(argv[++i], nullptr, 10);
    } else if (word == "--corpus" && has_value) {
      const fs::path folder = argv[++i];
      if (fs::exists(folder))
        for (const auto& item : fs::directory_iterator(folder)) files.push_back(item.path());
    } else if (word == "--write-seeds" && has_value) {
      writeSeeds(argv[++i]);
      return 0;
    } else {
      files.push_back(word);
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<Bytes> pool = cf::fuzz::seeds();
  for (const fs::path& file : files) pool.push_back(fileBytes(file));
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGALRM})
    std::signal(signal, onSignal);
  for (const Bytes& input : pool) run(input);
  Mutator mutator(pool, seed);
  for (unsigned long i = 0; i < runs; ++i) run(mutator.next());
  std::printf("%s: %zu inputs as they are, %lu mutations, seed %llu: done\n", CF_FUZZ_NAME,
              pool.size(), runs, static_cast<unsigned long long>(seed));
  return 0;
}
