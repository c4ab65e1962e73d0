#pragma once

// How the command line ends: the exit codes that scripts rely on (docs/cli.md), and the exception
// with an exit code and a message for the user. Thrown anywhere in lss-cli, caught where a verb
// runs.

#include <cstdint>
#include <stdexcept>
#include <string>
#include <utility>

namespace lss::cli {

enum class ExitCode : std::uint8_t {
  completed = 0,
  internal = 1,
  usage = 2,
  unreachable = 3,     // no daemon, or it ended before a request
  unknown_name = 4,    // verb, command or vehicle
  rejected = 5,        // not executed
  failed = 6,          // accepted, then failed; for health: something is wrong
  timed_out = 7,       // outcome unknown
  not_authorised = 8,  // another source has authority
};

class Failure : public std::runtime_error {
 public:
  Failure(ExitCode code, const std::string& text, std::string advice = "")
      : std::runtime_error(text), code_(code), advice_(std::move(advice)) {}

  ExitCode code() const { return code_; }
  const std::string& advice() const { return advice_; }  // the advice; may be empty

 private:
  ExitCode code_;
  std::string advice_;
};

// Of a verb with forms of its own, when `typed` is none of them.
inline Failure no_form(std::string typed, const std::string& forms) {
  typed.erase(typed.find_last_not_of(' ') + 1);
  return Failure(ExitCode::usage, "cannot understand: " + typed, "write: " + forms);
}

// Ctrl-C, SIGTERM or the end of the terminal during a wait.
class Interrupted : public std::exception {
 public:
  const char* what() const noexcept override { return "interrupted"; }
};

}  // namespace lss::cli
