#pragma once

// Files from others: each is read or refused with a sentence, in bounded time and memory.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <functional>
#include <random>
#include <string>
#include <string_view>

#include "tools/lss-cli/show/failure.h"

namespace lss::cli::recording {

// The sentence of the refusal.
inline std::string why(const std::function<void()>& read) {
  try {
    read();
  } catch (const Failure& e) {
    return e.what();
  }
  return "was read";
}

inline std::string repeated(std::string_view text, std::size_t times) {
  std::string all;
  for (std::size_t i = 0; i < times; ++i) all += text;
  return all;
}

// Random files: `write(i, below)` makes one, with below(n) a random number less than n, and
// `read()` says what came of it.
inline void read_or_refuse(
    int files, unsigned seed,
    const std::function<void(int i, const std::function<std::size_t(std::size_t)>& below)>& write,
    const std::function<std::string()>& read) {
  std::mt19937 random(seed);
  const auto below = [&](std::size_t end) { return random() % end; };
  const auto begin = std::chrono::steady_clock::now();
  int good = 0, refused = 0;
  for (int i = 0; i < files; ++i) {
    write(i, below);
    const std::string said = read();
    said == "was read" ? ++good : ++refused;
    ASSERT_NE(said, "");
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_GT(good, 100);
  EXPECT_GT(refused, 100);
  EXPECT_LT(took.count(), 120) << files << " files of some kB";
#ifndef LSS_SANITIZED
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  EXPECT_LT(usage.ru_maxrss, 400'000) << "kB";
#endif
}

}  // namespace lss::cli::recording
