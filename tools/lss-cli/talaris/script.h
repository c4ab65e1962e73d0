#pragma once

// Scripts of TALARIS: a list of timed actuations in a file, one per line.
//
//   # two pulses, then the fans
//   0s      valves 1,3  for 100ms
//   500ms   valves 5,7  for 100ms
//   2s      fans all    throttle 0.3
//   6s      fans 1,2    rpm 12000
//   10s     fans all    throttle 0
//
// Times count from the first actuation, which comes 5 s after the script was started (TALARIS
// thesis A.3.2); a line never goes back in time. The daemon decides which actuations may be
// combined. Pure functions. Errors are a Failure with the line.

#include <string>
#include <string_view>
#include <vector>

#include "idl/talaris/commands.h"

namespace lss::cli::talaris {

struct ScriptStep {
  int line = 0;  // of the file, from 1
  double at_s = 0;
  lss::talaris::StepKind kind{};
  double which = 0;  // bit i: valve or fan i + 1
  double value = 0;  // s open, share of full throttle, or rpm
};

// At least one step; `name` names the text in errors.
std::vector<ScriptStep> parse_script(std::string_view text, const std::string& name);

// From its start, with the lead, to the end of its last actuation.
double duration_s(const std::vector<ScriptStep>& script);

}  // namespace lss::cli::talaris
