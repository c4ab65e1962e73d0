#pragma once

// The context of a verb: options, output and the vehicle, which is opened on first use. Main
// thread.

#include <memory>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "tools/lss-cli/session/session.h"
#include "tools/lss-cli/show/options.h"
#include "tools/lss-cli/show/output.h"

namespace lss::cli {

class Context {
 public:
  explicit Context(const Options& from) : options(from), output(from) {}

  // Opened on first use; no vehicle is asked for.
  Link& link() {
    if (!link_) link_ = std::make_unique<Link>(options);
    return *link_;
  }
  // Finds the vehicle on first use.
  Session& session() {
    if (!session_) {
      link().find_vehicle();
      warn();
      session_ = std::make_unique<Session>(*link_, output, options);
    }
    return *session_;
  }
  // Warnings of the link, once. Not before an emergency stop was sent: who reads stderr may be
  // slow.
  void warn() {
    if (!link_ || std::exchange(warned_, true)) return;
    for (const std::string& warning : link_->warnings()) output.note("warning: " + warning);
  }
  bool connected() const { return session_ != nullptr; }
  bool was_interrupted() const { return link_ && link_->was_interrupted(); }
  // The vehicle, when this program was built without it. Contacts its daemon on first use; nullptr
  // when no such daemon answers.
  const Vehicle* described() {
    if (!session_ && !link().may_be_described()) return nullptr;
    return session().link().is_described() ? &session().vehicle() : nullptr;
  }

  // A command that was not sent by the session; the caller owns it.
  void report(nlohmann::json command) {
    others_.emplace_back(session_ ? session_->commands() : 0, std::move(command));
  }
  // Every command so far, in order.
  nlohmann::json report() const {
    nlohmann::json list = session_ ? session_->report() : nlohmann::json::array();
    for (std::size_t i = 0; i < others_.size(); ++i) {
      const auto& [place, command] = others_[i];
      list.insert(list.begin() + static_cast<std::ptrdiff_t>(place + i), command);
    }
    return list;
  }

  Options options;
  Output output;
  bool in_sequence = false;  // of `run` or `shell`: the next command continues from here

 private:
  std::unique_ptr<Link> link_;
  bool warned_ = false;
  std::unique_ptr<Session> session_;
  std::vector<std::pair<std::size_t, nlohmann::json>> others_;
};

}  // namespace lss::cli
