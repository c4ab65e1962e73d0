#pragma once

// The result of one check of lss-cli doctor. Plain data.

#include <cstdint>
#include <string>
#include <vector>

namespace lss::cli::doctor {

enum class Result : std::uint8_t {
  good,
  note,     // information; no action needed
  warning,  // lssd runs with reduced performance: late, or without shared memory
  problem,  // lssd cannot run here in real time, or not as configured
};

struct Finding {
  std::string name;  // stable: programs look for it
  Result result = Result::good;
  std::string found = "";
  std::string meaning = "";
  std::string remedy = "";  // empty: nothing to do
};

using Findings = std::vector<Finding>;

}  // namespace lss::cli::doctor
