#pragma once

// What a verb works with: the options, the output and, opened when first asked for, the vehicle.
// Main thread.

#include <memory>

#include "tools/lss-cli/options.h"
#include "tools/lss-cli/output.h"
#include "tools/lss-cli/session.h"

namespace lss::cli {

class Context {
 public:
  explicit Context(const Options& from) : options(from), output(from) {}

  // Finds the vehicle on first use.
  Session& session() {
    if (!session_) {
      auto link = std::make_unique<Link>(options);
      link->find_vehicle();
      link_ = std::move(link);
      session_ = std::make_unique<Session>(*link_, output, options);
    }
    return *session_;
  }
  bool connected() const { return session_ != nullptr; }

  const Options options;
  Output output;
  bool in_sequence = false;  // of `run` or `shell`: the next command goes on from here

 private:
  std::unique_ptr<Link> link_;
  std::unique_ptr<Session> session_;
};

}  // namespace lss::cli
