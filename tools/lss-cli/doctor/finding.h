#pragma once

// What one check of lss-cli doctor found. Plain data.

#include <cstdint>
#include <string>
#include <vector>

namespace lss::cli::doctor {

enum class Result : std::uint8_t {
  good,
  note,     // good to know; nothing has to be done
  warning,  // lssd runs, but less well than it could: late, or without shared memory
  problem,  // lssd cannot run here in real time, or not as configured
};

struct Finding {
  std::string name;  // programs rely on it: docs/cli.md
  Result result = Result::good;
  std::string found = "";
  std::string meaning = "";
  std::string mend = "";  // empty: nothing to do
};

using Findings = std::vector<Finding>;

}  // namespace lss::cli::doctor
