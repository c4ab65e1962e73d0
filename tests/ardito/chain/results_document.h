#pragma once

// docs/ardito-results.md, one section at a time: tests that measure write theirs when
// LSS_WRITE_RESULTS is set in the environment.

#include <string>

namespace lss::ardito {

bool writing_results();

// Replaces the section `title` (## in the file), or adds it at the end; `text` ends with a newline.
void write_section(const std::string& title, const std::string& text);

// "measured 2026-01-31 by `LSS_WRITE_RESULTS=1 ardito_results_test --gtest_filter=TEST`"
std::string measured_by(const std::string& test);

}  // namespace lss::ardito
