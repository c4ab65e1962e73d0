#pragma once

// The findings of lss-cli doctor for people and for programs. Pure functions.

#include <nlohmann/json.hpp>
#include <string>

#include "tools/lss-cli/doctor/finding.h"
#include "tools/lss-cli/show/output.h"

namespace lss::cli::doctor {

const char* result_name(Result result);

struct Layout {
  std::size_t width = 100;  // of a line
  bool explain = false;     // good findings are explained, too
};

// A few lines for each finding, and a summary line.
std::string report_text(const Findings& findings, const Style& style, const Layout& layout);
// {checks: [{name, result, found, meaning, remedy}], problems, warnings}.
nlohmann::json report_json(const Findings& findings);

bool has_problem(const Findings& findings);

}  // namespace lss::cli::doctor
