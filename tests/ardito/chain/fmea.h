#pragma once

// The failure modes of the Ardito thesis' part IV, each with the run that shows its treatment:
// docs/fmea.md is made of these rows, and fmea_test.cpp executes each of them on the whole chain.

#include <functional>
#include <span>
#include <string>

namespace lss::ardito {

struct FailureMode {
  const char* name;  // of its test; "": no sensor of the Locomotion Sub-System can see it
  const char* number;
  const char* mode;  // after the name, which may say it all
  const char* seen_by;
  const char* done;
  // Breaks a rover and looks; the first thing that is not as `done` says, "": all is. none: no
  // test.
  std::function<std::string()> run{};
};

struct FailureSection {
  const char* title;
  std::span<const FailureMode> modes;
  const char* text;  // after its table
};

std::span<const FailureSection> failure_sections();

}  // namespace lss::ardito
